//! A robot's whole drive, and its inputs with other odometries.

use amiro_ipf::board::acquisition::ODOMETRY_AGE_US;
use amiro_ipf::board::health::Health;
use amiro_ipf::geometry::Pose;
use amiro_ipf::node::Input;

use super::{AcquisitionReport, ReportContent, Robot};

/// A robot's whole drive.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotDrive {
    /// The reports of the acquisition.
    pub reports: Vec<AcquisitionReport>,
    /// Times of the samples, and the robot's true poses.
    pub poses: Vec<(u64, Pose)>,
    /// The health of the parts, eight times per second.
    pub healths: Vec<(u64, Health)>,
}

impl RobotDrive {
    /// The node's inputs.
    #[must_use]
    pub fn inputs(&self) -> Vec<Input> {
        let inputs = self.reports.iter().map(|report| report.content.input());
        inputs.flatten().collect()
    }

    /// The inputs with the true stamp of each frame's pose.
    #[must_use]
    pub fn inputs_with_true_stamps(&self) -> Vec<Input> {
        let inputs = self.reports.iter().map(|report| match report.content {
            ReportContent::Pose {
                input: Input::Odometry { pose, .. },
                updated_us: stamp_us,
            } => Some(Input::Odometry { stamp_us, pose }),
            content => content.input(),
        });
        inputs.flatten().collect()
    }

    /// The inputs with the mean age as the age of every frame's pose.
    #[must_use]
    pub fn inputs_with_mean_age(&self) -> Vec<Input> {
        let inputs = self.reports.iter().map(|report| match report.content {
            ReportContent::Pose {
                input: Input::Odometry { pose, .. },
                ..
            } => Some(Input::Odometry {
                stamp_us: report.at_us.saturating_sub(ODOMETRY_AGE_US),
                pose,
            }),
            content => content.input(),
        });
        inputs.flatten().collect()
    }

    /// The inputs with the robot's exact poses.
    #[must_use]
    pub fn inputs_with_true_poses(&self) -> Vec<Input> {
        let samples = self
            .reports
            .iter()
            .filter_map(|report| match report.content {
                ReportContent::Samples(input) => Some(input),
                _ => None,
            });
        let pairs = self.poses.iter().zip(samples);
        let both = pairs
            .flat_map(|(&(stamp_us, pose), samples)| [Input::Odometry { stamp_us, pose }, samples]);
        both.collect()
    }
}

/// Lets a robot drive to its end.
#[must_use]
pub fn drive(mut robot: Robot) -> RobotDrive {
    let mut whole = RobotDrive {
        reports: Vec::new(),
        poses: Vec::new(),
        healths: Vec::new(),
    };
    while let Some(report) = robot.next() {
        match report.content {
            ReportContent::Samples(_) => {
                let pose = robot.true_pose_at(report.at_us);
                whole.poses.push((report.at_us, pose));
            }
            ReportContent::Health(health) => whole.healths.push((report.at_us, health)),
            ReportContent::Pose { .. } | ReportContent::Offsets(_) => {}
        }
        whole.reports.push(report);
    }
    whole
}
