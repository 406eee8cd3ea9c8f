//! Normal equations of the fit, and their solution by L D L'.

use super::MAX_SEGMENTS;

/// Coordinates of a segment.
pub(super) const COORDINATES: usize = 4;
/// Most unknowns of a fit.
pub(super) const MAX_UNKNOWNS: usize = COORDINATES * MAX_SEGMENTS;

/// Symmetric normal equations H x = b of at most [`MAX_UNKNOWNS`] unknowns.
///
/// The diagonal and what is above it hold H; below it is the place of the factor L, so
/// that H stays for another damping. Written out instead of nalgebra's factorization:
/// the number of unknowns varies at run time, the order of the operations is fixed on all
/// machines, and nothing can panic.
#[derive(Clone, Debug)]
pub(super) struct System {
    h: [[f32; MAX_UNKNOWNS]; MAX_UNKNOWNS],
    b: [f32; MAX_UNKNOWNS],
    unknowns: usize,
}

/// Derivatives of one residual for the coordinates of one segment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slope {
    /// First of the segment's unknowns.
    pub(super) first: usize,
    pub(super) values: [f32; COORDINATES],
}

impl System {
    /// No equations.
    pub(super) const fn new() -> Self {
        Self {
            h: [[0.0; MAX_UNKNOWNS]; MAX_UNKNOWNS],
            b: [0.0; MAX_UNKNOWNS],
            unknowns: 0,
        }
    }

    /// Makes it equations of so many unknowns, all zero.
    pub(super) fn clear(&mut self, unknowns: usize) {
        for row in self.h.iter_mut().take(unknowns) {
            row.iter_mut().take(unknowns).for_each(|entry| *entry = 0.0);
        }
        self.b.fill(0.0);
        self.unknowns = unknowns;
    }

    /// Adds a residual with its weight: H += w J'J, b -= w J'r.
    #[inline(never)]
    pub(super) fn add(&mut self, slopes: &[Slope], residual: f32, weight: f32) {
        for (index, slope) in slopes.iter().enumerate() {
            let weighted = slope.values.map(|value| weight * value);
            let rows = self.h.iter_mut().zip(&mut self.b).skip(slope.first);
            for (own, (row, b)) in weighted.iter().zip(rows) {
                *b -= own * residual;
                for other in slopes.iter().skip(index) {
                    let Some([e0, e1, e2, e3]) = row
                        .get_mut(other.first..)
                        .and_then(|row| row.first_chunk_mut())
                    else {
                        continue;
                    };
                    let [v0, v1, v2, v3] = other.values;
                    *e0 += own * v0;
                    *e1 += own * v1;
                    *e2 += own * v2;
                    *e3 += own * v3;
                }
            }
        }
    }

    /// Adds to the block of a segment, given by its first unknown.
    pub(super) fn add_block(
        &mut self,
        first: usize,
        h: impl Fn(usize, usize) -> f32,
        b: impl Fn(usize) -> f32,
    ) {
        let rows = self.h.iter_mut().zip(&mut self.b).skip(first);
        for (row, (entries, sum)) in rows.take(COORDINATES).enumerate() {
            *sum += b(row);
            let entries = entries.iter_mut().skip(first).take(COORDINATES);
            for (column, entry) in entries.enumerate() {
                *entry += h(row, column);
            }
        }
    }

    /// Makes it the block of a segment of other equations, with nothing on the right.
    pub(super) fn take_block(&mut self, of: &Self, first: usize) {
        self.clear(COORDINATES);
        let rows = self.h.iter_mut().zip(of.h.iter().skip(first));
        for (to, from) in rows.take(COORDINATES) {
            for (to, from) in to.iter_mut().zip(from.iter().skip(first)).take(COORDINATES) {
                *to = *from;
            }
        }
    }

    /// Sets the right side to a unit vector.
    pub(super) fn set_unit(&mut self, unknown: usize) {
        self.b.fill(0.0);
        if let Some(b) = self.b.get_mut(unknown) {
            *b = 1.0;
        }
    }

    /// The solution of (H + damping diag(H)) x = b; `None` if that is not positive.
    ///
    /// About n^3 / 3 + 2 n^2 operations for n unknowns.
    #[inline(never)]
    pub(super) fn solve(&mut self, damping: f32) -> Option<[f32; MAX_UNKNOWNS]> {
        let n = self.unknowns.min(MAX_UNKNOWNS);
        let mut inverse_pivots = [0.0_f32; MAX_UNKNOWNS];
        let mut x = self.b;
        for i in 0..n {
            let (above, rest) = self.h.split_at_mut_checked(i)?;
            let row = rest.first_mut()?;
            let diagonal = *row.get(i)?;
            let mut pivot = diagonal + damping * diagonal;
            let mut value = *x.get(i)?;
            for j in 0..i {
                // L_ij = (H_ij - sum over k of L_ik D_k L_jk) / D_j, built with D.
                let upper = above.get(j)?;
                let sum: f32 = row
                    .iter()
                    .zip(upper.iter())
                    .take(j)
                    .zip(&inverse_pivots)
                    .fold(0.0, |sum, ((a, b), inverse)| sum + a * b * inverse);
                let product = *upper.get(i)? - sum;
                *row.get_mut(j)? = product;
                let inverse = *inverse_pivots.get(j)?;
                pivot -= product * product * inverse;
                value -= product * inverse * *x.get(j)?;
            }
            // Less than rounding leaves of the diagonal is nothing.
            if !pivot.is_finite() || pivot <= 1e-6 * diagonal {
                return None;
            }
            *inverse_pivots.get_mut(i)? = 1.0 / pivot;
            *x.get_mut(i)? = value;
        }
        // x = L'^-1 D^-1 (L^-1 b), where the rows below the diagonal hold L D.
        for i in (0..n).rev() {
            let mut value = *x.get(i)?;
            for k in i + 1..n {
                value -= self.h.get(k)?.get(i)? * *x.get(k)?;
            }
            *x.get_mut(i)? = value * inverse_pivots.get(i)?;
        }
        x.iter().all(|value| value.is_finite()).then_some(x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solution_solves_the_equations_and_leaves_them() {
        let mut system = System::new();
        system.clear(MAX_UNKNOWNS);
        let mut value = 0.1_f32;
        let mut next = || {
            value = (value * 37.7 + 0.31) % 1.0;
            value - 0.5
        };
        for residual in 0..60 {
            let slopes: [Slope; 2] = core::array::from_fn(|index| Slope {
                first: 4 * ((residual + 2 * index) % 5 + index),
                values: core::array::from_fn(|_| next()),
            });
            system.add(&slopes, next(), 1.0);
        }
        let symmetric = |i: usize, j: usize, h: &[[f32; MAX_UNKNOWNS]; MAX_UNKNOWNS]| {
            f64::from(if i <= j { h[i][j] } else { h[j][i] })
        };
        for damping in [0.3, 0.01] {
            let x = system.solve(damping).unwrap();
            for i in 0..MAX_UNKNOWNS {
                let mut sum = -f64::from(system.b[i]);
                for (j, x) in x.iter().enumerate() {
                    let factor = if i == j {
                        1.0 + f64::from(damping)
                    } else {
                        1.0
                    };
                    sum += factor * symmetric(i, j, &system.h) * f64::from(*x);
                }
                assert!(sum.abs() < 1e-4, "row {i}: {sum}");
            }
        }
    }

    #[test]
    fn equations_without_a_solution_have_none() {
        let mut bad = System::new();
        bad.clear(4);
        assert_eq!(bad.solve(0.1), None);
        let slope = Slope {
            first: 0,
            values: [f32::NAN, 1.0, 0.0, 0.0],
        };
        bad.add(&[slope], 1.0, 1.0);
        assert_eq!(bad.solve(0.1), None);
    }
}
