//! The method of `map`: one of ranges, for which the rig has the sensors.

use std::str::FromStr;

use sim_harness::mapping::Method;
use sim_harness::rig::Rig;

/// The method of this name, if the ranges of this robot are enough for it.
pub(super) fn named(name: &str, rig: &Rig) -> Result<Method, String> {
    let is_of_ranges = |method: &Method| method.profile.is_none() && *method != Method::ALL_FREE;
    let method = Method::from_str(name).ok().filter(is_of_ranges);
    let method = method.ok_or_else(|| {
        let known = Method::ALL.into_iter().filter(is_of_ranges);
        let known: Vec<_> = known.map(|method| method.name).collect();
        format!("--method {name}: {} are known", known.join(", "))
    })?;
    if method.fits_signals && !rig.mounts.iter().any(|mount| mount.sensor.is_infrared()) {
        return Err(format!(
            "--method {method} fits the signals of infrared sensors: rig {} has none",
            rig.name
        ));
    }
    if method.takes_beams && rig.mounts.iter().all(|mount| mount.sensor.is_infrared()) {
        return Err(format!(
            "--method {method} needs scanners or cones: rig {} has only infrared sensors",
            rig.name
        ));
    }
    Ok(method)
}
