//! How long one step of 8 x 1000 particles takes on this host.
//!
//! `cargo bench`. A wall at 100 mm on the left, nothing elsewhere, 10 mm a step.

use std::hint::black_box;

use amiro_ipf::filter::{InverseParticleFilter, ParticleSet, Profile};
use amiro_ipf::geometry::{Angle, Motion, Point};
use amiro_ipf::model::Sample;
use amiro_ipf::node::Config;
use criterion::{Criterion, criterion_group, criterion_main};

fn step(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("step of 8 x 1000 particles");
    for (name, profile) in [("paper", Profile::Paper), ("plus", Profile::Plus)] {
        let config = Config::amiro(profile);
        let model = config.model();
        let mut samples = [Sample::Counts(0); 8];
        samples[1] = Sample::Counts(80);
        samples[2] = Sample::Counts(80);
        let readings = samples.map(|sample| model.photometry().read(sample));
        let motion = Motion {
            displacement: Point::new(0.010, 0.0),
            turn: Angle::default(),
        };
        let mut particles = Box::new(ParticleSet::<8000>::new());
        let mut filter = InverseParticleFilter::new(&mut particles, config.particles(), 1);
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                filter.step(&model, black_box(&motion), &readings, |place, outcome| {
                    black_box((place, outcome));
                })
            });
        });
    }
    group.finish();
}

criterion_group!(benches, step);
criterion_main!(benches);
