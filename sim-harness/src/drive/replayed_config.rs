//! The configuration under which a recording is replayed.

use amiro_ipf::node::{Config, Source, StepRule};

/// A configuration under which everything comes in with the recording, whatever the
/// recorded board read or counted itself.
#[must_use]
pub fn replayed_config(config: Config) -> Config {
    let step_rule = match config.step_rule {
        StepRule::PerTick { .. } => StepRule::PerTick { own_clock: false },
        rule @ StepRule::PerDistance { .. } => rule,
    };
    Config {
        step_rule,
        source: Source::Link,
        ..config
    }
}
