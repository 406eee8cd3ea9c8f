//! The faults that a bus can inject.

/// A fault of the wires or of a part on them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InjectedBusFault {
    /// An address or written byte finds no acknowledgement, and no part takes it.
    ///
    /// No effect on a byte that is read, because there the master acknowledges.
    NoAcknowledge,
    /// The master reads a 0 where it sent a 1 and leaves the bus; no part takes the byte.
    ArbitrationLost,
    /// A part holds SDA low from this byte's first bit on for a number of clocks: bytes
    /// that are read begin with zeros.
    SdaLow {
        /// Clocks until it releases SDA; a byte has nine.
        clocks: u32,
    },
    /// A part holds SCL low before this byte.
    SclLow {
        /// How long, in nanoseconds; `u64::MAX` is for ever.
        for_ns: u64,
    },
    /// A fault of the multiplexer.
    Mux(MuxFault),
    /// A fault of the sensor behind a channel of the multiplexer.
    Sensor {
        /// The channel, 0 to 3. A sensor without a multiplexer takes any channel.
        channel: u8,
        /// The fault.
        fault: Vcnl4020Fault,
    },
}

/// A fault of a multiplexer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MuxFault {
    /// It acknowledges a control byte and ignores it.
    WriteLost,
    /// Its supply fails for a moment: no channel.
    Reset,
    /// It connects another channel than the selected one, at once.
    Jump(u8),
    /// It misses the start that comes at this time.
    Deaf,
}

/// A fault of a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Vcnl4020Fault {
    /// Its supply fails for a moment: all registers as after power-up.
    Reset,
    /// It is unplugged: it does not answer.
    Unplugged,
    /// It is plugged in, and starts as after power-up.
    PluggedIn,
    /// A proximity measurement ends at this time, if it measures periodically.
    Measures,
    /// It misses the start that comes at this time, and continues to measure.
    Deaf,
}
