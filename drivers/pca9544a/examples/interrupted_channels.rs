//! Channels in the order of their interrupts, on any board with an asynchronous bus.
//!
//! A library, since it has no board of its own: await [`run`] in a task of a board.

#![no_std]

use embedded_hal_async::digital::Wait;
use embedded_hal_async::i2c::I2c;
use pca9544a::{Address, Channel, Error, Pca9544aAsync};

/// Waits for the interrupt pin, and passes each channel that pulls it to `serve`, which
/// clears the interrupt of its part.
///
/// # Errors
/// The first error of the multiplexer or of its bus.
pub async fn run<I: I2c>(
    i2c: I,
    mut pin: impl Wait,
    mut serve: impl AsyncFnMut(&mut I, Channel),
) -> Result<(), Error<I::Error>> {
    let mut mux = Pca9544aAsync::new(i2c, Address::from_pins(true, true, true));
    mux.deselect().await?;
    loop {
        if pin.wait_for_low().await.is_err() {
            continue;
        }
        let low = mux.interrupts().await?;
        for channel in Channel::ALL.into_iter().filter(|it| low.contains(*it)) {
            mux.select(channel).await?;
            serve(mux.bus(), channel).await;
        }
    }
}
