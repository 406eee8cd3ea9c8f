//! The node's inputs from the robot's own parts: eight proximity sensors, odometry.
//!
//! Like the node, [`Acquisition`] reads no clock and no pin. It gives the next transaction of
//! each I2C bus and takes its result, takes the frames of the CAN bus, and gives the
//! node's inputs. On a robot the flash image's interrupts execute the transactions and
//! move the frames, in a simulation a loop does.

mod acquire;
mod bus_status;
mod proximity_ring;
mod update_clock;

pub use super::i2c::muxed_bus::ROUND_PERIOD_US as ROUND_US;
pub use acquire::{Acquisition, BUSES, CanAction};
pub use proximity_ring::{AMIRO_CONNECTIONS, Bus, ProximityRing, SensorConnection};
pub use update_clock::ODOMETRY_AGE_US;
