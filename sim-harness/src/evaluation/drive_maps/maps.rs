//! Maps a recorded drive by each of the methods that have their sensors in it.

use std::cell::RefCell;
use std::time::Instant;

use super::peak_memory::PeakMemory;
use super::{MapRow, MapTable, RecordedDrive};
use crate::datasets::{DatasetError, PoseSource};
use crate::drive::{Keyframes, RingCalibration};
use crate::evaluation::cell_truth::{CellScores, DriveSurvey, DriveTruth, ScoredCells};
use crate::lattice::Lattice;
use crate::mapping::{FinishProgress, Map, Mapper, Method, NoEcho, Occupancy, Setup};
use crate::pipeline::{self, DriveOptions, DriveSummary, KeyframeShare};
use crate::world::TrueWorld;

/// The layers in whose cells maps of the even keyframes are scored.
const LAYERS: [Method; 2] = [Method::LASER, Method::SONAR];

/// How drives are mapped.
#[derive(Clone, Debug)]
pub struct MapSettings {
    /// The methods, each once.
    pub methods: Vec<Method>,
    /// Which poses are used.
    pub poses: PoseSource,
    /// Which of them are mapped; `None` for those that are usual of format and method.
    pub keyframes: Option<Keyframes>,
    /// Only mounts whose names begin with one of these; empty for all.
    pub sensors: Vec<String>,
    /// Side of a cell, millimetres; `None` for the usual one of the format.
    pub cell_mm: Option<u16>,
    /// Whether cells before the limit of a return without an echo are free.
    pub no_echo_is_free: bool,
    /// Alpha and gains of an AMiRo's sensors.
    pub calibration: Option<RingCalibration>,
}

/// How far the maps have come.
#[derive(Clone, Copy, Debug)]
pub enum MapProgress {
    /// Bytes read of the recording, and how many there are to read where that is known.
    Read {
        /// The method, or what else it is read for.
        what: &'static str,
        /// Bytes so far.
        bytes: u64,
        /// All of them.
        of: Option<u64>,
    },
    /// The end of a method that needs all records first.
    Finish(FinishProgress),
}

/// The map of one method.
#[derive(Debug)]
pub struct MethodMap {
    /// The map.
    pub map: Map,
    /// What was read of the drive for it.
    pub read: DriveSummary,
    /// Whether it is a map of the even keyframes alone.
    pub splits: bool,
    /// Time of the pass over the recording and of the method, seconds.
    pub seconds: f64,
    /// Most memory on the heap, bytes.
    pub peak_bytes: u64,
}

/// The maps of a drive.
#[derive(Debug)]
pub struct DriveMaps {
    /// What is in the recording; mounts without data are those that were asked for.
    pub survey: DriveSummary,
    /// The truth, if it is known.
    pub truth: Option<DriveTruth>,
    /// The methods with their maps, or why there is none.
    pub tried: Vec<(Method, Result<MethodMap, String>)>,
    /// The cells in which maps of the even keyframes are scored.
    of_split: ScoredCells,
    recording: String,
    poses: PoseSource,
    lattice: Lattice,
}

impl DriveMaps {
    /// Maps a drive: one pass over the recording for its truth, and one per method.
    ///
    /// # Errors
    /// The recording cannot be read, or its rig has other sensors.
    pub fn make(
        drive: &RecordedDrive,
        settings: &MapSettings,
        progress: &mut dyn FnMut(MapProgress),
    ) -> Result<Self, DatasetError> {
        let usual_mm = drive.dataset.usual().cell_mm;
        let cell_m = 1e-3 * f64::from(settings.cell_mm.unwrap_or(usual_mm));
        let mut lattice = Lattice::new(cell_m);
        let lies_on_borders = |world: &TrueWorld| world.lies_on_borders(cell_m);
        if drive.world.as_ref().is_some_and(lies_on_borders) {
            lattice = lattice.moved_by_half_a_cell();
        }
        let (mut survey, truth) = survey(drive, lattice, settings, progress)?;
        let pass = Pass {
            drive,
            settings,
            lattice,
            truth: truth.as_ref(),
        };
        let mut try_method =
            |method: &Method| match drive.mounts(method, &survey, &settings.sensors) {
                Ok(mounts) => pass.map_by(method, mounts, progress),
                Err(missing) => Ok(Err(missing)),
            };
        let mut tried = Vec::new();
        for method in &settings.methods {
            tried.push((*method, try_method(method)?));
        }
        // The cells of the layers do not depend on which of them are asked for.
        let is_split = |(_, made): &(Method, Result<MethodMap, String>)| {
            made.as_ref().is_ok_and(|made| made.splits)
        };
        let mut not_asked_for = Vec::new();
        if tried.iter().any(is_split) {
            for layer in LAYERS
                .into_iter()
                .filter(|it| !settings.methods.contains(it))
            {
                not_asked_for.extend(try_method(&layer)?);
            }
        }
        let asked_for = tried.iter().filter(|(method, _)| LAYERS.contains(method));
        let asked_for = asked_for.filter_map(|(_, made)| made.as_ref().ok());
        let layers: Vec<&Map> = asked_for.chain(&not_asked_for).map(|it| &it.map).collect();
        let named = drive.rig.mounts_named(&settings.sensors);
        let named: Vec<_> = drive.rig.mounts.iter().zip(named).collect();
        let is_named = |name: &String| named.iter().any(|(it, named)| *named && it.name == *name);
        survey.mounts_without_data.retain(is_named);
        Ok(Self {
            of_split: ScoredCells::known_in(&layers, lattice, &drive.rig),
            survey,
            truth,
            tried,
            recording: drive.path.display().to_string(),
            poses: settings.poses,
            lattice,
        })
    }

    /// The methods that made a map.
    pub fn made(&self) -> impl Iterator<Item = (&Method, &MethodMap)> {
        let tried = self.tried.iter();
        tried.filter_map(|(method, made)| Some((method, made.as_ref().ok()?)))
    }

    /// A row per method.
    #[must_use]
    pub fn rows(&self) -> Vec<MapRow> {
        let row = |(method, outcome): &(Method, Result<MethodMap, String>)| match outcome {
            Ok(made) => MapRow {
                scores: self.scores(method, made),
                map_cells: Some(
                    [Occupancy::Occupied, Occupancy::Free].map(|class| made.map.count(class)),
                ),
                seconds: Some(made.seconds),
                peak_bytes: Some(made.peak_bytes),
                splits_keyframes: made.splits,
                ..self.no_map(method.name)
            },
            Err(reason) => MapRow {
                not_applicable: Some(reason.clone()),
                ..self.no_map(method.name)
            },
        };
        self.tried.iter().map(row).collect()
    }

    fn no_map(&self, method: &'static str) -> MapRow {
        MapRow {
            poses: self.poses.name(),
            cell_m: Some(self.lattice.cell_m()),
            ..MapRow::new(&self.recording, method)
        }
    }

    fn scores(&self, method: &Method, made: &MethodMap) -> Option<CellScores> {
        let truth = self.truth.as_ref()?;
        Some(match &truth.of_odd_keyframes {
            _ if *method == Method::ALL_FREE => truth.all_free(),
            Some(odd) if made.splits => CellScores::of(&made.map, odd, &self.of_split),
            _ => truth.scores(&made.map),
        })
    }

    /// The table of rows that are its own.
    #[must_use]
    pub fn table<'a>(&self, rows: &'a [MapRow]) -> MapTable<'a> {
        let truth = self.truth.as_ref();
        let odd = truth.and_then(|truth| truth.of_odd_keyframes.as_ref());
        let odd = odd.filter(|_| rows.iter().any(|row| row.splits_keyframes));
        MapTable {
            rows,
            all_free: truth.map(DriveTruth::all_free),
            all_free_of_split: odd.map(|odd| CellScores::of_all_free(odd, &self.of_split)),
        }
    }
}

/// Reads the drive once, for what is in it and for its truth; `None` if it has none.
fn survey(
    drive: &RecordedDrive,
    lattice: Lattice,
    settings: &MapSettings,
    progress: &mut dyn FnMut(MapProgress),
) -> Result<(DriveSummary, Option<DriveTruth>), DatasetError> {
    let world = drive.world.as_ref();
    let mut survey = world.map(|world| DriveSurvey::new(world, &drive.rig, lattice));
    let usual = drive.dataset.usual().keyframes;
    let options = DriveOptions {
        keyframes: settings.keyframes.unwrap_or(usual),
        share: KeyframeShare::All,
        mounts: vec![true; drive.rig.mounts.len()],
    };
    let read = pipeline::dataset_records(
        drive.dataset,
        &drive.file(None, settings.poses, settings.calibration),
        &options,
        &mut |bytes, of| {
            let what = "looked through";
            progress(MapProgress::Read { what, bytes, of });
        },
        &mut |record| {
            if let Some(survey) = &mut survey {
                survey.take(record);
            }
        },
    )?;
    Ok((read, survey.map(DriveSurvey::finish)))
}

/// A pass over a drive for one method.
struct Pass<'a> {
    drive: &'a RecordedDrive,
    settings: &'a MapSettings,
    lattice: Lattice,
    truth: Option<&'a DriveTruth>,
}

impl Pass<'_> {
    /// Maps the drive; the inner error is why there is no map.
    fn map_by(
        &self,
        method: &Method,
        mounts: Vec<bool>,
        progress: &mut dyn FnMut(MapProgress),
    ) -> Result<Result<MethodMap, String>, DatasetError> {
        let (drive, settings) = (self.drive, self.settings);
        let memory = PeakMemory::start();
        let started = Instant::now();
        let mut mapper = method.mapper(&Setup {
            no_echo: settings.no_echo_is_free.then_some(NoEcho::Free),
            ..Setup::new(&drive.rig, self.lattice)
        });
        let is_by_scanner = self.truth.is_some_and(|it| it.of_odd_keyframes.is_some());
        let splits = method.splits_keyframes && is_by_scanner;
        let usual = method.keyframes(drive.dataset.usual().keyframes);
        let options = DriveOptions {
            keyframes: settings.keyframes.unwrap_or(usual),
            share: if splits {
                KeyframeShare::Even
            } else {
                KeyframeShare::All
            },
            mounts,
        };
        let progress = RefCell::new(progress);
        let what = method.name;
        let mut show = |bytes, of| progress.borrow_mut()(MapProgress::Read { what, bytes, of });
        let file = drive.file(Some(method), settings.poses, settings.calibration);
        let read = pipeline::run_with_progress(
            |take| pipeline::dataset_records(drive.dataset, &file, &options, &mut show, take),
            &mut mapper,
            &mut |_, _| {},
            &mut |finish| progress.borrow_mut()(MapProgress::Finish(finish)),
        )?;
        let map = mapper.map();
        let (seconds, peak_bytes) = (started.elapsed().as_secs_f64(), memory.bytes());
        if let (Err(reason), false) = (read.check(&map), *method == Method::ALL_FREE) {
            return Ok(Err(format!("no map: {reason}")));
        }
        Ok(Ok(MethodMap {
            map,
            read,
            splits,
            seconds,
            peak_bytes,
        }))
    }
}
