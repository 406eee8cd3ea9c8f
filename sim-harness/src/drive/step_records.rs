//! Records of an AMiRo's steps, without a filter.

use amiro_ipf::node::{Config, Input, InputError, Scheduled, StepScheduler};

use super::{Record, scan_records};

/// Turns the inputs of an AMiRo's node into the pose and the scan of each of its steps.
///
/// The inputs pass through the [`StepScheduler`] of the node; no particle exists.
#[derive(Debug)]
pub struct StepRecords {
    config: Config,
    scheduler: StepScheduler,
    steps: u32,
}

impl StepRecords {
    /// Steps under a configuration.
    #[must_use]
    pub fn new(config: Config) -> Self {
        Self {
            config,
            scheduler: StepScheduler::default(),
            steps: 0,
        }
    }

    /// Passes on the records that an input gives: none, a reset of the odometry, or pose
    /// and scan of a step.
    ///
    /// # Errors
    /// Why the node refuses the input; it changes nothing then.
    pub fn take(&mut self, input: &Input, take: &mut dyn FnMut(&Record)) -> Result<(), InputError> {
        match self.scheduler.take(&self.config, input)? {
            Scheduled::Nothing => {}
            Scheduled::OdometryReset { stamp_us } => take(&Record::OdometryReset { stamp_us }),
            Scheduled::Step(step) => {
                self.steps = self.steps.saturating_add(1);
                scan_records(&self.config, step.stamp_us, step.pose, &step.samples)
                    .iter()
                    .for_each(take);
            }
        }
        Ok(())
    }

    /// Steps so far.
    #[must_use]
    pub fn steps(&self) -> u32 {
        self.steps
    }
}
