//! The faults of each component by time, after `ok` has ended earlier ones.

use std::ops::Range;

use super::{Component, Faults, Kind};

/// A fault of one component in one stretch of time.
#[derive(Clone, Debug, PartialEq)]
pub struct ActiveFault {
    /// Never the ring.
    pub component: Component,
    /// Never `ok`.
    pub kind: Kind,
    /// Microseconds from the start of the drive.
    pub when_us: Range<u64>,
}

/// The faults of a drive's components, and the seed of their random part.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ActiveFaults {
    all: Vec<ActiveFault>,
    seed: u64,
}

impl ActiveFaults {
    /// No faults; the seed is 0.
    #[must_use]
    pub const fn none() -> Self {
        Self {
            all: Vec::new(),
            seed: 0,
        }
    }

    /// The seed, beside the robot's own.
    #[must_use]
    pub const fn seed(&self) -> u64 {
        self.seed
    }

    /// The same, with a fault of a component from a time on.
    #[must_use]
    pub fn from(self, from_us: u64, component: Component, kind: Kind) -> Self {
        self.within(from_us..u64::MAX, component, kind)
    }

    /// The same, with a fault of a component between two times.
    #[must_use]
    pub fn within(mut self, when_us: Range<u64>, component: Component, kind: Kind) -> Self {
        self.all.push(ActiveFault {
            component,
            kind,
            when_us,
        });
        self
    }

    /// All faults, in the order in which they were named.
    pub fn iter(&self) -> impl Iterator<Item = &ActiveFault> {
        self.all.iter()
    }

    /// The faults of a component at a time, with their index among all.
    pub fn placed(&self, component: Component, at_us: u64) -> impl Iterator<Item = (usize, Kind)> {
        self.all
            .iter()
            .enumerate()
            .filter(move |(_, fault)| {
                fault.component == component && fault.when_us.contains(&at_us)
            })
            .map(|(place, fault)| (place, fault.kind))
    }

    /// The faults of a component at a time.
    pub fn of(&self, component: Component, at_us: u64) -> impl Iterator<Item = Kind> {
        self.placed(component, at_us).map(|(_, kind)| kind)
    }
}

impl Faults {
    /// The faults of the robot's components, each with its times; times are those of the
    /// drive, and the random part is drawn from the seed.
    #[must_use]
    pub fn active(&self, seed: u64) -> ActiveFaults {
        let mut all: Vec<ActiveFault> = Vec::new();
        for fault in &self.parts {
            let when_us = fault.window.range_us();
            for component in fault.component.each() {
                if fault.kind == Kind::Ok {
                    all = all
                        .into_iter()
                        .flat_map(|before| before.without(component, &when_us))
                        .collect();
                } else {
                    all.push(ActiveFault {
                        component,
                        kind: fault.kind,
                        when_us: when_us.clone(),
                    });
                }
            }
        }
        ActiveFaults { all, seed }
    }
}

impl ActiveFault {
    /// The rest of the fault when a component has no fault for a time.
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

    fn active(text: &str) -> Vec<(String, Range<u64>)> {
        let faults: Faults = text.parse().unwrap();
        let active = faults.active(0);
        let named = |fault: &ActiveFault| (fault.component.to_string(), fault.when_us.clone());
        active.iter().map(named).collect()
    }

    fn s3(when_us: Range<u64>) -> (String, Range<u64>) {
        ("s3".to_owned(), when_us)
    }

    #[test]
    fn ok_ends_what_was_named_before_it_for_its_window() {
        let second = 1_000_000;
        assert_eq!(active("s3=off, s3=ok@8s"), [s3(0..8 * second)]);
        assert_eq!(
            active("s3=off, s3=ok@5s..8s"),
            [s3(0..5 * second), s3(8 * second..u64::MAX)]
        );
        assert_eq!(active("s3=off@1s..2s, s3=ok@2s"), [s3(second..2 * second)]);
        assert_eq!(active("s3=ok, s3=off"), [s3(0..u64::MAX)]);
        assert_eq!(active("s3=off, ring=ok"), []);
        assert_eq!(active("s3=off, s4=ok"), [s3(0..u64::MAX)]);
    }

    #[test]
    fn the_ring_is_eight_sensors() {
        let all_but_one = active("ring=off, s3=ok");
        let names: Vec<&str> = all_but_one.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["s0", "s1", "s2", "s4", "s5", "s6", "s7"]);
    }
}
