//! The walls around a run of the recordings.

use std::path::Path;

use super::super::DatasetError;
use crate::world::TrueWorld;

/// The walls of the environment that the repository's notebook gives for a run, from the
/// files of walls beside the experiments; `None` for another folder, and without the file.
pub(super) fn walls_of(run: &Path) -> Result<Option<TrueWorld>, DatasetError> {
    let path = run.canonicalize().unwrap_or_else(|_| run.to_owned());
    let name = |path: &Path| Some(path.file_name()?.to_str()?.to_owned());
    let Some((experiment, run)) = path.parent().and_then(name).zip(name(&path)) else {
        return Ok(None);
    };
    let walls = match (experiment.as_str(), run.as_str()) {
        ("exp1", "two-drones") => "walls_env1a.csv",
        ("exp1", "four-drones") => "walls_env1b.csv",
        ("exp2", _) => "walls_env2.csv",
        _ => return Ok(None),
    };
    let walls = path
        .parent()
        .and_then(Path::parent)
        .map(|it| it.join(walls));
    let walls = walls.filter(|walls| walls.is_file());
    let world = walls.as_deref().map(TrueWorld::load_walls).transpose();
    world.map_err(DatasetError::Walls)
}
