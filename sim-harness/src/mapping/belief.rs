//! The belief in a cell: occupied, free, unknown or in conflict.

/// How much belief lies on each answer to "is the cell occupied?"; the four sum to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Belief {
    /// The cell is occupied.
    pub occupied: f32,
    /// The cell is free.
    pub free: f32,
    /// There is no evidence either way.
    pub unknown: f32,
    /// The evidence contradicts itself, in a calculus that keeps such evidence apart.
    pub conflict: f32,
}

impl Belief {
    /// No evidence.
    pub const UNKNOWN: Self = Self {
        occupied: 0.0,
        free: 0.0,
        unknown: 1.0,
        conflict: 0.0,
    };

    /// Difference between the beliefs in occupied and in free up to which they decide
    /// nothing: equal evidence for and against leaves a rounding error, not 0.
    pub const TOLERANCE: f64 = 1e-6;

    /// The belief of a calculus of probabilities: all of it is on occupied or on free.
    #[must_use]
    pub fn of_probability(p_occ: f32) -> Self {
        Self {
            occupied: p_occ,
            free: 1.0 - p_occ,
            unknown: 0.0,
            conflict: 0.0,
        }
    }

    /// As [`of_probability`](Self::of_probability), and unknown where p and 1 - p differ by
    /// at most [`TOLERANCE`](Self::TOLERANCE).
    #[must_use]
    pub fn of_sum(p_occ: f64) -> Self {
        if (2.0 * p_occ - 1.0).abs() <= Self::TOLERANCE {
            Self::UNKNOWN
        } else {
            Self::of_probability(p_occ as f32)
        }
    }

    /// The belief of a method that compares a score with 0: occupied above it, free up to it.
    ///
    /// p_occ = 0.5 + s / (2 (1 + |s|)), at least twice [`TOLERANCE`](Self::TOLERANCE) from
    /// 0.5. It ranks cells as the scores do; it is no probability.
    #[must_use]
    pub fn of_score(score: f64) -> Self {
        let lean = (0.5 * score.abs() / (1.0 + score.abs())).max(2.0 * Self::TOLERANCE);
        let p_occ = if score > 0.0 { 0.5 + lean } else { 0.5 - lean };
        Self::of_probability(p_occ as f32)
    }

    /// Probability that the cell is occupied: what is unknown or in conflict counts half.
    #[must_use]
    pub fn p_occ(&self) -> f32 {
        self.occupied + 0.5 * (self.unknown + self.conflict)
    }

    /// The class that follows from the probability; NaN is unknown.
    #[must_use]
    pub fn occupancy(&self) -> Occupancy {
        let p_occ = self.p_occ();
        if p_occ > 0.5 {
            Occupancy::Occupied
        } else if p_occ < 0.5 {
            Occupancy::Free
        } else {
            Occupancy::Unknown
        }
    }
}

/// The class of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Occupancy {
    /// p_occ below 0.5.
    Free,
    /// p_occ above 0.5.
    Occupied,
    /// p_occ of exactly 0.5: no evidence, or as much for as against.
    Unknown,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probabilities_come_back_bit_for_bit_and_half_is_unknown() {
        for (p_occ, class) in [
            (0.0, Occupancy::Free),
            (0.3, Occupancy::Free),
            (0.5, Occupancy::Unknown),
            (0.500_000_1, Occupancy::Occupied),
            (1.0, Occupancy::Occupied),
        ] {
            let belief = Belief::of_probability(p_occ);
            assert_eq!(belief.p_occ().to_bits(), p_occ.to_bits());
            assert_eq!(belief.occupancy(), class, "{p_occ}");
        }
        assert_eq!(Belief::UNKNOWN.occupancy(), Occupancy::Unknown);
        let nan = Belief::of_probability(f32::NAN);
        assert_eq!(nan.occupancy(), Occupancy::Unknown);
    }

    #[test]
    fn scores_keep_their_order_and_their_side_of_zero() {
        let scores = [-3500.0, -3400.0, -1.0, -1e-3, 1e-9, 1e-3, 0.3, 200.0, 200.1];
        let p_occ = scores.map(|score| Belief::of_score(score).p_occ());
        assert!(p_occ.is_sorted_by(|low, high| low < high), "{p_occ:?}");
        for (score, p_occ) in scores.iter().zip(p_occ) {
            assert_eq!(*score > 0.0, p_occ > 0.5, "{score}");
        }
        assert_eq!(Belief::of_score(0.0).occupancy(), Occupancy::Free);
    }

    #[test]
    fn sums_near_a_half_are_unknown() {
        for (p_occ, class) in [
            (0.5 + 0.4e-6, Occupancy::Unknown),
            (0.5 - 0.4e-6, Occupancy::Unknown),
            (0.5 + 0.6e-6, Occupancy::Occupied),
            (0.5 - 0.6e-6, Occupancy::Free),
        ] {
            assert_eq!(Belief::of_sum(p_occ).occupancy(), class, "{p_occ}");
        }
    }
}
