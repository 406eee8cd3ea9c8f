//! The asynchronous driver gives the same transfers as the blocking one.

use std::future::Future;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

use embedded_hal::i2c::{ErrorKind, NoAcknowledgeSource};
use embedded_hal_mock::eh1::i2c::{Mock, Transaction as Expected};
use vcnl4020::{Configuration, Error, InterruptStatus, Measurement, Vcnl4020Async};

const NACK: ErrorKind = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);

/// The mock's futures are ready at once.
fn now<F: Future>(future: F) -> F::Output {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(output) => output,
        Poll::Pending => unreachable!("the mock waits for nothing"),
    }
}

fn write(bytes: &[u8]) -> Expected {
    Expected::write(0x13, bytes.to_vec())
}

fn read(register: u8, answer: &[u8]) -> Expected {
    Expected::write_read(0x13, vec![register], answer.to_vec())
}

#[test]
fn a_sensor_is_started_and_read() {
    let mut sensor = Vcnl4020Async::new(Mock::new(&[
        read(0x81, &[0x21]),
        write(&[0x80, 0x00]),
        write(&[0x82, 0x00, 0x02, 0x1d]),
        write(&[0x80, 0x07]),
        read(0x80, &[0x87]),
        read(0x80, &[0xa7]),
        read(0x87, &[0x09, 0x92]),
        read(0x87, &[0x09, 0x92]),
        write(&[0x8e, 0x08]),
    ]));
    now(async {
        sensor.start(&Configuration::default()).await?;
        assert_eq!(sensor.proximity().await, Err(Error::NotReady));
        assert_eq!(sensor.proximity().await?, 2_450);
        sensor.clear_interrupts(InterruptStatus(0x08)).await
    })
    .unwrap();
    sensor.release().done();
}

#[test]
fn one_measurement_ends_after_its_polls() {
    let mut sensor = Vcnl4020Async::new(Mock::new(&[
        write(&[0x80, 0x18]),
        read(0x80, &[0x98]),
        read(0x80, &[0xe0]),
        read(0x85, &[0, 9, 1, 2]),
        write(&[0x80, 0x18]),
        read(0x80, &[0x98]),
    ]));
    let measured = Measurement {
        ambient: 9,
        proximity: 0x0102,
    };
    assert_eq!(now(sensor.measure_once(2)), Ok(measured));
    assert_eq!(now(sensor.measure_once(1)), Err(Error::NotReady));
    sensor.release().done();
}

#[test]
fn a_failing_bus_ends_an_operation() {
    let mut sensor = Vcnl4020Async::new(Mock::new(&[
        read(0x81, &[0x21]),
        write(&[0x80, 0x00]).with_error(NACK),
    ]));
    let outcome = now(sensor.start(&Configuration::default()));
    assert_eq!(outcome, Err(Error::Bus(NACK)));
    sensor.release().done();
}
