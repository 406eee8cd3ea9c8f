//! Which sensors of a robot a method maps.

use core::fmt;

use crate::rig::Rig;
use crate::sensors::SensorKind;

/// Which sensors of a robot a method maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorChoice {
    /// None: the method needs no sensor.
    Nothing,
    /// Those of the first of these kinds that the robot has.
    FirstOf(&'static [SensorKind]),
    /// Those of all these kinds; the robot needs each.
    Each(&'static [SensorKind]),
}

/// The robot lacks the sensors that a method needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("needs {0}")]
pub struct MissingSensors(SensorChoice);

impl SensorChoice {
    /// Of each mount of a robot, whether the method maps it; of the mounts that are
    /// `allowed`, and of none beyond them.
    ///
    /// # Errors
    /// The allowed mounts have not the sensors that the method needs.
    pub fn mounts(self, rig: &Rig, allowed: &[bool]) -> Result<Vec<bool>, MissingSensors> {
        let mounts = || rig.mounts.iter().zip(allowed);
        let has = |kind| mounts().any(|(it, is_allowed)| *is_allowed && it.sensor.kind() == kind);
        let chosen: Vec<SensorKind> = match self {
            Self::Nothing => Vec::new(),
            Self::FirstOf(kinds) => {
                let first = kinds.iter().copied().find(|kind| has(*kind));
                vec![first.ok_or(MissingSensors(self))?]
            }
            Self::Each(kinds) if kinds.iter().all(|kind| has(*kind)) => kinds.to_vec(),
            Self::Each(_) => return Err(MissingSensors(self)),
        };
        Ok(mounts()
            .map(|(mount, is_allowed)| *is_allowed && chosen.contains(&mount.sensor.kind()))
            .collect())
    }
}

/// The kinds, as in `cones or scanners`.
impl fmt::Display for SensorChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (kinds, between) = match self {
            Self::Nothing => return f.write_str("no sensors"),
            Self::FirstOf(kinds) => (kinds, " or "),
            Self::Each(kinds) => (kinds, " and "),
        };
        let names: Vec<&str> = kinds.iter().map(|kind| kind.plural()).collect();
        f.write_str(&names.join(between))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use SensorKind::{Cone, Infrared, Scanner};

    fn kcma() -> Rig {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../rigs/kcma.toml");
        Rig::load(&root).unwrap()
    }

    #[test]
    fn a_choice_takes_the_first_kind_there_is_or_every_kind() {
        let rig = kcma();
        let chosen = |choice: SensorChoice| {
            let mounts = choice.mounts(&rig, &rig.mounts_named(&[]))?;
            Ok::<_, MissingSensors>(mounts.into_iter().filter(|wanted| *wanted).count())
        };
        assert_eq!(
            chosen(SensorChoice::FirstOf(&[Infrared, Cone, Scanner])),
            Ok(8)
        );
        assert_eq!(chosen(SensorChoice::FirstOf(&[Scanner, Cone])), Ok(1));
        assert_eq!(chosen(SensorChoice::Each(&[Scanner, Cone])), Ok(9));
        assert_eq!(chosen(SensorChoice::Nothing), Ok(0));
        let laser = rig.mounts_named(&["laser".to_owned()]);
        let no_cone = SensorChoice::FirstOf(&[Cone]).mounts(&rig, &laser);
        assert_eq!(no_cone.unwrap_err().to_string(), "needs cones");
        let refused = chosen(SensorChoice::Each(&[Cone, Infrared])).unwrap_err();
        assert_eq!(refused.to_string(), "needs cones and infrared sensors");
        let refused = chosen(SensorChoice::FirstOf(&[Infrared])).unwrap_err();
        assert_eq!(refused.to_string(), "needs infrared sensors");
    }
}
