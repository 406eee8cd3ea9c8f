//! The filter's configuration for a simulated world.

use amiro_ipf::filter::Profile;
use amiro_ipf::node::Config;

use crate::world::Scenario;

impl Scenario {
    /// The configuration of the filter for this world: the given profile, 1000 particles
    /// per sensor, seed 1, and the sensors that the scenario uses.
    #[must_use]
    pub fn config(&self, profile: Profile) -> Config {
        let (ring, sensors) = self.ring();
        Config {
            ring,
            sensors,
            ..Config::amiro(profile)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::standard_scenarios;

    #[test]
    fn the_papers_scenarios_have_legal_configurations() {
        for scenario in standard_scenarios().unwrap() {
            let config = scenario.config(Profile::Plus);
            assert_eq!(config.sensors, scenario.ring().1, "{}", scenario.name);
            assert_eq!(config.validate(), Ok(()), "{}", scenario.name);
        }
    }
}
