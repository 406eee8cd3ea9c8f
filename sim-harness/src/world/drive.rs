//! The drive: exact poses along the legs, sampled as the sensors are.

use amiro_ipf::geometry::Pose;

use super::{Leg, Scenario};
use crate::geometry::{Turn, Vector, radians};

/// Between two samples of the sensors, microseconds: 125 Hz.
pub const SAMPLE_PERIOD_US: u64 = 8_000;

/// The poses of a drive by time.
#[derive(Clone, Debug)]
pub struct Drive {
    speed_m_per_s: f64,
    /// Each leg with the state at its start.
    legs: Vec<(LegStart, Leg)>,
    end: LegStart,
}

/// The beginning of a leg.
#[derive(Clone, Copy, Debug)]
struct LegStart {
    time_s: f64,
    position: Vector,
    heading_deg: f64,
}

impl Drive {
    /// The drive of a scenario.
    #[must_use]
    pub fn of(scenario: &Scenario) -> Self {
        let speed_m_per_s = scenario.speed_m_per_s;
        let mut end = LegStart {
            time_s: 0.0,
            position: scenario.start,
            heading_deg: scenario.start_heading_deg,
        };
        let mut legs = Vec::with_capacity(scenario.drive.len());
        for leg in &scenario.drive {
            legs.push((end, *leg));
            end = end.after(leg, leg.duration_s(speed_m_per_s), speed_m_per_s);
        }
        Self {
            speed_m_per_s,
            legs,
            end,
        }
    }

    /// Stamp of the end of the drive, microseconds.
    #[must_use]
    pub fn end_us(&self) -> u64 {
        (self.end.time_s * 1e6).round() as u64
    }

    /// The robot's pose at a stamp; after the end it stays at the last one.
    #[must_use]
    pub fn pose_at(&self, stamp_us: u64) -> Pose {
        let time_s = stamp_us as f64 * 1e-6;
        let begun = self
            .legs
            .partition_point(|(start, _)| start.time_s <= time_s);
        let leg = begun.checked_sub(1).and_then(|index| self.legs.get(index));
        match leg {
            Some((start, leg)) if stamp_us < self.end_us() => {
                let into_s = (time_s - start.time_s).min(leg.duration_s(self.speed_m_per_s));
                start.after(leg, into_s, self.speed_m_per_s).pose()
            }
            _ => self.end.pose(),
        }
    }

    /// Stamps and poses of all samples: from 0, every 8 ms, and at the end.
    pub fn samples(&self) -> impl Iterator<Item = (u64, Pose)> {
        let end_us = self.end_us();
        (0..end_us)
            .step_by(SAMPLE_PERIOD_US as usize)
            .chain([end_us])
            .map(|stamp_us| (stamp_us, self.pose_at(stamp_us)))
    }
}

impl LegStart {
    /// The state after the given time on a leg.
    fn after(&self, leg: &Leg, seconds: f64, speed_m_per_s: f64) -> Self {
        let time_s = self.time_s + seconds;
        let way_m = speed_m_per_s * seconds;
        let forward = Turn::by_degrees(self.heading_deg).direction();
        match *leg {
            Leg::Straight { length_m } => Self {
                time_s,
                position: self.position + forward.scaled(way_m.copysign(length_m)),
                heading_deg: self.heading_deg,
            },
            Leg::Turn { angle_deg } => Self {
                time_s,
                heading_deg: self.heading_deg
                    + (super::leg::TURN_DEG_PER_S * seconds).copysign(angle_deg),
                ..*self
            },
            Leg::Arc {
                angle_deg,
                radius_m,
            } => {
                let turned_deg = way_m / radius_m * (180.0 / core::f64::consts::PI);
                let heading_deg = self.heading_deg + turned_deg.copysign(angle_deg);
                let radius_m = radius_m.copysign(angle_deg);
                // The centre lies to the left at +radius, to the right at -radius.
                let to_centre =
                    |forward: Vector| Vector::new(-forward.y, forward.x).scaled(radius_m);
                let later = Turn::by_degrees(heading_deg).direction();
                Self {
                    time_s,
                    position: self.position + to_centre(forward) - to_centre(later),
                    heading_deg,
                }
            }
        }
    }

    fn pose(&self) -> Pose {
        let Vector { x, y } = self.position;
        Pose::new(x as f32, y as f32, radians(self.heading_deg))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive(legs: &str) -> Drive {
        let text = format!(
            "name = \"d\"\ncell_m = 0.01\nextent_m = [-1, -1, 1, 1]\nspeed_m_per_s = 0.08\n\
             start = [0, 0, 90]\n{legs}"
        );
        Drive::of(&Scenario::parse(&text).unwrap())
    }

    fn at(pose: Pose, x: f32, y: f32, degrees: f32) {
        let expected = Pose::new(x, y, degrees.to_radians());
        let error = (pose.position - expected.position).norm();
        let turn = pose.motion_to(&expected).turn.radians();
        assert!(
            error < 1e-6 && turn.abs() < 1e-6,
            "{pose:?} is not {expected:?}"
        );
    }

    #[test]
    fn samples_lie_8_ms_apart_and_the_last_at_the_end() {
        let samples: Vec<_> = drive("[[drive]]\nstraight_m = 0.01").samples().collect();
        assert_eq!(samples.len(), 17);
        assert_eq!(samples[0].0, 0);
        assert_eq!(samples[1].0, 8_000);
        assert_eq!(samples[16].0, 125_000);
        at(samples[0].1, 0.0, 0.0, 90.0);
        at(samples[1].1, 0.0, 0.000_64, 90.0);
        at(samples[16].1, 0.0, 0.01, 90.0);
        assert_eq!(drive("").samples().count(), 1);
    }

    #[test]
    fn legs_follow_each_other() {
        let drive = drive(
            "[[drive]]\nstraight_m = 0.08\n[[drive]]\nturn_deg = -90\n\
             [[drive]]\narc_deg = 90\nradius_m = 0.16\n[[drive]]\nstraight_m = -0.04",
        );
        at(drive.pose_at(500_000), 0.0, 0.04, 90.0);
        at(drive.pose_at(2_000_000), 0.0, 0.08, 45.0);
        // The arc begins at 3 s along +x and takes pi seconds.
        let eighth = core::f32::consts::FRAC_1_SQRT_2 * 0.16;
        at(
            drive.pose_at(3_000_000 + 1_570_796),
            eighth,
            0.08 + 0.16 - eighth,
            45.0,
        );
        at(drive.pose_at(3_000_000 + 3_141_593), 0.16, 0.24, 90.0);
        assert_eq!(drive.end_us(), 6_641_593);
        at(drive.pose_at(drive.end_us()), 0.16, 0.20, 90.0);
        at(drive.pose_at(u64::MAX), 0.16, 0.20, 90.0);
    }

    #[test]
    fn right_arcs_mirror_left_ones() {
        let pose = |legs| {
            let drive = drive(legs);
            drive.pose_at(drive.end_us())
        };
        at(
            pose("[[drive]]\narc_deg = 90\nradius_m = 0.1"),
            -0.1,
            0.1,
            180.0,
        );
        at(
            pose("[[drive]]\narc_deg = -90\nradius_m = 0.1"),
            0.1,
            0.1,
            0.0,
        );
    }
}
