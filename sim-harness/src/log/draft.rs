//! A recording in the making: every rule that does not depend on the format.

use std::fmt::Display;
use std::ops::ControlFlow;

use amiro_ipf::geometry::Pose;
use amiro_ipf::link::Message;
use amiro_ipf::node::{Config, Event, Input};

use super::{Format, GroundTruth, Place, Reason, Recording};

/// Most memory of a recording's inputs, events and true poses together, bytes: 4 GiB.
///
/// An entry takes at most 128 bytes, and no frame is shorter than 9: up to this limit the
/// memory is in proportion to the source. The limit is for sources without end. It is 33
/// million events, five hours of all that a filter of 8000 particles sends while the robot
/// drives at 80 mm/s.
pub const MOST_BYTES: u64 = 4 << 30;

/// Stamps further apart than this begin a new segment.
const GAP_US: u64 = 1_000_000;

/// Kinds of inputs that have stamps.
const KINDS: usize = 4;

/// Who said a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sender {
    /// A host, a simulator, or the program that wrote a table.
    Host,
    /// A board; its inputs are what it read itself.
    Board,
}

/// How far the run of a recording has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Run {
    /// Nothing says with what configuration.
    Unknown,
    /// A configuration was given. A board may be amid another run until it takes it.
    Given(Sender),
    /// A board has taken it.
    Taken,
}

/// A recording in the making.
#[derive(Debug)]
pub(super) struct Draft {
    recording: Recording,
    run: Run,
    /// Places of the board's inputs since the configuration was given, until it is taken.
    early: Vec<usize>,
    last_of_host: [Option<(u64, Input)>; KINDS],
    last_of_board: [Option<(u64, Input)>; KINDS],
    newest_us: Option<u64>,
    /// Bytes that the entries may take.
    room: u64,
}

impl Draft {
    pub(super) fn new(format: Format) -> Self {
        Self {
            recording: Recording::new(format),
            run: Run::Unknown,
            early: Vec::new(),
            last_of_host: [None; KINDS],
            last_of_board: [None; KINDS],
            newest_us: None,
            room: MOST_BYTES,
        }
    }

    pub(super) fn finish(self) -> Recording {
        self.recording
    }

    pub(super) fn refuse(&mut self, place: Place, reason: Reason, text: impl Display) {
        self.recording.refusals.add(place, reason, text);
    }

    /// Whether a configuration or an input was taken: what a simulator writes in front of
    /// them then belongs to another run.
    pub(super) fn has_begun(&self) -> bool {
        self.run != Run::Unknown || !self.recording.inputs.is_empty()
    }

    /// Forgets the truth so far: it belongs to a recording that ended before it began.
    pub(super) fn forget_truth(&mut self, place: Place) {
        self.recording.truth = None;
        let text = "a simulated recording begins again: the truth before it is not used";
        self.refuse(place, Reason::Forgotten, text);
    }

    /// Takes an input if it is usable; breaks when nothing after it may be used.
    pub(super) fn take_input(
        &mut self,
        place: Place,
        sender: Sender,
        input: Input,
    ) -> ControlFlow<()> {
        let (kind, stamp_us) = match input {
            Input::Configure(config) => return self.take_config(place, sender, config),
            Input::Limit { .. } => {
                self.make_room(place)?;
                self.recording.inputs.push(input);
                return ControlFlow::Continue(());
            }
            Input::Proximity { stamp_us, .. } => (0, stamp_us),
            Input::Odometry { stamp_us, .. } => (1, stamp_us),
            Input::Wheels { stamp_us, .. } => (2, stamp_us),
            Input::Tick { stamp_us } => (3, stamp_us),
        };
        if !is_finite(&input) {
            self.refuse(place, Reason::NotFinite, "a number is not finite");
            return ControlFlow::Continue(());
        }
        if let Some((last_us, last)) = self.last_of(sender).get(kind).copied().flatten() {
            if last == input {
                self.refuse(place, Reason::Repeated, "repeats the input before");
                return ControlFlow::Continue(());
            }
            if stamp_us < last_us {
                self.refuse_backward(place, stamp_us, last_us);
                return ControlFlow::Continue(());
            }
        }
        self.make_room(place)?;
        if let Some(last) = self.last_of(sender).get_mut(kind) {
            *last = Some((stamp_us, input));
        }
        self.count_segment(stamp_us);
        if self.run != Run::Taken && sender == Sender::Board {
            self.early.push(self.recording.inputs.len());
        }
        self.recording.inputs.push(input);
        ControlFlow::Continue(())
    }

    /// Takes the first legal configuration; what was before it is forgotten, as a node does.
    ///
    /// A board's own after a host's is of the run that the board was amid, or the same.
    fn take_config(&mut self, place: Place, sender: Sender, config: Config) -> ControlFlow<()> {
        if let Err(error) = config.validate() {
            self.refuse(place, Reason::BadConfiguration, error);
            return ControlFlow::Continue(());
        }
        if (self.run, sender) == (Run::Given(Sender::Host), Sender::Board) {
            return ControlFlow::Continue(());
        }
        let recording = &mut self.recording;
        if recording.config.is_some() {
            let text = "a second configuration: what follows is another run";
            self.refuse(place, Reason::SecondRun, text);
            return ControlFlow::Break(());
        }
        recording.config = Some(config);
        self.run = Run::Given(sender);
        self.early.clear();
        if recording.inputs.is_empty() {
            return ControlFlow::Continue(());
        }
        let forgotten = recording.inputs.len();
        recording.inputs.clear();
        recording
            .messages
            .retain(|message| matches!(message, Message::Boot(_)));
        recording.segments = 0;
        self.last_of_host = [None; KINDS];
        self.last_of_board = [None; KINDS];
        self.newest_us = None;
        self.refuse(
            place,
            Reason::Forgotten,
            format_args!("a configuration, so the {forgotten} inputs before it are not used"),
        );
        ControlFlow::Continue(())
    }

    /// Takes what a board answered; breaks where another run begins.
    pub(super) fn take_message(&mut self, place: Place, message: Message) -> ControlFlow<()> {
        self.make_room(place)?;
        if let Message::Event(Event::Configured(config)) = message {
            match self.run {
                Run::Given(_) if self.recording.config == Some(config) => self.begin_run(place),
                // Of the run before, or of one whose beginning is not here.
                Run::Given(Sender::Host) | Run::Unknown => {}
                Run::Given(Sender::Board) | Run::Taken => {
                    let text = "the board takes a configuration: what follows is another run";
                    self.refuse(place, Reason::SecondRun, text);
                    return ControlFlow::Break(());
                }
            }
        }
        self.recording.messages.push(message);
        ControlFlow::Continue(())
    }

    /// The board takes the configuration: what it said and read before is of another run.
    fn begin_run(&mut self, place: Place) {
        self.run = Run::Taken;
        self.last_of_board = [None; KINDS];
        let recording = &mut self.recording;
        recording
            .messages
            .retain(|message| matches!(message, Message::Boot(_)));
        let early = std::mem::take(&mut self.early);
        if early.is_empty() {
            return;
        }
        let mut number = 0;
        recording.inputs.retain(|_| {
            number += 1;
            early.binary_search(&(number - 1)).is_err()
        });
        recording.segments = 0;
        self.newest_us = None;
        for place in 0..self.recording.inputs.len() {
            let stamp_us = self.recording.inputs.get(place).and_then(stamp_of);
            stamp_us
                .into_iter()
                .for_each(|stamp_us| self.count_segment(stamp_us));
        }
        let forgotten = early.len();
        self.refuse(
            place,
            Reason::Forgotten,
            format_args!("{forgotten} inputs of the run that the board was amid are not used"),
        );
    }

    /// Takes where the robot really was.
    pub(super) fn take_true_pose(
        &mut self,
        place: Place,
        stamp_us: u64,
        pose: Pose,
    ) -> ControlFlow<()> {
        self.make_room(place)?;
        let last = self.truth().poses.last().copied();
        match last {
            _ if !pose.is_finite() => {
                self.refuse(place, Reason::NotFinite, "a number is not finite");
            }
            Some(last) if last == (stamp_us, pose) => {
                self.refuse(place, Reason::Repeated, "repeats the true pose before");
            }
            Some((last_us, _)) if stamp_us < last_us => {
                self.refuse_backward(place, stamp_us, last_us);
            }
            _ => self.truth().poses.push((stamp_us, pose)),
        }
        ControlFlow::Continue(())
    }

    /// The ground truth, which from now on the recording has.
    pub(super) fn truth(&mut self) -> &mut GroundTruth {
        self.recording
            .truth
            .get_or_insert_with(GroundTruth::default)
    }

    /// The last inputs of a sender, by kind.
    fn last_of(&mut self, sender: Sender) -> &mut [Option<(u64, Input)>; KINDS] {
        match sender {
            Sender::Host => &mut self.last_of_host,
            Sender::Board => &mut self.last_of_board,
        }
    }

    fn refuse_backward(&mut self, place: Place, stamp_us: u64, last_us: u64) {
        self.refuse(
            place,
            Reason::Backward,
            format_args!("stamp {stamp_us} us lies before {last_us} us"),
        );
    }

    fn count_segment(&mut self, stamp_us: u64) {
        let is_new = self
            .newest_us
            .is_none_or(|newest_us| stamp_us.saturating_sub(newest_us) > GAP_US);
        self.recording.segments += usize::from(is_new);
        self.newest_us = self.newest_us.max(Some(stamp_us));
    }

    fn make_room(&mut self, place: Place) -> ControlFlow<()> {
        let recording = &self.recording;
        let poses = recording.truth.as_ref().map(|truth| &*truth.poses);
        let taken = size_of_val(&*recording.inputs)
            + size_of_val(&*recording.messages)
            + size_of_val(poses.unwrap_or_default());
        if (taken as u64) < self.room {
            return ControlFlow::Continue(());
        }
        let text = format!(
            "entries of more than {} MiB: the rest is not read",
            self.room >> 20
        );
        self.refuse(place, Reason::Full, text);
        ControlFlow::Break(())
    }
}

fn stamp_of(input: &Input) -> Option<u64> {
    match *input {
        Input::Configure(_) | Input::Limit { .. } => None,
        Input::Proximity { stamp_us, .. }
        | Input::Odometry { stamp_us, .. }
        | Input::Wheels { stamp_us, .. }
        | Input::Tick { stamp_us } => Some(stamp_us),
    }
}

fn is_finite(input: &Input) -> bool {
    match input {
        Input::Odometry { pose, .. } => pose.is_finite(),
        Input::Wheels { speeds, .. } => {
            speeds.left_m_per_s.is_finite() && speeds.right_m_per_s.is_finite()
        }
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HERE: Place = Place::Byte(0);

    fn tick(stamp_us: u64) -> Input {
        Input::Tick { stamp_us }
    }

    #[test]
    fn endless_inputs_end_at_the_cap() {
        let mut draft = Draft::new(Format::Stream);
        draft.room = 3 * size_of::<Input>() as u64;
        for stamp_us in 0..3 {
            assert!(
                draft
                    .take_input(HERE, Sender::Host, tick(stamp_us))
                    .is_continue()
            );
        }
        assert!(draft.take_input(HERE, Sender::Host, tick(3)).is_break());
        let recording = draft.finish();
        assert_eq!(recording.inputs.len(), 3);
        assert_eq!(recording.refusals.count_of(Reason::Full), 1);
    }

    #[test]
    fn events_of_an_hour_of_driving_are_not_cut() {
        const EVENTS: u64 = 6_100_000;
        assert!(EVENTS * size_of::<Message>() as u64 <= MOST_BYTES);
    }

    #[test]
    fn entry_is_as_small_as_the_cap_assumes() {
        assert!(size_of::<Input>() <= 128, "{}", size_of::<Input>());
        assert!(size_of::<Message>() <= 128, "{}", size_of::<Message>());
    }

    #[test]
    fn configuration_after_inputs_begins_the_run() {
        let mut draft = Draft::new(Format::Stream);
        let config = Config::default();
        assert!(
            draft
                .take_input(HERE, Sender::Host, tick(9_000_000))
                .is_continue()
        );
        assert!(
            draft
                .take_input(HERE, Sender::Host, Input::Configure(config))
                .is_continue()
        );
        assert!(draft.take_input(HERE, Sender::Host, tick(5)).is_continue());
        assert!(
            draft
                .take_input(HERE, Sender::Host, Input::Configure(config))
                .is_break()
        );
        let recording = draft.finish();
        assert_eq!(recording.config, Some(config));
        assert_eq!(recording.inputs, [tick(5)]);
        assert_eq!(recording.segments, 1);
        assert_eq!(recording.refusals.count_of(Reason::Forgotten), 1);
        assert_eq!(recording.refusals.count_of(Reason::SecondRun), 1);
    }
}
