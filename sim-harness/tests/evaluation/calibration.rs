//! The fit of the photometric law through the public door: known laws are found again.

use std::fmt::Write as _;

use amiro_ipf::filter::Profile;
use amiro_ipf::geometry::Pose;
use amiro_ipf::model::{Photometry, SENSORS, Sample};
use amiro_ipf::node::{Config, Event, Input};
use amiro_ipf::random::{Generator, standard_normal_pair};
use sim_harness::calibration::{
    Fit, Fixed, LawComparison, LawKind, LawVerdict, Origin, Parameter, Table, fit, fit_law,
};
use sim_harness::run;
use sim_harness::sensors::WallLaw;

use crate::common;

const RANGES_MM: [u32; 9] = [30, 40, 50, 60, 80, 100, 120, 150, 200];

/// A table of a law with its own noise, three readings a place.
fn table_of(law: &Photometry, angles_deg: &[f32], seed: u64) -> Table {
    let mut noise = Generator::seeded(seed);
    let mut text = "# simulated\nrange_mm,angle_deg,counts\n".to_owned();
    for range_mm in RANGES_MM {
        for angle_deg in angles_deg {
            for _ in 0..3 {
                let exact = law.counts(range_mm as f32 / 1000.0, angle_deg.to_radians());
                let normal = standard_normal_pair(&mut noise).0;
                let counts = exact.unwrap() + law.sigma_counts * normal;
                writeln!(text, "{range_mm},{angle_deg},{counts}").unwrap();
            }
        }
    }
    Table::parse(&text).unwrap()
}

fn fitted(text: &str, fixed: &[&str]) -> Result<Fit, String> {
    let table = Table::parse(text).map_err(|error| error.to_string())?;
    let fixed = Fixed::parse(fixed.iter().copied()).map_err(|error| error.to_string())?;
    fit(&table, &fixed).map_err(|error| error.to_string())
}

#[test]
fn known_laws_are_found_again_within_four_standard_errors() {
    let laws = [
        Photometry::VCNL4020,
        Photometry {
            alpha_counts_m2: 1.9,
            beta_counts: 2300.0,
            delta_m2: -3e-4,
            xi: 1.12,
            sigma_counts: 12.0,
            ..Photometry::VCNL4020
        },
        Photometry {
            alpha_counts_m2: 0.3,
            beta_counts: -40.0,
            delta_m2: 2e-4,
            xi: 1.4,
            sigma_counts: 2.0,
            ..Photometry::VCNL4020
        },
    ];
    for (index, law) in laws.iter().enumerate() {
        for seed in 1..=3 {
            let table = table_of(law, &[-60.0, -30.0, 0.0, 30.0, 60.0], seed);
            let fit = fit(&table, &Fixed::default()).unwrap();
            for estimate in fit.estimates() {
                let error = estimate.value - estimate.parameter.of(law);
                let standard_error = estimate.standard_error.unwrap();
                assert!(
                    error.abs() < 4.0 * standard_error,
                    "law {index}, seed {seed}: {fit}"
                );
            }
        }
    }
}

/// Without noise, and far from the values that a fit holds parameters at.
#[test]
fn laws_far_from_the_default_are_found_exactly() {
    for alpha in [0.05_f64, 1.0, 20.0] {
        for beta in [-3000.0_f64, 0.0, 2400.0] {
            for xi in [0.6_f64, 1.0, 1.42] {
                for delta in [-1e-3_f64, 0.0, 4e-4] {
                    let mut text = "range_mm,angle_deg,counts\n".to_owned();
                    for range_mm in RANGES_MM {
                        for angle_deg in [-60.0_f64, -20.0, 0.0, 40.0] {
                            let c = (xi * angle_deg.to_radians()).cos();
                            let square = (f64::from(range_mm) / 1000.0).powi(2);
                            let counts = beta + alpha * c / (square - delta * c);
                            if counts < 65_535.0 {
                                writeln!(text, "{range_mm},{angle_deg},{counts}").unwrap();
                            }
                        }
                    }
                    let fit = fitted(&text, &[]).unwrap();
                    let law = format!("{alpha} {beta} {xi} {delta}: {fit}");
                    // A millionth of each parameter's own size.
                    for (parameter, truth, size) in [
                        (Parameter::Alpha, alpha, alpha),
                        (Parameter::Beta, beta, 1000.0),
                        (Parameter::Xi, xi, 1.0),
                        (Parameter::Delta, delta, 1e-3),
                    ] {
                        let error = (fit.value(parameter) - truth).abs();
                        assert!(error < 1e-6 * size, "{parameter}: {law}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_black_wall_is_fitted_and_the_filter_takes_it() {
    let law = Photometry {
        alpha_counts_m2: 0.0099,
        sigma_counts: 2.0,
        ..Photometry::VCNL4020
    };
    let mut noise = Generator::seeded(1);
    let mut text = "range_mm,angle_deg,counts\n".to_owned();
    for range_mm in [5, 7, 10, 15, 20, 25, 30, 40, 60] {
        for _ in 0..5 {
            let exact = law.counts(range_mm as f32 / 1000.0, 0.0).unwrap();
            let counts = exact + law.sigma_counts * standard_normal_pair(&mut noise).0;
            writeln!(text, "{range_mm},0,{counts}").unwrap();
        }
    }
    let fit = fitted(&text, &["delta=0"]).unwrap();
    let alpha = fit.value(Parameter::Alpha);
    assert!((alpha / 0.0099 - 1.0).abs() < 0.05, "{fit}");
    // Both profiles find a wall that is 30 mm away from the two sensors on the left, each
    // of which looks 22.5 degrees beside it.
    for profile in [Profile::Paper, Profile::Plus] {
        let config = Config {
            photometry: fit.photometry(),
            ..Config::amiro(profile)
        };
        config.validate().unwrap();
        let seen = law.counts(0.03, 22.5_f32.to_radians()).unwrap();
        let mut samples = [Sample::Counts(law.beta_counts as i32 - 1); SENSORS];
        samples[1] = Sample::Counts(seen as i32);
        samples[2] = Sample::Counts(seen as i32);
        let inputs: Vec<Input> = (0..40)
            .flat_map(|row| {
                let stamp_us = row * 125_000;
                let pose = Pose::new(row as f32 * 0.01, 0.0, 0.0);
                [
                    Input::Odometry { stamp_us, pose },
                    Input::Proximity { stamp_us, samples },
                ]
            })
            .collect();
        let mut surfaces = 0;
        let outcome = run(&config, &inputs, |event| {
            if let Event::StepDone(step) = event {
                surfaces += u64::from(step.past_gate);
            }
        })
        .unwrap();
        assert!(outcome.steps > 20, "{profile:?}: {outcome:?}");
        assert!(
            surfaces > 500,
            "{profile:?}: {surfaces} particles past the gate"
        );
    }
}

#[test]
fn angles_of_zero_keep_the_beam_pattern_at_its_default() {
    let table = table_of(&Photometry::VCNL4020, &[0.0], 1);
    let fit = fit(&table, &Fixed::default()).unwrap();
    let xi = fit.estimate(Parameter::Xi).unwrap();
    assert!(matches!(&xi.origin, Origin::Held(why) if why == "the angles do not tell it"));
    assert!((xi.value - Parameter::Xi.of(&Photometry::VCNL4020)).abs() < 1e-12);
    assert!(fit.to_string().contains("held"), "{fit}");
    let alpha = fit.estimate(Parameter::Alpha).unwrap();
    assert_eq!(alpha.origin, Origin::Fitted);
}

#[test]
fn fixed_parameters_stay_and_shrink_the_errors_of_the_others() {
    let table = table_of(&Photometry::VCNL4020, &[0.0, 45.0], 2);
    let free = fit(&table, &Fixed::default()).unwrap();
    let fixed = Fixed::parse(["delta=0", "sigma=4.57"]).unwrap();
    let held = fit(&table, &fixed).unwrap();
    assert!(held.value(Parameter::Delta).abs() < 1e-15);
    assert!((held.value(Parameter::Sigma) - 4.57).abs() < 1e-12);
    let error = |fit: &Fit| fit.estimate(Parameter::Alpha).unwrap().standard_error;
    assert!(error(&held).unwrap() < error(&free).unwrap());
}

#[test]
fn a_weight_of_two_is_a_row_written_twice() {
    let rows = "0.05,0,361\n0.08,30,100\n0.1,0,80\n0.15,20,22\n0.2,0,9\n";
    let last = "0.2,0,9";
    let twice = format!("range_m,angle_deg,counts\n{rows}{last}\n");
    let weighed = rows.replace('\n', ",1\n").replace("0,9,1", "0,9,2");
    let weighed = format!("range_m,angle_deg,counts,weight\n{weighed}");
    let fixed = ["delta=0", "sigma=5"];
    let (twice, weighed) = (
        fitted(&twice, &fixed).unwrap(),
        fitted(&weighed, &fixed).unwrap(),
    );
    for (one, other) in twice.estimates().iter().zip(weighed.estimates()) {
        // The search ends within 1e-8 of the least squares, relatively.
        let bound = 1e-5 * (1.0 + one.value.abs());
        assert!((one.value - other.value).abs() < bound, "{twice}{weighed}");
    }
}

#[test]
fn hostile_tables_give_clear_errors() {
    let head = "range_m,angle_deg,counts\n";
    for (rows, said) in [
        ("", "no measurements"),
        ("0.1,0,NaN", "line 2: counts is 'NaN'"),
        ("0.1,0,78", "1 measurements, 3 are needed"),
        ("0.1,0,78\n0.2,0,7", "2 measurements, 3 are needed"),
        (
            "0.1,0,78\n0.1,10,77\n0.1,20,70\n0.1,30,60",
            "all ranges are 0.1 m: alpha and beta cannot be told apart",
        ),
        // Counts that rise with the range.
        (
            "0.1,0,10\n0.15,0,60\n0.2,0,100\n0.25,0,140",
            "alpha comes out as",
        ),
    ] {
        let error = fitted(&format!("{head}{rows}\n"), &["delta=0"]).unwrap_err();
        assert!(error.starts_with(said), "{rows:?}: {error}");
    }
    // With beta known a single range tells the gain.
    let rows = format!("{head}0.1,0,78\n0.1,0,80\n0.1,0,76\n");
    let fit = fitted(&rows, &["beta=-16.25", "delta=0", "xi=1.2"]).unwrap();
    assert!((fit.value(Parameter::Alpha) - 0.9425).abs() < 1e-6, "{fit}");
}

#[test]
fn extreme_tables_never_panic() {
    let numbers = ["1e-9", "0.05", "2"];
    let counts = ["-65535", "0", "65535"];
    for near in numbers {
        for far in numbers {
            for a in counts {
                for b in counts {
                    let text = format!(
                        "range_m,angle_deg,counts\n{near},0,{a}\n{far},60,{b}\n\
                         {far},-89,{a}\n{near},90,{b}\n0.1,10,5\n"
                    );
                    // An answer or an error: either is said in words.
                    let said = match fitted(&text, &[]) {
                        Ok(fit) => fit.to_string() + &fit.residuals() + &fit.rust() + &fit.csv(),
                        Err(error) => error,
                    };
                    assert!(!said.is_empty(), "{text}");
                }
            }
        }
    }
}

/// Two white blocks, their counts read off a published plot with the sensor's own offset.
#[test]
fn published_curves_of_a_white_block_give_the_known_gain() {
    let Some(folder) = common::recordings() else {
        return common::skip("no recordings");
    };
    let file = folder.join("amiro/vcnl4020_calibration_curves_digitised.csv");
    let text = std::fs::read_to_string(file).unwrap();
    for (set, gains) in [("white1", 1.55..1.75), ("white2", 1.35..1.45)] {
        let mut table = "angle_deg,range_m,counts\n".to_owned();
        for line in text.lines().filter(|line| line.starts_with(set)) {
            let fields: Vec<_> = line.split(',').collect();
            table += &format!("{},{},{}\n", fields[1], fields[2], fields[3]);
        }
        for fixed in [&["delta=0"][..], &[]] {
            let fit = fitted(&table, fixed).unwrap();
            let (alpha, xi) = (fit.value(Parameter::Alpha), fit.value(Parameter::Xi));
            assert!(gains.contains(&alpha), "{set}: {fit}");
            assert!((1.10..1.15).contains(&xi), "{set}: {fit}");
        }
    }
}

/// A table of an endless wall with the noise of a sample, three readings a place.
fn table_of_a_wall(law: &Photometry, angles_deg: &[f64], seed: u64) -> Table {
    let wall = WallLaw::new(law);
    let mut noise = Generator::seeded(seed);
    let mut text = "range_mm,angle_deg,counts\n".to_owned();
    for range_mm in RANGES_MM {
        for angle_deg in angles_deg {
            for _ in 0..3 {
                let exact =
                    wall.endless_wall_counts(f64::from(range_mm) / 1000.0, angle_deg.to_radians());
                let normal = standard_normal_pair(&mut noise).0;
                let counts =
                    f64::from(law.beta_counts) + exact + f64::from(law.sigma_counts * normal);
                writeln!(text, "{range_mm},{angle_deg},{counts}").unwrap();
            }
        }
    }
    Table::parse(&text).unwrap()
}

#[test]
fn the_law_that_made_a_table_explains_it_better() {
    let law = Photometry {
        alpha_counts_m2: 1.85,
        ..Photometry::VCNL4020
    };
    for seed in 1..=3 {
        for sigma in [None, Some(4.57)] {
            let fixed = sigma.map_or(Fixed::default(), |sigma| {
                Fixed::default().with(Parameter::Sigma, sigma).unwrap()
            });
            let wall = table_of_a_wall(&law, &[-60.0, -30.0, 0.0, 30.0, 60.0], seed);
            let both = LawComparison::of(&wall, &fixed).unwrap();
            assert_eq!(
                both.verdict(),
                LawVerdict::Better(LawKind::Wall),
                "seed {seed}: {both}"
            );
            assert_eq!(both.better().unwrap().law, LawKind::Wall);
            let point = table_of(&law, &[-60.0, -30.0, 0.0, 30.0, 60.0], seed);
            let both = LawComparison::of(&point, &fixed).unwrap();
            assert_eq!(
                both.verdict(),
                LawVerdict::Better(LawKind::Point),
                "seed {seed}: {both}"
            );
            let said = both.to_string();
            assert!(
                said.contains("the point law explains the table better"),
                "{said}"
            );
        }
    }
}

#[test]
fn a_wall_law_is_found_again_within_four_standard_errors() {
    for (xi, seed) in [(1.0, 1), (1.2365, 2), (1.4, 3)] {
        let law = Photometry {
            alpha_counts_m2: 1.85,
            xi,
            ..Photometry::VCNL4020
        };
        let table = table_of_a_wall(&law, &[-80.0, -45.0, 0.0, 20.0, 60.0], seed);
        let fit = fit_law(LawKind::Wall, &table, &Fixed::default()).unwrap();
        for estimate in fit.estimates() {
            let error = estimate.value - estimate.parameter.of(&law);
            let bound = 4.0 * estimate.standard_error.unwrap();
            assert!(error.abs() < bound, "xi {xi}: {fit}");
        }
    }
}

#[test]
fn perpendicular_readings_do_not_decide_between_the_laws() {
    for seed in 1..=3 {
        let table = table_of_a_wall(&Photometry::VCNL4020, &[0.0], seed);
        let both = LawComparison::of(&table, &Fixed::default()).unwrap();
        assert_eq!(both.verdict(), LawVerdict::Undecided, "{both}");
        assert!(both.aic_difference().unwrap().abs() < 1e-6, "{both}");
        let [point, wall] = [both.point.clone().unwrap(), both.wall.clone().unwrap()]
            .map(|fit| fit.value(Parameter::Alpha));
        assert!(
            (point / wall - 1.0).abs() < 1e-6,
            "on the axis the laws are one"
        );
        let said = both.to_string();
        assert!(said.contains("the table does not decide"), "{said}");
    }
}

#[test]
fn readings_without_noise_decide_by_the_rounding_of_counts() {
    let exact = Photometry {
        sigma_counts: 0.0,
        ..Photometry::VCNL4020
    };
    // One bearing off the axis would be explained by xi under either law.
    let angles = [-70.0, 0.0, 40.0];
    let both = LawComparison::of(&table_of_a_wall(&exact, &angles, 1), &Fixed::default());
    assert_eq!(both.unwrap().verdict(), LawVerdict::Better(LawKind::Wall));
}
