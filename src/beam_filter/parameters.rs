//! Every choice of the beam filter as a named parameter, and its two forms.

use serde::{Deserialize, Serialize};

use crate::filter::ParameterError;

/// Where a particle enters the disc again after the motion moved it out.
///
/// The particle behind the robot is lost; space ahead of it has come into the disc. The
/// weight at re-entry is 0.5.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reentry {
    /// At the opposite point of the rim, p r / -|p|: the text of \[KS\], "on the other side".
    ///
    /// A clump that leaves enters again as a clump.
    Opposite,
    /// On the rim, at a uniform bearing within 60 degrees of the motion.
    RimAhead,
    /// Uniformly in the crescent that the step has newly covered.
    ///
    /// The only rule that keeps the density of a uniform set uniform.
    Crescent,
}

/// Parameters of the beam filter.
///
/// Symbols are those of \[KS\] table 1, which prints no values: every value is ours.
/// [`Self::MOVING`] has measurements.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BeamFilterParameters {
    /// Radius of the disc about the robot, metres (r); 0.1 to 10. More: obstacles are kept
    /// for longer, with fewer particles per area. A little more than the range of the
    /// sensor: 1.0 for 0.8 m (infrared triangulation), 1.5 for time of flight.
    pub local_radius_m: f32,
    /// Distance from a beam within which it sets weights, metres (l_w, printed as l_y,
    /// "length of the beam"); 0.001 to a quarter of the radius. More: more particles per
    /// beam, thicker walls. 0.02, and 0.04 for time of flight.
    pub beam_tolerance_m: f32,
    /// Change of the weight at the edge of the tolerance (e_y), 0 to less than 0.5. The
    /// last beam of a sweep that reaches a particle reaches it at the edge, so most weights
    /// end near e_y or 1 - e_y. 0.1; at 0.5 ("probability of error" of one half, taken
    /// literally) few particles stay high.
    pub measurement_error: f32,
    /// Share by which a weight returns to 0.5 per cycle (e_w), 0 to 1. More: moved
    /// obstacles fade sooner. 0.002 per cycle of one beam, 0.01 per cycle of 32 beams.
    /// \[KS\] decays per reading.
    pub decay: f32,
    /// Standard deviation of the motion per axis, as a share of its length (e_m), 0 to 1.
    /// More: walls blur behind the sensors. 0.05.
    pub motion_noise: f32,
    /// Number of cycles from one resampling to the next (n_r), 0 to 10 000; 0 is never.
    /// More: fewer particles at obstacles. 10 cycles of one beam, 2 cycles of 32 beams.
    pub resampling_period: u16,
    /// Share of the low particles that resampling leaves where they are, 0 to 1: scouts in
    /// empty space, which find an obstacle that moves there (guideline 2 of \[KS\]). 0.05.
    pub scout_share: f32,
    /// Share of the other low particles that resampling scatters over the disc with weight
    /// 0.5, 0 to 1; it moves the rest to obstacles. `PAPER`: 0, all are moved; `MOVING`:
    /// 0.5. At 0 the particles collect at the first obstacles and leave the disc with them.
    pub scatter_share: f32,
    /// Where a particle enters again. `PAPER`: opposite; `MOVING`: crescent.
    pub reentry: Reentry,
}

impl BeamFilterParameters {
    /// The paper's form, with the figures for its experiment: one infrared triangulation
    /// sensor on a servo, one beam per cycle.
    pub const PAPER: Self = Self {
        local_radius_m: 1.0,
        beam_tolerance_m: 0.02,
        measurement_error: 0.1,
        decay: 0.002,
        motion_noise: 0.05,
        resampling_period: 10,
        scout_share: 0.05,
        scatter_share: 0.0,
        reentry: Reentry::Opposite,
    };

    /// The form for a robot that moves: half of the low particles are scattered, and those
    /// that leave enter in the crescent ahead.
    ///
    /// The paper says that its resampling is efficient only while robot and obstacles
    /// stand still. Measured on the recordings `nano_swarm` (126 scans of drones, poses of a
    /// motion capture system, exact walls; 1000 particles, [`Self::for_frames`], 3 seeds),
    /// with `PAPER` in brackets: error of the nearest obstacle 1.6 to 1.8 cm in the median
    /// (4.7 to 5.1) and 4.4 to 5.4 cm at 90 % (41 to 50), share of the visible wall found
    /// 0.74 to 0.76 (0.33 to 0.34), share of high particles within 10 cm of a wall 0.93 to
    /// 0.94 (0.93 to 0.95). The nearest end point of the scan itself is off by 1.3 cm: the
    /// filter gives memory of fixed size, not accuracy.
    pub const MOVING: Self = Self {
        scatter_share: 0.5,
        reentry: Reentry::Crescent,
        ..Self::PAPER
    };

    /// The same form with the figures for a sensor that gives a frame of beams per cycle,
    /// as a ring of time-of-flight cameras with a range of 1.5 to 2 m.
    #[must_use]
    pub const fn for_frames(self) -> Self {
        Self {
            local_radius_m: 1.5,
            beam_tolerance_m: 0.04,
            decay: 0.01,
            resampling_period: 2,
            ..self
        }
    }

    /// Checks every field against its range.
    ///
    /// # Errors
    /// The first field that is outside its range, NaN included.
    pub fn validate(&self) -> Result<(), ParameterError> {
        let unless = ParameterError::unless;
        let share = 0.0..=1.0;
        unless(
            (0.1..=10.0).contains(&self.local_radius_m),
            "local_radius_m",
            "0.1 to 10 m",
        )?;
        unless(
            (0.001..=0.25 * self.local_radius_m).contains(&self.beam_tolerance_m),
            "beam_tolerance_m",
            "0.001 m to a quarter of local_radius_m",
        )?;
        unless(
            (0.0..0.5).contains(&self.measurement_error),
            "measurement_error",
            "0 to less than 0.5",
        )?;
        unless(share.contains(&self.decay), "decay", "0 to 1")?;
        unless(share.contains(&self.motion_noise), "motion_noise", "0 to 1")?;
        unless(
            self.resampling_period <= 10_000,
            "resampling_period",
            "0 to 10 000 cycles",
        )?;
        unless(share.contains(&self.scout_share), "scout_share", "0 to 1")?;
        unless(
            share.contains(&self.scatter_share),
            "scatter_share",
            "0 to 1",
        )
    }
}

impl Default for BeamFilterParameters {
    fn default() -> Self {
        Self::MOVING
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam_filter::BeamModel;

    #[test]
    fn both_forms_are_legal_and_differ_in_two_choices() {
        let (paper, moving) = (BeamFilterParameters::PAPER, BeamFilterParameters::MOVING);
        for form in [paper, moving, paper.for_frames(), moving.for_frames()] {
            assert_eq!(form.validate(), Ok(()), "{form:?}");
        }
        let changed = BeamFilterParameters {
            scatter_share: 0.5,
            reentry: Reentry::Crescent,
            ..paper
        };
        assert_eq!(moving, changed);
    }

    #[test]
    fn a_model_names_the_parameter_that_is_out_of_range() {
        type Change = fn(&mut BeamFilterParameters, f32);
        let changes: [(&str, Change); 7] = [
            ("local_radius_m", |p, x| p.local_radius_m = x),
            ("beam_tolerance_m", |p, x| p.beam_tolerance_m = x),
            ("measurement_error", |p, x| p.measurement_error = x),
            ("decay", |p, x| p.decay = x),
            ("motion_noise", |p, x| p.motion_noise = x),
            ("scout_share", |p, x| p.scout_share = x),
            ("scatter_share", |p, x| p.scatter_share = x),
        ];
        for (name, change) in changes {
            for bad in [f32::NAN, f32::INFINITY, -0.1, 10.1] {
                let mut parameters = BeamFilterParameters::PAPER;
                change(&mut parameters, bad);
                let error = BeamModel::new(parameters).unwrap_err();
                assert_eq!(error.parameter, name, "{bad}");
            }
        }
        let parameters = BeamFilterParameters {
            measurement_error: 0.5,
            ..BeamFilterParameters::PAPER
        };
        let error = BeamModel::new(parameters).unwrap_err();
        assert_eq!(
            error.to_string(),
            "measurement_error must be 0 to less than 0.5"
        );
    }
}
