//! Inverse sensor models as mapping methods, and the map without a method.

use super::{Method, SensorChoice, Setup};
use crate::mapping::{AllFreeMapper, InverseSensorMapper, InverseSensorParameters, Mapper, NoEcho};
use crate::sensors::SensorKind::{Cone, Infrared, Scanner};

const LOBES: &str = "Thrun, Burgard and Fox 2005, table 4.2, over the lobes of proximity sensors";
const RANGES: &str = "Thrun, Burgard and Fox 2005, table 4.2";
const DECAY: &str = "Carvalho and Ventura 2013, section II";

const PROXIMITY: SensorChoice = SensorChoice::FirstOf(&[Infrared, Cone, Scanner]);
const RANGE_SENSORS: SensorChoice = SensorChoice::FirstOf(&[Cone, Scanner, Infrared]);

const STANDARD: InverseSensorParameters = InverseSensorParameters::STANDARD;
const TUNED: InverseSensorParameters = InverseSensorParameters::TUNED;
const RANGE: InverseSensorParameters = InverseSensorParameters::RANGE;

impl Method {
    /// Inverse sensor model, usual parameters, nothing in range counted as free.
    pub const ISM_STANDARD: Self =
        Self::new("ism-standard", LOBES, PROXIMITY, |s| ism(s, STANDARD));
    /// The same with tuned parameters.
    pub const ISM_TUNED: Self = Self::new("ism-tuned", LOBES, PROXIMITY, |s| ism(s, TUNED));
    /// [`ISM_TUNED`](Self::ISM_TUNED) of infrared sensors, under its name among the methods of
    /// recorded drives.
    pub const ISM_PROXIMITY: Self = Self {
        sensors: SensorChoice::Each(&[Infrared]),
        ..Self::named("ism-proximity", Self::ISM_TUNED)
    };
    /// Usual parameters, nothing in range dropped.
    pub const ISM_STANDARD_DROPPED: Self =
        Self::new("ism-standard-dropped", LOBES, PROXIMITY, |s| {
            ism(s, STANDARD.with(NoEcho::Dropped))
        });
    /// Usual parameters, nothing in range taken as an object.
    pub const ISM_STANDARD_OBJECT: Self = Self::new("ism-standard-object", LOBES, PROXIMITY, |s| {
        ism(s, STANDARD.with(NoEcho::Object))
    });
    /// Tuned parameters, nothing in range dropped.
    pub const ISM_TUNED_DROPPED: Self = Self::new("ism-tuned-dropped", LOBES, PROXIMITY, |s| {
        ism(s, TUNED.with(NoEcho::Dropped))
    });
    /// Tuned parameters, nothing in range taken as an object.
    pub const ISM_TUNED_OBJECT: Self = Self::new("ism-tuned-object", LOBES, PROXIMITY, |s| {
        ism(s, TUNED.with(NoEcho::Object))
    });
    /// Inverse sensor model of range sensors.
    pub const ISM: Self = Self::new("ism", RANGES, RANGE_SENSORS, |s| ism(s, RANGE));
    /// The same; an echo's weight decays to nothing over 5 m.
    pub const ISM_DECAY: Self = Self::new("ism-decay", DECAY, RANGE_SENSORS, |s| {
        let decay_m = Some(5.0);
        ism(s, InverseSensorParameters { decay_m, ..RANGE })
    });
    /// No method: every cell of a rectangle is free, for any measurement.
    pub const ALL_FREE: Self = Self::new(
        "all-free",
        "the row to compare scores with",
        SensorChoice::Nothing,
        |s| Box::new(AllFreeMapper::new(s.lattice, s.extent.as_ref())),
    );
}

fn ism(setup: &Setup<'_>, parameters: InverseSensorParameters) -> Box<dyn Mapper> {
    let no_echo = setup.no_echo.unwrap_or(parameters.no_echo);
    let parameters = parameters.with(no_echo);
    Box::new(InverseSensorMapper::new(
        setup.lattice,
        setup.rig,
        parameters,
    ))
}
