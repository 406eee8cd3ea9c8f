//! A drive of a robot with range sensors through a known room, as records.

use amiro_ipf::random::Generator;

use super::RangeWorld;
use crate::drive::{RangeScan, Record};
use crate::geometry::{Pose2, Vector};
use crate::rig::Rig;

/// Time from one pose to the next, microseconds.
const PERIOD_US: u64 = 250_000;

/// A heading less than this from the next leg's needs no turn, radians.
const STRAIGHT_RAD: f64 = 1e-9;

/// Odometry that is wrong by as much for each metre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriftingOdometry {
    /// Measured travel per true one.
    pub scale: f64,
    /// Turn that is not there, radians per metre.
    pub turn_rad_per_m: f64,
}

impl DriftingOdometry {
    /// No error.
    pub const EXACT: Self = Self {
        scale: 1.0,
        turn_rad_per_m: 0.0,
    };

    /// The poses that the odometry gives of true ones; the first is the true one.
    #[must_use]
    pub fn poses(&self, truth: &[Pose2]) -> Vec<Pose2> {
        let Some(first) = truth.first() else {
            return Vec::new();
        };
        let (mut believed, mut extra_rad) = (*first, 0.0);
        let mut poses = vec![believed];
        for two in truth.windows(2) {
            let step = two[0].view(two[1].position);
            let place = believed.place(step.scaled(self.scale));
            extra_rad += self.turn_rad_per_m * step.norm();
            believed = Pose2::new(place.x, place.y, two[1].heading_rad() + extra_rad);
            poses.push(believed);
        }
        poses
    }
}

/// Poses along straight legs, a step apart, beginning with each leg's first place; between
/// legs the robot turns on the spot, a pose per `turn_step_rad`, where one is given.
#[must_use]
pub fn poses_along(places: &[Vector], step_m: f64, turn_step_rad: Option<f64>) -> Vec<Pose2> {
    let mut poses: Vec<Pose2> = Vec::new();
    for leg in places.windows(2) {
        let way = leg[1] - leg[0];
        let heading_rad = libm::atan2(way.y, way.x);
        let heading = Pose2::new(leg[0].x, leg[0].y, heading_rad);
        if let (Some(turn_step_rad), Some(last)) = (turn_step_rad, poses.last().copied()) {
            let turn = heading.heading.after(last.heading.inverse());
            let turn_rad = libm::atan2(turn.sine, turn.cosine);
            // A part of a turn.
            let steps = ((turn_rad.abs() - STRAIGHT_RAD) / turn_step_rad).max(0.0) as u32;
            for step in 1..=steps {
                let turned = f64::from(step) * turn_step_rad.copysign(turn_rad);
                let heading_rad = last.heading_rad() + turned;
                poses.push(Pose2::new(leg[0].x, leg[0].y, heading_rad));
            }
        }
        let length_m = way.norm();
        for step in 0_u32.. {
            let along_m = f64::from(step) * step_m;
            if along_m >= length_m - STRAIGHT_RAD {
                break;
            }
            let place = leg[0] + way.scaled(along_m / length_m);
            poses.push(Pose2::new(place.x, place.y, heading_rad));
        }
    }
    poses
}

/// The records of a drive: at each pose one scan of the cones and one of the scanners, with
/// the pose that the odometry gives.
#[must_use]
pub fn simulated_records(
    world: &RangeWorld,
    rig: &Rig,
    truth: &[Pose2],
    odometry: &DriftingOdometry,
    seed: u64,
) -> Vec<Record> {
    let mut rng = Generator::seeded(seed);
    let mut records = Vec::new();
    let believed = odometry.poses(truth);
    for (number, (true_pose, world_from_body)) in (0_u64..).zip(truth.iter().zip(believed)) {
        let stamp_us = number * PERIOD_US;
        records.push(Record::Pose {
            stamp_us,
            world_from_body,
        });
        let mut first = 0;
        while let Some(mount) = rig.mounts.get(first) {
            let kind = core::mem::discriminant(&mount.sensor);
            let mut returns = Vec::new();
            let mut end = first;
            while let Some(mount) = rig.mounts.get(end)
                && core::mem::discriminant(&mount.sensor) == kind
            {
                let world_from_sensor = *true_pose * mount.body_from_sensor;
                returns.extend(world.measure(&mount.sensor, &world_from_sensor, &mut rng));
                end += 1;
            }
            records.push(Record::Scan(RangeScan {
                stamp_us,
                world_from_body,
                mounts: first..end,
                returns,
                signals: Vec::new(),
            }));
            first = end;
        }
    }
    records
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiments::{RoomWalls, SonarEchoes};

    fn places(ends: &[(f64, f64)]) -> Vec<Vector> {
        ends.iter().map(|(x, y)| Vector::new(*x, *y)).collect()
    }

    #[test]
    fn legs_have_a_pose_per_step_and_turns_one_per_turn_step() {
        let ends = places(&[(1.0, 1.0), (9.0, 1.0), (9.0, 6.0), (1.0, 6.0), (1.0, 1.15)]);
        // The lap of Carvalho and Ventura's experiment: 1400 readings of eight sonars.
        assert_eq!(poses_along(&ends, 0.15, None).len(), 175);
        let corner = places(&[(0.0, 0.0), (1.0, 0.0), (1.0, -0.5)]);
        let poses = poses_along(&corner, 0.5, Some(5_f64.to_radians()));
        // Two poses, 17 on the spot, and one at the right heading.
        assert_eq!(poses.len(), 2 + 17 + 1);
        assert!((poses[2].heading_rad() + 5_f64.to_radians()).abs() < 1e-9);
        assert!((poses[19].heading_rad() + 90_f64.to_radians()).abs() < 1e-9);
    }

    #[test]
    fn drift_grows_with_the_way() {
        let truth = poses_along(&places(&[(1.0, 0.0), (11.0, 0.0)]), 0.01, None);
        let drift = DriftingOdometry {
            scale: 1.02,
            turn_rad_per_m: 0.01,
        };
        let end = *drift.poses(&truth).last().unwrap();
        // A circle of radius 1.02 / 0.01 m.
        let radius_m = 102.0;
        let turn_rad: f64 = 0.01 * 9.99;
        let expected = Vector::new(
            1.0 + radius_m * turn_rad.sin(),
            radius_m * (1.0 - turn_rad.cos()),
        );
        // Half a step's turn over the way.
        assert!(
            (end.position - expected).norm() < 1e-3,
            "{end:?} {expected:?}"
        );
        let exact = *DriftingOdometry::EXACT.poses(&truth).last().unwrap();
        assert!(
            (exact.position - Vector::new(10.99, 0.0)).norm() < 1e-9,
            "{exact:?}"
        );
    }

    #[test]
    fn a_pose_has_a_scan_of_all_sonars_and_one_of_the_laser_and_the_same_seed_the_same_records() {
        let rig = Rig::parse("rig", include_str!("../../../rigs/pioneer2dx_laser.toml")).unwrap();
        let world = RangeWorld {
            walls: RoomWalls::new(vec![[Vector::new(2.0, -9.0), Vector::new(2.0, 9.0)]]),
            echoes: SonarEchoes::ROOM,
        };
        let truth = poses_along(&places(&[(0.0, 0.0), (0.5, 0.0)]), 0.1, None);
        let exact = DriftingOdometry::EXACT;
        let records = simulated_records(&world, &rig, &truth, &exact, 100);
        assert_eq!(records.len(), 3 * truth.len());
        let Record::Scan(laser) = &records[2] else {
            panic!("{:?}", records[2]);
        };
        assert_eq!((laser.mounts.clone(), laser.returns.len()), (16..17, 181));
        assert_eq!(
            records,
            simulated_records(&world, &rig, &truth, &exact, 100)
        );
        assert_ne!(
            records,
            simulated_records(&world, &rig, &truth, &exact, 101)
        );
    }
}
