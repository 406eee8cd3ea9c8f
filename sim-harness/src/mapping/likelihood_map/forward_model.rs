//! How likely a range is, given the obstacles in a cone.

use super::{LikelihoodParameters, Objective};

/// Share of readings that pass all obstacles so far below which farther ones are left out.
const PASSED: f64 = 1e-4;

/// ln(1 / sqrt(2 pi)).
const LN_OF_NORMAL: f64 = -0.918_938_533_204_672_7;

/// Standard deviation of a maximum reading over z_max.
const MAXIMUM_SIGMA: f64 = 1e-3;

/// An obstacle in a cone: a cluster of occupied cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Obstacle {
    /// Mean distance of its cells, metres (d_k).
    pub(super) distance_m: f64,
    /// Probability that it is hit if nothing before it is (h_k).
    pub(super) hit: f64,
}

/// The forward sensor model (Carvalho and Ventura 2013, section III).
///
/// A reading z has one of these causes: none (*), obstacle k, from near to far, or the
/// maximum range (0):
///
/// ```text
/// pi_* = p_rand                                                        L_* = pi_* / z_max
/// pi_k = (1 - p_rand - p_max) h_k prod over i < k (1 - h_i)            L_k = pi_k N(z; d_k, sigma^2)
/// pi_0 = p_max + (1 - p_rand - p_max) prod over all i (1 - h_i)        L_0 = pi_0 N(z; z_max, (z_max / 1000)^2)
/// ```
///
/// The paper prints pi_0 = p_max: its priors do not sum to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ForwardModel {
    p_random: f64,
    p_maximum: f64,
    sigma_m: f64,
    objective: Objective,
}

/// A reading as the model sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Measured {
    /// z, metres.
    pub(super) range_m: f64,
    /// z_max, metres.
    pub(super) limit_m: f64,
    /// Whether it is a maximum reading, at z_max.
    pub(super) is_maximum: bool,
}

/// The causes of a reading, added from near to far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Causes<'a> {
    model: &'a ForwardModel,
    measured: Measured,
    /// Probability that the reading passes all obstacles so far.
    passed: f64,
    sum: f64,
    best: f64,
}

impl ForwardModel {
    /// The model on cells of a size, metres.
    pub(super) fn new(parameters: &LikelihoodParameters, cell_m: f64) -> Self {
        Self {
            p_random: parameters.p_random,
            p_maximum: parameters.p_maximum,
            sigma_m: parameters.sigma_cells * cell_m,
            objective: parameters.objective,
        }
    }

    /// The causes of a reading in an empty cone.
    pub(super) fn causes(&self, measured: Measured) -> Causes<'_> {
        let random = self.p_random / measured.limit_m;
        Causes {
            model: self,
            measured,
            passed: 1.0,
            sum: random,
            best: random,
        }
    }

    /// N(z; d, sigma^2), 1/m; 0 far away.
    fn density(&self, range_m: f64, distance_m: f64) -> f64 {
        let deviation = (range_m - distance_m) / self.sigma_m;
        libm::exp(LN_OF_NORMAL - 0.5 * deviation * deviation) / self.sigma_m
    }

    /// Share of the readings that are neither random nor maximum by chance.
    fn regular(&self) -> f64 {
        1.0 - self.p_random - self.p_maximum
    }
}

impl Causes<'_> {
    /// Adds the next obstacle, which is not nearer than those before. Returns whether
    /// enough readings pass it for a farther one to matter.
    pub(super) fn add(&mut self, obstacle: Obstacle) -> bool {
        let prior = self.model.regular() * obstacle.hit * self.passed;
        let density = self
            .model
            .density(self.measured.range_m, obstacle.distance_m);
        self.add_term(prior * density);
        self.passed *= 1.0 - obstacle.hit;
        self.passed >= PASSED
    }

    fn add_term(&mut self, term: f64) {
        self.sum += term;
        self.best = self.best.max(term);
    }

    /// The prior of a maximum reading (pi_0).
    fn maximum(&self) -> f64 {
        self.model.p_maximum + self.model.regular() * self.passed
    }

    /// The logarithm of the likelihood; finite.
    pub(super) fn log_likelihood(mut self) -> f64 {
        if self.measured.is_maximum {
            let sigma_m = MAXIMUM_SIGMA * self.measured.limit_m;
            let density = libm::exp(LN_OF_NORMAL) / sigma_m;
            self.add_term(self.maximum() * density);
        }
        libm::log(match self.model.objective {
            Objective::Soft => self.sum,
            Objective::Hard => self.best,
        })
    }
}

/// The bearings of a cell, of those within the half angle of a cone.
pub(super) fn bearings(
    bearing_rad: f64,
    range_m: f64,
    cell_m: f64,
    half_angle_rad: f64,
) -> [f64; 2] {
    let half_rad = libm::atan(0.5 * cell_m / range_m);
    [
        (bearing_rad - half_rad).max(-half_angle_rad),
        (bearing_rad + half_rad).min(half_angle_rad),
    ]
}

/// Length of the union of intervals, radians; sorts them.
pub(super) fn union_rad(intervals: &mut [[f64; 2]]) -> f64 {
    intervals.sort_unstable_by(|[a, _], [b, _]| a.total_cmp(b));
    let (mut sum, mut end) = (0.0, f64::NEG_INFINITY);
    for [low, high] in intervals {
        if *high > end {
            sum += *high - low.max(end);
            end = *high;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    const MEASURED: Measured = Measured {
        range_m: 1.95,
        limit_m: 5.0,
        is_maximum: false,
    };
    const OBSTACLES: [Obstacle; 2] = [
        Obstacle {
            distance_m: 1.0,
            hit: 0.4,
        },
        Obstacle {
            distance_m: 2.0,
            hit: 0.9,
        },
    ];

    fn model(objective: Objective) -> ForwardModel {
        ForwardModel::new(&LikelihoodParameters::STANDARD.with(objective), 0.1)
    }

    fn near(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-9, "{found}, not {expected}");
    }

    /// L_* and the obstacles' L_k.
    fn terms(model: &ForwardModel) -> Vec<f64> {
        let mut causes = model.causes(MEASURED);
        let mut terms = vec![causes.sum];
        for obstacle in OBSTACLES {
            let before = causes;
            causes.add(obstacle);
            // A term of its own, not the difference of two sums.
            let prior = model.regular() * obstacle.hit * before.passed;
            terms.push(prior * model.density(MEASURED.range_m, obstacle.distance_m));
        }
        terms
    }

    #[test]
    fn g3_priors_sum_to_one_and_those_printed_do_not() {
        let model = model(Objective::Soft);
        let mut causes = model.causes(MEASURED);
        let mut priors = vec![model.p_random];
        for obstacle in OBSTACLES {
            priors.push(model.regular() * obstacle.hit * causes.passed);
            causes.add(obstacle);
        }
        for (prior, expected) in priors.iter().zip([0.05, 0.36, 0.486]) {
            near(*prior, expected);
        }
        let others: f64 = priors.iter().sum();
        near(causes.maximum(), 0.104);
        near(others + causes.maximum(), 1.0);
        let printed = model.p_maximum;
        near(others + printed, 0.946);
    }

    #[test]
    fn g3_likelihoods_of_one_reading_are_the_tabulated_ones() {
        let soft = model(Objective::Soft);
        let terms = terms(&soft);
        near(terms[0], 0.01);
        assert!(
            (terms[1] / 3.628_056_742e-20 - 1.0).abs() < 1e-9,
            "{terms:?}"
        );
        near(terms[2], 1.711_037_488);
        for (objective, expected) in [
            (Objective::Soft, 0.542_927_300),
            (Objective::Hard, 0.537_099_905),
        ] {
            let model = model(objective);
            let mut causes = model.causes(MEASURED);
            assert!(causes.add(OBSTACLES[0]) && causes.add(OBSTACLES[1]));
            near(causes.log_likelihood(), expected);
        }
    }

    #[test]
    fn g3_responsibilities_and_their_entropy_add_up_to_the_soft_likelihood() {
        let terms = terms(&model(Objective::Soft));
        let sum: f64 = terms.iter().sum();
        let share = |term: &f64| term / sum;
        near(share(&terms[0]), 0.005_810_449);
        near(share(&terms[2]), 0.994_189_551);
        let expected: f64 = terms.iter().map(|it| share(it) * libm::log(*it)).sum();
        let entropy: f64 = terms
            .iter()
            .map(|it| -share(it) * libm::log(share(it)))
            .sum();
        near(expected, 0.507_221_008);
        near(entropy, 0.035_706_291);
        near(expected + entropy, 0.542_927_300);
    }

    #[test]
    fn g3_an_empty_cone_and_a_far_obstacle_leave_the_logarithm_finite() {
        for objective in [Objective::Soft, Objective::Hard] {
            let model = model(objective);
            near(model.causes(MEASURED).log_likelihood(), -4.605_170_186);
            let narrow = ForwardModel {
                sigma_m: 0.05,
                ..model
            };
            assert_eq!(narrow.density(0.2, 5.0).to_bits(), 0);
            let mut causes = narrow.causes(Measured {
                range_m: 0.2,
                ..MEASURED
            });
            causes.add(Obstacle {
                distance_m: 5.0,
                hit: 0.9,
            });
            near(causes.log_likelihood(), -4.605_170_186);
        }
    }

    #[test]
    fn a_maximum_reading_is_less_likely_behind_obstacles() {
        let model = model(Objective::Soft);
        let silent = Measured {
            range_m: 5.0,
            is_maximum: true,
            ..MEASURED
        };
        let mut causes = model.causes(silent);
        // ln(0.01 + 0.95 / (0.005 sqrt(2 pi))).
        let empty = causes.log_likelihood();
        near(
            empty,
            libm::log(0.01 + 0.95 * 0.398_942_280_401_432_7 / 0.005),
        );
        causes.add(OBSTACLES[1]);
        assert!(causes.log_likelihood() < empty - 1.0);
    }

    #[test]
    fn g4_a_cell_covers_its_share_of_the_cone_and_the_same_cell_twice_no_more() {
        let half_angle_rad = 12.5_f64.to_radians();
        let cell = bearings(0.0, 2.0, 0.1, half_angle_rad);
        near(cell[1], 0.024_994_794);
        near(cell[0], -0.024_994_794);
        let share = |cells: &mut [[f64; 2]]| union_rad(cells) / (2.0 * half_angle_rad);
        let once = share(&mut [cell]);
        near(once, 0.114_567_695);
        near(share(&mut [cell, cell]), once);
        let [low, high] = LikelihoodParameters::STANDARD.hit;
        near(low + (high - low) * once, 0.120_819_571);
        // A cell at the edge is cut there; a gap between cells does not count.
        let edge = bearings(half_angle_rad, 2.0, 0.1, half_angle_rad);
        near(share(&mut [edge]), 0.5 * once);
        near(share(&mut [edge, cell]), 1.5 * once);
    }
}
