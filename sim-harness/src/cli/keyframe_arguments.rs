//! Which poses of a drive `map` maps.

use clap::Args;
use sim_harness::drive::Keyframes;

/// Arguments for the poses that are mapped.
#[derive(Debug, Args)]
pub(super) struct KeyframeArguments {
    /// Map all poses, not only keyframes: poses 0.10 m or 5 degrees from the last one. Of an
    /// AMiRo, and by `kleppe` and `pgc`, every step is mapped unless one of the next two is given.
    #[arg(long, conflicts_with_all = ["keyframe_mm", "keyframe_deg"])]
    all_poses: bool,
    /// Least distance of a keyframe from the last one; 100 if only --keyframe-deg is given.
    #[arg(long, value_name = "MM", value_parser = clap::value_parser!(u16).range(1..))]
    keyframe_mm: Option<u16>,
    /// Least turn of a keyframe from the last one; 5 if only --keyframe-mm is given.
    #[arg(long, value_name = "DEG", value_parser = clap::value_parser!(u16).range(1..=180))]
    keyframe_deg: Option<u16>,
}

impl KeyframeArguments {
    /// The keyframes that were asked for.
    pub(super) fn given(&self) -> Option<Keyframes> {
        match (self.all_poses, self.keyframe_mm, self.keyframe_deg) {
            (true, ..) => Some(Keyframes::new(0.0, 0.0)),
            (false, None, None) => None,
            (false, mm, deg) => Some(Keyframes::new(
                1e-3 * f64::from(mm.unwrap_or(100)),
                f64::from(deg.unwrap_or(5)).to_radians(),
            )),
        }
    }
}
