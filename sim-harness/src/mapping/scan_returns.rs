//! The returns of a scan, mount by mount.

use crate::drive::{RangeScan, Return};
use crate::geometry::Pose2;
use crate::rig::{Rig, SensorMount};
use crate::sensors::Sensor;

/// The returns of one mount in a scan.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MountReturns<'a> {
    /// Its number in the rig.
    pub(crate) index: usize,
    /// The mount.
    pub(crate) mount: &'a SensorMount,
    /// Where its sensor was.
    pub(crate) world_from_sensor: Pose2,
    returns: &'a [Return],
}

/// The returns of a scan, mount by mount; mounts that the rig does not have are left out.
pub(crate) fn mount_returns<'a>(
    rig: &'a Rig,
    scan: &'a RangeScan,
) -> impl Iterator<Item = MountReturns<'a>> {
    let mut rest = scan.returns.as_slice();
    let mounts = rig.mounts.get(scan.mounts.clone()).unwrap_or_default();
    mounts
        .iter()
        .zip(scan.mounts.clone())
        .map(move |(mount, index)| {
            let count = mount.sensor.model().returns().min(rest.len());
            let (returns, behind) = rest.split_at(count);
            rest = behind;
            MountReturns {
                index,
                mount,
                world_from_sensor: scan.world_from_body * mount.body_from_sensor,
                returns,
            }
        })
}

impl MountReturns<'_> {
    /// The returns as they were recorded.
    pub(crate) fn recorded(&self) -> impl Iterator<Item = Return> {
        self.returns.iter().copied()
    }

    /// The returns within the sensor's limits; see [`within_limits`].
    pub(super) fn returns(&self) -> impl Iterator<Item = Return> {
        let farthest_m = farthest_m(&self.mount.sensor);
        self.recorded()
            .map(move |measured| within_limits(measured, farthest_m))
    }
}

/// Farthest range that a sensor measures, metres.
pub(super) fn farthest_m(sensor: &Sensor) -> f64 {
    match sensor {
        Sensor::Infrared(infrared) => f64::from(infrared.photometry().x_max_m),
        Sensor::Cone(cone) => cone.range_m[1],
        Sensor::Scanner(scanner) => scanner.range_m[1],
    }
}

/// A return with its range within a sensor's limit, so that the cells of a return are few.
///
/// An echo beyond the limit is no echo up to the limit; a range that is not a positive
/// number is no measurement.
fn within_limits(measured: Return, farthest_m: f64) -> Return {
    match measured {
        Return::Echo { range_m, .. } if range_m > 0.0 && range_m <= farthest_m => measured,
        Return::Echo { range_m, sigma_m } if range_m > farthest_m => Return::NoEcho {
            limit_m: farthest_m,
            sigma_m,
        },
        Return::NoEcho { limit_m, sigma_m } if limit_m > 0.0 => Return::NoEcho {
            limit_m: limit_m.min(farthest_m),
            sigma_m,
        },
        Return::TooClose => Return::TooClose,
        Return::Echo { .. } | Return::NoEcho { .. } | Return::Invalid => Return::Invalid,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_beyond_the_limit_are_no_echo_and_what_is_no_number_is_invalid() {
        let echo = |range_m| Return::Echo {
            range_m,
            sigma_m: 0.1,
        };
        let no_echo = |limit_m| Return::NoEcho {
            limit_m,
            sigma_m: 0.1,
        };
        for (measured, expected) in [
            (echo(2.0), echo(2.0)),
            (echo(2.1), no_echo(2.0)),
            (echo(f64::INFINITY), no_echo(2.0)),
            (echo(f64::NAN), Return::Invalid),
            (echo(-1.0), Return::Invalid),
            (no_echo(1.5), no_echo(1.5)),
            (no_echo(1e300), no_echo(2.0)),
            (no_echo(f64::NAN), Return::Invalid),
            (Return::TooClose, Return::TooClose),
            (Return::Invalid, Return::Invalid),
        ] {
            assert_eq!(within_limits(measured, 2.0), expected, "{measured:?}");
        }
    }
}
