//! Rules that fuse the layers of a cell.

use crate::mapping::Belief;

/// Distance from 0.5 up to which the mean of the layers leans to neither side.
const EVEN: f64 = 1e-9;

/// How the layers of a cell become one value, by the probabilities that the cell is free.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fusion {
    /// The least probability of free. A layer that knows nothing of the cell has 0.5, and
    /// wins over one that has 0.9: a cell that one sensor never saw is not free.
    Pessimistic,
    /// The same over the layers that lean to a side; not in the source.
    PessimisticOfKnown,
    /// The largest probability of free if the mean of the layers is above 0.5, the least if
    /// it is below, and 0.5 at 0.5: the layer that is surest on the side of the mean.
    MinMax,
}

/// The value of a cell after fusion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fused {
    /// Probability that the cell is free.
    pub free: f64,
    /// Index of the layer that supplied it, the first of equal ones; `None` if none did.
    pub source: Option<usize>,
}

impl Fused {
    const NOTHING: Self = Self {
        free: 0.5,
        source: None,
    };
}

impl Fusion {
    /// Fuses the probabilities of free of a cell, one per layer.
    #[must_use]
    pub fn fuse(self, free: &[f64]) -> Fused {
        let layers = free.iter().copied().enumerate();
        match self {
            Self::Pessimistic => least(layers),
            Self::PessimisticOfKnown => {
                least(layers.filter(|(_, free)| (2.0 * free - 1.0).abs() > Belief::TOLERANCE))
            }
            Self::MinMax => {
                let mean = free.iter().sum::<f64>() / free.len() as f64;
                if mean > 0.5 + EVEN {
                    let turned = least(layers.map(|(index, free)| (index, 1.0 - free)));
                    let source = turned.source;
                    let value = source.and_then(|index| free.get(index));
                    value.map_or(Fused::NOTHING, |free| Fused {
                        free: *free,
                        source,
                    })
                } else if mean < 0.5 - EVEN {
                    least(layers)
                } else {
                    Fused::NOTHING
                }
            }
        }
    }
}

/// The least probability, the first of equal ones.
fn least(layers: impl Iterator<Item = (usize, f64)>) -> Fused {
    let first = |least: Fused, (index, free)| {
        if least.source.is_none() || free < least.free {
            let source = Some(index);
            Fused { free, source }
        } else {
            least
        }
    };
    layers.fold(Fused::NOTHING, first)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Value and source of both layers under a rule.
    fn fused(rule: Fusion, layers: [f64; 2]) -> (f64, Option<usize>) {
        let Fused { free, source } = rule.fuse(&layers);
        (free, source)
    }

    #[test]
    fn g10_two_layers_are_fused_as_tabulated() {
        for (layers, pessimistic, min_max) in [
            ([0.9, 0.2], 0.2, 0.9),
            ([0.6, 0.4], 0.4, 0.5),
            ([0.9, 0.5], 0.5, 0.9),
            ([0.3, 0.5], 0.3, 0.3),
            ([0.3, 0.6], 0.3, 0.3),
            ([0.55, 0.40], 0.40, 0.40),
        ] {
            let (found, _) = fused(Fusion::Pessimistic, layers);
            assert!((found - pessimistic).abs() < 1e-9, "{layers:?}: {found}");
            let (found, _) = fused(Fusion::MinMax, layers);
            assert!((found - min_max).abs() < 1e-9, "{layers:?}: {found}");
        }
    }

    #[test]
    fn the_source_is_the_layer_that_supplied_the_value_the_first_of_equal_ones() {
        for (rule, layers, source) in [
            (Fusion::Pessimistic, [0.9, 0.2], Some(1)),
            (Fusion::Pessimistic, [0.2, 0.2], Some(0)),
            (Fusion::MinMax, [0.9, 0.2], Some(0)),
            (Fusion::MinMax, [0.7, 0.7], Some(0)),
            (Fusion::MinMax, [0.6, 0.8], Some(1)),
            (Fusion::MinMax, [0.6, 0.4], None),
            (Fusion::PessimisticOfKnown, [0.5, 0.5], None),
        ] {
            assert_eq!(fused(rule, layers).1, source, "{rule:?} {layers:?}");
        }
    }

    #[test]
    fn an_unknown_layer_wins_as_printed_and_not_if_it_is_ignored() {
        let layers = [0.9, 0.5];
        assert!((fused(Fusion::Pessimistic, layers).0 - 0.5).abs() < 1e-12);
        assert_eq!(fused(Fusion::PessimisticOfKnown, layers), (0.9, Some(0)));
    }

    #[test]
    fn no_layer_is_no_opinion() {
        for rule in [
            Fusion::Pessimistic,
            Fusion::PessimisticOfKnown,
            Fusion::MinMax,
        ] {
            assert_eq!(rule.fuse(&[]), Fused::NOTHING, "{rule:?}");
        }
    }
}
