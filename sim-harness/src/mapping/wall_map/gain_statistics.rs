//! The prior of gains, their means, and which of them a covariance determines.

use nalgebra::{DMatrix, DVector};

use super::RingGains;

/// Standard deviation of ln of the common gain (s_a): a factor of 2.7.
const COMMON_SIGMA: f64 = 1.0;

/// The same where the common gain is known.
const KNOWN_COMMON_SIGMA: f64 = 1e-3;

/// Standard deviation of ln of a sensor's gain about the common one (s_g). Sensors of one
/// robot differ by 10 to 15 %.
const SPREAD_SIGMA: f64 = 0.2;

/// Information of the prior of ln of the gains: their spread about the mean of all, and the
/// common gain, which is the mean over the mounts that are lit.
pub(super) fn prior(is_lit: &[bool], is_common_known: bool) -> DMatrix<f64> {
    let mounts = is_lit.len();
    let sigma = if is_common_known {
        KNOWN_COMMON_SIGMA
    } else {
        COMMON_SIGMA
    };
    let mean = mean_weights(is_lit);
    let centred = DMatrix::identity(mounts, mounts)
        - DMatrix::from_element(mounts, mounts, 1.0 / mounts.max(1) as f64);
    centred / SPREAD_SIGMA.powi(2) + &mean * mean.transpose() / sigma.powi(2)
}

/// The largest set of mounts whose gains relative to the mean of the set are determined,
/// found by leaving out the worst; one mount alone says nothing about ratios.
pub(super) fn determined(covariance: &DMatrix<f64>, lit: &[usize]) -> Vec<bool> {
    let mut determined: Vec<bool> = lit.iter().map(|lit| *lit > 0).collect();
    while determined.iter().filter(|it| **it).count() > 1 {
        let weights = mean_weights(&determined);
        let members = determined.iter().enumerate().filter(|(_, it)| **it);
        let sigmas = members.map(|(mount, _)| {
            let sigma = variance(covariance, &relative(mount, &weights)).sqrt();
            (sigma, mount)
        });
        let worst = sigmas.max_by(|one, other| one.0.total_cmp(&other.0));
        match worst {
            Some((sigma, mount)) if sigma > RingGains::LARGEST_SIGMA => determined[mount] = false,
            _ => break,
        }
    }
    determined
}

/// Equal weights of the members of a set, of all where it is empty.
pub(super) fn mean_weights(members: &[bool]) -> DVector<f64> {
    let is_empty = !members.contains(&true);
    let weights = members
        .iter()
        .map(|it| f64::from(u8::from(*it || is_empty)));
    let weights = DVector::from_iterator(members.len(), weights);
    let sum = weights.sum();
    weights / sum.max(1.0)
}

/// Weights that give a mount's value less a mean.
pub(super) fn relative(mount: usize, mean: &DVector<f64>) -> DVector<f64> {
    let mut weights = -mean.clone();
    weights[mount] += 1.0;
    weights
}

pub(super) fn variance(covariance: &DMatrix<f64>, weights: &DVector<f64>) -> f64 {
    (weights.transpose() * covariance * weights)[(0, 0)].max(0.0)
}
