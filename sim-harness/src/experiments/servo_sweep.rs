//! Sweeps of a sensor that stands and turns.

use crate::datasets::{Dataset, DatasetError, DriveFile, ReadRows};
use crate::drive::{Record, Return};
use crate::geometry::Vector;

/// One reading of a sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweepReading {
    /// Direction of the sensor, radians.
    pub bearing_rad: f64,
    /// What it measured.
    pub measured: Return,
}

impl SweepReading {
    /// Where the echo was; `None` without one.
    #[must_use]
    pub fn end(&self) -> Option<Vector> {
        let (sine, cosine) = libm::sincos(self.bearing_rad);
        match self.measured {
            Return::Echo { range_m, .. } => Some(Vector::new(cosine, sine).scaled(range_m)),
            _ => None,
        }
    }
}

/// The readings of one sweep, in their order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ServoSweep {
    /// The readings.
    pub readings: Vec<SweepReading>,
}

impl ServoSweep {
    /// Number of readings with an echo.
    #[must_use]
    pub fn echoes(&self) -> usize {
        self.ends().count()
    }

    /// Where the echoes were.
    pub fn ends(&self) -> impl Iterator<Item = Vector> {
        self.readings.iter().filter_map(SweepReading::end)
    }

    /// The greatest limit of the returns without an echo; `None` if all have one.
    #[must_use]
    pub fn limit_m(&self) -> Option<f64> {
        let limits = self.readings.iter().filter_map(|it| match it.measured {
            Return::NoEcho { limit_m, .. } => Some(limit_m),
            _ => None,
        });
        limits.reduce(f64::max)
    }

    /// The least and the greatest direction, radians.
    #[must_use]
    pub fn sector(&self) -> [f64; 2] {
        let bearings = || self.readings.iter().map(|it| it.bearing_rad);
        [
            bearings().fold(f64::INFINITY, f64::min),
            bearings().fold(f64::NEG_INFINITY, f64::max),
        ]
    }

    /// The reading nearest in direction.
    #[must_use]
    pub fn towards(&self, bearing_rad: f64) -> Option<&SweepReading> {
        let apart = |it: &SweepReading| (it.bearing_rad - bearing_rad).abs();
        let readings = self.readings.iter();
        readings.min_by(|a, b| apart(a).total_cmp(&apart(b)))
    }
}

/// The sweeps of a drive: a reset of the odometry begins a new one.
///
/// # Errors
/// As [`Dataset::read`].
pub fn sweeps(
    dataset: &dyn Dataset,
    drive: &DriveFile<'_>,
) -> Result<(Vec<ServoSweep>, ReadRows), DatasetError> {
    let mut all = vec![ServoSweep::default()];
    let rows = dataset.read(drive, &mut |_, _| {}, &mut |record| match record {
        Record::OdometryReset { .. } => all.push(ServoSweep::default()),
        Record::Scan(scan) => {
            if let (Some(sweep), Some(measured)) = (all.last_mut(), scan.returns.first()) {
                sweep.readings.push(SweepReading {
                    bearing_rad: scan.world_from_body.heading_rad(),
                    measured: *measured,
                });
            }
        }
        _ => {}
    })?;
    Ok((all, rows))
}
