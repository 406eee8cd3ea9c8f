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
}
