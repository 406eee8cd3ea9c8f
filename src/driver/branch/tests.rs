//! The branch's own rules, with answers that no part has to give. What it does on a bus
//! with parts stands in `sim-harness/tests/device/buses`.

use pca9544a::Channel;
use pca9544a::transactions::deselect;

use super::*;
use crate::driver::{BusFault, MUX_ADDRESS, SensorState, Transaction};
use crate::random::{Generator, uniform_below};

/// Runs a round with these answers and gives the number of its transactions.
fn round(
    branch: &mut Branch,
    now_us: u64,
    mut answer: impl FnMut(&Transaction) -> Result<Vec<u8>, BusFault>,
) -> u32 {
    assert!(branch.begin_round(now_us, true));
    let mut transactions = 0;
    while let Some(transaction) = branch.next(now_us) {
        let result = answer(&transaction);
        branch.answer(now_us, result.as_deref().map_err(|fault| *fault));
        transactions += 1;
        assert!(transactions <= 80, "round at {now_us} us");
    }
    transactions
}

fn states(branch: &Branch, now_us: u64) -> [SensorState; 4] {
    Channel::ALL.map(|channel| branch.sensor(channel).state(now_us))
}

#[test]
fn a_busy_round_is_counted_and_goes_on() {
    let mut branch = Branch::new(&Channel::ALL);
    assert!(branch.begin_round(0, true));
    let first = branch.next(0);
    assert!(!branch.begin_round(0, true));
    assert_eq!(branch.next(0), first);
    assert_eq!(branch.counters().late, 1);
    assert_eq!(branch.counters().rounds, 1);
}

#[test]
fn an_answer_without_a_transaction_changes_nothing() {
    let mut branch = Branch::new(&Channel::ALL);
    let before = format!("{branch:?}");
    branch.answer(1, Ok(&[1, 2, 3]));
    branch.answer(1, Err(BusFault::HeldLow));
    assert_eq!(format!("{branch:?}"), before);
}

#[test]
fn answers_of_a_wrong_length_are_failures_and_end() {
    let mut branch = Branch::new(&Channel::ALL);
    for length in [0, 1, 2, 3, 5, 16] {
        round(&mut branch, 0, |_| Ok(vec![0x07; length]));
    }
}

#[test]
fn whatever_the_bus_answers_a_round_ends_within_eighty_transactions() {
    let mut generator = Generator::seeded(1);
    let mut below = |bound| uniform_below(&mut generator, bound);
    let mut branch = Branch::new(&Channel::ALL);
    let rounds = if cfg!(miri) { 50 } else { 100_000 };
    for index in 0..rounds {
        round(&mut branch, index * ROUND_PERIOD_US, |transaction| {
            // Mostly what keeps the round going: channels, identities, ready bits.
            let byte = match below(4) {
                0 => below(256) as u8,
                1 => 0x04 | below(4) as u8,
                2 => [0x00, 0x21, 0x87, 0xa7][below(4) as usize],
                _ => transaction.to_write().first().copied().unwrap_or(0x04),
            };
            match below(40) {
                0 => Err(BusFault::NoSuchPart),
                1 => Err(BusFault::Misplaced),
                _ => Ok(vec![byte; transaction.to_read()]),
            }
        });
    }
}

#[test]
fn f03_a_held_line_ends_the_round_at_once() {
    for fault in [BusFault::HeldLow, BusFault::Overdue] {
        let mut branch = Branch::new(&Channel::ALL);
        assert_eq!(round(&mut branch, 0, |_| Err(fault)), 1);
        assert_eq!(branch.counters().line_failures, 1);
        for channel in Channel::ALL {
            assert_eq!(branch.sensor(channel).counters().failed, 1);
        }
        // Nothing is assumed about the multiplexer afterwards.
        branch.begin_round(8_000, true);
        let next = branch.next(8_000);
        assert_eq!(next, Some(Transaction::of_mux(&deselect(MUX_ADDRESS))));
    }
}

#[test]
fn f06_without_the_multiplexer_all_four_are_missing_and_it_is_tried_once_a_second() {
    let mut branch = Branch::new(&Channel::ALL);
    let refuse = |_: &Transaction| Err(BusFault::NoSuchPart);
    let mut transactions = 0;
    for index in 0..1_253 {
        if index == 2 {
            assert_ne!(states(&branch, 8_000), [SensorState::Missing; 4]);
        }
        let now_us = index * ROUND_PERIOD_US;
        transactions += round(&mut branch, now_us, refuse);
        if index == 2 {
            assert_eq!(transactions, 3);
        }
        if index >= 2 {
            assert_eq!(states(&branch, now_us), [SensorState::Missing; 4]);
        }
    }
    // Every 125th or 126th of 1250 rounds a deselection is tried, nothing else.
    assert_eq!(transactions, 3 + 10);
    assert_eq!(branch.counters().mux_failures, 13);
}

#[test]
fn f07_each_read_back_that_names_another_channel_is_counted() {
    let mut branch = Branch::new(&Channel::ALL);
    // Takes no selection: four sensors, two visits each.
    round(&mut branch, 0, |transaction| {
        Ok(vec![0; transaction.to_read()])
    });
    assert_eq!(branch.counters().wrong_channel, 8);
}

#[test]
fn only_the_channels_in_use_are_visited() {
    let mut branch = Branch::new(&[Channel::Two]);
    round(&mut branch, 0, |transaction| {
        let written = transaction.to_write();
        assert!(written.is_empty() || [[0], [6]].iter().any(|it| it == written));
        Ok(vec![0; transaction.to_read()])
    });
    let none = SensorState::NoData;
    assert_eq!(states(&branch, 0), [none; 4]);
    assert_eq!(branch.sensor(Channel::Two).counters().failed, 1);
    assert_eq!(branch.sensor(Channel::One).counters().failed, 0);
}
