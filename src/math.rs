//! The only float functions of this crate, each with its error bound.
//!
//! `std`, `libm`, `micromath` and the target's FPU disagree in the last bits and
//! sometimes in the first. Everything here gives the same bits on a host and on
//! the Cortex-M4F: plain additions, multiplications and divisions in a fixed
//! order, plus one correctly rounded square root. Nothing else in this crate may
//! call a float method (`clippy.toml` refuses it).

use core::f32::consts::{FRAC_2_PI, LN_2, LOG2_E, PI, TAU};

/// Square root, correctly rounded; NaN for negative arguments.
///
/// 14 cycles (VSQRT) on the target, `std` or `libm` on a host: all three round
/// correctly, hence the same bits.
#[must_use]
#[inline]
pub fn sqrt(x: f32) -> f32 {
    square_root::sqrt(x)
}

#[cfg(target_os = "none")]
mod square_root {
    #[expect(
        unsafe_code,
        reason = "stable Rust has no other way to name VSQRT: its inline assembly takes no float operands"
    )]
    #[inline(always)]
    pub(super) fn sqrt(x: f32) -> f32 {
        let mut bits = x.to_bits();
        // SAFETY: the five instructions read and write `bits` and a scratch register
        // that the compiler chose, and s15, which they leave as they found it. No
        // memory, no flags. As a called function the routine would cost a step of 8000
        // particles 0.1 of 7.6 million instructions more.
        unsafe {
            core::arch::asm!(
                "vmov {saved}, s15",
                "vmov s15, {bits}",
                "vsqrt.f32 s15, s15",
                "vmov {bits}, s15",
                "vmov s15, {saved}",
                bits = inout(reg) bits,
                saved = out(reg) _,
                options(pure, nomem, nostack, preserves_flags),
            );
        }
        f32::from_bits(bits)
    }
}

#[cfg(all(not(target_os = "none"), feature = "std"))]
mod square_root {
    #[expect(clippy::disallowed_methods, reason = "this is the door")]
    #[inline]
    pub(super) fn sqrt(x: f32) -> f32 {
        x.sqrt()
    }
}

#[cfg(all(not(target_os = "none"), not(feature = "std")))]
mod square_root {
    #[inline]
    pub(super) fn sqrt(x: f32) -> f32 {
        libm::sqrtf(x)
    }
}

/// Nearest integer, halves away from zero, saturating at the range of `i32`.
///
/// NaN gives 0, as the conversion does.
#[must_use]
#[inline]
pub fn round_to_i32(x: f32) -> i32 {
    if x < 0.0 {
        (x - 0.5) as i32
    } else {
        (x + 0.5) as i32
    }
}

/// Nearest integer to x in [0, 2^32), halves upward; 0 below and for NaN.
#[must_use]
#[inline]
pub fn round_to_u32(x: f32) -> u32 {
    (x + 0.5) as u32
}

/// Sine and cosine of an angle in radians.
///
/// Absolute error below 3e-7 for |x| <= 10, growing with the argument to 1e-5 at
/// |x| = 1000. NaN gives NaN. About 30 instructions: reduction to +-pi/4, then the
/// Taylor series to x^9 and x^8.
#[must_use]
#[inline]
pub fn sin_cos(x: f32) -> (f32, f32) {
    // pi/2 in three parts, so that the reduction loses no digits.
    const PART_1: f32 = 1.570_312_5;
    const PART_2: f32 = 4.837_513e-4;
    const PART_3: f32 = 7.549_79e-8;
    let quadrant = round_to_i32(x * FRAC_2_PI);
    let turns = quadrant as f32;
    let y = ((x - turns * PART_1) - turns * PART_2) - turns * PART_3;
    in_quadrant(y, quadrant as u32)
}

/// Sine and cosine of an angle within a right angle of 0, in radians: the series alone.
///
/// Absolute error below 6e-7 for |x| <= 60 degrees, 3e-5 up to 90 degrees. Half of the
/// instructions of [`sin_cos`].
#[must_use]
#[inline]
pub fn sin_cos_within_right_angle(x: f32) -> (f32, f32) {
    in_quadrant(x, 0)
}

/// Sine and cosine of a uniformly random angle, from 32 random bits.
///
/// The two highest bits choose the quadrant, the others the angle in it: no reduction
/// is needed. Error as of [`sin_cos`].
#[must_use]
#[inline]
pub fn sin_cos_of_random(bits: u32) -> (f32, f32) {
    // [-2^29, 2^29) to [-pi/4, pi/4).
    const SCALE: f32 = core::f32::consts::FRAC_PI_4 / 536_870_912.0;
    let within = (bits & 0x3fff_ffff) as i32 - 0x2000_0000;
    in_quadrant(within as f32 * SCALE, bits >> 30)
}

/// Sine and cosine of y + quadrant pi/2 for |y| <= pi/4, by their Taylor series.
#[inline]
fn in_quadrant(y: f32, quadrant: u32) -> (f32, f32) {
    let y2 = y * y;
    let sine = y
        * (1.0
            + y2 * (-1.0 / 6.0
                + y2 * (1.0 / 120.0 + y2 * (-1.0 / 5040.0 + y2 * (1.0 / 362_880.0)))));
    let cosine =
        1.0 + y2 * (-0.5 + y2 * (1.0 / 24.0 + y2 * (-1.0 / 720.0 + y2 * (1.0 / 40_320.0))));
    match quadrant & 3 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

/// `e^-x` for x >= 0; exactly 0 from x = 24 on (4e-11).
///
/// Relative error below 5e-7. Arguments below 0 are the caller's mistake: down to
/// -0.3 they are served as well, beyond that the result is nonsense, though no panic.
#[must_use]
#[inline]
pub fn exp_of_minus(x: f32) -> f32 {
    if x >= 24.0 {
        return 0.0;
    }
    let halvings = (x * LOG2_E + 0.5) as i32;
    // ln 2 in two parts; the first has trailing zeros, so the product is exact.
    const LN_2_HIGH: f32 = 0.693_145_75;
    const LN_2_LOW: f32 = 1.428_606_8e-6;
    let y = -((x - halvings as f32 * LN_2_HIGH) - halvings as f32 * LN_2_LOW);
    let series = 1.0
        + y * (1.0
            + y * (0.5
                + y * (1.0 / 6.0 + y * (1.0 / 24.0 + y * (1.0 / 120.0 + y * (1.0 / 720.0))))));
    // 0 <= halvings <= 35: the exponent stays in its field.
    series * f32::from_bits((127_u32.wrapping_sub(halvings as u32)) << 23)
}

/// Natural logarithm of a positive number.
///
/// Absolute error below 3e-7 times max(1, |ln x|) up to 1e9; the argument must be a
/// normal number. Zero, negative and NaN arguments give -87.3, the logarithm of the
/// smallest normal number.
#[must_use]
#[inline]
pub fn ln(x: f32) -> f32 {
    const SQRT_HALF_BITS: u32 = 0x3f35_04f3;
    let x = if x >= f32::MIN_POSITIVE {
        x
    } else {
        f32::MIN_POSITIVE
    };
    // Split x = m * 2^k with m in [sqrt(1/2), sqrt(2)).
    let shifted = x.to_bits().wrapping_sub(SQRT_HALF_BITS);
    let k = (shifted as i32) >> 23;
    let m = f32::from_bits(x.to_bits().wrapping_sub((k as u32) << 23));
    let z = (m - 1.0) / (m + 1.0);
    let z2 = z * z;
    let series = 2.0 * z * (1.0 + z2 * (1.0 / 3.0 + z2 * (1.0 / 5.0 + z2 * (1.0 / 7.0))));
    k as f32 * LN_2 + series
}

/// Arc cosine of a number in [0, 1], in radians; arguments outside are clamped.
///
/// Absolute error below 2e-6. Newton's method on [`sin_cos`]; for tables that are
/// built at start, about 300 instructions.
#[must_use]
pub fn acos(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    // Exact in the limit x -> 1 and 10 % low at x = 0: a start Newton can use.
    let mut angle = sqrt(2.0 * (1.0 - x));
    for _ in 0..4 {
        let (sine, cosine) = sin_cos(angle);
        if sine <= 1e-6 {
            break;
        }
        angle += (cosine - x) / sine;
    }
    angle
}

/// Angle of the vector (x, y) in radians, within 0.004 rad (0.23 degrees).
///
/// By micromath: coarse, but cheap. For the bearing of the nearest obstacle in a
/// status message, never for the motion or the weight of a particle. (0, 0) gives 0.
#[must_use]
pub fn coarse_atan2(y: f32, x: f32) -> f32 {
    if x == 0.0 && y == 0.0 {
        return 0.0;
    }
    micromath::F32Ext::atan2(y, x)
}

/// 2^23 rad: above it floats are a radian and more apart, and a product with so many
/// turns is off by more than one.
const MOST_WRAPPED: f32 = 8_388_608.0;

/// The angle in (-pi, pi] that differs from `x` by whole turns.
///
/// Error below 1e-6 rad times the number of turns removed; beyond a million turns, where
/// that is no direction any more, the result is still in range. NaN and infinities give
/// NaN.
#[must_use]
pub fn wrap_angle(x: f32) -> f32 {
    if x > -PI && x <= PI {
        return x;
    }
    if !x.is_finite() {
        return f32::NAN;
    }
    let wrapped = if x.abs() < MOST_WRAPPED {
        x - round_to_i32(x / TAU) as f32 * TAU
    } else {
        // The remainder is exact on every platform, and slow.
        x % TAU
    };
    if wrapped > PI {
        wrapped - TAU
    } else if wrapped <= -PI {
        wrapped + TAU
    } else {
        wrapped
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sweep(from: f64, to: f64, steps: u32) -> impl Iterator<Item = f32> {
        (0..=steps).map(move |i| (from + (to - from) * f64::from(i) / f64::from(steps)) as f32)
    }

    #[test]
    fn square_root_is_correctly_rounded() {
        for bits in (0..0x7f80_0000_u32).step_by(40_009) {
            let x = f32::from_bits(bits);
            let exact = f64::from(x).sqrt() as f32;
            assert_eq!(sqrt(x).to_bits(), exact.to_bits(), "x = {x:e}");
        }
    }

    #[test]
    fn sine_and_cosine_keep_their_bound() {
        for (range, bound) in [(10.0, 3e-7), (1000.0, 1e-5)] {
            for x in sweep(-range, range, 400_000) {
                let (sine, cosine) = sin_cos(x);
                let (s, c) = f64::from(x).sin_cos();
                assert!((f64::from(sine) - s).abs() < bound, "sin {x}");
                assert!((f64::from(cosine) - c).abs() < bound, "cos {x}");
            }
        }
    }

    #[test]
    fn the_series_alone_serves_a_right_angle() {
        for (limit_deg, bound) in [(60.0_f64, 6e-7), (90.0, 3e-5)] {
            let limit = limit_deg.to_radians();
            for x in sweep(-limit, limit, 100_000) {
                let (sine, cosine) = sin_cos_within_right_angle(x);
                let error = (f64::from(sine) - f64::from(x).sin())
                    .abs()
                    .max((f64::from(cosine) - f64::from(x).cos()).abs());
                assert!(error < bound, "{x}: {error:e}");
            }
        }
    }

    #[test]
    fn sine_and_cosine_of_random_bits_keep_their_bound() {
        for bits in (0..=u32::MAX).step_by(10_007) {
            let angle = (f64::from(bits & 0x3fff_ffff) / f64::from(1_u32 << 30) - 0.5
                + f64::from(bits >> 30))
                * core::f64::consts::FRAC_PI_2;
            let (sine, cosine) = sin_cos_of_random(bits);
            let (s, c) = angle.sin_cos();
            assert!((f64::from(sine) - s).abs() < 3e-7, "sin of {bits:#x}");
            assert!((f64::from(cosine) - c).abs() < 3e-7, "cos of {bits:#x}");
        }
    }

    #[test]
    fn exponential_keeps_its_bound_and_ends_at_zero() {
        for x in sweep(0.0, 23.999, 400_000) {
            let exact = (-f64::from(x)).exp();
            let error = (f64::from(exp_of_minus(x)) / exact - 1.0).abs();
            assert!(error < 5e-7, "x = {x}, error = {error:e}");
        }
        assert_eq!(exp_of_minus(24.0).to_bits(), 0);
        assert_eq!(exp_of_minus(f32::INFINITY).to_bits(), 0);
        assert_eq!(exp_of_minus(0.0).to_bits(), 1.0_f32.to_bits());
        for x in [-0.3, -1e9, f32::NEG_INFINITY, f32::NAN] {
            let _ = exp_of_minus(x);
        }
    }

    #[test]
    fn logarithm_keeps_its_bound() {
        for i in 1..=1_000_000_u32 {
            let x = i as f32 / 1_000_000.0;
            let exact = f64::from(x).ln();
            let bound = 3e-7 * exact.abs().max(1.0);
            assert!((f64::from(ln(x)) - exact).abs() < bound, "x = {x}");
        }
        for x in sweep(0.0, 20.7, 400_000) {
            let x = f64::from(x).exp() as f32;
            let exact = f64::from(x).ln();
            let bound = 3e-7 * exact.max(1.0);
            assert!((f64::from(ln(x)) - exact).abs() < bound, "x = {x}");
        }
        for x in [0.0, -1.0, f32::NAN] {
            assert!((ln(x) + 87.33655).abs() < 1e-3, "x = {x}");
        }
    }

    #[test]
    fn arc_cosine_keeps_its_bound() {
        for x in sweep(0.0, 1.0, 20_000) {
            let error = (f64::from(acos(x)) - f64::from(x).acos()).abs();
            assert!(error < 2e-6, "x = {x}, error = {error:e}");
        }
    }

    #[test]
    fn coarse_arc_tangent_is_within_a_quarter_degree() {
        for angle in sweep(-3.13, 3.13, 10_000) {
            let (y, x) = f64::from(angle).sin_cos();
            let error = (coarse_atan2(y as f32, x as f32) - angle).abs();
            assert!(error < 0.004, "angle = {angle}, error = {error}");
        }
        assert_eq!(coarse_atan2(0.0, 0.0).to_bits(), 0);
    }

    #[test]
    fn wrapped_angles_lie_in_one_turn_and_keep_their_direction() {
        for x in sweep(-50.0, 50.0, 100_000) {
            let wrapped = wrap_angle(x);
            assert!(wrapped > -PI - 1e-6 && wrapped <= PI + 1e-6, "x = {x}");
            let error = (f64::from(wrapped) - f64::from(x)).sin().abs();
            assert!(error < 1e-5, "x = {x}, error = {error}");
        }
        assert!(wrap_angle(f32::NAN).is_nan());
        assert!(wrap_angle(f32::INFINITY).is_nan());
    }

    #[test]
    fn an_angle_of_any_number_of_turns_is_wrapped_once_and_for_all() {
        for bits in (0..0x7f80_0000_u32).step_by(10_007) {
            for x in [f32::from_bits(bits), -f32::from_bits(bits)] {
                let wrapped = wrap_angle(x);
                assert!(wrapped > -PI && wrapped <= PI, "x = {x}: {wrapped}");
                assert_eq!(wrap_angle(wrapped).to_bits(), wrapped.to_bits(), "x = {x}");
            }
        }
    }

    #[test]
    fn rounding_goes_to_the_nearest_integer_on_both_sides_of_zero() {
        for (x, expected) in [
            (0.4, 0),
            (0.5, 1),
            (-0.4, 0),
            (-0.5, -1),
            (2.7, 3),
            (-2.7, -3),
        ] {
            assert_eq!(round_to_i32(x), expected, "x = {x}");
        }
        assert_eq!(round_to_i32(f32::NAN), 0);
        assert_eq!(round_to_i32(1e20), i32::MAX);
    }
}
