//! A drive through one of the paper's scenarios, mapped by several methods at once.

use amiro_ipf::config::Config;
use amiro_ipf::filter::Profile;

use crate::drive::Record;
use crate::evaluation::Truth;
use crate::geometry::Pose2;
use crate::mapping::{Map, Mapper, Method, Setup};
use crate::pipeline;
use crate::rig::Rig;
use crate::world::{Options, Scenario, simulate_with};

use super::FigureError;

/// The scenarios, in the program itself: the figures need no file.
const SCENARIOS: [&str; 5] = [
    include_str!("../../../../scenarios/ssso.toml"),
    include_str!("../../../../scenarios/msso.toml"),
    include_str!("../../../../scenarios/msod.toml"),
    include_str!("../../../../scenarios/msm_l.toml"),
    include_str!("../../../../scenarios/msm_t.toml"),
];

/// Rounding of positions that is forgiven in travelled distances, metres.
const ROUNDING_M: f64 = 1e-5;

/// How a drive is simulated and filtered, where it is not as always.
#[derive(Clone, Copy, Debug)]
pub(super) struct Conditions {
    /// Seed of the sensors' noise and of the filter.
    pub(super) seed: u64,
    /// In what the world differs from the filter's model.
    pub(super) options: Options,
    /// Travelled distance after which nothing counts, metres.
    pub(super) until_m: f64,
    /// Particles a sensor, in place of 1000.
    pub(super) particles: Option<u16>,
    /// Gate, in place of the profile's.
    pub(super) gate: Option<u8>,
}

impl Conditions {
    /// A whole drive in a world as the model says.
    pub(super) fn seeded(seed: u64) -> Self {
        Self {
            seed,
            options: Options::default(),
            until_m: f64::INFINITY,
            particles: None,
            gate: None,
        }
    }
}

/// Maps of one drive.
#[derive(Clone, Debug)]
pub(super) struct Mapped {
    /// The maps, one a method in the order asked for.
    pub(super) maps: Vec<Map>,
    /// The robot's pose at each step that counted.
    pub(super) poses: Vec<Pose2>,
}

/// One of the paper's scenarios.
#[derive(Clone, Debug)]
pub(super) struct Course {
    /// The world and the way through it.
    pub(super) scenario: Scenario,
}

impl Course {
    /// The five scenarios in the paper's order.
    pub(super) fn all() -> Result<Vec<Self>, FigureError> {
        let parsed = SCENARIOS.iter().map(|text| {
            let scenario = Scenario::parse(text)?;
            Ok(Self { scenario })
        });
        parsed.collect()
    }

    /// The scenario in the paper's words.
    pub(super) fn title(&self) -> &'static str {
        match self.scenario.name.as_str() {
            "ssso" => "SSSO",
            "msso" => "MSSO",
            "msod" => "MSOD",
            "msm_l" => "L maze",
            _ => "T maze",
        }
    }

    /// Drives once and maps by every method.
    pub(super) fn map(
        &self,
        methods: &[Method],
        conditions: &Conditions,
    ) -> Result<Mapped, FigureError> {
        let simulation = simulate_with(&self.scenario, conditions.seed, &conditions.options);
        let mut poses = Vec::new();
        let maps = methods.iter().map(|method| {
            let config = self.config(method.profile().unwrap_or(Profile::Paper), conditions);
            let mut mapper = method.mapper(&Setup {
                rig: &Rig::from(&config),
                cell_m: self.scenario.cell_m,
                footprint: false,
                extent: Some(self.scenario.extent),
            });
            let mut travel = Travel::new(conditions.until_m);
            pipeline::records(method, &config, &simulation.inputs, &mut |record| {
                if travel.reaches(record) {
                    mapper.take(record);
                }
            })?;
            poses = travel.poses;
            Ok(mapper.map())
        });
        let maps = maps.collect::<Result<_, FigureError>>()?;
        Ok(Mapped { maps, poses })
    }

    fn config(&self, profile: Profile, conditions: &Conditions) -> Config {
        let mut config = self.scenario.config(profile);
        config.seed = conditions.seed;
        if let Some(particles) = conditions.particles {
            config.particles_per_sensor = particles;
        }
        if let Some(gate) = conditions.gate {
            config.parameters.gate = gate;
        }
        config
    }

    /// What could be seen from the poses.
    pub(super) fn truth(&self, poses: &[Pose2]) -> Truth {
        Truth::of(&self.scenario, poses)
    }
}

/// The way so far, up to a distance.
struct Travel {
    left_m: f64,
    poses: Vec<Pose2>,
}

impl Travel {
    fn new(until_m: f64) -> Self {
        Self {
            left_m: until_m + ROUNDING_M,
            poses: Vec::new(),
        }
    }

    /// Whether a record still counts.
    fn reaches(&mut self, record: &Record) -> bool {
        if let Record::Pose {
            world_from_body, ..
        } = record
        {
            let last = self.poses.last().unwrap_or(world_from_body);
            self.left_m -= (world_from_body.position - last.position).norm();
            if self.left_m >= 0.0 {
                self.poses.push(*world_from_body);
            }
        }
        self.left_m >= 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_a_drive_ends_where_it_is_told_to() {
        let courses = Course::all().unwrap();
        let course = courses.last().unwrap();
        assert_eq!(course.title(), "T maze");
        let conditions = Conditions {
            until_m: 0.43,
            particles: Some(20),
            ..Conditions::seeded(1)
        };
        let mapped = course.map(&[Method::PLUS], &conditions).unwrap();
        let end = mapped.poses.last().unwrap();
        // The drive begins at y = -430 mm, a step is 10 mm.
        assert!((-0.0101..1e-5).contains(&end.position.y), "{end:?}");
        assert!(end.position.x.abs() < 1e-5, "{end:?}");
        assert_eq!(mapped.maps.len(), 1);
    }
}
