//! Vishay's VCNL4020: infrared proximity and ambient light, 16 bits each.
//!
//! [`Vcnl4020`] is the part on a bus that waits. What is said and answered stands apart
//! from it in the functions of [`transactions`], for whoever drives the bus by interrupts.
//!
//! # Registers
//!
//! | address | register | after a reset |
//! |---|---|---|
//! | 0x80 | command: 7 always 1, 6 ambient ready, 5 proximity ready, 4 and 3 measure once, 2 and 1 enable, 0 self-timed | 0x80 |
//! | 0x81 | identity: product 2, revision 1 | 0x21 |
//! | 0x82 | proximity rate, 1.95 /s times two to the power of bits 2..0 | 0x00 |
//! | 0x83 | diode current, bits 5..0 in 10 mA | 0x02 |
//! | 0x84 | ambient: 7 continuous, 6..4 rate, 3 auto-offset, 2..0 averaging | 0x1d |
//! | 0x85, 0x86 | ambient result, high byte first | |
//! | 0x87, 0x88 | proximity result, high byte first | |
//! | 0x89 | interrupts: 7..5 count, 3 proximity ready, 2 ambient ready, 1 thresholds, 0 of ambient | 0x00 |
//! | 0x8a, 0x8b; 0x8c, 0x8d | low and high threshold, high byte first | 0 |
//! | 0x8e | why the interrupt pin is pulled; ones clear | 0x00 |
//!
//! A transfer of several bytes goes on to the next register. Rates change only while
//! bit 0 of the command is clear. Reading a result clears its ready bit. From Vishay's
//! data sheet, as the drivers of Linux (vcnl4000), RIOT (vcnl40x0) and Adafruit tell
//! it; the reset value of 0x84 is unconfirmed.
//!
//! # Cost
//!
//! Bytes on the bus, addresses included, and the time at 100 and at 400 kHz stand at
//! each method: 9 clocks a byte and one for each start and stop.
//!
//! # Example
//!
//! ```
//! use amiro_ipf::driver::vcnl4020::{Configuration, Error, Vcnl4020};
//! use embedded_hal::i2c::{ErrorType, I2c, Operation};
//!
//! /// A part that is always ready: registers and a pointer that counts up.
//! struct Registers([u8; 256]);
//!
//! impl ErrorType for Registers {
//!     type Error = core::convert::Infallible;
//! }
//!
//! impl I2c for Registers {
//!     fn transaction(&mut self, _: u8, list: &mut [Operation<'_>]) -> Result<(), Self::Error> {
//!         let mut pointer = 0;
//!         for operation in list {
//!             match operation {
//!                 Operation::Write(bytes) => {
//!                     pointer = usize::from(bytes[0]);
//!                     self.0[pointer..][..bytes.len() - 1].copy_from_slice(&bytes[1..]);
//!                 }
//!                 Operation::Read(bytes) => {
//!                     let length = bytes.len();
//!                     bytes.copy_from_slice(&self.0[pointer..][..length]);
//!                 }
//!             }
//!         }
//!         self.0[0x80] |= 0b1110_0000;
//!         Ok(())
//!     }
//! }
//!
//! let mut registers = [0; 256];
//! registers[0x81] = 0x21;
//! registers[0x87..0x89].copy_from_slice(&2_560_u16.to_be_bytes());
//!
//! let mut sensor = Vcnl4020::new(Registers(registers));
//! sensor.start(&Configuration::AMIRO)?;
//! assert_eq!(sensor.result()?.proximity, 2_560);
//! # Ok::<(), Error<core::convert::Infallible>>(())
//! ```

mod device;
mod registers;
pub mod transactions;

pub use device::{Error, Vcnl4020};
pub use registers::{
    ADDRESS, Ambient, AmbientRate, Command, IDENTITY, InterruptControl, InterruptStatus,
    LedCurrent, Measurement, ProximityRate, SATURATED, Watched,
};
pub use transactions::Configuration;
