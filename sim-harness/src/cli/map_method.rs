//! The method of `map`: one of ranges, for which the rig has the sensors.

use std::str::FromStr;

use sim_harness::mapping::Method;
use sim_harness::rig::Rig;

/// The method of this name, if the ranges of this robot are enough for it.
pub(super) fn named(name: &str, rig: &Rig) -> Result<Method, String> {
    let is_of_ranges = |method: &Method| method.profile.is_none() && *method != Method::ALL_FREE;
    let method = Method::from_str(name).ok().filter(is_of_ranges);
    let method = method.ok_or_else(|| {
        let known = Method::ALL.iter().copied().filter(is_of_ranges);
        let known: Vec<_> = known.map(|method| method.name).collect();
        format!("--method {name}: {} are known", known.join(", "))
    })?;
    if let Err(missing) = method.sensors.mounts(rig) {
        return Err(format!(
            "--method {method} {missing}: rig {} has none",
            rig.name
        ));
    }
    Ok(method)
}
