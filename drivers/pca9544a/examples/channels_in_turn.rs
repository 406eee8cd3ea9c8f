//! One reading of the same sensor on each channel, on any board with a blocking bus.
//!
//! A library, since it has no board of its own: call [`read_all`] from a board's `main`.

#![no_std]

use embedded_hal::i2c::I2c;
use pca9544a::{Address, Channel, Error, Pca9544a};

/// Calls `read` with the bus and each channel in turn, and keeps what it gives if the
/// channel was still selected afterwards.
///
/// # Errors
/// The first error of the multiplexer or of its bus.
pub fn read_all<I: I2c, T: Copy>(
    i2c: I,
    mut read: impl FnMut(&mut I, Channel) -> Option<T>,
) -> Result<[Option<T>; 4], Error<I::Error>> {
    let mut mux = Pca9544a::new(i2c, Address::from_pins(true, true, true));
    let mut values = [None; 4];
    for (value, channel) in values.iter_mut().zip(Channel::ALL) {
        mux.select(channel)?;
        let reading = read(mux.bus(), channel);
        mux.confirm()?;
        *value = reading;
    }
    mux.deselect()?;
    Ok(values)
}
