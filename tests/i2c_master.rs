//! The flash image's I2C master at a model of the silicon's registers.
//!
//! Names that begin with f02 to f05 are entries of the fault catalogue. What the
//! silicon itself does with a shorted wire is not shown here.

#[path = "../src/bin/firmware/i2c/mod.rs"]
mod i2c;
mod i2c_model;

use amiro_ipf::driver::{BusFault, LONGEST_READ, LONGEST_WRITE, Transaction};

use i2c::Timing;
use i2c_model::{Bench, Fault, Part, Seen, Stuck};

const ADDRESS: u8 = 0x13;

fn bytes(length: usize) -> Vec<u8> {
    (0..length).map(|index| 0x80 + index as u8).collect()
}

fn answer(length: usize) -> Vec<u8> {
    (0..length as u8).map(Part::byte).collect()
}

fn transaction(write: usize, read: usize) -> Transaction {
    Transaction::new(ADDRESS, &bytes(write), read as u8)
}

/// What a part sees of a transaction that nothing disturbs.
fn seen(write: usize, read: usize) -> Vec<Seen> {
    let mut seen = Vec::new();
    if write > 0 || read == 0 {
        seen.push(Seen::Address { read: false });
        seen.extend(bytes(write).into_iter().map(Seen::Written));
    }
    if read > 0 {
        seen.push(Seen::Address { read: true });
        seen.extend(answer(read).into_iter().map(Seen::Read));
    }
    seen.push(Seen::Stop);
    seen
}

/// Every length of writing with every length of reading.
fn shapes() -> impl Iterator<Item = (usize, usize)> {
    (0..=LONGEST_WRITE).flat_map(|write| (0..=LONGEST_READ).map(move |read| (write, read)))
}

/// Addresses and bytes of a transaction.
fn on_the_wire(write: usize, read: usize) -> usize {
    let addresses = 1 + usize::from(write > 0 && read > 0);
    addresses + write + read
}

/// A transaction of every shape on a bench, to which something is done before each.
fn all_shapes_arrive(bench: &mut Bench, part: &Part, story: &str) {
    for (write, read) in shapes() {
        let result = bench.run(&transaction(write, read));
        assert_eq!(result, Ok(answer(read)), "{story}: {write} + {read}");
        assert_eq!(
            part.take_seen(),
            seen(write, read),
            "{story}: {write} + {read}"
        );
        let unit = bench.unit.borrow();
        assert_eq!(unit.wrongs, [""; 0], "{story}: {write} + {read}");
        assert!(unit.is_idle(), "{story}: {write} + {read}");
    }
}

#[test]
fn every_shape_arrives_whole() {
    let part = Part::at(ADDRESS);
    let mut bench = Bench::new(part.clone(), 1);
    all_shapes_arrive(&mut bench, &part, "in time");
    assert_eq!(*bench.master.counters(), i2c::Counters::default());
}

#[test]
fn debug_one() {
    let part = Part::at(ADDRESS);
    let mut bench = Bench::new(part.clone(), 1);
    for (w, r) in [(0, 0), (1, 0), (0, 1), (0, 2), (0, 3), (1, 4)] {
        let t0 = bench.now_ns();
        let result = bench.run(&transaction(w, r));
        eprintln!("{w}+{r}: {result:?} {} ns {} calls {:?}", bench.now_ns() - t0, bench.calls, part.take_seen());
        eprintln!("{:?}", bench.unit.borrow().wrongs);
    }
    let _ = (Fault::ClockLow, Stuck::Busy, BusFault::HeldLow, Timing::fast(1));
    let _ = on_the_wire(1, 1);
}
