//! What `evaluate` says of a simulated robot: its stamps, its broken sensors.

use sim_harness::console;
use sim_harness::evaluation::{MeanStd, Number, SCORES_IN_WORDS};
use sim_harness::robot::{SensorFaultTrials, StampTrials};

use super::{Ending, Outcome};

/// A broken sensor's cost, and whether it is within its bounds.
pub(super) fn sensor_faults(trials: &SensorFaultTrials) -> Outcome {
    console::print(format_args!(
        "A robot of which one sensor breaks after {:.0} % of the drive, another one for each \
         seed; {} drives",
        100.0 * trials.breaks_at,
        trials.scenarios.len() as u64 * (trials.seeds.end - trials.seeds.start) * 4
    ));
    console::print_text(format_args!("\n{SCORES_IN_WORDS}\n"));
    let rows = trials.run()?;
    for row in &rows {
        console::print_text(row);
    }
    let failed = rows.iter().filter(|row| !row.holds()).count();
    console::print(format_args!(
        "{failed} of {} rows cost a drive more than they may",
        rows.len()
    ));
    Ok(if failed == 0 {
        Ending::Good
    } else {
        Ending::Failed
    })
}

/// What the senses' stamps of the odometry cost.
pub(super) fn stamps(trials: &StampTrials) -> Outcome {
    console::print(
        "A robot's OE % with exact poses / frames with the time of their pose / as its senses \
         stamp them / 25 ms before they came;",
    );
    console::print(
        "plain OE % of the same four; and how far the last three put a step from the truth, RMS, mm",
    );
    console::print_text(format_args!("\n{SCORES_IN_WORDS}\n"));
    for row in trials.run()? {
        let figure = |value: Option<f64>, scale: f64, decimals| Number {
            value: value.map(|value| scale * value),
            decimals,
        };
        let percent = |spread: MeanStd| figure(spread.mean, 100.0, 2);
        let [exact, dated, stamped, aged] = row.plain.map(percent);
        let [true_mm, own_mm, age_mm] = row.off_m.map(|off_m| figure(off_m.mean, 1e3, 1));
        console::print(format_args!(
            "{:6} {:6} {:5} / {:5} / {:5} / {:5}   \
             {exact:5} / {dated:5} / {stamped:5} / {aged:5}   {true_mm:4} / {own_mm:4} / {age_mm:4}",
            row.scenario,
            format!("{:?}", row.profile).to_lowercase(),
            percent(row.exact),
            percent(row.true_stamps),
            percent(row.own_stamps),
            percent(row.mean_age),
        ));
    }
    Ok(Ending::Good)
}
