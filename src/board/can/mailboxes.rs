//! Frames that wait to be sent: three places in the unit.

use super::{CanFrame, CanIdentifier};

use super::registers::{CanRegister, CanRegisters, IDE, RTR, TXRQ};

/// Longest wait of a frame, microseconds; whatever it says is old by then.
pub(super) const MOST_WAIT_US: u64 = 20_000;

/// TSR: the mailbox's request is done; written to clear what is known of it.
const fn completed(mailbox: usize) -> u32 {
    1 << (8 * mailbox)
}

/// TSR: the request ended with the frame on the bus.
const fn sent(mailbox: usize) -> u32 {
    1 << (8 * mailbox + 1)
}

/// TSR: give the request up.
const fn abort(mailbox: usize) -> u32 {
    1 << (8 * mailbox + 7)
}

/// TSR: the mailbox is empty.
const fn empty(mailbox: usize) -> u32 {
    1 << (26 + mailbox)
}

/// What became of the frames since the last look.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Outcome {
    /// Frames that somebody acknowledged.
    pub(super) sent: u32,
    /// Frames that waited too long or were lost.
    pub(super) given_up: u32,
}

/// Since when the frame in each mailbox waits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mailboxes {
    since_us: [Option<u64>; 3],
}

impl Mailboxes {
    /// Three mailboxes that hold nothing of ours.
    pub(super) const fn new() -> Self {
        Self {
            since_us: [None; 3],
        }
    }

    /// Puts a frame into a free mailbox; whether there was one.
    pub(super) fn put<R: CanRegisters>(
        &mut self,
        registers: &mut R,
        now_us: u64,
        frame: &CanFrame,
    ) -> bool {
        let status = registers.read(CanRegister::TSR);
        let places = self.since_us.iter_mut().zip(CanRegister::MAILBOXES);
        for (mailbox, (since_us, [identifier, length, low, high])) in places.enumerate() {
            if since_us.is_some() || status & empty(mailbox) == 0 {
                continue;
            }
            let [a, b, c, d, e, f, g, h] = frame.bytes();
            registers.write(length, u32::from(frame.length()));
            registers.write(low, u32::from_le_bytes([a, b, c, d]));
            registers.write(high, u32::from_le_bytes([e, f, g, h]));
            registers.write(identifier, identifier_bits(frame) | TXRQ);
            *since_us = Some(now_us);
            return true;
        }
        false
    }

    /// Looks which requests are done and gives up those that wait for too long.
    ///
    /// A request that is given up in the middle of its frame ends with it, perhaps well.
    pub(super) fn look<R: CanRegisters>(&mut self, registers: &mut R, now_us: u64) -> Outcome {
        let mut outcome = Outcome::default();
        let status = registers.read(CanRegister::TSR);
        for (mailbox, place) in self.since_us.iter_mut().enumerate() {
            let Some(since_us) = *place else { continue };
            if status & empty(mailbox) != 0 {
                let is_sent = status & sent(mailbox) != 0;
                outcome.sent += u32::from(is_sent);
                outcome.given_up += u32::from(!is_sent);
                registers.write(CanRegister::TSR, completed(mailbox));
                *place = None;
            } else if now_us.saturating_sub(since_us) >= MOST_WAIT_US {
                registers.write(CanRegister::TSR, abort(mailbox));
            }
        }
        outcome
    }
}

fn identifier_bits(frame: &CanFrame) -> u32 {
    let bits = match frame.identifier() {
        CanIdentifier::Standard(identifier) => u32::from(identifier.bits()) << 21,
        CanIdentifier::Extended(identifier) => identifier << 3 | IDE,
    };
    if frame.is_remote() { bits | RTR } else { bits }
}
