//! How long a round holds its bus.

use crate::board::i2c::clocks;

/// Time between two rounds at the sensors' 125 Hz.
pub const ROUND_PERIOD_US: u64 = 8_000;

/// Readouts of the second pass begin within this time of their round.
///
/// At 400 kHz the longest readout takes 0.75 ms, so that the round then ends before the
/// next one begins.
pub const SECOND_READOUTS_UNTIL_US: u64 = 6_000;

/// Clocks of a usual readout: selection, read-back, command, results, proximity
/// again, read-back.
const READING_CLOCKS: u32 =
    clocks(1, 0) + clocks(0, 1) + clocks(1, 1) + clocks(1, 4) + clocks(1, 2) + clocks(0, 1);

/// Clocks of a readout that finds its sensor reset and configures it.
const CONFIGURING_CLOCKS: u32 =
    clocks(1, 0) + clocks(0, 1) + 2 * clocks(1, 1) + 2 * clocks(2, 0) + clocks(4, 0) + clocks(0, 1);

/// Clocks of the longest readout: selection unknown, and a torn value.
const LONGEST_READOUT_CLOCKS: u32 = {
    let deselection = clocks(1, 0) + clocks(0, 1);
    let torn = READING_CLOCKS + clocks(1, 2);
    let longest = if torn > CONFIGURING_CLOCKS {
        torn
    } else {
        CONFIGURING_CLOCKS
    };
    deselection + longest
};

/// Clocks of a round in which four sensors deliver.
pub const USUAL_ROUND_CLOCKS: u32 = 4 * READING_CLOCKS;

/// Clocks of the longest first pass: each readout ends with an error.
///
/// 1204: 12.0 ms at 100 kHz, 3.0 ms at 400 kHz.
pub const LONGEST_FIRST_PASS_CLOCKS: u32 = 4 * LONGEST_READOUT_CLOCKS;

/// Longest time that a round holds a bus of this speed, microseconds, rounded up.
///
/// 6.02 ms at 400 kHz, 12.04 ms at 100 kHz; the time between transactions comes on top.
#[must_use]
pub const fn longest_round_us(bus_hz: u32) -> u64 {
    let first_us = time_us(LONGEST_FIRST_PASS_CLOCKS, bus_hz);
    if first_us >= SECOND_READOUTS_UNTIL_US {
        return first_us;
    }
    let all_us = time_us(2 * LONGEST_FIRST_PASS_CLOCKS, bus_hz);
    let last_us = SECOND_READOUTS_UNTIL_US + time_us(LONGEST_READOUT_CLOCKS, bus_hz);
    if all_us < last_us { all_us } else { last_us }
}

/// Duration of a number of clocks, microseconds, rounded up; a bus of 0 Hz counts as 1 Hz.
const fn time_us(clocks: u32, bus_hz: u32) -> u64 {
    let hz = if bus_hz == 0 { 1 } else { bus_hz };
    (clocks as u64 * 1_000_000).div_ceil(hz as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_take_the_documented_numbers_of_clocks() {
        assert_eq!(USUAL_ROUND_CLOCKS, 852);
        // 20 + 20 to select, 39 + 39 to look, 29 + 47 + 29 to set, 20 to confirm.
        assert_eq!(CONFIGURING_CLOCKS, 243);
        assert_eq!(LONGEST_FIRST_PASS_CLOCKS, 1_204);
    }

    #[test]
    fn the_longest_round_is_bounded_at_every_speed_of_the_bus() {
        for (bus_hz, longest_us) in [
            // Twice 1204 clocks, all before the second pass is over.
            (1_000_000, 2_408),
            (400_000, 6_020),
            // Begun just before 6 ms, and 301 clocks more.
            (300_000, 6_000 + 1_004),
            // 1204 clocks take 6 ms to the microsecond: no second readout begins.
            (200_667, 6_000),
            (100_000, 12_040),
            // No division by zero.
            (0, 1_204_000_000),
        ] {
            assert_eq!(longest_round_us(bus_hz), longest_us, "{bus_hz} Hz");
        }
        assert!(longest_round_us(400_000) < ROUND_PERIOD_US);
    }
}
