//! The robot's board as portable code over register traits; no HAL.
//!
//! A reading passes through these modules in this order:
//!
//! 1. [`i2c`]: a master per bus moves one transaction at a time; `i2c::muxed_bus` chooses
//!    the transactions that read four sensors behind one multiplexer.
//! 2. [`proximity_sensor`]: each reading is checked by [`signal_check`] and becomes a
//!    sample with a [`sensor_state`].
//! 3. [`acquisition`]: the samples of eight sensors become the node's proximity inputs,
//!    and the odometry frames of [`can`] become its odometry inputs.
//!
//! [`offsets`] are subtracted from each reading. [`calibration`] measures them,
//! `offset_store` keeps them in the [`eeprom`].
//!
//! [`can`] holds the controller of the robot's bus and its messages, [`health`] the
//! report on the parts, [`supervision`] the rules by which the image supervises itself.
//! [`clock_choice`] starts the best clock that the board has, [`budget`] holds the sizes
//! of the image's statics.
//!
//! The flash image implements the traits [`i2c::I2cRegisters`], [`can::CanRegisters`] and
//! [`clock_choice::ClockUnit`] with the STM32F405's registers, the tests with models.

pub mod acquisition;
pub mod budget;
pub mod calibration;
pub mod can;
pub mod clock_choice;
pub mod eeprom;
pub mod health;
pub mod i2c;
mod offset_store;
pub mod offsets;
pub mod proximity_sensor;
pub mod sensor_state;
pub mod signal_check;
pub mod supervision;

pub use {pca9544a, vcnl4020};
