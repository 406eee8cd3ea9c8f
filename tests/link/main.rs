//! The link between a board and a host: bytes, frames, messages.

mod wire;
