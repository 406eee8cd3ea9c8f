//! Connects the buses' interrupts with the acquisition and the queue to `run`.

use core::sync::atomic::{AtomicBool, Ordering};

use amiro_ipf::board::acquisition::{Acquisition, Bus, CanAction};
use amiro_ipf::board::can::CanState;
use amiro_ipf::board::health::{BusHealth, BusState, CanHealth, Health};
use amiro_ipf::board::offsets::OffsetReport;
use amiro_ipf::node::{Input, SeedSource};
use heapless::spsc::{Consumer, Producer, Queue};
use stm32f4xx_hal::pac::Interrupt;

use crate::clock::Microseconds;
use crate::hal::{AcquisitionUnits, BusMaster, Can, ShutdownLine};
use crate::requests::request_shutdown;
use amiro_ipf::board::budget::REPORT_QUEUE;
use amiro_ipf::board::i2c::{I2cMaster, TransferProgress};

/// Polls between two reports of health: 8 Hz at 2 kHz.
const HEALTH_EVERY: u32 = 250;

/// Polls between two of the CAN controller: 2 ms, a tenth of a frame's longest wait.
const CAN_EVERY: u32 = 4;

/// Whether a measurement of the offsets was requested.
static CALIBRATION_REQUESTED: AtomicBool = AtomicBool::new(false);

/// Requests a measurement of the offsets, from any task.
pub(crate) fn request_calibration() {
    CALIBRATION_REQUESTED.store(true, Ordering::Relaxed);
}

/// What the sampler reports to `run`.
pub(crate) enum Report {
    /// An input for the node.
    Input(Input),
    /// The state of the board's parts.
    Health(Health),
    /// The offsets were read, measured or refused.
    Offsets(OffsetReport),
}

/// The queue to `run`; a static of the image.
pub(crate) type Reports = Queue<Report, REPORT_QUEUE>;

/// The end of that queue that `run` takes from.
pub(crate) type Reported = Consumer<'static, Report>;

/// The acquisition, its buses and the queue to `run`, under one lock.
pub struct Sampler {
    acquisition: Acquisition,
    one: BusMaster,
    two: BusMaster,
    can: Can,
    seed: SeedSource,
    shutdown_line: ShutdownLine,
    clock: Microseconds,
    reports: Producer<'static, Report>,
    polls: u32,
}

impl Sampler {
    /// A sampler before its first transaction.
    pub(crate) fn new(
        units: AcquisitionUnits,
        clock: Microseconds,
        reports: Producer<'static, Report>,
    ) -> Self {
        Self {
            acquisition: Acquisition::new(),
            one: units.one,
            two: units.two,
            can: units.can,
            seed: units.seed,
            shutdown_line: units.shutdown_line,
            clock,
            reports,
            polls: 0,
        }
    }

    /// Serves a bus's event interrupt.
    pub(crate) fn on_event(&mut self, bus: Bus) {
        let now_us = self.clock.now();
        self.serve(bus, now_us, I2cMaster::on_event);
    }

    /// Serves a bus's error interrupt.
    pub(crate) fn on_error(&mut self, bus: Bus) {
        let now_us = self.clock.now();
        self.serve(bus, now_us, I2cMaster::on_error);
    }

    /// Takes the received frames of the CAN bus, three at most.
    pub(crate) fn on_frames(&mut self) {
        let now_us = self.clock.now();
        for frame in self.can.receive() {
            match self.acquisition.take_frame(now_us, &frame) {
                CanAction::Input(input) => self.report(Report::Input(input)),
                CanAction::Shutdown => request_shutdown(),
                CanAction::Nothing => {}
            }
        }
    }

    /// Serves deadlines every half millisecond: overdue transactions, new rounds, frames
    /// to send, reports.
    pub(crate) fn poll(&mut self) {
        let now_us = self.clock.now();
        self.serve(Bus::I2c1, now_us, I2cMaster::poll);
        self.serve(Bus::I2c2, now_us, I2cMaster::poll);
        if self.polls.is_multiple_of(CAN_EVERY) {
            self.can.poll(now_us);
        }
        if self.shutdown_line.is_pulled() {
            request_shutdown();
        }
        if self.can.health().state == CanState::On
            && let Some(frame) = self.acquisition.frame_due(now_us)
        {
            // A frame without a mailbox is counted there.
            self.can.transmit(now_us, &frame);
        }
        if CALIBRATION_REQUESTED.swap(false, Ordering::Relaxed) {
            self.acquisition.calibrate();
        }
        if let Some(input) = self.acquisition.poll(now_us) {
            self.report(Report::Input(input));
        }
        if let Some(offsets) = self.acquisition.take_offsets() {
            self.report(Report::Offsets(offsets));
        }
        self.polls = self.polls.wrapping_add(1);
        if self.polls.is_multiple_of(HEALTH_EVERY) {
            let health = self.health(now_us);
            self.report(Report::Health(health));
        }
    }

    /// Calls a bus's master, hands on the transaction that ended with the call and begins
    /// the next one.
    ///
    /// On a bus that is held low every transaction ends at once; the acquisition then has no
    /// further one after one or two.
    fn serve(
        &mut self,
        bus: Bus,
        now_us: u64,
        call: impl FnOnce(&mut BusMaster, u64) -> TransferProgress,
    ) {
        let acquisition = &mut self.acquisition;
        let master = match bus {
            Bus::I2c1 => &mut self.one,
            Bus::I2c2 => &mut self.two,
        };
        let mut progress = call(master, now_us);
        loop {
            match progress {
                TransferProgress::Running | TransferProgress::Refused => return,
                TransferProgress::Done => acquisition.answer(bus, now_us, master.result()),
                TransferProgress::Idle => {}
            }
            let Some(transaction) = acquisition.next(bus, now_us) else {
                return;
            };
            progress = master.begin(&transaction, now_us);
        }
    }

    fn health(&self, now_us: u64) -> Health {
        let [one, two] = self.acquisition.buses();
        let can = self.can.health();
        Health {
            sensors: self.acquisition.sensors(now_us),
            buses: [bus_health(one, &self.one), bus_health(two, &self.two)],
            can: CanHealth {
                state: can.state,
                overruns: narrow(can.overruns),
                bus_offs: narrow(can.bus_offs),
                unsent: narrow(can.given_up.saturating_add(can.refused)),
                ..self.acquisition.can()
            },
            seed: self.seed,
            offsets: self.acquisition.offset_origin(),
        }
    }

    /// Reports to `run`. A report without room is lost; the next reading or pose follows
    /// soon. The queue holds the reports of the longest step.
    fn report(&mut self, report: Report) {
        let _ = self.reports.enqueue(report);
        rtic::pend(Interrupt::TIM8_UP_TIM13);
    }
}

/// A bus's health from the acquisition, with its master's state.
fn bus_health(known: BusHealth, master: &BusMaster) -> BusHealth {
    BusHealth {
        state: if master.is_held_low() {
            BusState::HeldLow
        } else {
            known.state
        },
        recoveries: master.counters().recoveries,
        ..known
    }
}

fn narrow(count: u32) -> u16 {
    u16::try_from(count).unwrap_or(u16::MAX)
}
