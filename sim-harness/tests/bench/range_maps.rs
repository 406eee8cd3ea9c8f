//! How long maps of sonar echoes take on this host.
//!
//! `cargo bench -p sim-harness`. The walk over the cells of one echo, and the end of the
//! batch methods on the committed drive of 187 keyframes with 1038 echoes.

use std::hint::black_box;
use std::path::Path;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use sim_harness::datasets::{DriveFile, Kcma, PoseSource};
use sim_harness::drive::{Keyframes, Record, Return};
use sim_harness::geometry::Pose2;
use sim_harness::lattice::Lattice;
use sim_harness::mapping::{Mapper, Method, Setup};
use sim_harness::pipeline::{self, DriveOptions, KeyframeShare};
use sim_harness::rig::Rig;
use sim_harness::sensors::View;

const CELL_M: f64 = 0.1;

fn kcma() -> Rig {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    Rig::load(&root.join("../rigs/kcma.toml")).unwrap()
}

fn records(rig: &Rig) -> Vec<Record> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/robond");
    let drive = DriveFile {
        path: &path,
        rig,
        poses: PoseSource::Odometry,
        calibration: None,
        profile: None,
    };
    let options = DriveOptions {
        keyframes: Keyframes::new(0.10, 5_f64.to_radians()),
        share: KeyframeShare::All,
        mounts: rig
            .mounts
            .iter()
            .map(|it| it.name.starts_with("sonar"))
            .collect(),
    };
    let mut records = Vec::new();
    let mut take = |record: &Record| records.push(record.clone());
    pipeline::dataset_records(&Kcma, &drive, &options, &mut |_, _| {}, &mut take).unwrap();
    records
}

fn cone_walk(criterion: &mut Criterion) {
    let rig = kcma();
    let model = rig.mounts[3].sensor.model();
    let view = View {
        index: 0,
        measured: Return::Echo {
            range_m: 3.0,
            sigma_m: 0.03,
        },
        world_from_sensor: Pose2::new(0.31, 0.17, 0.4),
        tolerance_m: CELL_M,
        lattice: Lattice::new(CELL_M),
    };
    criterion.bench_function("cells of an echo at 3 m", |bencher| {
        bencher.iter(|| {
            model.footprint(black_box(&view), &mut |seen| {
                black_box(seen);
            })
        });
    });
}

fn finish(criterion: &mut Criterion) {
    let rig = kcma();
    let records = records(&rig);
    let mut group = criterion.benchmark_group("end of a drive of 1038 echoes");
    group.sample_size(10);
    for method in [Method::MAL, Method::CEMAL, Method::FSM, Method::FSM_CESP] {
        let filled = || {
            let mut mapper = method.mapper(&Setup::new(&rig, CELL_M));
            records.iter().for_each(|record| mapper.take(record));
            mapper
        };
        group.bench_function(method.name, |bencher| {
            bencher.iter_batched(
                filled,
                |mut mapper| {
                    mapper.finish(&mut |_| {});
                    mapper
                },
                BatchSize::PerIteration,
            );
        });
    }
    group.finish();
}

criterion_group!(benches, cone_walk, finish);
criterion_main!(benches);
