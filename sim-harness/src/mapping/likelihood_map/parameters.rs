//! Parameters of the forward sensor model and of the search.

/// What the search raises.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Objective {
    /// The likelihood of the readings: the causes of a reading are summed.
    Soft,
    /// The likelihood of each reading's best cause.
    Hard,
}

/// How far behind the measured range the cells of a reading go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reach {
    /// A cell, as the arc of an echo; the paper's cone ends at the echo.
    Cell,
    /// So many standard deviations of a range. More: an obstacle behind the reading may
    /// explain it, too.
    Sigmas(f64),
}

/// What a return without an echo counts as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MaximumReading {
    /// No evidence, as in the paper.
    Dropped,
    /// A reading of z_max: the more of its cone is occupied, the less likely it is.
    Evidence,
}

/// Parameters of the map of greatest likelihood.
///
/// The numbers are ours: the paper prints the model without them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LikelihoodParameters {
    /// Probability of a reading without a cause in the map (p_rand), above 0: it keeps the
    /// logarithm finite. More: fewer readings are worth an obstacle.
    pub p_random: f64,
    /// Probability of a maximum reading whatever is there (p_max).
    pub p_maximum: f64,
    /// Standard deviation of a range, cells (sigma). More: an obstacle explains readings
    /// farther away from it, and walls become thicker.
    pub sigma_cells: f64,
    /// Probability that an obstacle is hit that covers nothing of the cone, and all of it
    /// (h_min, h_max). A larger h_min needs more evidence for small obstacles.
    pub hit: [f64; 2],
    /// Distance from a cluster's mean at which the next cell begins a new cluster, cells.
    /// More: fewer and thicker obstacles.
    pub gap_cells: f64,
    /// What is raised.
    pub objective: Objective,
    /// How far the cells of a reading go.
    pub reach: Reach,
    /// What a return without an echo counts as.
    pub maximum: MaximumReading,
    /// Most sweeps over all readings. A drive needs some six.
    pub sweeps: u32,
}

impl LikelihoodParameters {
    /// The choice of docs/methods.md: sigma of a cell, gap of half a cell.
    pub const STANDARD: Self = Self {
        p_random: 0.05,
        p_maximum: 0.05,
        sigma_cells: 1.0,
        hit: [0.02, 0.90],
        gap_cells: 0.5,
        objective: Objective::Soft,
        reach: Reach::Cell,
        maximum: MaximumReading::Dropped,
        sweeps: 6,
    };

    /// The same with another objective.
    #[must_use]
    pub const fn with(self, objective: Objective) -> Self {
        Self { objective, ..self }
    }
}
