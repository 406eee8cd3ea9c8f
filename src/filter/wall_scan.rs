//! Weighing and drawing by upper bounds, against tracked wall segments (the profile
//! `wall`) or without them (`arcs`).
//!
//! A particle at p is supported by a seen segment with normal n and distance h from the
//! robot's centre if it lies between its ends and in the lobe of a sensor that claims it:
//!
//! ```text
//! e       h - n.p, before the wall positive
//! v       (3 mm)^2 + (2 % of h)^2
//! q       cos(xi t) cos^3(i), what the element at p returns as seen by the sensor
//! P       min(1, q / (q_min q_max)) exp(-e^2 / 2 v)
//! w       1 - prod (1 - P), as equation 2 joins the supports
//! ```
//!
//! Beside a segment, and a little beyond its ends, nothing is refuted. Elsewhere a sensor
//! sees past a place only well inside its arc, r < kappa x, and near its axis: the counts
//! give an upper bound of the range to a surface that does not fill the lobe. A reading
//! that no segment explains supports nothing. Without a tracker each surface supports the
//! places on its arc, as in [`Scan::weigh`].

use heapless::Vec;
use rand_core::Rng;

use super::seen_wall::{FAR_SQUARED, SeenWall};
use super::segments::{MAX_SEGMENTS, SegmentModel};
use super::weigh::Beam;
use super::{Evaluation, FilterParameters, Model, ParticleSet, Scan, WallParameters};
use crate::geometry::Point;
use crate::math;
use crate::model::{SENSORS, SensorMask};
use crate::random::{nearly_normal, uniform, uniform_below_and_within};

/// Least cosine of the incidence at which a particle is drawn on a segment.
const LEAST_INCIDENCE: f32 = 0.2;

/// The readings of one step with the segments that explain them.
pub(super) struct WallScan<'m> {
    model: &'m Model,
    parameters: &'m WallParameters,
    scan: Scan,
    walls: Vec<SeenWall, MAX_SEGMENTS>,
    /// Tangent of the largest bearing at which a reading refutes.
    side_tangent: f32,
    /// By sensor, the squared range beyond which a reading refutes nothing, and the one within
    /// which it refutes everything near its axis, square metres.
    refuted_squared: [(f32, f32); SENSORS],
    /// The sensors that a segment explains.
    explained: SensorMask,
}

impl<'m> WallScan<'m> {
    /// Prepares a step; `None` if the model has no walls.
    pub(super) fn new<const N: usize>(
        model: &'m Model,
        set: &ParticleSet<N>,
        scan: Scan,
    ) -> Option<Self> {
        let parameters = model.walls?;
        let mut walls = Vec::new();
        let seen = |segments: &SegmentModel| set.tracker.seen(segments, parameters);
        for segment in set.segment_model.as_ref().map(seen).iter().flatten() {
            if let Some(wall) = SeenWall::of(model, parameters, segment) {
                let _ = walls.push(wall);
            }
        }
        Some(Self::over(model, parameters, scan, walls))
    }

    fn over(
        model: &'m Model,
        parameters: &'m WallParameters,
        scan: Scan,
        walls: Vec<SeenWall, MAX_SEGMENTS>,
    ) -> Self {
        let (sine, cosine) = math::sin_cos(parameters.side_bearing_rad);
        let mut refuted_squared = [(0.0, 0.0); SENSORS];
        for beam in scan.usable() {
            // The lobe is at most 1, so that the arc is nowhere farther than on the axis.
            let most_m = kappa(parameters, beam) * beam.echo.range_m;
            let sure_m = surely_refuted_m(model, parameters, beam, cosine);
            if let Some(squared) = refuted_squared.get_mut(beam.sensor) {
                *squared = (most_m * most_m, sure_m * sure_m);
            }
        }
        let explained = walls.iter().flat_map(|wall| wall.sensors.iter()).collect();
        Self {
            model,
            parameters,
            scan,
            walls,
            side_tangent: sine / cosine.max(1e-3),
            refuted_squared,
            explained,
        }
    }

    /// Weighs a place of the body frame.
    pub(super) fn weigh(&self, place: Point) -> Evaluation {
        let mut supporting: Option<(&SeenWall, f32)> = None;
        let mut is_beside = false;
        for wall in &self.walls {
            let across = wall.distance_m - wall.normal.dot(place);
            let squared = across * across;
            if squared >= wall.far {
                continue;
            }
            let along = wall.along.dot(place);
            let (before, behind) = (wall.from_m - along, along - wall.to_m);
            // A comparison: the target has no instruction for `max`, but a function.
            let beyond = if before > behind { before } else { behind };
            is_beside |= squared < wall.beside && beyond < self.parameters.undecided_m;
            if beyond <= self.parameters.end_margin_m {
                let support = math::exp_of_minus(squared / (2.0 * wall.variance));
                if supporting.is_none_or(|(_, other)| support > other) {
                    supporting = Some((wall, support));
                }
            }
        }
        self.evaluate(place, supporting, is_beside)
    }

    fn evaluate(
        &self,
        place: Point,
        supporting: Option<(&SeenWall, f32)>,
        is_beside: bool,
    ) -> Evaluation {
        let model = self.model;
        let parameters = &model.parameters;
        let model_variance = parameters.model_error_m * parameters.model_error_m;
        let margin_squared = parameters.side_margin * parameters.side_margin;
        let is_on_arcs = self.parameters.segments.is_none();
        let mut unsupported = 1.0;
        let mut veto = 1.0;
        let mut in_view = false;
        let mut seen_past = false;
        for sensor in model.visibility.at(place).iter() {
            let Some(beam) = self.scan.beam(sensor) else {
                continue;
            };
            let seen = beam.mount.sensor_from_body(place);
            // Nothing behind the sensor passes, nor the sensor's own place.
            if seen.y.abs() >= model.beam_pattern.tangent_max() * seen.x {
                continue;
            }
            in_view = true;
            if is_beside && supporting.is_none() {
                break;
            }
            let (most, sure) = self
                .refuted_squared
                .get(sensor)
                .copied()
                .unwrap_or_default();
            let range_squared = seen.norm_squared();
            let refutes =
                !is_beside && seen.y.abs() <= self.side_tangent * seen.x && range_squared < most;
            let supporting = supporting.filter(|(wall, _)| wall.sensors.contains(sensor));
            let is_arc = is_on_arcs && beam.surface;
            if supporting.is_none() && !is_arc {
                if !refutes {
                    continue;
                }
                if range_squared < sure {
                    seen_past = true;
                    veto *= parameters.veto;
                    continue;
                }
            }
            let range = math::sqrt(range_squared);
            let lobe = model.beam_pattern.at(seen.x / range);
            if let Some((wall, support)) = supporting {
                unsupported *= 1.0 - support * wall.quality(beam, place, range, lobe);
            }
            if !refutes && !is_arc {
                continue;
            }
            let kappa = kappa(self.parameters, beam);
            let arc = beam.echo.range_m * lobe;
            let sigma = beam.echo.sigma_m * lobe;
            let short = arc - range;
            let variance = sigma * sigma + model_variance;
            let squared = short * short;
            if is_arc && squared < FAR_SQUARED * variance {
                unsupported *= 1.0 - math::exp_of_minus(squared / (2.0 * variance));
            }
            if refutes && range < kappa * arc && squared > margin_squared * variance {
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

    /// A position for a new particle; `None` when no sensor is usable.
    ///
    /// The sensor is uniform. For one that a segment explains, the position is on the
    /// segment, its bearing uniform between the ends, with the sensor's noise across it,
    /// but for the explorers. These are uniform over the area up to the reading's arc. Without
    /// a tracker the others are on the arc, as in Algorithm 2.
    pub(super) fn draw(&self, rng: &mut impl Rng) -> Option<Point> {
        let model = self.model;
        let beams = self.scan.usable();
        let (index, share) = uniform_below_and_within(rng, beams.len() as u32);
        let beam = beams.get(index as usize)?;
        let is_on_arcs = self.parameters.segments.is_none();
        if beam.surface
            && self.explained.contains(beam.sensor)
            && let Some(place) = self.draw_on_wall(beam, share, rng)
        {
            return Some(place);
        }
        let explores = !is_on_arcs || !beam.surface || uniform(rng) < self.parameters.explorers;
        let bearing = model.photometry.theta_max_rad * (2.0 * share - 1.0);
        let (sine, cosine) = math::sin_cos_within_right_angle(bearing);
        let on_axis = if explores {
            beam.echo.range_m * math::sqrt(uniform(rng))
        } else {
            beam.draw_range_on_axis(model, rng)
        };
        let range = on_axis * model.beam_pattern.at(cosine);
        let in_sensor = Point::new(range * cosine, range * sine);
        Some(beam.mount.body_from_sensor(in_sensor))
    }

    /// A place on one of the segments that explain a sensor, by a uniform sample for its
    /// bearing; `None` for an explorer.
    fn draw_on_wall(&self, beam: &Beam, share: f32, rng: &mut impl Rng) -> Option<Point> {
        let sensor = beam.sensor;
        let claiming = || {
            self.walls
                .iter()
                .filter(|wall| wall.sensors.contains(sensor))
        };
        let count = claiming().count() as u32;
        let (index, explores) = uniform_below_and_within(rng, count);
        if explores < self.parameters.explorers {
            return None;
        }
        let wall = claiming().nth(index as usize)?;
        let (from, to) = *wall.bearings_rad.get(sensor)?;
        let (sine, cosine) = math::sin_cos_within_right_angle(from + (to - from) * share);
        let ray = Point::new(cosine, sine).rotated(beam.mount.direction);
        let incidence = ray.dot(wall.normal);
        if incidence < LEAST_INCIDENCE {
            return None;
        }
        let distance = wall.distance_m - wall.normal.dot(beam.mount.position);
        let range = (distance + beam.echo.sigma_m * nearly_normal(rng)) / incidence;
        let range = if range > 0.0 { range } else { 0.0 };
        Some(beam.mount.position + Point::new(range * ray.x, range * ray.y))
    }

    /// How many steps of the gate a survival is worth after so much travel, metres.
    ///
    /// Less than the gate, so that one survival never opens it.
    pub(super) fn epochs(&self, travel_m: f32) -> u8 {
        let most = self.model.parameters.gate.saturating_sub(1).max(1);
        let steps = math::round_to_u32(travel_m.abs() / self.parameters.travel_per_epoch_m);
        steps.clamp(1, u32::from(most)) as u8
    }
}

/// The share of a reading's arc within which it refutes a place.
#[inline]
fn kappa(parameters: &WallParameters, beam: &Beam) -> f32 {
    if beam.surface {
        parameters.surface_kappa
    } else {
        parameters.nothing_kappa
    }
}

/// A range within which a sensor sees past every place near its axis, metres: that at the
/// largest bearing at which it does, given by its cosine. Arc and margin grow with the lobe,
/// which is least there. 0 if there is none.
fn surely_refuted_m(
    model: &Model,
    parameters: &WallParameters,
    beam: &Beam,
    side_cosine: f32,
) -> f32 {
    let FilterParameters {
        side_margin,
        model_error_m,
        ..
    } = model.parameters;
    let lobe = model.beam_pattern.at(side_cosine);
    let (arc, sigma) = (beam.echo.range_m * lobe, beam.echo.sigma_m * lobe);
    let margin = side_margin * math::sqrt(sigma * sigma + model_error_m * model_error_m);
    let range = (kappa(parameters, beam) * arc).min(arc - margin);
    let grows = arc > side_margin * sigma;
    if grows && range > 0.0 { range } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::FilterParameters;
    use crate::filter::segments::SeenSegment;
    use crate::model::{DifferentialDrive, Photometry, Ring, Sample};
    use crate::random::Generator;

    /// 0.1 m on the axis by the point law.
    const TENTH: Sample = Sample::Counts(78);
    /// Nothing in range.
    const DARK: Sample = Sample::Counts(-16);
    const SENSOR: usize = 3;

    fn model() -> Model {
        Model::new(
            FilterParameters::WALL,
            Photometry::VCNL4020,
            &Ring::AMIRO,
            DifferentialDrive::AMIRO,
        )
    }

    /// One sensor's reading, and a wall in that sensor's frame which it claims.
    fn scan(model: &Model, sample: Sample, wall: Option<[Point; 2]>) -> WallScan<'_> {
        let samples: [Sample; SENSORS] = core::array::from_fn(|sensor| {
            if sensor == SENSOR {
                sample
            } else {
                Sample::Missing
            }
        });
        let parameters = model.walls.unwrap();
        let mut walls = Vec::new();
        if let Some(ends) = wall {
            let segment = SeenSegment {
                ends: ends.map(|end| model.mounts[SENSOR].body_from_sensor(end)),
                sensors: SensorMask::NONE.with(SENSOR),
            };
            walls
                .push(SeenWall::of(model, parameters, &segment).unwrap())
                .unwrap();
        }
        let readings = samples.map(|sample| model.photometry.read(sample));
        WallScan::over(model, parameters, Scan::new(model, &readings), walls)
    }

    fn weigh(scan: &WallScan, x: f32, y: f32) -> Evaluation {
        let mount = &scan.model.mounts[SENSOR];
        scan.weigh(mount.body_from_sensor(Point::new(x, y)))
    }

    /// Across the axis, 60 mm from the sensor, 40 mm long.
    const SHORT: [Point; 2] = [Point { x: 0.06, y: -0.02 }, Point { x: 0.06, y: 0.02 }];

    #[test]
    fn a_place_on_a_claimed_segment_is_supported() {
        let model = model();
        let scan = scan(&model, TENTH, Some(SHORT));
        for y in [-0.015, 0.0, 0.015] {
            assert!(weigh(&scan, 0.06, y).weight > 0.999, "{y}");
        }
        // Three standard deviations before it: exp(-4.5).
        let off = 3.0 * math::sqrt(scan.walls[0].variance);
        let weight = weigh(&scan, 0.06 - 0.999 * off, 0.0).weight;
        assert!((weight - 0.0111).abs() < 1e-3, "{weight}");
    }

    #[test]
    fn nothing_is_supported_beyond_an_end_and_nothing_refuted_near_it() {
        let model = model();
        let scan = scan(&model, DARK, Some(SHORT));
        for (beyond, is_supported, is_refuted) in [
            (0.002, true, false),
            (0.004, false, false),
            (0.014, false, false),
            (0.016, false, true),
        ] {
            for side in [-1.0, 1.0] {
                let found = weigh(&scan, 0.06, side * (0.02 + beyond));
                assert!(found.in_view, "{beyond}");
                assert_eq!(found.weight > 0.0, is_supported, "{beyond} {side}");
                assert_eq!(found.seen_past, is_refuted, "{beyond} {side}");
            }
        }
    }

    #[test]
    fn what_is_surely_refuted_is_what_the_arc_refutes() {
        let model = model();
        for sample in [TENTH, Sample::Counts(20), Sample::Counts(900), DARK] {
            let fast = scan(&model, sample, None);
            let mut slow = scan(&model, sample, None);
            slow.refuted_squared.iter_mut().for_each(|it| it.1 = 0.0);
            let (most, sure) = fast.refuted_squared[SENSOR];
            assert!(
                sure > 0.3 * most && sure < most,
                "{sample:?}: {sure} {most}"
            );
            for step in 0..200 {
                for degrees in -61..=61 {
                    let (sine, cosine) = math::sin_cos((degrees as f32).to_radians());
                    let range = 0.001 * (step + 1) as f32;
                    let (x, y) = (range * cosine, range * sine);
                    let found = [&fast, &slow].map(|scan| weigh(scan, x, y));
                    assert_eq!(found[0], found[1], "{sample:?}: {x} {y}");
                }
            }
        }
    }

    #[test]
    fn a_reading_without_a_segment_supports_nothing_and_is_an_upper_bound() {
        let model = model();
        let scan = scan(&model, TENTH, None);
        let arc = scan.scan.beam(SENSOR).unwrap().echo.range_m;
        let kappa = scan.parameters.surface_kappa;
        for (share, is_refuted) in [(kappa - 0.01, true), (kappa + 0.01, false), (1.0, false)] {
            let found = weigh(&scan, share * arc, 0.0);
            assert_eq!(found.seen_past, is_refuted, "{share}");
            assert!(found.weight <= 0.0, "{share}");
        }
        // 20 mm from the sensor, and far from its axis.
        for (bearing_deg, is_refuted) in [(33.0_f32, true), (35.0, false)] {
            let (sine, cosine) = math::sin_cos(bearing_deg.to_radians());
            let found = weigh(&scan, 0.02 * cosine, 0.02 * sine);
            assert!(found.in_view);
            assert_eq!(found.seen_past, is_refuted, "{bearing_deg}");
        }
    }

    fn arcs() -> Model {
        Model::new(
            FilterParameters::ARCS,
            Photometry::VCNL4020,
            &Ring::AMIRO,
            DifferentialDrive::AMIRO,
        )
    }

    #[test]
    fn without_a_tracker_the_arc_supports_and_is_an_upper_bound() {
        let model = arcs();
        let scan = scan(&model, TENTH, None);
        let arc = scan.scan.beam(SENSOR).unwrap().echo.range_m;
        let kappa = scan.parameters.surface_kappa;
        for (range, is_supported, is_refuted) in [
            (arc, true, false),
            (arc - 0.012, true, false),
            ((kappa + 0.01) * arc, true, false),
            ((kappa - 0.01) * arc, false, true),
        ] {
            let found = weigh(&scan, range, 0.0);
            let as_plus = scan.scan.weigh(&model, {
                let mount = &model.mounts[SENSOR];
                mount.body_from_sensor(Point::new(range, 0.0))
            });
            assert_eq!(found.seen_past, is_refuted, "{range}");
            assert_eq!(found.weight > 0.002, is_supported, "{range}");
            // The support is that of `plus`; only the veto differs.
            if !as_plus.seen_past {
                assert!((found.weight - as_plus.weight).abs() < 1e-6, "{range}");
            }
        }
    }

    #[test]
    fn without_a_tracker_the_explorers_share_lies_before_the_arc() {
        let model = arcs();
        let scan = scan(&model, TENTH, None);
        let beam = scan.scan.beam(SENSOR).unwrap();
        let mut rng = Generator::seeded(1);
        let mut near = 0.0;
        for _ in 0..4000 {
            let place = scan.draw(&mut rng).unwrap();
            let seen = model.mounts[SENSOR].sensor_from_body(place);
            let range = seen.norm();
            let lobe = model.beam_pattern.at(seen.x / range);
            // Half of the explorers are nearer than 0.707 of the arc; no draw on it is.
            near += f32::from(u8::from(range < 0.707 * beam.echo.range_m * lobe));
        }
        let off = (near / 4000.0 - 0.5 * scan.parameters.explorers).abs();
        assert!(off < 0.026, "{off}");
    }

    #[test]
    fn the_explorers_share_searches_the_lobe_and_the_others_the_segment() {
        let model = model();
        // The segment is behind the arc, which no explorer crosses.
        let wall = [Point::new(0.15, -0.05), Point::new(0.15, 0.05)];
        let scan = scan(&model, TENTH, Some(wall));
        for seed in 1..=3 {
            let mut rng = Generator::seeded(seed);
            let mut on_wall = 0.0;
            for _ in 0..4000 {
                let place = scan.draw(&mut rng).unwrap();
                let seen = model.mounts[SENSOR].sensor_from_body(place);
                if seen.x > 0.12 {
                    on_wall += 1.0;
                    assert!((seen.x - 0.15).abs() < 0.02, "{seen:?}");
                    assert!(seen.y.abs() < 0.06, "{seen:?}");
                }
            }
            // sigma = sqrt(0.4 * 0.6 / 4000) = 0.008; 4 sigma.
            let share = 1.0 - on_wall / 4000.0;
            let off = (share - scan.parameters.explorers).abs();
            assert!(off < 0.031, "seed {seed}: {share}");
        }
    }

    #[test]
    fn nearly_normal_has_mean_zero_and_variance_one() {
        const COUNT: usize = 20_000;
        for seed in 1..=3 {
            let mut rng = Generator::seeded(seed);
            let (mut sum, mut squares) = (0.0, 0.0);
            for _ in 0..COUNT {
                let sample = f64::from(nearly_normal(&mut rng));
                assert!(sample.abs() < 3.47, "seed {seed}: {sample}");
                sum += sample;
                squares += sample * sample;
            }
            let n = COUNT as f64;
            // 4 sigma, and the variance's is below that of the normal distribution.
            assert!((sum / n).abs() < 4.0 / n.sqrt(), "seed {seed}: {sum}");
            let off = squares / n - 1.0;
            assert!(off.abs() < 4.0 * (2.0 / n).sqrt(), "seed {seed}: {off}");
        }
    }

    #[test]
    fn epochs_count_travel_and_one_survival_never_opens_the_gate() {
        let model = model();
        let scan = scan(&model, TENTH, None);
        let gate = model.parameters.gate;
        for (travel_m, epochs) in [
            (0.0, 1),
            (0.004, 1),
            (0.01, 1),
            (0.03, 3),
            (0.05, gate - 1),
            (0.3, gate - 1),
        ] {
            assert_eq!(scan.epochs(travel_m), epochs, "{travel_m}");
        }
    }
}
