//! One proximity sensor: its state and its sample, from its readings.

use vcnl4020::{Measurement, SATURATED};

use super::sensor_state::{SensorCounters, SensorFault, SensorState};
use super::signal_check::{SignalCheck, is_ambient_saturated};
use crate::model::Sample;
use crate::node::MAX_SAMPLE_AGE_US;

/// A value older than this is not used: two periods of 125 Hz.
pub const MAX_AGE_US: u64 = MAX_SAMPLE_AGE_US;

/// Rounds in a row without an answer after which a sensor is missing.
pub const MISSING_AFTER: u8 = 3;

/// Time between two probes of a sensor that is missing or has a wrong identity.
pub const PROBE_PERIOD_US: u64 = 1_000_000;

/// Plausible readings in a row before a sensor is trusted, at first and after a fault.
pub const TRUSTED_AFTER: u8 = 10;

/// Offset of a sensor that was never calibrated, counts.
pub const DEFAULT_OFFSET: u16 = 2_450;

/// Counts above the offset from which on something is in range: the law's 23.6 at 0.20 m.
const MIN_COUNTS: i32 = 24;

/// How the next round treats the sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Operation {
    /// It must be configured first.
    Unconfigured,
    /// It measures by itself.
    Running,
    /// It is not accessed until this time.
    Paused { until_us: u64, wrong_identity: bool },
}

/// One sensor: its operation, its last reading and what the checks found.
#[derive(Clone, Copy, Debug)]
pub struct ProximitySensor {
    /// Raw counts with nothing in range.
    pub offset: u16,
    operation: Operation,
    failures: u8,
    plausible: u8,
    ambient_saturated: bool,
    last: Option<StampedCounts>,
    signal: SignalCheck,
    counters: SensorCounters,
}

#[derive(Clone, Copy, Debug)]
struct StampedCounts {
    stamp_us: u64,
    proximity: u16,
}

impl ProximitySensor {
    /// A sensor before its first readout.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            offset: DEFAULT_OFFSET,
            operation: Operation::Unconfigured,
            failures: 0,
            plausible: 0,
            ambient_saturated: false,
            last: None,
            signal: SignalCheck::new(),
            counters: SensorCounters {
                readings: 0,
                failed: 0,
                resets: 0,
                discarded_for_mux: 0,
                torn: 0,
            },
        }
    }

    /// Its state now.
    #[must_use]
    pub fn state(&self, now_us: u64) -> SensorState {
        if let Operation::Paused { wrong_identity, .. } = self.operation {
            return if wrong_identity {
                SensorState::Faulty(SensorFault::WrongIdentity)
            } else {
                SensorState::Missing
            };
        }
        let Some(last) = self.last else {
            return SensorState::NoData;
        };
        if let Some(fault) = self.fault() {
            return SensorState::Faulty(fault);
        }
        if now_us.saturating_sub(last.stamp_us) > MAX_AGE_US || self.signal.is_stuck() {
            return SensorState::Stale;
        }
        if self.plausible < TRUSTED_AFTER {
            SensorState::NoData
        } else if last.proximity == SATURATED {
            SensorState::TooClose
        } else if self.counts(last.proximity) < MIN_COUNTS {
            SensorState::Nothing
        } else {
            SensorState::Good
        }
    }

    const fn fault(&self) -> Option<SensorFault> {
        if self.signal.is_garbage() {
            Some(SensorFault::Garbage)
        } else if self.ambient_saturated {
            Some(SensorFault::Dazzled)
        } else {
            None
        }
    }

    fn counts(&self, proximity: u16) -> i32 {
        i32::from(proximity) - i32::from(self.offset)
    }

    /// Its sample now; missing unless its state is trusted.
    #[must_use]
    pub fn sample(&self, now_us: u64) -> Sample {
        let Some(last) = self.last else {
            return Sample::Missing;
        };
        match self.state(now_us) {
            SensorState::TooClose => Sample::Saturated,
            SensorState::Nothing | SensorState::Good => Sample::Counts(self.counts(last.proximity)),
            _ => Sample::Missing,
        }
    }

    /// The last raw value, of any age and state.
    #[must_use]
    pub fn raw(&self) -> Option<u16> {
        self.last.map(|last| last.proximity)
    }

    /// Age of that value, microseconds.
    #[must_use]
    pub fn age_us(&self, now_us: u64) -> Option<u64> {
        self.last.map(|last| now_us.saturating_sub(last.stamp_us))
    }

    /// Its counters since the start.
    #[must_use]
    pub const fn counters(&self) -> SensorCounters {
        self.counters
    }

    /// Whether the round that begins now includes it.
    pub(super) const fn is_due(&self, now_us: u64) -> bool {
        match self.operation {
            Operation::Paused { until_us, .. } => now_us >= until_us,
            Operation::Unconfigured | Operation::Running => true,
        }
    }

    /// Whether it measures by itself and may be read.
    pub(super) const fn is_running(&self) -> bool {
        matches!(self.operation, Operation::Running)
    }

    /// Whether a failed readout is repeated in the same round.
    pub(super) const fn may_retry(&self) -> bool {
        !matches!(self.operation, Operation::Paused { .. })
    }

    /// It was configured; readings follow from the next round on.
    ///
    /// One that was running has been reset since.
    pub(super) fn on_configured(&mut self) {
        match self.operation {
            Operation::Running => self.counters.resets = self.counters.resets.saturating_add(1),
            Operation::Paused { .. } => self.signal = SignalCheck::new(),
            Operation::Unconfigured => {}
        }
        self.operation = Operation::Running;
        self.failures = 0;
        self.last = None;
    }

    /// It answered without a new result.
    pub(super) fn on_no_result(&mut self) {
        self.failures = 0;
    }

    /// It delivered a reading.
    pub(super) fn on_reading(&mut self, now_us: u64, measurement: Measurement, moving: bool) {
        self.failures = 0;
        self.counters.readings = self.counters.readings.saturating_add(1);
        self.signal.take(measurement.proximity, self.offset, moving);
        self.ambient_saturated = is_ambient_saturated(measurement.ambient);
        self.last = Some(StampedCounts {
            stamp_us: now_us,
            proximity: measurement.proximity,
        });
        self.plausible = match self.fault() {
            None => self.plausible.saturating_add(1).min(TRUSTED_AFTER),
            Some(_) => 0,
        };
    }

    /// Counts a reading that changed while it was read.
    pub(super) fn count_torn(&mut self) {
        self.counters.torn = self.counters.torn.saturating_add(1);
    }

    /// Counts an answer that was discarded because another channel was selected.
    pub(super) fn count_discarded(&mut self) {
        self.counters.discarded_for_mux = self.counters.discarded_for_mux.saturating_add(1);
    }

    /// A round ended without its answer.
    pub(super) fn on_failure(&mut self, now_us: u64) {
        self.counters.failed = self.counters.failed.saturating_add(1);
        self.failures = self.failures.saturating_add(1);
        if !self.may_retry() || self.failures >= MISSING_AFTER {
            self.pause(now_us, false);
        }
    }

    /// Another part answers at its address.
    pub(super) fn on_wrong_identity(&mut self, now_us: u64) {
        self.pause(now_us, true);
    }

    fn pause(&mut self, now_us: u64, wrong_identity: bool) {
        self.operation = Operation::Paused {
            until_us: now_us.saturating_add(PROBE_PERIOD_US),
            wrong_identity,
        };
        self.plausible = 0;
        self.last = None;
    }
}

impl Default for ProximitySensor {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dark(proximity: u16) -> Measurement {
        Measurement {
            ambient: 100,
            proximity,
        }
    }

    /// A sensor that is trusted after noisy readings up to time 0.
    fn trusted() -> ProximitySensor {
        let mut sensor = ProximitySensor::new();
        sensor.on_configured();
        for index in 0..TRUSTED_AFTER {
            sensor.on_reading(0, dark(2_500 + u16::from(index % 2)), true);
        }
        sensor
    }

    #[test]
    fn a_sensor_is_good_after_ten_readings() {
        let mut sensor = ProximitySensor::new();
        assert_eq!(sensor.state(0), SensorState::NoData);
        sensor.on_configured();
        for reading in 1..=10 {
            sensor.on_reading(0, dark(2_500), true);
            let expected = if reading < 10 {
                (SensorState::NoData, Sample::Missing)
            } else {
                (SensorState::Good, Sample::Counts(50))
            };
            assert_eq!((sensor.state(0), sensor.sample(0)), expected, "{reading}");
        }
        assert_eq!(sensor.counters().readings, 10);
    }

    #[test]
    fn nothing_begins_below_24_counts_and_goes_below_zero() {
        let mut sensor = trusted();
        for (raw, state) in [
            (2_474, SensorState::Good),
            (2_473, SensorState::Nothing),
            (2_440, SensorState::Nothing),
        ] {
            sensor.on_reading(0, dark(raw), true);
            assert_eq!(sensor.state(0), state, "{raw}");
            let counts = i32::from(raw) - 2_450;
            assert_eq!(sensor.sample(0), Sample::Counts(counts));
        }
    }

    #[test]
    fn f09_a_full_register_is_too_close_and_never_a_count() {
        let mut sensor = trusted();
        for _ in 0..1_000 {
            sensor.on_reading(0, dark(u16::MAX), true);
            assert_eq!(sensor.state(0), SensorState::TooClose);
            assert_eq!(sensor.sample(0), Sample::Saturated);
        }
    }

    #[test]
    fn f10_a_stuck_sensor_is_stale_after_a_second_of_driving() {
        let mut sensor = trusted();
        let found = (1..).find(|_| {
            sensor.on_reading(0, dark(2_600), true);
            sensor.state(0) == SensorState::Stale
        });
        assert_eq!(found, Some(125), "8 ms each");
        assert_eq!(sensor.sample(0), Sample::Missing);
        sensor.on_reading(0, dark(2_601), true);
        assert_eq!(sensor.state(0), SensorState::Good);
    }

    #[test]
    fn f12_a_sensor_in_saturating_light_gives_no_sample_until_it_is_trusted_again() {
        let mut sensor = trusted();
        let lit = Measurement {
            ambient: 40_000,
            proximity: 2_900,
        };
        sensor.on_reading(0, lit, true);
        let dazzled = SensorState::Faulty(SensorFault::Dazzled);
        assert_eq!(sensor.state(0), dazzled);
        assert_eq!(sensor.sample(0), Sample::Missing);
        for _ in 0..9 {
            sensor.on_reading(0, dark(2_500), true);
            assert_eq!(sensor.state(0), SensorState::NoData);
        }
        sensor.on_reading(0, dark(2_501), true);
        assert_eq!(sensor.state(0), SensorState::Good);
    }

    #[test]
    fn f15_a_value_of_16_ms_is_used_and_an_older_one_is_not() {
        let sensor = trusted();
        assert_eq!(sensor.state(MAX_AGE_US), SensorState::Good);
        assert_eq!(sensor.state(MAX_AGE_US + 1), SensorState::Stale);
        assert_eq!(sensor.sample(MAX_AGE_US + 1), Sample::Missing);
    }

    #[test]
    fn f01_the_third_failure_in_a_row_is_one_too_many() {
        let mut sensor = trusted();
        sensor.on_failure(8_000);
        sensor.on_failure(16_000);
        sensor.on_no_result();
        sensor.on_failure(24_000);
        sensor.on_failure(32_000);
        assert_ne!(sensor.state(32_000), SensorState::Missing);
        sensor.on_failure(40_000);
        assert_eq!(sensor.state(40_000), SensorState::Missing);
        assert_eq!(sensor.raw(), None);
        assert!(!sensor.is_due(1_039_999) && sensor.is_due(1_040_000));
        // The attempt fails as well: another second.
        sensor.on_failure(1_040_000);
        assert!(!sensor.is_due(2_039_999) && sensor.is_due(2_040_000));
        assert_eq!(sensor.counters().failed, 6);
    }
}
