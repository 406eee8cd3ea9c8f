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
fn bus_knows_no_filter_and_its_controller_no_board() {
    let words = ["crate::filter", "crate::node", "crate::wire"];
    assert_never_names("src/can", &words);
    assert_never_names("src/board", &words[..2]);
}

#[test]
fn drivers_know_their_parts_and_the_samples_they_give() {
    let words = [
        "crate::filter",
        "crate::node",
        "crate::wire",
        "crate::input",
        "crate::event",
        "crate::senses",
        "crate::can",
    ];
    assert_never_names("src/driver", &words);
    assert_never_names(
        "src/senses",
        &["crate::filter", "crate::node", "crate::wire"],
    );
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
    let board = Path::new("src/bin/firmware/board");
    for (path, text) in sources("src") {
        let inside = path.ends_with("src/math.rs")
            || path.parent().is_some_and(|folder| folder.ends_with(board));
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
            .is_some_and(|folder| folder.ends_with("firmware/board"));
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
        "crate::device",
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
        &["crate::world", "crate::device"],
    );
}
