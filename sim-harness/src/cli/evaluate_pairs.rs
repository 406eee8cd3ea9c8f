//! What `evaluate` prints of filters and inverse sensor models on the same readings.

use sim_harness::console;
use sim_harness::evaluation::{MeanStd, MethodComparison, Metric, Number, Trial, Trials};
use sim_harness::mapping::Method;

/// The overall error of each filter against the inverse sensor model, drive by drive.
pub(super) fn print(comparison: &MethodComparison, trials: &[Trial]) {
    console::print(
        "OE on the same readings, filter less ISM: percentage points +- standard error; plain OE \
         likewise",
    );
    for scenario in &comparison.scenarios {
        for filter in [Method::PAPER, Method::PLUS] {
            for model in [Method::ISM_STANDARD, Method::ISM_TUNED] {
                let of = |method| Trials::of(trials, &scenario.name, method);
                if let Some((its, models)) = of(filter).zip(of(model)) {
                    let differences = its.less(&models, Metric::Oe);
                    let plain = its.less(&models, Metric::OePlain);
                    let name = &scenario.name;
                    console::print(format_args!(
                        "{name:6} {filter:12} - {model:12} {}; plain {}",
                        paired_line(&differences),
                        paired_line(&plain)
                    ));
                }
            }
        }
    }
    console::print("");
}

fn paired_line(differences: &[Option<f64>]) -> String {
    let mean_std = MeanStd::of(differences);
    let points = |value: Option<f64>| Number {
        value: value.map(|share| 100.0 * share),
        decimals: 2,
    };
    let lower = differences
        .iter()
        .flatten()
        .filter(|difference| **difference < 0.0);
    format!(
        "{:7} +- {}, lower in {} of {} drives",
        points(mean_std.mean),
        points(mean_std.standard_error()),
        lower.count(),
        differences.len()
    )
}
