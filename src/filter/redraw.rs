//! Redrawing: a new particle from the current readings (Algorithm 2).

use rand_core::Rng;

use super::particles::Slot;
use super::weigh::Beam;
use super::{Model, NothingDraw, Scan};
use crate::geometry::Point;
use crate::math;
use crate::random::{standard_normal_pair, uniform, uniform_below};

/// A position drawn from the inverse model of one of the usable sensors.
///
/// Sensor and bearing are uniform. The range is normal about the reading's arc with
/// the sensor's own noise; the model error is left out, because it would put new
/// particles inside walls. An empty lobe is searched by [`NothingDraw`]. `None`
/// when no sensor is usable.
///
/// Corrected against the print: the bearing comes from +-theta_max, not +-90 degrees,
/// where the law has no solution beyond 72.8; the mean of the range is x(s_n, phi), a
/// length, not s_n, a count; the sensor's mount, missing in print, transforms the
/// position into the body frame.
#[inline]
fn draw(model: &Model, scan: &Scan, rng: &mut impl Rng) -> Option<Point> {
    let beams = scan.usable();
    let beam = beams.get(uniform_below(rng, beams.len() as u32) as usize)?; // 1: n ~ U(1, N)
    let bearing = model.photometry.theta_max_rad * (2.0 * uniform(rng) - 1.0); // 2: phi ~ U
    let (sine, cosine) = math::sin_cos(bearing);
    let range = beam.draw_range_on_axis(model, rng) * model.beam_pattern.at(cosine); // 3: r ~ N(x, sigma)
    let in_sensor = Point::new(range * cosine, range * sine);
    Some(beam.mount.body_from_sensor(in_sensor)) // 4: k
}

impl Beam {
    /// A range on the axis: normal about the reading, or the search of an empty lobe.
    #[inline]
    pub(super) fn draw_range_on_axis(&self, model: &Model, rng: &mut impl Rng) -> f32 {
        let echo = self.echo;
        let range_m = if self.surface || model.parameters.nothing_draw == NothingDraw::AtLimit {
            echo.range_m + echo.sigma_m * standard_normal_pair(rng).0
        } else {
            echo.range_m * math::sqrt(uniform(rng))
        };
        if range_m > 0.0 { range_m } else { 0.0 }
    }
}

impl Slot<'_> {
    /// Puts a new particle of epoch 0 into the slot; none when no sensor is usable.
    #[inline]
    pub(super) fn redraw(&mut self, model: &Model, scan: &Scan, rng: &mut impl Rng) {
        match draw(model, scan, rng) {
            Some(position) => self.fill(position),
            None => self.clear(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filter::{FilterParameters, Profile};
    use crate::model::{DifferentialDrive, Photometry, Reading, Ring, SENSORS, Sample};
    use crate::random::Generator;

    fn model(parameters: FilterParameters) -> Model {
        Model::new(
            parameters,
            Photometry::VCNL4020,
            &Ring::AMIRO,
            DifferentialDrive::AMIRO,
        )
    }

    fn draws(model: &Model, samples: [Sample; SENSORS], seed: u64, count: usize) -> Vec<Point> {
        let scan = Scan::new(model, &samples.map(|sample| model.photometry.read(sample)));
        let mut rng = Generator::seeded(seed);
        (0..count)
            .filter_map(|_| draw(model, &scan, &mut rng))
            .collect()
    }

    fn only(sensor: usize, counts: i32) -> [Sample; SENSORS] {
        core::array::from_fn(|index| {
            if index == sensor {
                Sample::Counts(counts)
            } else {
                Sample::Missing
            }
        })
    }

    #[test]
    fn draws_follow_the_arc_with_the_sensors_noise() {
        let model = model(FilterParameters::PAPER);
        let mount = Ring::AMIRO.mount(3);
        let echo = model.photometry.range_estimate(78.0).unwrap();
        const COUNT: usize = 20_000;
        for seed in 1..=3 {
            let scores: Vec<f64> = draws(&model, only(3, 78), seed, COUNT)
                .into_iter()
                .map(|place| {
                    let seen = mount.sensor_from_body(place);
                    let on_axis = seen.norm() / model.beam_pattern.at(seen.x / seen.norm());
                    f64::from((on_axis - echo.range_m) / echo.sigma_m)
                })
                .collect();
            assert_eq!(scores.len(), COUNT);
            let n = COUNT as f64;
            let mean = scores.iter().sum::<f64>() / n;
            let variance = scores.iter().map(|z| z * z).sum::<f64>() / n;
            assert!(
                mean.abs() < 4.0 / n.sqrt() + 0.002,
                "seed {seed}: mean {mean}"
            );
            assert!(
                (variance - 1.0).abs() < 4.0 * (2.0 / n).sqrt() + 0.002,
                "seed {seed}: {variance}"
            );
        }
    }

    #[test]
    fn bearings_are_drawn_equally_often_over_the_lobe_and_none_beyond_it() {
        let model = model(FilterParameters::PAPER);
        let mount = Ring::AMIRO.mount(3);
        const COUNT: usize = 20_000;
        for seed in 1..=3 {
            let mut sectors = [0_i32; 8];
            for place in draws(&model, only(3, 78), seed, COUNT) {
                let seen = mount.sensor_from_body(place);
                let bearing = f64::from(seen.y).atan2(f64::from(seen.x));
                let share = 0.5 + 0.5 * bearing / f64::from(model.photometry.theta_max_rad);
                // f32 at 0.1 m is 1e-7 of the lobe.
                assert!((-1e-6..=1.0 + 1e-6).contains(&share), "{share}");
                sectors[((share * 8.0).max(0.0) as usize).min(7)] += 1;
            }
            // 2500 each; sigma = sqrt(20000 / 8 * 7 / 8) = 47, 4 sigma.
            for count in sectors {
                assert!((count - 2500).abs() < 188, "seed {seed}: {sectors:?}");
            }
        }
    }

    #[test]
    fn sensors_are_drawn_equally_often() {
        let model = model(FilterParameters::PAPER);
        let places = draws(&model, [Sample::Counts(300); SENSORS], 4, 80_000);
        // At 56 mm range every draw is nearest to its own sensor's axis or its
        // neighbour's in equal measure: count by direction from the centre.
        let mut counts = [0_i32; SENSORS];
        for place in places {
            let nearest = (0..SENSORS).max_by(|&a, &b| {
                let along = |index| {
                    let mount = Ring::AMIRO.mount(index);
                    place.x * mount.direction.cosine + place.y * mount.direction.sine
                };
                along(a).total_cmp(&along(b))
            });
            counts[nearest.unwrap()] += 1;
        }
        for count in counts {
            assert!((count - 10_000).abs() < 400, "{counts:?}");
        }
    }

    #[test]
    fn empty_lobes_are_searched_at_their_limit_or_over_their_area() {
        let mount = Ring::AMIRO.mount(3);
        for (profile, inner_share) in [(Profile::Paper, 0.0), (Profile::Plus, 0.25)] {
            let model = model(profile.parameters());
            let places = draws(&model, only(3, 0), 9, 20_000);
            let inner = places
                .iter()
                .filter(|place| {
                    let seen = mount.sensor_from_body(**place);
                    seen.norm() < 0.1 * model.beam_pattern.at(seen.x / seen.norm())
                })
                .count();
            // Half the radius holds a quarter of the area; sigma 0.003.
            let share = inner as f64 / places.len() as f64;
            assert!((share - inner_share).abs() < 0.0125, "{profile:?}: {share}");
        }
    }

    #[test]
    fn every_code_draws_a_finite_place() {
        for profile in [Profile::Paper, Profile::Plus] {
            let model = model(profile.parameters());
            for counts in (-100..=65_535).step_by(7) {
                for place in draws(&model, only(5, counts), counts as u64, 10) {
                    assert!(place.norm() < 0.5, "{counts} counts: {place:?}");
                }
            }
        }
    }

    #[test]
    fn without_a_usable_sensor_nothing_is_drawn() {
        let model = model(FilterParameters::PAPER);
        let scan = Scan::new(&model, &[Reading::Faulty; SENSORS]);
        assert_eq!(draw(&model, &scan, &mut Generator::seeded(1)), None);
    }
}
