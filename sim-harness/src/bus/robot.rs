//! The AMiRo's two buses, populated.

use amiro_ipf::board::acquisition::{AMIRO_CONNECTIONS, Bus};
use amiro_ipf::board::eeprom;
use amiro_ipf::board::i2c::muxed_bus::MUX_ADDRESS;
use amiro_ipf::model::SENSORS;
use amiro_ipf::random::{Generator, uniform_below};

use super::{
    At24c01Model, Device, FakeBus, InjectedBusFault, Pca9544aModel, Vcnl4020Fault, Vcnl4020Model,
};

/// Period of 125 measurements per second.
const PERIOD_NS: u32 = 8_000_000;

/// The fault of a sensor of the ring, 0 to 7, for the script of its bus.
///
/// # Panics
/// For a sensor beyond 7.
#[must_use]
pub const fn on_sensor(sensor: usize, fault: Vcnl4020Fault) -> InjectedBusFault {
    let channel = AMIRO_CONNECTIONS[sensor].channel.number();
    InjectedBusFault::Sensor { channel, fault }
}

/// The parts on one of the buses. The robot's gauges, power and touch sensors are absent:
/// their addresses are not acknowledged.
#[derive(Clone, Debug)]
pub struct RobotParts {
    /// With four sensors behind it.
    pub mux: Pca9544aModel<Vcnl4020Model>,
    /// On the second bus only.
    pub memory: Option<At24c01Model>,
}

impl RobotParts {
    /// The parts of the given bus, 0 or 1.
    fn of(bus: usize) -> Self {
        let sensors = core::array::from_fn(|_| Vcnl4020Model::default());
        Self {
            mux: Pca9544aModel::new(MUX_ADDRESS.bits(), sensors),
            memory: (bus == 1).then(|| At24c01Model::new(eeprom::ADDRESS_AMIRO)),
        }
    }
}

impl Device for RobotParts {
    fn start(&mut self, address: u8, read: bool, now_ns: u64) -> bool {
        let mux = self.mux.start(address, read, now_ns);
        let memory = &mut self.memory;
        mux | memory
            .as_mut()
            .is_some_and(|it| it.start(address, read, now_ns))
    }

    fn write(&mut self, byte: u8, now_ns: u64) -> bool {
        let mux = self.mux.write(byte, now_ns);
        let memory = &mut self.memory;
        mux | memory.as_mut().is_some_and(|it| it.write(byte, now_ns))
    }

    /// A 0 on the line wins.
    fn read(&mut self, now_ns: u64) -> u8 {
        let mux = self.mux.read(now_ns);
        let memory = &mut self.memory;
        mux & memory.as_mut().map_or(0xff, |it| it.read(now_ns))
    }

    fn stop(&mut self, now_ns: u64) {
        self.mux.stop(now_ns);
        if let Some(memory) = &mut self.memory {
            memory.stop(now_ns);
        }
    }

    fn pass(&mut self, now_ns: u64) {
        self.mux.pass(now_ns);
    }

    fn interrupts(&self) -> bool {
        self.mux.interrupts()
    }

    fn inject(&mut self, fault: InjectedBusFault, now_ns: u64) -> bool {
        self.mux.inject(fault, now_ns)
    }
}

/// Both buses of a robot whose power has just come up.
#[derive(Debug)]
pub struct RobotBuses {
    /// I2C1: sensors 0, 1, 2 and 7.
    pub one: FakeBus<RobotParts>,
    /// I2C2: sensors 3 to 6 and the memory.
    pub two: FakeBus<RobotParts>,
}

impl Default for RobotBuses {
    fn default() -> Self {
        Self {
            one: FakeBus::new(RobotParts::of(0)),
            two: FakeBus::new(RobotParts::of(1)),
        }
    }
}

impl RobotBuses {
    /// What a sensor's proximity measurements give from now on, in counts.
    ///
    /// # Panics
    /// For a sensor beyond 7.
    pub fn set_signal(&mut self, sensor: usize, raw: u16) {
        self.sensor_mut(sensor).set_signal(raw);
    }

    /// A sensor of the ring at the current time.
    ///
    /// # Panics
    /// For a sensor beyond 7.
    pub fn sensor_mut(&mut self, sensor: usize) -> &mut Vcnl4020Model {
        let channel = AMIRO_CONNECTIONS[sensor].channel.number();
        self.bus_of_mut(sensor)
            .parts_mut()
            .mux
            .behind_mut(usize::from(channel))
    }

    /// The bus that a sensor of the ring is on.
    ///
    /// # Panics
    /// For a sensor beyond 7.
    pub fn bus_of_mut(&mut self, sensor: usize) -> &mut FakeBus<RobotParts> {
        match AMIRO_CONNECTIONS[sensor].bus {
            Bus::I2c1 => &mut self.one,
            Bus::I2c2 => &mut self.two,
        }
    }

    /// The bus with a number: 1 is the second one, any other the first.
    pub fn bus_mut(&mut self, bus: usize) -> &mut FakeBus<RobotParts> {
        if bus == 1 {
            &mut self.two
        } else {
            &mut self.one
        }
    }

    /// The later of the buses' clocks.
    #[must_use]
    pub fn now_ns(&self) -> u64 {
        self.one.now_ns().max(self.two.now_ns())
    }

    /// Lets time pass on both until the given time, if that is not over.
    pub fn advance_to(&mut self, now_ns: u64) {
        self.one.advance_to(now_ns);
        self.two.advance_to(now_ns);
    }

    /// Gives each sensor a phase of its own, up to 8 ms, and a clock that is up to 5 %
    /// fast or slow.
    pub fn scatter_clocks(&mut self, seed: u64) {
        let mut generator = Generator::seeded(seed);
        for sensor in 0..SENSORS {
            let phase_ns = uniform_below(&mut generator, PERIOD_NS);
            let above_fastest_ppm = uniform_below(&mut generator, 100_001);
            let sensor = self.sensor_mut(sensor);
            sensor.set_phase(u64::from(phase_ns));
            sensor.set_clock_error(above_fastest_ppm.cast_signed() - 50_000);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_hal::i2c::I2c;

    /// Starts the sensor on a channel and reads its result 20 ms later.
    fn read(bus: &mut FakeBus<RobotParts>, channel: u8) -> u16 {
        bus.write(0x77, &[0x04 | channel]).unwrap();
        bus.write(0x13, &[0x82, 0x06]).unwrap();
        bus.write(0x13, &[0x80, 0x03]).unwrap();
        bus.advance(20_000_000);
        let mut halves = [0; 2];
        bus.write_read(0x13, &[0x87], &mut halves).unwrap();
        u16::from_be_bytes(halves)
    }

    #[test]
    fn each_sensor_is_at_its_place_of_the_board_s_tables() {
        let mut buses = RobotBuses::default();
        for sensor in 0..SENSORS {
            buses.set_signal(sensor, 1000 + sensor as u16);
        }
        let wired = [
            [7, 0, 2, 1], // I2C1: SSE, SSW, WNW, WSW
            [3, 4, 6, 5], // I2C2: NNW, NNE, ESE, ENE
        ];
        for (bus, sensors) in wired.into_iter().enumerate() {
            for (channel, sensor) in sensors.into_iter().enumerate() {
                let raw = read(buses.bus_mut(bus), channel as u8);
                assert_eq!(raw, 1000 + sensor, "bus {bus}, channel {channel}");
            }
        }
    }

    #[test]
    fn only_the_second_bus_has_a_memory_and_other_addresses_are_not_acknowledged() {
        let mut buses = RobotBuses::default();
        let there = |bus: &mut FakeBus<RobotParts>| -> Vec<u8> {
            (0..0x80)
                .filter(|address| bus.write(*address, &[]).is_ok())
                .collect()
        };
        assert_eq!(there(&mut buses.one), [0x77]);
        assert_eq!(there(&mut buses.two), [0x50, 0x77]);
        buses.two.write(0x77, &[0x04]).unwrap();
        assert_eq!(there(&mut buses.two), [0x13, 0x50, 0x77]);
    }

    #[test]
    fn time_passes_on_both_buses_and_back_on_none() {
        let mut buses = RobotBuses::default();
        buses.two.advance(7);
        buses.advance_to(5);
        assert_eq!((buses.one.now_ns(), buses.two.now_ns()), (5, 7));
        assert_eq!(buses.now_ns(), 7);
    }

    #[test]
    fn scattered_clocks_measure_more_or_less_often() {
        let mut buses = RobotBuses::default();
        buses.scatter_clocks(1);
        let measured: Vec<u8> = (0..SENSORS)
            .map(|sensor| {
                buses.sensor_mut(sensor).queue_signals(1..=200);
                let channel = AMIRO_CONNECTIONS[sensor].channel.number();
                let bus = buses.bus_of_mut(sensor);
                read(bus, channel);
                bus.advance(1_000_000_000);
                buses.sensor_mut(sensor).register(0x88)
            })
            .collect();
        // In 1.02 s and the bytes' time, by a clock that is 5 % slow and by one that is
        // 5 % fast: the first phase takes up to 8 ms off.
        assert!(
            measured.iter().all(|n| (120..=136).contains(n)),
            "{measured:?}"
        );
        let mut distinct = measured.clone();
        distinct.sort_unstable();
        distinct.dedup();
        assert!(distinct.len() >= 5, "{measured:?}");
    }
}
