//! The schedule of injected faults.

use std::ops::{Range, RangeInclusive};

use amiro_ipf::random::{Generator, uniform, uniform_below};

use super::InjectedBusFault;

/// When a fault is injected.
#[derive(Clone, Copy, Debug, PartialEq)]
enum When {
    /// Before the byte with this number.
    Byte(u64),
    /// Before the first byte from then on.
    From(u64),
    /// Before every byte from the first time on and before the second.
    Between(u64, u64),
    /// The same, only in slots that are drawn at random.
    Now(u64, u64, Outages),
}

/// Random times of failure, as of a loose contact.
///
/// Time is cut into slots of equal length, and each is drawn independently: whether it
/// fails depends only on the seed and its number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outages {
    slot_ns: u64,
    share: f64,
    seed: u64,
}

/// Keeps the draws of slots apart from other noise: "loose".
const OUTAGE_STREAM: u64 = 0x6c_6f6f_7365;

impl Outages {
    /// The given share of all slots fails, to 2^-24; a length of 0 counts as 1.
    #[must_use]
    pub fn new(slot_ns: u64, share: f64, seed: u64) -> Self {
        Self {
            slot_ns: slot_ns.max(1),
            share,
            seed,
        }
    }

    /// Whether it fails at a time.
    #[must_use]
    pub fn fails_at(&self, now_ns: u64) -> bool {
        let slot = (now_ns / self.slot_ns).rotate_left(20);
        let mut generator = Generator::seeded(self.seed ^ OUTAGE_STREAM ^ slot);
        f64::from(uniform(&mut generator)) < self.share
    }
}

#[derive(Clone, Copy, Debug)]
struct PlannedFault {
    when: When,
    fault: InjectedBusFault,
}

/// Faults at random distances.
#[derive(Clone, Debug)]
pub struct Random {
    kinds: Vec<InjectedBusFault>,
    distances: RangeInclusive<u32>,
    /// The next byte with a fault; unknown before the first byte.
    next: Option<u64>,
    generator: Generator,
}

impl Random {
    /// One of `kinds` at a distance within `bytes`, both uniformly distributed.
    ///
    /// A least distance longer than an exchange keeps two faults out of the same one.
    #[must_use]
    pub fn new(kinds: Vec<InjectedBusFault>, distances: RangeInclusive<u32>, seed: u64) -> Self {
        Self {
            kinds,
            distances,
            next: None,
            generator: Generator::seeded(seed),
        }
    }

    fn distance(&mut self) -> u64 {
        let least = (*self.distances.start()).max(1);
        let most = (*self.distances.end()).max(least);
        u64::from(least + uniform_below(&mut self.generator, most - least + 1))
    }

    fn strikes(&mut self, byte: u64) -> Option<InjectedBusFault> {
        let next = self.next.unwrap_or_else(|| byte + self.distance() - 1);
        self.next = Some(next);
        if byte < next {
            return None;
        }
        self.next = Some(byte + self.distance());
        let kinds = u32::try_from(self.kinds.len()).ok()?;
        let kind = uniform_below(&mut self.generator, kinds);
        self.kinds.get(kind as usize).copied()
    }
}

/// The faults that a bus is to inject.
///
/// Bytes are counted since the bus's power came up, from 0; each address and each data
/// byte is one. Times are nanoseconds since then.
#[derive(Clone, Debug, Default)]
pub struct Script {
    entries: Vec<PlannedFault>,
    random: Option<Random>,
    /// Random faults that come only between two times.
    bursts: Vec<(Range<u64>, Random)>,
    hits: u64,
}

impl Script {
    /// A fault before the byte with the given number.
    pub fn at_byte(&mut self, byte: u64, fault: InjectedBusFault) {
        self.add(When::Byte(byte), fault);
    }

    /// A fault before the first byte from the given time on.
    pub fn from_time(&mut self, from_ns: u64, fault: InjectedBusFault) {
        self.add(When::From(from_ns), fault);
    }

    /// A fault before every byte that begins at `from_ns` or later and before `to_ns`.
    pub fn between(&mut self, from_ns: u64, to_ns: u64, fault: InjectedBusFault) {
        self.add(When::Between(from_ns, to_ns), fault);
    }

    /// A fault before every byte between two times that begins in a slot that fails.
    pub fn now_and_then(
        &mut self,
        from_ns: u64,
        to_ns: u64,
        outages: Outages,
        fault: InjectedBusFault,
    ) {
        self.add(When::Now(from_ns, to_ns, outages), fault);
    }

    /// Random faults between two times, in addition to all others.
    pub fn at_random_between(&mut self, from_ns: u64, to_ns: u64, random: Random) {
        self.bursts.push((from_ns..to_ns, random));
    }

    /// Random faults from now on, in place of earlier random ones; `None` ends them.
    pub fn at_random(&mut self, random: Option<Random>) {
        self.random = random;
    }

    /// Removes all future faults; the count of hits stays.
    pub fn clear(&mut self) {
        self.entries.clear();
        self.random = None;
        self.bursts.clear();
    }

    /// Number of injected faults that had an effect.
    #[must_use]
    pub const fn hits(&self) -> u64 {
        self.hits
    }

    fn add(&mut self, when: When, fault: InjectedBusFault) {
        self.entries.push(PlannedFault { when, fault });
    }

    pub(super) fn count_hit(&mut self) {
        self.hits += 1;
    }

    /// The faults before a byte; those that occur once are removed.
    pub(super) fn strikes(&mut self, byte: u64, now_ns: u64) -> Vec<InjectedBusFault> {
        let mut faults = Vec::new();
        self.entries.retain(|entry| {
            let (strikes, stays) = match entry.when {
                When::Byte(at) => (byte == at, byte < at),
                When::From(from_ns) => (now_ns >= from_ns, now_ns < from_ns),
                When::Between(from_ns, to_ns) => {
                    ((from_ns..to_ns).contains(&now_ns), now_ns < to_ns)
                }
                When::Now(from_ns, to_ns, outages) => {
                    let is_inside = (from_ns..to_ns).contains(&now_ns);
                    (is_inside && outages.fails_at(now_ns), now_ns < to_ns)
                }
            };
            if strikes {
                faults.push(entry.fault);
            }
            stays
        });
        if let Some(random) = &mut self.random {
            faults.extend(random.strikes(byte));
        }
        for (when_ns, random) in &mut self.bursts {
            if when_ns.contains(&now_ns) {
                faults.extend(random.strikes(byte));
            }
        }
        faults
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bus::MuxFault;

    const LOST: InjectedBusFault = InjectedBusFault::ArbitrationLost;
    const REFUSED: InjectedBusFault = InjectedBusFault::NoAcknowledge;

    #[test]
    fn faults_strike_at_their_byte_or_in_their_time() {
        let mut script = Script::default();
        script.at_byte(2, LOST);
        script.from_time(25, REFUSED);
        script.between(10, 30, InjectedBusFault::Mux(MuxFault::Reset));
        let struck: Vec<Vec<InjectedBusFault>> =
            (0..5).map(|byte| script.strikes(byte, byte * 10)).collect();
        let reset = InjectedBusFault::Mux(MuxFault::Reset);
        assert_eq!(
            struck,
            [
                vec![],
                vec![reset],
                vec![LOST, reset],
                vec![REFUSED],
                vec![]
            ]
        );
    }

    #[test]
    fn random_faults_have_their_rate_and_repeat_with_the_seed() {
        let faults = |seed| -> Vec<(u64, InjectedBusFault)> {
            let mut script = Script::default();
            script.at_random(Some(Random::new(vec![LOST, REFUSED], 1..=19, seed)));
            let at = |byte| {
                script
                    .strikes(byte, 0)
                    .into_iter()
                    .map(move |fault| (byte, fault))
            };
            (0..100_000).flat_map(at).collect()
        };
        for seed in 1..=3 {
            let struck = faults(seed);
            assert_eq!(struck, faults(seed));
            assert_ne!(struck, faults(seed + 3));
            let near = |(a, b): (&(u64, InjectedBusFault), &(u64, InjectedBusFault))| b.0 - a.0;
            let distances: Vec<u64> = struck.iter().zip(&struck[1..]).map(near).collect();
            assert!(distances.iter().all(|distance| (1..=19).contains(distance)));
            // Distances of 1 to 19: sigma 5.5, so 4 sigma of 10 000 of them are 220 faults'
            // worth; of the kinds 4 sqrt(10 000 / 4) = 200.
            let number = struck.len() as f64;
            assert!((number - 10_000.0).abs() < 220.0, "seed {seed}: {number}");
            let lost = struck.iter().filter(|(_, fault)| *fault == LOST).count() as f64;
            assert!((lost - 0.5 * number).abs() < 200.0, "seed {seed}: {lost}");
        }
    }

    #[test]
    fn a_loose_contact_fails_for_whole_slots_and_for_its_share_of_them() {
        for seed in 1..=3 {
            let mut script = Script::default();
            let outages = Outages::new(1_000, 0.3, seed);
            script.now_and_then(1_000_000, 11_000_000, outages, LOST);
            let struck = |script: &mut Script, now_ns| !script.strikes(0, now_ns).is_empty();
            assert!(!(0..1_000).any(|slot| struck(&mut script, slot * 1_000)));
            let slots = (1_000..11_000).map(|slot| {
                let [first, last] = [0, 999].map(|ns| struck(&mut script, slot * 1_000 + ns));
                assert_eq!(first, last);
                first
            });
            let failing = slots.filter(|failing| *failing).count();
            // 10 000 slots with p = 0.3: 4 sigma are 183.
            assert!(failing.abs_diff(3_000) < 183, "seed {seed}: {failing}");
            assert!(!struck(&mut script, 11_000_000));
        }
    }

    #[test]
    fn a_burst_ends_with_its_time() {
        let mut script = Script::default();
        script.at_random_between(10, 20, Random::new(vec![LOST], 1..=1, 1));
        let struck = (0..30).filter(|byte| !script.strikes(*byte, *byte).is_empty());
        assert_eq!(struck.collect::<Vec<_>>(), (10..20).collect::<Vec<_>>());
    }

    #[test]
    fn a_random_fault_may_strike_every_byte() {
        let mut script = Script::default();
        script.at_random(Some(Random::new(vec![LOST], 1..=1, 1)));
        assert!((0..100).all(|byte| script.strikes(byte, 0) == [LOST]));
        script.clear();
        assert!(script.strikes(100, 0).is_empty());
    }
}
