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
    let mut ticked = Vec::with_capacity(inputs.len());
    let mut due_us = None;
    for input in inputs {
        ticked.push(*input);
        let Input::Proximity { stamp_us, .. } = *input else {
            continue;
        };
        let due = due_us.unwrap_or(stamp_us);
        if stamp_us >= due {
            ticked.push(Input::Tick { stamp_us });
            let periods = ((stamp_us - due) / period_us.max(1)).saturating_add(1);
            due_us = Some(due.saturating_add(periods.saturating_mul(period_us.max(1))));
        }
    }
    ticked
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
