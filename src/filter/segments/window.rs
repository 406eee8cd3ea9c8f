//! The readings of the last few steps, with the poses that they were taken at.

use super::SegmentParameters;
use crate::geometry::{Point, Rotation};
use crate::math;
use crate::model::{Mount, SENSORS, Sample, TabulatedWallLaw, Wall};

/// A reading, ready for comparison.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct LogReading {
    /// d, counts above beta.
    pub(super) signal: f32,
    /// ln(d + d0).
    pub(super) log_signal: f32,
    /// 1 / sd; 0 for a sensor without counts, which is left out.
    pub(super) inverse_sigma: f32,
}

/// The readings of one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct StepReadings {
    /// The robot's centre, relative to where it is now.
    pub(super) position: Point,
    /// Direction of the body in the tracker's axes.
    pub(super) heading: Rotation,
    pub(super) measured: [LogReading; SENSORS],
}

/// Place and axis of a sensor in the tracker's axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    pub(super) position: Point,
    pub(super) axis: Rotation,
}

impl LogReading {
    fn of(sample: Sample, law: &TabulatedWallLaw, parameters: &SegmentParameters) -> Self {
        let Sample::Counts(counts) = sample else {
            return Self::default();
        };
        let signal = counts as f32 - law.beta_counts();
        // Noise may take a dark reading below -d0; 2 counts are as dark as 0.
        let lifted = (signal + parameters.soft_counts).max(2.0);
        let noise = parameters.sigma_counts / lifted;
        let relative = parameters.relative_sigma;
        let variance = noise * noise + relative * relative;
        Self {
            signal,
            log_signal: math::ln(lifted),
            inverse_sigma: 1.0 / math::sqrt(variance),
        }
    }

    /// r for a signal of the law.
    #[inline]
    pub(super) fn residual(&self, signal: f32, parameters: &SegmentParameters) -> f32 {
        (self.log_signal - math::ln(signal + parameters.soft_counts)) * self.inverse_sigma
    }
}

impl StepReadings {
    pub(super) fn new(
        heading: Rotation,
        samples: &[Sample; SENSORS],
        law: &TabulatedWallLaw,
        parameters: &SegmentParameters,
    ) -> Self {
        Self {
            position: Point::default(),
            heading,
            measured: samples.map(|sample| LogReading::of(sample, law, parameters)),
        }
    }

    /// Where a sensor was.
    #[inline]
    pub(super) fn place(&self, mount: &Mount) -> Placed {
        let (body, axis) = (self.heading, mount.direction);
        Placed {
            position: self.position + mount.position.rotated(body),
            axis: Rotation {
                sine: body.sine * axis.cosine + body.cosine * axis.sine,
                cosine: body.cosine * axis.cosine - body.sine * axis.sine,
            },
        }
    }
}

impl Placed {
    /// A wall of the tracker in the sensor's frame.
    #[inline]
    pub(super) fn see(&self, wall: &Wall) -> Wall {
        let inverse = self.axis.inverse();
        wall.map(|end| (end - self.position).rotated(inverse))
    }
}

/// The cost of a residual, and its weight in the normal equations (Huber 1964).
#[inline]
pub(super) fn huber(residual: f32, limit: f32) -> (f32, f32) {
    let size = residual.abs();
    if size <= limit {
        (residual * residual, 1.0)
    } else {
        (limit * (2.0 * size - limit), limit / size)
    }
}
