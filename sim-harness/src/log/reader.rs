//! A whole recording in memory: for tests and small tools.

use std::fs::File;
use std::io::{Read, stdin};
use std::path::Path;

use amiro_ipf::geometry::Pose;
use amiro_ipf::link::Message;
use amiro_ipf::node::Input;

use super::entries::Entries;
use super::overview::inspect;
use super::rules::{Entry, Sender};
use super::{LogError, Problem, Recording};

/// Most memory of a recording's inputs, events and true poses together, bytes: 4 GiB.
///
/// An entry takes at most 144 bytes, and no frame is shorter than 9: up to this limit the
/// memory is in proportion to the source. The limit is for sources without end. It is 29
/// million events, five hours of all that a filter of 8000 particles sends while the robot
/// drives at 80 mm/s. A [`StoredRecording`](super::StoredRecording) has no such limit.
pub const MOST_BYTES: u64 = 4 << 30;

/// Reads a recording of either format from a file; `-` is standard input.
///
/// A pipe is waited for until its other end opens and closes it.
///
/// # Errors
/// A source that cannot be read, is no recording, has nothing usable, or whose numbers
/// cannot be in the units that they claim.
pub fn read(path: &Path) -> Result<Recording, LogError> {
    if path.as_os_str() == "-" {
        return read_named("standard input", stdin().lock());
    }
    let name = path.to_string_lossy();
    match File::open(path) {
        Ok(file) => read_named(&name, file),
        Err(error) => Err(LogError::new(&name, None, Problem::Unreadable(error))),
    }
}

/// Reads a recording of either format from anything that gives bytes.
///
/// # Errors
/// As [`read`].
pub fn read_from(read: impl Read) -> Result<Recording, LogError> {
    read_named("recording", read)
}

fn read_named(name: &str, read: impl Read) -> Result<Recording, LogError> {
    let mut rows = Collected::default();
    let (overview, _) = inspect(Entries::new(name, read, MOST_BYTES)?, |entry| {
        rows.take(entry);
    })?;
    let mut truth = overview.truth;
    if let Some(truth) = &mut truth {
        truth.poses = rows.true_poses;
    }
    Ok(Recording {
        config: overview.config,
        inputs: rows.inputs,
        truth,
        messages: rows.messages,
        refusals: overview.refusals,
        format: overview.format,
        segments: overview.segments,
    })
}

/// The rows that are used so far.
#[derive(Debug, Default)]
struct Collected {
    inputs: Vec<Input>,
    /// Places of the board's inputs that are dropped when it takes a configuration.
    of_board: Vec<usize>,
    messages: Vec<Message>,
    true_poses: Vec<(u64, Pose)>,
}

impl Collected {
    fn take(&mut self, entry: Entry) {
        match entry {
            Entry::Input(sender, input) => {
                if sender == Sender::Board {
                    self.of_board.push(self.inputs.len());
                }
                self.inputs.push(input);
            }
            Entry::Message(message) => self.messages.push(message),
            Entry::TruePose(stamp_us, pose) => self.true_poses.push((stamp_us, pose)),
            Entry::Configuration => {
                self.inputs.clear();
                self.of_board.clear();
                self.keep_boots();
            }
            Entry::BoardBegins => {
                let of_board = std::mem::take(&mut self.of_board);
                let mut places = 0..;
                self.inputs.retain(|_| {
                    let place = places.next();
                    place.is_none_or(|place| of_board.binary_search(&place).is_err())
                });
                self.keep_boots();
            }
            Entry::TruthBegins => self.true_poses.clear(),
        }
    }

    fn keep_boots(&mut self) {
        self.messages
            .retain(|message| matches!(message, Message::Boot(_)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_of_an_hour_of_driving_are_not_cut() {
        const EVENTS: u64 = 6_100_000;
        assert!(EVENTS * size_of::<Message>() as u64 <= MOST_BYTES);
    }

    #[test]
    fn entry_is_as_small_as_the_cap_assumes() {
        assert!(size_of::<Input>() <= 136, "{}", size_of::<Input>());
        assert!(size_of::<Message>() <= 144, "{}", size_of::<Message>());
    }
}
