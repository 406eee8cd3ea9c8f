//! Checks that a robot can drive a scenario, and that the filter accepts its speed.

use std::fmt;

use amiro_ipf::model::Ring;
use amiro_ipf::node::odometry::{MAX_SPEED_M_PER_S, MAX_TURN_RAD_PER_S};
use serde::Deserialize;

use super::{Drive, Leg, Scenario, ScenarioError, Shape, Vector};

/// Overlap of hull and shape that counts as touching, metres: poses are `f32`, to 0.06 mm
/// at a kilometre.
const TOUCHING_M: f64 = 1e-4;
/// Rounding that is allowed for in the length of a drive, metres.
const ROUNDING_M: f64 = 1e-6;

/// A check that a scenario may fail on purpose, by the key `allow`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Allowance {
    /// The hull enters shapes.
    Collision,
    /// The robot drives or turns faster than the filter accepts.
    Speed,
}

impl Scenario {
    /// Checks that the hull enters no shape, that the filter accepts the speed, and that
    /// every opening is judged before the drive ends. Hull and shape may touch. The checks
    /// that the scenario's `allow` names are left out.
    ///
    /// # Errors
    /// [`ScenarioError::Limit`] with the key and its value.
    pub fn check_drive(&self) -> Result<(), ScenarioError> {
        if !self.allow.contains(&Allowance::Speed) {
            self.check_speed()?;
        }
        self.check_openings()?;
        if !self.allow.contains(&Allowance::Collision) {
            self.check_way()?;
        }
        Ok(())
    }

    fn check_speed(&self) -> Result<(), ScenarioError> {
        let (speed, most) = (self.speed_m_per_s, f64::from(MAX_SPEED_M_PER_S));
        if speed > most {
            return refused(
                "speed_m_per_s",
                format!(
                    "{speed} m/s, the filter accepts at most {most} m/s; allow = [\"speed\"] \
                     drives all the same"
                ),
            );
        }
        let most = f64::from(MAX_TURN_RAD_PER_S);
        for (number, leg) in (1..).zip(&self.drive) {
            if let Leg::Arc { radius_m, .. } = leg
                && speed / radius_m > most
            {
                return refused(
                    "drive, radius_m",
                    format!(
                        "leg {number} has an arc of {radius_m} m, a turn of {:.1} rad/s at \
                         {speed} m/s, the filter accepts at most {most} rad/s; \
                         allow = [\"speed\"] drives all the same",
                        speed / radius_m
                    ),
                );
            }
        }
        Ok(())
    }

    fn check_openings(&self) -> Result<(), ScenarioError> {
        let length_m: f64 = self.drive.iter().map(|leg| leg.length_m()).sum();
        for (number, opening) in (1..).zip(&self.openings) {
            let judged_at_m = opening.judged_at_m;
            if judged_at_m > length_m + ROUNDING_M {
                return refused(
                    "opening, judged_at_m",
                    format!(
                        "opening {number} is judged at {judged_at_m} m, beyond the drive, which \
                         ends after {length_m} m"
                    ),
                );
            }
        }
        Ok(())
    }

    /// Samples are at most 8 mm apart below 1 m/s: no shape of any thickness slips between
    /// two discs of 100 mm, and no hull gets deeper than 0.2 mm into one unseen.
    fn check_way(&self) -> Result<(), ScenarioError> {
        let hull_m = f64::from(Ring::AMIRO.radius_m) - TOUCHING_M;
        for (stamp_us, pose) in Drive::of(self).samples() {
            let place = Vector::from(pose.position);
            let near = self.shapes.iter().enumerate().find(|(_, shape)| {
                (shape.centre() - place).norm() < hull_m + shape.reach_m()
                    && shape.distance_m(place) < hull_m
            });
            let Some((index, shape)) = near else {
                continue;
            };
            let collision = Collision {
                place,
                shape: self.shape_in_words(index),
                distance_m: shape.distance_m(place),
            };
            if stamp_us == 0 {
                return refused("start", collision.to_string());
            }
            let seconds = 1e-6 * stamp_us as f64;
            let what = format!("leg {}, {seconds:.2} s: {collision}", self.leg_at(seconds));
            return refused("drive", what);
        }
        Ok(())
    }

    /// The shape of an index as the file has it: boxes and cylinders count by themselves.
    fn shape_in_words(&self, index: usize) -> String {
        let kind = self.shapes.get(index).map_or("shape", Shape::kind);
        let before = self.shapes.iter().take(index);
        let number = 1 + before.filter(|shape| shape.kind() == kind).count();
        format!("{kind} {number}")
    }

    /// Number of the leg on which the robot is after the given seconds.
    fn leg_at(&self, seconds: f64) -> usize {
        let mut ends_s = 0.0;
        let begun = self.drive.iter().take_while(|leg| {
            let is_begun = ends_s < seconds;
            ends_s += leg.duration_s(self.speed_m_per_s);
            is_begun
        });
        begun.count()
    }
}

/// A hull in a shape.
struct Collision {
    place: Vector,
    shape: String,
    distance_m: f64,
}

impl fmt::Display for Collision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Vector { x, y } = self.place;
        write!(f, "the robot's centre at [{x:.3}, {y:.3}] is ")?;
        match self.distance_m {
            distance_m if distance_m > 0.0 => write!(
                f,
                "{:.1} mm from {}, its hull has a radius of {:.0} mm",
                1e3 * distance_m,
                self.shape,
                1e3 * Ring::AMIRO.radius_m
            )?,
            _ => write!(f, "inside {}", self.shape)?,
        }
        f.write_str("; allow = [\"collision\"] drives all the same")
    }
}

fn refused(key: &'static str, what: String) -> Result<(), ScenarioError> {
    Err(ScenarioError::Limit { key, what })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str) -> Result<(), String> {
        let text = format!(
            "name = \"d\"\ncell_m = 0.01\nextent_m = [-1, -1, 1, 1]\nstart = [0, 0, 0]\n{text}"
        );
        let scenario = Scenario::parse(&text).unwrap();
        scenario.check_drive().map_err(|error| error.to_string())
    }

    const SLOW: &str = "speed_m_per_s = 0.08\n";
    const AHEAD: &str = "[[drive]]\nstraight_m = 0.5\n";

    #[test]
    fn a_robot_that_starts_in_a_cylinder_is_refused() {
        let error = check(&format!(
            "{SLOW}[[box]]\nmin = [0.5, 0.5]\nmax = [0.6, 0.6]\n\
             [[cylinder]]\ncenter = [0.01, 0]\nradius_m = 0.1\n"
        ));
        let error = error.unwrap_err();
        assert!(error.starts_with("start: "), "{error}");
        assert!(
            error.contains("[0.000, 0.000] is inside cylinder 1"),
            "{error}"
        );
        let beside = check(&format!(
            "{SLOW}[[cylinder]]\ncenter = [0.12, 0]\nradius_m = 0.1\n"
        ));
        let error = beside.unwrap_err();
        assert!(error.contains("20.0 mm from cylinder 1"), "{error}");
    }

    #[test]
    fn a_path_through_a_thin_wall_is_refused_with_its_leg() {
        let wall = "[[box]]\nmin = [0.3, -0.5]\nmax = [0.301, 0.5]\n";
        let error = check(&format!(
            "{SLOW}[[drive]]\nturn_deg = 10\n[[drive]]\nturn_deg = -10\n{AHEAD}{wall}"
        ));
        let error = error.unwrap_err();
        assert!(error.starts_with("drive: leg 3, "), "{error}");
        assert!(error.contains("from box 1"), "{error}");
        let fast = check(&format!("speed_m_per_s = 1\n{AHEAD}{wall}"));
        assert!(fast.unwrap_err().starts_with("drive: leg 1, "));
        let allowed = format!("{SLOW}allow = [\"collision\"]\n{AHEAD}{wall}");
        assert_eq!(check(&allowed), Ok(()));
    }

    #[test]
    fn a_hull_may_touch_a_wall() {
        let along = |y: &str| {
            check(&format!(
                "{SLOW}{AHEAD}[[box]]\nmin = [0, {y}]\nmax = [1, 0.5]\n"
            ))
        };
        assert_eq!(along("0.05"), Ok(()));
        assert!(along("0.0495").is_err());
    }

    #[test]
    fn a_speed_that_the_filter_does_not_accept_is_refused() {
        let error = check(&format!("speed_m_per_s = 3\n{AHEAD}")).unwrap_err();
        assert!(error.starts_with("speed_m_per_s: 3 m/s, "), "{error}");
        assert_eq!(check(&format!("speed_m_per_s = 1\n{AHEAD}")), Ok(()));
        let arc = "[[drive]]\narc_deg = 90\nradius_m = 0.02\n";
        let error = check(&format!("speed_m_per_s = 0.25\n{AHEAD}{arc}")).unwrap_err();
        assert!(
            error.contains("leg 2") && error.contains("12.5 rad/s"),
            "{error}"
        );
        let allowed = format!("speed_m_per_s = 3\nallow = [\"speed\"]\n{AHEAD}{arc}");
        assert_eq!(check(&allowed), Ok(()));
    }

    #[test]
    fn an_opening_that_is_judged_after_the_drive_is_refused() {
        let at = |judged_at_m: &str| {
            check(&format!(
                "{SLOW}{AHEAD}[[opening]]\nmin = [0.5, 0.5]\nmax = [0.6, 0.6]\n\
                 judged_at_m = {judged_at_m}\n"
            ))
        };
        assert_eq!(at("0.5"), Ok(()));
        let error = at("5").unwrap_err();
        assert!(
            error.starts_with("opening, judged_at_m: opening 1 is judged at 5 m"),
            "{error}"
        );
    }
}
