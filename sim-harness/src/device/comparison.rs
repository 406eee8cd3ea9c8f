//! Compares a board's run with the host's own, step by step, by the payloads' bytes.

use amiro_ipf::BUILD_ID;
use amiro_ipf::link::{Boot, MessageRef};
use amiro_ipf::node::{Event, InputError, Particles, StepBegun, StepDone, Walls};

use super::expected::{ExpectedRun, ExpectedStep, hash};
use super::{AnswerAudit, Equality, FrameTally, Verdict};

/// The host's run, and its comparison with a board's or a recorded run.
///
/// All of the host's run comes first, then all of the other. A message is compared by a
/// 64-bit hash of its payload; the hashes of a run of an hour, 50 MB, lie in a temporary
/// file. Particle messages may be missing, since a board drops them when its line is slow,
/// and walls messages, since each costs only itself: the comparison continues at the next
/// message that arrived, and the verdict reports the gap.
#[derive(Debug, Default)]
pub struct Comparison {
    expected: ExpectedRun,
    /// Number of odometry resets in the other run.
    breaks: usize,
    /// The step whose messages come now.
    current: Option<CurrentStep>,
    steps: usize,
    digests: usize,
    batches: usize,
    particles: usize,
    lost_batches: u64,
    walls: usize,
    lost_walls: u64,
    compared: u64,
    differs: Option<Difference>,
    refusals: Vec<(usize, InputError)>,
    differs_in_answers: Option<String>,
    answers: AnswerAudit,
}

/// Progress of a step.
#[derive(Clone, Copy, Debug)]
struct CurrentStep {
    index: usize,
    /// Whether its walls message was met, or counted as lost.
    has_walls: bool,
    /// The next particle message, by its place in the step.
    next: usize,
    is_done: bool,
}

/// Where two runs first differ.
#[derive(Clone, Debug, PartialEq)]
struct Difference {
    step: Option<u32>,
    text: String,
}

impl Comparison {
    /// Takes an event of the host's run.
    ///
    /// Step, walls and particle messages and odometry resets are compared; boot,
    /// configuration, status, health, offsets and post-mortem are not.
    pub fn expect(&mut self, event: &Event) {
        match event {
            Event::StepBegun(_) => self.expected.begin_step(hash(event)),
            Event::Particles(_) => {
                if let Some(step) = self.expected.open_step() {
                    step.particles.push(hash(event));
                }
            }
            Event::Walls(_) => {
                if let Some(step) = self.expected.open_step() {
                    step.walls = Some(hash(event));
                }
            }
            Event::StepDone(_) => {
                if let Some(step) = self.expected.open_step() {
                    step.done = hash(event);
                }
            }
            Event::OdometryReset { .. } => self.expected.break_off(hash(event)),
            _ => {}
        }
    }

    /// Takes an event of the board's run.
    pub fn meet<'m>(&mut self, message: impl Into<MessageRef<'m>>) {
        if let MessageRef::Event(event) = message.into() {
            self.meet_event(event);
        }
    }

    fn meet_event(&mut self, event: &Event) {
        match event {
            Event::StepBegun(step) => self.meet_begin(step, hash(event)),
            Event::Walls(walls) => self.meet_walls(walls, hash(event)),
            Event::Particles(batch) => self.meet_particles(batch, hash(event)),
            Event::StepDone(done) => self.meet_end(done, hash(event)),
            Event::OdometryReset { .. } => {
                if self.expected.next_break() != Some(hash(event)) {
                    let step = self.current.map(|current| current.index);
                    self.differ(step, "odometry broke off");
                }
                self.breaks += 1;
            }
            _ => return,
        }
        self.compared += 1;
    }

    fn meet_begin(&mut self, step: &StepBegun, found: u64) {
        if !self.go_to(step.index as usize, "step begins") {
            return;
        }
        let expected = self.expected.step(step.index as usize);
        if expected.is_some_and(|expected| expected.begun == found) {
            self.steps += 1;
        } else {
            self.differ(Some(step.index as usize), "step begins");
        }
    }

    fn meet_walls(&mut self, walls: &Walls, found: u64) {
        let index = walls.index as usize;
        let is_current = self
            .current
            .is_some_and(|current| current.index == index && !current.is_done);
        if !is_current {
            if !self.go_to(index, "walls") {
                return;
            }
            self.differ(Some(index), "its begin never came");
        }
        let expected = self.expected.step(index).and_then(|step| step.walls);
        let Some(current) = &mut self.current else {
            return;
        };
        let is_in_order = current.next == 0 && !current.has_walls;
        current.has_walls = true;
        if is_in_order && expected == Some(found) {
            self.walls += 1;
        } else {
            self.differ(Some(index), "walls");
        }
    }

    fn meet_particles(&mut self, batch: &Particles, found: u64) {
        // Those of a later step whose begin was lost are known by their content.
        let after = self.current.map_or(0, |current| current.index + 1);
        let later = after + usize::from(batch.step.wrapping_sub(after as u8));
        let is_later = |step: &ExpectedStep| step.particles.contains(&found);
        let is_of_current = self
            .current
            .is_some_and(|current| !current.is_done && current.index as u8 == batch.step);
        if !is_of_current && self.expected.step(later).is_some_and(is_later) {
            self.go_to(later, "particles");
            self.differ(Some(later), "its begin never came");
        }
        let Some(current) = &mut self.current else {
            self.differ(None, "particles came before the first step");
            return;
        };
        let index = current.index;
        let rest = self.expected.step(index).map(|step| &step.particles);
        let rest = rest.and_then(|all| all.get(current.next..));
        let place = rest.and_then(|rest| rest.iter().position(|expected| *expected == found));
        match place {
            Some(lost) if !current.is_done => {
                current.next += lost + 1;
                self.lost_batches += lost as u64;
                self.batches += 1;
                self.particles += batch.outcomes.len();
            }
            _ => {
                // It counts as the expected step, if there is one.
                let is_expected = rest.is_some_and(|rest| !rest.is_empty());
                current.next += usize::from(is_expected);
                self.differ(Some(index), "particles");
            }
        }
    }

    fn meet_end(&mut self, done: &StepDone, found: u64) {
        let index = done.index as usize;
        let is_current = self
            .current
            .is_some_and(|current| current.index == index && !current.is_done);
        if !is_current {
            if !self.go_to(index, "step done") {
                return;
            }
            self.differ(Some(index), "its begin never came");
        }
        self.lose_rest();
        if let Some(current) = &mut self.current {
            current.is_done = true;
        }
        if self
            .expected
            .step(index)
            .is_some_and(|expected| expected.done == found)
        {
            self.digests += 1;
        } else {
            self.differ(Some(index), "step done");
        }
    }

    /// Advances to a later step; `false` where there is none of this number.
    fn go_to(&mut self, index: usize, found: &str) -> bool {
        let after = self.current.map_or(0, |current| current.index + 1);
        if index >= self.expected.steps() {
            self.differ(None, &format!("{found} came after the last"));
            return false;
        }
        if index < after {
            self.differ(Some(index), &format!("{found} came again or out of order"));
            return false;
        }
        if let Some(current) = self.current.filter(|current| !current.is_done) {
            self.lose_rest();
            self.differ(Some(current.index), "its end never came");
        }
        if index > after {
            self.differ(Some(after), "it never came");
        }
        self.expected.forget_before(index);
        self.current = Some(CurrentStep {
            index,
            has_walls: false,
            next: 0,
            is_done: false,
        });
        true
    }

    /// Counts the missing walls and particle messages of the current step.
    fn lose_rest(&mut self) {
        if let Some(current) = &mut self.current
            && let Some(expected) = self.expected.step(current.index)
        {
            if expected.walls.is_some() && !current.has_walls {
                self.lost_walls += 1;
            }
            current.has_walls = true;
            let rest = expected.particles.len().saturating_sub(current.next);
            self.lost_batches += rest as u64;
            current.next += rest;
        }
    }

    fn differ(&mut self, step: Option<usize>, what: &str) {
        if self.differs.is_some() {
            return;
        }
        // As many steps as 32 bits count.
        let step = step.map(|step| step as u32);
        self.differs = Some(Difference {
            step,
            text: match step {
                Some(step) => format!("the run differs in step {step} ({what})"),
                None => what.to_owned(),
            },
        });
    }

    /// Takes why the host's node refused inputs, by the inputs' numbers, in order.
    pub fn expect_refusals(&mut self, refusals: &[(usize, InputError)]) {
        self.refusals.extend_from_slice(refusals);
    }

    /// Takes the board's answer to an input.
    pub fn meet_answer(&mut self, input: usize, refused: Option<InputError>) {
        let expected = self
            .refusals
            .binary_search_by_key(&input, |(input, _)| *input)
            .ok()
            .and_then(|place| self.refusals.get(place))
            .map(|(_, fault)| *fault);
        if expected != refused && self.differs_in_answers.is_none() {
            let words = |fault: Option<InputError>| {
                fault.map_or("taken".to_owned(), |fault| format!("refused ({fault})"))
            };
            self.differs_in_answers = Some(format!(
                "input {input} was {}, by the host's own node {}",
                words(refused),
                words(expected)
            ));
        }
    }

    /// Takes what was wrong with the board's answers as such.
    pub fn take_audit(&mut self, answers: AnswerAudit) {
        self.answers = answers;
    }

    /// The verdict over a run in lock-step, in which nothing may be lost: with the loss
    /// statistics since its greeting and the board's boot message.
    #[must_use]
    pub fn verdict(&self, boot: Option<&Boot>, tally: &FrameTally) -> Verdict {
        let mut verdict = self.verdict_of_recording();
        let reasons = &mut verdict.reasons;
        if let Some(step) = verdict.ends_within_step.take() {
            reasons.push(format!("the end of step {step} never came"));
        }
        let mut because = |count: u64, what: &str| {
            if count > 0 {
                reasons.push(format!("{count} {what}"));
            }
        };
        because(
            verdict.particle_messages_lost,
            "particle messages never came",
        );
        because(verdict.walls_messages_lost, "walls messages never came");
        because(tally.lost, "frames of the board were lost");
        because(tally.dropped, "frames were dropped by the board");
        because(
            tally.contradicted,
            "statuses of the board contradict its frames' numbers",
        );
        because(self.answers.surplus, "answers to no input of this run");
        because(self.answers.out_of_order, "answers came out of order");
        match boot {
            None => reasons.push("the board did not introduce itself".to_owned()),
            Some(boot) if boot.build_id != BUILD_ID => reasons.push(format!(
                "the board runs another build: {:016x}, the sources here are {BUILD_ID:016x}",
                boot.build_id
            )),
            Some(_) => {}
        }
        verdict.equal = verdict.reasons.is_empty();
        verdict.equality = if verdict.equal {
            Equality::Equal
        } else {
            Equality::Different
        };
        verdict
    }

    /// The verdict over recorded events, of which particle and walls messages may be missing,
    /// and the rest of the last step: a recording ends anywhere.
    #[must_use]
    pub fn verdict_of_recording(&self) -> Verdict {
        let mut reasons: Vec<String> = self
            .differs
            .iter()
            .map(|found| found.text.clone())
            .collect();
        reasons.extend(self.differs_in_answers.clone());
        if let Some(error) = self.expected.failed() {
            reasons.push(format!("the host's run could not be kept: {error}"));
        }
        let expected_steps = self.expected.steps();
        let ended = self
            .current
            .map_or(0, |current| current.index + usize::from(current.is_done));
        let is_cut = self.compared > 0 && ended + 1 == expected_steps;
        if self.digests + usize::from(is_cut) < expected_steps {
            reasons.push(format!(
                "{} of {expected_steps} digests were met",
                self.digests
            ));
        }
        if !is_cut && ended < expected_steps {
            reasons.push(format!("{} steps never ended", expected_steps - ended));
        }
        if self.breaks < self.expected.breaks() {
            reasons.push("the odometry broke off more often in the host's run".to_owned());
        }
        if self.compared == 0 {
            reasons.push("nothing was compared".to_owned());
        }
        let equality = match (reasons.is_empty(), self.lost_batches + self.lost_walls) {
            (true, 0) => Equality::Equal,
            (true, _) => Equality::ParticlesLost,
            (false, _) => Equality::Different,
        };
        Verdict {
            equality,
            equal: equality == Equality::Equal,
            // As many steps as 32 bits count.
            ends_within_step: is_cut.then_some(ended as u32),
            first_different_step: self.differs.as_ref().and_then(|found| found.step),
            steps: self.steps,
            digests: self.digests,
            particle_messages: self.batches,
            particles: self.particles,
            particle_messages_lost: self.lost_batches,
            walls_messages: self.walls,
            walls_messages_lost: self.lost_walls,
            expected_steps,
            reasons,
        }
    }
}
