//! The report on the recorded walls in words.

use std::fmt;

use super::{PhysicsError, RecordedReport, SensorError, WallEnd};

/// Millimetres, or a dash.
fn millimetres(metres: Option<f64>) -> String {
    metres.map_or_else(
        || "-".to_owned(),
        |metres| format!("{:.1}", 1000.0 * metres),
    )
}

/// A ratio's logarithm, or a dash.
fn logarithm(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:+.2}"))
}

impl fmt::Display for PhysicsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let own = if self.is_own_alpha {
            "own"
        } else {
            "calibrated"
        };
        writeln!(
            f,
            "{} with its {own} alpha {:.3}: expected against recorded counts",
            self.physics, self.alpha_counts_m2
        )?;
        let mut line = |name: &str, error: &SensorError| {
            writeln!(
                f,
                "  {name:<14} {:4} rows  RMS {:7.1} counts  {:4} lit  ln ratio mean {:>5}  RMS {:>5}",
                error.rows,
                error.rms_counts,
                error.lit_rows,
                logarithm(error.mean_log_ratio),
                logarithm(error.rms_log_ratio),
            )
        };
        for error in &self.sensors {
            let name = error
                .sensor
                .map_or_else(String::new, |n| format!("sensor {n}"));
            line(&name, error)?;
        }
        for (name, error) in &self.series {
            line(name, error)?;
        }
        line("together", &self.together)
    }
}

impl RecordedReport {
    /// The ends of the walls as each method that fits walls has placed them.
    fn write_ends(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let placed = || self.walls.iter().filter(|walls| !walls.ends.is_empty());
        if placed().next().is_none() {
            return Ok(());
        }
        writeln!(
            f,
            "ends of the walls, mm beyond the true end (standard deviation)"
        )?;
        let mut kinds: Vec<(&str, &str)> = Vec::new();
        for walls in placed() {
            let kind = (walls.readings, walls.method);
            write!(f, "{:<14} {:<9} {:<21}", walls.series, kind.0, kind.1)?;
            for end in &walls.ends {
                let name = if end.is_to { "to" } else { "from" };
                write!(f, "  wall {} {name} {}", end.wall + 1, EndInWords(end))?;
            }
            writeln!(f)?;
            if !kinds.contains(&kind) {
                kinds.push(kind);
            }
        }
        for kind in kinds {
            let of_kind = placed().filter(|walls| (walls.readings, walls.method) == kind);
            let ends: Vec<&WallEnd> = of_kind.flat_map(|walls| &walls.ends).collect();
            let mapped = ends.iter().filter(|end| end.mapped.is_some()).count();
            let rms = millimetres(WallEnd::rms_m(ends.iter().copied()));
            writeln!(
                f,
                "{} {}: {mapped} of {} ends mapped, RMS {rms} mm",
                kind.0,
                kind.1,
                ends.len()
            )?;
        }
        Ok(())
    }
}

/// The place of an end relative to the true one.
struct EndInWords<'e>(&'e WallEnd);

impl fmt::Display for EndInWords<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.mapped {
            Some(end) => write!(f, "{:+.1} ({:.1})", 1e3 * end.beyond_m, 1e3 * end.sigma_m),
            None => f.write_str("-"),
        }
    }
}

impl fmt::Display for RecordedReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "alpha {:.3} counts m^2, from {} with the face abeam; at most one step per station",
            self.alpha_counts_m2, self.alpha_from
        )?;
        for (name, about) in &self.sources {
            writeln!(f, "  {name:<14} {about}")?;
        }
        writeln!(
            f,
            "series         readings  method                 steps  occupied  beside  mean mm   RMS mm  \
             recall  within 20 mm  false"
        )?;
        for walls in &self.walls {
            writeln!(
                f,
                "{:<14} {:<9} {:<21} {:6} {:9} {:7} {:>8} {:>8} {:7.2} {:13.2} {:6}",
                walls.series,
                walls.readings,
                walls.method,
                walls.steps,
                walls.occupied,
                walls.beside,
                millimetres(walls.mean_m),
                millimetres(walls.rms_m),
                walls.recall_15,
                walls.recall_20,
                walls.false_cells,
            )?;
        }
        self.write_ends(f)?;
        for physics in &self.physics {
            write!(f, "{physics}")?;
        }
        let [matched, patch, ..] = self.physics.as_slice() else {
            return Ok(());
        };
        let ratio = |error: &PhysicsError| error.together.rms_log_ratio.unwrap_or(f64::NAN);
        let (better, worse) = if ratio(patch) < ratio(matched) {
            (patch, matched)
        } else {
            (matched, patch)
        };
        writeln!(
            f,
            "{} explains the recordings better than {}: RMS ln ratio {:.2} against {:.2}, \
             RMS {:.0} against {:.0} counts",
            better.physics,
            worse.physics,
            ratio(better),
            ratio(worse),
            better.together.rms_counts,
            worse.together.rms_counts,
        )
    }
}
