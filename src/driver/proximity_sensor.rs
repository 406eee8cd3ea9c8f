//! One proximity sensor as it is known from its readings: its state and its value.

use vcnl4020::{Measurement, SATURATED};

use super::sensor_state::{SensorCounters, SensorFault, SensorState};
use super::watch::{Watch, is_dazzled};
use crate::model::Sample;
use crate::node::MAX_SAMPLE_AGE_US;

/// A value older than this is not used: two periods of 125 Hz.
pub const MAX_AGE_US: u64 = MAX_SAMPLE_AGE_US;

/// Rounds in a row without an answer after which a sensor is missing.
pub const MISSING_AFTER: u8 = 3;

/// Time between two attempts at a sensor that is missing or a stranger.
pub const PROBE_PERIOD_US: u64 = 1_000_000;

/// Plausible readings in a row before a sensor is trusted, at first and anew.
pub const TRUSTED_AFTER: u8 = 10;

/// Offset of a sensor that was never calibrated, counts.
pub const DEFAULT_OFFSET: u16 = 2_450;

/// Counts above the offset that mean something: the law's 23.6 at 0.20 m.
pub const DEFAULT_LEAST_COUNTS: u16 = 24;

/// How the sensor is to be spoken to in the next round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Terms {
    /// It must be configured first.
    Unconfigured,
    /// It measures by itself.
    Running,
    /// It is left alone until this time.
    LeftAlone { until_us: u64, stranger: bool },
}

/// What is known of one sensor.
#[derive(Clone, Copy, Debug)]
pub struct ProximitySensor {
    /// Raw counts with nothing in range.
    pub offset: u16,
    /// Counts above the offset below which there is nothing in range.
    pub least_counts: u16,
    terms: Terms,
    failures: u8,
    plausible: u8,
    dazzled: bool,
    last: Option<Stamped>,
    watch: Watch,
    counters: SensorCounters,
}

#[derive(Clone, Copy, Debug)]
struct Stamped {
    stamp_us: u64,
    proximity: u16,
}

impl ProximitySensor {
    /// A sensor that nothing is known of.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            offset: DEFAULT_OFFSET,
            least_counts: DEFAULT_LEAST_COUNTS,
            terms: Terms::Unconfigured,
            failures: 0,
            plausible: 0,
            dazzled: false,
            last: None,
            watch: Watch::new(),
            counters: SensorCounters {
                readings: 0,
                failed: 0,
                resets: 0,
                discarded_for_mux: 0,
                torn: 0,
            },
        }
    }

    /// How it is now.
    #[must_use]
    pub fn state(&self, now_us: u64) -> SensorState {
        if let Terms::LeftAlone { stranger, .. } = self.terms {
            return if stranger {
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
        if now_us.saturating_sub(last.stamp_us) > MAX_AGE_US || self.watch.is_stuck() {
            return SensorState::Stale;
        }
        if self.plausible < TRUSTED_AFTER {
            SensorState::NoData
        } else if last.proximity == SATURATED {
            SensorState::TooClose
        } else if self.counts(last.proximity) < i32::from(self.least_counts) {
            SensorState::Nothing
        } else {
            SensorState::Good
        }
    }

    const fn fault(&self) -> Option<SensorFault> {
        if self.watch.is_garbage() {
            Some(SensorFault::Garbage)
        } else if self.dazzled {
            Some(SensorFault::Dazzled)
        } else {
            None
        }
    }

    fn counts(&self, proximity: u16) -> i32 {
        i32::from(proximity) - i32::from(self.offset)
    }

    /// What it delivers now; missing unless its state is trusted.
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

    /// The last raw value that it delivered, whatever its age and state.
    #[must_use]
    pub fn raw(&self) -> Option<u16> {
        self.last.map(|last| last.proximity)
    }

    /// Age of that value, microseconds.
    #[must_use]
    pub fn age_us(&self, now_us: u64) -> Option<u64> {
        self.last.map(|last| now_us.saturating_sub(last.stamp_us))
    }

    /// What happened to it since the start.
    #[must_use]
    pub const fn counters(&self) -> SensorCounters {
        self.counters
    }

    /// Whether the round that begins now has to do with it.
    pub(super) const fn is_due(&self, now_us: u64) -> bool {
        match self.terms {
            Terms::LeftAlone { until_us, .. } => now_us >= until_us,
            Terms::Unconfigured | Terms::Running => true,
        }
    }

    /// Whether it measures by itself and may be read.
    pub(super) const fn is_running(&self) -> bool {
        matches!(self.terms, Terms::Running)
    }

    /// Whether an error is made up for by another attempt in the same round.
    pub(super) const fn deserves_another_attempt(&self) -> bool {
        !matches!(self.terms, Terms::LeftAlone { .. })
    }

    /// It was configured; readings follow from the next round on.
    ///
    /// One that was running has been reset since.
    pub(super) fn configured(&mut self) {
        match self.terms {
            Terms::Running => self.counters.resets = self.counters.resets.saturating_add(1),
            Terms::LeftAlone { .. } => self.watch = Watch::new(),
            Terms::Unconfigured => {}
        }
        self.terms = Terms::Running;
        self.failures = 0;
        self.last = None;
    }

    /// It answered without having anything new.
    pub(super) fn answered(&mut self) {
        self.failures = 0;
    }

    /// It delivered a reading.
    pub(super) fn take(&mut self, now_us: u64, measurement: Measurement, moving: bool) {
        self.failures = 0;
        self.counters.readings = self.counters.readings.saturating_add(1);
        self.watch.take(measurement.proximity, self.offset, moving);
        self.dazzled = is_dazzled(measurement.ambient);
        self.last = Some(Stamped {
            stamp_us: now_us,
            proximity: measurement.proximity,
        });
        self.plausible = match self.fault() {
            None => self.plausible.saturating_add(1).min(TRUSTED_AFTER),
            Some(_) => 0,
        };
    }

    /// A reading changed while it was read.
    pub(super) fn torn(&mut self) {
        self.counters.torn = self.counters.torn.saturating_add(1);
    }

    /// An answer was thrown away because nobody knows whose it was.
    pub(super) fn discarded(&mut self) {
        self.counters.discarded_for_mux = self.counters.discarded_for_mux.saturating_add(1);
    }

    /// A round wanted it and got nothing.
    pub(super) fn failed(&mut self, now_us: u64) {
        self.counters.failed = self.counters.failed.saturating_add(1);
        self.failures = self.failures.saturating_add(1);
        let alone = matches!(self.terms, Terms::LeftAlone { .. });
        if alone || self.failures >= MISSING_AFTER {
            self.leave_alone(now_us, false);
        }
    }

    /// Another part answers in its place.
    pub(super) fn is_a_stranger(&mut self, now_us: u64) {
        self.leave_alone(now_us, true);
    }

    fn leave_alone(&mut self, now_us: u64, stranger: bool) {
        self.terms = Terms::LeftAlone {
            until_us: now_us.saturating_add(PROBE_PERIOD_US),
            stranger,
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

    /// A sensor that has earned trust with noisy readings up to time 0.
    fn trusted() -> ProximitySensor {
        let mut sensor = ProximitySensor::new();
        sensor.configured();
        for index in 0..TRUSTED_AFTER {
            sensor.take(0, dark(2_500 + u16::from(index % 2)), true);
        }
        sensor
    }

    #[test]
    fn trust_takes_ten_readings() {
        let mut sensor = ProximitySensor::new();
        assert_eq!(sensor.state(0), SensorState::NoData);
        sensor.configured();
        for reading in 1..=10 {
            sensor.take(0, dark(2_500), true);
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
            sensor.take(0, dark(raw), true);
            assert_eq!(sensor.state(0), state, "{raw}");
            let counts = i32::from(raw) - 2_450;
            assert_eq!(sensor.sample(0), Sample::Counts(counts));
        }
    }

    #[test]
    fn f09_a_full_register_is_too_close_and_never_a_count() {
        let mut sensor = trusted();
        for _ in 0..1_000 {
            sensor.take(0, dark(u16::MAX), true);
            assert_eq!(sensor.state(0), SensorState::TooClose);
            assert_eq!(sensor.sample(0), Sample::Saturated);
        }
    }

    #[test]
    fn f10_a_stuck_sensor_is_stale_after_a_second_of_driving() {
        let mut sensor = trusted();
        let found = (1..).find(|_| {
            sensor.take(0, dark(2_600), true);
            sensor.state(0) == SensorState::Stale
        });
        assert_eq!(found, Some(125), "8 ms each");
        assert_eq!(sensor.sample(0), Sample::Missing);
        sensor.take(0, dark(2_601), true);
        assert_eq!(sensor.state(0), SensorState::Good);
    }

    #[test]
    fn f12_a_dazzled_sensor_says_nothing_and_earns_trust_anew() {
        let mut sensor = trusted();
        let lit = Measurement {
            ambient: 40_000,
            proximity: 2_900,
        };
        sensor.take(0, lit, true);
        let dazzled = SensorState::Faulty(SensorFault::Dazzled);
        assert_eq!(sensor.state(0), dazzled);
        assert_eq!(sensor.sample(0), Sample::Missing);
        for _ in 0..9 {
            sensor.take(0, dark(2_500), true);
            assert_eq!(sensor.state(0), SensorState::NoData);
        }
        sensor.take(0, dark(2_501), true);
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
        sensor.failed(8_000);
        sensor.failed(16_000);
        sensor.answered();
        sensor.failed(24_000);
        sensor.failed(32_000);
        assert_ne!(sensor.state(32_000), SensorState::Missing);
        sensor.failed(40_000);
        assert_eq!(sensor.state(40_000), SensorState::Missing);
        assert_eq!(sensor.raw(), None);
        assert!(!sensor.is_due(1_039_999) && sensor.is_due(1_040_000));
        // The attempt fails as well: another second.
        sensor.failed(1_040_000);
        assert!(!sensor.is_due(2_039_999) && sensor.is_due(2_040_000));
        assert_eq!(sensor.counters().failed, 6);
    }
}
