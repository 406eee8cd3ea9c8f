//! The unit's three mailboxes of frames to send.

use super::{CanFrame, CanIdentifier};

use super::registers::{CanRegister, CanRegisters, IDE, RTR, TXRQ};

/// Longest wait of a frame, microseconds; its content is outdated then.
pub(super) const MAX_WAIT_US: u64 = 20_000;

/// TSR: the mailbox's request is done; written to clear its flags.
const fn completed(mailbox: usize) -> u32 {
    1 << (8 * mailbox)
}

/// TSR: the request ended with the frame on the bus.
const fn sent(mailbox: usize) -> u32 {
    1 << (8 * mailbox + 1)
}

/// TSR: abort the request.
const fn abort(mailbox: usize) -> u32 {
    1 << (8 * mailbox + 7)
}

/// TSR: the mailbox is empty.
const fn empty(mailbox: usize) -> u32 {
    1 << (26 + mailbox)
}

/// Frames that ended since the last check.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct SendCounts {
    /// Frames that were acknowledged.
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
    /// Three mailboxes without a frame of this controller.
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

    /// Checks which requests are done and aborts those that wait too long.
    ///
    /// A request that is aborted in the middle of its frame ends with that frame, which may
    /// still be acknowledged.
    pub(super) fn check<R: CanRegisters>(&mut self, registers: &mut R, now_us: u64) -> SendCounts {
        let mut outcome = SendCounts::default();
        let status = registers.read(CanRegister::TSR);
        for (mailbox, place) in self.since_us.iter_mut().enumerate() {
            let Some(since_us) = *place else { continue };
            if status & empty(mailbox) != 0 {
                let is_sent = status & sent(mailbox) != 0;
                outcome.sent += u32::from(is_sent);
                outcome.given_up += u32::from(!is_sent);
                registers.write(CanRegister::TSR, completed(mailbox));
                *place = None;
            } else if now_us.saturating_sub(since_us) >= MAX_WAIT_US {
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
