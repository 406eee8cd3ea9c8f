//! The sensors of one robot, as measured: what a configuration takes of them.

use amiro_ipf::model::{Gain, SENSORS};
use amiro_ipf::node::Config;

/// Alpha and the gains of the sensors of a ring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RingCalibration {
    /// Gain of the sensors together, counts m^2 (alpha).
    pub alpha_counts_m2: f32,
    /// Gain of each sensor relative to alpha.
    pub gains: [Gain; SENSORS],
}

impl RingCalibration {
    /// Sets alpha and gains of a configuration.
    pub fn apply(&self, config: &mut Config) {
        config.photometry.alpha_counts_m2 = self.alpha_counts_m2;
        config.gains = self.gains;
    }
}
