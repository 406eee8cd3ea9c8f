//! The numbers of the batch map of walls.

/// Parameters of [`WallMapper`](super::WallMapper).
///
/// Costs are in units of chi^2: the cost of a fit is the sum over the readings of r^2, for
/// |r| above `huber` of 2 huber |r| - huber^2, and of one prior per wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallMapParameters {
    /// Counts that are added to a signal before its logarithm (s_0). More: weak returns
    /// weigh less.
    pub floor_counts: f64,
    /// Standard deviation of the law relative to the return (rel): gains of sensors, near
    /// field, surfaces. More: strong returns weigh less.
    pub relative_sigma: f64,
    /// Residual from which on its cost grows linearly, standard deviations.
    pub huber: f64,
    /// Distance from a wall to a sensor beyond which its return is ignored, metres. At
    /// 0.45 m an endless wall returns 5 counts.
    pub reach_m: f64,
    /// Expected length of a wall, and its standard deviation, metres. The only prior; it
    /// holds what no reading determines.
    pub length_m: f64,
    /// See [`length_m`](Self::length_m).
    pub length_sigma_m: f64,
    /// Least distance of a wall from every place of the robot's centre, metres: a little
    /// less than the radius of its hull.
    pub clearance_m: f64,
    /// Standard deviation of the logarithm of a sensor's gain relative to the law's; 0 for
    /// gains that are the law's. More: gains follow the readings more freely, at the cost
    /// of distances.
    pub gain_sigma: f64,
    /// Decrease of the cost that a wall must bring. More: fewer walls.
    pub least_gain: f64,
    /// Largest increase of the cost for which two walls become one.
    pub merge_cost: f64,
    /// Largest distance between the ends of two walls that become one, metres.
    pub merge_gap_m: f64,
    /// Largest distance of an end from the line of the wall that two become, metres.
    pub merge_bend_m: f64,
    /// Longest wall that two become, or to which one grows, metres; a longer wall is mapped
    /// as several. Less: less work on long drives, more seams.
    pub longest_m: f64,
    /// Distance between the places at which walls are looked for, metres.
    pub lattice_m: f64,
    /// Number of directions, over half a turn, in which walls are looked for.
    pub directions: u8,
    /// Lengths of the walls that are looked for, metres.
    pub lengths_m: [f64; 3],
    /// Candidates that are fitted at once, the best of which becomes a wall.
    pub candidates: usize,
    /// Length of a piece of a wall that is drawn or not, metres.
    pub piece_m: f64,
    /// Length whose return is tested when a piece is drawn, and width of the surface that
    /// is tested in a free cell, metres.
    pub tested_m: f64,
    /// Least change of the readings by removing so much wall for which a piece is drawn,
    /// chi^2. More: less of weakly seen walls.
    pub occupied_chi2: f64,
    /// Least change of the readings by so much surface added for which a cell is free,
    /// chi^2. More: less free space.
    pub free_chi2: f64,
    /// Half width of the band about a wall in which no cell is free, metres.
    pub band_m: f64,
}

impl WallMapParameters {
    /// What ships: the same for simulated and for recorded drives.
    pub const STANDARD: Self = Self {
        floor_counts: 15.0,
        relative_sigma: 0.05,
        huber: 3.0,
        reach_m: 0.45,
        length_m: 0.2,
        length_sigma_m: 0.3,
        clearance_m: 0.046,
        gain_sigma: 0.0,
        least_gain: 30.0,
        merge_cost: 21.0,
        merge_gap_m: 0.05,
        merge_bend_m: 0.025,
        longest_m: 2.0,
        lattice_m: 0.03,
        directions: 8,
        lengths_m: [0.05, 0.12, 0.24],
        candidates: 6,
        piece_m: 0.0025,
        tested_m: 0.02,
        occupied_chi2: 30.0,
        free_chi2: 25.0,
        band_m: 0.009,
    };
}
