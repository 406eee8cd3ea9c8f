//! A tracked segment that explains readings, prepared for weighing and drawing.

use super::segments::SeenSegment;
use super::weigh::Beam;
use super::{Model, WallParameters};
use crate::geometry::Point;
use crate::math;
use crate::model::{SENSORS, SensorMask};

/// Squared distance from a segment, in variances, beyond which a support is none.
pub(super) const FAR_SQUARED: f32 = 24.0;
/// The same within which nothing is refuted.
const BESIDE_SQUARED: f32 = 9.0;
/// Bearings at which the strongest element is looked for, on each side of the axis.
const QUALITY_STEPS: i8 = 8;

/// A seen segment, prepared for a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeenWall {
    /// Away from the robot.
    pub(super) normal: Point,
    pub(super) along: Point,
    /// From the robot's centre, metres.
    pub(super) distance_m: f32,
    /// The ends on the line, from the foot of the perpendicular, metres.
    pub(super) from_m: f32,
    pub(super) to_m: f32,
    pub(super) variance: f32,
    /// The squared distances of [`FAR_SQUARED`] and [`BESIDE_SQUARED`], square metres.
    pub(super) far: f32,
    pub(super) beside: f32,
    pub(super) sensors: SensorMask,
    /// 1 / (q_min q_max) by sensor.
    pub(super) inverse_quality: [f32; SENSORS],
    /// The bearings of the ends by sensor, clipped to the lobe.
    pub(super) bearings_rad: [(f32, f32); SENSORS],
}

impl SeenWall {
    /// `None` for a segment without a length.
    pub(super) fn of(
        model: &Model,
        parameters: &WallParameters,
        segment: &SeenSegment,
    ) -> Option<Self> {
        let [from, to] = segment.ends;
        let way = to - from;
        let length_m = way.norm();
        if length_m <= 0.0 {
            return None;
        }
        let mut along = Point::new(way.x / length_m, way.y / length_m);
        let mut normal = Point::new(along.y, -along.x);
        let (mut from_m, mut to_m) = (along.dot(from), along.dot(to));
        let mut distance_m = normal.dot(from);
        if distance_m < 0.0 {
            distance_m = -distance_m;
            normal = Point::new(-normal.x, -normal.y);
            along = Point::new(-along.x, -along.y);
            (from_m, to_m) = (-to_m, -from_m);
        }
        let relative_m = parameters.relative_error * distance_m;
        let variance = parameters.error_m * parameters.error_m + relative_m * relative_m;
        let mut wall = Self {
            normal,
            along,
            distance_m,
            from_m,
            to_m,
            variance,
            far: FAR_SQUARED * variance,
            beside: BESIDE_SQUARED * variance,
            sensors: segment.sensors,
            inverse_quality: [0.0; SENSORS],
            bearings_rad: [(0.0, 0.0); SENSORS],
        };
        let by_sensor = wall.inverse_quality.iter_mut().zip(&mut wall.bearings_rad);
        for (sensor, ((inverse, bearings), mount)) in by_sensor.zip(&model.mounts).enumerate() {
            if !segment.sensors.contains(sensor) {
                continue;
            }
            let seen = segment.ends.map(|end| mount.sensor_from_body(end));
            let max = model.photometry.theta_max_rad;
            let [a, b] = seen.map(|end| math::coarse_atan2(end.y, end.x).max(-max).min(max));
            *bearings = (a.min(b), a.max(b));
            let turned = normal.rotated(mount.direction.inverse());
            *inverse = 1.0 / (parameters.least_quality * largest_quality(model, turned));
        }
        Some(wall)
    }

    /// min(1, q / (q_min q_max)) of a sensor that claims the wall, for a place in its view.
    #[inline]
    pub(super) fn quality(&self, beam: &Beam, place: Point, range: f32, lobe: f32) -> f32 {
        let inverse = self
            .inverse_quality
            .get(beam.sensor)
            .copied()
            .unwrap_or(0.0);
        let incidence = self.normal.dot(place - beam.mount.position) / range;
        let quality = lobe * lobe * incidence * incidence * incidence * inverse;
        if quality > 1.0 {
            1.0
        } else if quality > 0.0 {
            quality
        } else {
            0.0
        }
    }
}

/// q_max: the largest cos(xi t) cos^3(t - psi) in the lobe, by bearings a sixteenth of
/// it apart; within 3 % of it.
fn largest_quality(model: &Model, normal: Point) -> f32 {
    let step = model.photometry.theta_max_rad / f32::from(QUALITY_STEPS);
    let mut largest = 1e-3_f32;
    for index in -QUALITY_STEPS..=QUALITY_STEPS {
        let (sine, cosine) = math::sin_cos(f32::from(index) * step);
        let lobe = model.beam_pattern.at(cosine);
        let incidence = (normal.x * cosine + normal.y * sine).max(0.0);
        largest = largest.max(lobe * lobe * incidence * incidence * incidence);
    }
    largest
}
