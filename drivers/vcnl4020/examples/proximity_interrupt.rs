//! Proximity with an interrupt pin, on any board with a blocking bus.
//!
//! A library, since it has no board of its own: call [`run`] from a board's `main`.

#![no_std]

use embedded_hal::delay::DelayNs;
use embedded_hal::digital::InputPin;
use embedded_hal::i2c::I2c;
use vcnl4020::{
    Compared, Configuration, Error, InterruptControl, InterruptStatus, LedCurrent, ProximityRate,
    Vcnl4020,
};

/// Counts above which something is near, for a part with an offset of some 2000.
const NEAR: u16 = 3_000;

/// Calls `near` with the count each time that something comes near.
///
/// # Errors
/// The first error of the sensor or of its bus.
pub fn run<I: I2c, P: InputPin>(
    i2c: I,
    mut interrupt: P,
    mut delay: impl DelayNs,
    mut near: impl FnMut(u16),
) -> Result<(), Error<I::Error>> {
    let mut sensor = Vcnl4020::new(i2c);
    sensor.set_thresholds(0, NEAR)?;
    sensor.set_interrupts(InterruptControl {
        results_log2: 1,
        thresholds: Some(Compared::Proximity),
        ..InterruptControl::default()
    })?;
    sensor.start(&Configuration {
        rate: ProximityRate::Hz62_5,
        led: LedCurrent::MAX,
        ambient: None,
    })?;
    loop {
        if interrupt.is_low().unwrap_or(false) {
            match sensor.proximity() {
                Ok(counts) => near(counts),
                Err(Error::NotReady) => {}
                Err(error) => return Err(error),
            }
            sensor.clear_interrupts(InterruptStatus::ALL)?;
        }
        delay.delay_ms(16);
    }
}
