//! Methods in worlds that differ from their model.

use core::ops::Range;

use serde::Serialize;

use super::{ComparisonError, MeanStd, MethodComparison, Metric, Trials};
use crate::mapping::Method;
use crate::world::{Drift, OdometryModel, Options, Physics, Scenario, WheelErrors};

/// A difference of a world from the model of the methods.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mismatch {
    /// Its name in tables and files.
    pub name: &'static str,
    /// The world.
    pub options: Options,
}

impl Mismatch {
    /// The differences that are tried under a physics, the world without one first.
    ///
    /// Slips are five per metre, of either wheel.
    #[must_use]
    pub fn all(physics: Physics) -> [Self; 11] {
        let none = Options {
            physics,
            ..Options::default()
        };
        let reflectivity = |reflectivity_factor| Options {
            reflectivity_factor,
            ..none
        };
        let drift = |counts| Options {
            drift: Drift::constant(counts),
            ..none
        };
        let lobe = |xi| Options {
            xi: Some(xi),
            ..none
        };
        let wheels = |errors| Options {
            odometry: OdometryModel::WheelErrors(errors),
            ..none
        };
        [
            ("none", none),
            ("reflectivity x0.8", reflectivity(0.8)),
            ("reflectivity x1.25", reflectivity(1.25)),
            ("offset +10 counts", drift(10.0)),
            ("offset -10 counts", drift(-10.0)),
            (
                "noise x2",
                Options {
                    noise_factor: 2.0,
                    ..none
                },
            ),
            (
                "gain spread 12 %",
                Options {
                    gain_spread: 0.12,
                    ..none
                },
            ),
            ("lobe xi 1.0", lobe(1.0)),
            ("lobe xi 1.45", lobe(1.45)),
            (
                "heading drift 2 deg/m",
                wheels(WheelErrors {
                    drift_deg_per_m: 2.0,
                    ..WheelErrors::NONE
                }),
            ),
            (
                "slips 1 %",
                wheels(WheelErrors {
                    slip_percent: 1.0,
                    ..WheelErrors::NONE
                }),
            ),
        ]
        .map(|(name, options)| Self { name, options })
    }
}

/// Methods on the same drives in each of the differing worlds.
#[derive(Clone, Debug)]
pub struct RobustnessTrials {
    /// The worlds and drives.
    pub scenarios: Vec<Scenario>,
    /// The methods.
    pub methods: Vec<Method>,
    /// Seeds of noise and filters; the end is excluded.
    pub seeds: Range<u64>,
    /// Particles for each sensor in use.
    pub particles_per_sensor: u16,
    /// The differences.
    pub mismatches: Vec<Mismatch>,
}

/// One method in one scenario of one differing world: means over the seeds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RobustnessRow {
    /// The difference.
    pub mismatch: &'static str,
    /// The scenario's name.
    pub scenario: String,
    /// The method's name.
    pub method: &'static str,
    /// Number of seeds.
    pub seeds: usize,
    /// Overall error at the best wall expansion.
    pub oe: Option<f64>,
    /// Standard deviation of that over the seeds.
    pub oe_std: Option<f64>,
    /// Share of the visible surface that is found.
    pub surface_recall: Option<f64>,
    /// Share of the visible free space that is classified.
    pub coverage: Option<f64>,
    /// Mean distance of the occupied cells behind the visible surface, metres, over the drives
    /// that have such cells.
    pub surface_bias_m: Option<f64>,
}

impl RobustnessTrials {
    /// Drives and maps everything: by difference, then scenario, then method. `progress` is
    /// called with the number of differences that are done, and of all.
    ///
    /// # Errors
    /// As [`MethodComparison::run`].
    pub fn run(
        &self,
        progress: &mut dyn FnMut(usize, usize),
    ) -> Result<Vec<RobustnessRow>, ComparisonError> {
        let mut rows = Vec::new();
        for (done, mismatch) in self.mismatches.iter().enumerate() {
            progress(done, self.mismatches.len());
            let comparison = MethodComparison {
                scenarios: self.scenarios.clone(),
                methods: self.methods.clone(),
                seeds: self.seeds.clone(),
                particles_per_sensor: self.particles_per_sensor,
                options: mismatch.options,
                alpha_counts_m2: None,
                footprint: false,
                calibration: None,
                threads: 0,
            };
            let trials = comparison.run()?;
            for scenario in &self.scenarios {
                let of_method = |method: &Method| {
                    let trials = Trials::of(&trials, &scenario.name, *method)?;
                    Some(row(mismatch.name, &scenario.name, *method, &trials))
                };
                rows.extend(self.methods.iter().filter_map(of_method));
            }
        }
        Ok(rows)
    }
}

fn row(mismatch: &'static str, scenario: &str, method: Method, trials: &Trials) -> RobustnessRow {
    let oe: MeanStd = trials.mean_std(Metric::Oe);
    RobustnessRow {
        mismatch,
        scenario: scenario.to_owned(),
        method: method.name,
        seeds: oe.count,
        oe: oe.mean,
        oe_std: oe.std,
        surface_recall: trials.mean(Metric::SurfaceRecall),
        coverage: trials.mean(Metric::Coverage),
        surface_bias_m: trials.mean_of_defined(Metric::SurfaceBias).0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::standard;

    #[test]
    fn differences_have_names_of_their_own_and_legal_numbers() {
        let all = Mismatch::all(Physics::Patch);
        for (place, mismatch) in all.iter().enumerate() {
            assert_eq!(mismatch.options.validate(), Ok(()), "{}", mismatch.name);
            assert_eq!(mismatch.options.physics, Physics::Patch);
            for other in &all[..place] {
                assert_ne!(mismatch.name, other.name);
                assert_ne!(mismatch.options, other.options, "{}", mismatch.name);
            }
        }
    }

    #[test]
    fn each_method_has_a_row_in_each_world() {
        let trials = RobustnessTrials {
            scenarios: vec![standard("msod").unwrap().unwrap()],
            methods: vec![Method::ISM_TUNED, Method::ALL_FREE],
            seeds: 100..102,
            particles_per_sensor: 50,
            mismatches: Mismatch::all(Physics::Patch)[..3].to_vec(),
        };
        let mut reports = Vec::new();
        let rows = trials
            .run(&mut |done, of| reports.push((done, of)))
            .unwrap();
        assert_eq!(reports, [(0, 3), (1, 3), (2, 3)]);
        assert_eq!(rows.len(), 3 * 2);
        let of = |method: &str| -> Vec<_> {
            let rows = rows.iter().filter(|row| row.method == method);
            rows.map(|row| (row.mismatch, row.seeds, row.oe)).collect()
        };
        // The map of no method is the same in every world, that of another one is not.
        let free = of("all-free");
        assert!(
            free.iter()
                .all(|(_, seeds, oe)| *seeds == 2 && *oe == free[0].2)
        );
        let tuned = of("ism-tuned");
        assert_ne!(tuned[0].2, tuned[1].2, "{tuned:?}");
    }
}
