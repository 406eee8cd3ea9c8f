//! What may know what: rules that no compiler checks.

mod common;

use std::path::{Path, PathBuf};

/// Every Rust file below a folder or the file itself, with its text up to its tests.
fn sources(place: &str) -> Vec<(PathBuf, String)> {
    common::rust_files(place)
        .into_iter()
        .map(|(path, text)| {
            let code = text.split("#[cfg(test)]").next().unwrap_or_default();
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

#[test]
fn filter_knows_no_wire_no_events_no_time() {
    let words = [
        "crate::wire",
        "crate::event",
        "crate::input",
        "crate::node",
        "stamp_us",
    ];
    assert_never_names("src/filter", &words);
}

#[test]
fn models_know_no_filter() {
    for place in [
        "src/sensor",
        "src/kinematics.rs",
        "src/geometry.rs",
        "src/math.rs",
    ] {
        assert_never_names(place, &["crate::filter", "crate::node", "crate::wire"]);
    }
}

#[test]
fn board_names_no_filter_no_node_and_its_parts_no_input() {
    let words = [
        "crate::filter",
        "crate::node",
        "crate::wire",
        "crate::input",
        "crate::event",
        "crate::board::acquisition",
    ];
    assert_never_names("src/board", &words[..2]);
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
    assert_never_names("src/board/acquisition", &words[..3]);
    assert_never_names("src/board/i2c", &["crate::board::can"]);
}

#[test]
fn core_knows_no_board() {
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
fn unsafe_code_stays_behind_two_doors() {
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

#[test]
fn rigs_records_and_sensors_know_no_filter_run_and_no_world() {
    let above = [
        "crate::mapping",
        "crate::world",
        "crate::log",
        "crate::link",
        "crate::pipeline",
        "crate::evaluation",
        "crate::figures",
    ];
    for place in ["sim-harness/src/rig", "sim-harness/src/drive"] {
        assert_never_names(place, &above);
    }
    // A format gives records; the cells of a return are the grid's.
    assert_never_names("sim-harness/src/datasets", &above);
    assert_never_names("sim-harness/src/sensors", &above[1..]);
    assert_never_names(
        "sim-harness/src/pipeline.rs",
        &["crate::world", "crate::link"],
    );
}
