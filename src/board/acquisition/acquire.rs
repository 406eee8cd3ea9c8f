//! From bus transactions and CAN frames to the node's inputs.

use super::bus_status::{BusStatus, Requester};
use super::update_clock::UpdateClock;
use super::{AMIRO_CONNECTIONS, Bus, ProximityRing, ROUND_US};
use crate::board::calibration::OffsetMeasurement;
use crate::board::can::{CanFrame, CanMessage, RingSchedule, proximity_ring};
use crate::board::health::{BusHealth, CanHealth, SensorHealth};
use crate::board::i2c::{BusFault, BusTransaction};
use crate::board::offset_store::OffsetStore;
use crate::board::offsets::{OffsetOrigin, OffsetReport, Offsets};
use crate::geometry::Pose;
use crate::model::{SENSORS, Sample, SensorMask};
use crate::node::Input;

/// The two I2C buses, in the order of their numbers.
pub const BUSES: [Bus; 2] = [Bus::I2c1, Bus::I2c2];

/// The bus of the EEPROM.
const STORE_BUS: Bus = Bus::I2c2;

/// The robot counts as moving for this long after its odometry changed: three frames.
const MOVING_FOR_US: u64 = 200_000;

/// What the board does with a frame of the CAN bus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CanAction {
    /// The node takes an input.
    Input(Input),
    /// The robot shuts down.
    Shutdown,
    /// Nothing.
    Nothing,
}

/// The acquisition of all inputs of the robot; see the [module](super).
#[derive(Clone, Debug, Default)]
pub struct Acquisition {
    ring: ProximityRing,
    store: OffsetStore,
    bus_status: [BusStatus; 2],
    /// When the next round begins.
    next_round_us: u64,
    /// A round has begun and its samples were not given yet.
    is_round_pending: bool,
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

impl Acquisition {
    /// The acquisition before its first transaction. The stored offsets are read first,
    /// then the first round begins.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    fn status_mut(&mut self, bus: Bus) -> &mut BusStatus {
        let [one, two] = &mut self.bus_status;
        match bus {
            Bus::I2c1 => one,
            Bus::I2c2 => two,
        }
    }

    /// The transaction to execute now on a bus; `None` if there is none, or if the one
    /// before has no result yet. About a hundred instructions.
    pub fn next(&mut self, bus: Bus, now_us: u64) -> Option<BusTransaction> {
        if self.status_mut(bus).requester != Requester::None {
            return None;
        }
        let (requester, transaction) = match self.ring.bus_mut(bus).next(now_us) {
            Some(transaction) => (Requester::Ring, transaction),
            None if bus == STORE_BUS => (Requester::Store, self.store.next(now_us)?),
            None => return None,
        };
        self.status_mut(bus).requester = requester;
        Some(transaction)
    }

    /// Takes the result of the transaction before on a bus. About a hundred instructions.
    pub fn answer(&mut self, bus: Bus, now_us: u64, result: Result<&[u8], BusFault>) {
        match core::mem::take(&mut self.status_mut(bus).requester) {
            Requester::None => {}
            Requester::Ring => {
                self.status_mut(bus).on_result(result.err());
                self.ring.bus_mut(bus).answer(now_us, result);
            }
            // An EEPROM that is writing does not answer: the bus is all right.
            Requester::Store => {
                self.store.answer(now_us, result);
                self.take_stored();
            }
        }
    }

    /// Begins rounds in their time and gives the samples of each when it is over. To be
    /// called at least every millisecond.
    ///
    /// Nothing is given until a sensor has delivered for the first time. From then on a
    /// round without any sample is given as well, so that the node learns of it.
    pub fn poll(&mut self, now_us: u64) -> Option<Input> {
        let is_over = BUSES.iter().all(|bus| self.ring.bus_mut(*bus).is_idle());
        let input = if self.is_round_pending && is_over {
            self.finish_round(now_us)
        } else {
            None
        };
        if now_us >= self.next_round_us {
            // A round that is still busy is counted by its bus and goes on.
            let moving = self.is_moving(now_us);
            for bus in BUSES {
                self.ring.bus_mut(bus).begin_round(now_us, moving);
            }
            self.is_round_pending = true;
            let late_us = now_us - self.next_round_us;
            self.next_round_us = now_us.saturating_add(ROUND_US - late_us % ROUND_US);
        }
        input
    }

    fn finish_round(&mut self, now_us: u64) -> Option<Input> {
        self.is_round_pending = false;
        self.measure_offsets(now_us);
        let samples = self.ring.samples(now_us);
        self.has_delivered |= samples.iter().any(|sample| *sample != Sample::Missing);
        self.has_delivered.then_some(Input::Proximity {
            stamp_us: now_us,
            samples,
        })
    }

    /// Takes a frame of the CAN bus.
    pub fn take_frame(&mut self, now_us: u64, frame: &CanFrame) -> CanAction {
        let Ok(message) = CanMessage::decode(frame) else {
            self.can.ignored = self.can.ignored.saturating_add(1);
            return CanAction::Nothing;
        };
        self.can.taken = self.can.taken.saturating_add(1);
        match message {
            CanMessage::Odometry(pose) => {
                if self.last_pose.is_some_and(|last| last != pose) {
                    self.moved_us = Some(now_us);
                }
                self.last_pose = Some(pose);
                CanAction::Input(Input::Odometry {
                    stamp_us: self.updates.stamp(now_us, pose),
                    pose,
                })
            }
            CanMessage::CalibrateRing => {
                self.calibrate();
                CanAction::Nothing
            }
            CanMessage::Shutdown(_) => CanAction::Shutdown,
            CanMessage::ActualSpeed(_) | CanMessage::TargetSpeed(_) => CanAction::Nothing,
        }
    }

    /// The frame to send now on the CAN bus: the ring's, as AMiRo-OS sends them.
    pub fn frame_due(&mut self, now_us: u64) -> Option<CanFrame> {
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

    /// Begins to measure the offsets; a measurement that is under way goes on.
    pub fn calibrate(&mut self) {
        if self.measurement.is_none() {
            self.measurement = Some(OffsetMeasurement::new(&self.offsets.offsets));
        }
    }

    /// Adds the readings of a round to a measurement of the offsets and ends it after the
    /// last round.
    fn measure_offsets(&mut self, now_us: u64) {
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

    /// Takes what the store has read, once it has.
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

    /// The sensor ring.
    #[must_use]
    pub const fn ring(&self) -> &ProximityRing {
        &self.ring
    }

    /// Where the offsets come from.
    #[must_use]
    pub const fn offset_origin(&self) -> OffsetOrigin {
        self.offsets.offsets.origin
    }

    /// Health of each sensor.
    #[must_use]
    pub fn sensors(&self, now_us: u64) -> [SensorHealth; SENSORS] {
        AMIRO_CONNECTIONS.map(|at| {
            let sensor = self.ring.sensor(at);
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

    /// Health of each bus without its recoveries, which its master counts.
    #[must_use]
    pub fn buses(&self) -> [BusHealth; 2] {
        self.bus_status.map(|status| status.health())
    }

    /// Frames of the CAN bus that were taken and ignored.
    #[must_use]
    pub const fn can(&self) -> CanHealth {
        self.can
    }
}
