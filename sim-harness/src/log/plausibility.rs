//! Whether a drive's numbers can be in the units that they claim.
//!
//! Wrong units are wrong by a factor of 57 or more, a robot's speeds by less: the AMiRo
//! drives at 80 mm/s and has been driven at 0.6 m/s. Too high speeds are detected by the
//! stamps of a stream, too low ones by the rows of AMiRo's text, which has no stamps but
//! comes from a bus whose numbers move by 256 um or not at all. Headings are compared with
//! the course: a robot on two wheels drives along its heading, forward or backward.
//!
//! A robot that stands is legal with any readings, and so is a drive of few rows. A drive
//! that looks the same in both units passes: a straight drive along x has the heading 0
//! in all of them, and a drive of less than a metre from the origin stands at 0 in whole
//! metres.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use amiro_ipf::model::{SENSORS, Sample};
use amiro_ipf::node::Input;

use super::Format;
use super::percentile::Percentile;

/// Poses, and windows of time, below which nothing is judged.
const FEWEST: usize = 10;
/// Speed that half of a drive does not exceed, metres per second: three times the AMiRo's.
const MOST_SPEED: f64 = 2.0;
/// The paper's speed, metres per second: the unit with the nearest speed is suggested.
const USUAL_SPEED: f64 = 0.08;
/// Between two frames of the odometry, and so about between two rows, seconds.
const ROW_S: f64 = 0.063;
/// Time over which a stream's speed is taken, so that late poses do not look fast.
const WINDOW_US: u64 = 250_000;
/// Longest such time: beyond it a gap in the recording is no speed.
const MOST_WINDOW_US: u64 = 1_000_000;
/// Half the bus's step of 256 um, metres.
const HALF_STEP_M: f64 = 128e-6;
/// Counts by which a sensor's noise of 4.6 does not change a reading.
const LEAST_CHANGE: i32 = 30;
/// Length of a piece of path whose course is compared with the heading, metres.
const CHORD_M: f64 = 0.02;
/// Pieces of path below which headings are not judged.
const FEWEST_CHORDS: usize = 5;
/// Most mean angle between course and heading of a good recording, radians: the
/// recorded drives have 0.004 to 0.008.
const MOST_ANGLE: f64 = 0.15;

/// A pose as its source claims it to be: metres, radians not wrapped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Claimed {
    pub(super) x_m: f64,
    pub(super) y_m: f64,
    pub(super) heading_rad: f64,
}

impl Claimed {
    fn distance(&self, other: &Self) -> f64 {
        (other.x_m - self.x_m).hypot(other.y_m - self.y_m)
    }
}

/// Checks a recording's inputs one after another, in bounded memory.
#[derive(Clone, Debug)]
pub(super) enum UnitCheck {
    Speeds(SpeedCheck),
    Rows(Box<RowCheck>, MotionCheck),
}

impl UnitCheck {
    pub(super) fn new(format: Format) -> Self {
        match format {
            Format::Stream => Self::Speeds(SpeedCheck::default()),
            Format::AmiroText => Self::Rows(Box::default(), MotionCheck::default()),
        }
    }

    pub(super) fn take(&mut self, input: &Input) {
        match self {
            Self::Speeds(speeds) => speeds.take(input),
            Self::Rows(rows, motion) => {
                if let Some(row) = claimed(input) {
                    rows.take(row);
                }
                motion.take(input);
            }
        }
    }

    /// What the numbers look like, if not like what they claim.
    pub(super) fn finish(&self) -> Option<String> {
        match self {
            Self::Speeds(speeds) => speeds.finish(),
            Self::Rows(rows, motion) => rows.finish(motion.is_seen()),
        }
    }
}

/// A text's pose; its heading again from 0 to 2 pi, as the text has it.
fn claimed(input: &Input) -> Option<Claimed> {
    let Input::Odometry { pose, .. } = input else {
        return None;
    };
    let heading = f64::from(pose.heading.radians());
    // Smaller than any step of the text: rounding of a heading of 0.
    let is_right = heading < -5e-7;
    Some(Claimed {
        x_m: f64::from(pose.position.x),
        y_m: f64::from(pose.position.y),
        heading_rad: if is_right { heading + TAU } else { heading },
    })
}

/// Whether a sensor's readings change.
#[derive(Clone, Debug, Default)]
pub(super) struct MotionCheck {
    range: [Option<(i32, i32)>; SENSORS],
}

impl MotionCheck {
    fn take(&mut self, input: &Input) {
        let Input::Proximity { samples, .. } = input else {
            return;
        };
        for (range, sample) in self.range.iter_mut().zip(samples) {
            if let Sample::Counts(counts) = *sample {
                let (least, most) = range.unwrap_or((counts, counts));
                *range = Some((least.min(counts), most.max(counts)));
            }
        }
    }

    fn is_seen(&self) -> bool {
        let changes = |(least, most): &(i32, i32)| most.abs_diff(*least) > LEAST_CHANGE as u32;
        self.range.iter().flatten().any(changes)
    }
}

/// Possible units of length: metres each, and the name.
const LENGTHS: [(f64, &str); 4] = [
    (1e-6, "micrometres"),
    (1e-3, "millimetres"),
    (1e-2, "centimetres"),
    (1.0, "metres"),
];

/// The unit, other than the claimed one, in which a speed is nearest to the usual one.
fn nearest_length(claimed_m: f64, claimed_speed: f64) -> &'static str {
    let strangeness = |unit_m: f64| {
        let speed = claimed_speed / claimed_m * unit_m;
        (speed / USUAL_SPEED).ln().abs()
    };
    LENGTHS
        .into_iter()
        .filter(|(unit_m, _)| (unit_m / claimed_m).ln().abs() > 1.0)
        .min_by(|a, b| strangeness(a.0).total_cmp(&strangeness(b.0)))
        .map_or("another unit", |(_, name)| name)
}

/// The speeds of a stream, by its stamps and wheels.
#[derive(Clone, Debug, Default)]
pub(super) struct SpeedCheck {
    /// Where the current window of time began.
    begin: Option<(u64, Claimed)>,
    /// Speeds, standing included.
    count: usize,
    /// Those of a robot that moves.
    moving: Percentile,
}

impl SpeedCheck {
    fn take(&mut self, input: &Input) {
        match input {
            Input::Wheels { speeds, .. } => {
                let both = f64::from(speeds.left_m_per_s) + f64::from(speeds.right_m_per_s);
                self.take_speed(0.5 * both.abs());
            }
            Input::Odometry { stamp_us, .. } => {
                if let Some(pose) = claimed(input) {
                    self.take_pose(*stamp_us, pose);
                }
            }
            _ => {}
        }
    }

    fn take_pose(&mut self, stamp_us: u64, pose: Claimed) {
        let Some((began_us, before)) = self.begin else {
            self.begin = Some((stamp_us, pose));
            return;
        };
        let time_us = stamp_us.saturating_sub(began_us);
        if time_us < WINDOW_US {
            return;
        }
        if time_us <= MOST_WINDOW_US {
            self.take_speed(before.distance(&pose) / (time_us as f64 * 1e-6));
        }
        self.begin = Some((stamp_us, pose));
    }

    fn take_speed(&mut self, speed: f64) {
        self.count += 1;
        if speed > 0.0 {
            self.moving.take(speed);
        }
    }

    fn finish(&self) -> Option<String> {
        if self.count < FEWEST {
            return None;
        }
        // Units are wrong for all of a drive, a broken bus for a part of it: half of the
        // time in which the robot moves must be too fast.
        let speed = self.moving.of(50)?;
        (speed > MOST_SPEED).then(|| {
            let unit = nearest_length(1.0, speed);
            format!(
                "positions and speeds look like {unit}: in metres the robot does {speed:.1} m/s"
            )
        })
    }
}

/// The poses of AMiRo's text, row by row.
#[derive(Clone, Debug, Default)]
pub(super) struct RowCheck {
    count: usize,
    first: Option<Claimed>,
    last: Option<Claimed>,
    /// Distances between rows, without those of 0.
    steps: Percentile,
    path_m: f64,
    most_urad: f64,
    chords: Chords,
}

impl RowCheck {
    pub(super) fn take(&mut self, row: Claimed) {
        self.count += 1;
        self.first.get_or_insert(row);
        if let Some(last) = self.last.replace(row) {
            let step = last.distance(&row);
            if step > 0.0 {
                self.steps.take(step);
                self.path_m += step;
            }
        }
        self.most_urad = self.most_urad.max(row.heading_rad * 1e6);
        self.chords.take(row);
    }

    /// What the numbers look like, if not like what they claim; `sees_motion` is whether
    /// readings change.
    pub(super) fn finish(&self, sees_motion: bool) -> Option<String> {
        if self.count < FEWEST {
            return None;
        }
        self.check_places(sees_motion)
            .or_else(|| self.check_headings())
    }

    fn check_places(&self, sees_motion: bool) -> Option<String> {
        let Some(step) = self.steps.of(90) else {
            let rim = self
                .first
                .map_or(0.0, |row| row.x_m.abs().max(row.y_m.abs()));
            let stands_within_a_step = rim > 0.0 && rim < 2.0 * HALF_STEP_M;
            return (stands_within_a_step && sees_motion).then(|| {
                let place = rim * 1e6;
                format!(
                    "X and Y look like metres: the readings change and the robot stays within \
                     {place:.0} um, less than a step of its odometry"
                )
            });
        };
        let mean = self.path_m / (self.count - 1) as f64;
        if step >= HALF_STEP_M {
            return None;
        }
        let unit = nearest_length(1e-6, mean / ROW_S);
        let step_um = step * 1e6;
        Some(format!(
            "X and Y look like {unit}: in micrometres the robot moves {step_um:.3} um a row, \
             and a step of its odometry is 256 um"
        ))
    }

    fn check_headings(&self) -> Option<String> {
        let angle = self.chords.mean_angle(0)?;
        if angle <= MOST_ANGLE {
            return None;
        }
        let (better, unit) = (1..)
            .zip(ANGLES)
            .filter(|(_, (_, turn, _, _))| self.most_urad <= *turn)
            .filter_map(|(unit, (_, _, rounding, name))| {
                let better = self.chords.mean_angle(unit)?;
                (better <= MOST_ANGLE + rounding).then_some((better, name))
            })
            .min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(format!(
            "Theta looks like {unit}: in microradians the robot looks {angle:.2} rad off its \
             course, in {unit} {better:.2}"
        ))
    }
}

/// Possible units of angle: radians each, the most of a turn in
/// them, the mean error of whole numbers, and the name.
const ANGLES: [(f64, f64, f64, &str); 3] = [
    (1e-3, 6_300.0, 0.0, "milliradians"),
    (PI / 180.0, 361.0, 0.01, "degrees"),
    // Cut to whole ones: half a radian low in the mean.
    (1.0, 7.0, 0.5, "radians"),
];

/// The angles between the course of each piece of path and the heading, in the claimed unit
/// and in each of [`ANGLES`].
#[derive(Clone, Debug, Default)]
struct Chords {
    begin: Option<Claimed>,
    count: usize,
    sums: [f64; 1 + ANGLES.len()],
}

impl Chords {
    fn take(&mut self, row: Claimed) {
        let begin = *self.begin.get_or_insert(row);
        if begin.distance(&row) < CHORD_M {
            return;
        }
        self.begin = Some(row);
        self.count += 1;
        let course = (row.y_m - begin.y_m).atan2(row.x_m - begin.x_m);
        let scales = core::iter::once(1.0).chain(ANGLES.map(|(unit_rad, ..)| unit_rad / 1e-6));
        for (sum, scale) in self.sums.iter_mut().zip(scales) {
            let turn = wrapped((row.heading_rad - begin.heading_rad) * scale, TAU);
            let heading = begin.heading_rad * scale + 0.5 * turn;
            // Backward driving is along the course too.
            *sum += wrapped(course - heading, PI).abs().min(FRAC_PI_2);
        }
    }

    /// The mean angle in the claimed unit, 0, or in one of [`ANGLES`], from 1; `None` when
    /// there are too few.
    fn mean_angle(&self, unit: usize) -> Option<f64> {
        let sum = self.sums.get(unit)?;
        (self.count >= FEWEST_CHORDS).then(|| sum / self.count as f64)
    }
}

/// The angle nearest to zero that differs by whole periods.
fn wrapped(angle: f64, period: f64) -> f64 {
    angle - (angle / period).round() * period
}
