//! Fuzzy sets of occupied and empty cells.

use crate::mapping::{Belief, Calculus};

/// Memberships of a cell in the two sets; the sum may be above 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Memberships {
    /// In the set of occupied cells, in \[0, 1\] (mu_O).
    pub occupied: f64,
    /// In the set of empty cells, in \[0, 1\] (mu_E).
    pub empty: f64,
}

/// Union of fuzzy sets by the algebraic sum (Ivanjko et al. 2003, equations 27 and 28).
///
/// ```text
/// mu_O := mu_O + r_O - mu_O r_O
/// mu_E := mu_E + r_E - mu_E r_E
/// ```
///
/// No membership ever falls. The order of readings does not matter. After many readings
/// both memberships are near 1, so the cell holds the products 1 - mu_O and 1 - mu_E, which
/// keep their digits.
///
/// The belief has mu_O (1 - mu_E) on occupied, mu_E (1 - mu_O) on free, mu_O mu_E on
/// conflict and the rest on unknown; p_occ is then 0.5 + (mu_O - mu_E) / 2.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fuzzy;

/// What a cell is not: the products of 1 - r over its readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Complements {
    /// 1 - mu_O.
    not_occupied: f64,
    /// 1 - mu_E.
    not_empty: f64,
}

impl Complements {
    /// The memberships.
    #[must_use]
    pub fn memberships(&self) -> Memberships {
        Memberships {
            occupied: 1.0 - self.not_occupied,
            empty: 1.0 - self.not_empty,
        }
    }
}

impl Calculus for Fuzzy {
    type Evidence = Memberships;
    type Held = Complements;

    fn blank(&self) -> Complements {
        Complements {
            not_occupied: 1.0,
            not_empty: 1.0,
        }
    }

    fn update(&self, held: &mut Complements, reading: Memberships) {
        held.not_occupied *= 1.0 - reading.occupied;
        held.not_empty *= 1.0 - reading.empty;
    }

    fn belief(&self, held: &Complements) -> Belief {
        let Complements {
            not_occupied,
            not_empty,
        } = *held;
        let Memberships { occupied, empty } = held.memberships();
        let lean = not_empty - not_occupied;
        let conflict = (occupied * empty) as f32;
        if lean.abs() <= Belief::TOLERANCE {
            return Belief {
                occupied: 0.0,
                free: 0.0,
                unknown: 1.0 - conflict,
                conflict,
            };
        }
        Belief {
            occupied: (occupied * not_empty) as f32,
            free: (empty * not_occupied) as f32,
            unknown: (not_occupied * not_empty) as f32,
            conflict,
        }
    }
}

/// Membership of a cell in the set of cells that are safe to drive on (mu_S).
///
/// ```text
/// mu_C = (1 - mu_E mu_O) (1 - (1 - mu_E) (1 - mu_O))
/// mu_S = mu_E^2 (1 - mu_O) mu_C
/// ```
///
/// Equation 29 has mu_S^2 in the place of mu_E^2, which defines mu_S by itself: from 0 it
/// stays 0. Corrected here.
#[must_use]
pub fn safe_membership(cell: &Memberships) -> f64 {
    let Memberships { occupied, empty } = *cell;
    empty * empty * (1.0 - occupied) * clear_membership(cell)
}

/// Membership in the set of cells about which the readings agree and say something (mu_C).
fn clear_membership(Memberships { occupied, empty }: &Memberships) -> f64 {
    (1.0 - empty * occupied) * (1.0 - (1.0 - empty) * (1.0 - occupied))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mapping::Occupancy;

    #[test]
    fn g7_memberships_are_united_as_tabulated() {
        let mut held = Fuzzy.blank();
        let reading = |occupied| Memberships {
            occupied,
            empty: 0.0,
        };
        Fuzzy.update(&mut held, reading(0.3));
        Fuzzy.update(&mut held, reading(0.5));
        assert!((held.memberships().occupied - 0.65).abs() < 1e-9);
        Fuzzy.update(&mut held, reading(0.5));
        assert!((held.memberships().occupied - 0.825).abs() < 1e-9);
    }

    #[test]
    fn g7_the_safe_set_is_corrected_and_differs_from_the_printed_one() {
        for (empty, occupied, clear, safe, printed_once) in [
            (0.8, 0.3, 0.6536, 0.292_812_800, Some(0.457_520)),
            (1.0, 0.0, 1.0, 1.0, None),
            (0.0, 1.0, 1.0, 0.0, None),
            (0.5, 0.5, 0.5625, 0.070_312_500, Some(0.281_250)),
            (0.0, 0.0, 0.0, 0.0, None),
        ] {
            let cell = Memberships { occupied, empty };
            assert!((clear_membership(&cell) - clear).abs() < 1e-9);
            let found = safe_membership(&cell);
            assert!((found - safe).abs() < 1e-9, "{empty} {occupied}: {found}");
            let printed = |safe: f64| safe * safe * (1.0 - occupied) * clear_membership(&cell);
            // Printed, from 0, the set is empty whatever was measured.
            assert!(printed(0.0).abs() < 1e-15);
            if let Some(expected) = printed_once {
                assert!((printed(1.0) - expected).abs() < 1e-9);
                assert!((printed(1.0) - found).abs() > 0.1);
            }
        }
    }

    #[test]
    fn the_four_beliefs_sum_to_one_and_lean_by_half_the_difference() {
        for (occupied, empty) in [(0.0, 0.0), (0.4, 0.1), (0.9, 0.95), (1.0, 1.0), (0.3, 0.3)] {
            let mut held = Fuzzy.blank();
            Fuzzy.update(&mut held, Memberships { occupied, empty });
            let belief = Fuzzy.belief(&held);
            let sum = belief.occupied + belief.free + belief.unknown + belief.conflict;
            if (occupied - empty).abs() > 1e-3 {
                assert!((sum - 1.0).abs() < 1e-6, "{belief:?}");
            }
            let expected = 0.5 + 0.5 * (occupied - empty);
            assert!((f64::from(belief.p_occ()) - expected).abs() < 1e-6);
        }
    }

    #[test]
    fn memberships_near_one_still_differ() {
        let mut held = Fuzzy.blank();
        for _ in 0..40 {
            let (occupied, empty) = (0.25, 0.26);
            Fuzzy.update(&mut held, Memberships { occupied, empty });
        }
        assert!(held.memberships().occupied > 0.9999);
        assert_eq!(Fuzzy.belief(&held).occupancy(), Occupancy::Free);
    }
}
