//! A master at its unit, and whoever calls it: interrupts, late or not, and the patrol.

use std::cell::RefCell;
use std::rc::Rc;

use amiro_ipf::driver::{BusFault, Transaction};
use amiro_ipf::random::{Generator, uniform_below};

use sim_harness::bus::Device;

use super::Unit;
use super::unit::Wired;
use amiro_ipf::board::i2c::{Master, Progress, Timing};

/// The patrol's period.
pub(crate) const PATROL_NS: u64 = 500_000;

/// From the flag to the first access: entry into the handler and its prologue.
const ENTRY_NS: u64 = 300;

/// No transaction lasts longer, whatever happens: two patrols, the longest transaction
/// and a recovery lie far below.
const HANG_NS: u64 = 5_000_000;

pub(crate) struct Bench {
    pub(crate) unit: Rc<RefCell<Unit>>,
    pub(crate) master: Master<Wired>,
    /// An interrupt comes at most so much late, nanoseconds.
    pub(crate) lateness_ns: u32,
    /// One call, counted from 1, comes later by so many nanoseconds.
    pub(crate) late_call: Option<(u32, u64)>,
    /// Calls of the event and error handlers in the last transaction.
    pub(crate) calls: u32,
    /// The longest call of any handler so far, nanoseconds.
    pub(crate) longest_call_ns: u64,
    generator: Generator,
    next_patrol_ns: u64,
}

impl Bench {
    pub(crate) fn new(device: impl Device + 'static, seed: u64) -> Self {
        Self::after(device, seed, |_| {})
    }

    /// A bench on whose bus something has happened before the master starts.
    pub(crate) fn after(
        device: impl Device + 'static,
        seed: u64,
        happen: impl FnOnce(&mut Unit),
    ) -> Self {
        let mut unit = Unit::new(Box::new(device), seed);
        happen(&mut unit);
        let unit = Rc::new(RefCell::new(unit));
        let master = Master::new(Wired(unit.clone()), Timing::fast(42_000_000), 0);
        Self {
            unit,
            master,
            lateness_ns: 0,
            late_call: None,
            calls: 0,
            longest_call_ns: 0,
            generator: Generator::seeded(!seed),
            next_patrol_ns: PATROL_NS,
        }
    }

    pub(crate) fn now_ns(&self) -> u64 {
        self.unit.borrow().now_ns
    }

    fn now_us(&self) -> u64 {
        self.now_ns() / 1000
    }

    /// Begins a transaction and serves it to its end.
    pub(crate) fn run(&mut self, transaction: &Transaction) -> Result<Vec<u8>, BusFault> {
        self.calls = 0;
        let begun_ns = self.now_ns();
        let now_us = self.now_us();
        let mut progress = self.call(|master| master.begin(transaction, now_us));
        while progress == Progress::Running {
            progress = self.serve();
            let lasted = self.now_ns() - begun_ns;
            assert!(lasted < HANG_NS, "{transaction:?} hangs: {lasted} ns");
        }
        assert_eq!(progress, Progress::Done, "{transaction:?}");
        self.master.result().map(<[u8]>::to_vec)
    }

    /// Serves until a time, without a transaction.
    pub(crate) fn idle_until(&mut self, ns: u64) {
        while self.now_ns() < ns {
            self.serve();
        }
    }

    /// Lets the next thing happen. Of two that are due the event comes first, then the
    /// error, then the patrol, as their numbers in the vector table.
    fn serve(&mut self) -> Progress {
        let (event, error, now_ns, next_ns) = {
            let unit = self.unit.borrow();
            (
                unit.event_line(),
                unit.error_line(),
                unit.now_ns,
                unit.next_ns(),
            )
        };
        if event || error {
            self.calls += 1;
            let late_ns = match (self.late_call, self.lateness_ns) {
                (Some((call, late_ns)), _) if call == self.calls => late_ns,
                (_, 0) => 0,
                (_, most) => u64::from(uniform_below(&mut self.generator, most)),
            };
            self.unit.borrow_mut().pass(ENTRY_NS + late_ns);
            let now_us = self.now_us();
            return self.call(|master| {
                if event {
                    master.on_event(now_us)
                } else {
                    master.on_error(now_us)
                }
            });
        }
        let due_ns = next_ns.unwrap_or(u64::MAX).min(self.next_patrol_ns);
        self.unit.borrow_mut().pass(due_ns.saturating_sub(now_ns));
        if self.now_ns() < self.next_patrol_ns {
            return Progress::Running;
        }
        while self.next_patrol_ns <= self.now_ns() {
            self.next_patrol_ns += PATROL_NS;
        }
        let now_us = self.now_us();
        self.call(|master| master.patrol(now_us))
    }

    fn call(&mut self, call: impl FnOnce(&mut Master<Wired>) -> Progress) -> Progress {
        let before_ns = self.now_ns();
        let progress = call(&mut self.master);
        self.longest_call_ns = self.longest_call_ns.max(self.now_ns() - before_ns);
        progress
    }
}
