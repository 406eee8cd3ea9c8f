//! The table of methods that map a drive's records.

use super::{RangeInverseSensorMapper, RangeInverseSensorParameters};

/// Range at which an echo has no weight any more in `ism-decay`, metres.
const DECAY_M: f64 = 5.0;

/// One way to make a map of scans.
#[derive(Clone, Copy, Debug)]
pub struct RangeMethod {
    /// Its name on the command line.
    pub name: &'static str,
    /// Where it comes from.
    pub source: &'static str,
    decay_m: Option<f64>,
}

/// All of them.
pub const RANGE_METHODS: [RangeMethod; 2] = [
    RangeMethod {
        name: "ism",
        source: "Thrun, Burgard and Fox 2005, table 4.2",
        decay_m: None,
    },
    RangeMethod {
        name: "ism-decay",
        source: "Carvalho and Ventura 2013, section II",
        decay_m: Some(DECAY_M),
    },
];

impl RangeMethod {
    /// The method of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        RANGE_METHODS.into_iter().find(|method| method.name == name)
    }

    /// The method with cells of the given size, metres.
    #[must_use]
    pub fn mapper(&self, cell_m: f64, no_echo_is_free: bool) -> RangeInverseSensorMapper {
        let parameters = RangeInverseSensorParameters {
            no_echo_is_free,
            decay_m: self.decay_m,
            ..RangeInverseSensorParameters::standard(cell_m)
        };
        RangeInverseSensorMapper::new(cell_m, parameters)
    }
}
