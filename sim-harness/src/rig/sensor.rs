//! What a sensor can measure.

use amiro_ipf::model::Photometry;

/// How a sensor measures a range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sensor {
    /// Reflective infrared: counts, ambiguous over the lobe.
    Infrared(Infrared),
    /// Sonar, or the minimum of a wide time-of-flight sensor.
    Cone(Cone),
    /// A fan of narrow beams: a laser scanner, the columns of a time-of-flight array.
    Scanner(Scanner),
}

impl Sensor {
    /// Returns of one scan.
    #[must_use]
    pub const fn returns(&self) -> usize {
        match self {
            Self::Infrared(_) | Self::Cone(_) => 1,
            Self::Scanner(scanner) => scanner.beams as usize,
        }
    }
}

/// A reflective infrared sensor by its photometric law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Infrared {
    /// The law's parameters.
    pub photometry: Photometry,
}

/// A sensor that returns the nearest surface in a cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Half of the opening angle, radians, in (0, pi/2) (H).
    pub half_angle_rad: f64,
    /// Nearest and farthest range that it measures, metres.
    pub range_m: [f64; 2],
    /// Standard deviation of a range, metres.
    pub sigma_m: f64,
}

/// A sensor that returns one range per beam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scanner {
    /// Beams of one scan.
    pub beams: u16,
    /// Bearing of the first beam off the axis, radians.
    pub first_rad: f64,
    /// From one beam to the next, radians; negative for a scan from left to right.
    pub step_rad: f64,
    /// Nearest and farthest range that it measures, metres.
    pub range_m: [f64; 2],
    /// Standard deviation of a range, metres.
    pub sigma_m: f64,
}
