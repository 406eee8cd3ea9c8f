//! A range beam: one measurement of a narrow sensor, as a segment in the body frame.

use super::BeamModel;
use crate::geometry::{Point, Pose, Rotation};
use crate::math;

/// What a range sensor reports along its beam.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BeamRange {
    /// An obstacle at this distance from the sensor, metres.
    Echo(f32),
    /// No obstacle up to this distance, metres: the sensor's maximum range.
    ///
    /// \[KS\] treats it as an obstacle at that distance; the ring of its figure 6 is the
    /// effect.
    NoEcho(f32),
}

/// A measurement or a mount that is no beam.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BeamError {
    /// The range is not a number in 0 to [`RangeBeam::MOST_RANGE_M`].
    Range,
    /// The mount is not finite or farther than [`RangeBeam::MOST_OFFSET_M`] from the centre.
    Mount,
}

impl core::fmt::Display for BeamError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Range => "the range of a beam must be 0 to 100 m",
            Self::Mount => "the mount of a beam must be finite and within 10 m of the centre",
        })
    }
}

impl core::error::Error for BeamError {}

/// A beam in the body frame: a segment from the sensor, and whether an obstacle ends it.
///
/// Every value is legal: start and length are finite and bounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RangeBeam {
    start: Point,
    direction: Rotation,
    length_m: f32,
    has_echo: bool,
}

impl RangeBeam {
    /// The longest range accepted, metres.
    pub const MOST_RANGE_M: f32 = 100.0;

    /// The largest distance of a sensor from the robot's centre accepted, metres.
    pub const MOST_OFFSET_M: f32 = 10.0;

    /// The beam of a sensor at `mount` (`body_from_sensor`, looking along its x axis).
    ///
    /// Costs one sine and cosine.
    ///
    /// # Errors
    /// [`BeamError::Range`]: the range is NaN, infinite, negative or too long.
    /// [`BeamError::Mount`]: the mount is not finite or too far from the centre.
    pub fn new(mount: &Pose, range: BeamRange) -> Result<Self, BeamError> {
        let (length_m, has_echo) = match range {
            BeamRange::Echo(length_m) => (length_m, true),
            BeamRange::NoEcho(length_m) => (length_m, false),
        };
        if !(0.0..=Self::MOST_RANGE_M).contains(&length_m) {
            return Err(BeamError::Range);
        }
        let is_near = mount.position.norm_squared() <= Self::MOST_OFFSET_M * Self::MOST_OFFSET_M;
        if !mount.is_finite() || !is_near {
            return Err(BeamError::Mount);
        }
        Ok(Self {
            start: mount.position,
            direction: Rotation::by(mount.heading.radians()),
            length_m,
            has_echo,
        })
    }

    /// The weight that the beam gives to a position of the body frame; none far from it.
    ///
    /// With d_y the distance to the beam's end and d_l the distance to the segment
    /// (\[KS\] Algorithm 2, corrected):
    ///
    /// - d_y <= l_w and an echo: w = 1 - e_y d_y / l_w
    /// - d_l <= l_w: w = e_y d_l / l_w
    ///
    /// The test across the beam comes first: it refuses most particles after ten
    /// operations and is exact.
    #[inline]
    pub(super) fn weight_at(&self, model: &BeamModel, body: Point) -> Option<f32> {
        let offset = body - self.start;
        let Rotation { sine, cosine } = self.direction;
        let across = cosine * offset.y - sine * offset.x;
        if across.abs() > model.parameters().beam_tolerance_m {
            return None;
        }
        let along = cosine * offset.x + sine * offset.y;
        let past_end = along - self.length_m;
        let end_squared = across * across + past_end * past_end;
        if self.has_echo && end_squared <= model.tolerance_squared {
            return Some(1.0 - math::sqrt(end_squared) * model.error_per_metre);
        }
        let outside = if along < 0.0 {
            along
        } else {
            past_end.max(0.0)
        };
        let beam_squared = across * across + outside * outside;
        if beam_squared > model.tolerance_squared {
            return None;
        }
        Some(math::sqrt(beam_squared) * model.error_per_metre)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam_filter::{BeamFilterParameters, BeamParticle};

    fn model(beam_tolerance_m: f32) -> BeamModel {
        BeamModel::new(BeamFilterParameters {
            local_radius_m: 4.0,
            beam_tolerance_m,
            measurement_error: 0.1,
            ..BeamFilterParameters::PAPER
        })
        .unwrap()
    }

    fn ahead(range: BeamRange) -> RangeBeam {
        RangeBeam::new(&Pose::default(), range).unwrap()
    }

    fn weight(range: BeamRange, x: f32, y: f32) -> Option<f32> {
        ahead(range).weight_at(&model(0.02), Point::new(x, y))
    }

    /// The printed rule: the distance to the infinite line through the beam.
    fn printed_line(x: f32, y: f32) -> Option<f32> {
        let from_end = Point::new(x - 1.0, y).norm();
        if from_end <= 0.02 {
            return Some(1.0 - from_end / 0.02 * 0.1);
        }
        (y.abs() <= 0.02).then(|| y.abs() / 0.02 * 0.1)
    }

    #[test]
    fn g9_weights_along_a_beam_of_one_metre() {
        // Floats near 1 are 6e-8 apart, the slope is 5 per metre: 1e-6 is enough.
        for (x, y, expected) in [
            (1.0, 0.0, 1.0),
            (1.0, 0.01, 0.95),
            (1.0199, 0.0, 0.9005),
            (0.5, 0.01, 0.05),
            (-0.01, 0.0, 0.05),
        ] {
            let given = weight(BeamRange::Echo(1.0), x, y).unwrap();
            assert!((given - expected).abs() < 1e-6, "({x}, {y}): {given}");
        }
    }

    #[test]
    fn g9_a_line_instead_of_a_segment_clears_behind_robot_and_obstacle() {
        for (x, y) in [(-0.5, 0.0), (1.5, 0.0)] {
            assert_eq!(weight(BeamRange::Echo(1.0), x, y), None, "({x}, {y})");
            assert_eq!(printed_line(x, y), Some(0.0), "({x}, {y}) as printed");
        }
    }

    #[test]
    fn g9_the_beam_s_length_as_tolerance_makes_obstacles_of_free_space() {
        // Half way along the beam: free with a tolerance, an obstacle as printed.
        let point = Point::new(0.5, 0.0);
        let beam = ahead(BeamRange::Echo(1.0));
        assert_eq!(beam.weight_at(&model(0.02), point), Some(0.0));
        assert!(beam.weight_at(&model(1.0), point).unwrap() > 0.9);
    }

    #[test]
    fn g9_no_echo_clears_up_to_its_end_where_the_printed_maximum_marks_a_ring() {
        assert_eq!(weight(BeamRange::NoEcho(1.0), 1.0, 0.0), Some(0.0));
        assert_eq!(weight(BeamRange::NoEcho(1.0), 0.5, 0.0), Some(0.0));
        assert_eq!(weight(BeamRange::Echo(1.0), 1.0, 0.0), Some(1.0));
    }

    #[test]
    fn g9_an_error_of_nearly_one_half_leaves_no_obstacle_and_no_free_space_at_the_edge() {
        // The last beam of a sweep reaches most particles at the edge of its tolerance.
        let at_edge = |measurement_error: f32| {
            let model = BeamModel::new(BeamFilterParameters {
                measurement_error,
                ..BeamFilterParameters::PAPER
            })
            .unwrap();
            let weight = |x, y| {
                let beam = ahead(BeamRange::Echo(0.6));
                let weight = beam.weight_at(&model, Point::new(x, y)).unwrap();
                BeamParticle {
                    weight,
                    ..BeamParticle::default()
                }
            };
            (weight(0.6, 0.0199), weight(0.3, 0.0199))
        };
        let (end, along) = at_edge(0.1);
        assert!(end.is_high() && along.is_low(), "{end:?}, {along:?}");
        let (end, along) = at_edge(0.49);
        assert!(!end.is_high() && !along.is_low(), "{end:?}, {along:?}");
    }

    #[test]
    fn a_mounted_sensor_looks_from_its_place_in_its_direction() {
        let mount = Pose::new(0.1, 0.05, core::f32::consts::FRAC_PI_2);
        let beam = RangeBeam::new(&mount, BeamRange::Echo(0.4)).unwrap();
        let at = |x, y| beam.weight_at(&model(0.02), Point::new(x, y));
        assert!(at(0.1, 0.45).unwrap() > 0.999);
        assert!(at(0.1, 0.2).unwrap() < 0.001);
        assert_eq!(at(0.4, 0.05), None);
    }

    #[test]
    fn what_is_no_range_and_no_mount_is_refused() {
        let mount = Pose::default();
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.1, 100.1] {
            for range in [BeamRange::Echo(bad), BeamRange::NoEcho(bad)] {
                assert_eq!(RangeBeam::new(&mount, range), Err(BeamError::Range));
            }
        }
        for bad in [f32::NAN, f32::INFINITY, 1e30, 11.0] {
            let mount = Pose::new(bad, 0.0, 0.0);
            let refused = RangeBeam::new(&mount, BeamRange::Echo(1.0));
            assert_eq!(refused, Err(BeamError::Mount), "{bad}");
        }
        let turned = Pose::new(0.0, 0.0, f32::NAN);
        assert!(RangeBeam::new(&turned, BeamRange::Echo(1.0)).is_err());
    }
}
