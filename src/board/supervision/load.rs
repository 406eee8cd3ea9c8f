//! How many particles a step can afford.

/// Shares of the configured particles, in sixteenths, from one stage to the next.
pub const STAGES: [u8; 5] = [16, 12, 8, 4, 2];

/// Steps in a row beyond the budget before a stage is gone down.
const PATIENCE: u8 = 3;

/// Lowers the particles of a board that is too slow for its steps, instead of letting
/// it miss them. It never raises them again: a configuration does.
#[derive(Clone, Copy, Debug)]
pub struct LoadGuard {
    budget_us: u64,
    stage: usize,
    over: u8,
}

impl LoadGuard {
    /// A guard that allows a step so long.
    #[must_use]
    pub const fn new(budget_us: u64) -> Self {
        Self {
            budget_us,
            stage: 0,
            over: 0,
        }
    }

    /// A step took so long, of particles of which so many a sensor are configured. How
    /// many it should be from now on, if that has changed.
    ///
    /// After three steps in a row beyond the budget 3/4 of the configured number, then
    /// 1/2, 1/4 and 1/8, at least 1.
    pub fn took(&mut self, step_us: u64, configured: u16) -> Option<u16> {
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

    /// Begins anew, after a configuration.
    pub fn start_over(&mut self) {
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
        let said: Vec<_> = (0..16).filter_map(|_| guard.took(130_000, 1000)).collect();
        assert_eq!(said, [750, 500, 250, 125], "and no further");
        guard.start_over();
        for _ in 0..100 {
            assert_eq!(guard.took(130_000, 1000), None);
            assert_eq!(guard.took(130_000, 1000), None);
            assert_eq!(guard.took(99_000, 1000), None);
        }
    }

    #[test]
    fn f40_a_board_ten_times_too_slow_keeps_its_steps_after_a_while() {
        // A step of 1000 particles a sensor takes 700 ms, as on the internal clock.
        let mut guard = LoadGuard::new(100_000);
        let mut particles = 1000;
        for _ in 0..20 {
            let step_us = u64::from(particles) * 700;
            particles = guard.took(step_us, 1000).unwrap_or(particles);
        }
        assert_eq!(particles, 125);
        assert!(u64::from(particles) * 700 <= 100_000);
    }

    #[test]
    fn a_step_that_takes_its_whole_budget_is_in_time() {
        let mut guard = LoadGuard::new(100_000);
        assert!((0..100).all(|_| guard.took(100_000, 1000).is_none()));
        assert_eq!(guard.took(100_001, 1000), None);
        assert_eq!(guard.took(100_001, 1000), None);
        assert_eq!(guard.took(100_001, 1000), Some(750));
    }

    #[test]
    fn f40_a_configuration_begins_again_with_the_first_quarter() {
        let mut guard = LoadGuard::new(100_000);
        let mut said = || (0..3).find_map(|_| guard.took(130_000, 1000));
        assert_eq!((said(), said()), (Some(750), Some(500)));
        guard.start_over();
        let again = (0..3).find_map(|_| guard.took(130_000, 1000));
        assert_eq!(again, Some(750));
    }

    #[test]
    fn at_least_one_particle_is_left() {
        let mut guard = LoadGuard::new(1);
        let said: Vec<_> = (0..16).filter_map(|_| guard.took(2, 1)).collect();
        assert_eq!(said, [1, 1, 1, 1]);
    }
}
