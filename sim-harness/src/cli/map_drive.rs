//! Maps one recording by each of the methods that have their sensors in it.

use std::cell::RefCell;
use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

use sim_harness::console;
use sim_harness::datasets::{Amiro, Dataset, DatasetError, DriveFile, PoseSource};
use sim_harness::drive::{RingCalibration, TrueWorld};
use sim_harness::evaluation::cell_truth::{
    CellScores, DriveSurvey, DriveTruth, ScoredCells, TrueCell,
};
use sim_harness::lattice::Lattice;
use sim_harness::mapping::{FinishProgress, Map, Mapper, Method, NoEcho, Setup};
use sim_harness::output::{self, WriteError};
use sim_harness::pipeline::{self, DriveOptions, DriveSummary, KeyframeShare};
use sim_harness::report::{CellWindow, ContactSheet, DRIVE_FILES, DriveMapSummary, MapPicture};
use sim_harness::rig::Rig;

use super::keyframe_arguments::KeyframeArguments;
use super::map_report;
use super::map_table::{self, MapRow};
use super::peak_memory::PeakMemory;
use super::progress::PassProgress;

/// The files beside the maps of several methods.
const SHEET_FILES: [&str; 2] = ["contact_sheet.png", "truth.png"];

/// What all recordings of a command are mapped with.
pub(super) struct MapSettings<'a> {
    pub(super) methods: Vec<Method>,
    /// Whether there is one method, whose files need no folder of their own.
    pub(super) is_alone: bool,
    pub(super) calibration: Option<RingCalibration>,
    pub(super) poses: PoseSource,
    pub(super) no_echo_is_free: bool,
    pub(super) sensors: &'a [String],
    pub(super) keyframes: &'a KeyframeArguments,
    pub(super) cell_mm: Option<u16>,
}

/// A recording to be mapped.
pub(super) struct Recording {
    pub(super) path: PathBuf,
    pub(super) dataset: &'static dyn Dataset,
    pub(super) rig: Rig,
    pub(super) world: Option<TrueWorld>,
    pub(super) out: PathBuf,
}

/// A recording that was mapped.
pub(super) struct MappedRecording {
    pub(super) rows: Vec<MapRow>,
    pub(super) has_refused_rows: bool,
}

/// The map of one method.
struct MethodMap {
    map: Map,
    run: DriveSummary,
    /// Whether it is a map of the even keyframes alone.
    splits: bool,
    seconds: f64,
    peak_bytes: u64,
}

impl Recording {
    /// The files that will be written.
    pub(super) fn outputs(&self, settings: &MapSettings<'_>) -> Vec<PathBuf> {
        let of_method = |method: &Method| {
            let folder = self.folder(method, settings);
            DRIVE_FILES.map(|name| folder.join(name))
        };
        let mut files: Vec<PathBuf> = settings.methods.iter().flat_map(of_method).collect();
        if !settings.is_alone {
            files.extend(SHEET_FILES.map(|name| self.out.join(name)));
        }
        files
    }

    fn folder(&self, method: &Method, settings: &MapSettings<'_>) -> PathBuf {
        if settings.is_alone {
            self.out.clone()
        } else {
            self.out.join(method.name)
        }
    }

    /// Maps the recording, writes the files and prints the table.
    pub(super) fn map(
        &self,
        settings: &MapSettings<'_>,
    ) -> Result<MappedRecording, Box<dyn Error>> {
        let usual_mm = self.dataset.usual().cell_mm;
        let cell_m = 1e-3 * f64::from(settings.cell_mm.unwrap_or(usual_mm));
        let mut lattice = Lattice::new(cell_m);
        let lies_on_borders = |world: &TrueWorld| world.lies_on_borders(cell_m);
        if self.world.as_ref().is_some_and(lies_on_borders) {
            lattice = lattice.moved_by_half_a_cell();
        }
        let (survey, truth) = self.survey(lattice, settings)?;
        self.warn(&survey, settings);
        let truth = truth.as_ref();
        let mut tried = Vec::new();
        for method in &settings.methods {
            let outcome = match self.mounts(method, &survey, settings) {
                Ok(mounts) => self.map_by(method, mounts, lattice, truth, settings)?,
                Err(missing) => Err(missing),
            };
            if let (Err(reason), true) = (&outcome, settings.is_alone) {
                return Err(format!("{}: {method}: {reason}", self.path.display()).into());
            }
            tried.push((*method, outcome));
        }
        self.report(&tried, truth, lattice, settings)
    }

    /// The mounts that a method maps, or why it cannot.
    fn mounts(
        &self,
        method: &Method,
        survey: &DriveSummary,
        settings: &MapSettings<'_>,
    ) -> Result<Vec<bool>, String> {
        let is_of_filter = method.profile.is_some() || method.fits_signals;
        if is_of_filter && self.dataset.name() != Amiro.name() {
            return Err("needs infrared sensors: signals of an AMiRo's ring".to_owned());
        }
        let named = self.rig.mounts_named(settings.sensors);
        let mounts = self.rig.mounts.iter().zip(named);
        let allowed: Vec<bool> = mounts
            .map(|(mount, is_named)| is_named && !survey.mounts_without_data.contains(&mount.name))
            .collect();
        let mounts = method.sensors.mounts(&self.rig, &allowed);
        mounts.map_err(|missing| missing.to_string())
    }

    /// Warns of what was refused and is missing.
    fn warn(&self, survey: &DriveSummary, settings: &MapSettings<'_>) {
        let named = self
            .rig
            .mounts
            .iter()
            .zip(self.rig.mounts_named(settings.sensors));
        let is_named = |name: &String| named.clone().any(|(it, named)| named && it.name == *name);
        let mut survey = survey.clone();
        survey.mounts_without_data.retain(is_named);
        map_report::left_out(&survey);
    }

    /// Reads the drive once, for what is in it and for its truth; `None` if it has none.
    fn survey(
        &self,
        lattice: Lattice,
        settings: &MapSettings<'_>,
    ) -> Result<(DriveSummary, Option<DriveTruth>), DatasetError> {
        let world = self.world.as_ref();
        let mut survey = world.map(|world| DriveSurvey::new(world, &self.rig, lattice));
        let options = DriveOptions {
            keyframes: settings.keyframes.keyframes(self.dataset.usual().keyframes),
            share: KeyframeShare::All,
            mounts: vec![true; self.rig.mounts.len()],
        };
        let mut progress = PassProgress::default();
        let read = pipeline::dataset_records(
            self.dataset,
            &self.drive(None, settings),
            &options,
            &mut |bytes, length| progress.show("looked through", bytes, length),
            &mut |record| {
                if let Some(survey) = &mut survey {
                    survey.take(record);
                }
            },
        )?;
        Ok((read, survey.map(DriveSurvey::finish)))
    }

    fn drive<'s>(&'s self, method: Option<&Method>, settings: &MapSettings<'_>) -> DriveFile<'s> {
        DriveFile {
            path: &self.path,
            rig: &self.rig,
            poses: settings.poses,
            calibration: settings.calibration,
            profile: method.and_then(|method| method.profile),
        }
    }

    /// Maps the drive by one method; the inner error is why there is no map.
    fn map_by(
        &self,
        method: &Method,
        mounts: Vec<bool>,
        lattice: Lattice,
        truth: Option<&DriveTruth>,
        settings: &MapSettings<'_>,
    ) -> Result<Result<MethodMap, String>, DatasetError> {
        let memory = PeakMemory::start();
        let started = Instant::now();
        let mut mapper = method.mapper(&Setup {
            no_echo: settings.no_echo_is_free.then_some(NoEcho::Free),
            ..Setup::new(&self.rig, lattice)
        });
        let splits =
            method.splits_keyframes && truth.is_some_and(|it| it.of_odd_keyframes.is_some());
        let usual = method.keyframes(self.dataset.usual().keyframes);
        let options = DriveOptions {
            keyframes: settings.keyframes.keyframes(usual),
            share: if splits {
                KeyframeShare::Even
            } else {
                KeyframeShare::All
            },
            mounts,
        };
        let progress = RefCell::new(PassProgress::default());
        let mut show = |bytes, length| progress.borrow_mut().show(method.name, bytes, length);
        let drive = self.drive(Some(method), settings);
        let run = pipeline::run_with_progress(
            |take| pipeline::dataset_records(self.dataset, &drive, &options, &mut show, take),
            &mut mapper,
            &mut |_, _| {},
            &mut |FinishProgress { stage, done, of }| {
                progress.borrow_mut().show_count(stage, done, of);
            },
        )?;
        let map = mapper.map();
        let (seconds, peak_bytes) = (started.elapsed().as_secs_f64(), memory.bytes());
        if let (Err(reason), false) = (run.check(&map), *method == Method::ALL_FREE) {
            return Ok(Err(format!("no map: {reason}")));
        }
        Ok(Ok(MethodMap {
            map,
            run,
            splits,
            seconds,
            peak_bytes,
        }))
    }

    /// Scores the maps, writes the files and prints what there is to say.
    fn report(
        &self,
        tried: &[(Method, Result<MethodMap, String>)],
        truth: Option<&DriveTruth>,
        lattice: Lattice,
        settings: &MapSettings<'_>,
    ) -> Result<MappedRecording, Box<dyn Error>> {
        let made = || {
            tried
                .iter()
                .filter_map(|(method, it)| Some((method, it.as_ref().ok()?)))
        };
        if made().next().is_none() {
            return Err(format!("{}: no method has its sensors here", self.path.display()).into());
        }
        let split: Vec<&Map> = made()
            .filter(|it| it.1.splits)
            .map(|it| &it.1.map)
            .collect();
        let of_split = ScoredCells::known_in(&split, lattice, &self.rig);
        let scores = |method: &Method, made: &MethodMap| {
            let truth = truth?;
            Some(match &truth.of_odd_keyframes {
                _ if *method == Method::ALL_FREE => truth.all_free(),
                Some(odd) if made.splits => CellScores::of(&made.map, odd, &of_split),
                _ => truth.scores(&made.map),
            })
        };
        let recording = self.path.display().to_string();
        let rows: Vec<MapRow> = tried
            .iter()
            .map(|(method, outcome)| match outcome {
                Ok(made) => MapRow {
                    scores: scores(method, made),
                    seconds: Some(made.seconds),
                    peak_bytes: Some(made.peak_bytes),
                    splits_keyframes: made.splits,
                    ..MapRow::new(&recording, method.name)
                },
                Err(reason) => MapRow {
                    not_applicable: Some(reason.clone()),
                    ..MapRow::new(&recording, method.name)
                },
            })
            .collect();
        for (method, made) in made().filter(|(method, _)| **method != Method::ALL_FREE) {
            let words = [self.dataset.name(), method.name, settings.poses.name()];
            let summary = DriveMapSummary::of(words, &self.rig, &made.run, &made.map);
            let folder = self.folder(method, settings);
            output::create_folder(&folder)?;
            summary.save(&folder, &made.map, &self.rig, &made.run)?;
            if settings.is_alone {
                map_report::figures(&summary);
            }
        }
        let split_all_free = truth
            .and_then(|truth| truth.of_odd_keyframes.as_ref())
            .filter(|_| !split.is_empty())
            .map(|odd| CellScores::of_all_free(odd, &of_split));
        if !settings.is_alone {
            self.save_sheet(&made().collect::<Vec<_>>(), &rows, truth)?;
        }
        if let Some(truth) = truth {
            console::print(format_args!(
                "truth: {} occupied and {} free cells of {:.0} mm",
                truth.cells.number_of(TrueCell::Occupied),
                truth.cells.number_of(TrueCell::Free),
                1e3 * lattice.cell_m()
            ));
        }
        map_table::print(&rows, truth.map(DriveTruth::all_free), split_all_free);
        Ok(MappedRecording {
            rows,
            has_refused_rows: made().any(|(_, made)| made.run.refused.count > 0),
        })
    }

    /// All maps on one sheet, and the truth.
    fn save_sheet(
        &self,
        made: &[(&Method, &MethodMap)],
        rows: &[MapRow],
        truth: Option<&DriveTruth>,
    ) -> Result<(), WriteError> {
        output::create_folder(&self.out)?;
        // A scanner looks farther than the sensors of the other methods.
        let window_of = |splits: bool| {
            let maps = made.iter().filter(|(_, made)| made.splits == splits);
            let known = maps.filter_map(|(_, made)| CellWindow::known(&made.map));
            known.reduce(CellWindow::joined)
        };
        let window = window_of(false).or_else(|| window_of(true));
        let (Some(window), Some((_, first))) = (window, made.first()) else {
            return Ok(());
        };
        let (path, jumps) = (&first.run.path, &first.run.jumps);
        let mut sheet = ContactSheet::new(window, path, jumps);
        if let Some(truth) = truth {
            let map = truth.map();
            sheet.add("truth".to_owned(), &map);
            let picture = MapPicture {
                title: Some("truth"),
                path,
                jumps,
                ..MapPicture::default()
            };
            picture.render(&map).save_png(&self.out.join("truth.png"))?;
        }
        for (method, made) in made.iter().filter(|it| *it.0 != Method::ALL_FREE) {
            let row = rows.iter().find(|row| row.method == method.name);
            let label = row.map_or_else(|| method.name.to_owned(), MapRow::label);
            sheet.add(label, &made.map);
        }
        let picture = sheet.render();
        picture.save_png(&self.out.join("contact_sheet.png"))
    }
}
