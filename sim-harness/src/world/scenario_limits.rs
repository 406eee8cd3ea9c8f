//! Limits of a scenario, such that a simulation ends within some minutes.

use super::{Scenario, ScenarioError, Shape};

/// Longest file, bytes.
pub(super) const MAX_BYTES: usize = 4 << 20;
/// Greatest number of boxes and cylinders together.
const MAX_SHAPES: usize = 10_000;
/// Greatest number of legs of the drive, and of openings.
const MAX_LEGS: usize = 1_000;
/// Longest drive, metres.
const MAX_DRIVE_M: f64 = 1_000.0;
/// Longest drive, seconds.
const MAX_DRIVE_S: f64 = 3_600.0;
/// Greatest number of cells in the map's rectangle.
const MAX_CELLS: f64 = 4e6;
/// Longest outline of all shapes together, metres.
const MAX_OUTLINE_M: f64 = 10_000.0;
/// Greatest product of shapes and seconds of driving: minutes of computing, not hours.
const MAX_SHAPE_SECONDS: f64 = 400_000.0;

impl Scenario {
    /// Checks the texts and sizes of a scenario.
    ///
    /// # Errors
    /// [`ScenarioError::Limit`] for the first that is too large.
    pub(super) fn check_limits(&self) -> Result<(), ScenarioError> {
        for (key, text) in [("name", &self.name), ("about", &self.about)] {
            // Both are printed.
            if text.chars().any(char::is_control) {
                let what = "holds a control character".to_owned();
                return Err(ScenarioError::Limit { key, what });
            }
        }
        at_most("box, cylinder", self.shapes.len(), MAX_SHAPES, "shapes")?;
        at_most("drive", self.drive.len(), MAX_LEGS, "legs")?;
        at_most("opening", self.openings.len(), MAX_LEGS, "openings")?;
        let length_m: f64 = self.drive.iter().map(|leg| leg.length_m()).sum();
        within("drive", length_m, MAX_DRIVE_M, "metres in all")?;
        let duration_s = self.duration_s();
        within(
            "drive, speed_m_per_s",
            duration_s,
            MAX_DRIVE_S,
            "seconds in all",
        )?;
        let size = self.extent.max - self.extent.min;
        let cells = (size.x / self.cell_m) * (size.y / self.cell_m);
        within("extent_m, cell_m", cells, MAX_CELLS, "cells")?;
        let outline_m: f64 = self.shapes.iter().map(Shape::outline_m).sum();
        within(
            "box, cylinder",
            outline_m,
            MAX_OUTLINE_M,
            "metres of outline",
        )?;
        within(
            "box, cylinder, drive",
            self.shapes.len() as f64 * duration_s,
            MAX_SHAPE_SECONDS,
            "shapes times seconds of driving",
        )
    }
}

pub(super) fn at_most(
    key: &'static str,
    count: usize,
    limit: usize,
    of: &str,
) -> Result<(), ScenarioError> {
    within(key, count as f64, limit as f64, of)
}

fn within(key: &'static str, value: f64, limit: f64, of: &str) -> Result<(), ScenarioError> {
    if value <= limit {
        return Ok(());
    }
    Err(ScenarioError::Limit {
        key,
        what: format!("{value} {of}, at most {limit} are allowed"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &str = "name = \"small\"\ncell_m = 0.01\nextent_m = [-1, -1, 1, 1]\n\
        speed_m_per_s = 0.08\nstart = [0, 0, 0]\n";

    #[test]
    fn worlds_that_would_never_end_are_refused() {
        let leg = "[[drive]]\nstraight_m = 250\n";
        let shape = "[[cylinder]]\ncenter = [0, 0]\nradius_m = 0.01\n";
        let large = "[[box]]\nmin = [-1000, -1000]\nmax = [1000, 1000]\n";
        for (text, part) in [
            (SMALL.to_owned() + &leg.repeat(5), "drive: 1250 metres"),
            (
                SMALL.to_owned() + &leg.repeat(4),
                "speed_m_per_s: 12500 seconds",
            ),
            (
                SMALL.to_owned() + &"[[drive]]\nturn_deg = 1\n".repeat(1001),
                "1001 legs",
            ),
            (SMALL.to_owned() + &shape.repeat(10_001), "10001 shapes"),
            (
                SMALL.to_owned() + leg + &shape.repeat(1000),
                "shapes times seconds",
            ),
            (
                SMALL.to_owned() + &large.repeat(2),
                "16000 metres of outline",
            ),
            (
                SMALL.replace("[-1, -1, 1, 1]", "[-500, -1, 500, 1]"),
                "20000000 cells",
            ),
            (SMALL.to_owned() + &"#".repeat(MAX_BYTES), "bytes"),
            ("x = ".to_owned() + &"[".repeat(100_000), "recursion"),
        ] {
            let error = Scenario::parse(&text).unwrap_err().to_string();
            assert!(error.contains(part), "no {part:?} in {error:.300}");
        }
    }

    #[test]
    fn a_name_that_would_move_the_cursor_is_refused() {
        for key in ["name", "about"] {
            let rest: Vec<_> = SMALL
                .lines()
                .filter(|line| !line.starts_with(key))
                .collect();
            let text = format!("{key} = \"\\u001b[2J\"\n{}\n", rest.join("\n"));
            let error = Scenario::parse(&text).unwrap_err().to_string();
            assert_eq!(error, format!("{key}: holds a control character"));
        }
    }
}
