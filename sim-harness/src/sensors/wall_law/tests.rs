use super::*;
use crate::geometry::Turn;
use crate::world::{Physics, Scenario, signal_of};

const LAW: Photometry = Photometry::VCNL4020;

fn segment(from: (f64, f64), to: (f64, f64)) -> WallSegment {
    WallSegment::new(Vector::new(from.0, from.1), Vector::new(to.0, to.1))
}

/// Distance along a direction from the origin to a segment.
fn range_m(segment: &WallSegment, direction: Vector) -> Option<f64> {
    let way = segment.to - segment.from;
    let across = direction.cross(way);
    let range = segment.from.cross(way) / across;
    let share = segment.from.cross(direction) / across;
    (range > 0.0 && (0.0..=1.0).contains(&share)).then_some(range)
}

/// The return by a sum over narrow rays.
fn integrated(photometry: &Photometry, segments: &[WallSegment], rays: u32) -> f64 {
    let edge = f64::from(photometry.theta_max_rad);
    let xi = f64::from(photometry.xi);
    let width = 2.0 * edge / f64::from(rays);
    let (mut sum, mut endless) = (0.0, 0.0);
    for ray in 0..rays {
        let bearing = (f64::from(ray) + 0.5) * width - edge;
        let (sine, cosine) = libm::sincos(bearing);
        let direction = Vector::new(cosine, sine);
        let lobe = libm::cos(xi * bearing);
        endless += lobe * cosine * cosine * cosine;
        let hit = |segment: &WallSegment| {
            let range = range_m(segment, direction)?;
            let way = segment.to - segment.from;
            let incidence = (way.cross(direction) / way.norm()).abs();
            Some((range, lobe * incidence / (range * range)))
        };
        let nearest = segments
            .iter()
            .filter_map(hit)
            .min_by(|a, b| a.0.total_cmp(&b.0));
        sum += nearest.map_or(0.0, |(_, counts)| counts);
    }
    f64::from(photometry.alpha_counts_m2) * sum / endless
}

/// Walls in front, beside and behind each other, crossing, and behind the sensor.
fn scenes() -> Vec<Vec<WallSegment>> {
    vec![
        vec![segment((0.1, -0.5), (0.1, 0.5))],
        vec![segment((0.1, 0.03), (0.09, -0.02))],
        vec![segment((-0.2, 0.05), (0.4, 0.08))],
        vec![segment((0.02, -0.06), (0.15, 0.03))],
        vec![segment((-0.1, -0.1), (-0.1, 0.1))],
        // One hides the middle of the other.
        vec![
            segment((0.06, -0.01), (0.065, 0.02)),
            segment((0.12, -0.2), (0.11, 0.15)),
        ],
        // One hides an end of the other.
        vec![
            segment((0.12, -0.2), (0.11, 0.02)),
            segment((0.07, 0.01), (0.09, 0.09)),
        ],
        // A corner whose walls cross.
        vec![
            segment((0.1, -0.1), (0.13, 0.08)),
            segment((0.05, 0.06), (0.18, 0.04)),
        ],
        vec![
            segment((0.1, -0.1), (0.13, 0.08)),
            segment((0.05, 0.06), (0.18, 0.04)),
            segment((0.2, -0.4), (0.16, 0.3)),
            segment((0.05, -0.09), (0.07, -0.03)),
        ],
    ]
}

#[test]
fn an_endless_wall_across_the_axis_returns_alpha_over_the_distance_squared() {
    for distance in [0.03, 0.1, 0.2] {
        let wall = segment((distance, -9.0), (distance, 9.0));
        let expected = f64::from(LAW.alpha_counts_m2) / (distance * distance);
        let signal = WallLaw::new(&LAW).signal(&[wall]);
        assert!((signal / expected - 1.0).abs() < 1e-12, "{signal}");
    }
}

#[test]
fn an_endless_wall_returns_what_a_long_segment_returns_at_every_bearing() {
    let law = WallLaw::new(&LAW);
    for degrees in [
        -140.0, -100.0, -60.0, -20.0, 0.0, 31.0, 75.0, 120.0, 149.0_f64,
    ] {
        let (sine, cosine) = libm::sincos(degrees.to_radians());
        let normal = Vector::new(cosine, sine);
        let along = Vector::new(-normal.y, normal.x).scaled(1e4);
        let foot = normal.scaled(0.08);
        let signal = law.signal(&[WallSegment::new(foot - along, foot + along)]);
        let endless = law.endless_wall_counts(0.08, degrees.to_radians());
        // The segment ends 1e4 m away, where the angle of incidence is a right one.
        assert!(
            (signal - endless).abs() < 1e-6,
            "{degrees}: {signal}, {endless}"
        );
    }
    assert!(
        law.endless_wall_counts(0.08, 2.7).abs() < 1e-12,
        "behind the sensor"
    );
}

#[test]
fn the_closed_form_is_the_integral_over_the_lobe_with_occlusion() {
    for xi in [1.0, 1.2365, 1.45, 3.0] {
        for theta_max_rad in [20_f32.to_radians(), 30_f32.to_radians()] {
            let photometry = Photometry {
                xi,
                theta_max_rad,
                ..LAW
            };
            for scene in scenes() {
                let expected = integrated(&photometry, &scene, 200_000);
                let signal = WallLaw::new(&photometry).signal(&scene);
                // The ray that holds an end is wrong by up to its own width, 1 / 200 000.
                let error = (signal - expected).abs();
                assert!(
                    error < 1e-4 * expected.max(1.0),
                    "xi {xi}: {signal}, {expected}, {scene:?}"
                );
            }
        }
    }
    for scene in scenes() {
        let expected = integrated(&LAW, &scene, 400_000);
        let signal = WallLaw::new(&LAW).signal(&scene);
        let error = (signal - expected).abs();
        assert!(
            error < 1e-4 * expected.max(1.0),
            "{signal}, {expected}, {scene:?}"
        );
    }
}

#[test]
fn derivatives_by_the_ends_are_those_of_differences() {
    let law = WallLaw::new(&LAW);
    const STEP_M: f64 = 1e-6;
    for scene in scenes() {
        let mut gradients = vec![[0.0; 4]; scene.len()];
        let signal = law.linearised(&scene, &mut gradients);
        assert!((signal - law.signal(&scene)).abs() < 1e-9 * signal.max(1.0));
        for (index, gradient) in gradients.iter().enumerate() {
            for (parameter, analytic) in gradient.iter().enumerate() {
                let moved = |step: f64| {
                    let mut scene = scene.clone();
                    let wall = &mut scene[index];
                    *[
                        &mut wall.from.x,
                        &mut wall.from.y,
                        &mut wall.to.x,
                        &mut wall.to.y,
                    ][parameter] += step;
                    law.signal(&scene)
                };
                let difference = (moved(STEP_M) - moved(-STEP_M)) / (2.0 * STEP_M);
                // Second order: 1e-12 times a third derivative of some 1e8 counts/m^3.
                assert!(
                    (difference - analytic).abs() < 1e-3 * analytic.abs().max(1.0),
                    "{scene:?}, {index}, {parameter}: {difference}, {analytic}"
                );
            }
        }
    }
}

#[test]
fn returns_are_those_of_the_simulated_patch_physics() {
    let turn = |degrees: f64| Turn::by_degrees(degrees);
    for (distance, width, degrees) in [
        (0.1, 0.05, 0.0),
        (0.1, 0.2, 0.0),
        (0.06, 0.3, 20.0),
        (0.15, 0.1, -35.0),
    ] {
        let half = turn(degrees)
            .direction()
            .turned(turn(90.0))
            .scaled(0.5 * width);
        let middle = Vector::new(distance, 0.0);
        let wall = WallSegment::new(middle - half, middle + half);
        // A box 1 mm deep whose front face is the wall.
        let centre = middle + turn(degrees).direction().scaled(0.5e-3);
        let text = format!(
            "name = \"d\"\ncell_m = 0.01\nextent_m = [-1, -1, 1, 1]\nspeed_m_per_s = 0.08\n\
             start = [0, 0, 0]\n[[box]]\nmin = [{}, {}]\nmax = [{}, {}]\nangle_deg = {degrees}\n",
            centre.x - 0.5e-3,
            centre.y - 0.5 * width,
            centre.x + 0.5e-3,
            centre.y + 0.5 * width,
        );
        let shapes = Scenario::parse(&text).unwrap().shapes;
        let simulated = signal_of(&LAW, Physics::Patch, &shapes);
        let signal = WallLaw::new(&LAW).signal(&[wall]);
        // The simulator has one ray per degree: an end is wrong by up to half a ray.
        let ray = f64::from(LAW.alpha_counts_m2) / (distance * distance) / 85.0;
        assert!(
            (signal - simulated).abs() < 1.1 * ray,
            "{distance} {width} {degrees}: {signal}, {simulated}, {ray}"
        );
    }
}
