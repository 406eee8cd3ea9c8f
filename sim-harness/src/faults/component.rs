//! The components that can have faults.

use std::fmt;

use amiro_ipf::board::acquisition::Bus;
use amiro_ipf::model::SENSORS;

/// A component that can have faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    /// `s0` to `s7`: a sensor, by its index.
    Sensor(usize),
    /// `ring`: all eight sensors.
    Ring,
    /// `bus1`, `bus2`: a bus of four sensors.
    Bus(Bus),
    /// `mux1`, `mux2`: the multiplexer of such a bus.
    Mux(Bus),
    /// `can`: the odometry that comes over the robot's bus.
    Can,
    /// `link`: the serial line to the host.
    Link,
}

impl Component {
    pub(super) fn parse(name: &str) -> Option<Self> {
        let sensor = |place: &str| (0..SENSORS).find(|sensor| sensor.to_string() == place);
        Some(match name {
            "ring" => Self::Ring,
            "bus1" => Self::Bus(Bus::I2c1),
            "bus2" => Self::Bus(Bus::I2c2),
            "mux1" => Self::Mux(Bus::I2c1),
            "mux2" => Self::Mux(Bus::I2c2),
            "can" => Self::Can,
            "link" => Self::Link,
            _ => Self::Sensor(sensor(name.strip_prefix('s')?)?),
        })
    }

    /// The valid words for it, as they are written.
    #[must_use]
    pub const fn words(self) -> &'static [&'static str] {
        match self {
            Self::Sensor(_) | Self::Ring => &[
                "ok",
                "off",
                "stuck",
                "garbage",
                "wrong:COUNTS",
                "slow:RATEHz",
                "delayed:TIME",
                "intermittent:SHARE",
                "saturated",
            ],
            Self::Bus(_) | Self::Mux(_) => &["ok", "off", "stuck", "garbage", "intermittent:SHARE"],
            Self::Can => &[
                "ok",
                "off",
                "stuck",
                "garbage",
                "wrong:LENGTHmm",
                "slow:RATEHz",
                "delayed:TIME",
                "intermittent:SHARE",
            ],
            Self::Link => &[
                "ok",
                "off",
                "ber:R",
                "drop:R",
                "garbage:R",
                "lose:R",
                "twice:R",
                "swap:R",
                "cut:R",
                "delay:TIME",
                "slow:N",
            ],
        }
    }

    /// The component itself, or the sensors of the ring.
    pub(super) fn each(self) -> Vec<Self> {
        match self {
            Self::Ring => (0..SENSORS).map(Self::Sensor).collect(),
            one => vec![one],
        }
    }
}

impl fmt::Display for Component {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = |bus: &Bus| match bus {
            Bus::I2c1 => 1,
            Bus::I2c2 => 2,
        };
        match self {
            Self::Sensor(sensor) => write!(f, "s{sensor}"),
            Self::Ring => f.write_str("ring"),
            Self::Bus(bus) => write!(f, "bus{}", number(bus)),
            Self::Mux(bus) => write!(f, "mux{}", number(bus)),
            Self::Can => f.write_str("can"),
            Self::Link => f.write_str("link"),
        }
    }
}
