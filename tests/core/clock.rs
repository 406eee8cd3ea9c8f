//! The core's clock where parts of it are dead, at a model of the clock unit.

use amiro_ipf::board::clock_choice::{ClockSource, ClockUnit, choose};

/// A clock unit with dead parts.
#[derive(Debug, Default)]
struct Unit {
    has_internal: bool,
    has_crystal: bool,
    has_pll: bool,
    /// What runs.
    crystal_runs: bool,
    pll_runs: bool,
    core_is_on_pll: bool,
}

impl ClockUnit for Unit {
    fn start_internal(&mut self) -> bool {
        self.has_internal
    }

    fn select_internal(&mut self) {
        self.core_is_on_pll = false;
    }

    fn stop_pll(&mut self) {
        assert!(!self.core_is_on_pll, "the core's own clock was stopped");
        self.pll_runs = false;
    }

    fn start_crystal(&mut self) -> bool {
        self.crystal_runs = self.has_crystal;
        self.crystal_runs
    }

    fn stop_crystal(&mut self) {
        assert!(!self.core_is_on_pll, "the PLL's clock was stopped");
        self.crystal_runs = false;
    }

    fn lock_pll(&mut self, on_crystal: bool) -> bool {
        assert!(!self.pll_runs, "a running PLL takes no settings");
        assert!(!on_crystal || self.crystal_runs);
        self.pll_runs = self.has_pll;
        self.pll_runs
    }
}

#[test]
fn f43_every_dead_part_leaves_the_best_clock_that_there_is() {
    let whole = || Unit {
        has_internal: true,
        has_crystal: true,
        has_pll: true,
        // As a boot loader leaves it.
        crystal_runs: true,
        pll_runs: true,
        core_is_on_pll: true,
    };
    let cases = [
        (whole(), ClockSource::CrystalPll, true),
        (
            Unit {
                has_crystal: false,
                ..whole()
            },
            ClockSource::InternalPll,
            true,
        ),
        (
            Unit {
                has_pll: false,
                ..whole()
            },
            ClockSource::Internal,
            false,
        ),
        (
            Unit {
                has_crystal: false,
                has_pll: false,
                ..whole()
            },
            ClockSource::Internal,
            false,
        ),
        (Unit::default(), ClockSource::Unknown, false),
    ];
    for (mut unit, source, pll_runs) in cases {
        assert_eq!(choose(&mut unit), source, "{unit:?}");
        assert_eq!(unit.pll_runs, pll_runs, "{unit:?}");
        assert_eq!(unit.crystal_runs, source == ClockSource::CrystalPll);
    }
}
