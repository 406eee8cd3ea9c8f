//! The controller of the CAN unit: initialisation, joining the bus, bus-off.

use super::{CanFrame, CanIdentifier, CanState, StandardId, filters};
use heapless::Vec;

use super::bit_timing::BitTiming;
use super::mailboxes::Mailboxes;
use super::registers::{
    ABOM, AWUM, BOFF, BOFIE, CanRegister, CanRegisters, ERRI, FMP0, FMPIE0, FOVR0, IDE, INAK, INRQ,
    RFOM0, RTR, TXFP,
};

/// A unit that has not entered initialisation after this time is absent, microseconds. A
/// present one needs the rest of a frame, 0.13 ms, at most.
pub(super) const ENTER_TIMEOUT_US: u64 = 100_000;

/// Between two attempts at an absent unit, microseconds.
pub(super) const RETRY_US: u64 = 1_000_000;

/// Frames of one call of [`CanController::receive`]: as many as the FIFO holds.
pub(super) const MAX_FRAMES: usize = 3;

/// Settings of the unit: it rejoins after bus-off, wakes up, sends in order. The FIFO is
/// not locked: when it is full the newest frame replaces the last.
const SETTINGS: u32 = ABOM | AWUM | TXFP;

/// State and counters of the controller; counters saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CanControllerHealth {
    /// The unit's state.
    pub state: CanState,
    /// Frames taken from the FIFO.
    pub received: u32,
    /// Times that the FIFO was full and lost a frame or more.
    pub overruns: u32,
    /// Frames that were sent and acknowledged.
    pub sent: u32,
    /// Frames given up after 20 ms in a mailbox.
    pub given_up: u32,
    /// Frames refused because no mailbox was free or the bus was not joined.
    pub refused: u32,
    /// Times that the unit went off the bus.
    pub bus_offs: u32,
    /// The unit's counter of receive errors.
    pub receive_errors: u8,
    /// The unit's counter of transmit errors, up to 255.
    pub transmit_errors: u8,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// Before the first poll.
    Off,
    /// Initialisation is requested.
    Entering { since_us: u64 },
    /// Set up; waits for eleven recessive bits.
    Joining,
    /// On the bus, or bus-off.
    On,
    /// Did not answer.
    Absent { since_us: u64 },
}

/// A bxCAN unit on the robot's bus.
pub struct CanController<R> {
    registers: R,
    timing: Option<BitTiming>,
    phase: Phase,
    mailboxes: Mailboxes,
    health: CanControllerHealth,
}

impl<R: CanRegisters> CanController<R> {
    /// A unit before its first poll. Without a timing for the board's clock it stays
    /// [`CanState::Absent`]: a wrong timing would disturb the bus.
    pub const fn new(registers: R, timing: Option<BitTiming>) -> Self {
        Self {
            registers,
            timing,
            phase: Phase::Off,
            mailboxes: Mailboxes::new(),
            health: CanControllerHealth {
                state: CanState::Absent,
                received: 0,
                overruns: 0,
                sent: 0,
                given_up: 0,
                refused: 0,
                bus_offs: 0,
                receive_errors: 0,
                transmit_errors: 0,
            },
        }
    }

    /// Takes the next step towards the bus, or checks the state on it; at most thirty
    /// register accesses. To be called about every 10 ms.
    pub fn poll(&mut self, now_us: u64) {
        match self.phase {
            Phase::Off => self.enter(now_us),
            Phase::Entering { since_us } => self.await_initialisation(now_us, since_us),
            Phase::Joining => self.await_bus(),
            Phase::On => self.check_errors(now_us),
            Phase::Absent { since_us } if now_us.saturating_sub(since_us) >= RETRY_US => {
                self.enter(now_us);
            }
            Phase::Absent { .. } => {}
        }
    }

    /// The unit's state and counters.
    pub const fn health(&self) -> &CanControllerHealth {
        &self.health
    }

    /// Takes the received frames, at most three, oldest first; for the interrupt of
    /// FIFO 0, which comes again while there are more.
    pub fn receive(&mut self) -> Vec<CanFrame, MAX_FRAMES, u8> {
        let mut frames = Vec::new();
        for _ in 0..MAX_FRAMES {
            let status = self.registers.read(CanRegister::RF0R);
            if status & FOVR0 != 0 {
                self.registers.write(CanRegister::RF0R, FOVR0);
                self.health.overruns = self.health.overruns.saturating_add(1);
            }
            // A frame that is being released would be read twice.
            if status & FMP0 == 0 || status & RFOM0 != 0 {
                break;
            }
            let frame = self.first_frame();
            self.registers.write(CanRegister::RF0R, RFOM0);
            self.health.received = self.health.received.saturating_add(1);
            // As many turns as places.
            let _ = frames.push(frame);
        }
        frames
    }

    /// Hands a frame to the unit; whether it took it. A refused frame is not kept: a newer
    /// one follows.
    pub fn transmit(&mut self, now_us: u64, frame: &CanFrame) -> bool {
        let is_taken = self.health.state == CanState::On && {
            self.check_mailboxes(now_us);
            self.mailboxes.put(&mut self.registers, now_us, frame)
        };
        if !is_taken {
            self.health.refused = self.health.refused.saturating_add(1);
        }
        is_taken
    }

    fn enter(&mut self, now_us: u64) {
        if self.timing.is_none() {
            return;
        }
        // This also clears the sleep request that a reset sets.
        self.registers.write(CanRegister::MCR, SETTINGS | INRQ);
        self.phase = Phase::Entering { since_us: now_us };
        self.health.state = CanState::Joining;
    }

    fn await_initialisation(&mut self, now_us: u64, since_us: u64) {
        let Some(timing) = self.timing else { return };
        if self.registers.read(CanRegister::MSR) & INAK != 0 {
            self.registers.write(CanRegister::BTR, timing.bits());
            self.registers.write(CanRegister::IER, FMPIE0 | BOFIE);
            filters::set(&mut self.registers);
            self.registers.write(CanRegister::MCR, SETTINGS);
            self.phase = Phase::Joining;
        } else if now_us.saturating_sub(since_us) >= ENTER_TIMEOUT_US {
            self.phase = Phase::Absent { since_us: now_us };
            self.health.state = CanState::Absent;
        }
    }

    /// On a bus that is held dominant the unit stays in this phase.
    fn await_bus(&mut self) {
        if self.registers.read(CanRegister::MSR) & INAK == 0 {
            self.phase = Phase::On;
            self.health.state = CanState::On;
        }
    }

    fn check_errors(&mut self, now_us: u64) {
        let errors = self.registers.read(CanRegister::ESR);
        [self.health.receive_errors, self.health.transmit_errors] =
            [(errors >> 24) as u8, (errors >> 16) as u8];
        // The flag stays set when the unit rejoins before the next poll.
        if self.registers.read(CanRegister::MSR) & ERRI != 0 {
            self.registers.write(CanRegister::MSR, ERRI);
            self.health.bus_offs = self.health.bus_offs.saturating_add(1);
        }
        self.health.state = if errors & BOFF != 0 {
            CanState::BusOff
        } else {
            CanState::On
        };
        self.check_mailboxes(now_us);
    }

    fn check_mailboxes(&mut self, now_us: u64) {
        let outcome = self.mailboxes.check(&mut self.registers, now_us);
        self.health.sent = self.health.sent.saturating_add(outcome.sent);
        self.health.given_up = self.health.given_up.saturating_add(outcome.given_up);
    }

    fn first_frame(&self) -> CanFrame {
        let head = self.registers.read(CanRegister::RI0R);
        let length = self.registers.read(CanRegister::RDT0R);
        let [a, b, c, d] = self.registers.read(CanRegister::RDL0R).to_le_bytes();
        let [e, f, g, h] = self.registers.read(CanRegister::RDH0R).to_le_bytes();
        let identifier = if head & IDE != 0 {
            CanIdentifier::Extended(head >> 3)
        } else {
            CanIdentifier::Standard(StandardId::from_bits((head >> 21) as u16))
        };
        let length_code = (length & 0xf) as u8;
        CanFrame::received(
            identifier,
            head & RTR != 0,
            length_code,
            [a, b, c, d, e, f, g, h],
        )
    }
}
