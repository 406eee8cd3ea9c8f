//! What may know what: rules that no compiler checks.

mod common;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What the unit tests of a file begin with.
const TESTS: &str = "\n#[cfg(test)]\nmod tests {";

/// All code of the workspace that is no test.
const PLACES: [&str; 3] = ["src", "sim-harness/src", "drivers"];

/// Most lines of a file without its tests, and of a file with a command of `cargo ipf`.
const MOST_LINES: usize = 400;
const MOST_LINES_OF_A_COMMAND: usize = 150;

/// Names that more than one type has, with the most types that each may name. An entry
/// goes when its name is one type's alone; none is added.
const SHARED_NAMES: &[(&str, usize)] = &[
    // Each driver crate stands alone and calls these as crates for embedded-hal do.
    ("Error", 2),
    ("Transaction", 2),
];

/// Every Rust file below a folder or the file itself, with its text up to its tests;
/// files of tests are left out.
fn sources(place: &str) -> Vec<(PathBuf, String)> {
    common::rust_files(place)
        .into_iter()
        .filter(|(path, _)| !path.ends_with("tests.rs"))
        .map(|(path, text)| {
            let code = text.split(TESTS).next().unwrap_or_default();
            (path, code.to_owned())
        })
        .collect()
}

/// The code lines of a text, without comments.
fn code_lines(text: &str) -> impl Iterator<Item = &str> {
    text.lines()
        .filter(|line| !line.trim_start().starts_with("//"))
}

fn assert_never_names(place: &str, words: &[&str]) {
    for (path, text) in sources(place) {
        for line in code_lines(&text) {
            for word in words {
                assert!(
                    !line.contains(word),
                    "{} names {word}: {line}",
                    path.display()
                );
            }
        }
    }
}

/// The layers of the core from the lowest to the highest, with the modules that each may
/// import.
const LAYERS: [(&str, &[&str]); 11] = [
    ("checksum", &[]),
    ("math", &[]),
    ("geometry", &["math"]),
    ("random", &["math"]),
    ("model", &["geometry", "math"]),
    (
        "filter",
        &["model", "geometry", "math", "random", "checksum"],
    ),
    (
        "beam_filter",
        &["filter", "geometry", "math", "random", "checksum"],
    ),
    ("dead_reckoning", &["filter", "model", "geometry", "math"]),
    ("node", &["filter", "model", "geometry", "math"]),
    ("board", &["node", "model", "geometry", "math", "checksum"]),
    ("link", &["board", "node", "model", "geometry", "checksum"]),
];

/// The modules of this crate that a line of code names, one by one or in braces.
fn modules_named(line: &str) -> Vec<&str> {
    let mut named = Vec::new();
    for rest in line.split("crate::").skip(1) {
        let list = rest
            .strip_prefix('{')
            .and_then(|list| list.split('}').next());
        for path in list.map_or(vec![rest], |list| list.split(", ").collect()) {
            let end = path.find(|c: char| !c.is_alphanumeric() && c != '_');
            named.push(path.get(..end.unwrap_or(path.len())).unwrap_or_default());
        }
    }
    named
}

#[test]
fn each_layer_of_the_core_imports_only_lower_ones() {
    for (layer, lower) in LAYERS {
        let folder = format!("src/{layer}");
        let place = if Path::new(&folder).is_dir() {
            folder
        } else {
            format!("{folder}.rs")
        };
        for (path, text) in sources(&place) {
            for line in code_lines(&text) {
                for module in modules_named(line) {
                    let is_lower = module == layer || lower.contains(&module);
                    assert!(is_lower, "{} names {module}: {line}", path.display());
                }
            }
        }
    }
}

#[test]
fn filter_has_no_time() {
    assert_never_names("src/filter", &["stamp_us"]);
}

#[test]
fn board_names_no_filter_no_node_no_link_and_its_parts_no_input() {
    let words = [
        "crate::filter",
        "crate::link",
        "node::Input",
        "crate::board::acquisition",
    ];
    assert_never_names("src/board", &["crate::filter", "crate::link", "node::Node"]);
    for place in [
        "src/board/can",
        "src/board/i2c",
        "src/board/supervision",
        "src/board/calibration.rs",
        "src/board/eeprom.rs",
        "src/board/offset_store.rs",
        "src/board/offsets.rs",
        "src/board/proximity_sensor.rs",
        "src/board/sensor_state.rs",
        "src/board/signal_check.rs",
    ] {
        assert_never_names(place, &words);
    }
    assert_never_names("src/board/i2c", &["crate::board::can"]);
}

#[test]
fn core_names_no_board() {
    for (path, text) in sources("src") {
        if path.to_string_lossy().contains("/bin/") {
            continue;
        }
        for word in ["cortex_m", "stm32", "rtic::", "std::time", "Instant"] {
            let named = code_lines(&text).any(|line| line.contains(word));
            assert!(!named, "{} names {word}", path.display());
        }
    }
}

#[test]
fn unsafe_code_is_in_two_places() {
    let hal = Path::new("src/bin/firmware/hal");
    for (path, text) in sources("src") {
        let inside = path.ends_with("src/math.rs")
            || path.parent().is_some_and(|folder| folder.ends_with(hal));
        let found =
            code_lines(&text).any(|line| line.contains("unsafe ") || line.contains("unsafe("));
        assert!(inside || !found, "{} has unsafe code", path.display());
    }
    assert_never_names("sim-harness/src", &["unsafe "]);
}

#[test]
fn core_has_no_double_precision_and_no_heap() {
    for (path, text) in sources("src") {
        if path.to_string_lossy().contains("/bin/") {
            continue;
        }
        for word in ["f64", "Box", "alloc::", "Rc<", "Arc<"] {
            let named = code_lines(&text).any(|line| line.contains(word));
            assert!(!named, "{} names {word}", path.display());
        }
    }
}

#[test]
fn pins_and_registers_are_named_by_the_board_and_the_line_alone() {
    for (path, text) in sources("src/bin/firmware") {
        let is_board = path
            .parent()
            .is_some_and(|folder| folder.ends_with("firmware/hal"));
        if is_board || path.ends_with("link.rs") {
            continue;
        }
        for word in ["GPIO", ".modify(", "pa2", "pb12"] {
            let named = code_lines(&text).any(|line| line.contains(word));
            assert!(!named, "{} names {word}", path.display());
        }
    }
}

/// The modules of the harness from the lowest to the highest: each imports only modules
/// before it.
const HARNESS_LAYERS: [&str; 30] = [
    "escape",
    "bounded",
    "quantity",
    "geometry",
    "lattice",
    "spool",
    "run",
    "ticks",
    "log",
    "output",
    "console",
    "drive",
    "sensors",
    "rig",
    "world",
    "filter_config",
    "bus",
    "faults",
    "device",
    "robot",
    "datasets",
    "mapping",
    "calibration",
    "run_record",
    "pipeline",
    "evaluation",
    "report",
    "experiments",
    "cli",
    "main",
];

#[test]
fn each_layer_of_the_harness_imports_only_lower_ones() {
    let root = "sim-harness/src";
    for (path, text) in sources(root) {
        let inside = path.strip_prefix(common::root().join(root)).unwrap();
        let first = inside.iter().next().unwrap().to_string_lossy();
        let layer = first.trim_end_matches(".rs");
        if layer == "lib" {
            continue;
        }
        let place = |name: &str| HARNESS_LAYERS.iter().position(|layer| *layer == name);
        let own = place(layer).unwrap_or_else(|| panic!("{layer} is in no layer"));
        for line in code_lines(&text) {
            for module in modules_named(line) {
                // A name in no layer is a re-export of the crate's root.
                let is_lower = place(module).is_none_or(|lower| lower <= own);
                assert!(is_lower, "{} names {module}: {line}", path.display());
            }
        }
    }
}

#[test]
fn worlds_and_mappers_name_no_filter() {
    let filters = ["amiro_ipf::node::Config", "amiro_ipf::filter"];
    assert_never_names("sim-harness/src/world", &filters);
    assert_never_names("sim-harness/src/mapping", &["crate::world"]);
}

/// The code of the workspace without its tests, by path from the root.
fn workspace() -> Vec<(String, String)> {
    let files = PLACES.iter().flat_map(|place| sources(place));
    files
        .map(|(path, text)| {
            let path = path.strip_prefix(common::root()).unwrap();
            let names: Vec<_> = path.iter().map(|name| name.to_string_lossy()).collect();
            (names.join("/"), text)
        })
        .filter(|(path, _)| !path.ends_with("/tests.rs") && !path.contains("/tests/"))
        .collect()
}

/// Panics with what is more than `most` where the list has no entry that allows it, and
/// with entries of the list that allow what needs no entry.
fn assert_within(
    found: &BTreeMap<String, usize>,
    most: impl Fn(&str) -> usize,
    list: &[(&str, usize)],
) {
    let allowed = BTreeMap::from_iter(list.iter().copied());
    let mut wrong = Vec::new();
    for (name, count) in found {
        let limit = *allowed.get(name.as_str()).unwrap_or(&most(name));
        if *count > limit {
            wrong.push(format!("{name}: {count}, at most {limit}"));
        }
    }
    for (name, _) in list {
        if found.get(*name).is_none_or(|count| *count <= most(name)) {
            wrong.push(format!(
                "{name}: no exception any more, remove it from the list"
            ));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn files_are_short_without_their_tests() {
    let lines = workspace()
        .into_iter()
        .map(|(path, text)| (path, text.lines().count()));
    let most = |path: &str| {
        if path.starts_with("sim-harness/src/cli/") {
            MOST_LINES_OF_A_COMMAND
        } else {
            MOST_LINES
        }
    };
    assert_within(&lines.collect(), most, &[]);
}

/// The name of the type that a line outside of all braces defines.
fn defined_type(line: &str) -> Option<&str> {
    let line = match line.strip_prefix("pub(") {
        Some(rest) => rest.split_once(") ")?.1,
        None => line.strip_prefix("pub ").unwrap_or(line),
    };
    let (kind, rest) = line.split_once(' ')?;
    let is_type = ["struct", "enum", "trait", "type", "union"].contains(&kind);
    let end = rest.find(|letter: char| !letter.is_alphanumeric() && letter != '_');
    is_type.then(|| &rest[..end.unwrap_or(rest.len())])
}

#[test]
fn a_type_name_has_one_meaning() {
    let mut places: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (path, text) in workspace() {
        for name in text.lines().filter_map(defined_type) {
            places
                .entry(name.to_owned())
                .or_default()
                .push(path.clone());
        }
    }
    assert!(places.len() > 400, "{places:#?}");
    let is_shared = |name: &str| SHARED_NAMES.iter().any(|(shared, _)| *shared == name);
    for (name, places) in &places {
        assert!(places.len() == 1 || is_shared(name), "{name}: {places:?}");
    }
    let counts = places
        .into_iter()
        .map(|(name, places)| (name, places.len()));
    assert_within(&counts.collect(), |_| 1, SHARED_NAMES);
}
