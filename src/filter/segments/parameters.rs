//! Every choice of the tracker as a named parameter.

use serde::{Deserialize, Serialize};

/// Parameters of the segment tracker.
///
/// Costs and gains are chi^2: squared deviations in units of their standard deviation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SegmentParameters {
    /// Steps of the window (W), 1 to 5. More: ends are surer, and odometry errors within
    /// the window count as errors of the walls.
    pub window_steps: u8,
    /// Distance from the robot at which a step leaves the window, metres: so far apart are
    /// its first and last step. Four stations of 50 mm; steps of 10 mm never reach it.
    /// More: what the odometry gets wrong between stations counts as errors of the walls.
    pub window_m: f32,
    /// Relative standard deviation of a signal (rel): gain, surface, law. More: near
    /// walls are followed less closely.
    pub relative_sigma: f32,
    /// Standard deviation of a reading, counts (sigma). Twice the sensor's own 4.57:
    /// recordings are clipped at 0 counts, which is up to 16 above beta, and simulated
    /// mazes are mapped better, too. More: weak signals, as of small blocks, count less.
    pub sigma_counts: f32,
    /// Counts added to signals before the logarithm (d0). More: weak signals count less.
    pub soft_counts: f32,
    /// Deviation beyond which a reading pulls no harder (Huber), standard deviations.
    pub huber: f32,
    /// Expected length of a segment, metres.
    pub length_m: f32,
    /// Standard deviation of the length, metres. More: segments grow far beyond what was
    /// seen of them.
    pub length_sigma_m: f32,
    /// Share of a prior that is kept per step. Less: old readings are forgotten sooner.
    pub fade: f32,
    /// Iterations of the fit per step.
    pub iterations: u8,
    /// Farthest that an end moves in an iteration, metres.
    pub most_move_m: f32,
    /// Radius about the robot's centre that is free of segments, metres: the hull less
    /// 4 mm of odometry error.
    pub hull_m: f32,
    /// Distance from the robot's centre at which segments are frozen, metres.
    pub reach_m: f32,
    /// Unexplained chi^2 of a sensor over its last steps from which on a segment is
    /// sought.
    pub unexplained: f32,
    /// Steps that it is summed over.
    pub unexplained_steps: u8,
    /// Cost that a new segment must save. More: fewer and surer segments.
    pub birth_gain: f32,
    /// Iterations of the fit with each of the best three candidates.
    pub birth_iterations: u8,
    /// Steps between two looks at drops and merges.
    pub upkeep_steps: u8,
    /// Evidence below which a segment is dropped.
    pub drop_evidence: f32,
    /// Evidence from which on a segment out of reach is frozen instead of forgotten.
    pub freeze_evidence: f32,
    /// Largest gap between two segments that are merged, metres.
    pub merge_gap_m: f32,
    /// Largest distance of the inner ends from the merged segment, metres.
    pub merge_bend_m: f32,
    /// Largest cost that a merge may add.
    pub merge_cost: f32,
    /// Length below which a segment is dropped, metres.
    pub least_length_m: f32,
}

impl SegmentParameters {
    /// For steps of 10 mm and for stations up to 50 mm apart.
    pub const STEPS: Self = Self {
        window_steps: 5,
        window_m: 0.155,
        relative_sigma: 0.08,
        sigma_counts: 10.0,
        soft_counts: 15.0,
        huber: 3.0,
        length_m: 0.2,
        length_sigma_m: 0.3,
        fade: 0.98,
        iterations: 3,
        most_move_m: 0.03,
        hull_m: 0.046,
        reach_m: 0.29,
        unexplained: 24.0,
        unexplained_steps: 3,
        birth_gain: 21.0,
        birth_iterations: 6,
        upkeep_steps: 3,
        drop_evidence: 12.0,
        freeze_evidence: 30.0,
        merge_gap_m: 0.05,
        merge_bend_m: 0.025,
        merge_cost: 21.0,
        least_length_m: 0.01,
    };
}

impl Default for SegmentParameters {
    fn default() -> Self {
        Self::STEPS
    }
}
