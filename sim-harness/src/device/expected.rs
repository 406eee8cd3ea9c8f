//! The host's run as a comparison needs it: hashes of its messages, in bounded memory.

use std::collections::VecDeque;
use std::collections::hash_map::DefaultHasher;
use std::hash::Hasher;
use std::io::{self, ErrorKind, Read};

use amiro_ipf::link::MessageRef;
use amiro_ipf::node::Event;

use crate::spool::{Spool, SpoolReader};

/// A message's payload: floats are compared by their bits, not by their value.
pub(super) fn hash(event: &Event) -> u64 {
    let mut bytes = [0; amiro_ipf::link::MAX_FRAME];
    let mut hasher = DefaultHasher::new();
    // No event is larger than a frame.
    if let Ok(payload) = postcard::to_slice(&MessageRef::Event(event), &mut bytes) {
        hasher.write(payload);
    }
    hasher.finish()
}

/// Hashes of the messages of one step.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct ExpectedStep {
    pub(super) begun: u64,
    pub(super) walls: Option<u64>,
    pub(super) particles: Vec<u64>,
    pub(super) done: u64,
}

/// The steps of the host's run and its odometry resets.
///
/// First all of it is written, then it is read forward: steps before the last requested one
/// are dropped.
#[derive(Debug, Default)]
pub(super) struct ExpectedRun {
    steps: usize,
    breaks: usize,
    /// The step whose messages are written now.
    open: Option<ExpectedStep>,
    step_spool: Spool,
    break_spool: Spool,
    reading: Option<ExpectedReader>,
    failed: Option<io::Error>,
}

/// The run as it is read again.
#[derive(Debug)]
struct ExpectedReader {
    steps: SpoolReader,
    breaks: SpoolReader,
    /// The steps that are held, and the number of the first.
    held: VecDeque<ExpectedStep>,
    first: usize,
}

impl ExpectedRun {
    /// Number of steps.
    pub(super) fn steps(&self) -> usize {
        self.steps
    }

    /// Number of odometry resets.
    pub(super) fn breaks(&self) -> usize {
        self.breaks
    }

    /// Why the run could not be kept, if it could not.
    pub(super) fn failed(&self) -> Option<&io::Error> {
        self.failed.as_ref()
    }

    /// Writes the begin of a step.
    pub(super) fn begin_step(&mut self, begun: u64) {
        self.close_step();
        self.steps += 1;
        self.open = Some(ExpectedStep {
            begun,
            ..ExpectedStep::default()
        });
    }

    /// The step whose messages are written now.
    pub(super) fn open_step(&mut self) -> Option<&mut ExpectedStep> {
        self.open.as_mut()
    }

    /// Writes an odometry reset.
    pub(super) fn break_off(&mut self, hash: u64) {
        self.breaks += 1;
        self.break_spool.write(&hash.to_le_bytes());
    }

    fn close_step(&mut self) {
        let Some(step) = self.open.take() else {
            return;
        };
        let count = step.particles.len() as u64;
        let numbers = [step.begun, step.done, u64::from(step.walls.is_some())];
        let numbers = numbers.into_iter().chain(step.walls).chain([count]);
        for number in numbers.chain(step.particles) {
            self.step_spool.write(&number.to_le_bytes());
        }
    }

    /// The step of a number, which is not below that of an earlier call of
    /// [`forget_before`](Self::forget_before); `None` where there is none.
    pub(super) fn step(&mut self, index: usize) -> Option<&ExpectedStep> {
        if index >= self.steps {
            return None;
        }
        let place = index.checked_sub(self.reading()?.first)?;
        while self.reading()?.held.len() <= place {
            let step = read_step(&mut self.reading()?.steps);
            let step = self.checked(step)?;
            self.reading()?.held.push_back(step);
        }
        self.reading()?.held.get(place)
    }

    /// Drops the steps before a number.
    pub(super) fn forget_before(&mut self, index: usize) {
        while self.reading().is_some_and(|reading| reading.first < index) {
            let Some(first) = self.reading().map(|reading| reading.first) else {
                return;
            };
            if self.step(first).is_none() {
                return;
            }
            if let Some(reading) = self.reading() {
                reading.held.pop_front();
                reading.first += 1;
            }
        }
    }

    /// The hash of the next odometry reset.
    pub(super) fn next_break(&mut self) -> Option<u64> {
        let hash = read_number(&mut self.reading()?.breaks);
        match hash {
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => None,
            hash => self.checked(hash),
        }
    }

    /// The run for reading; later writes are not part of it.
    fn reading(&mut self) -> Option<&mut ExpectedReader> {
        if self.reading.is_none() && self.failed.is_none() {
            self.close_step();
            let steps = std::mem::take(&mut self.step_spool).read();
            let breaks = std::mem::take(&mut self.break_spool).read();
            let (steps, breaks) = (self.checked(steps)?, self.checked(breaks)?);
            self.reading = Some(ExpectedReader {
                steps,
                breaks,
                held: VecDeque::new(),
                first: 0,
            });
        }
        self.reading.as_mut()
    }

    fn checked<T>(&mut self, result: io::Result<T>) -> Option<T> {
        result
            .map_err(|error| self.failed.get_or_insert(error).kind())
            .ok()
    }
}

fn read_step(spool: &mut SpoolReader) -> io::Result<ExpectedStep> {
    let (begun, done) = (read_number(spool)?, read_number(spool)?);
    let has_walls = read_number(spool)? != 0;
    let walls = has_walls.then(|| read_number(spool)).transpose()?;
    let count = read_number(spool)?;
    let particles: io::Result<Vec<_>> = (0..count).map(|_| read_number(spool)).collect();
    Ok(ExpectedStep {
        begun,
        walls,
        particles: particles?,
        done,
    })
}

fn read_number(spool: &mut SpoolReader) -> io::Result<u64> {
    let mut bytes = [0; 8];
    spool.read_exact(&mut bytes)?;
    Ok(u64::from_le_bytes(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_read_forward_and_breaks_in_order() {
        let mut run = ExpectedRun::default();
        for step in 0..1000 {
            run.begin_step(step);
            let open = run.open_step().unwrap();
            open.walls = (step % 2 == 0).then_some(step);
            open.particles.extend(0..step % 3);
            open.done = step + 1;
        }
        run.break_off(77);
        for index in [0, 5, 300, 44, 999] {
            let step = run.step(index).unwrap();
            assert_eq!((step.begun, step.done), (index as u64, index as u64 + 1));
            assert_eq!(step.particles.len(), index % 3);
            assert_eq!(step.walls, (index % 2 == 0).then_some(index as u64));
        }
        run.forget_before(500);
        assert_eq!(run.step(499), None);
        assert_eq!(run.step(500).unwrap().begun, 500);
        run.forget_before(5000);
        assert_eq!(run.step(1000), None);
        assert_eq!((run.next_break(), run.next_break()), (Some(77), None));
        assert!(run.failed().is_none());
        assert_eq!((run.steps(), run.breaks()), (1000, 1));
    }
}
