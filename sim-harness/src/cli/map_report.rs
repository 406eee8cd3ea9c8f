//! What `map` prints.

use sim_harness::console;
use sim_harness::mapping::MAX_CELLS;
use sim_harness::report::DriveMapSummary;

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
    if summary.cells_refused > 0 {
        console::print(format_args!(
            "THE MAP IS CUT: it holds at most {MAX_CELLS} cells, {} updates of cells were refused",
            summary.cells_refused
        ));
    }
}
