//! The experiment of Kleppe and Skavhaug 2013: one infrared sensor on a servo.
//!
//! There is no truth: the particles are compared with the end points of the sweep itself.

use amiro_ipf::beam_filter::{
    BeamFilterParameters, BeamModel, BeamParticle, BeamParticleFilter, BeamRange, RangeBeam,
};
use amiro_ipf::filter::ParameterError;
use amiro_ipf::geometry::{Angle, Motion, Pose};
use amiro_ipf::random::Generator;

use super::{ServoSweep, SweepReading};
use crate::drive::Return;
use crate::geometry::Vector;

/// Most particles of a run.
const PARTICLES: usize = 10_000;

/// A particle is at an end point, and an end point is covered, within this distance, metres.
const NEAR_M: f64 = 0.05;

/// Half the width of the ring at the maximum range, metres.
const RING_M: f64 = 0.03;

/// Range that the paper's sensor measures, metres; one that measures farther has a disc and
/// a tolerance of its own.
const SHORT_M: f64 = 0.8;

/// Particles so far beside the sector of a sweep are never moved, radians.
const BESIDE_RAD: f64 = 25.0 / 180.0 * core::f64::consts::PI;

/// How the filter takes a return without an echo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MaximumRange {
    /// Nothing is in the way up to the limit: the corrected form.
    Clears,
    /// An obstacle at the limit: as the paper prints it.
    Obstacle,
}

impl MaximumRange {
    /// Both forms.
    pub const ALL: [Self; 2] = [Self::Clears, Self::Obstacle];

    /// Its name in tables and files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Clears => "corrected",
            Self::Obstacle => "printed",
        }
    }
}

/// How a sweep is run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ServoScan {
    /// Particles, at most 10 000.
    pub particles: usize,
    /// Times that the sweep is passed, there and back in turn as the servo moves.
    pub passes: usize,
    /// How the filter takes a return without an echo.
    pub maximum: MaximumRange,
    /// The sensor's greatest range, metres, where the recording has returns without an echo.
    pub limit_m: Option<f64>,
    /// Seed of the filter.
    pub seed: u64,
}

/// A particle at the end of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ServoParticle {
    /// Where it is, metres from the sensor.
    pub place: Vector,
    /// Probability that this is part of an obstacle.
    pub weight: f64,
}

/// Figures of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ServoScanFigures {
    /// Particles with a high weight.
    pub high: usize,
    /// Those of them within 5 cm of an end point.
    pub high_near: usize,
    /// End points of the sweep.
    pub ends: usize,
    /// End points within 5 cm of a high particle.
    pub ends_covered: usize,
    /// Particles in the free sector that are no obstacle, before the first reading and at the
    /// end; obstacles that are not at an end are missing in `high_near`.
    pub free: [usize; 2],
    /// High particles within 3 cm of the greatest range.
    pub ring: usize,
    /// Largest change of a weight outside of the sector.
    pub outside_change: f64,
}

/// A run with its particles.
#[derive(Clone, Debug, PartialEq)]
pub struct ServoScanRun {
    /// The particles.
    pub particles: Vec<ServoParticle>,
    /// Radius of the disc, metres.
    pub radius_m: f64,
    /// Its figures.
    pub figures: ServoScanFigures,
}

impl ServoScan {
    /// Runs the filter over a sweep, a cycle per reading, and one without a reading: a
    /// resampling that is due comes before the readings of a cycle, and the paper's after it.
    ///
    /// # Errors
    /// A parameter outside its range: none of the program's own is.
    pub fn run(&self, sweep: &ServoSweep) -> Result<ServoScanRun, ParameterError> {
        let parameters = self.parameters();
        let model = BeamModel::new(parameters)?;
        let mut rng = Generator::seeded(self.seed);
        let mut filter = Box::new(BeamParticleFilter::<PARTICLES>::new());
        filter.reset(&model, self.particles, Angle::default(), &mut rng);
        let start = particles(&filter);
        for pass in 0..self.passes {
            let mut readings: Vec<&SweepReading> = sweep.readings.iter().collect();
            if pass % 2 == 1 {
                readings.reverse();
            }
            for reading in readings {
                let beam = self.beam(reading);
                filter.cycle(&model, &Motion::NONE, beam.as_slice(), &mut rng);
            }
        }
        filter.cycle(&model, &Motion::NONE, &[], &mut rng);
        let particles = particles(&filter);
        Ok(ServoScanRun {
            figures: self.figures(sweep, &start, &particles),
            particles,
            radius_m: f64::from(parameters.local_radius_m),
        })
    }

    /// The paper's form; for a sensor that measures beyond 0.8 m a disc of 1.3 m and a
    /// tolerance of 3 cm.
    fn parameters(&self) -> BeamFilterParameters {
        if self.limit_m.is_none_or(|limit_m| limit_m <= SHORT_M) {
            return BeamFilterParameters::PAPER;
        }
        BeamFilterParameters {
            local_radius_m: 1.3,
            beam_tolerance_m: 0.03,
            ..BeamFilterParameters::PAPER
        }
    }

    /// The beam of a reading; none for one that is no measurement.
    fn beam(&self, reading: &SweepReading) -> Option<RangeBeam> {
        let range = match (reading.measured, self.maximum) {
            (Return::Echo { range_m, .. }, _) => BeamRange::Echo(range_m as f32),
            (Return::NoEcho { limit_m, .. }, MaximumRange::Clears) => {
                BeamRange::NoEcho(limit_m as f32)
            }
            (Return::NoEcho { limit_m, .. }, MaximumRange::Obstacle) => {
                BeamRange::Echo(limit_m as f32)
            }
            (Return::TooClose | Return::Invalid, _) => return None,
        };
        // Only the bearing: the heading of the axes stays, since the servo turns and not they.
        let axis = Pose::new(0.0, 0.0, reading.bearing_rad as f32);
        RangeBeam::new(&axis, range).ok()
    }
}

fn particles(filter: &BeamParticleFilter<PARTICLES>) -> Vec<ServoParticle> {
    let particle = |it: &BeamParticle| ServoParticle {
        place: Vector::from(it.position),
        weight: f64::from(it.weight),
    };
    filter.particles().map(particle).collect()
}

impl ServoParticle {
    /// Whether its weight is high.
    #[must_use]
    pub fn is_high(&self) -> bool {
        self.weight > f64::from(BeamParticle::HIGH)
    }

    /// Whether its weight is low.
    #[must_use]
    pub fn is_low(&self) -> bool {
        self.weight < f64::from(BeamParticle::LOW)
    }
}

impl ServoScan {
    fn figures(
        &self,
        sweep: &ServoSweep,
        start: &[ServoParticle],
        found: &[ServoParticle],
    ) -> ServoScanFigures {
        let ends: Vec<Vector> = sweep.ends().collect();
        let high = found.iter().filter(|it| it.is_high());
        let high: Vec<Vector> = high.map(|it| it.place).collect();
        let is_near = |places: &[Vector], of: &Vector| {
            let mut places = places.iter();
            places.any(|place| (*place - *of).norm() <= NEAR_M)
        };
        let ring = |limit_m: f64| {
            let high = high.iter();
            high.filter(|place| (place.norm() - limit_m).abs() < RING_M)
                .count()
        };
        let is_free = |it: &&ServoParticle| !it.is_high() && is_free(sweep, it.place);
        ServoScanFigures {
            high: high.len(),
            high_near: high.iter().filter(|place| is_near(&ends, place)).count(),
            ends: ends.len(),
            ends_covered: ends.iter().filter(|end| is_near(&high, end)).count(),
            free: [start, found].map(|all| all.iter().filter(is_free).count()),
            ring: self.limit_m.map_or(0, ring),
            outside_change: self.outside_change(sweep, found),
        }
    }

    /// Largest change of a weight beside the sector, where no beam with its tolerance reaches.
    fn outside_change(&self, sweep: &ServoSweep, found: &[ServoParticle]) -> f64 {
        let tolerance_m = f64::from(self.parameters().beam_tolerance_m);
        let nearest_m = tolerance_m / libm::sin(BESIDE_RAD);
        let [first_rad, last_rad] = sweep.sector();
        let sector = first_rad - BESIDE_RAD..=last_rad + BESIDE_RAD;
        let outside = found
            .iter()
            .filter(|it| !sector.contains(&bearing_rad(it.place)) && it.place.norm() > nearest_m);
        outside.fold(0.0, |most, it| (it.weight - 0.5).abs().max(most))
    }
}

fn bearing_rad(place: Vector) -> f64 {
    libm::atan2(place.y, place.x)
}

/// Whether a place is before the reading nearest in direction, by more than 5 cm.
fn is_free(sweep: &ServoSweep, place: Vector) -> bool {
    let bearing_rad = bearing_rad(place);
    let [first_rad, last_rad] = sweep.sector();
    let reading = sweep.towards(bearing_rad);
    let clear_m = reading.map_or(0.0, |reading| match reading.measured {
        Return::Echo { range_m, .. } => range_m - NEAR_M,
        Return::NoEcho { limit_m, .. } => limit_m - NEAR_M,
        Return::TooClose | Return::Invalid => 0.0,
    });
    (first_rad..=last_rad).contains(&bearing_rad) && place.norm() < clear_m
}

impl ServoScanFigures {
    /// Share of the high particles within 5 cm of an end point; NaN without any.
    #[must_use]
    pub fn near_share(&self) -> f64 {
        self.high_near as f64 / self.high as f64
    }

    /// Share of the end points that are covered.
    #[must_use]
    pub fn covered_share(&self) -> f64 {
        self.ends_covered as f64 / self.ends as f64
    }

    /// Density in the free sector, in parts of the density before the first reading.
    #[must_use]
    pub fn free_density(&self) -> f64 {
        self.free[1] as f64 / self.free[0] as f64
    }

    /// The sums of the counts of two runs.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            high: self.high + other.high,
            high_near: self.high_near + other.high_near,
            ends: self.ends + other.ends,
            ends_covered: self.ends_covered + other.ends_covered,
            free: [self.free[0] + other.free[0], self.free[1] + other.free[1]],
            ring: self.ring + other.ring,
            outside_change: self.outside_change.max(other.outside_change),
        }
    }
}
