//! Which segments explain what the sensors read now.

use heapless::Vec;

use super::fit::{SegmentFit, seen};
use super::{MAX_SEGMENTS, SegmentModel, SegmentTracker};
use crate::filter::WallParameters;
use crate::math;
use crate::model::{SENSORS, SensorMask, Wall};

/// A segment with the sensors whose readings it explains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SeenSegment {
    /// The ends in the body frame.
    pub(crate) ends: Wall,
    /// The sensors.
    pub(crate) sensors: SensorMask,
}

impl SegmentTracker {
    /// The segments that are seen now.
    #[inline(never)]
    pub(crate) fn seen(
        &self,
        model: &SegmentModel,
        parameters: &WallParameters,
    ) -> Vec<SeenSegment, MAX_SEGMENTS> {
        let segments = self.segments();
        let mut masks = [SensorMask::NONE; MAX_SEGMENTS];
        for sensor in 0..SENSORS {
            self.add_claims(model, parameters, sensor, &mut masks);
        }
        let fit = SegmentFit {
            model,
            rows: self.rows(),
        };
        let mut with: Option<f32> = None;
        let mut seen = Vec::new();
        for (index, (segment, sensors)) in segments.iter().zip(masks).enumerate() {
            if sensors.is_empty() {
                continue;
            }
            let mut evidence = segment.evidence();
            if evidence <= parameters.least_evidence {
                let with = *with.get_or_insert_with(|| fit.readings_cost(segments, None));
                evidence += fit.readings_cost(segments, Some(index)) - with;
            }
            if evidence > parameters.least_evidence {
                let ends = segment.ends().map(|end| self.body_from_track(end));
                let _ = seen.push(SeenSegment { ends, sensors });
            }
        }
        seen
    }

    /// Adds a sensor to the segments that make its reading, if they explain it.
    #[inline(never)]
    fn add_claims(
        &self,
        model: &SegmentModel,
        parameters: &WallParameters,
        sensor: usize,
        masks: &mut [SensorMask; MAX_SEGMENTS],
    ) {
        let segments = self.segments();
        let reading = self.rows().last().and_then(|row| {
            let mount = model.mounts.get(sensor)?;
            Some((row.place(mount), row.measured.get(sensor)?))
        });
        let Some((placed, measured)) = reading else {
            return;
        };
        if measured.inverse_sigma <= 0.0 {
            return;
        }
        let signal = model.law.signal(&seen(&placed, segments, None));
        let soft = model.parameters.soft_counts;
        let noise = model.parameters.sigma_counts / (measured.signal + soft).max(2.0);
        let relative = parameters.claim_relative_sigma;
        let sigma = math::sqrt(noise * noise + relative * relative);
        let deviation = measured.log_signal - math::ln(signal + soft);
        if deviation.abs() >= parameters.claim_sigmas * sigma {
            return;
        }
        for (index, mask) in masks.iter_mut().enumerate().take(segments.len()) {
            let without = model.law.signal(&seen(&placed, segments, Some(index)));
            if signal - without > parameters.least_share * signal {
                *mask = mask.with(sensor);
            }
        }
    }
}
