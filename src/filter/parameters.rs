//! Every choice of the filter as a named parameter, and the profiles.

use serde::{Deserialize, Serialize};

/// The filters that ship.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Profile {
    /// The faithful filter: SIR with systematic resampling, counting by equation 3.
    #[default]
    Paper,
    /// Ours: Bernoulli survival, side test on rejection, veto, uniform search of empty lobes.
    Plus,
    /// For surfaces that fill the lobes: particles weighed against tracked wall segments.
    Wall,
}

impl Profile {
    /// The parameters of this profile.
    #[must_use]
    pub const fn parameters(self) -> FilterParameters {
        match self {
            Self::Paper => FilterParameters::PAPER,
            Self::Plus => FilterParameters::PLUS,
            Self::Wall => FilterParameters::WALL,
        }
    }
}

/// How the weights select the survivors (line 9 of Algorithm 1; the paper does not define it).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SurvivalRule {
    /// Systematic resampling: equidistant pointers over the weights, one per live particle;
    /// a particle with a pointer survives, once. Relative: of bad guesses the best survive.
    Systematic,
    /// Each particle survives with probability of its own weight. Absolute, one
    /// pass, independent of the order of the particles.
    Bernoulli,
    /// The same, with weights from the wall segments that a tracker fits to all readings
    /// of the last steps ([`WallParameters`](super::WallParameters)), and a gate in
    /// travel: one step per 10 mm.
    BernoulliOnWalls,
}

/// Where Algorithm 2 searches in the lobe of a sensor that has nothing in range.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum NothingDraw {
    /// On the arc at the range limit, with the sensor's noise there.
    AtLimit,
    /// Uniformly over the lobe's area.
    OverLobe,
}

/// Parameters of the filter.
///
/// The doc of each field gives its meaning and unit, what more of it does, and why
/// the two profiles hold what they hold; the effects are measured in
/// `docs/decisions.md`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FilterParameters {
    /// Who survives. `paper`: systematic, the only rule that reproduces figure 4's
    /// 80 %; `plus`: Bernoulli, since an absolute test does not inflate bad sets.
    pub survival: SurvivalRule,
    /// Innovation gate g, survived steps: a survivor counts as a surface from its
    /// g-th survival on. More: fewer false cells, thinner walls. 1 to 200. `paper`:
    /// 4, as in its evaluation; `plus`: 5, the measured optimum.
    pub gate: u8,
    /// Model error sigma_m, metres, added in quadrature to the sensor's in the
    /// weight, not in the draw. More: particles of curved and edge-on surfaces
    /// survive, walls get thicker. Not in the paper and indispensable: near the hull
    /// sigma_x is 0.3 mm, while a wall leaves the measured arc by several
    /// millimetres. 8 mm in both profiles.
    pub model_error_m: f32,
    /// Standard deviation of a wheel's travel as a share of it. More: the set
    /// spreads, thin walls blur. 0.05 in both: 0 and 0.05 map alike, 0.10 is worse.
    pub wheel_noise: f32,
    /// Radius of the local map about the robot's centre, metres; a particle beyond
    /// it is redrawn and counts nothing. At most 0.5. 0.32 in both: hull, x_max and
    /// three sigma of the draws at x_max fit inside.
    pub local_radius_m: f32,
    /// Whether a rejected particle counts as free only if some sensor sees past it.
    /// `paper`: off (equation 3 as printed); `plus`: on, else wall interiors turn free.
    pub side_test: bool,
    /// How far in front of a reading's arc a particle must lie to be seen past, in
    /// standard deviations of reading and model together. 1 in both.
    pub side_margin: f32,
    /// Factor on the weight for each sensor that sees past the particle, 0 to 1.
    /// `paper`: 1 (off; equation 2 is a pure OR); `plus`: 0.1.
    pub veto: f32,
    /// Search of empty lobes. `paper`: at the limit, the closest reading of
    /// Algorithm 2; `plus`: over the lobe, which frees more near space.
    pub nothing_draw: NothingDraw,
}

impl FilterParameters {
    /// The profile `paper`.
    pub const PAPER: Self = Self {
        survival: SurvivalRule::Systematic,
        gate: 4,
        model_error_m: 0.008,
        wheel_noise: 0.05,
        local_radius_m: 0.32,
        side_test: false,
        side_margin: 1.0,
        veto: 1.0,
        nothing_draw: NothingDraw::AtLimit,
    };

    /// The profile `plus`.
    pub const PLUS: Self = Self {
        survival: SurvivalRule::Bernoulli,
        gate: 5,
        side_test: true,
        veto: 0.1,
        nothing_draw: NothingDraw::OverLobe,
        ..Self::PAPER
    };
}

impl FilterParameters {
    /// The profile `wall`: a gate of 50 mm of travel and at least two survivals.
    pub const WALL: Self = Self {
        survival: SurvivalRule::BernoulliOnWalls,
        ..Self::PLUS
    };
}

impl Default for FilterParameters {
    fn default() -> Self {
        Self::PAPER
    }
}

/// A parameter outside its range; names the parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ParameterError {
    /// The parameter's name, as in its struct.
    pub parameter: &'static str,
    /// The range it must lie in, in words.
    pub range: &'static str,
}

impl ParameterError {
    /// Refuses `parameter` unless `holds`. A comparison with NaN does not hold.
    pub(crate) const fn unless(
        holds: bool,
        parameter: &'static str,
        range: &'static str,
    ) -> Result<(), Self> {
        if holds {
            Ok(())
        } else {
            Err(Self { parameter, range })
        }
    }
}

impl core::fmt::Display for ParameterError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{} must be {}", self.parameter, self.range)
    }
}

impl core::error::Error for ParameterError {}

impl FilterParameters {
    /// Checks every field against its range.
    ///
    /// # Errors
    /// The first field that is outside its range, NaN included.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let unless = ParameterError::unless;
        unless((1..=200).contains(&self.gate), "gate", "1 to 200 steps")?;
        unless(
            (0.0..=0.1).contains(&self.model_error_m),
            "model_error_m",
            "0 to 0.1 m",
        )?;
        unless(
            (0.0..=1.0).contains(&self.wheel_noise),
            "wheel_noise",
            "0 to 1",
        )?;
        unless(
            (0.05..=0.5).contains(&self.local_radius_m),
            "local_radius_m",
            "0.05 to 0.5 m",
        )?;
        unless(
            (0.0..=10.0).contains(&self.side_margin),
            "side_margin",
            "0 to 10",
        )?;
        unless((0.0..=1.0).contains(&self.veto), "veto", "0 to 1")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_profiles_are_legal() {
        for profile in [Profile::Paper, Profile::Plus, Profile::Wall] {
            assert_eq!(profile.parameters().validate(), Ok(()));
        }
    }

    #[test]
    fn the_profiles_differ_in_five_choices_and_share_the_rest() {
        let paper = FilterParameters {
            survival: SurvivalRule::Systematic,
            gate: 4,
            model_error_m: 0.008,
            wheel_noise: 0.05,
            local_radius_m: 0.32,
            side_test: false,
            side_margin: 1.0,
            veto: 1.0,
            nothing_draw: NothingDraw::AtLimit,
        };
        assert_eq!(Profile::Paper.parameters(), paper);
        let plus = FilterParameters {
            survival: SurvivalRule::Bernoulli,
            gate: 5,
            side_test: true,
            veto: 0.1,
            nothing_draw: NothingDraw::OverLobe,
            ..paper
        };
        assert_eq!(Profile::Plus.parameters(), plus);
    }

    #[test]
    fn a_bad_parameter_is_named() {
        let bad = FilterParameters {
            veto: f32::NAN,
            ..FilterParameters::PAPER
        };
        assert_eq!(bad.validate().unwrap_err().parameter, "veto");
        let bad = FilterParameters {
            gate: 0,
            ..FilterParameters::PAPER
        };
        let error = bad.validate().unwrap_err();
        assert_eq!(error.to_string(), "gate must be 1 to 200 steps");
    }
}
