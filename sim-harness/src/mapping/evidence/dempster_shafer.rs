//! Dempster's rule for a cell.

use crate::mapping::{Belief, Calculus};

/// Least value of 1 - k at which two sets of masses are combined.
const LEAST_AGREEMENT: f64 = 1e-6;

/// Masses of belief of one source.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Masses {
    /// On occupied, in \[0, 1\] (m(O)).
    pub occupied: f64,
    /// On empty, in \[0, 1\] (m(E)); the sum of both is at most 1.
    pub empty: f64,
}

impl Masses {
    /// Mass on neither (m(Theta)): what is not known.
    #[must_use]
    pub fn open(&self) -> f64 {
        (1.0 - self.occupied - self.empty).max(0.0)
    }

    /// Mass of the conflict between two sources (k).
    #[must_use]
    pub fn conflict(&self, other: &Self) -> f64 {
        self.empty * other.occupied + self.occupied * other.empty
    }
}

/// Dempster's rule of combination (Ivanjko et al. 2003, equations 23 and 24).
///
/// With the masses m of the cell and r of the reading:
///
/// ```text
/// k    = m(E) r(O) + m(O) r(E)
/// m(O) := (m(O) r(O) + m(O) r(Theta) + m(Theta) r(O)) / (1 - k)
/// m(E) := (m(E) r(E) + m(E) r(Theta) + m(Theta) r(E)) / (1 - k)
/// ```
///
/// Both from the old masses. Where the two contradict each other wholly, 1 - k < 1e-6, the
/// cell stays as it is: the rule has no answer. p_occ is m(O) + m(Theta) / 2.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DempsterShafer;

impl Calculus for DempsterShafer {
    type Evidence = Masses;
    type Held = Masses;

    fn blank(&self) -> Masses {
        Masses::default()
    }

    fn update(&self, held: &mut Masses, reading: Masses) {
        let agreement = 1.0 - held.conflict(&reading);
        if agreement < LEAST_AGREEMENT {
            return;
        }
        let (open, reading_open) = (held.open(), reading.open());
        let combined = |mass: f64, reading_mass: f64| {
            let sum = mass * reading_mass + mass * reading_open + open * reading_mass;
            (sum / agreement).clamp(0.0, 1.0)
        };
        let occupied = combined(held.occupied, reading.occupied);
        let empty = combined(held.empty, reading.empty);
        *held = Masses {
            occupied,
            // Rounding may lift the sum above 1.
            empty: empty.min(1.0 - occupied),
        };
    }

    /// Masses that lean to neither side are conflict: p_occ is 0.5.
    fn belief(&self, held: &Masses) -> Belief {
        let Masses { occupied, empty } = *held;
        if (occupied - empty).abs() <= Belief::TOLERANCE {
            let conflict = (occupied + empty) as f32;
            return Belief {
                conflict,
                unknown: 1.0 - conflict,
                occupied: 0.0,
                free: 0.0,
            };
        }
        Belief {
            occupied: occupied as f32,
            free: empty as f32,
            unknown: held.open() as f32,
            conflict: 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mapping::Occupancy;

    const fn masses(occupied: f64, empty: f64) -> Masses {
        Masses { occupied, empty }
    }

    fn combined(mut held: Masses, reading: Masses) -> Masses {
        DempsterShafer.update(&mut held, reading);
        held
    }

    #[test]
    fn g6_masses_are_combined_as_tabulated() {
        let (held, reading) = (masses(0.4, 0.2), masses(0.5, 0.1));
        assert!((held.conflict(&reading) - 0.14).abs() < 1e-12);
        let found = combined(held, reading);
        assert!((found.occupied - 0.651_162_791).abs() < 1e-9);
        assert!((found.empty - 0.162_790_698).abs() < 1e-9);
        assert!((found.open() - 0.186_046_512).abs() < 1e-9);
    }

    #[test]
    fn g6_the_new_mass_of_occupied_is_not_used_for_that_of_empty() {
        // The slip: m(O) is replaced before m(E), k and m(Theta) are computed anew.
        let reading = masses(0.5, 0.1);
        let new_occupied = combined(masses(0.4, 0.2), reading).occupied;
        let slipped = combined(masses(new_occupied, 0.2), reading).empty;
        let right = combined(masses(0.4, 0.2), reading).empty;
        assert!((slipped - 0.137_604_457).abs() < 1e-9, "{slipped}");
        assert!((slipped - right).abs() > 0.02);
    }

    #[test]
    fn g6_masses_are_divided_by_what_does_not_conflict() {
        let found = combined(masses(0.4, 0.2), masses(0.5, 0.1));
        // Without the division the masses are 0.56 and 0.14.
        assert!((found.occupied * 0.86 - 0.56).abs() < 1e-9);
        assert!((found.empty * 0.86 - 0.14).abs() < 1e-9);
    }

    #[test]
    fn g6_strong_conflict_is_shared_and_total_conflict_changes_nothing() {
        assert!((masses(0.9, 0.0).conflict(&masses(0.0, 0.9)) - 0.81).abs() < 1e-12);
        let shared = combined(masses(0.9, 0.0), masses(0.0, 0.9));
        assert!((shared.occupied - 0.473_684_211).abs() < 1e-9);
        assert!((shared.empty - 0.473_684_211).abs() < 1e-9);
        let total = masses(1.0, 0.0);
        assert_eq!(combined(total, masses(0.0, 1.0)), total);
        let held = masses(0.4, 0.2);
        let vacuous = combined(held, Masses::default());
        assert!((vacuous.occupied - held.occupied).abs() < 1e-15);
        assert!((vacuous.empty - held.empty).abs() < 1e-15);
    }

    #[test]
    fn belief_leaves_what_is_open_unknown_and_what_leans_to_neither_side_in_conflict() {
        let belief = DempsterShafer.belief(&masses(0.6, 0.1));
        assert!((belief.p_occ() - 0.75).abs() < 1e-6);
        for share in [0.0, 0.1, 0.3, 0.473_684_211, 0.5] {
            let even = DempsterShafer.belief(&masses(share, share));
            assert_eq!(even.occupancy(), Occupancy::Unknown, "{share}");
        }
    }
}
