//! What can go wrong on a bus.

/// A fault of the wires or of a part on them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InjectedBusFault {
    /// An address or written byte finds no acknowledgement, and no part takes it.
    ///
    /// Nothing on a byte that is read: there the master acknowledges.
    NoAcknowledge,
    /// The master reads a 0 where it sent a 1 and leaves the bus; no part takes the byte.
    ArbitrationLost,
    /// A part holds SDA low from this byte's first bit on until it has seen so many
    /// clocks: bytes that are read have leading zeros that nobody put there.
    SdaLow {
        /// Clocks until it lets go; a byte has nine.
        clocks: u32,
    },
    /// A part holds SCL low before this byte.
    SclLow {
        /// How long, in nanoseconds; `u64::MAX` is for ever.
        for_ns: u64,
    },
    /// Something happens to the mux.
    Mux(MuxFault),
    /// Something happens to the sensor behind a channel of the mux.
    Sensor {
        /// The channel, 0 to 3. A sensor alone on a bus takes any for its own.
        channel: u8,
        /// What happens.
        fault: Vcnl4020Fault,
    },
}

/// What can happen to a mux.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MuxFault {
    /// It acknowledges a control byte and forgets it.
    WriteLost,
    /// Its supply fails for a moment: no channel.
    Reset,
    /// It connects another channel than was asked for, at once.
    Jump(u8),
    /// It hears nothing of the start that comes at this very moment.
    Deaf,
}

/// What can happen to a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Vcnl4020Fault {
    /// Its supply fails for a moment: all registers as after power-up.
    Reset,
    /// Its plug is pulled: it answers nothing.
    Unplugged,
    /// It is plugged in, and starts as after power-up.
    PluggedIn,
    /// A proximity measurement ends at this very moment, if it measures periodically.
    Measures,
    /// It hears nothing of the start that comes at this very moment, and measures on.
    Deaf,
}
