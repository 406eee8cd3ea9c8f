//! The sound pressure of a cone, by distance and bearing.

use crate::sensors::{Cone, Directivity};

/// Half of an echo's amplitude: 2 J1(x) / x = 0.5 at this x.
const HALF_AMPLITUDE: f64 = 2.215_089;

/// Distance below which the pressure rises no further, metres.
const NEAR_M: f64 = 0.05;

/// Terms of the series of 2 J1(x) / x; the next one is below 1e-13 for x <= 4.
const TERMS: u32 = 14;

/// The sound pressure of an echo relative to that on the axis at 1 m (Carvalho and Ventura
/// 2013, section III):
///
/// ```text
/// SP(r, theta) = D(theta) / max(r, 0.05 m)
/// D = (2 J1(x) / x)^2,  x = ka sin|theta|       a round piston that sends and receives
/// D = 1                                         flat
/// ```
///
/// ka follows from the cone, ka = 2.215089 / sin H: each way the amplitude at the cone's
/// edge is half of that on the axis. The ka of a data sheet may put the null of the piston
/// into the cone, where a reading would have no pressure at all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum SoundPressure {
    /// A round piston.
    Piston {
        /// Wave number times the radius of the piston.
        ka: f64,
    },
    /// The same in the whole cone.
    Flat,
}

impl SoundPressure {
    /// That of a cone.
    pub(super) fn of(cone: &Cone) -> Self {
        match cone.directivity {
            Directivity::Piston => Self::Piston {
                ka: HALF_AMPLITUDE / libm::sin(cone.half_angle_rad),
            },
            Directivity::Flat => Self::Flat,
        }
    }

    /// Share of the pressure under a bearing (D).
    fn directivity(self, bearing_rad: f64) -> f64 {
        match self {
            Self::Flat => 1.0,
            Self::Piston { ka } => {
                let amplitude = piston_amplitude(ka * libm::sin(bearing_rad.abs()));
                amplitude * amplitude
            }
        }
    }

    /// The pressure at a distance, metres, and bearing, radians.
    pub(super) fn at(self, range_m: f64, bearing_rad: f64) -> f64 {
        self.directivity(bearing_rad) / range_m.max(NEAR_M)
    }
}

/// 2 J1(x) / x = sum over m of (-x^2 / 4)^m / (m! (m + 1)!).
fn piston_amplitude(x: f64) -> f64 {
    let factor = -0.25 * x * x;
    let (mut term, mut sum) = (1.0, 1.0);
    for m in 1..=TERMS {
        let m = f64::from(m);
        term *= factor / (m * (m + 1.0));
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ka of the SensComp 600, of 19 mm radius at 50 kHz.
    const SENSCOMP: f64 = 17.1968;

    fn of_half_angle(degrees: f64) -> SoundPressure {
        SoundPressure::of(&Cone {
            half_angle_rad: degrees.to_radians(),
            range_m: [0.1, 5.0],
            sigma_m: 0.0,
            directivity: Directivity::Piston,
        })
    }

    #[test]
    fn g5_directivity_of_a_piston_is_the_tabulated_one() {
        let degrees = [0.0, 5.0, 7.5, 10.0, 12.5];
        for (ka, expected) in [
            (SENSCOMP, [1.0, 0.553_963, 0.239_491, 0.053_141, 0.000_577]),
            (10.2343, [1.0, 0.816_836, 0.628_726, 0.427_553, 0.249_993]),
        ] {
            let pressure = SoundPressure::Piston { ka };
            for (angle, expected) in degrees.into_iter().zip(expected) {
                let found = pressure.directivity(f64::to_radians(angle));
                assert!((found - expected).abs() < 1e-6, "{ka}, {angle}: {found}");
                let mirrored = pressure.directivity(-f64::to_radians(angle));
                assert_eq!(found.to_bits(), mirrored.to_bits());
            }
        }
    }

    #[test]
    fn g5_amplitude_halves_at_the_edge_and_vanishes_at_the_null() {
        assert!((piston_amplitude(HALF_AMPLITUDE) - 0.5).abs() < 1e-6);
        assert!(piston_amplitude(3.831_706).abs() < 1e-6);
        let pressure = of_half_angle(12.5);
        assert!((pressure.directivity(12.5_f64.to_radians()) - 0.25).abs() < 1e-6);
        let SoundPressure::Piston { ka } = pressure else {
            panic!("{pressure:?}");
        };
        assert!((ka - 10.234_212).abs() < 1e-6, "{ka}");
        // The printed transducer's null lies near the edge of the cone.
        let printed = SoundPressure::Piston { ka: SENSCOMP };
        assert!(printed.directivity(12.5_f64.to_radians()) < 0.001);
    }

    #[test]
    fn g5_a_far_reading_on_the_axis_beats_a_near_one_off_it() {
        let pressure = of_half_angle(12.5);
        for (range_m, degrees, expected) in [
            (1.0, 0.0_f64, 1.0),
            (2.0, 0.0, 0.5),
            (1.5, 10.0, 0.285_040_074),
            (2.5, 2.0, 0.387_411_306),
        ] {
            let found = pressure.at(range_m, degrees.to_radians());
            assert!((found - expected).abs() < 1e-9, "{range_m}: {found}");
        }
        assert!((SoundPressure::Flat.at(2.0, 1.0) - 0.5).abs() < 1e-12);
        let at_sensor = pressure.at(0.0, 0.0);
        assert_eq!(at_sensor.to_bits(), pressure.at(0.05, 0.0).to_bits());
    }
}
