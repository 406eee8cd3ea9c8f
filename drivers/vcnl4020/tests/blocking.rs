//! The blocking driver, transfer by transfer.

use embedded_hal::i2c::{ErrorKind, NoAcknowledgeSource};
use embedded_hal_mock::eh1::i2c::{Mock, Transaction as Expected};
use vcnl4020::{
    Ambient, AmbientRate, Command, Compared, Configuration, Error, InterruptControl,
    InterruptStatus, LedCurrent, Measurement, ProximityRate, SATURATED, Vcnl4020,
};

const NACK: ErrorKind = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);

const FAST: Configuration = Configuration {
    rate: ProximityRate::Hz125,
    led: LedCurrent::MAX,
    ambient: Some(Ambient {
        continuous: false,
        rate: AmbientRate::Hz2,
        auto_offset: false,
        conversions_log2: 5,
    }),
};

fn write(bytes: &[u8]) -> Expected {
    Expected::write(0x13, bytes.to_vec())
}

fn read(register: u8, answer: &[u8]) -> Expected {
    Expected::write_read(0x13, vec![register], answer.to_vec())
}

/// Runs `call` against exactly these transfers.
fn on<R>(
    expected: &[Expected],
    call: impl FnOnce(&mut Vcnl4020<Mock>) -> Result<R, Error<ErrorKind>>,
) -> Result<R, Error<ErrorKind>> {
    let mut sensor = Vcnl4020::new(Mock::new(expected));
    let outcome = call(&mut sensor);
    sensor.release().done();
    outcome
}

/// Asserts the result, then runs `call` once per transfer with that transfer failing: the
/// error is returned and no transfer follows.
fn check<R: core::fmt::Debug + PartialEq>(
    expected: &[Expected],
    call: impl Fn(&mut Vcnl4020<Mock>) -> Result<R, Error<ErrorKind>>,
    result: R,
) {
    assert_eq!(on(expected, &call), Ok(result));
    for index in 0..expected.len() {
        let mut cut = expected[..=index].to_vec();
        let last = cut.pop().unwrap().with_error(NACK);
        cut.push(last);
        assert_eq!(on(&cut, &call), Err(Error::Bus(NACK)), "at {index}");
    }
}

#[test]
fn identity_is_checked() {
    check(&[read(0x81, &[0x21])], Vcnl4020::check_identity, ());
    assert_eq!(
        on(&[read(0x81, &[0x22])], Vcnl4020::check_identity),
        Err(Error::WrongIdentity(0x22))
    );
}

#[test]
fn starting_stops_first_and_enables_last() {
    let expected = [
        read(0x81, &[0x21]),
        write(&[0x80, 0x00]),
        write(&[0x82, 0x06, 0x14, 0x15]),
        write(&[0x80, 0x07]),
    ];
    check(&expected, |sensor| sensor.start(&FAST), ());
}

#[test]
fn a_vcnl3020_is_started_without_its_missing_register() {
    let expected = [
        read(0x81, &[0x21]),
        write(&[0x80, 0x00]),
        write(&[0x82, 0x06, 0x14]),
        write(&[0x80, 0x03]),
    ];
    let configuration = Configuration {
        ambient: None,
        ..FAST
    };
    check(&expected, |sensor| sensor.start(&configuration), ());
}

#[test]
fn a_part_with_another_identity_is_not_written_to() {
    assert_eq!(
        on(&[read(0x81, &[0x55])], |sensor| sensor.start(&FAST)),
        Err(Error::WrongIdentity(0x55))
    );
}

#[test]
fn stopping_clears_the_command_register() {
    check(&[write(&[0x80, 0x00])], Vcnl4020::stop, ());
}

#[test]
fn a_reset_shows_in_the_command_register() {
    check(
        &[read(0x80, &[0x80])],
        |sensor| Ok(sensor.command()?.is_self_timed()),
        false,
    );
    check(&[read(0x80, &[0xa7])], Vcnl4020::command, Command(0xa7));
}

#[test]
fn rates_are_set_only_while_stopped() {
    let rate = |sensor: &mut Vcnl4020<Mock>| sensor.set_proximity_rate(ProximityRate::Hz250);
    check(&[read(0x80, &[0x80]), write(&[0x82, 0x07])], rate, ());
    assert_eq!(on(&[read(0x80, &[0x87])], rate), Err(Error::Running));

    let settings = Ambient {
        continuous: false,
        rate: AmbientRate::Hz10,
        auto_offset: true,
        conversions_log2: 0,
    };
    let ambient = |sensor: &mut Vcnl4020<Mock>| sensor.set_ambient(settings);
    check(&[read(0x80, &[0x80]), write(&[0x84, 0x78])], ambient, ());
    assert_eq!(on(&[read(0x80, &[0x87])], ambient), Err(Error::Running));
}

#[test]
fn current_is_set_at_any_time() {
    let current = LedCurrent::from_milliamperes(50).unwrap();
    check(
        &[write(&[0x83, 5])],
        |sensor| sensor.set_led_current(current),
        (),
    );
}

#[test]
fn a_result_is_read_only_when_its_own_bit_is_set() {
    let twice = [
        read(0x80, &[0xa7]),
        read(0x87, &[0x09, 0x92]),
        read(0x87, &[0x09, 0x92]),
    ];
    check(&twice, Vcnl4020::proximity, 2_450);
    let twice = [
        read(0x80, &[0xc7]),
        read(0x85, &[0x01, 0x02]),
        read(0x85, &[0x01, 0x02]),
    ];
    check(&twice, Vcnl4020::ambient, 0x0102);
    for (command, proximity, ambient) in [
        (0x87, Error::NotReady, Error::NotReady),
        (0xe0, Error::NotRunning, Error::NotRunning),
    ] {
        let expected = [read(0x80, &[command])];
        assert_eq!(on(&expected, Vcnl4020::proximity), Err(proximity));
        assert_eq!(on(&expected, Vcnl4020::ambient), Err(ambient));
    }
    let only_ambient = [read(0x80, &[0xc7])];
    assert_eq!(on(&only_ambient, Vcnl4020::proximity), Err(Error::NotReady));
    let only_proximity = [read(0x80, &[0xa7])];
    assert_eq!(on(&only_proximity, Vcnl4020::ambient), Err(Error::NotReady));
}

#[test]
fn a_result_that_changes_while_it_is_read_is_not_a_mixture() {
    // 0x0aff became 0x0b00 between the bytes of the first reading.
    let expected = [
        read(0x80, &[0xa7]),
        read(0x87, &[0x0a, 0x00]),
        read(0x87, &[0x0b, 0x00]),
        read(0x87, &[0x0b, 0x00]),
    ];
    check(&expected, Vcnl4020::proximity, 0x0b00);
}

#[test]
fn one_measurement_polls_as_often_as_allowed_and_no_more() {
    let once = |sensor: &mut Vcnl4020<Mock>| sensor.measure_once(3);
    let ready = [
        write(&[0x80, 0x18]),
        read(0x80, &[0x98]),
        read(0x80, &[0xb8]),
        read(0x80, &[0xe0]),
        read(0x85, &[0, 9, 0xff, 0xff]),
    ];
    let measured = Measurement {
        ambient: 9,
        proximity: SATURATED,
    };
    check(&ready, once, measured);
    let never = [
        write(&[0x80, 0x18]),
        read(0x80, &[0x98]),
        read(0x80, &[0x98]),
        read(0x80, &[0xb8]),
    ];
    assert_eq!(on(&never, once), Err(Error::NotReady));
    assert_eq!(
        on(&[write(&[0x80, 0x18])], |sensor| sensor.measure_once(0)),
        Err(Error::NotReady)
    );
}

#[test]
fn one_proximity_measurement_waits_for_no_ambient_light() {
    let ready = [
        write(&[0x80, 0x08]),
        read(0x80, &[0x88]),
        read(0x80, &[0xa0]),
        read(0x87, &[0x0a, 0x00]),
    ];
    check(&ready, |sensor| sensor.measure_proximity_once(2), 2_560);
}

#[test]
fn thresholds_are_written_high_byte_first() {
    check(
        &[write(&[0x8a, 0x01, 0x02, 0x03, 0x04])],
        |sensor| sensor.set_thresholds(0x0102, 0x0304),
        (),
    );
}

#[test]
fn interrupts_are_set_read_and_cleared_by_writing_ones() {
    let control = InterruptControl {
        results_log2: 2,
        thresholds: Some(Compared::Proximity),
        ..InterruptControl::default()
    };
    check(
        &[write(&[0x89, 0b0100_0010])],
        |sensor| sensor.set_interrupts(control),
        (),
    );
    check(
        &[read(0x8e, &[0x02])],
        Vcnl4020::interrupts,
        InterruptStatus(2),
    );
    // Bits without an event are never written.
    check(
        &[write(&[0x8e, 0x02])],
        |sensor| sensor.clear_interrupts(InterruptStatus(0xf2)),
        (),
    );
}

#[test]
fn errors_name_what_was_found() {
    let error = Error::<ErrorKind>::WrongIdentity(0x22);
    assert_eq!(error.to_string(), "identity is 0x22 instead of 0x21");
}
