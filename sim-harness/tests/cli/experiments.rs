//! `cargo ipf experiments`: what it refuses, what it writes, and its exit code.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::common;

/// Exit code, and what was printed.
fn experiments(arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_ipf"))
        .arg("experiments")
        .args(arguments)
        .output()
        .unwrap();
    let both = [output.stdout.as_slice(), &output.stderr].concat();
    (output.status.code(), String::from_utf8(both).unwrap())
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// A planar sweep from 60 to 119 degrees at a wall 0.3 m ahead.
fn sweep() -> String {
    let mut lines = [Vec::new(), Vec::new()];
    for degree in 60..120_u8 {
        let bearing_rad = f64::from(degree).to_radians();
        lines[0].push(format!("{:.4}", 30.0 / bearing_rad.tan()));
        lines[1].push("30.0".to_owned());
    }
    lines.map(|line| line.join(",") + "\n").concat()
}

#[test]
fn a_servo_scan_gives_a_table_a_row_per_particle_and_a_picture() {
    let folder = common::own_folder("experiments");
    let (drive, out) = (folder.path().join("test2d.csv"), folder.path().join("out"));
    fs::write(&drive, sweep()).unwrap();
    let (code, shown) = experiments(&["servo-scan", text(&drive), "--out", text(&out)]);
    assert_eq!(code, Some(0), "{shown}");
    assert!(
        shown.contains("1 of 1 sweeps have more than 10 echoes"),
        "{shown}"
    );
    assert_eq!(shown.matches("PASS").count(), 4, "{shown}");
    let csv = fs::read_to_string(out.join("particles.csv")).unwrap();
    assert!(csv.starts_with("particles,form,x_m,y_m,weight\n"));
    assert_eq!(csv.lines().count(), 1 + 2 * (10_000 + 1_000));
    let png = fs::read(out.join("particles.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG"));
    let (_, again) = experiments(&["servo-scan", text(&drive), "--out", text(&out)]);
    assert_eq!(again, shown);
    assert_eq!(fs::read(out.join("particles.png")).unwrap(), png);
}

#[test]
fn what_is_no_sweep_and_no_room_is_refused() {
    let folder = common::own_folder("experiments");
    let (drive, out) = (folder.path().join("drive"), folder.path().join("out"));
    for (content, words) in [
        ("", "no row of the format sharp_ir"),
        ("[[1, \u{1b}[2J]]", "byte 1: '\\u{1b}[2J' is no number"),
        ("1,2\n3,4\n", "no sweep has more than 10 echoes"),
    ] {
        fs::write(&drive, content).unwrap();
        let (code, shown) = experiments(&["servo-scan", text(&drive), "--out", text(&out)]);
        assert_eq!(code, Some(2), "{shown}");
        assert!(shown.contains(words), "{words}: {shown}");
        assert!(!shown.contains('\u{1b}'), "{shown}");
        assert!(!out.exists(), "{words}");
    }
    let rig = common::root().join("rigs/nano_swarm.toml");
    let (code, shown) = experiments(&["sharing", text(folder.path()), "--rig", text(&rig)]);
    assert_eq!(code, Some(2), "{shown}");
    assert!(
        shown.contains("exp1/two-drones: no file of walls is beside"),
        "{shown}"
    );
    let (code, shown) = experiments(&["001", "--seeds", "5..5"]);
    assert_eq!(code, Some(2), "{shown}");
    assert!(shown.contains("A must be below B"), "{shown}");
}

#[test]
fn the_simulated_odometry_gives_the_same_table_each_time() {
    let (code, shown) = experiments(&["odometry", "--seeds", "100..102"]);
    assert_eq!(code, Some(0), "{shown}");
    assert_eq!(shown.matches("PASS").count(), 4, "{shown}");
    assert_eq!(experiments(&["odometry", "--seeds", "100..102"]).1, shown);
}
