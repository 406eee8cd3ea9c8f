//! The rules that select the entries of a source's run, for all formats.

use std::collections::VecDeque;
use std::fmt::Display;
use std::ops::ControlFlow;

use amiro_ipf::geometry::Pose;
use amiro_ipf::link::Message;
use amiro_ipf::node::{Config, Event, Input};

use super::{Format, GroundTruth, Place, Reason, Refusals};

/// Stamps further apart than this begin a new segment.
const GAP_US: u64 = 1_000_000;

/// Kinds of inputs that have stamps.
const KINDS: usize = 4;

/// Which program or device sent a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sender {
    /// A host, a simulator, or the program that wrote a table.
    Host,
    /// A board; its inputs are what it read itself.
    Board,
}

/// An accepted entry, in the order of the source.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Entry {
    /// An input. Limits, which have no stamp, count as the host's.
    Input(Sender, Input),
    /// A message of a board.
    Message(Message),
    /// A true pose.
    TruePose(u64, Pose),
    /// A configuration behind inputs: no input before it is used, and of the events before
    /// it only boots.
    Configuration,
    /// The board takes the configuration: no input of the board before it is used, and of
    /// the events before it only boots.
    BoardBegins,
    /// A simulated recording begins again: no true pose before it is used.
    TruthBegins,
}

/// State of a recording's run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Run {
    /// The configuration is unknown.
    Unknown,
    /// A configuration was given. A board may be amid another run until it takes it.
    Given(Sender),
    /// A board has taken it.
    Taken,
}

/// Entries that are used so far.
#[derive(Clone, Copy, Debug, Default)]
struct EntryCounts {
    inputs: u64,
    /// Of these the board's own, while it has not taken the configuration.
    early: u64,
    messages: u64,
    /// Of these boot messages.
    boots: u64,
    true_poses: u64,
}

impl EntryCounts {
    /// Memory that these take where they are collected, bytes.
    fn bytes(&self) -> u64 {
        self.inputs * size_of::<Input>() as u64
            + self.messages * size_of::<Message>() as u64
            + self.true_poses * size_of::<(u64, Pose)>() as u64
    }

    /// Drops all messages but boot messages.
    fn keep_boots(&mut self) {
        self.messages = self.boots;
    }
}

/// Stretches without a gap between inputs.
#[derive(Clone, Copy, Debug, Default)]
struct Segments {
    count: usize,
    newest_us: Option<u64>,
}

impl Segments {
    fn take(&mut self, stamp_us: u64) {
        let is_new = self
            .newest_us
            .is_none_or(|newest_us| stamp_us.saturating_sub(newest_us) > GAP_US);
        self.count += usize::from(is_new);
        self.newest_us = self.newest_us.max(Some(stamp_us));
    }
}

/// The state of the rules amid a source: memory does not depend on the source's length.
#[derive(Debug)]
pub(super) struct Rules {
    pub(super) format: Format,
    pub(super) config: Option<Config>,
    /// Without true poses, which are entries.
    pub(super) truth: Option<GroundTruth>,
    pub(super) refusals: Refusals,
    run: Run,
    passed: VecDeque<Entry>,
    counts: EntryCounts,
    last_of_host: [Option<(u64, Input)>; KINDS],
    last_of_board: [Option<(u64, Input)>; KINDS],
    last_true_pose: Option<(u64, Pose)>,
    segments: Segments,
    /// The same without the board's inputs.
    segments_of_host: Segments,
    /// Bytes that the entries may take where they are collected.
    room: u64,
}

impl Rules {
    /// The rules at the beginning of a source whose entries may take so many bytes.
    pub(super) fn new(format: Format, room: u64) -> Self {
        Self {
            format,
            config: None,
            truth: None,
            refusals: Refusals::default(),
            run: Run::Unknown,
            passed: VecDeque::new(),
            counts: EntryCounts::default(),
            last_of_host: [None; KINDS],
            last_of_board: [None; KINDS],
            last_true_pose: None,
            segments: Segments::default(),
            segments_of_host: Segments::default(),
            room,
        }
    }

    /// The next entry that has passed.
    pub(super) fn pop(&mut self) -> Option<Entry> {
        self.passed.pop_front()
    }

    /// Inputs that are used so far.
    pub(super) fn inputs(&self) -> u64 {
        self.counts.inputs
    }

    /// Messages of a board that are used so far.
    pub(super) fn messages(&self) -> u64 {
        self.counts.messages
    }

    /// True poses that are used so far.
    pub(super) fn true_poses(&self) -> u64 {
        self.counts.true_poses
    }

    /// Stretches without a gap of more than a second between the inputs so far.
    pub(super) fn segments(&self) -> usize {
        self.segments.count
    }

    pub(super) fn refuse(&mut self, place: Place, reason: Reason, text: impl Display) {
        self.refusals.add(place, reason, text);
    }

    /// Whether a configuration or an input was taken: what a simulator writes in front of
    /// them then belongs to another run.
    pub(super) fn has_begun(&self) -> bool {
        self.run != Run::Unknown || self.counts.inputs > 0
    }

    /// Drops the ground truth so far: it belongs to an earlier recording.
    pub(super) fn forget_truth(&mut self, place: Place) {
        self.truth = None;
        self.last_true_pose = None;
        self.counts.true_poses = 0;
        self.passed.push_back(Entry::TruthBegins);
        let text = "a simulated recording begins again: the truth before it is not used";
        self.refuse(place, Reason::BeforeConfiguration, text);
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
                self.pass_input(Sender::Host, input);
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
        self.segments.take(stamp_us);
        match sender {
            Sender::Host => self.segments_of_host.take(stamp_us),
            Sender::Board => self.counts.early += u64::from(self.run != Run::Taken),
        }
        self.pass_input(sender, input);
        ControlFlow::Continue(())
    }

    fn pass_input(&mut self, sender: Sender, input: Input) {
        self.counts.inputs += 1;
        self.passed.push_back(Entry::Input(sender, input));
    }

    /// Takes the first legal configuration; everything before it is dropped, as a node does.
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
        if self.config.is_some() {
            let text = "a second configuration: what follows is another run";
            self.refuse(place, Reason::SecondRun, text);
            return ControlFlow::Break(());
        }
        self.config = Some(config);
        self.run = Run::Given(sender);
        let forgotten = self.counts.inputs;
        if forgotten == 0 {
            return ControlFlow::Continue(());
        }
        self.counts.inputs = 0;
        self.counts.early = 0;
        self.counts.keep_boots();
        self.segments = Segments::default();
        self.segments_of_host = Segments::default();
        self.last_of_host = [None; KINDS];
        self.last_of_board = [None; KINDS];
        self.passed.push_back(Entry::Configuration);
        self.refuse(
            place,
            Reason::BeforeConfiguration,
            format_args!("a configuration, so the {forgotten} inputs before it are not used"),
        );
        ControlFlow::Continue(())
    }

    /// Takes a board's message; breaks where another run begins.
    pub(super) fn take_message(&mut self, place: Place, message: Message) -> ControlFlow<()> {
        self.make_room(place)?;
        if let Message::Event(Event::Configured(config)) = message {
            match self.run {
                Run::Given(_) if self.config == Some(config) => self.begin_run(place),
                // Of the run before, or of one whose beginning is not here.
                Run::Given(Sender::Host) | Run::Unknown => {}
                Run::Given(Sender::Board) | Run::Taken => {
                    let text = "the board takes a configuration: what follows is another run";
                    self.refuse(place, Reason::SecondRun, text);
                    return ControlFlow::Break(());
                }
            }
        }
        self.counts.messages += 1;
        self.counts.boots += u64::from(matches!(message, Message::Boot(_)));
        self.passed.push_back(Entry::Message(message));
        ControlFlow::Continue(())
    }

    /// The board takes the configuration: its events and inputs before are of another run.
    fn begin_run(&mut self, place: Place) {
        self.run = Run::Taken;
        self.last_of_board = [None; KINDS];
        self.counts.keep_boots();
        self.passed.push_back(Entry::BoardBegins);
        let forgotten = std::mem::take(&mut self.counts.early);
        if forgotten == 0 {
            return;
        }
        self.counts.inputs -= forgotten;
        self.segments = self.segments_of_host;
        self.refuse(
            place,
            Reason::BeforeConfiguration,
            format_args!("{forgotten} inputs of the run that the board was amid are not used"),
        );
    }

    /// Takes a true pose.
    pub(super) fn take_true_pose(
        &mut self,
        place: Place,
        stamp_us: u64,
        pose: Pose,
    ) -> ControlFlow<()> {
        self.make_room(place)?;
        self.truth();
        match self.last_true_pose {
            _ if !pose.is_finite() => {
                self.refuse(place, Reason::NotFinite, "a number is not finite");
            }
            Some(last) if last == (stamp_us, pose) => {
                self.refuse(place, Reason::Repeated, "repeats the true pose before");
            }
            Some((last_us, _)) if stamp_us < last_us => {
                self.refuse_backward(place, stamp_us, last_us);
            }
            _ => {
                self.last_true_pose = Some((stamp_us, pose));
                self.counts.true_poses += 1;
                self.passed.push_back(Entry::TruePose(stamp_us, pose));
            }
        }
        ControlFlow::Continue(())
    }

    /// The ground truth, which from now on the recording has.
    pub(super) fn truth(&mut self) -> &mut GroundTruth {
        self.truth.get_or_insert_with(GroundTruth::default)
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

    fn make_room(&mut self, place: Place) -> ControlFlow<()> {
        if self.counts.bytes() < self.room {
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
        let mut rules = Rules::new(Format::Stream, 3 * size_of::<Input>() as u64);
        for stamp_us in 0..3 {
            assert!(
                rules
                    .take_input(HERE, Sender::Host, tick(stamp_us))
                    .is_continue()
            );
        }
        assert!(rules.take_input(HERE, Sender::Host, tick(3)).is_break());
        assert_eq!(rules.inputs(), 3);
        assert_eq!(rules.refusals.count_of(Reason::Full), 1);
    }

    #[test]
    fn configuration_after_inputs_begins_the_run() {
        let mut rules = Rules::new(Format::Stream, u64::MAX);
        let config = Config::default();
        assert!(
            rules
                .take_input(HERE, Sender::Host, tick(9_000_000))
                .is_continue()
        );
        assert!(
            rules
                .take_input(HERE, Sender::Host, Input::Configure(config))
                .is_continue()
        );
        assert!(rules.take_input(HERE, Sender::Host, tick(5)).is_continue());
        assert!(
            rules
                .take_input(HERE, Sender::Host, Input::Configure(config))
                .is_break()
        );
        assert_eq!(rules.config, Some(config));
        let passed: Vec<_> = std::iter::from_fn(|| rules.pop()).collect();
        let input = |stamp_us| Entry::Input(Sender::Host, tick(stamp_us));
        assert_eq!(passed, [input(9_000_000), Entry::Configuration, input(5)]);
        assert_eq!((rules.inputs(), rules.segments()), (1, 1));
        assert_eq!(rules.refusals.count_of(Reason::BeforeConfiguration), 1);
        assert_eq!(rules.refusals.count_of(Reason::SecondRun), 1);
    }
}
