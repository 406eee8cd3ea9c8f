//! The asynchronous driver gives the same transfers as the blocking one.

use std::future::Future;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

use embedded_hal::i2c::{ErrorKind, NoAcknowledgeSource};
use embedded_hal_mock::eh1::i2c::{Mock, Transaction as Expected};
use pca9544a::{Address, Channel, Error, Pca9544aAsync, Selection};

const NACK: ErrorKind = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);

/// The mock's futures are ready at once.
fn now<F: Future>(future: F) -> F::Output {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(output) => output,
        Poll::Pending => unreachable!("the mock waits for nothing"),
    }
}

fn write(byte: u8) -> Expected {
    Expected::write(0x72, vec![byte])
}

fn read(byte: u8) -> Expected {
    Expected::read(0x72, vec![byte])
}

fn mux(expected: &[Expected]) -> Pca9544aAsync<Mock> {
    Pca9544aAsync::new(Mock::new(expected), Address::from_pins(false, true, false))
}

#[test]
fn channels_are_selected_confirmed_and_deselected() {
    let mut mux = mux(&[
        write(0),
        read(0),
        write(0x05),
        read(0x05),
        read(0x85),
        write(0),
        read(0),
    ]);
    now(async {
        mux.select(Channel::One).await?;
        assert_eq!(mux.selection(), Selection::Channel(Channel::One));
        assert!(mux.interrupts().await?.contains(Channel::Three));
        mux.deselect().await
    })
    .unwrap();
    assert_eq!(mux.selection(), Selection::None);
    mux.release().done();
}

#[test]
fn any_failure_leaves_the_selection_unknown() {
    let mut mux = mux(&[write(0), read(0), write(0x04).with_error(NACK)]);
    assert_eq!(now(mux.select(Channel::Zero)), Err(Error::Bus(NACK)));
    assert_eq!(mux.selection(), Selection::Unknown);
    assert_eq!(now(mux.confirm()), Err(Error::UnknownSelection));
    mux.release().done();
}

#[test]
fn a_future_that_is_dropped_before_its_first_transfer_leaves_the_selection_as_it_was() {
    let mut mux = mux(&[write(0), read(0)]);
    now(mux.deselect()).unwrap();
    drop(mux.select(Channel::Zero));
    assert_eq!(mux.selection(), Selection::None);
    mux.release().done();
}
