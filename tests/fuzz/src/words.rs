//! Any text as words on a command line, and as a table of measured counts.

use std::time::Duration;

use sim_harness::calibration::{Fixed, Table};
use sim_harness::device::FaultInjector;
use sim_harness::faults::{Faults, Kind};
use sim_harness::mapping::Method;
use sim_harness::world::Options;

use crate::framing::frame_around;
use crate::recordings::assert_is_printable;

/// Longest garbage of a line that bytes are sent over.
const LONGEST_GARBAGE: u32 = 100;

/// Reads the text as all of them; the faults of a line say what they were read from,
/// and a line that has them delivers no more than they explain.
pub fn check(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let _ = text.parse::<Options>();
    let _ = text.parse::<Method>();
    let _ = Options::named_in(&text);
    let _ = Fixed::parse(text.split_whitespace());
    if let Err(error) = Table::parse(&text) {
        assert_is_printable(&error.to_string());
    }
    if let Ok(faults) = format!("link={text}").parse::<Faults>() {
        assert_eq!(faults.to_string().parse().as_ref(), Ok(&faults));
        check_line(&faults);
    }
}

fn check_line(faults: &Faults) {
    let (mut most_garbage, mut copies) = (0, 1);
    for fault in faults.line() {
        match fault.kind {
            Kind::GarbageBytes { most, .. } => most_garbage += most,
            Kind::Twice(_) => copies *= 2,
            _ => {}
        }
    }
    if most_garbage > LONGEST_GARBAGE || copies > 16 {
        return;
    }
    let mut line = FaultInjector::new(faults, 1);
    let (mut sent, mut arrived, mut now) = (0, 0, Duration::ZERO);
    for number in 0..4 {
        let frame = frame_around(1, number, &[0, 0]);
        sent += frame.len();
        line.send(&frame, now);
        now += Duration::from_millis(100);
        arrived += line.receive(now).len();
    }
    line.flush(now);
    arrived += line.receive(now + Duration::from_secs(200_000)).len();
    assert!(
        arrived <= sent * copies * (1 + most_garbage as usize),
        "{arrived} of {sent} bytes over {faults}"
    );
}
