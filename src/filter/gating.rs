//! Gating: what a survivor or a rejected particle counts as (equation 3).

use super::{Evaluation, FilterParameters};

/// The outcome of a live particle in a step; the map counts two of the four.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Outcome {
    /// Survived, at or past the innovation gate: counts as occupied.
    SurvivedPastGate,
    /// Survived, but still below the gate: counts nothing.
    SurvivedBelowGate,
    /// Rejected: counts as free.
    RejectedFree,
    /// Rejected at a place that no sensor observed as free: counts nothing.
    RejectedUnobserved,
}

impl Outcome {
    /// A survivor of the given epoch, its survival in this step included.
    ///
    /// Equation 3 has "age >= g", the paper's text "greater than the gate"; this follows
    /// the equation.
    #[inline]
    pub(crate) fn of_survivor(parameters: &FilterParameters, epoch: u8) -> Self {
        if epoch >= parameters.gate {
            Self::SurvivedPastGate
        } else {
            Self::SurvivedBelowGate
        }
    }

    /// A rejected particle by what the sensors saw of its place ([`Evaluation::flags`]).
    ///
    /// Equation 3 counts every rejection as free. Here a place that no sensor has in
    /// view counts nothing. With the side test, the arc of one sensor must lie behind
    /// the place: a rejection behind the arc is no evidence of free space, and without
    /// the test the interiors of walls become free.
    #[inline]
    pub(crate) fn of_rejected(parameters: &FilterParameters, view: u8) -> Self {
        let needed = if parameters.side_test {
            Evaluation::SEEN_PAST
        } else {
            Evaluation::IN_VIEW
        };
        if view & needed != 0 {
            Self::RejectedFree
        } else {
            Self::RejectedUnobserved
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gate_opens_at_the_g_th_survival() {
        let parameters = FilterParameters {
            gate: 4,
            ..FilterParameters::PAPER
        };
        for (epoch, expected) in [
            (1, Outcome::SurvivedBelowGate),
            (3, Outcome::SurvivedBelowGate),
            (4, Outcome::SurvivedPastGate),
            (255, Outcome::SurvivedPastGate),
        ] {
            assert_eq!(
                Outcome::of_survivor(&parameters, epoch),
                expected,
                "age {epoch}"
            );
        }
    }

    #[test]
    fn rejections_count_by_profile() {
        use Outcome::{RejectedFree, RejectedUnobserved};
        let (seen, past) = (
            Evaluation::IN_VIEW,
            Evaluation::IN_VIEW | Evaluation::SEEN_PAST,
        );
        for (view, paper, plus) in [
            (0, RejectedUnobserved, RejectedUnobserved),
            (seen, RejectedFree, RejectedUnobserved),
            (past, RejectedFree, RejectedFree),
        ] {
            assert_eq!(
                Outcome::of_rejected(&FilterParameters::PAPER, view),
                paper,
                "{view}"
            );
            assert_eq!(
                Outcome::of_rejected(&FilterParameters::PLUS, view),
                plus,
                "{view}"
            );
        }
    }
}
