//! The box about the robot that shortens readings through gaps between sensors.

use core::ops::Range;

use crate::drive::{RangeScan, Record, Return};
use crate::geometry::{Turn, Vector};
use crate::mapping::scan_returns::farthest_m;
use crate::mapping::{FinishProgress, Map, MappedWall, Mapper};
use crate::rig::{Rig, SensorMount};
use crate::sensors::Sensor;

/// Bearing off an axis of the robot up to which a cone makes a side, radians: 10 degrees,
/// and half a degree for rigs whose numbers are rounded.
const ALONG_AXIS_RAD: f64 = 10.5 * core::f64::consts::PI / 180.0;

/// Range from which on a reading makes no side, metres.
const SIDES_BELOW_M: f64 = 3.0;

/// Shortens the readings of a cycle by a box about the robot (Ivanjko et al. 2003), and
/// hands them to another mapper.
///
/// The box has its sides at right angles to the robot's axes. The readings along an axis
/// make its side: the least of their echoes below 3.0 m, as the distance along the axis from
/// the robot's origin. Without such a reading the side is open. Each other reading is
/// shortened to where its axis leaves the box; one without an echo becomes an echo there.
/// A reading that would become shorter than its sensor can measure stays as it is.
///
/// Which readings look along an axis follows from the rig: cones whose axis lies within 10
/// degrees of 0, 90, 180 or -90 degrees; of a scanner the beams less than a step off them.
/// The sonars of the rig `kcma` at 7.5 and -7.5 degrees make the front, those at 90 and -90
/// degrees left and right; the rear is open. A ring without sensors along the axes has
/// no sides, and nothing is changed.
///
/// A cycle has all scans of one stamp; it ends with the next record of another kind or
/// stamp, so the map lacks the last cycle until [`Mapper::finish`].
#[derive(Clone, Debug)]
pub struct BoxMapper<M> {
    mapper: M,
    /// Of each mount the axes of its returns; `None` for returns that are left as they are.
    axes: Vec<Vec<Option<ReturnAxis>>>,
    cycle: Vec<RangeScan>,
    shortened: u64,
}

/// The axis of a return in the body frame.
#[derive(Clone, Copy, Debug)]
struct ReturnAxis {
    origin: Vector,
    direction: Vector,
    /// The side that it makes; `None` if it is shortened.
    side: Option<BoxSide>,
    nearest_m: f64,
    farthest_m: f64,
}

/// A side of the box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum BoxSide {
    Front,
    Left,
    Rear,
    Right,
}

impl BoxSide {
    const ALL: [Self; 4] = [Self::Front, Self::Left, Self::Rear, Self::Right];

    /// Unit vector from the robot towards the side.
    const fn outward(self) -> Vector {
        match self {
            Self::Front => Vector::new(1.0, 0.0),
            Self::Left => Vector::new(0.0, 1.0),
            Self::Rear => Vector::new(-1.0, 0.0),
            Self::Right => Vector::new(0.0, -1.0),
        }
    }
}

/// Distances of the four sides from the robot's origin, metres; infinite for an open side.
#[derive(Clone, Copy, Debug, PartialEq)]
struct BoxSides([f64; 4]);

impl BoxSides {
    const OPEN: Self = Self([f64::INFINITY; 4]);

    /// Moves a side to a place that a reading found, if that is nearer.
    fn take(&mut self, side: BoxSide, found: Vector) {
        let distance_m = found.dot(side.outward());
        for (bound_m, of) in self.0.iter_mut().zip(BoxSide::ALL) {
            if of == side {
                *bound_m = bound_m.min(distance_m);
            }
        }
    }

    /// Distance along an axis to where it leaves the box, metres; infinite through an open
    /// side.
    fn along(&self, axis: &ReturnAxis) -> f64 {
        let to = self.0.iter().zip(BoxSide::ALL).map(|(bound_m, side)| {
            let speed = axis.direction.dot(side.outward());
            let rest_m = bound_m - axis.origin.dot(side.outward());
            if speed > 1e-9 {
                rest_m / speed
            } else {
                f64::INFINITY
            }
        });
        to.fold(f64::INFINITY, f64::min)
    }
}

impl ReturnAxis {
    /// The axes of the returns of a mount.
    fn of(mount: &SensorMount) -> Vec<Self> {
        let [nearest_m, within_rad] = match &mount.sensor {
            Sensor::Scanner(scanner) => [scanner.range_m[0], scanner.step_rad.abs()],
            Sensor::Cone(cone) => [cone.range_m[0], ALONG_AXIS_RAD],
            Sensor::Infrared(_) => [0.0, ALONG_AXIS_RAD],
        };
        let bearings = match &mount.sensor {
            Sensor::Scanner(scanner) => (0..scanner.beams)
                .map(|beam| scanner.bearing_rad(usize::from(beam)))
                .collect(),
            Sensor::Cone(_) | Sensor::Infrared(_) => vec![0.0],
        };
        let axes = bearings.into_iter().map(|bearing_rad| {
            let pose = mount.body_from_sensor;
            let direction = Turn::by_radians_f64(bearing_rad)
                .after(pose.heading)
                .direction();
            let is_along = |side: &BoxSide| {
                let outward = side.outward();
                libm::atan2(outward.cross(direction).abs(), outward.dot(direction)) < within_rad
            };
            Self {
                origin: pose.position,
                direction,
                side: BoxSide::ALL.into_iter().find(is_along),
                nearest_m,
                farthest_m: farthest_m(&mount.sensor),
            }
        });
        axes.collect()
    }

    /// The return shortened by the box; `None` if it stays as it is.
    fn shortened(&self, sides: &BoxSides, measured: Return) -> Option<Return> {
        let (reach_m, sigma_m) = match measured {
            Return::Echo { range_m, sigma_m } => (range_m, sigma_m),
            Return::NoEcho { limit_m, sigma_m } => (limit_m, sigma_m),
            Return::TooClose | Return::Invalid => return None,
        };
        let range_m = sides.along(self);
        let is_shorter = self.side.is_none()
            && range_m < reach_m.min(self.farthest_m)
            && range_m >= self.nearest_m.max(f64::MIN_POSITIVE);
        is_shorter.then_some(Return::Echo { range_m, sigma_m })
    }
}

impl<M> BoxMapper<M> {
    /// Puts the box before a mapper, for the mounts of a rig that `is_mapped` names; others
    /// make no side, and their returns are handed on as they are.
    #[must_use]
    pub fn new(mapper: M, rig: &Rig, is_mapped: impl Fn(&SensorMount) -> bool) -> Self {
        let axes = |mount: &SensorMount| {
            let axes = ReturnAxis::of(mount).into_iter();
            axes.map(|axis| is_mapped(mount).then_some(axis)).collect()
        };
        Self {
            mapper,
            axes: rig.mounts.iter().map(axes).collect(),
            cycle: Vec::new(),
            shortened: 0,
        }
    }

    /// Number of readings that were shortened.
    #[must_use]
    pub fn shortened(&self) -> u64 {
        self.shortened
    }

    /// The mapper behind the box.
    #[must_use]
    pub fn mapper(&self) -> &M {
        &self.mapper
    }

    /// The axes of the returns of a scan, in their order.
    fn axes_of<'a>(
        axes: &'a [Vec<Option<ReturnAxis>>],
        mounts: &Range<usize>,
    ) -> impl Iterator<Item = &'a Option<ReturnAxis>> + use<'a, M> {
        let of_mounts = axes.get(mounts.clone()).unwrap_or_default();
        of_mounts.iter().flatten()
    }
}

impl<M: Mapper> BoxMapper<M> {
    /// Shortens the readings of the cycle and hands its scans on.
    fn end_cycle(&mut self) {
        let mut sides = BoxSides::OPEN;
        for scan in &self.cycle {
            let axes = Self::axes_of(&self.axes, &scan.mounts);
            for (axis, measured) in axes.zip(&scan.returns) {
                let Some(axis) = axis else { continue };
                if let (Some(side), Return::Echo { range_m, .. }) = (axis.side, measured)
                    && *range_m < SIDES_BELOW_M
                {
                    sides.take(side, axis.origin + axis.direction.scaled(*range_m));
                }
            }
        }
        for mut scan in self.cycle.drain(..) {
            let axes = Self::axes_of(&self.axes, &scan.mounts);
            for (axis, measured) in axes.zip(&mut scan.returns) {
                let Some(axis) = axis else { continue };
                if let Some(shortened) = axis.shortened(&sides, *measured) {
                    *measured = shortened;
                    self.shortened += 1;
                }
            }
            self.mapper.take(&Record::Scan(scan));
        }
    }
}

impl<M: Mapper> Mapper for BoxMapper<M> {
    fn take(&mut self, record: &Record) {
        let Record::Scan(scan) = record else {
            self.end_cycle();
            self.mapper.take(record);
            return;
        };
        let is_next = |last: &RangeScan| last.stamp_us != scan.stamp_us;
        if self.cycle.last().is_some_and(is_next) {
            self.end_cycle();
        }
        self.cycle.push(scan.clone());
    }

    fn finish(&mut self, progress: &mut dyn FnMut(FinishProgress)) {
        self.end_cycle();
        self.mapper.finish(progress);
    }

    fn map(&self) -> Map {
        self.mapper.map()
    }

    fn is_online(&self) -> bool {
        self.mapper.is_online()
    }

    fn walls(&self) -> &[MappedWall] {
        self.mapper.walls()
    }
}

#[cfg(test)]
mod tests;
