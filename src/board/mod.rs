//! The board's controllers over register traits: portable code, no HAL.
//!
//! [`i2c`] is the master of the sensors' buses and [`can`] the controller of the robot's
//! bus, each a state machine that interrupts and a timer drive. [`clock_choice`] brings
//! the clock unit as far as it goes. The flash image implements the traits with the
//! STM32F405's registers, the tests with models of them. [`budget`] holds the sizes of
//! the image's statics.

pub mod budget;
pub mod can;
pub mod clock_choice;
pub mod i2c;
