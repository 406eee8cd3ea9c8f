//! Weighing: how likely is a wall here, given what the sensors see (line 3, eq. 2).

use heapless::Vec;

use super::Model;
use crate::geometry::Point;
use crate::math;
use crate::model::{Mount, RangeEstimate, Reading, SENSORS};

/// Squared distance from the arc, in variances, beyond which the support is zero: it
/// would be below exp(-12) = 6e-6, less than half a unit of a stored weight.
const FAR_SQUARED: f32 = 24.0;

/// The sensors' evidence for one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evaluation {
    /// P(wall here | readings) in [0, 1], peak-normalised: a score, not a density.
    pub weight: f32,
    /// Whether any usable sensor has the place within its largest bearing.
    pub in_view: bool,
    /// Whether any of them sees past it: its arc lies clearly behind the place.
    pub seen_past: bool,
}

impl Evaluation {
    pub(crate) const IN_VIEW: u8 = 1;
    pub(crate) const SEEN_PAST: u8 = 2;

    /// The weight in 16 bits, 65535 for 1.
    #[inline]
    pub(crate) fn packed_weight(&self) -> u16 {
        math::round_to_u32(self.weight * 65_535.0).min(65_535) as u16
    }

    #[inline]
    pub(crate) fn flags(&self) -> u8 {
        (if self.in_view { Self::IN_VIEW } else { 0 })
            | (if self.seen_past { Self::SEEN_PAST } else { 0 })
    }
}

/// One usable sensor's reading, prepared for a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Beam {
    /// Index on the ring.
    pub(crate) sensor: usize,
    pub(crate) mount: Mount,
    pub(crate) echo: RangeEstimate,
    /// Whether the echo is a surface; otherwise it is the limit of an empty lobe.
    pub(crate) surface: bool,
}

/// The readings of one step.
///
/// A sensor that is faulty or too close has no beam: it neither supports nor refutes
/// a particle, and Algorithm 2 draws nothing from it.
#[derive(Clone, Debug)]
pub struct Scan {
    /// By sensor index.
    beams: [Option<Beam>; SENSORS],
    /// The usable ones, in the order of their index.
    usable: Vec<Beam, SENSORS, u8>,
}

impl Scan {
    /// Prepares a step's readings.
    #[must_use]
    pub fn new(model: &Model, readings: &[Reading; SENSORS]) -> Self {
        let mut beams = [None; SENSORS];
        let mut usable = Vec::new();
        let mounts = model.mounts.iter().enumerate();
        for ((beam, (sensor, mount)), reading) in beams.iter_mut().zip(mounts).zip(readings) {
            let (echo, surface) = match *reading {
                Reading::Range(echo) => (echo, true),
                Reading::NothingInRange(limit) => (limit, false),
                Reading::TooClose | Reading::Faulty => continue,
            };
            let prepared = Beam {
                sensor,
                mount: *mount,
                echo,
                surface,
            };
            *beam = Some(prepared);
            // As many places as sensors: the push cannot be refused.
            let _ = usable.push(prepared);
        }
        Self { beams, usable }
    }

    /// The usable sensors.
    pub(crate) fn usable(&self) -> &[Beam] {
        &self.usable
    }

    /// The reading of a sensor, if it is usable.
    #[inline]
    pub(super) fn beam(&self, sensor: usize) -> Option<&Beam> {
        self.beams.get(sensor).and_then(Option::as_ref)
    }

    /// Weighs a place of the body frame.
    ///
    /// For each sensor that has it in view at range r and lobe S, with the reading's
    /// arc at x = x_0 S and the variance v = (sigma_0 S)^2 + sigma_m^2, a surface
    /// supports it with P = exp(-(r - x)^2 / (2 v)), and the supports join by
    /// De Morgan's law, w = 1 - prod (1 - P) (equation 2, whose printed form lacks
    /// the bracket). A sensor with r < x - margin sqrt(v) sees past the place and
    /// multiplies w by the veto. A lobe without a surface supports nothing.
    ///
    /// About 10 instructions, 20 more for each sensor that may have the place in view
    /// and 60 more for each that has.
    #[must_use]
    #[inline]
    pub fn weigh(&self, model: &Model, place: Point) -> Evaluation {
        let parameters = &model.parameters;
        let model_variance = parameters.model_error_m * parameters.model_error_m;
        let margin_squared = parameters.side_margin * parameters.side_margin;
        let mut unsupported = 1.0;
        let mut veto = 1.0;
        let mut in_view = false;
        let mut seen_past = false;
        for sensor in model.visibility.at(place).iter() {
            let Some(Some(beam)) = self.beams.get(sensor) else {
                continue;
            };
            let seen = beam.mount.sensor_from_body(place);
            if seen.x <= 0.0 || seen.y.abs() > model.beam_pattern.tangent_max() * seen.x {
                continue;
            }
            in_view = true;
            let range = seen.norm();
            let lobe = model.beam_pattern.at(seen.x / range);
            let sigma = beam.echo.sigma_m * lobe;
            let variance = sigma * sigma + model_variance;
            let short = beam.echo.range_m * lobe - range;
            let squared = short * short;
            if beam.surface && squared < FAR_SQUARED * variance {
                unsupported *= 1.0 - math::exp_of_minus(squared / (2.0 * variance));
            }
            if short > 0.0 && squared > margin_squared * variance {
                seen_past = true;
                veto *= parameters.veto;
            }
        }
        Evaluation {
            weight: (1.0 - unsupported) * veto,
            in_view,
            seen_past,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::{FilterParameters, Profile};
    use crate::model::{DifferentialDrive, Photometry, Ring, Sample};

    fn model(parameters: FilterParameters) -> Model {
        Model::new(
            parameters,
            Photometry::VCNL4020,
            &Ring::AMIRO,
            DifferentialDrive::AMIRO,
        )
    }

    fn scan(model: &Model, samples: [Sample; SENSORS]) -> Scan {
        Scan::new(model, &samples.map(|sample| model.photometry.read(sample)))
    }

    fn only(sensor: usize, sample: Sample) -> [Sample; SENSORS] {
        core::array::from_fn(|index| {
            if index == sensor {
                sample
            } else {
                Sample::Missing
            }
        })
    }

    fn on_axis(sensor: usize, range_m: f32) -> Point {
        Ring::AMIRO
            .mount(sensor)
            .body_from_sensor(Point::new(range_m, 0.0))
    }

    /// 78 counts: 0.1 m on the axis, sigma 2.4 mm.
    const TENTH: Sample = Sample::Counts(78);

    #[test]
    fn weight_is_one_on_the_arc_and_falls_as_the_normal_curve() {
        let model = model(FilterParameters::PAPER);
        let scan = scan(&model, only(3, TENTH));
        let echo = model.photometry.range_estimate(78.0).unwrap();
        let sigma = math::sqrt(echo.sigma_m * echo.sigma_m + 0.008 * 0.008);
        for (offset, expected) in [
            (0.0, 1.0),
            (1.0, 0.606_53),
            (-1.0, 0.606_53),
            (2.0, 0.135_34),
        ] {
            let view = scan.weigh(&model, on_axis(3, echo.range_m + offset * sigma));
            assert!(
                (view.weight - expected).abs() < 1e-3,
                "{offset} sigma: {view:?}"
            );
            assert!(view.in_view);
        }
    }

    #[test]
    fn arc_bends_with_the_lobe() {
        let model = model(FilterParameters::PAPER);
        let scan = scan(&model, only(3, TENTH));
        for degrees in [-55.0_f32, -30.0, 10.0, 50.0] {
            let bearing = degrees.to_radians();
            let range = model.photometry.range_m(78.0, bearing).unwrap();
            let (sine, cosine) = math::sin_cos(bearing);
            let place = Ring::AMIRO
                .mount(3)
                .body_from_sensor(Point::new(range * cosine, range * sine));
            let view = scan.weigh(&model, place);
            assert!(view.weight > 0.999, "{degrees} degrees: {view:?}");
        }
    }

    /// The place at a bearing of sensor 3, so many standard deviations of the sensor's own
    /// behind its arc.
    fn off_the_arc(model: &Model, degrees: f32, sigmas: f32) -> Point {
        let echo = model.photometry.range_estimate(78.0).unwrap();
        let (sine, cosine) = math::sin_cos(degrees.to_radians());
        let range = (echo.range_m + sigmas * echo.sigma_m) * model.beam_pattern.at(cosine);
        Ring::AMIRO
            .mount(3)
            .body_from_sensor(Point::new(range * cosine, range * sine))
    }

    #[test]
    fn the_sensor_s_noise_bends_with_the_lobe_as_its_arc_does() {
        // Without a model error the distance in standard deviations is the same at
        // every bearing.
        let model = model(FilterParameters {
            model_error_m: 0.0,
            ..FilterParameters::PAPER
        });
        let scan = scan(&model, only(3, TENTH));
        for degrees in [-55.0, -30.0, 0.0, 50.0] {
            for (sigmas, expected) in [(1.0, 0.606_53), (-2.0, 0.135_34)] {
                let view = scan.weigh(&model, off_the_arc(&model, degrees, sigmas));
                // A tenth of a millimetre is 4 % of a standard deviation; f32 and the
                // lobe's table are a thousandth of that.
                assert!(
                    (view.weight - expected).abs() < 2e-3,
                    "{degrees} degrees, {sigmas} sigma: {view:?}"
                );
            }
        }
    }

    #[test]
    fn support_ends_where_it_is_less_than_half_a_stored_unit() {
        // exp(-12) at the square root of 24, 4.899 sigma.
        let model = model(FilterParameters {
            model_error_m: 0.0,
            ..FilterParameters::PAPER
        });
        let scan = scan(&model, only(3, TENTH));
        for sign in [-1.0, 1.0] {
            let inside = scan.weigh(&model, off_the_arc(&model, 0.0, 4.85 * sign));
            assert!((5e-6..1e-5).contains(&inside.weight), "{inside:?}");
            let outside = scan.weigh(&model, off_the_arc(&model, 0.0, 4.95 * sign));
            assert_eq!(outside.weight.to_bits(), 0, "{outside:?}");
            assert_eq!(outside.packed_weight(), 0);
        }
    }

    #[test]
    fn a_place_is_seen_past_from_the_side_margin_in_front_of_the_arc() {
        for side_margin in [1.0, 2.0] {
            let model = model(FilterParameters {
                model_error_m: 0.0,
                side_margin,
                ..FilterParameters::PLUS
            });
            let scan = scan(&model, only(3, TENTH));
            for (sigmas, seen_past) in [
                (-side_margin - 0.05, true),
                (-side_margin + 0.05, false),
                (-0.1, false),
                (side_margin + 0.5, false),
                (6.0, false),
            ] {
                let view = scan.weigh(&model, off_the_arc(&model, 20.0, sigmas));
                assert_eq!(
                    (view.in_view, view.seen_past),
                    (true, seen_past),
                    "margin {side_margin}, {sigmas} sigma"
                );
            }
        }
    }

    #[test]
    fn a_weight_is_stored_in_65535_parts_beside_what_was_seen() {
        let view = |weight| Evaluation {
            weight,
            in_view: true,
            seen_past: false,
        };
        for (weight, stored) in [(0.0, 0), (0.2, 13_107), (0.5, 32_768), (1.0, 65_535)] {
            assert_eq!(view(weight).packed_weight(), stored, "{weight}");
        }
        assert_eq!(view(1.0).flags(), Evaluation::IN_VIEW);
        let past = Evaluation {
            seen_past: true,
            ..view(1.0)
        };
        assert_eq!(past.flags(), Evaluation::IN_VIEW | Evaluation::SEEN_PAST);
    }

    #[test]
    fn supports_join_by_de_morgan() {
        // Both front sensors, a place between them on both arcs' one-sigma side.
        let model = model(FilterParameters::PAPER);
        let place = Point::new(0.15, 0.0);
        let alone = [3, 4].map(|sensor| {
            scan(&model, only(sensor, TENTH))
                .weigh(&model, place)
                .weight
        });
        let mut samples = only(3, TENTH);
        samples[4] = TENTH;
        let both = scan(&model, samples).weigh(&model, place).weight;
        let expected = 1.0 - (1.0 - alone[0]) * (1.0 - alone[1]);
        assert!(
            (both - expected).abs() < 1e-6 && both > alone[0],
            "{both}, {alone:?}"
        );
    }

    #[test]
    fn an_empty_lobe_supports_nothing_and_is_seen_through() {
        let model = model(FilterParameters::PAPER);
        let scan = scan(&model, only(3, Sample::Counts(0)));
        let near = scan.weigh(&model, on_axis(3, 0.15));
        assert_eq!(
            (near.weight.to_bits(), near.in_view, near.seen_past),
            (0, true, true)
        );
        let far = scan.weigh(&model, on_axis(3, 0.195));
        assert_eq!(
            (far.weight.to_bits(), far.in_view, far.seen_past),
            (0, true, false)
        );
    }

    #[test]
    fn no_sensor_sees_behind_itself_or_beyond_sixty_degrees() {
        let model = model(FilterParameters::PAPER);
        let scan = scan(&model, only(3, TENTH));
        let mount = Ring::AMIRO.mount(3);
        for (x, y) in [(-0.05, 0.0), (0.0, 0.0), (0.01, 0.1), (0.05, 0.0867)] {
            let view = scan.weigh(&model, mount.body_from_sensor(Point::new(x, y)));
            assert!(!view.in_view && view.weight == 0.0, "({x}, {y}): {view:?}");
        }
        let edge = scan.weigh(&model, mount.body_from_sensor(Point::new(0.05, 0.0865)));
        assert!(edge.in_view);
    }

    #[test]
    fn veto_of_plus_lets_one_sensor_refute_another() {
        // Sensor 3 sees something at 0.1 m, sensor 4 looks through the same place.
        let place = Point::new(0.15, 0.0);
        let mut samples = only(3, TENTH);
        samples[4] = Sample::Counts(0);
        let weights = [Profile::Paper, Profile::Plus].map(|profile| {
            let model = model(profile.parameters());
            scan(&model, samples).weigh(&model, place).weight
        });
        assert!((weights[1] - 0.1 * weights[0]).abs() < 1e-6, "{weights:?}");
    }

    #[test]
    fn faulty_and_too_close_sensors_have_no_beam() {
        let model = model(FilterParameters::PAPER);
        for sample in [Sample::Missing, Sample::Saturated] {
            let scan = scan(&model, [sample; SENSORS]);
            assert!(scan.usable().is_empty());
            assert!(!scan.weigh(&model, on_axis(3, 0.01)).in_view);
        }
    }
}
