//! Lowers the particle count when steps take too long.

/// Shares of the configured particles, in sixteenths, from one stage to the next.
pub const STAGES: [u8; 5] = [16, 12, 8, 4, 2];

/// Steps in a row beyond the budget before the next stage.
const PATIENCE: u8 = 3;

/// Lowers the particle count of a board that is too slow for its steps, so that it does
/// not miss them. Only a configuration raises the count again.
#[derive(Clone, Copy, Debug)]
pub struct LoadGuard {
    budget_us: u64,
    stage: usize,
    over: u8,
}

impl LoadGuard {
    /// A guard with this budget per step.
    #[must_use]
    pub const fn new(budget_us: u64) -> Self {
        Self {
            budget_us,
            stage: 0,
            over: 0,
        }
    }

    /// Takes a step's duration and the configured particles per sensor; the particles per
    /// many it should be from now on, if that has changed.
    ///
    /// After three steps in a row beyond the budget 3/4 of the configured number, then
    /// 1/2, 1/4 and 1/8, at least 1.
    pub fn on_step(&mut self, step_us: u64, configured: u16) -> Option<u16> {
        if step_us <= self.budget_us {
            self.over = 0;
            return None;
        }
        self.over += 1;
        if self.over < PATIENCE {
            return None;
        }
        self.over = 0;
        let share = STAGES.get(self.stage + 1)?;
        self.stage += 1;
        Some((u32::from(configured) * u32::from(*share) / 16).max(1) as u16)
    }

    /// Starts again from all particles, after a configuration.
    pub fn reset(&mut self) {
        self.stage = 0;
        self.over = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn f40_three_long_steps_in_a_row_cost_a_quarter() {
        let mut guard = LoadGuard::new(100_000);
        let limits: Vec<_> = (0..16)
            .filter_map(|_| guard.on_step(130_000, 1000))
            .collect();
        assert_eq!(limits, [750, 500, 250, 125], "and no further");
        guard.reset();
        for _ in 0..100 {
            assert_eq!(guard.on_step(130_000, 1000), None);
            assert_eq!(guard.on_step(130_000, 1000), None);
            assert_eq!(guard.on_step(99_000, 1000), None);
        }
        let again = (0..3).find_map(|_| guard.on_step(130_000, 1000));
        assert_eq!(again, Some(750), "the first stage after a reset");
    }

    #[test]
    fn f40_a_board_ten_times_too_slow_keeps_its_steps_after_a_while() {
        // A step of 1000 particles a sensor takes 700 ms, as on the internal clock.
        let mut guard = LoadGuard::new(100_000);
        let mut particles = 1000;
        for _ in 0..20 {
            let step_us = u64::from(particles) * 700;
            particles = guard.on_step(step_us, 1000).unwrap_or(particles);
        }
        assert_eq!(particles, 125);
        assert!(u64::from(particles) * 700 <= 100_000);
    }

    #[test]
    fn a_step_that_takes_its_whole_budget_is_in_time() {
        let mut guard = LoadGuard::new(100_000);
        assert!((0..100).all(|_| guard.on_step(100_000, 1000).is_none()));
        let limits = [(); 3].map(|()| guard.on_step(100_001, 1000));
        assert_eq!(limits, [None, None, Some(750)]);
    }

    #[test]
    fn at_least_one_particle_is_left() {
        let mut guard = LoadGuard::new(1);
        let limits: Vec<_> = (0..16).filter_map(|_| guard.on_step(2, 1)).collect();
        assert_eq!(limits, [1, 1, 1, 1]);
    }
}
