//! The simulated robot: polls, transactions, frames, and the reports that follow.

use std::collections::VecDeque;

use amiro_ipf::board::acquisition::{Acquisition, BUSES, Bus, CanAction};
use amiro_ipf::board::can::CanState;
use amiro_ipf::board::health::{CanHealth, Health};
use amiro_ipf::board::i2c::BusTransaction;
use amiro_ipf::board::offsets::OffsetReport;
use amiro_ipf::board::sensor_state::SensorState;
use amiro_ipf::geometry::Pose;
use amiro_ipf::model::SENSORS;
use amiro_ipf::node::{Input, SeedSource};
use amiro_ipf::random::Generator;

use super::bring_up::buses;
use super::frames::FrameWay;
use super::wheel_module::WheelModule;
use super::{PartClocks, SensedWorld, SensorClocks};
use crate::bus::RobotBuses;
use crate::faults::{ActiveFaults, Component, Kind, period_us};
use crate::world::{Options, Scenario};

/// Period of the flash image's poll: 2 kHz.
const POLL_PERIOD_US: u64 = 500;
/// Polls between two reports of health.
const HEALTH_EVERY: u64 = 250;
/// Standstill after power-up: the sensors become good and several odometry frames arrive. A
/// whole number of rounds.
pub const STARTS_DRIVING_US: u64 = 400_000;
/// Standstill at the end: the last frame and the last round.
const STANDS_US: u64 = 100_000;
/// Sensors that measure together do so from the second round on.
const TOGETHER_FROM_US: u64 = 8_000;
/// Keeps garbage apart from all other noise: "garbage".
const GARBAGE_STREAM: u64 = 0x67_6172_6261_6765;

/// A report of the acquisition with its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AcquisitionReport {
    /// Microseconds after the power came up.
    pub at_us: u64,
    /// What.
    pub content: ReportContent,
}

/// A report of the acquisition, as from the flash image's sampler.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ReportContent {
    /// Samples, an input for the node.
    Samples(Input),
    /// A pose, an input for the node.
    Pose {
        /// The input.
        input: Input,
        /// When the pose was computed, which a frame does not contain.
        updated_us: u64,
    },
    /// The health of the parts.
    Health(Health),
    /// The offsets were read.
    Offsets(OffsetReport),
}

impl ReportContent {
    /// The input for the node, if it is one.
    #[must_use]
    pub const fn input(&self) -> Option<Input> {
        match self {
            Self::Samples(input) | Self::Pose { input, .. } => Some(*input),
            Self::Health(_) | Self::Offsets(_) => None,
        }
    }
}

/// A simulated robot on its drive: an iterator over the reports of its acquisition.
///
/// Equal arguments give equal reports, bit for bit, on every machine. It stands for
/// [`STARTS_DRIVING_US`] first; its stamps count from when its power came up.
#[derive(Debug)]
pub struct Robot {
    sensed_world: SensedWorld,
    faults: ActiveFaults,
    seed: u64,
    clocks: SensorClocks,
    buses: RobotBuses,
    acquisition: Acquisition,
    wheels: WheelModule,
    frames: FrameWay,
    now_us: u64,
    polls: u64,
    /// The measurement of each sensor that its signal is set for.
    prepared_ns: [Option<u64>; SENSORS],
    /// What a stuck sensor measures.
    stuck_at: [Option<u16>; SENSORS],
    reports: VecDeque<AcquisitionReport>,
}

impl Robot {
    /// A robot at the start of a scenario, with clocks that the seed draws.
    ///
    /// The options' dropout is ignored: samples get lost on the buses. Its odometry has
    /// wheel errors or none.
    #[must_use]
    pub fn new(scenario: &Scenario, seed: u64, options: &Options, faults: ActiveFaults) -> Self {
        Self::with_clocks(scenario, seed, options, faults, &PartClocks::drawn(seed))
    }

    /// A robot whose parts run by the given clocks.
    #[must_use]
    pub fn with_clocks(
        scenario: &Scenario,
        seed: u64,
        options: &Options,
        faults: ActiveFaults,
        part_clocks: &PartClocks,
    ) -> Self {
        let sensed_world = SensedWorld::of(scenario, seed, options);
        let mut buses = buses(sensed_world.used());
        match part_clocks.sensors {
            SensorClocks::Scattered { seed } => buses.scatter_clocks(seed),
            SensorClocks::Together { .. } => {
                for sensor in 0..SENSORS {
                    // Nothing is measured before its time.
                    buses
                        .sensor_mut(sensor)
                        .set_phase(STARTS_DRIVING_US * 1_000);
                }
            }
        }
        faults.script(&mut buses, STARTS_DRIVING_US);
        Self {
            wheels: WheelModule::new(
                sensed_world.drive(),
                STARTS_DRIVING_US,
                seed,
                options,
                part_clocks,
            ),
            frames: FrameWay::default(),
            sensed_world,
            faults,
            seed,
            clocks: part_clocks.sensors,
            buses,
            acquisition: Acquisition::new(),
            now_us: 0,
            polls: 0,
            prepared_ns: [None; SENSORS],
            stuck_at: [None; SENSORS],
            reports: VecDeque::new(),
        }
    }

    /// Where the robot is at a time after its power came up.
    #[must_use]
    pub fn true_pose_at(&self, at_us: u64) -> Pose {
        self.sensed_world
            .pose_at(at_us.saturating_sub(STARTS_DRIVING_US))
    }

    /// The current state of each sensor, by the acquisition.
    #[must_use]
    pub fn sensors(&self) -> [SensorState; SENSORS] {
        self.acquisition
            .sensors(self.now_us)
            .map(|sensor| sensor.state)
    }

    /// The current health of the parts.
    #[must_use]
    pub fn health(&self) -> Health {
        Health {
            sensors: self.acquisition.sensors(self.now_us),
            buses: self.acquisition.buses(),
            can: CanHealth {
                state: CanState::On,
                ..self.acquisition.can()
            },
            seed: SeedSource::Configured,
            offsets: self.acquisition.offset_origin(),
        }
    }

    /// Simulates half a millisecond of the flash image.
    fn poll(&mut self) {
        self.take_frames();
        self.buses.advance_to(self.now_us * 1_000);
        self.set_signals();
        let until_us = self.now_us + POLL_PERIOD_US;
        // Pending transactions begin now; those of a round that begins now, at the next poll.
        let pending = BUSES.map(|bus| {
            // A transaction that waited for a held wire may have taken longer than a poll
            // period.
            let is_late = self.buses.bus_mut(index_of(bus)).now_ns() / 1_000 >= until_us;
            let next = (!is_late).then(|| self.acquisition.next(bus, self.now_us));
            (bus, next.flatten())
        });
        if let Some(input) = self.acquisition.poll(self.now_us) {
            self.report(ReportContent::Samples(input));
        }
        if let Some(offsets) = self.acquisition.take_offsets() {
            self.report(ReportContent::Offsets(offsets));
        }
        self.polls += 1;
        if self.polls.is_multiple_of(HEALTH_EVERY) {
            self.report(ReportContent::Health(self.health()));
        }
        for (bus, pending) in pending {
            self.serve(bus, pending, until_us);
        }
        self.now_us = until_us;
    }

    fn report(&mut self, content: ReportContent) {
        let at_us = self.now_us;
        self.reports.push_back(AcquisitionReport { at_us, content });
    }

    /// Executes a bus's transactions, one after the other, until the poll period is over.
    fn serve(&mut self, bus: Bus, pending: Option<BusTransaction>, until_us: u64) {
        let line = self.buses.bus_mut(index_of(bus));
        let mut next = pending;
        while let Some(transaction) = next {
            let result = line.run(&transaction);
            let result = result.as_deref().map_err(|error| (*error).into());
            let now_us = line.now_ns() / 1_000;
            self.acquisition.answer(bus, now_us, result);
            if now_us >= until_us {
                return;
            }
            next = self.acquisition.next(bus, now_us);
        }
    }

    /// Takes the frames since the last poll, each at its own time.
    fn take_frames(&mut self) {
        while let Some(sent) = self.wheels.sent_by(self.now_us, self.sensed_world.drive()) {
            let drive_us = sent.at_us.saturating_sub(STARTS_DRIVING_US);
            self.frames.take(sent, drive_us, &self.faults);
        }
        while let Some(arrived) = self.frames.arrived_by(self.now_us) {
            let action = self.acquisition.take_frame(arrived.at_us, &arrived.frame);
            if let CanAction::Input(input) = action {
                self.reports.push_back(AcquisitionReport {
                    at_us: arrived.at_us,
                    content: ReportContent::Pose {
                        input,
                        updated_us: arrived.updated_us,
                    },
                });
            }
        }
    }

    /// Sets the signal of each sensor's measurement under way: there is one every 8 ms, so
    /// that none is missed.
    fn set_signals(&mut self) {
        for sensor in self.sensed_world.used().iter() {
            let part = self.buses.sensor_mut(sensor);
            let Some(at_ns) = part.measures_at_ns() else {
                self.prepared_ns[sensor] = None;
                continue;
            };
            let before_ns = self.prepared_ns[sensor];
            let was_running = before_ns.is_some();
            let at_ns = match self.clocks {
                SensorClocks::Together { into_round_ns } if !was_running => {
                    let first_ns = TOGETHER_FROM_US * 1_000 + into_round_ns;
                    part.measure_next_at(first_ns);
                    first_ns
                }
                _ => at_ns,
            };
            let at_ns = match (before_ns, self.period_ns(sensor, at_ns)) {
                (Some(before_ns), Some(period_ns)) if before_ns < at_ns => {
                    let at_ns = at_ns.max(before_ns + period_ns);
                    self.buses.sensor_mut(sensor).measure_next_at(at_ns);
                    at_ns
                }
                _ => at_ns,
            };
            if self.prepared_ns[sensor].replace(at_ns) != Some(at_ns) {
                self.set_signal(sensor, at_ns);
            }
        }
    }

    /// How long a slow sensor takes from one measurement to the next.
    fn period_ns(&self, sensor: usize, at_ns: u64) -> Option<u64> {
        let drive_us = (at_ns / 1_000).saturating_sub(STARTS_DRIVING_US);
        let active = self.faults.of(Component::Sensor(sensor), drive_us);
        let slow = active.filter_map(|kind| match kind {
            Kind::Slow(rate_hz) => Some(period_us(rate_hz) * 1_000),
            _ => None,
        });
        slow.max()
    }

    fn set_signal(&mut self, sensor: usize, at_ns: u64) {
        let drive_ns = at_ns.cast_signed() - (STARTS_DRIVING_US * 1_000).cast_signed();
        let drive_us = u64::try_from(drive_ns / 1_000).unwrap_or(0);
        let component = Component::Sensor(sensor);
        let late = self.faults.of(component, drive_us);
        let late = late.filter_map(|kind| match kind {
            Kind::Delayed(by) => Some(by.as_nanos() as u64),
            _ => None,
        });
        let seen_ns = drive_ns - late.max().unwrap_or(0).cast_signed();
        let Some(mut raw) = self.sensed_world.raw_counts(sensor, seen_ns) else {
            return;
        };
        let mut ambient_counts = 0;
        let mut is_stuck = false;
        for kind in self.faults.of(component, drive_us) {
            match kind {
                Kind::Saturated => raw = u16::MAX,
                Kind::Stuck => is_stuck = true,
                Kind::Garbage => {
                    let moment = at_ns.rotate_left(20);
                    let seed = self.seed ^ self.faults.seed();
                    let mut noise = Generator::seeded(seed ^ GARBAGE_STREAM ^ moment);
                    // The upper half of the bits.
                    raw = (noise.bits() >> 16) as u16;
                }
                Kind::Wrong(counts) if raw != u16::MAX => {
                    let wrong = i32::from(raw).saturating_add(counts);
                    // One below a full register, which has another meaning.
                    raw = wrong.clamp(0, i32::from(u16::MAX - 1)) as u16;
                }
                Kind::Lit { ambient, added } => {
                    ambient_counts = ambient;
                    raw = raw.saturating_add(added);
                }
                _ => {}
            }
        }
        let stuck_at = &mut self.stuck_at[sensor];
        if is_stuck {
            raw = *stuck_at.get_or_insert(raw);
        } else {
            *stuck_at = None;
        }
        let part = self.buses.sensor_mut(sensor);
        part.set_signal(raw);
        part.set_ambient(ambient_counts);
    }
}

impl Iterator for Robot {
    type Item = AcquisitionReport;

    fn next(&mut self) -> Option<AcquisitionReport> {
        let end_us = STARTS_DRIVING_US + self.sensed_world.drive().end_us() + STANDS_US;
        while self.reports.is_empty() && self.now_us < end_us {
            self.poll();
        }
        self.reports.pop_front()
    }
}

/// The index of a bus.
const fn index_of(bus: Bus) -> usize {
    match bus {
        Bus::I2c1 => 0,
        Bus::I2c2 => 1,
    }
}
