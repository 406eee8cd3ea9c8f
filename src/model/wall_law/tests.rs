//! Tests of the law of walls against integrals in double precision.

use super::*;
use crate::random::Generator;
use rand_core::Rng;

const SENSOR: Photometry = Photometry::VCNL4020;

/// Uniform in [low, high).
fn uniform(generator: &mut Generator, low: f32, high: f32) -> f32 {
    low + (high - low) * (generator.next_u32() >> 8) as f32 / 16_777_216.0
}

/// Integral over the lobe of cos(xi t) cos(i) / r^2 of the nearest wall on each ray, by
/// the middles of so many rays, in counts; and the least perpendicular distance.
fn integral(photometry: &Photometry, walls: &[Wall], rays: u32) -> f64 {
    let xi = f64::from(photometry.xi);
    let edge = f64::from(photometry.theta_max_rad);
    let step = 2.0 * edge / f64::from(rays);
    let (mut sum, mut full) = (0.0, 0.0);
    for ray in 0..rays {
        let t = (f64::from(ray) + 0.5) * step - edge;
        full += (xi * t).cos() * t.cos().powi(3);
        let mut nearest: Option<(f64, f64)> = None;
        for [a, b] in walls {
            let (ax, ay) = (f64::from(a.x), f64::from(a.y));
            let (wx, wy) = (f64::from(b.x) - ax, f64::from(b.y) - ay);
            let determinant = t.cos() * wy - t.sin() * wx;
            let range = (ax * wy - ay * wx) / determinant;
            let share = (ax * t.sin() - ay * t.cos()) / determinant;
            if range > 0.0 && (0.0..=1.0).contains(&share) {
                let cosine = determinant.abs() / wx.hypot(wy);
                if nearest.is_none_or(|(least, _)| range < least) {
                    nearest = Some((range, cosine));
                }
            }
        }
        if let Some((range, cosine)) = nearest {
            sum += (xi * t).cos() * cosine / (range * range);
        }
    }
    f64::from(photometry.alpha_counts_m2) * sum / full
}

fn distance(&[a, b]: &Wall) -> f32 {
    (a.x * b.y - a.y * b.x).abs() / (b - a).norm()
}

impl core::ops::Sub<&Point> for &Point {
    type Output = Point;

    fn sub(self, other: &Point) -> Point {
        *self - *other
    }
}

#[test]
fn tables_are_the_integrals() {
    let law = TabulatedWallLaw::of(&SENSOR);
    let xi = f64::from(SENSOR.xi);
    let max = f64::from(law.half_tangent_max);
    let integrals = |to: f64| {
        let steps = 4000;
        let step = to / f64::from(steps);
        let mut sums = [0.0_f64; 4];
        for index in 0..steps {
            let t = (f64::from(index) + 0.5) * step;
            let (s, c) = t.sin_cos();
            let lobe = (xi * t).cos() * step;
            for (sum, term) in
                sums.iter_mut()
                    .zip([c * c * c, 3.0 * c * c * s, 3.0 * c * s * s, s * s * s])
            {
                *sum += lobe * term;
            }
        }
        sums
    };
    let full = 2.0 * integrals(2.0 * max.atan())[0];
    for (index, entry) in law.table.iter().enumerate() {
        let t = 2.0 * (max * index as f64 / PIECES as f64).atan();
        for (held, exact) in entry.iter().zip(integrals(t)) {
            let error = (f64::from(*held) - exact / full).abs();
            assert!(error < 2e-6, "entry {index}: {held}, {}", exact / full);
        }
    }
}

#[test]
fn one_wall_keeps_the_bound() {
    for xi in [1.0, 1.12, 1.236_518_5, 1.45] {
        let photometry = Photometry { xi, ..SENSOR };
        let law = TabulatedWallLaw::of(&photometry);
        let mut generator = Generator::seeded(7);
        for _ in 0..1000 {
            let mut place = || {
                let x = uniform(&mut generator, -0.1, 0.3);
                Point::new(x, uniform(&mut generator, -0.3, 0.3))
            };
            let wall = [place(), place()];
            let distance = f64::from(distance(&wall));
            if distance < 0.01 {
                continue;
            }
            let full = f64::from(SENSOR.alpha_counts_m2) / (distance * distance);
            // The rays cut the ends to half a ray of 1e-4 rad.
            let error = f64::from(law.signal(&[wall])) - integral(&photometry, &[wall], 20_000);
            assert!(
                error.abs() < 4e-4 * full,
                "xi {xi}, {wall:?}: {}",
                error / full
            );
        }
    }
}

#[test]
fn several_walls_hide_each_other() {
    let law = TabulatedWallLaw::of(&SENSOR);
    let mut generator = Generator::seeded(11);
    for _ in 0..400 {
        // Chords of rings that do not meet: no two walls cross.
        let walls: [Wall; 4] = core::array::from_fn(|index| {
            let range = 0.05 + 0.03 * index as f32;
            let place = |bearing: f32| {
                let (sine, cosine) = math::sin_cos(bearing);
                Point::new(range * cosine, range * sine)
            };
            let from = uniform(&mut generator, -1.5, 1.4);
            let width = uniform(&mut generator, 0.05, 0.7);
            [place(from), place(from + width)]
        });
        let exact = integral(&SENSOR, &walls, 20_000);
        let signal = f64::from(law.signal(&walls));
        let full = f64::from(SENSOR.alpha_counts_m2) / 0.047_f64.powi(2);
        assert!(
            (signal - exact).abs() < 1e-3 * full,
            "{walls:?}: {signal}, {exact}"
        );
        let together = law.signal_and_gradient(&walls).signal;
        assert!((f64::from(together) - signal).abs() < 1e-4 * full);
    }
}

#[test]
fn gradient_is_the_change_of_the_signal() {
    let law = TabulatedWallLaw::of(&SENSOR);
    let mut generator = Generator::seeded(3);
    let mut compared = 0;
    for _ in 0..500 {
        let mut place = |x: f32| Point::new(x, uniform(&mut generator, -0.2, 0.2));
        let near = [place(0.06), place(0.07)];
        let far = [place(0.15), place(0.17)];
        // The derivative jumps where an end passes the lobe's edge or another end.
        let mut bearings = [near, far]
            .as_flattened()
            .iter()
            .map(|place| f64::from(place.y).atan2(f64::from(place.x)))
            .chain([-SENSOR.theta_max_rad, SENSOR.theta_max_rad].map(f64::from))
            .collect::<std::vec::Vec<_>>();
        bearings.sort_unstable_by(f64::total_cmp);
        if bearings.windows(2).any(|two| two[1] - two[0] < 0.02) {
            continue;
        }
        let gradient = law.signal_and_gradient(&[near, far]).gradient;
        for (wall, end, step) in [
            (0, 0, (1, 0)),
            (0, 1, (0, 1)),
            (1, 0, (0, 1)),
            (1, 1, (1, 0)),
        ] {
            let h = 3e-4;
            let (dx, dy) = (h * step.0 as f64, h * step.1 as f64);
            let moved = |sign: f64| {
                let mut walls = [near, far];
                let at = &mut walls[wall][end];
                at.x += (sign * dx) as f32;
                at.y += (sign * dy) as f32;
                integral(&SENSOR, &walls, 20_000)
            };
            let exact = (moved(1.0) - moved(-1.0)) / (2.0 * h);
            let held = gradient[wall][end];
            let held = f64::from(if step.0 == 1 { held.x } else { held.y });
            let full = integral(&SENSOR, &[near, far], 1000).max(5.0);
            // Rays of 1e-4 rad against steps of 3e-4 m, and a table's straight pieces.
            assert!(
                (held - exact).abs() < 0.06 * exact.abs() + 1.5 * full,
                "{near:?} {far:?}, wall {wall} end {end}: {held}, {exact}, full {full}"
            );
            compared += 1;
        }
    }
    assert!(compared > 1500, "{compared}");
}

#[test]
fn endless_walls_have_their_closed_form_and_its_inverse() {
    let law = TabulatedWallLaw::of(&SENSOR);
    // G(psi) in steps of 5 degrees, from sums of 1000 terms with three digits.
    let published = [
        1.0, 0.994, 0.976, 0.947, 0.908, 0.860, 0.804, 0.742, 0.675, 0.606, 0.535, 0.466, 0.398,
        0.335, 0.275, 0.222, 0.175, 0.134, 0.100, 0.072, 0.049, 0.033, 0.020, 0.012, 0.006,
    ];
    for (index, expected) in published.into_iter().enumerate() {
        let psi = (5.0 * index as f32).to_radians();
        for psi in [psi, -psi] {
            let share = law.endless_share(psi);
            assert!((share - expected).abs() < 2e-3, "{index}: {share}");
        }
        if index < 18 {
            for distance in [0.03, 0.1, 0.2] {
                let signal = law.endless_signal(distance, psi);
                let counts = signal + law.beta_counts();
                let back = law.endless_distance_m(counts, psi).unwrap();
                assert!((back / distance - 1.0).abs() < 1e-4, "{distance}: {back}");
                // A wall of 200 m is as good as endless.
                let (sine, cosine) = math::sin_cos(psi);
                let place = |along: f32| {
                    Point::new(
                        distance * cosine - along * sine,
                        distance * sine + along * cosine,
                    )
                };
                let long = law.signal(&[[place(-100.0), place(100.0)]]);
                let full = law.endless_signal(distance, 0.0);
                assert!((long - signal).abs() < 8e-4 * full, "{long}, {signal}");
            }
        }
    }
    assert_eq!(law.endless_distance_m(SENSOR.beta_counts, 0.0), None);
    assert_eq!(law.endless_distance_m(f32::NAN, 0.0), None);
}

#[test]
fn walls_without_sense_return_nothing() {
    let law = TabulatedWallLaw::of(&SENSOR);
    let good = Point::new(0.1, 0.05);
    for bad in [
        good,
        Point::new(f32::NAN, 0.0),
        Point::new(0.1, f32::INFINITY),
        Point::new(f32::MAX, f32::MAX),
    ] {
        let result = law.signal_and_gradient(&[[good, bad], [bad, good]]);
        assert!(result.signal.abs() < 1e-6, "{bad:?}: {result:?}");
    }
    // Behind the sensor, and in line with it.
    for wall in [
        [Point::new(-0.1, -0.3), Point::new(-0.1, 0.3)],
        [Point::new(0.05, 0.0), Point::new(0.15, 0.0)],
    ] {
        assert!(law.signal(&[wall]).abs() < 1e-6, "{wall:?}");
    }
    // Through the sensor: more than the register holds.
    let through = [Point::new(1e-4, -0.1), Point::new(1e-4, 0.1)];
    assert!(law.signal(&[through]) > 50_000.0);
    let many = [[Point::new(0.1, -0.1), good]; 2 * MAX_WALLS];
    assert!(law.signal(&many).is_finite());
}
