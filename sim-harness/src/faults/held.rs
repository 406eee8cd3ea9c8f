//! Which single part suffers what when, after `ok` has ended what it ends.

use std::ops::Range;

use super::{Component, Faults, Word};

/// What one part suffers in one stretch of time.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Held {
    /// Never the ring.
    pub(super) component: Component,
    /// Never `ok`.
    pub(super) word: Word,
    pub(super) when_us: Range<u64>,
}

impl Faults {
    /// What holds, in the order in which it was named.
    pub(super) fn held(&self) -> Vec<Held> {
        let mut held: Vec<Held> = Vec::new();
        for fault in &self.parts {
            let when_us = fault.during.range_us();
            for component in fault.component.each() {
                if fault.word == Word::Ok {
                    held = held
                        .into_iter()
                        .flat_map(|before| before.without(component, &when_us))
                        .collect();
                } else {
                    held.push(Held {
                        component,
                        word: fault.word,
                        when_us: when_us.clone(),
                    });
                }
            }
        }
        held
    }
}

impl Held {
    /// What is left of it when a part is well for a time.
    fn without(self, component: Component, well_us: &Range<u64>) -> Vec<Self> {
        if self.component != component {
            return vec![self];
        }
        let Range { start, end } = self.when_us;
        let pieces = [start..end.min(well_us.start), start.max(well_us.end)..end];
        pieces
            .into_iter()
            .filter(|piece| !piece.is_empty())
            .map(|when_us| Self {
                when_us,
                ..self.clone()
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn held(text: &str) -> Vec<(String, Range<u64>)> {
        let faults: Faults = text.parse().unwrap();
        let named = |held: Held| (held.component.to_string(), held.when_us);
        faults.held().into_iter().map(named).collect()
    }

    fn s3(when_us: Range<u64>) -> (String, Range<u64>) {
        ("s3".to_owned(), when_us)
    }

    #[test]
    fn ok_ends_what_was_named_before_it_for_its_window() {
        let second = 1_000_000;
        assert_eq!(held("s3=off, s3=ok@8s"), [s3(0..8 * second)]);
        assert_eq!(
            held("s3=off, s3=ok@5s..8s"),
            [s3(0..5 * second), s3(8 * second..u64::MAX)]
        );
        assert_eq!(held("s3=off@1s..2s, s3=ok@2s"), [s3(second..2 * second)]);
        assert_eq!(held("s3=ok, s3=off"), [s3(0..u64::MAX)]);
        assert_eq!(held("s3=off, ring=ok"), []);
        assert_eq!(held("s3=off, s4=ok"), [s3(0..u64::MAX)]);
    }

    #[test]
    fn the_ring_is_eight_sensors() {
        let all_but_one = held("ring=off, s3=ok");
        let names: Vec<&str> = all_but_one.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["s0", "s1", "s2", "s4", "s5", "s6", "s7"]);
    }
}
