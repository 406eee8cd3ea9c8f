//! The filter of contradicting echoes in front of another method.

use super::{EchoJudgement, judge};
use crate::drive::{RangeScan, Record, Return};
use crate::lattice::Lattice;
use crate::mapping::cone_readings::{ConeReadings, ReadingSelection};
use crate::mapping::{FinishProgress, Map, Mapper};
use crate::rig::Rig;

/// Most scans in store, some 300 bytes each with eight returns; one beyond it is refused
/// and counted.
const MAX_SCANS: usize = 1 << 20;

/// Stores the scans of a drive, and passes those echoes to another mapper in
/// [`finish`](Mapper::finish) that do not contradict each other.
///
/// An echo that is removed becomes [`Return::Invalid`]; so do echoes of sensors without a
/// cone, and returns whose cone is too large for a grid. The other mapper gets scans only,
/// and no map exists before the end.
#[derive(Clone, Debug)]
pub struct ConsistentEchoMapper<M> {
    /// Without a record.
    inner: M,
    filled: Option<M>,
    readings: ConeReadings,
    scans: Vec<RangeScan>,
    refused_scans: u64,
    judgement: EchoJudgement,
}

impl<M: Mapper + Clone> ConsistentEchoMapper<M> {
    /// A filter for the sensors of a rig before a mapper that has taken no record. An echo
    /// lies within `tolerance_m` of its range (beta).
    #[must_use]
    pub fn new(inner: M, lattice: impl Into<Lattice>, rig: &Rig, tolerance_m: f64) -> Self {
        let selection = ReadingSelection {
            tolerance_m,
            reach_m: 0.0,
            takes_no_echo: false,
        };
        Self {
            inner,
            filled: None,
            readings: ConeReadings::new(lattice.into(), rig, selection),
            scans: Vec::new(),
            refused_scans: 0,
            judgement: EchoJudgement::default(),
        }
    }

    /// What was kept and removed at the end of the drive; nothing before it.
    #[must_use]
    pub fn judgement(&self) -> &EchoJudgement {
        &self.judgement
    }

    /// The scans without the echoes that were removed.
    pub(super) fn kept_scans(&self) -> Vec<RangeScan> {
        let mut kept = self.scans.clone();
        for scan in &mut kept {
            for measured in &mut scan.returns {
                let passes = match *measured {
                    Return::Echo { .. } => false,
                    Return::NoEcho { limit_m, sigma_m } => {
                        self.readings.is_walkable(limit_m + sigma_m)
                    }
                    Return::TooClose | Return::Invalid => true,
                };
                if !passes {
                    *measured = Return::Invalid;
                }
            }
        }
        let readings = self.readings.readings().iter();
        for (reading, is_kept) in readings.zip(&self.judgement.is_kept) {
            let [scan, number] = reading.source;
            if *is_kept {
                kept[scan].returns[number] = self.scans[scan].returns[number];
            }
        }
        kept
    }
}

impl<M: Mapper + Clone> Mapper for ConsistentEchoMapper<M> {
    fn take(&mut self, record: &Record) {
        let Record::Scan(scan) = record else {
            return;
        };
        if self.scans.len() == MAX_SCANS {
            self.refused_scans += 1;
            return;
        }
        self.readings.add(scan);
        self.scans.push(scan.clone());
    }

    fn finish(&mut self, progress: &mut dyn FnMut(FinishProgress)) {
        self.judgement = judge(&self.readings);
        let mut filled = self.inner.clone();
        for scan in self.kept_scans() {
            filled.take(&Record::Scan(scan));
        }
        filled.finish(progress);
        self.filled = Some(filled);
    }

    fn map(&self) -> Map {
        let Some(filled) = &self.filled else {
            return self.readings.blank_map();
        };
        let mut map = filled.map();
        let refused = self.readings.refused() + self.refused_scans;
        (0..refused).for_each(|_| map.refuse());
        map
    }

    fn is_online(&self) -> bool {
        false
    }
}
