//! Layers of evidence per kind of sensor, alone and fused, as mapping methods.

use super::{Method, SensorChoice, Setup};
use crate::mapping::{Fusion, LayerMapper, LayerParameters, Mapper};
use crate::sensors::SensorKind::{self, Cone, Scanner};

const LASER: &str = "Lee, layer of the laser";
const SONAR: &str = "Lee, layer of the sonars";
const PESSIMISTIC: &str = "Lee, pessimistic fusion of the layers, unknown layers counted";
const MINMAX: &str = "Lee, MinMax fusion of the layers";

impl Method {
    /// The layer of the scanners.
    pub const LASER: Self = Self::layer("laser", LASER, SensorChoice::Each(&[Scanner]), |s| {
        layers(s, &[Scanner], Fusion::MinMax)
    });
    /// The layer of the cones.
    pub const SONAR: Self = Self::layer("sonar", SONAR, SensorChoice::Each(&[Cone]), |s| {
        layers(s, &[Cone], Fusion::MinMax)
    });
    /// Both layers; the least probability of free counts.
    pub const PESSIMISTIC: Self = Self::layer("pessimistic", PESSIMISTIC, BOTH, |s| {
        layers(s, &[Scanner, Cone], Fusion::Pessimistic)
    });
    /// Both layers; the surest on the side of their mean counts.
    pub const MINMAX: Self = Self::layer("minmax", MINMAX, BOTH, |s| {
        layers(s, &[Scanner, Cone], Fusion::MinMax)
    });

    const fn layer(
        name: &'static str,
        source: &'static str,
        sensors: SensorChoice,
        build: fn(&Setup<'_>) -> Box<dyn Mapper>,
    ) -> Self {
        Self {
            splits_keyframes: true,
            ..Self::new(name, source, sensors, build)
        }
    }
}

const BOTH: SensorChoice = SensorChoice::Each(&[Cone, Scanner]);

fn layers(setup: &Setup<'_>, kinds: &[SensorKind], fusion: Fusion) -> Box<dyn Mapper> {
    let lee = LayerParameters::LEE;
    let parameters = LayerParameters {
        scanner_no_echo: setup.no_echo.unwrap_or(lee.scanner_no_echo),
        cone_no_echo: setup.no_echo.unwrap_or(lee.cone_no_echo),
        ..lee
    };
    Box::new(LayerMapper::new(
        setup.lattice,
        setup.rig,
        kinds,
        fusion,
        parameters,
    ))
}
