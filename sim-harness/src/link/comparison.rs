//! Holds a board's run against the host's own, payload byte for payload byte.

use std::fmt;

use amiro_ipf::BUILD_ID;
use amiro_ipf::event::{BoardStatus, Boot, Event};
use amiro_ipf::fault::Fault;

/// The host's events of a run, waiting to be met in the same order.
#[derive(Debug, Default)]
pub struct Comparison {
    expected: Vec<Event>,
    next: usize,
    steps: usize,
    batches: usize,
    digests: usize,
    particles: usize,
    differs: Option<Difference>,
    refusals: Vec<(usize, Fault)>,
    differs_in_answers: Option<String>,
    board: BoardStatus,
}

/// Where a board and the host first part.
#[derive(Clone, Debug, PartialEq)]
struct Difference {
    message: usize,
    step: Option<u32>,
    expected: Option<&'static str>,
    found: &'static str,
}

/// What a comparison found.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Verdict {
    /// Whether everything was compared and equal.
    pub equal: bool,
    /// Step messages compared equal, the begin of each.
    pub steps: usize,
    /// Digests compared equal.
    pub digests: usize,
    /// Particle messages compared equal.
    pub particle_messages: usize,
    /// Particle outcomes in them.
    pub particles: usize,
    /// Steps that the host computed.
    pub expected_steps: usize,
    /// Why it is not equal.
    pub reasons: Vec<String>,
}

/// What is compared: step and particle messages, and where the odometry broke off. Of
/// answers it is compared whether and why inputs were refused; boot and status are not.
fn is_compared(event: &Event) -> Option<&'static str> {
    match event {
        Event::StepBegun(_) => Some("step begins"),
        Event::Particles(_) => Some("particles"),
        Event::StepDone(_) => Some("step done"),
        Event::BrokeOff { .. } => Some("odometry broke off"),
        Event::Boot(_)
        | Event::Configured(_)
        | Event::Answer { .. }
        | Event::Status(_)
        | Event::Health(_)
        | Event::Offsets(_)
        | Event::PostMortem(_)
        | Event::Supervision(_) => None,
    }
}

/// The payload's bytes: floats compare by their bits, not by their value.
fn payload(event: &Event) -> Vec<u8> {
    let mut bytes = [0; amiro_ipf::wire::MAX_FRAME];
    // No event is larger than a frame.
    postcard::to_slice(event, &mut bytes).map_or_else(|_| Vec::new(), |slice| slice.to_vec())
}

impl Comparison {
    /// Takes an event of the host's run.
    pub fn expect(&mut self, event: &Event) {
        if is_compared(event).is_some() {
            self.expected.push(event.clone());
        }
    }

    /// Takes an event of the board's run.
    pub fn meet(&mut self, event: &Event) {
        if let Event::Status(status) = event {
            self.board = status.board;
        }
        let Some(found) = is_compared(event) else {
            return;
        };
        let expected = self.expected.get(self.next);
        if expected.map(payload) == Some(payload(event)) {
            match event {
                Event::StepBegun(_) => self.steps += 1,
                Event::StepDone(_) => self.digests += 1,
                Event::Particles(batch) => {
                    self.batches += 1;
                    self.particles += batch.outcomes.len();
                }
                _ => {}
            }
        } else if self.differs.is_none() {
            self.differs = Some(Difference {
                message: self.next,
                step: self
                    .expected
                    .iter()
                    .take(self.next + 1)
                    .rev()
                    .find_map(step_of),
                expected: expected.and_then(is_compared),
                found,
            });
        }
        self.next += 1;
    }

    /// Takes why the host's node refused inputs, by the inputs' numbers, in order.
    pub fn expect_refusals(&mut self, refusals: &[(usize, Fault)]) {
        self.refusals.extend_from_slice(refusals);
    }

    /// Takes the board's answer to an input.
    pub fn meet_answer(&mut self, input: usize, refused: Option<Fault>) {
        let expected = self
            .refusals
            .binary_search_by_key(&input, |(input, _)| *input)
            .ok()
            .and_then(|place| self.refusals.get(place))
            .map(|(_, fault)| *fault);
        if expected != refused && self.differs_in_answers.is_none() {
            let words = |fault: Option<Fault>| {
                fault.map_or("taken".to_owned(), |fault| format!("refused ({fault})"))
            };
            self.differs_in_answers = Some(format!(
                "input {input} was {}, by the host's own node {}",
                words(refused),
                words(expected)
            ));
        }
    }

    /// The board's side of its last status.
    #[must_use]
    pub fn board_status(&self) -> &BoardStatus {
        &self.board
    }

    /// The verdict, with what the link lost and who the board said it was.
    #[must_use]
    pub fn verdict(&self, boot: Option<&Boot>, lost_frames: u64) -> Verdict {
        let mut verdict = self.verdict_of_recording();
        let reasons = &mut verdict.reasons;
        if lost_frames > 0 {
            reasons.push(format!("{lost_frames} frames of the board were lost"));
        }
        match boot {
            None => reasons.push("the board did not introduce itself".to_owned()),
            Some(boot) if boot.build_id != BUILD_ID => reasons.push(format!(
                "the board runs another build: {:016x}, the sources here are {BUILD_ID:016x}",
                boot.build_id
            )),
            Some(_) => {}
        }
        verdict.equal = verdict.reasons.is_empty();
        verdict
    }

    /// The verdict over recorded events: whoever made them, they must be met.
    #[must_use]
    pub fn verdict_of_recording(&self) -> Verdict {
        let expected_steps = self
            .expected
            .iter()
            .filter(|event| matches!(event, Event::StepDone(_)))
            .count();
        let mut reasons = Vec::new();
        if let Some(difference) = &self.differs {
            reasons.push(difference.to_string());
        }
        reasons.extend(self.differs_in_answers.clone());
        if self.board.dropped_frames > 0 {
            let dropped = self.board.dropped_frames;
            reasons.push(format!("the board dropped {dropped} frames"));
        }
        if self.digests < expected_steps {
            reasons.push(format!(
                "{} of {expected_steps} digests were met",
                self.digests
            ));
        }
        if self.next < self.expected.len() {
            let missing = self.expected.len() - self.next;
            reasons.push(format!("{missing} messages never came"));
        }
        if self.next == 0 {
            reasons.push("nothing was compared".to_owned());
        }
        Verdict {
            equal: reasons.is_empty(),
            steps: self.steps,
            digests: self.digests,
            particle_messages: self.batches,
            particles: self.particles,
            expected_steps,
            reasons,
        }
    }
}

fn step_of(event: &Event) -> Option<u32> {
    match event {
        Event::StepBegun(step) => Some(step.index),
        _ => None,
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "message {} differs", self.message)?;
        if let Some(step) = self.step {
            write!(f, " in step {step}")?;
        }
        match self.expected {
            Some(expected) if expected == self.found => write!(f, " ({expected})"),
            Some(expected) => write!(f, " ({expected} expected, {} came)", self.found),
            None => write!(f, " ({} came after the last)", self.found),
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}: {} of {} steps, {} digests, {} particle messages with {} outcomes compared equal",
            if self.equal { "EQUAL" } else { "DIFFERENT" },
            self.steps,
            self.expected_steps,
            self.digests,
            self.particle_messages,
            self.particles
        )?;
        for reason in &self.reasons {
            write!(f, "\n  {reason}")?;
        }
        Ok(())
    }
}
