//! The robot's own senses: eight sensors on two buses, odometry on a third.
//!
//! Like the node, this reads no clock and no pin. It says which transaction is next on
//! each I2C bus and takes its answer, takes the frames of the robot's bus, and gives
//! the node's inputs. What executes the transactions and moves the frames is the flash
//! image's interrupts on a robot and a loop in a simulation.

mod store;
mod update_clock;

use crate::can::{Frame, Message, RingSchedule, proximity_ring};
use crate::driver::{
    AMIRO_PLACES, Bus, BusFault, OffsetMeasurement, OffsetOrigin, Offsets, ProximityRing,
    Transaction,
};
use crate::geometry::Pose;
use crate::link::{BusHealth, BusState, CanHealth, OffsetReport, SensorHealth};
use crate::model::{SENSORS, Sample, SensorMask};
use crate::node::Input;

use store::OffsetStore;
use update_clock::UpdateClock;

pub use crate::driver::branch::ROUND_PERIOD_US as ROUND_US;
pub use update_clock::ODOMETRY_AGE_US;

/// The two I2C buses, in the order of their numbers.
pub const BUSES: [Bus; 2] = [Bus::I2c1, Bus::I2c2];

/// The bus that the memory of the offsets is on.
const STORE_BUS: Bus = Bus::I2c2;

/// A robot whose odometry changed so long ago is still taken to be moving: three frames.
const MOVING_FOR_US: u64 = 200_000;

/// Transactions in a row that fail before a bus is said to fail.
const FAILING_AFTER: u8 = 3;

/// What a frame of the robot's bus means to the rest of the board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Heard {
    /// An input for the node.
    Input(Input),
    /// The robot is to be switched off.
    Shutdown,
    /// Nothing, or nothing to anybody else.
    Nothing,
}

/// Who asked for the transaction that is under way on a bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Asker {
    #[default]
    Nobody,
    Ring,
    Store,
}

/// What is known of one bus.
#[derive(Clone, Copy, Debug, Default)]
struct Line {
    asker: Asker,
    has_worked: bool,
    held_low: bool,
    failures_in_a_row: u8,
    failed: u16,
}

/// The robot's own senses.
#[derive(Clone, Debug)]
pub struct Senses {
    ring: ProximityRing,
    store: OffsetStore,
    lines: [Line; 2],
    /// When the next round begins.
    next_round_us: u64,
    /// A round is under way and its samples were not given yet.
    is_owing: bool,
    /// A sensor has delivered since the start.
    has_delivered: bool,
    measurement: Option<OffsetMeasurement>,
    offsets: OffsetReport,
    are_offsets_new: bool,
    schedule: RingSchedule,
    updates: UpdateClock,
    last_pose: Option<Pose>,
    moved_us: Option<u64>,
    can: CanHealth,
}

impl Senses {
    /// Senses of which nothing is known yet; the first round begins at once, after the
    /// stored offsets were asked for.
    #[must_use]
    pub fn new() -> Self {
        Self {
            ring: ProximityRing::new(),
            store: OffsetStore::new(),
            lines: [Line::default(); 2],
            next_round_us: 0,
            is_owing: false,
            has_delivered: false,
            measurement: None,
            offsets: OffsetReport::default(),
            are_offsets_new: false,
            schedule: RingSchedule::default(),
            updates: UpdateClock::default(),
            last_pose: None,
            moved_us: None,
            can: CanHealth::default(),
        }
    }

    fn line_mut(&mut self, bus: Bus) -> &mut Line {
        let [one, two] = &mut self.lines;
        match bus {
            Bus::I2c1 => one,
            Bus::I2c2 => two,
        }
    }

    /// The transaction to execute now on a bus; `None` if there is none, or if the one
    /// before has not been answered. Some hundred instructions.
    pub fn next(&mut self, bus: Bus, now_us: u64) -> Option<Transaction> {
        if self.line_mut(bus).asker != Asker::Nobody {
            return None;
        }
        let (asker, transaction) = match self.ring.branch_mut(bus).next(now_us) {
            Some(transaction) => (Asker::Ring, transaction),
            None if bus == STORE_BUS => (Asker::Store, self.store.next(now_us)?),
            None => return None,
        };
        self.line_mut(bus).asker = asker;
        Some(transaction)
    }

    /// Takes the result of the transaction before on a bus. Some hundred instructions.
    pub fn answer(&mut self, bus: Bus, now_us: u64, result: Result<&[u8], BusFault>) {
        match core::mem::take(&mut self.line_mut(bus).asker) {
            Asker::Nobody => {}
            Asker::Ring => {
                self.line_mut(bus).take(result.err());
                self.ring.branch_mut(bus).answer(now_us, result);
            }
            // A memory that is writing answers to nobody: nothing is wrong with the bus.
            Asker::Store => {
                self.store.answer(now_us, result);
                self.take_stored();
            }
        }
    }

    /// Looks after time, every millisecond or more often: begins rounds, and gives the
    /// samples of each when it is over.
    ///
    /// Nothing is given until a sensor has delivered for the first time. From then on a
    /// round in which none did is given as well: the node is to know that all are dead.
    pub fn poll(&mut self, now_us: u64) -> Option<Input> {
        let is_over = BUSES.iter().all(|bus| self.ring.branch_mut(*bus).is_idle());
        let input = if self.is_owing && is_over {
            self.finish_round(now_us)
        } else {
            None
        };
        if now_us >= self.next_round_us {
            // A round that is still busy is counted by its branch and goes on.
            let moving = self.is_moving(now_us);
            for bus in BUSES {
                self.ring.branch_mut(bus).begin_round(now_us, moving);
            }
            self.is_owing = true;
            let late_us = now_us - self.next_round_us;
            self.next_round_us = now_us.saturating_add(ROUND_US - late_us % ROUND_US);
        }
        input
    }

    fn finish_round(&mut self, now_us: u64) -> Option<Input> {
        self.is_owing = false;
        self.measure_on(now_us);
        let samples = self.ring.samples(now_us);
        self.has_delivered |= samples.iter().any(|sample| *sample != Sample::Missing);
        self.has_delivered.then_some(Input::Proximity {
            stamp_us: now_us,
            samples,
        })
    }

    /// Takes a frame of the robot's bus.
    pub fn take_frame(&mut self, now_us: u64, frame: &Frame) -> Heard {
        let Ok(message) = Message::decode(frame) else {
            self.can.ignored = self.can.ignored.saturating_add(1);
            return Heard::Nothing;
        };
        self.can.taken = self.can.taken.saturating_add(1);
        match message {
            Message::Odometry(pose) => {
                if self.last_pose.is_some_and(|last| last != pose) {
                    self.moved_us = Some(now_us);
                }
                self.last_pose = Some(pose);
                Heard::Input(Input::Odometry {
                    stamp_us: self.updates.stamp(now_us, pose),
                    pose,
                })
            }
            Message::CalibrateRing => {
                self.calibrate();
                Heard::Nothing
            }
            Message::Shutdown(_) => Heard::Shutdown,
            Message::ActualSpeed(_) | Message::TargetSpeed(_) => Heard::Nothing,
        }
    }

    /// The frame to send now on the robot's bus: the ring's, as AMiRo-OS sends them.
    pub fn frame_due(&mut self, now_us: u64) -> Option<Frame> {
        if !self.schedule.may_be_due(now_us) {
            return None;
        }
        let trusted = (0..SENSORS)
            .zip(self.ring.states(now_us))
            .filter(|(_, state)| state.is_trusted())
            .fold(SensorMask::NONE, |mask, (sensor, _)| mask.with(sensor));
        let sensor = self.schedule.due(now_us, trusted)?;
        let offset = self.offsets.offsets.counts.get(sensor).copied()?;
        proximity_ring(sensor, self.ring.raw(sensor)?, offset)
    }

    /// Whether the odometry changed lately.
    fn is_moving(&self, now_us: u64) -> bool {
        self.moved_us
            .is_some_and(|moved_us| now_us.saturating_sub(moved_us) <= MOVING_FOR_US)
    }

    /// Begins to measure the offsets; one that is under way goes on.
    pub fn calibrate(&mut self) {
        if self.measurement.is_none() {
            self.measurement = Some(OffsetMeasurement::new(&self.offsets.offsets));
        }
    }

    /// After a round: one more reading for each sensor, and the end if it was the last.
    fn measure_on(&mut self, now_us: u64) {
        let Some(measurement) = &mut self.measurement else {
            return;
        };
        if !measurement.take(&self.ring.trusted_raw(now_us)) {
            return;
        }
        self.offsets.refused = measurement.results().map(Result::err);
        if let Some(offsets) = measurement.offsets() {
            self.use_offsets(offsets);
            self.offsets.is_kept = self.store.write(&offsets);
        }
        self.measurement = None;
        self.are_offsets_new = true;
    }

    /// After a transaction of the store: what it read, once it is known.
    fn take_stored(&mut self) {
        let Some(stored) = self.store.take_read() else {
            return;
        };
        if let Some(offsets) = stored {
            self.use_offsets(offsets);
            self.offsets.is_kept = true;
        }
        self.are_offsets_new = true;
    }

    fn use_offsets(&mut self, offsets: Offsets) {
        self.ring.set_offsets(offsets.counts);
        self.offsets.offsets = offsets;
    }

    /// The offsets, if they were read, measured or refused since the last call.
    pub fn take_offsets(&mut self) -> Option<OffsetReport> {
        core::mem::take(&mut self.are_offsets_new).then_some(self.offsets)
    }

    /// The ring, for looking at it.
    #[must_use]
    pub const fn ring(&self) -> &ProximityRing {
        &self.ring
    }

    /// Where the offsets come from.
    #[must_use]
    pub const fn offset_origin(&self) -> OffsetOrigin {
        self.offsets.offsets.origin
    }

    /// How each sensor is.
    #[must_use]
    pub fn sensors(&self, now_us: u64) -> [SensorHealth; SENSORS] {
        AMIRO_PLACES.map(|place| {
            let sensor = self.ring.sensor_at(place);
            let age_ms = sensor
                .age_us(now_us)
                .map_or(u64::MAX, |age_us| age_us / 1_000);
            SensorHealth {
                state: sensor.state(now_us),
                age_ms: u8::try_from(age_ms).unwrap_or(u8::MAX),
                failed: sensor.counters().failed,
            }
        })
    }

    /// How each bus is, apart from its recoveries, which its master counts.
    #[must_use]
    pub fn buses(&self) -> [BusHealth; 2] {
        self.lines.map(|line| line.health())
    }

    /// How many frames were understood, and how many were not.
    #[must_use]
    pub const fn can(&self) -> CanHealth {
        self.can
    }
}

impl Default for Senses {
    fn default() -> Self {
        Self::new()
    }
}

impl Line {
    fn take(&mut self, fault: Option<BusFault>) {
        let Some(fault) = fault else {
            self.has_worked = true;
            self.held_low = false;
            self.failures_in_a_row = 0;
            return;
        };
        self.held_low = fault == BusFault::HeldLow;
        self.failures_in_a_row = self.failures_in_a_row.saturating_add(1);
        self.failed = self.failed.saturating_add(1);
    }

    fn health(&self) -> BusHealth {
        let state = if self.held_low {
            BusState::HeldLow
        } else if !self.has_worked {
            BusState::Silent
        } else if self.failures_in_a_row >= FAILING_AFTER {
            BusState::Failing
        } else {
            BusState::Working
        };
        BusHealth {
            state,
            failed: self.failed,
            recoveries: 0,
        }
    }
}
