//! A room of straight walls, and what sonars and lasers measure in it.

use amiro_ipf::random::{Generator, standard_normal_pair};

use super::RoomWalls;
use crate::drive::Return;
use crate::geometry::{Pose2, Vector};
use crate::sensors::{Cone, Scanner, Sensor};

/// How far a ray goes before it can meet a wall again, metres.
const LEAVES_M: f64 = 1e-9;

/// Two mirrors send a ray back if it returns within this angle of the way it came, as the
/// cosine: a right angle between walls does.
const SENT_BACK: f64 = -0.996;

/// How the sound of a sonar meets walls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SonarEchoes {
    /// Rays across a cone.
    pub rays: u16,
    /// Greatest angle between a ray and the wall's normal at which an echo comes back,
    /// radians; beyond it the wall is a mirror.
    pub incidence_rad: f64,
    /// Walls that mirror a ray before it is lost.
    pub mirrors: u16,
}

impl SonarEchoes {
    /// 25 rays, echoes within 25 degrees, three mirrors.
    pub const ROOM: Self = Self {
        rays: 25,
        incidence_rad: 25.0 / 180.0 * core::f64::consts::PI,
        mirrors: 3,
    };
}

/// Walls that sonars and lasers measure.
///
/// A laser beam ends at the first wall. A ray of a sonar gives an echo where it meets a wall
/// nearly at right angles; else the wall mirrors it, and the echo of a wall behind comes back
/// the same way, with a range that is too long. Of two mirrors at a right angle it comes back
/// beside itself. The range of a cone is the shortest of its rays.
#[derive(Clone, Debug, PartialEq)]
pub struct RangeWorld {
    /// The walls.
    pub walls: RoomWalls,
    /// How the sound of a sonar meets them.
    pub echoes: SonarEchoes,
}

/// Where a ray meets a wall.
#[derive(Clone, Copy, Debug)]
struct WallHit {
    distance_m: f64,
    /// Normal of the wall, either way.
    normal: Vector,
}

impl RangeWorld {
    /// What the sensor of a mount measures from its pose, with normal noise of the sensor's
    /// standard deviation.
    ///
    /// Infrared sensors measure no range and return nothing.
    pub fn measure(
        &self,
        sensor: &Sensor,
        world_from_sensor: &Pose2,
        rng: &mut Generator,
    ) -> Vec<Return> {
        match sensor {
            Sensor::Cone(cone) => {
                let range_m = self.sonar_m(cone, world_from_sensor);
                vec![noisy(range_m, cone.range_m, cone.sigma_m, rng)]
            }
            Sensor::Scanner(scanner) => {
                let beams = 0..scanner.beams;
                beams
                    .map(|beam| {
                        let range_m = self.beam_m(scanner, world_from_sensor, beam);
                        noisy(range_m, scanner.range_m, scanner.sigma_m, rng)
                    })
                    .collect()
            }
            Sensor::Infrared(_) => Vec::new(),
        }
    }

    /// The range of a sonar without noise, metres; `None` without an echo.
    #[must_use]
    pub fn sonar_m(&self, cone: &Cone, world_from_sensor: &Pose2) -> Option<f64> {
        let rays = self.echoes.rays.max(1);
        let ranges = (0..rays).filter_map(|ray| {
            let share = (f64::from(ray) + 0.5) / f64::from(rays);
            let bearing_rad = (2.0 * share - 1.0) * cone.half_angle_rad;
            let direction = direction(world_from_sensor, bearing_rad);
            self.echo_m(world_from_sensor.position, direction, cone.range_m[1])
        });
        ranges.reduce(f64::min)
    }

    /// The range of a beam without noise, metres; `None` beyond the scanner's farthest.
    #[must_use]
    pub fn beam_m(&self, scanner: &Scanner, world_from_sensor: &Pose2, beam: u16) -> Option<f64> {
        let bearing_rad = scanner.bearing_rad(usize::from(beam));
        let direction = direction(world_from_sensor, bearing_rad);
        let hit = self.first_hit(world_from_sensor.position, direction)?;
        (hit.distance_m <= scanner.range_m[1]).then_some(hit.distance_m)
    }

    /// Half of the way of a ray to its echo and back, metres.
    fn echo_m(&self, start: Vector, way: Vector, limit_m: f64) -> Option<f64> {
        let least = libm::cos(self.echoes.incidence_rad);
        let (mut place, mut direction, mut travelled_m) = (start, way, 0.0);
        for mirrors in 0..=self.echoes.mirrors {
            let hit = self.first_hit(place, direction)?;
            travelled_m += hit.distance_m;
            if travelled_m > limit_m {
                return None;
            }
            let across = direction.dot(hit.normal);
            if across.abs() >= least {
                return Some(travelled_m);
            }
            place = place + direction.scaled(hit.distance_m);
            direction = direction - hit.normal.scaled(2.0 * across);
            if mirrors == 1 && direction.dot(way) < SENT_BACK {
                let back_m = (start - place).dot(direction);
                return Some(0.5 * (travelled_m + back_m)).filter(|range_m| *range_m <= limit_m);
            }
        }
        None
    }

    fn first_hit(&self, place: Vector, direction: Vector) -> Option<WallHit> {
        let walls = self.walls.segments().iter();
        let hits = walls.filter_map(|[from, to]| {
            let wall = *to - *from;
            let across = direction.cross(wall);
            let distance_m = (*from - place).cross(wall) / across;
            let along = (*from - place).cross(direction) / across;
            // A wall along the ray gives NaN or infinity, and is not met.
            let is_met =
                distance_m > LEAVES_M && distance_m.is_finite() && (0.0..=1.0).contains(&along);
            is_met.then(|| WallHit {
                distance_m,
                normal: Vector::new(-wall.y, wall.x).scaled(1.0 / wall.norm()),
            })
        });
        hits.min_by(|a, b| a.distance_m.total_cmp(&b.distance_m))
    }
}

fn direction(world_from_sensor: &Pose2, bearing_rad: f64) -> Vector {
    let (sine, cosine) = libm::sincos(bearing_rad);
    Vector::new(cosine, sine).turned(world_from_sensor.heading)
}

fn noisy(
    range_m: Option<f64>,
    [nearest_m, farthest_m]: [f64; 2],
    sigma_m: f64,
    rng: &mut Generator,
) -> Return {
    // Drawn for every return, so that the numbers of one do not depend on the others.
    let (normal, _) = standard_normal_pair(rng);
    let range_m = range_m.map(|range_m| range_m + sigma_m * f64::from(normal));
    match range_m {
        Some(range_m) if range_m < nearest_m.max(LEAVES_M) => Return::TooClose,
        Some(range_m) if range_m <= farthest_m => Return::Echo { range_m, sigma_m },
        _ => Return::NoEcho {
            limit_m: farthest_m,
            sigma_m,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::Directivity;

    fn world(walls: &[[f64; 4]], degrees: f64) -> RangeWorld {
        let wall = |[x1, y1, x2, y2]: &[f64; 4]| [Vector::new(*x1, *y1), Vector::new(*x2, *y2)];
        RangeWorld {
            walls: RoomWalls::new(walls.iter().map(wall).collect()),
            echoes: SonarEchoes {
                incidence_rad: degrees.to_radians(),
                ..SonarEchoes::ROOM
            },
        }
    }

    fn cone(half_deg: f64) -> Cone {
        Cone {
            half_angle_rad: half_deg.to_radians(),
            range_m: [0.17, 5.0],
            sigma_m: 0.03,
            directivity: Directivity::Piston,
        }
    }

    fn at(x: f64, y: f64, degrees: f64) -> Pose2 {
        Pose2::new(x, y, degrees.to_radians())
    }

    const WALL: [f64; 4] = [2.0, -10.0, 2.0, 10.0];

    #[test]
    fn a_sonar_measures_the_distance_along_the_normal_while_that_lies_in_its_cone() {
        let world = world(&[WALL], 25.0);
        for degrees in [0.0, 5.0, -10.0] {
            let range_m = world.sonar_m(&cone(12.5), &at(0.5, 0.3, degrees)).unwrap();
            // The nearest ray is half a step of one degree off the normal.
            assert!((1.5..1.5002).contains(&range_m), "{degrees}: {range_m}");
        }
        // Beyond its cone the ray at the edge is the shortest: 20 - 12 degrees off the normal.
        let range_m = world.sonar_m(&cone(12.5), &at(0.5, 0.0, 20.0)).unwrap();
        let expected = 1.5 / f64::cos(8.0_f64.to_radians());
        assert!((range_m - expected).abs() < 1e-9, "{range_m}");
    }

    #[test]
    fn beyond_the_limit_of_incidence_a_wall_gives_no_echo() {
        let world = world(&[WALL], 25.0);
        // The ray at the edge meets the wall at 24.5 and at 25.5 degrees.
        assert!(world.sonar_m(&cone(12.5), &at(0.5, 0.0, 36.5)).is_some());
        assert!(world.sonar_m(&cone(12.5), &at(0.5, 0.0, 37.5)).is_none());
        assert!(world.sonar_m(&cone(12.5), &at(-4.0, 0.0, 0.0)).is_none());
    }

    #[test]
    fn a_mirror_gives_the_range_of_the_wall_behind_it() {
        // A ray at 45 degrees, mirrored at x = 2 to the left, meets y = 3 at 45 degrees and is
        // sent back beside itself: a corner of right angles.
        let corner = world(&[WALL, [-10.0, 3.0, 2.0, 3.0]], 25.0);
        let narrow = Cone {
            half_angle_rad: 1e-9,
            ..cone(1.0)
        };
        let range_m = corner.sonar_m(&narrow, &at(0.5, 0.0, 45.0)).unwrap();
        // Of a ray that two mirrors at a right angle send back, half of the way is the
        // distance from the corner along the ray.
        let expected = 1.5 * f64::cos(45_f64.to_radians()) + 3.0 * f64::sin(45_f64.to_radians());
        assert!((range_m - expected).abs() < 1e-6, "{range_m} {expected}");
        // A wall at right angles to the mirrored ray: 1.5 / cos 45 to the mirror, and on.
        let behind = world(&[WALL, [0.0, 2.0, 2.0, 4.0]], 25.0);
        let range_m = behind.sonar_m(&narrow, &at(0.5, 0.0, 45.0)).unwrap();
        let mirror = Vector::new(2.0, 1.5);
        let to_mirror_m = 1.5 * std::f64::consts::SQRT_2;
        let behind_m = mirror.distance_from_segment(Vector::new(0.0, 2.0), Vector::new(2.0, 4.0));
        assert!((range_m - to_mirror_m - behind_m).abs() < 1e-6, "{range_m}");
        // Without mirrors it is lost.
        let mut none = behind;
        none.echoes.mirrors = 0;
        assert!(none.sonar_m(&narrow, &at(0.5, 0.0, 45.0)).is_none());
    }

    #[test]
    fn a_laser_measures_along_each_beam_at_any_angle() {
        let world = world(&[WALL], 25.0);
        let scanner = Scanner {
            beams: 181,
            first_rad: -core::f64::consts::FRAC_PI_2,
            step_rad: 1_f64.to_radians(),
            range_m: [0.05, 8.0],
            sigma_m: 0.01,
        };
        for beam in [30, 90, 120] {
            let degrees = f64::from(beam) - 90.0;
            let range_m = world.beam_m(&scanner, &at(0.5, 1.0, 0.0), beam).unwrap();
            let expected = 1.5 / f64::cos(degrees.to_radians());
            assert!((range_m - expected).abs() < 1e-9, "{beam}: {range_m}");
        }
        assert!(world.beam_m(&scanner, &at(0.5, 1.0, 0.0), 0).is_none());
        assert!(world.beam_m(&scanner, &at(0.5, 1.0, 0.0), 175).is_none());
    }

    #[test]
    fn noise_has_the_sensor_s_deviation_and_ranges_stay_in_their_limits() {
        let world = world(&[WALL], 25.0);
        let mut rng = Generator::seeded(100);
        let sensor = Sensor::Cone(cone(12.5));
        let measured = |place, rng: &mut Generator| world.measure(&sensor, &place, rng)[0];
        let mut squares = 0.0;
        for _ in 0..4000 {
            let Return::Echo { range_m, .. } = measured(at(0.5, 0.0, 0.0), &mut rng) else {
                panic!("an echo");
            };
            squares += (range_m - 1.5).powi(2);
        }
        let sigma_m = (squares / 4000.0).sqrt();
        // 4 sigma / sqrt(2 n) = 4.5 %.
        assert!((sigma_m / 0.03 - 1.0).abs() < 0.045, "{sigma_m}");
        assert_eq!(measured(at(1.95, 0.0, 0.0), &mut rng), Return::TooClose);
        let none = measured(at(-4.0, 0.0, 0.0), &mut rng);
        assert!(matches!(none, Return::NoEcho { limit_m, .. } if limit_m >= 5.0));
    }
}
