//! Any text as a scenario file.

use amiro_ipf::filter::Profile;
use amiro_ipf::node::Input;
use sim_harness::world::{Scenario, simulate};

use crate::recordings::assert_is_printable;

/// Longest drive that is simulated here, seconds.
const LONGEST_S: f64 = 2.0;
/// Most shapes in it.
const MOST_SHAPES: usize = 20;

/// Parses the text; what is a scenario can be driven, and says only finite numbers.
pub fn check(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let scenario = match Scenario::parse(&text) {
        Ok(scenario) => scenario,
        Err(error) => {
            assert_is_printable(&error.to_string());
            return;
        }
    };
    assert_is_printable(&scenario.name);
    assert_is_printable(&scenario.about);
    for profile in [Profile::Paper, Profile::Plus] {
        assert_eq!(scenario.config(profile).validate(), Ok(()));
    }
    let duration_s = scenario.duration_s();
    assert!(duration_s.is_finite() && duration_s >= 0.0);
    if duration_s > LONGEST_S || scenario.shapes.len() > MOST_SHAPES {
        return;
    }
    let simulation = simulate(&scenario, 1);
    assert!(!simulation.poses.is_empty());
    for input in &simulation.inputs {
        if let Input::Odometry { pose, .. } = input {
            assert!(pose.is_finite(), "{pose:?}");
        }
    }
}
