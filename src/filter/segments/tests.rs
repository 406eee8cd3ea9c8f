//! Tests of the tracker as a whole.

use super::*;
use crate::geometry::{Motion, Point, Pose, Rotation};
use crate::model::{Photometry, Ring, SENSORS, Sample, TabulatedWallLaw, Wall, evaluations};

const SENSOR: Photometry = Photometry::VCNL4020;

pub(super) fn samples(law: &TabulatedWallLaw, walls: &[Wall], pose: &Pose) -> [Sample; SENSORS] {
    let body = Rotation::by(pose.heading.radians()).inverse();
    core::array::from_fn(|sensor| {
        let mount = Ring::AMIRO.mount(sensor);
        let seen: std::vec::Vec<Wall> = walls
            .iter()
            .map(|wall| wall.map(|end| mount.sensor_from_body((end - pose.position).rotated(body))))
            .collect();
        Sample::Counts(crate::math::round_to_i32(
            law.signal(&seen) + law.beta_counts(),
        ))
    })
}

/// Drives along poses and returns the walls that were tracked at the end, in the world.
fn track(
    model: &SegmentModel,
    walls: &[Wall],
    poses: &[Pose],
) -> (SegmentTracker, std::vec::Vec<Wall>) {
    let mut tracker = SegmentTracker::new();
    let mut last = poses[0];
    for pose in poses {
        let readings = samples(model.law(), walls, pose);
        tracker.step(model, &last.motion_to(pose), &readings, &mut |_| {});
        last = *pose;
    }
    let world = |segment: &TrackedSegment| {
        segment
            .ends()
            .map(|end| last.world_from_body(tracker.body_from_track(end)))
    };
    let walls = tracker.segments().iter().map(world).collect();
    (tracker, walls)
}

fn line_distance([a, b]: &Wall, place: Point) -> f32 {
    let way = *b - *a;
    ((place.x - a.x) * way.y - (place.y - a.y) * way.x).abs() / way.norm()
}

#[test]
fn an_l_shaped_room_without_noise_is_tracked_to_a_millimetre() {
    let model = SegmentModel::new(SegmentParameters::STEPS, &SENSOR, &Ring::AMIRO);
    let walls = [
        [Point::new(0.0, 0.10), Point::new(0.5, 0.10)],
        [Point::new(0.5, -0.40), Point::new(0.5, 0.10)],
    ];
    // Along the one wall, round the corner, along the other.
    let right = core::f32::consts::FRAC_PI_2;
    let poses: std::vec::Vec<Pose> = (0..=35)
        .map(|step| Pose::new(0.05 + 0.01 * step as f32, 0.0, 0.0))
        .chain((1..=9).map(|step| Pose::new(0.4, 0.0, -right * step as f32 / 9.0)))
        .chain((1..=30).map(|step| Pose::new(0.4, -0.01 * step as f32, -right)))
        .collect();
    let (_, found) = track(&model, &walls, &poses);
    for wall in &walls {
        // The middle third of each wall lies on a segment.
        for share in [0.34, 0.5, 0.66] {
            let [a, b] = *wall;
            let place = a + Point::new(share * (b.x - a.x), share * (b.y - a.y));
            let nearest = found
                .iter()
                .filter(|found| {
                    segment::distance_m(&found.map(|end| end - place), Point::default()) < 0.01
                })
                .map(|found| line_distance(found, place))
                .fold(f32::INFINITY, f32::min);
            assert!(nearest < 1e-3, "{wall:?} at {share}: {nearest}; {found:?}");
        }
    }
}

#[test]
fn both_ends_of_a_wall_that_was_passed_are_found() {
    let model = SegmentModel::new(SegmentParameters::STEPS, &SENSOR, &Ring::AMIRO);
    let walls = [[Point::new(0.2, -0.11), Point::new(0.5, -0.09)]];
    let poses: std::vec::Vec<Pose> = (0..=60)
        .map(|step| Pose::new(0.01 * step as f32, 0.0, 0.0))
        .collect();
    let (tracker, found) = track(&model, &walls, &poses);
    assert_eq!(found.len(), 1, "{found:?}");
    for end in walls[0] {
        let off = found[0].iter().map(|other| (*other - end).norm());
        let off = off.fold(f32::INFINITY, f32::min);
        assert!(off < 3e-3, "{end:?}: {found:?}");
    }
    let segment = &tracker.segments()[0];
    assert!(segment.evidence() > 100.0, "{segment:?}");
    for coordinate in 0..4 {
        let variance = segment.covariance()[(coordinate, coordinate)];
        assert!(variance > 0.0 && variance < 1e-2, "{variance}");
    }
}

#[test]
fn nothing_is_tracked_where_nothing_is_seen() {
    let model = SegmentModel::new(SegmentParameters::STEPS, &SENSOR, &Ring::AMIRO);
    let mut tracker = SegmentTracker::new();
    let motion = Motion {
        displacement: Point::new(0.01, 0.0),
        ..Motion::NONE
    };
    for step in 0..100 {
        let dark = core::array::from_fn(|sensor| {
            Sample::Counts(-16 + ((step * 7 + sensor as i32 * 5) % 11) - 5)
        });
        tracker.step(&model, &motion, &dark, &mut |_| {});
    }
    assert!(tracker.segments().is_empty(), "{:?}", tracker.segments());
}

#[test]
fn sensors_without_counts_are_left_out() {
    let model = SegmentModel::new(SegmentParameters::STEPS, &SENSOR, &Ring::AMIRO);
    let walls = [[Point::new(0.0, 0.10), Point::new(0.6, 0.10)]];
    let mut tracker = SegmentTracker::new();
    let mut last = Pose::default();
    for step in 0..40 {
        let pose = Pose::new(0.1 + 0.01 * step as f32, 0.0, 0.0);
        let mut readings = samples(model.law(), &walls, &pose);
        readings[1] = Sample::Missing;
        readings[5] = Sample::Saturated;
        tracker.step(&model, &last.motion_to(&pose), &readings, &mut |_| {});
        last = pose;
    }
    let place = Point::new(last.position.x, 0.10) - last.position;
    let near = tracker.segments().iter().any(|segment| {
        segment::distance_m(&segment.ends().map(|end| end - place), Point::default()) < 5e-3
    });
    assert!(near, "{:?}", tracker.segments());
}

#[test]
fn hostile_steps_leave_a_finite_state() {
    let model = SegmentModel::new(SegmentParameters::STEPS, &SENSOR, &Ring::AMIRO);
    let mut generator = crate::random::Generator::seeded(5);
    let mut tracker = SegmentTracker::new();
    for step in 0..600_u32 {
        let samples = core::array::from_fn(|_| match generator.bits() % 6 {
            0 => Sample::Missing,
            1 => Sample::Saturated,
            2 => Sample::Counts(i32::MAX - (generator.bits() % 3) as i32),
            3 => Sample::Counts(i32::MIN + (generator.bits() % 3) as i32),
            4 => Sample::Counts((generator.bits() % 70_000) as i32 - 100),
            _ => Sample::Counts((generator.bits() % 400) as i32 - 40),
        });
        let displacement = match step % 23 {
            5 => Point::new(f32::NAN, 0.0),
            9 => Point::new(0.0, f32::INFINITY),
            13 => Point::new(3e30, -3e30),
            17 => Point::new(0.45, 0.0),
            _ => Point::new(0.01, 0.0),
        };
        let turn = if step % 31 == 7 { f32::NAN } else { 0.3 };
        let motion = Motion {
            displacement,
            turn: crate::geometry::Angle::from_radians(turn),
        };
        tracker.step(&model, &motion, &samples, &mut |_| {});
        for segment in tracker.segments() {
            let is_finite = segment.ends().iter().all(|end| end.norm().is_finite());
            assert!(is_finite, "step {step}: {segment:?}");
            assert!(segment.evidence().is_finite(), "step {step}: {segment:?}");
        }
    }
}

#[test]
fn of_a_wall_that_is_gone_no_more_than_a_stub_stays() {
    let model = SegmentModel::new(SegmentParameters::STEPS, &SENSOR, &Ring::AMIRO);
    let walls = [[Point::new(0.0, 0.10), Point::new(0.3, 0.10)]];
    let mut tracker = SegmentTracker::new();
    let mut most = 0;
    let mut last = Pose::default();
    for step in 0..60 {
        let pose = Pose::new(0.1, 0.003 * (step % 2) as f32, 0.0);
        let seen: &[Wall] = if step < 10 { &walls } else { &[] };
        let readings = samples(model.law(), seen, &pose);
        tracker.step(&model, &last.motion_to(&pose), &readings, &mut |_| {});
        most = most.max(tracker.segments().len());
        last = pose;
    }
    let longest = tracker.segments().iter().map(TrackedSegment::length_m);
    let longest = longest.fold(0.0, f32::max);
    assert!(most > 0 && longest < 0.03, "{tracker:?}");
}

#[test]
fn the_same_steps_give_the_same_bits() {
    let model = SegmentModel::new(SegmentParameters::STEPS, &SENSOR, &Ring::AMIRO);
    let walls = [[Point::new(0.0, 0.10), Point::new(0.6, 0.12)]];
    let poses: std::vec::Vec<Pose> = (0..=40)
        .map(|step| Pose::new(0.01 * step as f32, 0.0, 0.02))
        .collect();
    let first = track(&model, &walls, &poses).1;
    assert_eq!(first, track(&model, &walls, &poses).1);
}

/// Readings and motions of all kinds.
fn hostile_step(generator: &mut crate::random::Generator) -> (Motion, [Sample; SENSORS]) {
    let samples = core::array::from_fn(|_| match generator.bits() % 8 {
        0 => Sample::Missing,
        1 => Sample::Counts(generator.bits() as i32),
        2 => Sample::Counts((generator.bits() % 70_000) as i32),
        _ => Sample::Counts((generator.bits() % 900) as i32 - 30),
    });
    let part = |bits: u32| (bits % 201) as f32 - 100.0;
    let motion = Motion {
        displacement: Point::new(2e-4 * part(generator.bits()), 2e-4 * part(generator.bits())),
        turn: crate::geometry::Angle::from_radians(3e-3 * part(generator.bits())),
    };
    (motion, samples)
}

#[test]
fn a_step_evaluates_the_law_no_more_often_than_its_stages_allow() {
    const READINGS: usize = MAX_WINDOW * SENSORS;
    const ALL: usize = READINGS * MAX_SEGMENTS;
    let parameters = SegmentParameters::STEPS;
    // Iterations after the first equations take two each at most.
    let fit = |iterations: u8| (1 + 2 * usize::from(iterations)) * ALL;
    let fold = SENSORS * MAX_SEGMENTS * MAX_SEGMENTS;
    let gains = ALL * MAX_SEGMENTS;
    let merge = fit(3) + 2 * ALL;
    let rank = ALL + 3 * SENSORS * MAX_SEGMENTS + 84 * (4 + READINGS);
    let alone = ALL + 3 * fit(parameters.birth_iterations);
    let join = ALL + fit(6);
    let most = fold + fit(parameters.iterations) + gains + merge.max(rank).max(alone).max(join);
    let model = SegmentModel::new(parameters, &SENSOR, &Ring::AMIRO);
    let mut largest = 0;
    for seed in 0..4 {
        let mut generator = crate::random::Generator::seeded(seed);
        let mut tracker = SegmentTracker::new();
        for step in 0..400 {
            let (motion, samples) = hostile_step(&mut generator);
            let _ = evaluations::take();
            tracker.step(&model, &motion, &samples, &mut |_| {});
            let walls = evaluations::take();
            largest = largest.max(walls);
            assert!(walls <= most, "seed {seed}, step {step}: {walls} of {most}");
        }
    }
    assert!(
        largest > most / 10,
        "the bound says nothing: {largest} of {most}"
    );
}

#[test]
fn the_tracker_takes_at_most_six_kibibytes() {
    let bytes = core::mem::size_of::<SegmentTracker>();
    assert!(bytes <= 6 * 1024, "{bytes}");
}

#[test]
fn a_window_of_equal_poses_gives_one_finite_wall() {
    let model = SegmentModel::new(SegmentParameters::STEPS, &SENSOR, &Ring::AMIRO);
    let walls = [[Point::new(-0.3, 0.10), Point::new(0.3, 0.10)]];
    let mut tracker = SegmentTracker::new();
    let readings = samples(model.law(), &walls, &Pose::default());
    for step in 0..40 {
        // Turns to and fro, so that each row is kept, by so little that poses are equal.
        let motion = Motion {
            turn: crate::geometry::Angle::from_radians(if step % 2 == 0 { 0.02 } else { -0.02 }),
            ..Motion::NONE
        };
        tracker.step(&model, &motion, &readings, &mut |_| {});
    }
    for segment in tracker.segments() {
        assert!(
            line_distance(&segment.ends(), Point::new(0.0, 0.10)) < 0.01,
            "{segment:?}"
        );
        assert!(segment.covariance().iter().all(|entry| entry.is_finite()));
    }
    assert!(!tracker.segments().is_empty());
}

#[test]
fn a_segment_that_no_longer_fits_is_dropped_and_not_dragged() {
    let model = SegmentModel::new(SegmentParameters::STEPS, &SENSOR, &Ring::AMIRO);
    let walls = [[Point::new(-1.0, 0.10), Point::new(3.0, 0.10)]];
    let mut tracker = SegmentTracker::new();
    // The odometry turns by 10 degrees per metre; the robot drives straight on.
    let motion = Motion {
        displacement: Point::new(0.01, 0.0),
        turn: crate::geometry::Angle::from_radians(0.1_f32.to_radians()),
    };
    let mut steps_with_wall = 0;
    let mut wrong_for = 0;
    for step in 0..150 {
        let pose = Pose::new(0.01 * step as f32, 0.0, 0.0);
        let readings = samples(model.law(), &walls, &pose);
        tracker.step(&model, &motion, &readings, &mut |_| {});
        if step < 20 {
            continue;
        }
        // A segment beside the robot that is not where the wall is now.
        let (mut right, mut wrong) = (0, 0);
        for segment in tracker.segments() {
            let [a, b] = segment.ends().map(|end| tracker.body_from_track(end));
            if a.x.min(b.x) < 0.0 && a.x.max(b.x) > 0.0 && a.y + b.y > 0.0 {
                let y = a.y + (b.y - a.y) * (-a.x) / (b.x - a.x);
                let is_right = (y - 0.10).abs() < 0.025;
                right += usize::from(is_right);
                wrong += usize::from(!is_right);
            }
        }
        wrong_for = if wrong > 0 { wrong_for + 1 } else { 0 };
        assert!(wrong_for <= 10, "step {step}: {:?}", tracker.segments());
        steps_with_wall += usize::from(right > 0);
    }
    assert!(steps_with_wall > 100, "{steps_with_wall} of 130");
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig {
        // Every case is 60 steps.
        cases: if cfg!(miri) { 1 } else { 40 },
        failure_persistence: None,
        ..proptest::prelude::ProptestConfig::default()
    })]

    #[test]
    fn no_samples_make_a_number_that_is_none(seed in proptest::prelude::any::<u64>()) {
        let model = SegmentModel::new(SegmentParameters::STEPS, &SENSOR, &Ring::AMIRO);
        let mut generator = crate::random::Generator::seeded(seed);
        let mut tracker = SegmentTracker::new();
        for step in 0..60 {
            let (motion, samples) = hostile_step(&mut generator);
            tracker.step(&model, &motion, &samples, &mut |_| {});
            for segment in tracker.segments() {
                let [a, b] = segment.ends();
                let numbers = [a.x, a.y, b.x, b.y, segment.evidence()];
                let covariance = segment.covariance().iter();
                let is_finite = numbers.iter().chain(covariance).all(|it| it.is_finite());
                proptest::prop_assert!(is_finite, "step {step}: {segment:?}");
            }
        }
    }
}

#[test]
fn the_window_ends_after_five_steps_or_four_stations() {
    let model = SegmentModel::new(SegmentParameters::STEPS, &SENSOR, &Ring::AMIRO);
    for (step_m, rows) in [(0.01, 5), (0.03, 5), (0.05, 4), (0.2, 1)] {
        let poses: std::vec::Vec<Pose> = (0..10)
            .map(|step| Pose::new(step_m * step as f32, 0.0, 0.0))
            .collect();
        let (tracker, _) = track(&model, &[], &poses);
        assert_eq!(tracker.rows().len(), rows, "{step_m}");
    }
}
