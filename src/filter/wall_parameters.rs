//! The choices of the profiles `wall` and `arcs`.

use serde::{Deserialize, Serialize};

use super::SegmentParameters;

/// Parameters of the filter that takes readings as upper bounds: over tracked wall
/// segments (the profile `wall`), or without them (`arcs`).
///
/// A sensor is *claimed* if the segments explain its reading; a segment is *seen* if it
/// makes enough of a claimed reading and has enough evidence.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WallParameters {
    /// Parameters of the tracker. Without one a surface is on the arc of a reading, as in
    /// `plus`, and what concerns claims and segments means nothing.
    pub segments: Option<SegmentParameters>,
    /// Largest deviation of a claimed reading from the law, standard deviations.
    pub claim_sigmas: f32,
    /// Relative standard deviation of a reading in that test.
    pub claim_relative_sigma: f32,
    /// Share of a claimed reading that a segment must make to be seen by it.
    pub least_share: f32,
    /// Evidence, that of the window included, from which on a segment is seen (chi^2).
    /// More: walls appear later and fewer false ones do.
    pub least_evidence: f32,
    /// Standard deviation of a segment's place across it, metres. More: thicker walls.
    pub error_m: f32,
    /// The same, as a share of the distance from the robot's centre.
    pub relative_error: f32,
    /// How far beyond an end a particle is still supported, metres.
    pub end_margin_m: f32,
    /// How far beyond an end a particle is neither supported nor refuted, metres.
    pub undecided_m: f32,
    /// Share of the strongest element's return that supports a particle fully (q_min).
    /// More: only the middle of what a sensor sees is supported.
    pub least_quality: f32,
    /// Share of the range on the arc within which a sensor with a surface sees past a
    /// place (kappa). The counts of a wall that does not fill the lobe mean too large a
    /// range: a reading is an upper bound of it. More: more free space, and walls that
    /// are seen edge-on are erased.
    pub surface_kappa: f32,
    /// The same for a sensor with nothing in range.
    pub nothing_kappa: f32,
    /// Largest bearing at which a sensor sees past a place, radians. More: more free space, and
    /// walls of weak signal are erased by readings that are too low: with 10 counts less
    /// 6.9 % of the cells of the T maze are wrong at 40 degrees and 5.8 % at 34.
    pub side_bearing_rad: f32,
    /// Share of the particles drawn for a claimed sensor that search its whole lobe
    /// (explorers); for a sensor that no segment explains all do. Less: near space stays
    /// unknown beside walls.
    pub explorers: f32,
    /// Travel that is worth one step of the gate, metres: the gate is one of travel.
    pub travel_per_epoch_m: f32,
}

impl WallParameters {
    /// The profile `wall`.
    pub const WALL: Self = Self {
        segments: Some(SegmentParameters::STEPS),
        claim_sigmas: 3.0,
        claim_relative_sigma: 0.1,
        least_share: 0.3,
        least_evidence: 100.0,
        error_m: 0.003,
        relative_error: 0.02,
        end_margin_m: 0.003,
        undecided_m: 0.015,
        least_quality: 0.25,
        surface_kappa: 0.7,
        nothing_kappa: 0.85,
        side_bearing_rad: 34.0 * core::f32::consts::PI / 180.0,
        explorers: 0.4,
        travel_per_epoch_m: 0.010,
    };

    /// The profile `arcs`: the four constants of upper bounds alone, kappa, the bearing,
    /// the explorers and the gate of travel.
    pub const ARCS: Self = Self {
        segments: None,
        surface_kappa: 0.75,
        side_bearing_rad: 40.0 * core::f32::consts::PI / 180.0,
        ..Self::WALL
    };
}

impl Default for WallParameters {
    fn default() -> Self {
        Self::WALL
    }
}
