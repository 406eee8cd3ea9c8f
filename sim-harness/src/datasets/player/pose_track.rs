//! Scans of devices at rates of their own, with poses between those of the odometry.

use std::ops::Range;

use super::super::{ReadRows, RefusedRow};
use crate::drive::{RangeScan, Record, Return};
use crate::geometry::Pose2;

/// Most scans between two poses; the others are refused.
const MOST_PENDING: usize = 256;

/// How long before the last pose, or behind the last one of a log, a scan may be, seconds.
const MOST_APART_S: f64 = 0.5;

/// Holds scans until the pose behind them is known.
///
/// A scan gets the pose on the straight way between the two poses around it. Of one that
/// comes later than the pose behind it, the way is continued back.
#[derive(Debug, Default)]
pub(super) struct PoseTrack {
    first_s: Option<f64>,
    last: Option<(f64, Pose2)>,
    pending: Vec<PendingScan>,
    /// Stamp of the last record, microseconds.
    stamp_us: u64,
}

#[derive(Debug)]
struct PendingScan {
    time_s: f64,
    mounts: Range<usize>,
    returns: Vec<Return>,
    /// The refusal of the row, without a reason.
    row: RefusedRow,
}

impl PoseTrack {
    /// Takes a pose, and hands on the scans before it, then the pose.
    pub(super) fn pose(
        &mut self,
        time_s: f64,
        pose: Pose2,
        rows: &mut ReadRows,
        take: &mut dyn FnMut(&Record),
    ) -> Result<(), String> {
        if self.last.is_some_and(|(last_s, _)| time_s < last_s) {
            return Err(format!("stamp {time_s} s is out of order"));
        }
        self.first_s.get_or_insert(time_s);
        let pending = core::mem::take(&mut self.pending);
        let (before, behind) = pending.into_iter().partition(|scan| scan.time_s < time_s);
        self.pending = behind;
        self.hand_on(before, Some((time_s, pose)), rows, take);
        self.last = Some((time_s, pose));
        let stamp_us = self.stamp(time_s);
        take(&Record::Pose {
            stamp_us,
            world_from_body: pose,
        });
        Ok(())
    }

    /// Takes a scan; `row` is the refusal of its row, without a reason.
    pub(super) fn scan(
        &mut self,
        time_s: f64,
        mounts: Range<usize>,
        returns: Vec<Return>,
        row: RefusedRow,
        rows: &mut ReadRows,
    ) {
        let refused = |reason: String| RefusedRow {
            reason,
            ..row.clone()
        };
        if self.pending.len() >= MOST_PENDING {
            let reason = format!("more than {MOST_PENDING} scans without a pose");
            rows.refused.add(refused(reason));
            return;
        }
        let is_late = |(last_s, _)| time_s < last_s - MOST_APART_S;
        if self.last.is_some_and(is_late) {
            rows.refused
                .add(refused(format!("stamp {time_s} s is out of order")));
            return;
        }
        self.pending.push(PendingScan {
            time_s,
            mounts,
            returns,
            row,
        });
    }

    /// Hands on the scans behind the last pose.
    pub(super) fn finish(&mut self, rows: &mut ReadRows, take: &mut dyn FnMut(&Record)) {
        let pending = core::mem::take(&mut self.pending);
        self.hand_on(pending, None, rows, take);
    }

    fn hand_on(
        &mut self,
        mut scans: Vec<PendingScan>,
        next: Option<(f64, Pose2)>,
        rows: &mut ReadRows,
        take: &mut dyn FnMut(&Record),
    ) {
        scans.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        for scan in scans {
            let Some(world_from_body) = self.pose_at(scan.time_s, next) else {
                rows.refused.add(RefusedRow {
                    reason: "no position row is near in time".to_owned(),
                    ..scan.row
                });
                continue;
            };
            rows.used += 1;
            let stamp_us = self.stamp(scan.time_s);
            take(&Record::Scan(RangeScan {
                stamp_us,
                world_from_body,
                mounts: scan.mounts,
                returns: scan.returns,
                signals: Vec::new(),
            }));
        }
    }

    /// The pose at a time between the last pose and the next.
    fn pose_at(&self, time_s: f64, next: Option<(f64, Pose2)>) -> Option<Pose2> {
        let (last_s, last) = self.last?;
        let Some((next_s, next)) = next else {
            return (time_s - last_s <= MOST_APART_S).then_some(last);
        };
        let period_s = next_s - last_s;
        let share = if period_s > 0.0 {
            ((time_s - last_s) / period_s).clamp(-1.0, 1.0)
        } else {
            0.0
        };
        let place = last.position + (next.position - last.position).scaled(share);
        let turn = next.heading.after(last.heading.inverse());
        let turn_rad = libm::atan2(turn.sine, turn.cosine);
        let heading_rad = last.heading_rad() + share * turn_rad;
        Some(Pose2::new(place.x, place.y, heading_rad))
    }

    /// The stamp of a record, never before the last one.
    fn stamp(&mut self, time_s: f64) -> u64 {
        let since_s = time_s - self.first_s.unwrap_or(time_s);
        // Saturates at 0; at most 1e16.
        self.stamp_us = self.stamp_us.max((1e6 * since_s).round() as u64);
        self.stamp_us
    }
}
