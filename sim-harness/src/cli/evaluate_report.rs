//! What `evaluate` prints around its tables: the world, verdicts, results not reproduced.

use sim_harness::console;
use sim_harness::evaluation::{
    ClaimVerdict, MethodComparison, Metric, Number, OdometryLoss, SCORES_IN_WORDS, Trial, Trials,
};
use sim_harness::mapping::Method;

/// The simulated world, where it differs from the filter's model.
pub(super) fn world(comparison: &MethodComparison) {
    let options = &comparison.options;
    console::print(format_args!(
        "Simulated; physics {}, odometry {}.",
        options.physics, options.odometry
    ));
    if let Some(alpha) = comparison.alpha_counts_m2 {
        console::print(format_args!(
            "Filters and ISM believe in alpha = {alpha:.3} counts m^2."
        ));
    }
    if comparison.footprint {
        console::print("The robot's footprint is free in every map; not so in the paper.");
    }
    console::print("");
    console::print_text(SCORES_IN_WORDS);
    console::print(
        "PathOE: mean of OE over eight snapshots. False, frontier: occupied cells in the \
         openings, frontier cells in the worse one (smallest seed).",
    );
    console::print("");
}

/// Verdicts under a heading with the number of failures.
pub(super) fn verdicts(heading: &str, verdicts: &[ClaimVerdict]) {
    let failed = verdicts.iter().filter(|verdict| !verdict.holds()).count();
    console::print(format_args!(
        "{heading}: {} judged, {failed} failed",
        verdicts.len()
    ));
    for verdict in verdicts {
        console::print_text(verdict);
    }
    console::print("");
}

/// Claims of the paper that the results do not show.
pub(super) fn not_reproduced(trials: &[Trial]) {
    console::print("Not reproduced: a range that is almost doubled (section 5.2).");
    for scenario in ["ssso", "msso"] {
        let distances = [Method::PAPER, Method::PLUS, Method::ISM_STANDARD].map(|method| {
            let trials = Trials::of(trials, scenario, method)?;
            let millimetres = trials
                .mean(Metric::DetectedAt)
                .map(|metres| 1000.0 * metres);
            let number = Number {
                value: millimetres,
                decimals: 0,
            };
            Some(format!("{method} {number} mm"))
        });
        let distances: Vec<_> = distances.into_iter().flatten().collect();
        if !distances.is_empty() {
            console::print(format_args!(
                "  {scenario}: hull's distance when two cells of the object are there: {}",
                distances.join(", ")
            ));
        }
    }
    for scenario in ["ssso", "msso", "msod"] {
        let oe = |method| Trials::of(trials, scenario, method)?.mean(Metric::Oe);
        let both = oe(Method::PAPER).zip(oe(Method::ISM_TUNED));
        if let Some((filter, tuned)) = both.filter(|(filter, tuned)| filter >= tuned) {
            console::print(format_args!(
                "Not reproduced against the tuned ISM: lower OE in {scenario}, {:.1} and {:.1} %.",
                100.0 * filter,
                100.0 * tuned
            ));
        }
    }
    console::print(
        "Not judged: real blocks and sensors; worlds and methods share their laws of the sensor.",
    );
    console::print("");
}

/// What the AMiRo's odometry costs each filter, with the bound.
pub(super) fn odometry(losses: &[OdometryLoss]) {
    console::print("");
    console::print(
        "Odometry of the AMiRo, OE % of exact poses / as on its bus / the same without \
         prediction to the readings' time; plain OE % of the same three",
    );
    for loss in losses {
        let percent = |share: f64| 100.0 * share;
        let [exact_plain, amiro_plain, undated_plain] = loss.plain.map(|share| Number {
            value: share.map(percent),
            decimals: 2,
        });
        console::print(format_args!(
            "{}  {:6} {:6} {:5.2} / {:5.2} / {:5.2}, loss {:5.2} <= {:.2} points; \
             plain {exact_plain:5} / {amiro_plain:5} / {undated_plain:5}",
            if loss.holds() { "PASS" } else { "FAIL" },
            loss.scenario,
            loss.method,
            percent(loss.exact),
            percent(loss.amiro),
            percent(loss.undated.unwrap_or(f64::NAN)),
            percent(loss.loss()),
            percent(loss.loss_at_most)
        ));
    }
}
