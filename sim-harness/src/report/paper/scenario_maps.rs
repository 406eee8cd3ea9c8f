//! A drive through one of the paper's scenarios, mapped by several methods.

use amiro_ipf::filter::Profile;
use amiro_ipf::node::Config;

use super::FigureError;
use crate::drive::Record;
use crate::geometry::Pose2;
use crate::mapping::{Map, Mapper, Method, Setup};
use crate::pipeline;
use crate::rig::Rig;
use crate::world::{Options, Scenario, simulate_with};

/// Rounding of positions that is allowed for in travelled distances, metres.
const ROUNDING_M: f64 = 1e-5;

/// How a drive is simulated and filtered.
#[derive(Clone, Copy, Debug)]
pub(super) struct Conditions {
    /// Seed of the sensors' noise and of the filter.
    pub(super) seed: u64,
    /// How the world differs from the filter's model.
    pub(super) options: Options,
    /// Travelled distance after which events are ignored, metres.
    pub(super) until_m: f64,
    /// Particles per sensor; `None` for the scenario's 1000.
    pub(super) particles: Option<u16>,
    /// Gate; `None` for the profile's.
    pub(super) gate: Option<u8>,
}

impl Conditions {
    /// A whole drive in a world that agrees with the model.
    pub(super) fn seeded(seed: u64) -> Self {
        Self {
            seed,
            options: Options::default(),
            until_m: f64::INFINITY,
            particles: None,
            gate: None,
        }
    }

    /// The configuration of a method's filter.
    fn config(&self, scenario: &Scenario, method: &Method) -> Config {
        let mut config = scenario.config(method.profile.unwrap_or(Profile::Paper));
        config.seed = self.seed;
        if let Some(particles) = self.particles {
            config.particles_per_sensor = particles;
        }
        if let Some(gate) = self.gate {
            config.parameters.gate = gate;
        }
        config
    }
}

/// Maps of one drive.
#[derive(Clone, Debug)]
pub(super) struct ScenarioMaps {
    /// The maps, one per method in the order of the methods.
    pub(super) maps: Vec<Map>,
    /// The robot's pose at each step that was not ignored.
    pub(super) poses: Vec<Pose2>,
}

/// The name of a scenario in the paper.
pub(super) fn paper_name(scenario: &Scenario) -> &'static str {
    match scenario.name.as_str() {
        "ssso" => "SSSO",
        "msso" => "MSSO",
        "msod" => "MSOD",
        "msm_l" => "L maze",
        _ => "T maze",
    }
}

impl ScenarioMaps {
    /// Drives once and maps by every method.
    pub(super) fn new(
        scenario: &Scenario,
        methods: &[Method],
        conditions: &Conditions,
    ) -> Result<Self, FigureError> {
        let simulation = simulate_with(scenario, conditions.seed, &conditions.options);
        let mut poses = Vec::new();
        let maps = methods.iter().map(|method| {
            let config = conditions.config(scenario, method);
            let mut mapper = method.mapper(&Setup {
                rig: &Rig::from(&config),
                lattice: scenario.cell_m.into(),
                footprint: false,
                no_echo: None,
                extent: Some(scenario.extent),
            });
            let mut travel = Travel::new(conditions.until_m);
            let records = |take: &mut dyn FnMut(&Record)| {
                pipeline::records(method, &config, &simulation.inputs, &mut |record| {
                    if travel.includes(record) {
                        take(record);
                    }
                })
            };
            pipeline::run(records, &mut mapper, &mut |_, _| {})?;
            poses = travel.poses;
            Ok(mapper.map())
        });
        let maps = maps.collect::<Result<_, FigureError>>()?;
        Ok(Self { maps, poses })
    }
}

/// The path so far, up to a distance.
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

    /// Whether a record lies within the distance.
    fn includes(&mut self, record: &Record) -> bool {
        if let Some(pose) = record.pose() {
            let last = self.poses.last().unwrap_or(&pose);
            self.left_m -= (pose.position - last.position).norm();
            if self.left_m >= 0.0 {
                self.poses.push(pose);
            }
        }
        self.left_m >= 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::standard_scenarios;

    #[test]
    fn half_a_drive_ends_at_its_distance() {
        let scenarios = standard_scenarios().unwrap();
        let scenario = scenarios.last().unwrap();
        assert_eq!(paper_name(scenario), "T maze");
        let conditions = Conditions {
            until_m: 0.43,
            particles: Some(20),
            ..Conditions::seeded(1)
        };
        let drive = ScenarioMaps::new(scenario, &[Method::PLUS], &conditions).unwrap();
        let end = drive.poses.last().unwrap();
        // The drive begins at y = -430 mm, a step is 10 mm.
        assert!((-0.0101..1e-5).contains(&end.position.y), "{end:?}");
        assert!(end.position.x.abs() < 1e-5, "{end:?}");
        assert_eq!(drive.maps.len(), 1);
    }
}
