//! The greeting of a board.

use std::time::{Duration, Instant};

use amiro_ipf::link::{Boot, Encoder, Message, Received, WIRE_VERSION};

use super::board::{BOOT_DEADLINE, HOST_BOOT_ID};
use super::greeting::{Answerer, Greeting};
use super::{Board, LinkError, LossStats, MOST_RESETS};

/// Time between two greetings of a board that does not answer.
const GREETING_PERIOD: Duration = Duration::from_millis(500);

/// Greetings without an answer after which the board counts as one of another version.
const UNANSWERED_GREETINGS: u32 = 2;

impl Board {
    /// Greets the board until it answers this session.
    ///
    /// Twice, with two random numbers; frames and bytes before the second answer, of this
    /// board or another, are not part of the session.
    ///
    /// # Errors
    /// [`LinkError::NoBoot`], [`LinkError::OtherSession`], [`LinkError::Version`],
    /// [`LinkError::KeepsResetting`], [`LinkError::MostlyNoise`], or a broken link.
    pub fn greet(&mut self) -> Result<Boot, LinkError> {
        // Bytes before the answer are not kept: there may be any number.
        self.raw.pause();
        let greeted = self.greet_within(BOOT_DEADLINE);
        self.raw.resume();
        greeted
    }

    pub(super) fn greet_within(&mut self, patience: Duration) -> Result<Boot, LinkError> {
        let deadline = Instant::now() + patience;
        let mut greeting = Greeting::default();
        let mut first = self.greet_once(&mut greeting, deadline)?;
        loop {
            let second = self.greet_once(&mut greeting, deadline)?;
            // Another boot: the first answer was of an earlier session, or the board was
            // reset between the two.
            if second.boot_id == first.boot_id {
                let boot = second.boot;
                self.greeted = Some(second);
                return Ok(boot);
            }
            first = second;
        }
    }

    /// One greeting with a number of its own, repeated until it is answered.
    fn greet_once(
        &mut self,
        greeting: &mut Greeting,
        deadline: Instant,
    ) -> Result<Answerer, LinkError> {
        *greeting = greeting.next();
        let number = (self.numbers)();
        let mut unanswered = 0;
        // Bytes sent before the board's line is up are lost, so the greeting is repeated.
        while Instant::now() < deadline {
            // Under the same number: on a slow line an answer may come after the next one.
            self.encoder = Encoder::numbered_from(HOST_BOOT_ID, number);
            self.send(&Message::Hello)?;
            let next_greeting = deadline.min(Instant::now() + GREETING_PERIOD);
            while let Some(received) = self.receive(next_greeting)? {
                if self.take_baud_warning() {
                    return Err(LinkError::MostlyNoise);
                }
                let Received::Frame { frame, .. } = received else {
                    continue;
                };
                if greeting.resets() >= MOST_RESETS {
                    return Err(greeting.failure());
                }
                if let Some(board) = greeting.take(&frame, number) {
                    check_version(&board.boot)?;
                    self.loss_stats = LossStats::after(&frame);
                    self.greeted_as = number;
                    return Ok(board);
                }
            }
            // A board of another version sends its `Boot` after a reset and may not decode
            // the greeting.
            unanswered += u32::from(greeting.last_boot().is_some());
            if unanswered == UNANSWERED_GREETINGS
                && let Some(boot) = greeting.last_boot()
            {
                check_version(boot)?;
            }
        }
        Err(greeting.failure())
    }
}

fn check_version(boot: &Boot) -> Result<(), LinkError> {
    if boot.wire_version == WIRE_VERSION {
        return Ok(());
    }
    Err(LinkError::Version {
        board: boot.wire_version,
    })
}
