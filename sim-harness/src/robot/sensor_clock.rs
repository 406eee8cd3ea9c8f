//! The independent clocks of the robot's parts.

use amiro_ipf::random::{Generator, uniform_below};

use crate::world::{FRAME_PERIOD_US, UPDATE_PERIOD_US};

/// Keeps a robot's clocks apart from its noise: "clock".
const CLOCK_STREAM: u64 = 0x63_6c6f_636b;

/// When the sensors measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorClocks {
    /// Each at a time of its own, by a clock that is up to 5 % fast or slow.
    Scattered {
        /// Seed of the phases and errors.
        seed: u64,
    },
    /// All at this time of each round, from the second after the power came up on.
    Together {
        /// Nanoseconds after the round's beginning.
        into_round_ns: u64,
    },
}

/// The timing of the parts, each of which has its own clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PartClocks {
    /// The sensors.
    pub sensors: SensorClocks,
    /// First update of the odometry after the power came up, microseconds.
    pub first_update_us: u64,
    /// First frame with it.
    pub first_frame_us: u64,
}

impl PartClocks {
    /// Phases and errors that a seed draws.
    #[must_use]
    pub fn drawn(seed: u64) -> Self {
        let mut generator = Generator::seeded(seed ^ CLOCK_STREAM);
        let mut below = |period_us: u64| {
            let bound = u32::try_from(period_us).unwrap_or(u32::MAX);
            u64::from(uniform_below(&mut generator, bound))
        };
        Self {
            sensors: SensorClocks::Scattered { seed },
            first_update_us: below(UPDATE_PERIOD_US),
            first_frame_us: below(FRAME_PERIOD_US),
        }
    }
}
