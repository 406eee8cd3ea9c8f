//! The metrics that drives are compared by.

use serde::Deserialize;

use super::DriveScores;

/// One number of a drive's scores.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Metric {
    /// Overall error of the final map at its best expansion.
    Oe,
    /// Overall error of the final map without wall expansion.
    OePlain,
    /// Overall error, mean over eight snapshots.
    OePathMean,
    /// True positive rate.
    Tpr,
    /// False positive rate.
    Fpr,
    /// Informedness.
    J,
    /// Share of the visible surface that is found.
    SurfaceRecall,
    /// Share of the visible free space that is classified.
    Coverage,
    /// Mean distance of the occupied cells behind the visible surface, metres.
    SurfaceBias,
    /// RMS of that distance, metres.
    SurfaceRms,
    /// Classified cells.
    Cells,
    /// Cells that are not classified.
    Unknown,
    /// Falsely occupied cells in all openings together.
    OpeningFalse,
    /// Falsely occupied cells in the opening that has the fewest.
    OpeningFalseLeast,
    /// Frontier cells in the opening that has the fewest.
    OpeningFrontier,
    /// Frontier cells in the opening that has the most.
    OpeningFrontierMost,
    /// Hull's distance from the object at its detection, metres.
    DetectedAt,
}

impl Metric {
    /// The name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Oe => "OE",
            Self::OePlain => "plain OE",
            Self::OePathMean => "path-mean OE",
            Self::Tpr => "TPR",
            Self::Fpr => "FPR",
            Self::J => "J",
            Self::SurfaceRecall => "surface recall",
            Self::Coverage => "coverage",
            Self::SurfaceBias => "surface bias",
            Self::SurfaceRms => "surface RMS",
            Self::Cells => "classified cells",
            Self::Unknown => "unknown cells",
            Self::OpeningFalse => "false cells in openings",
            Self::OpeningFalseLeast => "false cells in each opening",
            Self::OpeningFrontier => "frontier cells in each opening",
            Self::OpeningFrontierMost => "frontier cells in any opening",
            Self::DetectedAt => "detection distance",
        }
    }

    /// The value; `None` where it is undefined.
    #[must_use]
    pub fn of(self, scores: &DriveScores) -> Option<f64> {
        let last = &scores.last;
        match self {
            Self::Oe => last.oe,
            Self::OePlain => last.oe_unexpanded,
            Self::OePathMean => scores.oe_path_mean,
            Self::Tpr => last.tpr,
            Self::Fpr => last.fpr,
            Self::J => last.j,
            Self::SurfaceRecall => last.surface_recall,
            Self::Coverage => last.coverage,
            Self::SurfaceBias => scores.offset.bias_m,
            Self::SurfaceRms => scores.offset.rms_m,
            Self::Cells => Some(last.cells as f64),
            Self::Unknown => Some(last.unknown as f64),
            Self::OpeningFalse => scores.opening_false_occupied().map(|cells| cells as f64),
            Self::OpeningFalseLeast => scores.least_false_occupied().map(|cells| cells as f64),
            Self::OpeningFrontier => scores.opening_frontier().map(|cells| cells as f64),
            Self::OpeningFrontierMost => scores.most_frontier().map(|cells| cells as f64),
            Self::DetectedAt => scores.detected_at_m,
        }
    }
}
