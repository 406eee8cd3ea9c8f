//! The tables of `evaluate`: the scores of every method.

use sim_harness::console;
use sim_harness::evaluation::{MethodComparison, Metric, Number, Trial, Trials};
use sim_harness::mapping::Method;

/// One table per scenario, one line per method.
pub(super) fn scores(comparison: &MethodComparison, trials: &[Trial]) {
    for scenario in &comparison.scenarios {
        console::print(format_args!("{}: {}", scenario.name, scenario.about));
        console::print(format_args!(
            "{:20} {:>12} {:>8} {:>11} {:>5} {:>5} {:>5} {:>6} {:>5} {:>7} {:>7} {:>6} {:>6} {:>8}",
            "means over the seeds",
            "OE % +- std",
            "plain %",
            "worst seed",
            "TPR",
            "FPR",
            "J",
            "recall",
            "cover",
            "cells",
            "unknown",
            "pathOE",
            "false",
            "frontier"
        ));
        for method in &comparison.methods {
            if let Some(trials) = Trials::of(trials, &scenario.name, *method) {
                console::print_text(line(*method, &trials));
            }
        }
        for trial in trials
            .iter()
            .filter(|trial| trial.scenario == scenario.name)
        {
            if trial.scores.last.cells_refused > 0 {
                console::print(format_args!(
                    "THE MAP IS CUT: {}, seed {}: {} updates of cells were refused",
                    trial.method, trial.seed, trial.scores.last.cells_refused
                ));
            }
        }
        console::print("");
    }
}

/// One table of all scenarios, one line per method, if there are several.
pub(super) fn together(comparison: &MethodComparison, trials: &[Trial]) {
    let scenarios = comparison.scenarios.len();
    if scenarios < 2 {
        return;
    }
    console::print(format_args!(
        "All {scenarios} scenarios together. Bias, RMS: distance of the occupied cells behind \
         the nearest visible surface within 80 mm"
    ));
    console::print(format_args!(
        "{:20} {:>6} {:>5} {:>6} {:>7} {:>6} {:>5}",
        "means over drives", "OE %", "TPR", "recall", "bias mm", "RMS mm", "cover"
    ));
    for method in &comparison.methods {
        let Some(trials) = Trials::of_method(trials, *method) else {
            continue;
        };
        let number = |metric, scale: f64, decimals| Number {
            value: trials.mean_of_defined(metric).0.map(|value| scale * value),
            decimals,
        };
        console::print(format_args!(
            "{method:20} {:6} {:5} {:6} {:7} {:6} {:5}",
            number(Metric::Oe, 100.0, 1),
            number(Metric::Tpr, 1.0, 2),
            number(Metric::SurfaceRecall, 1.0, 2),
            number(Metric::SurfaceBias, 1e3, 1),
            number(Metric::SurfaceRms, 1e3, 1),
            number(Metric::Coverage, 1.0, 2),
        ));
    }
    console::print("");
}

fn line(method: Method, trials: &Trials) -> String {
    let mean = |metric| trials.mean(metric);
    let percent = |value: Option<f64>| Number {
        value: value.map(|share| 100.0 * share),
        decimals: 1,
    };
    let number = |value, decimals| Number { value, decimals };
    let oe = trials.mean_std(Metric::Oe);
    let worst = trials.largest(Metric::Oe);
    let worst = worst.map_or("n/a".to_owned(), |(oe, seed)| {
        format!("{} ({seed})", percent(Some(oe)))
    });
    let smallest = trials.smallest(Metric::OpeningFrontier);
    let smallest = smallest.map_or(String::new(), |(cells, _)| format!(" ({cells:.0})"));
    format!(
        "{method:20} {:5} +- {:3} {:8} {worst:>11} {:5} {:5} {:5} {:6} {:5} {:7} {:7} {:6} {:6} {:4}{smallest}",
        percent(oe.mean),
        percent(oe.std),
        percent(mean(Metric::OePlain)),
        number(mean(Metric::Tpr), 2),
        number(mean(Metric::Fpr), 2),
        number(mean(Metric::J), 2),
        number(mean(Metric::SurfaceRecall), 2),
        number(mean(Metric::Coverage), 2),
        number(mean(Metric::Cells), 0),
        number(mean(Metric::Unknown), 0),
        percent(mean(Metric::OePathMean)),
        number(mean(Metric::OpeningFalse), 1),
        number(mean(Metric::OpeningFrontier), 1),
    )
}
