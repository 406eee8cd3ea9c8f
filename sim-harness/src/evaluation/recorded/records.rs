//! The figures of recorded series as files have them.

use serde::Serialize;

use super::{RecordedReport, SeriesWalls};
use crate::evaluation::json_lines;

/// A series' map by one method: one flat object, `null` for what is undefined.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct WallsRecord<'r> {
    series: &'r str,
    method: &'static str,
    bias_mm: Option<f64>,
    rms_mm: Option<f64>,
    recall_15: f64,
    recall_20: f64,
    false_cells: usize,
    end_error_mm: Option<f64>,
}

impl<'r> From<&'r SeriesWalls> for WallsRecord<'r> {
    fn from(walls: &'r SeriesWalls) -> Self {
        let millimetres = |metres: Option<f64>| metres.map(|metres| 1000.0 * metres);
        Self {
            series: &walls.series,
            method: walls.method,
            bias_mm: millimetres(walls.mean_m),
            rms_mm: millimetres(walls.rms_m),
            recall_15: walls.recall_15,
            recall_20: walls.recall_20,
            false_cells: walls.false_cells,
            end_error_mm: millimetres(walls.end_error_m()),
        }
    }
}

impl RecordedReport {
    /// The maps of the recorded readings as a JSON array, one series and method per line.
    ///
    /// # Errors
    /// As `serde_json` has it for any value; a record gives it no reason.
    pub fn json(&self) -> Result<String, serde_json::Error> {
        let recorded = self.walls.iter().filter(|walls| walls.is_recorded());
        json_lines(recorded.map(WallsRecord::from))
    }
}
