//! What single precision costs the tracker: its fit against the same in double precision.
//!
//! The twin has the tracker's readings, poses, priors and table, and computes everything that
//! an iteration makes of them in `f64`: places of the sensors, law, derivatives, equations.

use std::vec::Vec;

use crate::filter::segments::fit::SegmentFit;
use crate::filter::segments::linear::{COORDINATES, System};
use crate::filter::segments::segment::{Prior, TrackedSegment};
use crate::filter::segments::tests::samples;
use crate::filter::segments::window::StepReadings;
use crate::filter::segments::{SegmentModel, SegmentParameters, SegmentTracker};
use crate::geometry::{Point, Pose};
use crate::model::{Mount, Photometry, Ring, SENSORS, Sample, TabulatedWallLaw, Wall};
use crate::random::{Generator, standard_normal_pair};

type Vector = [f64; 2];
type Wall64 = [Vector; 2];

/// Damping of both, that of the iteration of a short step.
const DAMPING: f64 = 1e-2;

fn vector(point: Point) -> Vector {
    [f64::from(point.x), f64::from(point.y)]
}

fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1]]
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn norm(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// A vector turned by the angle whose cosine and sine are given.
fn turned(a: Vector, [c, s]: Vector) -> Vector {
    [c * a[0] - s * a[1], s * a[0] + c * a[1]]
}

/// A wall as a sensor sees it, its ends in the order of their bearings.
struct Sight64 {
    wall: usize,
    is_swapped: bool,
    ends: Wall64,
    normal: Vector,
    distance: f64,
    half_tangents: [f64; 2],
    is_clipped: [bool; 2],
}

impl Sight64 {
    fn of(wall: usize, [a, b]: Wall64, max: f64) -> Option<Self> {
        let cross = a[0] * b[1] - a[1] * b[0];
        let is_swapped = cross < 0.0;
        let ends = if is_swapped { [b, a] } else { [a, b] };
        let [from, to] = ends;
        let length = norm(minus(to, from));
        let [first, last] = ends.map(|end| {
            if end[0] > 0.0 {
                end[1] / (norm(end) + end[0])
            } else {
                1e3_f64.copysign(end[1])
            }
        });
        let (is_clipped, half_tangents) = if last >= first {
            ([first < -max, last > max], [first.max(-max), last.min(max)])
        } else if first < max {
            ([false, true], [first, max])
        } else {
            ([true, false], [-max, last])
        };
        let along = minus(to, from).map(|it| it / length);
        let distance = cross.abs() / length;
        let is_between = dot(from, along) < 0.0 && dot(to, along) > 0.0;
        let is_in_view = half_tangents[1] - half_tangents[0] > 1e-6;
        (is_in_view && (distance >= 0.004 || is_between)).then(|| Self {
            wall,
            is_swapped,
            ends,
            normal: [along[1], -along[0]],
            distance: distance.max(0.004),
            half_tangents,
            is_clipped,
        })
    }

    fn inverse_range(&self, u: f64) -> f64 {
        ((1.0 - u * u) * self.normal[0] + 2.0 * u * self.normal[1]) / self.distance
    }

    /// The integrals of the table combined for the wall's normal.
    fn share(&self, integrals: [f64; 4]) -> f64 {
        let [c, s] = self.normal;
        let powers = [c * c * c, c * c * s, c * s * s, s * s * s];
        (0..4).map(|it| integrals[it] * powers[it]).sum()
    }
}

/// A piece of the lobe with its nearest wall.
struct Interval64 {
    sight: usize,
    bounds: [f64; 2],
}

/// The tracker's law with the same table: `TabulatedWallLaw::signal_and_gradient`.
struct Law64<'l>(&'l TabulatedWallLaw);

impl Law64<'_> {
    /// The integrals at tan(t / 2), and their slopes there.
    fn look_up(&self, u: f64) -> ([f64; 4], [f64; 4]) {
        let (table, max, _) = self.0.parts();
        let pieces_per_tangent = (table.len() - 1) as f64 / f64::from(max);
        let place = u.abs() * pieces_per_tangent;
        let index = (place as usize).min(table.len() - 2);
        let share = place - index as f64;
        let sign = if u < 0.0 { -1.0 } else { 1.0 };
        let (mut values, mut slopes) = ([0.0; 4], [0.0; 4]);
        for power in 0..4 {
            let [near, far] = [index, index + 1].map(|at| f64::from(table[at][power]));
            let value = near + share * (far - near);
            let slope = pieces_per_tangent * (far - near);
            let is_odd = power % 2 == 0;
            values[power] = if is_odd { sign * value } else { value };
            slopes[power] = if is_odd { slope } else { sign * slope };
        }
        (values, slopes)
    }

    fn scale(&self, sight: &Sight64) -> f64 {
        let (_, _, alpha) = self.0.parts();
        f64::from(alpha) / (sight.distance * sight.distance)
    }

    fn split(sights: &[Sight64]) -> Vec<Interval64> {
        let mut cuts: Vec<f64> = sights.iter().flat_map(|it| it.half_tangents).collect();
        cuts.sort_by(f64::total_cmp);
        let mut intervals: Vec<Interval64> = Vec::new();
        for cut in cuts.windows(2).filter(|cut| cut[1] - cut[0] > 1e-6) {
            let middle = 0.5 * (cut[0] + cut[1]);
            let is_here =
                |it: &Sight64| it.half_tangents[0] < middle && middle < it.half_tangents[1];
            let here = sights.iter().enumerate().filter(|(_, it)| is_here(it));
            let nearest = here.max_by(|(_, a), (_, b)| {
                a.inverse_range(middle).total_cmp(&b.inverse_range(middle))
            });
            let Some((sight, _)) = nearest else { continue };
            match intervals.last_mut() {
                Some(last) if last.sight == sight && cut[0] - last.bounds[1] <= 1e-6 => {
                    last.bounds[1] = cut[1];
                }
                _ => intervals.push(Interval64 {
                    sight,
                    bounds: [cut[0], cut[1]],
                }),
            }
        }
        intervals
    }

    fn signal_and_gradient(&self, walls: &[Wall64]) -> (f64, Vec<Wall64>) {
        let (_, max, _) = self.0.parts();
        let sights = walls.iter().enumerate();
        let sights = sights.filter_map(|(index, wall)| Sight64::of(index, *wall, f64::from(max)));
        let sights: Vec<_> = sights.collect();
        let intervals = Self::split(&sights);
        let (mut sum, mut gradient) = (0.0, std::vec![[[0.0; 2]; 2]; walls.len()]);
        for (index, interval) in intervals.iter().enumerate() {
            let sight = &sights[interval.sight];
            let (signal, mut ends) = self.interval(sight, interval);
            sum += signal;
            let before = index.checked_sub(1).map(|it| &intervals[it]);
            let after = intervals.get(index + 1);
            let behind = [
                before.filter(|before| before.bounds[1] >= interval.bounds[0]),
                after.filter(|after| after.bounds[0] <= interval.bounds[1]),
            ];
            for (end, behind) in behind.into_iter().enumerate() {
                let behind = behind.map(|behind| &sights[behind.sight]);
                self.add_end(sight, interval, end, behind, &mut ends);
            }
            if sight.is_swapped {
                ends.reverse();
            }
            for (own, end) in gradient[sight.wall]
                .as_flattened_mut()
                .iter_mut()
                .zip(ends.as_flattened())
            {
                *own += end;
            }
        }
        (sum, gradient)
    }

    /// The signal of an interval between fixed bearings, and its derivatives.
    fn interval(&self, sight: &Sight64, interval: &Interval64) -> (f64, Wall64) {
        let [near, far] = interval.bounds.map(|it| self.look_up(it).0);
        let i: [f64; 4] = core::array::from_fn(|it| far[it] - near[it]);
        let scale = self.scale(sight);
        let signal = scale * sight.share(i).max(0.0);
        let [c, s] = sight.normal;
        let per_turn = scale
            * (-3.0 * i[0] * c * c * s
                + i[1] * (c * c * c - 2.0 * c * s * s)
                + i[2] * (2.0 * c * c * s - s * s * s)
                + 3.0 * i[3] * c * s * s);
        let per_distance = -2.0 * signal / sight.distance;
        let [a, b] = sight.ends.map(|end| dot(end, [-s, c]));
        let of_first = (per_distance * b + per_turn) / (b - a);
        let of_last = (-per_distance * a - per_turn) / (b - a);
        let ends = [of_first, of_last].map(|factor| sight.normal.map(|it| factor * it));
        (signal, ends)
    }

    fn add_end(
        &self,
        sight: &Sight64,
        interval: &Interval64,
        end: usize,
        neighbour: Option<&Sight64>,
        ends: &mut Wall64,
    ) {
        let own = sight.half_tangents[end];
        if sight.is_clipped[end] || (interval.bounds[end] - own).abs() > 1e-6 {
            return;
        }
        let (_, slopes) = self.look_up(own);
        let density = |sight: &Sight64| self.scale(sight) * sight.share(slopes).max(0.0);
        let uncovered = neighbour
            .filter(|other| other.inverse_range(own) < sight.inverse_range(own))
            .map_or(0.0, density);
        let sign = if end == 0 { -1.0 } else { 1.0 };
        let place = sight.ends[end];
        let factor =
            sign * (density(sight) - uncovered) * 0.5 * (1.0 + own * own) / dot(place, place);
        ends[end] = [
            ends[end][0] - place[1] * factor,
            ends[end][1] + place[0] * factor,
        ];
    }
}

/// The unknowns of a fit: the ends of the segments that are not frozen.
struct Fit64<'f> {
    model: &'f SegmentModel,
    rows: &'f [StepReadings],
    segments: Vec<&'f TrackedSegment>,
    ends: Vec<Wall64>,
}

impl<'f> Fit64<'f> {
    fn of(model: &'f SegmentModel, rows: &'f [StepReadings], all: &'f [TrackedSegment]) -> Self {
        let segments: Vec<_> = all.iter().filter(|it| !it.is_frozen).collect();
        Self {
            model,
            rows,
            ends: segments.iter().map(|it| it.ends.map(vector)).collect(),
            segments,
        }
    }

    /// The signal of a sensor, and its derivatives for the coordinates along and across the
    /// segments' priors.
    fn predicted(&self, row: &StepReadings, mount: &Mount) -> (f64, Vec<f64>) {
        let [heading, axis] =
            [row.heading, mount.direction].map(|it| [f64::from(it.cosine), f64::from(it.sine)]);
        let offset = turned(vector(mount.position), heading);
        let centre = vector(row.position);
        let position = [centre[0] + offset[0], centre[1] + offset[1]];
        let [c, s] = turned(axis, heading);
        let see = |wall: &Wall64| wall.map(|end| turned(minus(end, position), [c, -s]));
        let seen: Vec<Wall64> = self.ends.iter().map(see).collect();
        let (signal, gradient) = Law64(self.model.law()).signal_and_gradient(&seen);
        let slopes = self
            .segments
            .iter()
            .zip(gradient)
            .flat_map(|(segment, ends)| {
                let [along, across] = vector(segment.prior.along);
                let local = ends.map(|end| turned(turned(end, [c, s]), [along, -across]));
                local.as_flattened().to_vec()
            });
        (signal, slopes.collect())
    }

    /// One Gauss-Newton iteration.
    fn follow(&mut self) {
        let parameters = &self.model.parameters;
        let n = COORDINATES * self.segments.len();
        let (mut h, mut b) = (std::vec![std::vec![0.0; n]; n], std::vec![0.0; n]);
        let mut add = |first: usize, slopes: &[f64], residual: f64, weight: f64| {
            for (i, own) in slopes.iter().enumerate() {
                b[first + i] -= weight * own * residual;
                for (j, other) in slopes.iter().enumerate() {
                    h[first + i][first + j] += weight * own * other;
                }
            }
        };
        for row in self.rows {
            for (mount, measured) in self.model.mounts.iter().zip(&row.measured) {
                let inverse_sigma = f64::from(measured.inverse_sigma);
                if inverse_sigma <= 0.0 {
                    continue;
                }
                let (signal, mut slopes) = self.predicted(row, mount);
                let lifted = signal + f64::from(parameters.soft_counts);
                let residual = (f64::from(measured.log_signal) - lifted.ln()) * inverse_sigma;
                for slope in &mut slopes {
                    *slope *= -inverse_sigma / lifted;
                }
                let limit = f64::from(parameters.huber);
                let weight = (limit / residual.abs()).min(1.0);
                add(0, &slopes, residual, weight);
            }
        }
        let sigma = f64::from(parameters.length_sigma_m);
        for (index, (segment, [from, to])) in self.segments.iter().zip(&self.ends).enumerate() {
            let way = minus(*to, *from);
            let residual = (norm(way) - f64::from(parameters.length_m)) / sigma;
            let [along, across] = vector(segment.prior.along);
            let [x, y] = turned(way, [along, -across]).map(|it| it / (norm(way) * sigma));
            add(COORDINATES * index, &[-x, -y, x, y], residual, 1.0);
        }
        for (index, segment) in self.segments.iter().enumerate() {
            let deviation = deviation(&segment.prior, &self.ends[index]);
            for i in 0..COORDINATES {
                let at = COORDINATES * index + i;
                b[at] += f64::from(segment.prior.pull[i]);
                for (j, deviation) in deviation.iter().enumerate() {
                    let information = f64::from(segment.prior.information[(i, j)]);
                    h[at][COORDINATES * index + j] += information;
                    b[at] -= information * deviation;
                }
            }
        }
        for (i, row) in h.iter_mut().enumerate() {
            row[i] *= 1.0 + DAMPING;
        }
        self.apply(&solved(h, b));
    }

    fn apply(&mut self, step: &[f64]) {
        let most = f64::from(self.model.parameters.most_move_m);
        for (index, segment) in self.segments.iter().enumerate() {
            let [c, s] = vector(segment.prior.along);
            for (place, end) in self.ends[index].iter_mut().enumerate() {
                let at = COORDINATES * index + 2 * place;
                let step = turned([step[at], step[at + 1]], [c, s]);
                let factor = (most / norm(step)).min(1.0);
                *end = [end[0] + factor * step[0], end[1] + factor * step[1]];
            }
        }
    }
}

fn deviation(prior: &Prior, ends: &Wall64) -> [f64; COORDINATES] {
    let [c, s] = vector(prior.along);
    let [a, b] = [0, 1].map(|it| {
        let off = minus(ends[it], vector(prior.reference[it]));
        turned(off, [c, -s])
    });
    [a[0], a[1], b[0], b[1]]
}

/// The solution of symmetric positive equations, by elimination.
fn solved(mut h: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for i in 0..n {
        let (above, below) = h.split_at_mut(i + 1);
        let pivots = &above[i];
        for (k, row) in below.iter_mut().enumerate() {
            let factor = row[i] / pivots[i];
            for (entry, pivot) in row.iter_mut().zip(pivots) {
                *entry -= factor * pivot;
            }
            b[i + 1 + k] -= factor * b[i];
        }
    }
    for i in (0..n).rev() {
        let rest: f64 = (i + 1..n).map(|j| h[i][j] * b[j]).sum();
        b[i] = (b[i] - rest) / h[i][i];
    }
    b
}

/// Differences of the ends after one iteration from the same place with the same readings
/// and priors, metres: of every end that the tracker has after a step.
fn differences(model: &SegmentModel, tracker: &SegmentTracker) -> Vec<f64> {
    let rows = tracker.rows();
    let mut twin = Fit64::of(model, rows, tracker.segments());
    let mut single = tracker.segments().to_vec();
    let fit = SegmentFit { model, rows };
    let mut system = System::new();
    fit.follow(&mut single, &mut system);
    twin.follow();
    let single = single.iter().filter(|it| !it.is_frozen);
    let pairs = single.zip(&twin.ends);
    pairs
        .flat_map(|(single, twin)| [0, 1].map(|it| norm(minus(vector(single.ends[it]), twin[it]))))
        .collect()
}

/// Differences over a drive, sorted.
fn of_drive(
    model: &SegmentModel,
    drive: impl Iterator<Item = (Pose, [Sample; SENSORS])>,
) -> Vec<f64> {
    let mut tracker = SegmentTracker::new();
    let mut last: Option<Pose> = None;
    let mut all = Vec::new();
    for (pose, samples) in drive {
        let motion = last.unwrap_or(pose).motion_to(&pose);
        tracker.step(model, &motion, &samples, &mut |_| {});
        all.extend(differences(model, &tracker));
        last = Some(pose);
    }
    all.sort_by(f64::total_cmp);
    all
}

/// A drive up the stem of a T of walls 200 mm apart, a turn in place, and out along its bar.
fn t_maze(law: &TabulatedWallLaw, seed: u64) -> impl Iterator<Item = (Pose, [Sample; SENSORS])> {
    let wall = |x0, y0, x1, y1| [Point::new(x0, y0), Point::new(x1, y1)];
    let walls: [Wall; 5] = [
        wall(-0.1, 0.1, 0.5, 0.1),
        wall(-0.1, -0.1, 0.5, -0.1),
        wall(0.5, 0.1, 0.5, 0.6),
        wall(0.5, -0.6, 0.5, -0.1),
        wall(0.7, -0.6, 0.7, 0.6),
    ];
    let right = core::f32::consts::FRAC_PI_2;
    let stem = (0..=60).map(|step| Pose::new(0.01 * step as f32, 0.0, 0.0));
    let turn = (1..=9).map(move |step| Pose::new(0.6, 0.0, -right * step as f32 / 9.0));
    let bar = (1..=45).map(move |step| Pose::new(0.6, -0.01 * step as f32, -right));
    let mut generator = Generator::seeded(seed);
    let law = law.clone();
    stem.chain(turn).chain(bar).map(move |pose| {
        let noisy = samples(&law, &walls, &pose).map(|sample| match sample {
            Sample::Counts(counts) => {
                let noise = 4.57 * standard_normal_pair(&mut generator).0;
                Sample::Counts(counts + crate::math::round_to_i32(noise))
            }
            other => other,
        });
        (pose, noisy)
    })
}

#[test]
fn single_precision_moves_the_ends_of_segments_by_a_micrometre() {
    let sensor = &Photometry::VCNL4020;
    let model = SegmentModel::new(SegmentParameters::STEPS, sensor, &Ring::AMIRO);
    for seed in 1..=3 {
        let all = of_drive(&model, t_maze(model.law(), seed));
        let [median_um, most_um] = [all.len() / 2, all.len() - 1].map(|it| 1e6 * all[it]);
        let story = format!(
            "seed {seed}: {} ends, {median_um} um, {most_um} um",
            all.len()
        );
        assert!(all.len() > 500, "{story}");
        // 0.011 and 0.95 um at most of the three; the readings determine an end to 0.3 mm and
        // worse.
        assert!(median_um < 0.05 && most_um < 5.0, "{story}");
        // The same numbers in single precision would differ by nothing.
        assert!(most_um > 0.01, "{story}");
    }
}
