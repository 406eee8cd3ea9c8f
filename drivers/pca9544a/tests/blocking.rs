//! The blocking driver, transfer by transfer.

use embedded_hal::i2c::{ErrorKind, I2c, NoAcknowledgeSource};
use embedded_hal_mock::eh1::i2c::{Mock, Transaction as Expected};
use pca9544a::{Address, Channel, Error, Pca9544a, Selection};

const NACK: ErrorKind = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);

fn write(byte: u8) -> Expected {
    Expected::write(0x77, vec![byte])
}

fn read(byte: u8) -> Expected {
    Expected::read(0x77, vec![byte])
}

fn mux(expected: &[Expected]) -> Pca9544a<Mock> {
    Pca9544a::new(Mock::new(expected), Address::from_pins(true, true, true))
}

#[test]
fn the_first_selection_deselects_before_it_and_the_next_does_not() {
    let mut mux = mux(&[
        write(0),
        read(0),
        write(0x05),
        read(0x05),
        write(0x07),
        read(0x07),
        write(0),
        read(0),
    ]);
    assert_eq!(mux.selection(), Selection::Unknown);
    assert_eq!(mux.select(Channel::One), Ok(()));
    assert_eq!(mux.selection(), Selection::Channel(Channel::One));
    assert_eq!(mux.select(Channel::Three), Ok(()));
    assert_eq!(mux.deselect(), Ok(()));
    assert_eq!(mux.selection(), Selection::None);
    mux.release().done();
}

#[test]
fn after_a_lost_write_the_next_change_begins_with_a_deselection() {
    let mut mux = mux(&[
        write(0),
        read(0),
        // The write is lost: no channel is still connected.
        write(0x06),
        read(0x00),
        write(0),
        read(0),
        write(0x06),
        read(0x06),
    ]);
    let lost = Error::WrongSelection(Selection::None);
    assert_eq!(mux.select(Channel::Two), Err(lost));
    assert_eq!(mux.selection(), Selection::Unknown);
    assert_eq!(mux.confirm(), Err(Error::UnknownSelection));
    assert_eq!(mux.select(Channel::Two), Ok(()));
    mux.release().done();
}

#[test]
fn any_failure_of_the_bus_leaves_the_selection_unknown() {
    let sound = [write(0), read(0), write(0x04), read(0x04), read(0x04)];
    for index in 0..sound.len() {
        let mut expected = sound[..=index].to_vec();
        let last = expected.pop().unwrap().with_error(NACK);
        expected.push(last);
        let mut mux = mux(&expected);
        let outcome = mux.select(Channel::Zero).and_then(|()| mux.confirm());
        assert_eq!(outcome, Err(Error::Bus(NACK)), "at {index}");
        assert_eq!(mux.selection(), Selection::Unknown, "at {index}");
        mux.release().done();
    }
}

#[test]
fn a_selection_that_stays_after_a_deselection_is_an_error() {
    let mut mux = mux(&[write(0), read(0x05)]);
    let stays = Error::WrongSelection(Selection::Channel(Channel::One));
    assert_eq!(mux.deselect(), Err(stays));
    assert_eq!(mux.selection(), Selection::Unknown);
    mux.release().done();
}

#[test]
fn interrupt_bits_are_read_by_channel_and_confirm_the_selection() {
    let mut mux = mux(&[write(0), read(0), read(0x50), read(0x00), read(0x04)]);
    assert_eq!(mux.deselect(), Ok(()));
    let low = mux.interrupts().unwrap();
    assert!(low.contains(Channel::Zero) && low.contains(Channel::Two));
    assert!(!low.contains(Channel::One) && !low.contains(Channel::Three));
    assert!(mux.interrupts().unwrap().is_empty());
    let other = Error::WrongSelection(Selection::Channel(Channel::Zero));
    assert_eq!(mux.interrupts(), Err(other));
    assert_eq!(mux.selection(), Selection::Unknown);
    mux.release().done();
}

#[test]
fn the_bus_reaches_the_parts_on_the_channel() {
    let mut mux = mux(&[Expected::write(0x13, vec![0x80])]);
    assert_eq!(mux.bus().write(0x13, &[0x80]), Ok(()));
    mux.release().done();
}

#[test]
fn errors_name_what_was_found() {
    let error = Error::<ErrorKind>::WrongSelection(Selection::None);
    assert_eq!(error.to_string(), "another selection was read back: None");
}
