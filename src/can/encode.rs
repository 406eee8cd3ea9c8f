//! Messages as frames: the ring's, which this board sends, and those that it reads, for
//! simulators and tests.

use super::{Board, BodySpeed, Frame, StandardId, TransmittedPose};
use crate::geometry::Pose;
use crate::model::SENSORS;

/// PROXIMITY_RING of a sensor, identifier 0x182 + 8 i: raw counts above the offset,
/// scaled by [`scaled_above_offset`]. `None` for a sensor that the ring has not.
#[must_use]
pub fn proximity_ring(sensor: usize, raw: u16, offset: u16) -> Option<Frame> {
    let index = u8::try_from(sensor).ok().filter(|_| sensor < SENSORS)?;
    let identifier = StandardId::of(0x30 + index, Board::PowerManagement);
    let value = scaled_above_offset(raw, offset);
    Some(Frame::data(identifier, value.to_le_bytes()))
}

/// What the robots say of a reading: 0 up to the offset, and 65535 for a full register.
///
/// (raw - offset) * 65535 / (65535 - offset), rounded down. With an offset of some 2400
/// counts that is 1.04 times the counts above it.
#[must_use]
pub fn scaled_above_offset(raw: u16, offset: u16) -> u16 {
    let full = u32::from(u16::MAX);
    let above = u32::from(raw.saturating_sub(offset));
    let range = full - u32::from(offset);
    // No range, no raw value above the offset.
    let scaled = (above * full).checked_div(range).unwrap_or(0);
    // above <= range, so the quotient is at most 65535.
    scaled as u16
}

/// ODOMETRY of a pose, as the DiWheelDrive sends it; see [`TransmittedPose::of`].
#[must_use]
pub fn odometry(pose: &Pose) -> Frame {
    TransmittedPose::of(pose).frame()
}

/// ACTUAL_SPEED, as the DiWheelDrive sends it: whole um/s and urad/s, rounded down.
#[must_use]
pub fn actual_speed(speed: &BodySpeed) -> Frame {
    Frame::data(StandardId::ACTUAL_SPEED, speed_bytes(speed))
}

/// TARGET_SPEED, as Cognition sends it.
#[must_use]
pub fn target_speed(speed: &BodySpeed) -> Frame {
    Frame::data(StandardId::TARGET_SPEED, speed_bytes(speed))
}

fn speed_bytes(speed: &BodySpeed) -> [u8; 8] {
    let [v0, v1, v2, v3] = millionths(speed.forward_m_per_s).to_le_bytes();
    let [w0, w1, w2, w3] = millionths(speed.turn_rad_per_s).to_le_bytes();
    [v0, v1, v2, v3, w0, w1, w2, w3]
}

/// Millionths of a number, rounded down; saturating, 0 for NaN.
fn millionths(x: f32) -> i32 {
    let scaled = x * 1e6;
    let towards_zero = scaled as i32;
    towards_zero.saturating_sub(i32::from(towards_zero as f32 > scaled))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ring_frame_has_the_bytes_of_the_robots() {
        // (2569 - 2469) * 65535 / 63066 = 103.9: 103, 0x0067. Sensor 1: 0x31 << 3 | 2.
        let frame = proximity_ring(1, 2569, 2469);
        let expected = Frame::data(StandardId::from_bits(0x18a), [0x67, 0x00]);
        assert_eq!(frame, Some(expected));
        // 0x1234 above an offset of 0 is itself, lowest byte first.
        let frame = proximity_ring(7, 0x1234, 0);
        let expected = Frame::data(StandardId::from_bits(0x1ba), [0x34, 0x12]);
        assert_eq!(frame, Some(expected));
        assert_eq!(proximity_ring(8, 1, 0), None);
        assert_eq!(proximity_ring(256, 1, 0), None);
    }

    #[test]
    fn scale_ends_at_zero_and_at_the_full_register() {
        for offset in [0, 1, 2469, 65_534] {
            assert_eq!(scaled_above_offset(0, offset), 0);
            assert_eq!(scaled_above_offset(offset, offset), 0);
            assert_eq!(scaled_above_offset(u16::MAX, offset), u16::MAX);
        }
        assert_eq!(scaled_above_offset(u16::MAX, u16::MAX), 0);
    }

    #[test]
    fn scale_never_falls_with_the_reading() {
        for offset in [0, 1, 2190, 2469, 40_000, 65_534, 65_535] {
            let mut last = 0;
            for raw in 0..=u16::MAX {
                let scaled = scaled_above_offset(raw, offset);
                assert!(scaled >= last, "{raw} above {offset}: {scaled} < {last}");
                last = scaled;
            }
        }
    }

    #[test]
    fn speeds_are_rounded_down_to_millionths() {
        for (speed, millionth) in [
            (0.0, 0),
            (0.08, 80_000),
            (-0.08, -80_000),
            (1.5e-6, 1),
            (-1.5e-6, -2),
            (1e9, i32::MAX),
            (-1e9, i32::MIN),
            (f32::NAN, 0),
        ] {
            assert_eq!(millionths(speed), millionth, "{speed}");
        }
    }
}
