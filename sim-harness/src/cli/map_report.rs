//! What `map` prints.

use sim_harness::console;
use sim_harness::evaluation::cell_truth::{DriveTruth, TrueCell, TrueCells};
use sim_harness::evaluation::drive_maps::RecordedDrive;
use sim_harness::mapping::MAX_CELLS;
use sim_harness::pipeline::DriveSummary;
use sim_harness::report::DriveMapSummary;

/// Warns of rows that were refused, of mounts without data, and of what else was found.
pub(super) fn left_out(drive: &DriveSummary) {
    drive.notes.iter().for_each(console::warn);
    let (used, refused) = (drive.used_rows, &drive.refused);
    if refused.count > 0 {
        console::warn_text(refused);
        console::warn(format_args!(
            "{used} of {} rows used",
            used.saturating_add(refused.count)
        ));
    }
    if refused.count > used {
        console::warn("MOST OF THE RECORDING IS MISSING in the map: see the refused rows");
    }
    if !drive.mounts_without_data.is_empty() {
        console::warn(format_args!(
            "the recording has no data for {}",
            drive.mounts_without_data.join(", ")
        ));
    }
}

/// Prints where a truth is from and its size, and warns of one that hardly fits.
pub(super) fn truth(drive: &RecordedDrive, truth: &DriveTruth) {
    let occupied = truth.cells.number_of(TrueCell::Occupied);
    if let Some(world) = &drive.world {
        console::print(format_args!(
            "truth from {world}: {occupied} occupied and {} free cells of {:.0} mm",
            truth.cells.number_of(TrueCell::Free),
            1e3 * truth.cells.cell_m()
        ));
    }
    if occupied == 0 {
        console::warn("no true wall is near the robot: do the poses have another origin?");
    }
    let [places, inside] = truth.places;
    if inside < places {
        console::warn(format_args!(
            "{} of {places} poses lie in or behind a true wall",
            places - inside
        ));
    }
}

/// Prints the figures of a mapped drive.
pub(super) fn figures(summary: &DriveMapSummary<'_>) {
    let figures = summary.figures;
    console::print(format_args!(
        "{} of {} poses over {:.1} m; {} returns with an echo, {} without, {} invalid",
        figures.keyframes,
        figures.poses,
        figures.path_m,
        figures.echoes,
        figures.no_echoes,
        figures.invalid
    ));
    console::print(format_args!(
        "{} occupied and {} free cells of {:.0} mm",
        summary.cells_occupied,
        summary.cells_free,
        1e3 * summary.cell_m
    ));
}

/// Warns of a map that is cut.
pub(super) fn cut(summary: &DriveMapSummary<'_>) {
    if summary.cells_refused > 0 {
        console::print(format_args!(
            "{}: THE MAP IS CUT: it holds at most {MAX_CELLS} cells, {} updates of cells were \
             refused",
            summary.method, summary.cells_refused
        ));
    }
}

/// Warns of a truth that is cut.
pub(super) fn cut_truth(truth: &TrueCells) {
    if truth.refused() > 0 {
        console::print(format_args!(
            "THE TRUTH IS CUT: it holds at most {MAX_CELLS} cells; cells beyond are not scored"
        ));
    }
}
