//! `cargo ipf map` on the recordings, against the tables of an independent implementation.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::common;

/// OE, TPR, FPR, AUC and coverage.
type Figures = [f64; 5];

const KEYS: [&str; 5] = ["oe", "tpr", "fpr", "auc", "coverage"];

/// How far a method of order-free counts may be off, and one that follows a path of
/// decisions: differences come from cells on exact borders, and from the truth.
const COUNTED: Figures = [0.005, 0.02, 0.005, 0.02, 0.02];
const DECIDED: Figures = [0.015, 0.05, 0.015, 0.05, 0.05];

/// Runs `map --methods all` over drives; the mean figures by method.
fn means(drives: &[String], poses: &str, name: &str) -> BTreeMap<String, Figures> {
    let folder = common::own_folder(name);
    let json = folder.path().join("rows.json");
    let output = Command::new(env!("CARGO_BIN_EXE_ipf"))
        .arg("map")
        .args(drives)
        .args(["--methods", "all", "--poses", poses, "--json"])
        .arg(&json)
        .arg("--out")
        .arg(folder.path().join("out"))
        .stdin(Stdio::null())
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    let text = std::fs::read_to_string(&json).unwrap();
    let rows: Vec<serde_json::Value> = serde_json::from_str(&text).unwrap();
    let mut means: BTreeMap<String, Figures> = BTreeMap::new();
    let share = 1.0 / drives.len() as f64;
    for row in rows
        .iter()
        .filter(|row| row.get("not_applicable").is_none())
    {
        let sums = means.entry(row["method"].as_str().unwrap().to_owned());
        let sums = sums.or_default();
        for (sum, key) in sums.iter_mut().zip(KEYS) {
            *sum += share * row[key].as_f64().unwrap();
        }
    }
    means
}

fn check(means: &BTreeMap<String, Figures>, expected: &[(&str, Figures, Figures)]) {
    for (method, expected, within) in expected {
        let found = &means[*method];
        for (((found, expected), within), key) in found.iter().zip(expected).zip(within).zip(KEYS) {
            assert!(
                (found - expected).abs() <= *within,
                "{method}: {key} is {found:.4}, and {expected} in the table"
            );
        }
    }
}

fn paths(folder: &Path, names: &[&str]) -> Vec<String> {
    let path = |name: &&str| folder.join(name).to_str().unwrap().to_owned();
    names.iter().map(path).collect()
}

#[test]
fn sonar_maps_of_three_runs_have_the_tabulated_scores_and_order() {
    let Some(folder) = common::recordings() else {
        return common::skip("no recordings");
    };
    let drives = paths(&folder.join("kcma"), &["test1", "test3", "test4"]);
    let means = means(&drives, "matched", "kcma-table");
    check(
        &means,
        &[
            ("all-free", [0.088, 0.0, 0.0, 0.5, 1.0], COUNTED),
            ("ism", [0.107, 0.521, 0.072, 0.847, 0.982], COUNTED),
            ("ism-decay", [0.112, 0.676, 0.092, 0.883, 1.0], COUNTED),
            ("ism-cesp", [0.097, 0.684, 0.076, 0.878, 0.833], DECIDED),
            (
                "ism-decay-cesp",
                [0.105, 0.698, 0.086, 0.892, 0.851],
                DECIDED,
            ),
            ("fsm", [0.096, 0.580, 0.065, 0.757, 1.0], DECIDED),
            ("fsm-cesp", [0.082, 0.668, 0.058, 0.848, 0.851], DECIDED),
            ("cemal", [0.073, 0.587, 0.040, 0.812, 0.851], DECIDED),
            ("mal", [0.096, 0.209, 0.029, 0.590, 1.0], COUNTED),
            ("bayes", [0.112, 0.706, 0.095, 0.885, 0.726], COUNTED),
            ("ds", [0.112, 0.704, 0.095, 0.885, 0.726], COUNTED),
            ("fuzzy", [0.116, 0.723, 0.101, 0.893, 0.726], COUNTED),
            ("bayes-box", [0.128, 0.703, 0.112, 0.891, 0.777], COUNTED),
            ("ds-box", [0.127, 0.702, 0.111, 0.891, 0.777], COUNTED),
            ("fuzzy-box", [0.138, 0.722, 0.124, 0.894, 0.776], COUNTED),
            ("laser", [0.017, 0.767, 0.000, 0.962, 0.997], COUNTED),
            ("sonar", [0.084, 0.341, 0.038, 0.740, 0.578], COUNTED),
            ("pessimistic", [0.049, 0.820, 0.039, 0.926, 0.597], COUNTED),
            ("minmax", [0.019, 0.741, 0.001, 0.955, 0.997], COUNTED),
            ("kleppe", [0.056, 0.520, 0.014, 0.835, 0.680], DECIDED),
        ],
    );
    let oe = |method: &str| means[method][0];
    assert!(oe("cemal") < oe("fsm-cesp") && oe("fsm-cesp") < oe("fsm") && oe("fsm") < oe("ism"));
    assert!(oe("cemal") < oe("ism-cesp") && oe("ism-cesp") < oe("ism"));
    assert!((oe("bayes") - oe("ds")).abs() <= 0.005);
    let raised = |method: &str| means[&format!("{method}-box")][2] - means[method][2];
    assert!(raised("bayes") > 0.0 && raised("ds") > 0.0);
    assert!(raised("fuzzy") > raised("bayes") && raised("fuzzy") > raised("ds"));
    // The two methods of this project are the only ones of sonars alone, beside those with
    // the filter, that are better than the map that is free everywhere.
    assert!(oe("ism-near") < oe("all-free") && oe("pgc") < oe("ism-near"));
}

#[test]
fn maps_of_drones_between_exact_walls_have_the_tabulated_scores_and_order() {
    let Some(folder) = common::recordings() else {
        return common::skip("no recordings");
    };
    let runs = [
        "exp1/two-drones",
        "exp1/four-drones",
        "exp2/two-drones",
        "exp2/four-drones",
    ];
    let drives = paths(&folder.join("nano_swarm"), &runs);
    let means = means(&drives, "mocap", "nano-table");
    check(
        &means,
        &[
            ("all-free", [0.072, 0.0, 0.0, 0.5, 1.0], COUNTED),
            ("ism", [0.107, 0.943, 0.110, 0.954, 0.980], COUNTED),
            ("ism-decay", [0.114, 0.952, 0.119, 0.954, 0.990], COUNTED),
            ("ism-cesp", [0.140, 0.873, 0.141, 0.936, 0.942], DECIDED),
            ("cemal", [0.079, 0.675, 0.060, 0.850, 0.961], DECIDED),
            ("fsm", [0.109, 0.948, 0.114, 0.926, 0.990], DECIDED),
            ("fsm-cesp", [0.130, 0.876, 0.131, 0.914, 0.961], DECIDED),
            ("mal", [0.052, 0.495, 0.017, 0.746, 0.990], COUNTED),
            ("bayes", [0.226, 0.989, 0.243, 0.898, 0.994], COUNTED),
            ("ds", [0.227, 0.989, 0.243, 0.902, 0.994], COUNTED),
            ("fuzzy", [0.268, 0.990, 0.288, 0.932, 0.994], COUNTED),
            ("laser", [0.029, 0.657, 0.005, 0.987, 0.996], COUNTED),
            ("sonar", [0.107, 0.943, 0.110, 0.953, 0.980], COUNTED),
            ("pessimistic", [0.106, 0.964, 0.111, 0.957, 0.981], COUNTED),
            ("minmax", [0.030, 0.860, 0.021, 0.983, 0.997], COUNTED),
            ("kleppe", [0.078, 0.671, 0.059, 0.871, 0.760], DECIDED),
            ("kleppe-paper", [0.081, 0.371, 0.039, 0.729, 0.340], DECIDED),
        ],
    );
    let oe = |method: &str| means[method][0];
    assert!(oe("mal") < oe("cemal") && oe("cemal") < oe("ism"));
}
