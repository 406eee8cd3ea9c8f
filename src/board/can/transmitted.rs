//! The quantised pose of the message ODOMETRY.

use core::f32::consts::TAU;

use super::{CanFrame, StandardId};
use crate::geometry::Pose;

/// Millionths, of a metre or a radian, that the lowest bit stands for.
const STEP: i32 = 256;
/// Most of a 24-bit number.
const MAX_POSITION: i32 = 0x7f_ffff;
/// Headings go to 2 pi, 24543.7 steps; one step more is taken for rounding.
const MAX_HEADING: u16 = 24_544;

/// A pose in the steps of ODOMETRY: 256 um, and 256 urad of a heading from 0 to 2 pi.
///
/// The robot computes in micrometres and microradians and drops the lowest eight bits:
/// numbers are rounded down, so that positions are 128 um too low in the mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TransmittedPose {
    x: i32,
    y: i32,
    heading: u16,
}

impl TransmittedPose {
    /// The transmitted form of a pose.
    ///
    /// Rounds the exact value down, to the bit. Positions beyond 2147 m are sent as the
    /// farthest, NaN as 0; an odometry holds neither.
    #[must_use]
    pub fn of(pose: &Pose) -> Self {
        let turn = fixed(pose.heading.radians());
        let turn = if turn < 0 { turn + TURN } else { turn };
        // 0 to 2 pi, so 0 to 24543.
        let heading = steps(turn).clamp(0, i64::from(MAX_HEADING)) as u16;
        Self {
            x: place(pose.position.x),
            y: place(pose.position.y),
            heading,
        }
    }

    /// The pose that a receiver makes of the steps: metres and radians.
    #[must_use]
    pub fn pose(&self) -> Pose {
        Pose::new(unit(self.x), unit(self.y), unit(i32::from(self.heading)))
    }

    /// The frame that carries the steps: 24, 24 and 16 bits.
    #[must_use]
    pub fn frame(&self) -> CanFrame {
        let [x0, x1, x2, _] = self.x.to_le_bytes();
        let [y0, y1, y2, _] = self.y.to_le_bytes();
        let [h0, h1] = self.heading.to_le_bytes();
        CanFrame::data(StandardId::ODOMETRY, [x0, x1, x2, y0, y1, y2, h0, h1])
    }

    /// The steps in a frame's eight bytes; `None` for a heading beyond a full turn.
    pub(super) fn from_bytes([x0, x1, x2, y0, y1, y2, h0, h1]: [u8; 8]) -> Option<Self> {
        let heading = u16::from_le_bytes([h0, h1]);
        (heading <= MAX_HEADING).then_some(Self {
            // The number in the upper three bytes, and its sign down again.
            x: i32::from_le_bytes([0, x0, x1, x2]) >> 8,
            y: i32::from_le_bytes([0, y0, y1, y2]) >> 8,
            heading,
        })
    }
}

/// Fractional bits of [`fixed`].
const FRACTION: u32 = 44;
/// 2^44.
const ONE: f32 = 17_592_186_044_416.0;
/// 2 pi x 2^44, rounded down.
const TURN: i64 = 110_534_964_875_444;

/// x in units of 2^-44, rounded down; saturating, and 0 for NaN.
///
/// Exact for |x| >= 2^-20, whose lowest bit is 2^-43; below, rounded down with its sign.
fn fixed(x: f32) -> i64 {
    // A product by a power of two is exact, and so is the way back of a number that
    // had a fraction to lose.
    let scaled = x * ONE;
    let towards_zero = scaled as i64;
    let is_above = towards_zero as f32 > scaled;
    towards_zero.saturating_sub(i64::from(is_above))
}

/// Whole steps of 256 millionths: a unit is 10^6 / 256 = 15625 / 4 of them.
fn steps(fixed: i64) -> i64 {
    // 63 + 14 bits, less 46: fits again.
    ((i128::from(fixed) * 15_625) >> (FRACTION + 2)) as i64
}

/// Steps of a coordinate in metres.
fn place(metres: f32) -> i32 {
    // 24 bits after clamping.
    steps(fixed(metres)).clamp(i64::from(!MAX_POSITION), i64::from(MAX_POSITION)) as i32
}

/// Metres or radians of a number of steps, to the nearest f32.
///
/// The product has 24 significant bits as the number had, and 10^6 is an f32: one
/// division, correctly rounded.
fn unit(steps: i32) -> f32 {
    (steps * STEP) as f32 / 1e6
}

const _: () = assert!(MAX_HEADING as f32 * 256e-6 > TAU);

#[cfg(test)]
mod tests {
    use super::*;
    use core::f32::consts::{FRAC_PI_2, PI};
    use proptest::prelude::*;

    /// The rule as it reads, in double precision: 24 bits times 10^6 are exact there.
    fn in_double_precision(x: f64) -> i64 {
        (x * 1e6 / 256.0).floor() as i64
    }

    #[test]
    fn numbers_are_rounded_down_to_256_millionths() {
        for (metres, steps) in [
            (0.0, 0),
            (-0.0, 0),
            (255e-6, 0),
            (257e-6, 1),
            (-1e-6, -1),
            (-1e-30, -1),
            (1e-30, 0),
            // 0.3 m are 1171.875 steps.
            (0.3, 1171),
            (-0.3, -1172),
            // Exactly 15625 / 4 x 4.
            (4.0, 15_625),
            (-4.0, -15_625),
        ] {
            assert_eq!(place(metres), steps, "{metres}");
            let expected = (f64::from(steps) * 256.0 * 1e-6) as f32;
            assert_eq!(unit(steps).to_bits(), expected.to_bits(), "{metres}");
        }
    }

    #[test]
    fn places_beyond_the_message_are_its_farthest_and_no_numbers_are_zero() {
        assert_eq!(place(2147.5), MAX_POSITION);
        assert_eq!(place(f32::INFINITY), MAX_POSITION);
        assert_eq!(place(-2147.5), -MAX_POSITION - 1);
        assert_eq!(place(f32::MIN), -MAX_POSITION - 1);
        assert_eq!(place(f32::NAN), 0);
        let nowhere = TransmittedPose::of(&Pose::new(0.0, 0.0, f32::NAN));
        assert_eq!(nowhere.heading, 0);
    }

    #[test]
    fn headings_to_the_right_are_above_half_a_turn() {
        for (heading, steps) in [
            (0.0, 0),
            // pi is 12271.8 steps, 3 pi / 2 18407.8, 2 pi 24543.7.
            (PI, 12_271),
            (-FRAC_PI_2, 18_407),
            (-1e-9, 24_543),
            (-1e-30, 24_543),
        ] {
            let sent = TransmittedPose::of(&Pose::new(0.0, 0.0, heading));
            assert_eq!(sent.heading, steps, "{heading}");
        }
    }

    #[test]
    fn every_step_is_the_nearest_number_of_double_precision() {
        for steps in -0x80_0000..=0x7f_ffff {
            let expected = (f64::from(steps) * 256.0 * 1e-6) as f32;
            assert_eq!(unit(steps).to_bits(), expected.to_bits(), "{steps}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, cases: 20_000, ..ProptestConfig::default() })]

        #[test]
        fn rounding_down_is_exact(x in -2000.0_f32..2000.0, small in -1e-3_f32..1e-3) {
            for x in [x, small, x * 1e-3, small * small * small] {
                prop_assert_eq!(i64::from(place(x)), in_double_precision(f64::from(x)), "{}", x);
            }
        }

        #[test]
        fn headings_are_rounded_down_as_in_double_precision(heading in -PI..PI) {
            let turn = f64::from(heading) + if heading < 0.0 { core::f64::consts::TAU } else { 0.0 };
            let sent = TransmittedPose::of(&Pose::new(0.0, 0.0, heading));
            prop_assert_eq!(i64::from(sent.heading), in_double_precision(turn));
        }
    }
}
