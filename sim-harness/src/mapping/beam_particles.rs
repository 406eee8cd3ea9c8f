//! A map from the inverted particle filter for range beams.

use amiro_ipf::beam_filter::{
    BeamFilterParameters, BeamModel, BeamParticleFilter, BeamRange, RangeBeam,
};
use amiro_ipf::geometry::{Angle, Motion, Point, Pose};
use amiro_ipf::random::Generator;

use super::{Belief, Calculus, Counts, Evidence, FinishProgress, Grid, Map, Mapper, mount_returns};
use crate::drive::{RangeScan, Record, Return};
use crate::geometry::{Pose2, Vector};
use crate::lattice::Lattice;
use crate::rig::Rig;
use crate::sensors::Sensor;

/// The form of the filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BeamForm {
    /// [`BeamFilterParameters::PAPER`].
    Paper,
    /// [`BeamFilterParameters::MOVING`].
    Moving,
}

/// Particles that fit, and those for sensors of at most [`SHORT_M`].
const PARTICLES: usize = 2000;
const PARTICLES_OF_SHORT: usize = 1000;

/// Longest range of a time-of-flight row, metres: a disc of 1.5 m serves it, and one of
/// 3 m with a doubled tolerance the sensors that measure farther.
const SHORT_M: f64 = 2.0;

/// How much shorter than the disc's radius a beam is at most, metres.
const MARGIN_M: f64 = 0.1;

/// Most beams of one sensor per cycle; of a scanner with more every second, third, ... is
/// taken: each fifth of 361.
const MOST_BEAMS: usize = 80;

/// Seed of the filter.
const SEED: u64 = 1;

/// Counts the low and high particles of each cycle in a grid that is fixed in the world.
///
/// A cycle has all beams of one stamp. A high particle counts as occupied in its cell, a
/// low one as free; the belief is that of [`Counts`]. A scanner gives its beams, a cone its
/// axis, which is crude: the surface may lie anywhere in the cone. Infrared sensors are
/// passed over. A range beyond the disc is a beam without an echo. After a reset of the
/// odometry the filter begins anew; the counts stay.
///
/// The map lacks the last stamp until [`Mapper::finish`].
#[derive(Debug)]
pub struct BeamMapper {
    rig: Rig,
    model: BeamModel,
    count: usize,
    reach_m: f64,
    filter: Box<BeamParticleFilter<PARTICLES>>,
    rng: Generator,
    /// Pose of the last cycle; `None` before the first one.
    last: Option<Pose2>,
    /// Stamp, pose and beams of the cycle that is not run yet.
    next: Option<(u64, Pose2, Vec<RangeBeam>)>,
    counts: Grid<[u16; 2]>,
}

impl BeamMapper {
    /// A mapper for the sensors of a rig, with cells of the given size, metres.
    #[must_use]
    pub fn new(lattice: impl Into<Lattice>, rig: &Rig, form: BeamForm) -> Self {
        let farthest = rig.mounts.iter().filter_map(|mount| match &mount.sensor {
            Sensor::Scanner(scanner) => Some(scanner.range_m[1]),
            Sensor::Cone(cone) => Some(cone.range_m[1]),
            Sensor::Infrared(_) => None,
        });
        let is_short = farthest.fold(0.0, f64::max) <= SHORT_M;
        let frames = match form {
            BeamForm::Paper => BeamFilterParameters::PAPER.for_frames(),
            BeamForm::Moving => BeamFilterParameters::MOVING.for_frames(),
        };
        let (parameters, count) = if is_short {
            (frames, PARTICLES_OF_SHORT)
        } else {
            let twice = BeamFilterParameters {
                local_radius_m: 2.0 * frames.local_radius_m,
                beam_tolerance_m: 2.0 * frames.beam_tolerance_m,
                ..frames
            };
            (twice, PARTICLES)
        };
        Self::with_parameters(lattice, rig, parameters, count)
    }

    /// A mapper with parameters of its own, and a number of particles, at most 2000.
    ///
    /// # Panics
    /// If a parameter is outside its range.
    #[must_use]
    #[expect(
        clippy::expect_used,
        reason = "the parameters are constants of the program"
    )]
    pub fn with_parameters(
        lattice: impl Into<Lattice>,
        rig: &Rig,
        parameters: BeamFilterParameters,
        count: usize,
    ) -> Self {
        Self {
            rig: rig.clone(),
            model: BeamModel::new(parameters).expect("parameters of the beam filter"),
            count,
            reach_m: f64::from(parameters.local_radius_m) - MARGIN_M,
            filter: Box::new(BeamParticleFilter::new()),
            rng: Generator::seeded(SEED),
            last: None,
            next: None,
            counts: Grid::new(lattice, Counts.blank()),
        }
    }

    /// Adds the beams of a scan to those of its stamp.
    fn add(&mut self, scan: &RangeScan) {
        if self
            .next
            .as_ref()
            .is_some_and(|next| next.0 != scan.stamp_us)
        {
            self.run_cycle();
        }
        let (_, _, beams) = self
            .next
            .get_or_insert_with(|| (scan.stamp_us, scan.world_from_body, Vec::new()));
        for mounted in mount_returns(&self.rig, scan) {
            let mount = mounted.mount;
            let number = mount.sensor.model().returns();
            let stride = number.div_ceil(MOST_BEAMS).max(1);
            for (index, measured) in mounted.recorded().enumerate() {
                let bearing_rad = match &mount.sensor {
                    Sensor::Scanner(it) => it.bearing_rad(index),
                    Sensor::Cone(_) => 0.0,
                    Sensor::Infrared(_) => continue,
                };
                let Some(range) = beam_range(measured, self.reach_m) else {
                    continue;
                };
                if index % stride == 0 {
                    let at = mount.body_from_sensor;
                    let axis = Pose::new(
                        at.position.x as f32,
                        at.position.y as f32,
                        (at.heading_rad() + bearing_rad) as f32,
                    );
                    beams.extend(RangeBeam::new(&axis, range));
                }
            }
        }
    }

    /// Runs the cycle of the beams that were added, and counts its particles.
    fn run_cycle(&mut self) {
        let Some((_, pose, beams)) = self.next.take() else {
            return;
        };
        let motion = self.motion_to(&pose);
        self.last = Some(pose);
        self.filter
            .cycle(&self.model, &motion, &beams, &mut self.rng);
        for particle in self.filter.particles() {
            if !particle.is_low() && !particle.is_high() {
                continue;
            }
            // The axes of the particles are those of the world.
            let Point { x, y } = particle.position;
            let place = pose.position + Vector::new(f64::from(x), f64::from(y));
            if let Some(held) = self.counts.reach_at(place.x, place.y) {
                let evidence = Evidence {
                    is_occupied: particle.is_high(),
                    weight: 1.0,
                };
                Counts.update(held, evidence);
            }
        }
    }

    /// The motion since the last cycle; before the first one the filter is filled.
    fn motion_to(&mut self, pose: &Pose2) -> Motion {
        let Some(last) = self.last else {
            let heading = Angle::from_radians(pose.heading_rad() as f32);
            self.filter
                .reset(&self.model, self.count, heading, &mut self.rng);
            return Motion::NONE;
        };
        // The heading of the poses, not a sum of turns that were rounded.
        self.filter
            .set_heading(Angle::from_radians(last.heading_rad() as f32));
        let Vector { x, y } = last.view(pose.position);
        Motion {
            displacement: Point::new(x as f32, y as f32),
            turn: Angle::from_radians((pose.heading_rad() - last.heading_rad()) as f32),
        }
    }
}

/// A return as the filter takes it; `None` for no measurement.
fn beam_range(measured: Return, reach_m: f64) -> Option<BeamRange> {
    match measured {
        Return::Echo { range_m, .. } if range_m <= reach_m => Some(BeamRange::Echo(range_m as f32)),
        Return::Echo { .. } => Some(BeamRange::NoEcho(reach_m as f32)),
        Return::NoEcho { limit_m, .. } => Some(BeamRange::NoEcho(limit_m.min(reach_m) as f32)),
        Return::TooClose | Return::Invalid => None,
    }
}

impl Mapper for BeamMapper {
    fn take(&mut self, record: &Record) {
        match record {
            Record::Scan(scan) => self.add(scan),
            Record::OdometryReset { .. } => {
                self.run_cycle();
                self.last = None;
            }
            Record::Pose { .. } | Record::Outcomes(_) => {}
        }
    }

    fn finish(&mut self, _progress: &mut dyn FnMut(FinishProgress)) {
        self.run_cycle();
    }

    fn map(&self) -> Map {
        self.counts.map(Belief::UNKNOWN, |held| Counts.belief(held))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mapping::Occupancy;
    use crate::rig::SensorMount;
    use crate::sensors::{Cone, Scanner};

    fn rig(sensor: Sensor) -> Rig {
        Rig {
            name: "one".to_owned(),
            about: "one sensor".to_owned(),
            radius_m: 0.1,
            track_m: None,
            mounts: vec![SensorMount {
                name: "front".to_owned(),
                body_from_sensor: Pose2::new(0.0, 0.0, 0.0),
                sensor,
            }],
        }
    }

    fn row() -> Sensor {
        Sensor::Scanner(Scanner {
            beams: 8,
            first_rad: 0.35,
            step_rad: -0.1,
            range_m: [0.0, 2.0],
            sigma_m: 0.01,
        })
    }

    /// Drives along x towards a wall at x = 1, with steps of 10 mm.
    fn driven(rig: &Rig, form: BeamForm, measured: impl Fn(usize, f64) -> Return) -> Map {
        let mut mapper = BeamMapper::new(0.05, rig, form);
        let returns = rig.mounts[0].sensor.model().returns();
        for step in 0..40_u32 {
            let x = 0.01 * f64::from(step);
            let measured = (0..returns).map(|index| measured(index, 1.0 - x));
            mapper.take(&Record::Scan(RangeScan {
                stamp_us: u64::from(step),
                world_from_body: Pose2::new(x, 0.0, 0.0),
                mounts: 0..1,
                returns: measured.collect(),
                signals: Vec::new(),
            }));
        }
        mapper.finish(&mut |_| {});
        mapper.map()
    }

    fn echo(range_m: f64) -> Return {
        Return::Echo {
            range_m,
            sigma_m: 0.01,
        }
    }

    #[test]
    fn a_wall_is_occupied_and_the_way_to_it_is_free() {
        for form in [BeamForm::Paper, BeamForm::Moving] {
            let map = driven(&rig(row()), form, |index, to_wall_m| {
                echo(to_wall_m / f64::cos(0.35 - 0.1 * index as f64))
            });
            // The paper's form has particles at few of eight beam ends.
            if form == BeamForm::Moving {
                assert!(map.count(Occupancy::Occupied) > 0);
            }
            for cell in map.cells_of(Occupancy::Occupied) {
                let (x, y) = map.lattice().centre(cell);
                assert!((x - 1.0).abs() < 0.1, "{form:?}: {x} {y}");
            }
            assert!(map.count(Occupancy::Free) > 0, "{form:?}");
            assert_eq!(map.occupancy_at(-0.5, 0.0), Occupancy::Unknown, "{form:?}");
        }
    }

    #[test]
    fn ranges_beyond_the_disc_and_returns_without_an_echo_only_clear() {
        let limit = Return::NoEcho {
            limit_m: 2.0,
            sigma_m: 0.01,
        };
        for measured in [limit, echo(1.9)] {
            let map = driven(&rig(row()), BeamForm::Moving, |_, _| measured);
            assert_eq!(map.count(Occupancy::Occupied), 0);
            assert!(map.count(Occupancy::Free) > 50);
        }
    }

    #[test]
    fn a_cone_is_a_beam_along_its_axis() {
        let cone = Sensor::Cone(Cone {
            half_angle_rad: 0.4,
            range_m: [0.0, 2.0],
            sigma_m: 0.01,
            directivity: crate::sensors::Directivity::Piston,
        });
        let map = driven(&rig(cone), BeamForm::Moving, |_, to_wall_m| echo(to_wall_m));
        assert!(map.count(Occupancy::Free) > 0);
        for cell in map.cells_of(Occupancy::Free) {
            let (_, y) = map.lattice().centre(cell);
            // Tolerance of the beam, half a cell, and 5 sigma of the motion noise.
            assert!(y.abs() < 0.04 + 0.025 + 0.016, "{y}");
        }
    }

    #[test]
    fn scans_of_one_stamp_are_one_cycle_and_a_reset_begins_anew() {
        let rig = rig(row());
        let scan = |stamp_us, x| {
            Record::Scan(RangeScan {
                stamp_us,
                world_from_body: Pose2::new(x, 0.0, 0.0),
                mounts: 0..1,
                returns: vec![echo(1.0); 8],
                signals: Vec::new(),
            })
        };
        let mut mapper = BeamMapper::new(0.05, &rig, BeamForm::Moving);
        mapper.take(&scan(0, 0.0));
        mapper.take(&scan(0, 0.0));
        assert_eq!(mapper.next.as_ref().unwrap().2.len(), 16);
        assert!(mapper.last.is_none());
        mapper.take(&Record::OdometryReset { stamp_us: 1 });
        assert!(mapper.next.is_none() && mapper.last.is_none());
        let before = mapper.map().count(Occupancy::Free);
        assert!(before > 0);
        mapper.take(&scan(1, 50.0));
        mapper.finish(&mut |_| {});
        assert!(mapper.map().count(Occupancy::Free) > before);
    }
}
