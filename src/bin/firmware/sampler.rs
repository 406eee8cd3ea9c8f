//! The robot's senses between the buses' interrupts and the queue to `think`.

use core::sync::atomic::{AtomicBool, Ordering};

use amiro_ipf::can::CanState;
use amiro_ipf::driver::Bus;
use amiro_ipf::link::{BusHealth, BusState, CanHealth, Health, OffsetReport};
use amiro_ipf::node::{Input, SeedSource};
use amiro_ipf::senses::{Heard, Senses};
use heapless::spsc::{Consumer, Producer, Queue};
use stm32f4xx_hal::pac::Interrupt;

use crate::board::{BusOne, BusTwo, Can, SenseUnits, ShutdownLine};
use crate::clock::Microseconds;
use crate::watch::want_shutdown;
use amiro_ipf::board::budget::REPORT_QUEUE;
use amiro_ipf::board::i2c::{Master, Progress, Registers};

/// Patrols between two reports of health: 8 Hz at 2 kHz.
const HEALTH_EVERY: u32 = 250;

/// Patrols between two looks at the CAN unit: 2 ms, a tenth of a frame's longest wait.
const CAN_EVERY: u32 = 4;

/// Whether somebody wants the offsets measured anew.
static CALIBRATION_WANTED: AtomicBool = AtomicBool::new(false);

/// Asks for new offsets, from any task.
pub(crate) fn want_calibration() {
    CALIBRATION_WANTED.store(true, Ordering::Relaxed);
}

/// What `think` is told.
pub(crate) enum Report {
    /// An input for the node.
    Input(Input),
    /// How the parts are.
    Health(Health),
    /// The offsets were read, measured or refused.
    Offsets(OffsetReport),
}

/// The queue to `think`; a static of the image.
pub(crate) type Reports = Queue<Report, REPORT_QUEUE>;

/// The end of it that `think` has.
pub(crate) type Reported = Consumer<'static, Report>;

/// Senses, buses and the queue: whoever has it has all of them.
pub struct Sampler {
    senses: Senses,
    one: BusOne,
    two: BusTwo,
    can: Can,
    seed: SeedSource,
    shutdown_line: ShutdownLine,
    clock: Microseconds,
    reports: Producer<'static, Report>,
    patrols: u32,
}

impl Sampler {
    /// A sampler that has asked nothing yet.
    pub(crate) fn new(
        units: SenseUnits,
        clock: Microseconds,
        reports: Producer<'static, Report>,
    ) -> Self {
        Self {
            senses: Senses::new(),
            one: units.one,
            two: units.two,
            can: units.can,
            seed: units.seed,
            shutdown_line: units.shutdown_line,
            clock,
            reports,
            patrols: 0,
        }
    }

    /// Serves a bus's event interrupt.
    pub(crate) fn on_event(&mut self, bus: Bus) {
        let now_us = self.clock.now();
        let senses = &mut self.senses;
        match bus {
            Bus::I2c1 => {
                let progress = self.one.on_event(now_us);
                go_on(senses, &mut self.one, bus, progress, now_us);
            }
            Bus::I2c2 => {
                let progress = self.two.on_event(now_us);
                go_on(senses, &mut self.two, bus, progress, now_us);
            }
        }
    }

    /// Serves a bus's error interrupt.
    pub(crate) fn on_error(&mut self, bus: Bus) {
        let now_us = self.clock.now();
        let senses = &mut self.senses;
        match bus {
            Bus::I2c1 => {
                let progress = self.one.on_error(now_us);
                go_on(senses, &mut self.one, bus, progress, now_us);
            }
            Bus::I2c2 => {
                let progress = self.two.on_error(now_us);
                go_on(senses, &mut self.two, bus, progress, now_us);
            }
        }
    }

    /// Serves the robot's bus: takes the frames that came, three at most.
    pub(crate) fn on_frames(&mut self) {
        let now_us = self.clock.now();
        for frame in self.can.receive() {
            match self.senses.take_frame(now_us, &frame) {
                Heard::Input(input) => self.report(Report::Input(input)),
                Heard::Shutdown => want_shutdown(),
                Heard::Nothing => {}
            }
        }
    }

    /// Looks after time, every half millisecond: what is overdue, what is to begin, what
    /// is to be told.
    pub(crate) fn patrol(&mut self) {
        let now_us = self.clock.now();
        let progress = self.one.patrol(now_us);
        go_on(&mut self.senses, &mut self.one, Bus::I2c1, progress, now_us);
        let progress = self.two.patrol(now_us);
        go_on(&mut self.senses, &mut self.two, Bus::I2c2, progress, now_us);
        if self.patrols.is_multiple_of(CAN_EVERY) {
            self.can.patrol(now_us);
        }
        if self.shutdown_line.is_pulled() {
            want_shutdown();
        }
        if self.can.health().state == CanState::On
            && let Some(frame) = self.senses.frame_due(now_us)
        {
            // A frame without a mailbox is counted there.
            self.can.transmit(now_us, &frame);
        }
        if CALIBRATION_WANTED.swap(false, Ordering::Relaxed) {
            self.senses.calibrate();
        }
        if let Some(input) = self.senses.poll(now_us) {
            self.report(Report::Input(input));
        }
        if let Some(offsets) = self.senses.take_offsets() {
            self.report(Report::Offsets(offsets));
        }
        self.patrols = self.patrols.wrapping_add(1);
        if self.patrols.is_multiple_of(HEALTH_EVERY) {
            let health = self.health(now_us);
            self.report(Report::Health(health));
        }
    }

    fn health(&self, now_us: u64) -> Health {
        let [one, two] = self.senses.buses();
        let can = self.can.health();
        Health {
            sensors: self.senses.sensors(now_us),
            buses: [joined(one, &self.one), joined(two, &self.two)],
            can: CanHealth {
                state: can.state,
                overruns: narrow(can.overruns),
                bus_offs: narrow(can.bus_offs),
                unsent: narrow(can.given_up.saturating_add(can.refused)),
                ..self.senses.can()
            },
            seed: self.seed,
            offsets: self.senses.offset_origin(),
        }
    }

    /// Tells `think`. A report without room is lost: a reading or a pose of which the
    /// next one comes soon. The queue holds the longest step's.
    fn report(&mut self, report: Report) {
        let _ = self.reports.enqueue(report);
        rtic::pend(Interrupt::TIM8_UP_TIM13);
    }
}

/// What the senses know of a bus, with what its master knows.
fn joined<R: Registers>(known: BusHealth, master: &Master<R>) -> BusHealth {
    BusHealth {
        state: if master.is_dead() {
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

/// Hands on what has ended on a bus and begins what comes next.
///
/// On a bus that is held low every transaction ends at once; the senses then have none
/// left after one or two.
fn go_on<R: Registers>(
    senses: &mut Senses,
    master: &mut Master<R>,
    bus: Bus,
    mut progress: Progress,
    now_us: u64,
) {
    loop {
        match progress {
            Progress::Running | Progress::Refused => return,
            Progress::Done => senses.answer(bus, now_us, master.result()),
            Progress::Idle => {}
        }
        let Some(transaction) = senses.next(bus, now_us) else {
            return;
        };
        progress = master.begin(&transaction, now_us);
    }
}
