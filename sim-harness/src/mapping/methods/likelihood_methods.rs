//! The filter of contradicting echoes, and maps by likelihood, as mapping methods.

use super::{Method, SensorChoice, Setup};
use crate::mapping::{
    ApproximateLikelihoodMapper, ConsistentEchoMapper, EchoFilter, InverseSensorMapper,
    InverseSensorParameters, LikelihoodMapper, LikelihoodParameters, Mapper, MaximumReading,
    NoEcho, Objective,
};
use crate::sensors::SensorKind::{Cone, Infrared};

const CESP: &str = "Carvalho and Ventura 2013, sections II and III: inverse model behind CEsp";
const FSM: &str = "Carvalho and Ventura 2013, section III: forward sensor model";
const FSM_CESP: &str = "Carvalho and Ventura 2013, section III: forward model behind CEsp";
const MAL: &str = "Carvalho and Ventura 2013, section III: MAL";
const CEMAL: &str = "Carvalho and Ventura 2013, section III: CEsp and MAL";

/// Infrared sensors are read as their cone.
const CONES: SensorChoice = SensorChoice::FirstOf(&[Cone, Infrared]);

const RANGE: InverseSensorParameters = InverseSensorParameters::RANGE;

impl Method {
    /// [`ISM`](Self::ISM) behind the filter of contradicting echoes.
    pub const ISM_CESP: Self = Self::new("ism-cesp", CESP, CONES, |s| filtered(s, RANGE));
    /// [`ISM_DECAY`](Self::ISM_DECAY) behind the same filter.
    pub const ISM_DECAY_CESP: Self = Self::new("ism-decay-cesp", CESP, CONES, |s| {
        let decay_m = Some(5.0);
        filtered(s, InverseSensorParameters { decay_m, ..RANGE })
    });
    /// The map under which the readings are most likely.
    pub const FSM: Self = Self::new("fsm", FSM, CONES, |s| {
        likelihood(s, EchoFilter::None, Objective::Soft)
    });
    /// The same, each reading by its best cause.
    pub const FSM_HARD: Self = Self::new("fsm-hard", FSM, CONES, |s| {
        likelihood(s, EchoFilter::None, Objective::Hard)
    });
    /// [`FSM`](Self::FSM) behind the filter of contradicting echoes.
    pub const FSM_CESP: Self = Self::new("fsm-cesp", FSM_CESP, CONES, |s| {
        likelihood(s, EchoFilter::Consistent, Objective::Soft)
    });
    /// Free before occupied, without a filter.
    pub const MAL: Self = Self::new("mal", MAL, CONES, |s| approximate(s, EchoFilter::None));
    /// Free before occupied, behind the filter of contradicting echoes.
    pub const CEMAL: Self = Self::new("cemal", CEMAL, CONES, |s| {
        approximate(s, EchoFilter::Consistent)
    });
}

/// Whether returns without an echo are evidence; the paper drops them.
fn takes_no_echo(setup: &Setup<'_>) -> bool {
    setup.no_echo == Some(NoEcho::Free)
}

fn filtered(setup: &Setup<'_>, parameters: InverseSensorParameters) -> Box<dyn Mapper> {
    let no_echo = setup.no_echo.unwrap_or(parameters.no_echo);
    let parameters = parameters.with(no_echo);
    let tolerance_m = parameters.tolerance_cells * setup.lattice.cell_m();
    Box::new(ConsistentEchoMapper::new(
        InverseSensorMapper::new(setup.lattice, setup.rig, parameters),
        setup.lattice,
        setup.rig,
        tolerance_m,
    ))
}

fn approximate(setup: &Setup<'_>, filter: EchoFilter) -> Box<dyn Mapper> {
    Box::new(ApproximateLikelihoodMapper::new(
        setup.lattice,
        setup.rig,
        filter,
        setup.lattice.cell_m(),
        takes_no_echo(setup),
    ))
}

fn likelihood(setup: &Setup<'_>, filter: EchoFilter, objective: Objective) -> Box<dyn Mapper> {
    let maximum = if takes_no_echo(setup) {
        MaximumReading::Evidence
    } else {
        MaximumReading::Dropped
    };
    let parameters = LikelihoodParameters {
        maximum,
        ..LikelihoodParameters::STANDARD.with(objective)
    };
    Box::new(LikelihoodMapper::new(
        setup.lattice,
        setup.rig,
        filter,
        parameters,
    ))
}
