//! Ticks at a fixed rate of the inputs' own time.

use amiro_ipf::node::Input;

/// A fixed rate of 8 Hz.
pub const TICK_PERIOD_US: u64 = 125_000;

/// The inputs with a tick behind the first reading at or past every period.
///
/// For [`StepRule::PerTick`](amiro_ipf::node::StepRule::PerTick) without a clock of
/// the board's own. The first reading gets a tick; a gap in the readings gets none.
#[must_use]
pub fn with_ticks(inputs: &[Input], period_us: u64) -> Vec<Input> {
    Ticked::new(inputs.iter().copied(), period_us).collect()
}

/// The same one after another, for inputs of any number.
#[derive(Clone, Debug)]
pub struct Ticked<I> {
    inputs: I,
    period_us: u64,
    due_us: Option<u64>,
    /// The tick behind the last reading, if it is due.
    tick: Option<Input>,
}

impl<I> Ticked<I> {
    /// Inputs with ticks of a period.
    #[must_use]
    pub fn new(inputs: I, period_us: u64) -> Self {
        Self {
            inputs,
            period_us: period_us.max(1),
            due_us: None,
            tick: None,
        }
    }
}

impl<I: Iterator<Item = Input>> Iterator for Ticked<I> {
    type Item = Input;

    fn next(&mut self) -> Option<Input> {
        if let Some(tick) = self.tick.take() {
            return Some(tick);
        }
        let input = self.inputs.next()?;
        if let Input::Proximity { stamp_us, .. } = input {
            let due = self.due_us.unwrap_or(stamp_us);
            if stamp_us >= due {
                self.tick = Some(Input::Tick { stamp_us });
                let periods = ((stamp_us - due) / self.period_us).saturating_add(1);
                self.due_us = Some(due.saturating_add(periods.saturating_mul(self.period_us)));
            }
        }
        Some(input)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use amiro_ipf::model::{SENSORS, Sample};

    #[test]
    fn readings_at_125_hertz_get_eight_ticks_a_second() {
        let readings: Vec<_> = (0..1250)
            .map(|row| Input::Proximity {
                stamp_us: 1_000_000 + row * 8_000,
                samples: [Sample::Counts(0); SENSORS],
            })
            .collect();
        let ticks = with_ticks(&readings, TICK_PERIOD_US);
        assert_eq!(ticks.len() - readings.len(), 80);
        assert!(matches!(
            ticks.get(1),
            Some(Input::Tick {
                stamp_us: 1_000_000
            })
        ));
    }
}
