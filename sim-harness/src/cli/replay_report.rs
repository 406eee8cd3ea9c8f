//! What `replay` prints.

use std::error::Error;

use amiro_ipf::link::Message;
use sim_harness::device::{Imbalance, Replayed, post_mortem_in_words};
use sim_harness::evaluation::DriveScores;
use sim_harness::log::StoredRecording;
use sim_harness::mapping::MAX_CELLS;
use sim_harness::report::RunSummary;
use sim_harness::{RunOutcome, console};

/// Cycles of a core that an emulator lets run at one instruction a nanosecond.
const NANOSECONDS_PER_CYCLE: f64 = 1e9 / 168e6;

/// Prints what was broken on purpose in the recorded run, and how its board's boot before
/// had ended.
pub(super) fn recorded(recording: &mut StoredRecording) -> Result<(), Box<dyn Error>> {
    let overview = recording.overview();
    let faults = overview.truth.iter().flat_map(|truth| &truth.faults);
    for (text, seed) in faults {
        console::print(format_args!("recorded with faults: {text}, seed {seed}"));
    }
    if overview.post_mortems == 0 {
        return Ok(());
    }
    let mut messages = recording.messages(|_| ())?;
    for message in messages.by_ref() {
        if let Message::PostMortem(record) = message {
            console::print(format_args!("recorded: {}", post_mortem_in_words(&record)));
        }
    }
    messages.finish()?;
    Ok(())
}

/// Prints what a line with faults did to the frames, and the inputs that the host refused.
pub(super) fn frames(run: &Replayed) -> Result<(), Imbalance> {
    if let Some((frames, line)) = &run.line {
        console::print(format_args!("{frames}; {} damaged", line.damaged));
        frames.balance(line.sent)?;
    }
    refused_inputs(&run.outcome);
    Ok(())
}

/// Warns of the inputs that the host's node refused.
pub(super) fn refused_inputs(outcome: &RunOutcome) {
    for (fault, count) in outcome.faults() {
        console::warn(format_args!("{count} inputs refused: {fault:?}, {fault}"));
    }
}

/// Prints the longest and the mean step of an emulator that counts instructions.
pub(super) fn steps(run: &Replayed) {
    let cycles = &run.step_cycles;
    let millions = |cycles: f64| cycles * NANOSECONDS_PER_CYCLE / 1e6;
    console::print(format_args!(
        "longest step: {:.2} million instructions (emulated)",
        millions(f64::from(cycles.longest))
    ));
    if let Some(mean) = cycles.mean() {
        console::print(format_args!(
            "mean step: {:.2} million instructions (emulated), over {} of {} steps",
            millions(mean),
            cycles.counted,
            cycles.steps()
        ));
    }
}

/// Prints what was found.
pub(super) fn found(summary: &RunSummary, scores: Option<&DriveScores>, resets: usize) {
    let figures = &summary.figures;
    console::print(format_args!(
        "{} steps over {:.3} m, mean step {}, {} occupied and {} free cells",
        figures.steps,
        figures.path_m,
        figures
            .mean_step_m
            .map_or("n/a".to_owned(), |step| format!("{:.2} mm", 1e3 * step)),
        figures.cells_occupied,
        figures.cells_free
    ));
    if figures.cells_refused > 0 {
        console::print(format_args!(
            "THE MAP IS CUT: it holds at most {MAX_CELLS} cells, {} updates of cells were refused",
            figures.cells_refused
        ));
    }
    if let Some(radius_m) = figures.footprint_radius_m {
        console::print(format_args!(
            "the robot's footprint is free in the map: hull of {:.0} mm radius",
            1e3 * radius_m
        ));
    }
    if let Some(walls) = &summary.wall_segments {
        console::print(format_args!(
            "{} wall segments of {:.2} m together, orange in map.png and listed in walls.csv",
            walls.standing, walls.length_m
        ));
        if walls.refused > 0 {
            console::warn(format_args!(
                "{} more segments were not kept",
                walls.refused
            ));
        }
    }
    match resets {
        0 => {}
        times => console::print(format_args!(
            "BrokeOff {times} times: parts of the map share no origin"
        )),
    }
    if let Some(scores) = scores {
        console::print_text(scores.last);
        console::print("(the figures are explained by `cargo ipf demo` and in docs/evaluation.md)");
    }
    if let Some(walls) = &summary.walls {
        console::print_text(walls);
    }
    if let Some(comparison) = &summary.comparison {
        console::print_text(comparison);
    }
}
