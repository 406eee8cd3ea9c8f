//! `cargo ipf map`: recorded drives of any robot, mapped by one method or by many.

use std::cell::RefCell;
use std::error::Error;

use sim_harness::console;
use sim_harness::evaluation::drive_maps::{
    DriveMaps, MapProgress, MapRow, MapSettings, RecordedDrive,
};
use sim_harness::evaluation::json_lines;
use sim_harness::mapping::{FinishProgress, Method};
use sim_harness::output;
use sim_harness::report::summary_of;

use super::map_arguments::MapCommand;
use super::progress::PassProgress;
use super::{CommandResult, ExitStatus, arguments, cell_limit, map_report};

impl MapCommand {
    /// Runs the command.
    pub(super) fn run(self) -> CommandResult {
        arguments::check_folder("--out", &self.out)?;
        let settings = self.settings()?;
        let drives = self.recorded_drives(&settings)?;
        self.check_outputs(&drives, &settings)?;
        let mut rows = Vec::new();
        let (mut has_refused, mut has_failed) = (false, false);
        for (drive, files) in &drives {
            if drives.len() > 1 {
                console::print(format_args!("{}", drive.path.display()));
            }
            let maps = match make(drive, &settings) {
                Err(error) if drives.len() > 1 => {
                    console::warn(&error);
                    has_failed = true;
                    let path = drive.path.display().to_string();
                    rows.extend(settings.methods.iter().map(|method| MapRow {
                        not_applicable: Some(error.to_string()),
                        ..MapRow::new(&path, method.name)
                    }));
                    continue;
                }
                made => made?,
            };
            let of_drive = maps.rows();
            files.save(drive, &settings, &maps, &of_drive)?;
            show(drive, &settings, &maps, &of_drive);
            has_refused |= maps.survey.refused.count > 0;
            rows.extend(of_drive);
        }
        if let Some(path) = &self.json {
            output::write(path, json_lines(&rows)?.as_bytes())?;
        }
        Ok(if has_failed || self.strict && has_refused {
            ExitStatus::Refused
        } else {
            ExitStatus::Good
        })
    }
}

fn make(drive: &RecordedDrive, settings: &MapSettings) -> Result<DriveMaps, Box<dyn Error>> {
    let cell_mm = settings.cell_mm.unwrap_or(drive.dataset.usual().cell_mm);
    cell_limit::check(&drive.rig, cell_mm)?;
    let progress = RefCell::new(PassProgress::default());
    let maps = DriveMaps::make(drive, settings, &mut |step| {
        let mut progress = progress.borrow_mut();
        match step {
            MapProgress::Read { what, bytes, of } => progress.show(what, bytes, of),
            MapProgress::Finish(FinishProgress { stage, done, of }) => {
                progress.show_count(stage, done, of);
            }
        }
    })?;
    drop(progress);
    map_report::left_out(&maps.survey);
    check_made(drive, &maps)?;
    Ok(maps)
}

/// Of one method its map is asked for; of several at least one.
fn check_made(drive: &RecordedDrive, maps: &DriveMaps) -> Result<(), String> {
    let path = drive.path.display();
    match &maps.tried[..] {
        [(method, Err(reason))] => Err(format!("{path}: {method}: {reason}")),
        _ if maps.made().next().is_none() => Err(format!("{path}: no method has its sensors here")),
        _ => Ok(()),
    }
}

fn show(drive: &RecordedDrive, settings: &MapSettings, maps: &DriveMaps, rows: &[MapRow]) {
    if let [(method, Ok(made))] = &maps.tried[..] {
        map_report::figures(&summary_of(drive, settings, method, made));
    }
    for (method, made) in maps.made().filter(|it| *it.0 != Method::ALL_FREE) {
        map_report::cut(&summary_of(drive, settings, method, made));
    }
    if let Some(truth) = &maps.truth {
        map_report::truth(drive, truth);
        map_report::cut_truth(&truth.cells);
    }
    console::print_text(maps.table(rows));
}
