//! The result of one pass over a source: everything but its rows.

use std::io::Read;

use amiro_ipf::link::Message;
use amiro_ipf::node::{Config, Event};

use super::entries::Entries;
use super::plausibility::UnitCheck;
use super::rules::{Entry, Sender};
use super::{Format, GroundTruth, LogError, Problem, Refusals, amiro_text};

/// A recording without its rows: its size does not depend on the recording's length.
#[derive(Clone, Debug, PartialEq)]
pub struct Overview {
    /// The configuration that the inputs were recorded under, if the source has one.
    pub config: Option<Config>,
    /// The simulator's ground truth, without the true poses; `None` for a real drive.
    pub truth: Option<GroundTruth>,
    /// Lines and frames that were not used, with place and reason.
    pub refusals: Refusals,
    /// How the source was written.
    pub format: Format,
    /// Stretches without a gap of more than a second between inputs; 0 without inputs.
    pub segments: usize,
    /// Number of inputs.
    pub inputs: u64,
    /// Number of messages of a board.
    pub messages: u64,
    /// Number of true poses.
    pub true_poses: u64,
    /// Number of messages that end a step of a filter.
    pub steps: u64,
    /// Number of messages that report the end of a board's last boot.
    pub post_mortems: u64,
}

/// From which entry on the entries of each kind are used; entries count from 0.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Uses {
    inputs_from: u64,
    board_inputs_from: u64,
    events_from: u64,
    true_poses_from: u64,
}

impl Uses {
    fn note(&mut self, number: u64, entry: &Entry) {
        match entry {
            Entry::Configuration => {
                self.inputs_from = number;
                self.board_inputs_from = number;
                self.events_from = number;
            }
            Entry::BoardBegins => {
                self.board_inputs_from = number;
                self.events_from = number;
            }
            Entry::TruthBegins => self.true_poses_from = number,
            Entry::Input(..) | Entry::Message(_) | Entry::TruePose(..) => {}
        }
    }

    /// Whether an entry is used, once the whole source was noted.
    pub(super) fn keep(&self, number: u64, entry: &Entry) -> bool {
        let from = match entry {
            Entry::Input(Sender::Host, _) => self.inputs_from,
            Entry::Input(Sender::Board, _) => self.board_inputs_from,
            Entry::Message(Message::Boot(_)) => 0,
            Entry::Message(_) => self.events_from,
            Entry::TruePose(..) => self.true_poses_from,
            Entry::Configuration | Entry::BoardBegins | Entry::TruthBegins => return false,
        };
        number >= from
    }
}

/// The unit checks over the inputs that are used so far.
#[derive(Debug)]
struct UnitChecks {
    format: Format,
    all: UnitCheck,
    /// The same without the board's inputs, once there are any that may be dropped.
    of_host: Option<UnitCheck>,
    /// Whether the board has taken the configuration: no input is dropped any more.
    has_begun: bool,
}

impl UnitChecks {
    fn new(format: Format) -> Self {
        Self {
            format,
            all: UnitCheck::new(format),
            of_host: None,
            has_begun: false,
        }
    }

    fn take(&mut self, entry: &Entry) {
        match entry {
            Entry::Input(Sender::Board, input) => {
                if !self.has_begun {
                    self.of_host.get_or_insert_with(|| self.all.clone());
                }
                self.all.take(input);
            }
            Entry::Input(Sender::Host, input) => {
                self.all.take(input);
                if let Some(of_host) = &mut self.of_host {
                    of_host.take(input);
                }
            }
            Entry::Configuration => *self = Self::new(self.format),
            Entry::BoardBegins => {
                self.has_begun = true;
                if let Some(of_host) = self.of_host.take() {
                    self.all = of_host;
                }
            }
            Entry::Message(_) | Entry::TruePose(..) | Entry::TruthBegins => {}
        }
    }
}

/// Messages of the kinds that an overview counts.
#[derive(Clone, Copy, Debug, Default)]
struct MessageCounts {
    steps: u64,
    post_mortems: u64,
}

impl MessageCounts {
    fn take(&mut self, entry: &Entry) {
        match entry {
            Entry::Message(Message::Event(Event::StepDone(_))) => self.steps += 1,
            Entry::Message(Message::PostMortem(_)) => self.post_mortems += 1,
            Entry::Configuration | Entry::BoardBegins => *self = Self::default(),
            _ => {}
        }
    }
}

/// Reads a source to its end and passes on its entries; those that [`Uses`] keeps are used.
///
/// # Errors
/// A source that cannot be read, is no recording, has nothing usable, or whose numbers
/// cannot be in the units that they claim.
pub(super) fn inspect<R: Read>(
    mut entries: Entries<R>,
    mut hand_on: impl FnMut(Entry),
) -> Result<(Overview, Uses), LogError> {
    let format = entries.rules().format;
    let mut uses = Uses::default();
    let mut units = UnitChecks::new(format);
    let mut counts = MessageCounts::default();
    let mut number = 0;
    while let Some(entry) = entries.next()? {
        uses.note(number, &entry);
        units.take(&entry);
        counts.take(&entry);
        number += 1;
        hand_on(entry);
    }
    let rules = entries.rules();
    let (inputs, messages) = (rules.inputs(), rules.messages());
    let (true_poses, segments) = (rules.true_poses(), rules.segments());
    let found = match format {
        Format::AmiroText if inputs == 0 => amiro_text::unit_check(entries.head()),
        _ => units.all.finish(),
    };
    if let Some(found) = found {
        return Err(entries.error(Problem::ImplausibleUnits { found }));
    }
    if inputs == 0 && messages == 0 {
        let refusals = rules.refusals.clone();
        return Err(entries.error(Problem::NothingUsable(refusals)));
    }
    let rules = entries.into_rules();
    let overview = Overview {
        config: rules.config,
        truth: rules.truth,
        refusals: rules.refusals,
        format,
        segments,
        inputs,
        messages,
        true_poses,
        steps: counts.steps,
        post_mortems: counts.post_mortems,
    };
    Ok((overview, uses))
}
