//! Files of other robots with random damage: read or refused, row by row.

use std::fs;
use std::path::Path;

use amiro_ipf::random::{Generator, uniform_below};
use sim_harness::datasets::{Dataset, DriveFile, Player, PoseSource, SharpIr};
use sim_harness::drive::{Record, Return};
use sim_harness::rig::Rig;

use crate::common::{own_folder, root};

const SEED: u64 = 100;

/// Files per format.
const FILES: usize = 300;

/// Some bytes replaced, removed or repeated.
fn damaged(bytes: &[u8], rng: &mut Generator) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..=uniform_below(rng, 6) {
        let length = bytes.len() as u32;
        let at = uniform_below(rng, length) as usize;
        let end = (at + uniform_below(rng, 40) as usize).min(bytes.len());
        match uniform_below(rng, 4) {
            0 => bytes[at] = rng.bits() as u8,
            1 => drop(bytes.drain(at..end)),
            2 => {
                let part = bytes[at..end].to_vec();
                bytes.splice(at..at, part);
            }
            _ => bytes[at] = b"0123456789.-+e,[] \n#"[uniform_below(rng, 20) as usize],
        }
        if bytes.is_empty() {
            bytes.push(b'1');
        }
    }
    bytes
}

/// Reads a file: stamps never decrease, poses and ranges are finite, refusals are printable.
fn check(dataset: &dyn Dataset, path: &Path, rig: &Rig) {
    let drive = DriveFile {
        path,
        rig,
        poses: PoseSource::Odometry,
        calibration: None,
        profile: None,
    };
    let mut last_us = 0;
    let read = dataset.read(&drive, &mut |_, _| {}, &mut |record| {
        let stamp_us = match record {
            Record::Pose {
                stamp_us,
                world_from_body,
            } => {
                assert!(world_from_body.is_finite(), "{record:?}");
                *stamp_us
            }
            Record::OdometryReset { stamp_us } => *stamp_us,
            Record::Scan(scan) => {
                assert!(scan.world_from_body.is_finite(), "{record:?}");
                let mounts = &rig.mounts[scan.mounts.clone()];
                let returns = mounts.iter().map(|it| it.sensor.model().returns());
                assert_eq!(scan.returns.len(), returns.sum::<usize>());
                for measured in &scan.returns {
                    if let Return::Echo { range_m, .. } = measured {
                        assert!(*range_m > 0.0 && range_m.is_finite(), "{record:?}");
                    }
                }
                scan.stamp_us
            }
            Record::Outcomes(_) => last_us,
        };
        assert!(stamp_us >= last_us, "{record:?}");
        last_us = stamp_us;
    });
    let shown = match read {
        Ok(rows) => {
            assert!(rows.used > 0);
            rows.refused.to_string() + &rows.notes.concat()
        }
        Err(error) => error.to_string(),
    };
    let is_plain = |letter: char| letter == '\n' || !letter.is_control();
    assert!(shown.chars().all(is_plain), "{shown:?}");
}

fn check_damaged(dataset: &dyn Dataset, rig: &str, whole: &str) {
    let rig = Rig::load(&root().join("rigs").join(rig)).unwrap();
    let folder = own_folder("damaged");
    let path = folder.path().join("file");
    let mut rng = Generator::seeded(SEED);
    fs::write(&path, whole).unwrap();
    assert!(dataset.recognises(&path));
    check(dataset, &path, &rig);
    for _ in 0..FILES {
        fs::write(&path, damaged(whole.as_bytes(), &mut rng)).unwrap();
        // Whether or not the file still looks like one of the format.
        dataset.recognises(&path);
        check(dataset, &path, &rig);
    }
}

#[test]
fn damaged_logs_of_player_are_read_or_refused() {
    let rig = Rig::load(&root().join("rigs/pioneer2dx.toml")).unwrap();
    let mut log = "# a comment\n".to_owned();
    for step in 0..8_u8 {
        let time_s = 100.0 + 0.1 * f64::from(step);
        let head = |interface: &str| format!("{time_s:.3} robot 6665 {interface} 00 {time_s:.3}");
        log += &head("position");
        log += &format!(" {:.3} 0.000 0.100 0.5 0.0 0.0 0\n", 0.05 * f64::from(step));
        log += &head("sonar");
        log += " 16";
        for mount in &rig.mounts {
            let at = mount.body_from_sensor;
            let heading_rad = at.heading_rad();
            log += &format!(
                " {:.3} {:.3} {heading_rad:.4}",
                at.position.x, at.position.y
            );
        }
        log += " 16";
        log += &" 1.250".repeat(16);
        log += "\n";
        log += &head("laser");
        log += " -1.5708 1.5708 0.0175 181";
        log += &" 2.500 0".repeat(181);
        log += "\n";
    }
    check_damaged(&Player, "pioneer2dx_laser.toml", &log);
    check_damaged(&Player, "pioneer2dx.toml", &log);
}

#[test]
fn damaged_sweeps_are_read_or_refused() {
    let row = format!("[{}114.4273]", "55.5, ".repeat(59));
    let list = format!("[{}]", [row.as_str(); 4].join(", "));
    check_damaged(&SharpIr, "sharp_ir.toml", &list);
    let line = format!("{}30.25\n", "20.5,".repeat(59));
    check_damaged(&SharpIr, "sharp_ir.toml", &line.repeat(2));
}
