//! What a reading of a cone says about a place in the cone.

use super::{Masses, Memberships};

/// Least and largest probability of a reading, so that no single one decides a cell.
const LEAST_PROBABILITY: f64 = 1e-4;

/// A place in a cone, and the reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConePlace {
    /// Distance of the place from the sensor, metres (rho).
    pub range_m: f64,
    /// Bearing of the place off the axis as a share of the half cone, in \[-1, 1\]
    /// (theta / theta_0).
    pub bearing_share: f64,
    /// The measured range, metres (R).
    pub measured_m: f64,
}

/// Inverse model of a sonar.
///
/// A reading R says that the cone is free before R and that a surface lies about R. How
/// much it says falls off the axis (alpha) and with the distance of the place (Delta):
///
/// ```text
/// alpha = 1 - (theta / theta_0)^2
/// Delta = 1 - (1 + tanh(2 (rho - rho_v))) / 2
/// q     = alpha Delta
/// ```
///
/// The paper prints no sensor model. The shapes are those of Elfes, Wijk and Oriolo as
/// MAPPERS section 4.2 restates them; the values are ours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SonarModel {
    /// Distance at which a place is trusted half as much as at the sensor, metres (rho_v).
    /// More: far readings say more, right and wrong ones.
    pub visibility_m: f64,
    /// Half width of the band about the reading in which the surface lies, metres (dR).
    /// More: thicker walls, more of them found.
    pub band_m: f64,
    /// Range from which on a reading is rejected, metres; the paper has 3.0.
    pub rejected_from_m: f64,
    /// Mass of a reading that is certain, below 1 (Dempster-Shafer). Less: less conflict
    /// between readings; the classes of cells hardly change.
    pub mass_cap: f64,
    /// Membership in `empty` of the best place of a reading (k_E).
    pub empty_gain: f64,
    /// Membership in `occupied` of the best place of a reading (k_O). The quotient of the
    /// two gains decides between a hit and several passes.
    pub occupied_gain: f64,
}

impl SonarModel {
    /// The model for cells of a size, metres: the band is 0.05 m and a cell, that is 0.15 m
    /// for cells of 0.10 m and 0.10 m for cells of 0.05 m.
    #[must_use]
    pub fn for_cells(cell_m: f64) -> Self {
        Self {
            visibility_m: 1.2,
            band_m: 0.05 + cell_m,
            rejected_from_m: 3.0,
            mass_cap: 0.9,
            empty_gain: 0.1,
            occupied_gain: 0.25,
        }
    }

    /// How much a reading says about a place, in \[0, 1\] (q).
    fn trust(&self, place: &ConePlace) -> f64 {
        let off_axis = (1.0 - place.bearing_share * place.bearing_share).max(0.0);
        let visibility = 0.5 * (1.0 - libm::tanh(2.0 * (place.range_m - self.visibility_m)));
        off_axis * visibility
    }

    /// Probability that the place is occupied, given the reading (L), with
    /// a = (rho - R) / dR:
    ///
    /// ```text
    /// (1 - q) / 2                     rho < R - 2 dR
    /// (1 - q (1 - (2 + a)^2)) / 2     R - 2 dR <= rho < R - dR
    /// (1 + q (1 - a^2)) / 2           R - dR <= rho < R + dR
    /// 1 / 2                           beyond
    /// ```
    ///
    /// Within 1e-4 of neither 0 nor 1.
    #[must_use]
    pub fn occupancy(&self, place: &ConePlace) -> f64 {
        let trust = self.trust(place);
        let along = (place.range_m - place.measured_m) / self.band_m;
        let lean = if along < -2.0 {
            -trust
        } else if along < -1.0 {
            -trust * (1.0 - (2.0 + along) * (2.0 + along))
        } else if along < 1.0 {
            trust * (1.0 - along * along)
        } else {
            0.0
        };
        (0.5 * (1.0 + lean)).clamp(LEAST_PROBABILITY, 1.0 - LEAST_PROBABILITY)
    }

    /// Masses of the reading: the cap times how far L lies from 1/2, on the side to which
    /// it leans.
    #[must_use]
    pub fn masses(&self, place: &ConePlace) -> Masses {
        let lean = 2.0 * self.occupancy(place) - 1.0;
        Masses {
            occupied: self.mass_cap * lean.max(0.0),
            empty: self.mass_cap * (-lean).max(0.0),
        }
    }

    /// Memberships of the reading, with a = (rho - R) / dR:
    ///
    /// ```text
    /// occupied   k_O q (1 - a^2)   |a| < 1; 0 elsewhere
    /// empty      k_E q             a < -1
    ///            k_E q a^2         -1 <= a < 0; 0 beyond
    /// ```
    #[must_use]
    pub fn memberships(&self, place: &ConePlace) -> Memberships {
        let trust = self.trust(place);
        let along = (place.range_m - place.measured_m) / self.band_m;
        let occupied = if along.abs() < 1.0 {
            self.occupied_gain * trust * (1.0 - along * along)
        } else {
            0.0
        };
        let empty = if along < -1.0 {
            self.empty_gain * trust
        } else if along < 0.0 {
            self.empty_gain * trust * along * along
        } else {
            0.0
        };
        Memberships { occupied, empty }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HALF_CONE_DEG: f64 = 12.5;

    fn place(range_m: f64, bearing_deg: f64) -> ConePlace {
        ConePlace {
            range_m,
            bearing_share: bearing_deg / HALF_CONE_DEG,
            measured_m: 2.0,
        }
    }

    #[test]
    fn g8_the_inverse_model_has_the_tabulated_values() {
        let model = SonarModel::for_cells(0.1);
        for (range_m, bearing_deg, expected) in [
            (0.5, 0.0, 0.028_662_088),
            (1.5, 0.0, 0.384_262_392),
            (1.75, 0.0, 0.455_666_449),
            (1.85, 0.0, 0.5),
            (2.0, 0.0, 0.519_582_861),
            (2.0, 6.25, 0.514_687_146),
            (2.1, 0.0, 0.507_388_054),
            (2.2, 0.0, 0.5),
        ] {
            let found = model.occupancy(&place(range_m, bearing_deg));
            assert!((found - expected).abs() < 1e-9, "{range_m}: {found}");
        }
        let empty = model.masses(&place(0.5, 0.0));
        assert!((empty.empty - 0.848_408_242).abs() < 1e-9, "{empty:?}");
        assert!(empty.occupied.abs() < 1e-15);
        let occupied = model.masses(&place(2.0, 0.0));
        assert!((occupied.occupied - 0.035_249_151).abs() < 1e-9);
        assert!(occupied.empty.abs() < 1e-15);
    }

    #[test]
    fn the_band_is_a_cell_and_five_centimetres() {
        for (cell_m, band_m) in [(0.10, 0.15), (0.05, 0.10)] {
            assert!((SonarModel::for_cells(cell_m).band_m - band_m).abs() < 1e-12);
        }
    }

    #[test]
    fn nothing_is_said_at_the_edge_of_the_cone_and_beyond_the_band() {
        let model = SonarModel::for_cells(0.1);
        for (range_m, bearing_deg) in [(0.5, 12.5), (2.0, -12.5), (2.15, 0.0), (3.0, 3.0)] {
            let place = place(range_m, bearing_deg);
            assert!((model.occupancy(&place) - 0.5).abs() < 1e-12, "{range_m}");
            let Memberships { occupied, empty } = model.memberships(&place);
            assert!(occupied.abs() < 1e-12 && empty.abs() < 1e-12, "{range_m}");
        }
    }
}
