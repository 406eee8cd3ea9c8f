//! The messages that this board reads.

use super::{AmiroModule, BodySpeed, CanFrame, CanIdentifier, StandardId, TransmittedPose};
use crate::geometry::Pose;

/// Every identifier that [`CanMessage::decode`] reads; a controller's filters need no other.
pub const READ_IDS: [StandardId; 9] = [
    StandardId::ODOMETRY,
    StandardId::ACTUAL_SPEED,
    StandardId::TARGET_SPEED,
    StandardId::OWN_TARGET_SPEED,
    StandardId::CALIBRATE_RING,
    StandardId::shutdown(AmiroModule::DiWheelDrive),
    StandardId::shutdown(AmiroModule::PowerManagement),
    StandardId::shutdown(AmiroModule::LightRing),
    StandardId::shutdown(AmiroModule::Cognition),
];

/// Highest plausible speed, micrometres per second. The AMiRo has been driven at 0.6 m/s.
const MAX_FORWARD: u32 = 10_000_000;
/// Highest plausible turn, microradians per second: wheels at 10 m/s against each other on the 69 mm track turn
/// the body by 290 rad/s.
const MAX_TURN: u32 = 300_000_000;
/// Payload of a shutdown, so that no stray frame switches the robot off.
pub(super) const SHUTDOWN: u16 = 0xaa55;

/// A message of the bus that this board reads.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CanMessage {
    /// The pose by the wheels' odometry, every 63 ms.
    ///
    /// The frame has no stamp; the odometry in it is up to 50 ms old.
    Odometry(Pose),
    /// The measured speed, every 63 ms, in steps of about 12 mm/s.
    ActualSpeed(BodySpeed),
    /// The target speed.
    TargetSpeed(BodySpeed),
    /// The request to measure the ring's offsets.
    CalibrateRing,
    /// A module requests the shutdown of all.
    Shutdown(AmiroModule),
}

/// Why this board ignores a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum IgnoredFrame {
    /// Its identifier has 29 bits.
    Extended,
    /// It requests data.
    NotData,
    /// It is no message for this board.
    UnknownId,
    /// It has more or fewer bytes than its message.
    WrongLength,
    /// No robot sends its values.
    ImpossibleValue,
}

impl core::fmt::Display for IgnoredFrame {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Extended => "identifier has 29 bits",
            Self::NotData => "frame asks for data",
            Self::UnknownId => "no message for this board",
            Self::WrongLength => "message has another length",
            Self::ImpossibleValue => "no robot sends such a value",
        })
    }
}

impl core::error::Error for IgnoredFrame {}

impl CanMessage {
    /// Decodes a frame.
    ///
    /// # Errors
    /// The reason why it is ignored; the variants of [`IgnoredFrame`] are tested in their
    /// order.
    pub fn decode(frame: &CanFrame) -> Result<Self, IgnoredFrame> {
        let CanIdentifier::Standard(identifier) = frame.identifier() else {
            return Err(IgnoredFrame::Extended);
        };
        if frame.is_remote() {
            return Err(IgnoredFrame::NotData);
        }
        match identifier {
            StandardId::ODOMETRY => TransmittedPose::from_bytes(payload(frame)?)
                .map(|sent| Self::Odometry(sent.pose()))
                .ok_or(IgnoredFrame::ImpossibleValue),
            StandardId::ACTUAL_SPEED => speed(payload(frame)?).map(Self::ActualSpeed),
            StandardId::TARGET_SPEED | StandardId::OWN_TARGET_SPEED => {
                speed(payload(frame)?).map(Self::TargetSpeed)
            }
            StandardId::CALIBRATE_RING => payload::<0>(frame).map(|_| Self::CalibrateRing),
            _ => shutdown(identifier, frame),
        }
    }
}

/// The payload, if it has exactly the message's length.
fn payload<const LENGTH: usize>(frame: &CanFrame) -> Result<[u8; LENGTH], IgnoredFrame> {
    frame
        .payload()
        .try_into()
        .map_err(|_| IgnoredFrame::WrongLength)
}

fn speed([v0, v1, v2, v3, w0, w1, w2, w3]: [u8; 8]) -> Result<BodySpeed, IgnoredFrame> {
    let forward = i32::from_le_bytes([v0, v1, v2, v3]);
    let turn = i32::from_le_bytes([w0, w1, w2, w3]);
    if forward.unsigned_abs() > MAX_FORWARD || turn.unsigned_abs() > MAX_TURN {
        return Err(IgnoredFrame::ImpossibleValue);
    }
    Ok(BodySpeed {
        forward_m_per_s: forward as f32 / 1e6,
        turn_rad_per_s: turn as f32 / 1e6,
    })
}

fn shutdown(identifier: StandardId, frame: &CanFrame) -> Result<CanMessage, IgnoredFrame> {
    let sender = AmiroModule::ALL
        .into_iter()
        .find(|board| StandardId::shutdown(*board) == identifier);
    let Some(sender) = sender else {
        return Err(IgnoredFrame::UnknownId);
    };
    match u16::from_le_bytes(payload(frame)?) {
        SHUTDOWN => Ok(CanMessage::Shutdown(sender)),
        _ => Err(IgnoredFrame::ImpossibleValue),
    }
}
