//! The gain of a calibration on a block, under the physics of a simulated world.

use amiro_ipf::model::{Photometry, Sample};
use amiro_ipf::node::Input;

use crate::world::{OdometryModel, Options, Scenario, ScenarioError, simulate_with};

/// The block, its long side 100 mm ahead of sensor 0.
const BLOCK: &str = include_str!("block.toml");

/// Distance of the block's side from the sensor, metres.
const RANGE_M: f32 = 0.1;

/// Why there is no gain.
#[derive(Debug, thiserror::Error)]
pub enum BlockGainError {
    /// The built-in scenario is none; a test holds that it is one.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// The simulated sensor gave no counts.
    #[error("the calibration has no reading")]
    NoReading,
}

/// The gain of a calibration on a block's long side, counts m^2: the gain with which a
/// point at 100 mm straight ahead of one sensor has the block's signal.
///
/// # Errors
/// The simulated sensor gave no counts.
pub fn block_gain(options: &Options) -> Result<f32, BlockGainError> {
    let scenario = Scenario::parse(BLOCK)?;
    let quiet = Options {
        noise_factor: 0.0,
        odometry: OdometryModel::Truth,
        ..*options
    };
    let readings = simulate_with(&scenario, 0, &quiet).inputs;
    let counts = readings.iter().find_map(|input| match input {
        Input::Proximity {
            samples: [Sample::Counts(counts), ..],
            ..
        } => Some(*counts as f32),
        _ => None,
    });
    let counts = counts.ok_or(BlockGainError::NoReading)?;
    Ok((counts - Photometry::VCNL4020.beta_counts) * RANGE_M * RANGE_M)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::Physics;

    #[test]
    fn a_sensor_that_obeys_the_filter_s_law_has_its_own_gain() {
        let gain = block_gain(&Options::default()).unwrap();
        // Counts are integers: half a count at 100 mm.
        let own = Photometry::VCNL4020.alpha_counts_m2;
        assert!((gain - own).abs() <= 0.5 * RANGE_M * RANGE_M, "{gain}");
        let patch = Options {
            physics: Physics::Patch,
            ..Options::default()
        };
        assert!((block_gain(&patch).unwrap() - gain).abs() > 0.02);
    }
}
