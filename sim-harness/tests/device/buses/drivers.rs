//! The crates `vcnl4020` and `pca9544a` at the models of their parts: what their own tests,
//! which expect single transfers, cannot show.

use amiro_ipf::random::{Generator, uniform_below};
use pca9544a::{Address, Channel, Pca9544a};
use sim_harness::bus::{FakeBus, FakeBusError, InjectedBusFault, RobotBuses, Vcnl4020Model};
use vcnl4020::{
    Ambient, Command, Compared, Configuration, Error, InterruptControl, InterruptStatus,
    LedCurrent, ProximityRate, Vcnl4020,
};

use super::WHOLE;

const MS: u64 = 1_000_000;

const FAST: Configuration = Configuration {
    rate: ProximityRate::Hz125,
    led: LedCurrent::MAX,
    ambient: None,
};

/// A sensor of its own that measures this, and its bus.
fn bus(signal: u16) -> FakeBus<Vcnl4020Model> {
    let mut bus = FakeBus::new(Vcnl4020Model::default());
    bus.parts_mut().set_signal(signal);
    bus
}

/// Lets time pass on the sensor's bus.
fn after(sensor: Vcnl4020<FakeBus<Vcnl4020Model>>, ns: u64) -> Vcnl4020<FakeBus<Vcnl4020Model>> {
    let mut bus = sensor.release();
    bus.advance(ns);
    Vcnl4020::new(bus)
}

#[test]
fn a_started_sensor_gives_each_result_once() {
    let mut wire = bus(2_600);
    wire.parts_mut().set_ambient(400);
    let mut sensor = Vcnl4020::new(wire);
    let configuration = Configuration {
        ambient: Some(Ambient::default()),
        ..FAST
    };
    assert_eq!(sensor.start(&configuration), Ok(()));
    let mut sensor = after(sensor, 9 * MS);
    assert_eq!(sensor.proximity(), Ok(2_600));
    assert_eq!(sensor.proximity(), Err(Error::NotReady));
    assert_eq!(sensor.ambient(), Err(Error::NotReady));
    let mut sensor = after(sensor, 100 * MS);
    assert_eq!(sensor.ambient(), Ok(400));
    assert_eq!(sensor.proximity(), Ok(2_600));
    let bus = sensor.release();
    let registers = [0x82, 0x83, 0x84].map(|register| bus.parts().register(register));
    assert_eq!(registers, [0x06, 0x14, 0x1d]);
}

#[test]
fn the_interrupt_pin_follows_the_thresholds_until_it_is_cleared() {
    let mut sensor = Vcnl4020::new(bus(2_600));
    assert_eq!(sensor.set_thresholds(0, 3_000), Ok(()));
    let control = InterruptControl {
        results_log2: 1,
        thresholds: Some(Compared::Proximity),
        ..InterruptControl::default()
    };
    assert_eq!(sensor.set_interrupts(control), Ok(()));
    assert_eq!(sensor.start(&FAST), Ok(()));
    let mut sensor = after(sensor, 50 * MS);
    assert_eq!(sensor.interrupts(), Ok(InterruptStatus(0)));
    let mut wire = sensor.release();
    wire.parts_mut().set_signal(3_001);
    let mut sensor = after(Vcnl4020::new(wire), 50 * MS);
    assert!(sensor.interrupts().is_ok_and(InterruptStatus::above_high));
    let mut wire = sensor.release();
    wire.parts_mut().set_signal(2_600);
    let mut sensor = after(Vcnl4020::new(wire), 50 * MS);
    assert_eq!(sensor.clear_interrupts(InterruptStatus::ALL), Ok(()));
    assert_eq!(sensor.interrupts(), Ok(InterruptStatus(0)));
}

#[test]
fn a_start_that_a_fault_ends_at_any_byte_can_be_repeated() {
    let mut sensor = Vcnl4020::new(bus(2_600));
    assert_eq!(sensor.start(&FAST), Ok(()));
    let bytes = sensor.release().bytes();
    assert!(bytes > 10);
    for fault in [
        InjectedBusFault::NoAcknowledge,
        InjectedBusFault::ArbitrationLost,
    ] {
        for at in 0..bytes {
            let mut wire = bus(2_600);
            wire.script.at_byte(at, fault);
            let mut sensor = Vcnl4020::new(wire);
            match sensor.start(&FAST) {
                Err(Error::Bus(FakeBusError::NoAcknowledge(_) | FakeBusError::Line(_))) => {
                    assert_eq!(sensor.start(&FAST), Ok(()), "{fault:?} at {at}");
                }
                // A byte that is read cannot be refused.
                outcome => assert_eq!((outcome, fault), (Ok(()), InjectedBusFault::NoAcknowledge)),
            }
            assert_eq!(sensor.command(), Ok(Command(0x83)), "{fault:?} at {at}");
        }
    }
}

#[test]
fn f17_of_a_hundred_thousand_random_update_phases_none_gives_a_torn_result() {
    let mut generator = Generator::seeded(1);
    let mut sensor = Vcnl4020::new(bus(WHOLE[0]));
    assert_eq!(sensor.start(&FAST), Ok(()));
    for _ in 0..100_000 {
        let mut wire = sensor.release();
        wire.parts_mut().queue_signals(WHOLE);
        // At a pace of its own, slower than the sensor's: a result is always ready.
        wire.advance(8 * MS + u64::from(uniform_below(&mut generator, 8_000_000)));
        sensor = Vcnl4020::new(wire);
        let result = sensor.proximity();
        assert!(result.is_ok_and(|it| WHOLE.contains(&it)), "{result:?}");
    }
}

const MUX: Address = Address::from_pins(true, true, true);

#[test]
fn each_channel_leads_to_its_own_sensor() {
    let mut buses = RobotBuses::default();
    // The first bus: sensors 7, 0, 2 and 1 on channels 0 to 3.
    for (sensor, signal) in [(7, 3_000), (0, 3_001), (2, 3_002), (1, 3_003)] {
        buses.set_signal(sensor, signal);
    }
    let mut mux = Pca9544a::new(&mut buses.one, MUX);
    for channel in Channel::ALL {
        assert_eq!(mux.select(channel), Ok(()));
        assert_eq!(Vcnl4020::new(mux.bus()).start(&FAST), Ok(()));
    }
    mux.bus().advance(20 * MS);
    for channel in Channel::ALL {
        assert_eq!(mux.select(channel), Ok(()));
        let result = Vcnl4020::new(mux.bus()).proximity();
        assert_eq!(mux.confirm(), Ok(()));
        assert_eq!(result, Ok(3_000 + u16::from(channel.number())));
    }
    assert_eq!(mux.deselect(), Ok(()));
    assert!(Vcnl4020::new(mux.bus()).check_identity().is_err());
}

#[test]
fn interrupt_lines_of_all_channels_are_read_whatever_is_selected() {
    let mut buses = RobotBuses::default();
    let mut mux = Pca9544a::new(&mut buses.one, MUX);
    assert_eq!(mux.select(Channel::Two), Ok(()));
    let control = InterruptControl {
        proximity_ready: true,
        ..InterruptControl::default()
    };
    let mut sensor = Vcnl4020::new(mux.bus());
    assert_eq!(sensor.set_interrupts(control), Ok(()));
    assert_eq!(sensor.start(&FAST), Ok(()));
    assert_eq!(mux.deselect(), Ok(()));
    mux.bus().advance(20 * MS);
    let low = mux.interrupts().unwrap();
    let which = Channel::ALL.map(|channel| low.contains(channel));
    assert_eq!(which, [false, false, true, false]);
}
