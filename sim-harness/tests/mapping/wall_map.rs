//! The batch map of walls in worlds of extended surfaces.

use sim_harness::evaluation::{MethodComparison, Metric, Trials};
use sim_harness::mapping::Method;
use sim_harness::world::{Options, Physics, standard};

#[test]
fn walls_of_extended_surfaces_are_mapped_with_little_error() {
    let names = ["msod", "msm_l", "msm_t"];
    let comparison = MethodComparison {
        scenarios: names.map(|name| standard(name).unwrap().unwrap()).to_vec(),
        methods: vec![Method::WALL_MAP],
        // Seeds of the tuning.
        seeds: 0..3,
        particles_per_sensor: 1,
        options: Options {
            physics: Physics::Patch,
            ..Options::default()
        },
        alpha_counts_m2: None,
        calibration: None,
        footprint: false,
        threads: 0,
    };
    let trials = comparison.run().unwrap();
    // The block's short sides, edge-on to the drive, are not seen: 0.8 is its face.
    for (name, largest_oe, least_recall) in [
        ("msod", 0.005, 0.72),
        ("msm_l", 0.01, 0.93),
        ("msm_t", 0.02, 0.85),
    ] {
        let trials = Trials::of(&trials, name, Method::WALL_MAP).unwrap();
        let (oe, seed) = trials.largest(Metric::Oe).unwrap();
        assert!(oe <= largest_oe, "{name}, seed {seed}: {oe}");
        let (recall, seed) = trials.smallest(Metric::SurfaceRecall).unwrap();
        assert!(recall >= least_recall, "{name}, seed {seed}: {recall}");
    }
}
