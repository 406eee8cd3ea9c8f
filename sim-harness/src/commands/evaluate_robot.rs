//! What `evaluate` says of a simulated robot: its stamps, its broken sensors.

use sim_harness::evaluation::Figure;
use sim_harness::robot::{SensorFaultTrials, StampTrials};

use super::{Ending, Outcome};

/// A broken sensor's cost, and whether it is within its bounds.
pub(super) fn sensor_faults(trials: &SensorFaultTrials) -> Outcome {
    println!(
        "A robot of which one sensor breaks after {:.0} % of the drive, another one for each \
         seed; {} drives",
        100.0 * trials.breaks_at,
        trials.scenarios.len() as u64 * (trials.seeds.end - trials.seeds.start) * 4
    );
    let rows = trials.run()?;
    for row in &rows {
        println!("{row}");
    }
    let failed = rows.iter().filter(|row| !row.holds()).count();
    println!(
        "{failed} of {} rows cost a drive more than they may",
        rows.len()
    );
    Ok(if failed == 0 {
        Ending::Good
    } else {
        Ending::Failed
    })
}

/// What the senses' stamps of the odometry cost.
pub(super) fn stamps(trials: &StampTrials) -> Outcome {
    println!(
        "A robot's OE % with exact poses / frames with the time of their pose / as its senses \
         stamp them; farthest pose of a step from the truth, mm"
    );
    for row in trials.run()? {
        let percent = |share: Option<f64>| Figure {
            value: share.map(|share| 100.0 * share),
            decimals: 2,
        };
        let [true_m, own_m] = row.farthest_m;
        println!(
            "{:6} {:6} {:5} / {:5} / {:5}   {:.1} / {:.1}",
            row.scenario,
            format!("{:?}", row.profile).to_lowercase(),
            percent(row.exact.mean),
            percent(row.true_stamps.mean),
            percent(row.own_stamps.mean),
            1e3 * true_m,
            1e3 * own_m
        );
    }
    Ok(Ending::Good)
}
