//! Three calculi over sonar cones, with and without the box, as mapping methods.

use super::{Method, SensorChoice};
use crate::mapping::{
    Bayes, BoxMapper, ConeEvidenceMapper, DempsterShafer, Fuzzy, Mapper, SonarModel,
};
use crate::rig::{Rig, SensorMount};
use crate::sensors::SensorKind::{Cone, Infrared};

const BAYES: &str = "Ivanjko, Petrovic and Macek 2003, equation 18";
const DS: &str = "Ivanjko, Petrovic and Macek 2003, equations 23 and 24";
const FUZZY: &str = "Ivanjko, Petrovic and Macek 2003, equations 27 and 28";
const BAYES_BOX: &str = "Ivanjko, Petrovic and Macek 2003, equation 18, bounding box";
const DS_BOX: &str = "Ivanjko, Petrovic and Macek 2003, equations 23 and 24, bounding box";
const FUZZY_BOX: &str = "Ivanjko, Petrovic and Macek 2003, equations 27 and 28, bounding box";

const CONES: SensorChoice = SensorChoice::FirstOf(&[Cone, Infrared]);

impl Method {
    /// Bayes' rule over a sonar model.
    pub const BAYES: Self = Self::new("bayes", BAYES, CONES, |s| {
        let evidence = SonarModel::occupancy;
        Box::new(ConeEvidenceMapper::new(s.lattice, s.rig, Bayes, evidence))
    });
    /// Dempster-Shafer masses over the same model.
    pub const DS: Self = Self::new("ds", DS, CONES, |s| {
        let (calculus, evidence) = (DempsterShafer, SonarModel::masses);
        Box::new(ConeEvidenceMapper::new(
            s.lattice, s.rig, calculus, evidence,
        ))
    });
    /// Fuzzy sets over the same model.
    pub const FUZZY: Self = Self::new("fuzzy", FUZZY, CONES, |s| {
        let evidence = SonarModel::memberships;
        Box::new(ConeEvidenceMapper::new(s.lattice, s.rig, Fuzzy, evidence))
    });
    /// Bayes' rule with readings shortened by a box about the robot.
    pub const BAYES_BOX: Self = Self::new("bayes-box", BAYES_BOX, CONES, |s| {
        boxed((Self::BAYES.build)(s), s.rig)
    });
    /// Dempster-Shafer masses with the box.
    pub const DS_BOX: Self = Self::new("ds-box", DS_BOX, CONES, |s| {
        boxed((Self::DS.build)(s), s.rig)
    });
    /// Fuzzy sets with the box.
    pub const FUZZY_BOX: Self = Self::new("fuzzy-box", FUZZY_BOX, CONES, |s| {
        boxed((Self::FUZZY.build)(s), s.rig)
    });
}

/// A mapper behind the box of the cones that are mapped.
fn boxed(mapper: Box<dyn Mapper>, rig: &Rig) -> Box<dyn Mapper> {
    let mounts = CONES
        .mounts(rig, &rig.mounts_named(&[]))
        .unwrap_or_default();
    let kinds: Vec<_> = (rig.mounts.iter().zip(mounts))
        .filter_map(|(mount, is_mapped)| is_mapped.then_some(mount.sensor.kind()))
        .collect();
    let is_mapped = |mount: &SensorMount| kinds.contains(&mount.sensor.kind());
    Box::new(BoxMapper::new(mapper, rig, is_mapped))
}
