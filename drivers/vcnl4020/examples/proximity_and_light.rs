//! Proximity and ambient light, on any board with an asynchronous bus.
//!
//! A library, since it has no board of its own: await [`run`] in a task of a board.

#![no_std]

use embedded_hal_async::delay::DelayNs;
use embedded_hal_async::i2c::I2c;
use vcnl4020::{
    Configuration, Error, LUX_PER_COUNT, LedCurrent, ProximityRate, SATURATED, Vcnl4020Async,
};

/// A result of either kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Proximity, counts.
    Proximity(u16),
    /// The surface is too close to be measured.
    TooClose,
    /// Illuminance, lux.
    Ambient(f32),
}

/// Passes each result on; starts the sensor again after its supply failed.
///
/// # Errors
/// The first error of the sensor or of its bus.
pub async fn run<I: I2c>(
    i2c: I,
    mut delay: impl DelayNs,
    mut each: impl FnMut(Light),
) -> Result<(), Error<I::Error>> {
    let configuration = Configuration {
        rate: ProximityRate::Hz125,
        led: LedCurrent::MAX,
        ..Configuration::default()
    };
    let mut sensor = Vcnl4020Async::new(i2c);
    loop {
        match sensor.proximity().await {
            Ok(SATURATED) => each(Light::TooClose),
            Ok(counts) => each(Light::Proximity(counts)),
            Err(Error::NotReady) => delay.delay_ms(1).await,
            Err(Error::NotRunning) => sensor.start(&configuration).await?,
            Err(error) => return Err(error),
        }
        match sensor.ambient().await {
            Ok(counts) => each(Light::Ambient(f32::from(counts) * LUX_PER_COUNT)),
            Err(Error::NotReady | Error::NotRunning) => {}
            Err(error) => return Err(error),
        }
    }
}
