//! What `simulate` prints about a whole robot's sensors and buses.

use std::fmt::Display;
use std::mem;

use amiro_ipf::board::health::{BusState, Health};
use amiro_ipf::model::SENSORS;

/// Reports the sensors that the acquisition did not trust and the buses that did not work,
/// with the times of the changes.
pub(super) fn print_untrusted(healths: &[(u64, Health)], report: fn(&dyn Display)) {
    let mut known = [None; SENSORS];
    let mut known_buses = [BusState::Working; 2];
    for (at_us, health) in healths {
        for (number, (known, now)) in (1..).zip(known_buses.iter_mut().zip(&health.buses)) {
            if mem::replace(known, now.state) != now.state {
                report(&format_args!(
                    "{:6.2} s: bus{number} {:?}",
                    *at_us as f64 * 1e-6,
                    now.state
                ));
            }
        }
        for (sensor, (known, now)) in known.iter_mut().zip(&health.sensors).enumerate() {
            let is_news = *known != Some(now.state)
                && (known.is_some_and(|before| !before.is_trusted()) || !now.state.is_trusted());
            if is_news {
                report(&format_args!(
                    "{:6.2} s: s{sensor} {:?}",
                    *at_us as f64 * 1e-6,
                    now.state
                ));
            }
            *known = Some(now.state);
        }
    }
}
