//! Access to an I2C unit: seven registers and two pins.

/// A register of the I2C unit \[RM 27.6\].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum I2cRegister {
    /// Control 1: on, start, stop, acknowledge, reset.
    Cr1,
    /// Control 2: bus clock, interrupts.
    Cr2,
    /// Data.
    Dr,
    /// Status 1: events and errors.
    Sr1,
    /// Status 2: busy, master. Reading it after status 1 clears the address event.
    Sr2,
    /// Clock control.
    Ccr,
    /// Rise time.
    Trise,
}

/// A wire of the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BusLine {
    /// SCL.
    Clock,
    /// SDA.
    Data,
}

/// Access to one I2C unit and its pins. The second implementor is the tests' model.
pub trait I2cRegisters {
    /// Reads a register, with the side effects that the silicon has.
    fn read(&mut self, register: I2cRegister) -> u16;

    /// Writes a register.
    fn write(&mut self, register: I2cRegister, value: u16);

    /// Takes both pins from the unit: open-drain outputs, released.
    fn take_pins(&mut self);

    /// Hands both pins back to the unit.
    fn return_pins(&mut self);

    /// Pulls a taken pin low.
    fn pull(&mut self, line: BusLine);

    /// Releases a taken pin.
    fn release(&mut self, line: BusLine);

    /// Whether the wire of a taken pin is high.
    fn is_high(&mut self, line: BusLine) -> bool;

    /// Lets half a clock pass for bit-banging: 2.5 us, above the 1.3 us for which a
    /// fast-mode clock is low at least.
    fn wait_half_clock(&mut self);

    /// Does a few register accesses without an interrupt between them.
    fn without_interrupts<T>(&mut self, work: impl FnOnce(&mut Self) -> T) -> T;
}

/// Bits of the first control register.
pub(super) mod cr1 {
    /// The unit is on.
    pub(crate) const ENABLE: u16 = 1 << 0;
    /// Make a start as soon as the bus is free, or after the current byte.
    pub(crate) const START: u16 = 1 << 8;
    /// Make a stop after the current byte.
    pub(crate) const STOP: u16 = 1 << 9;
    /// Acknowledge what is received.
    pub(crate) const ACK: u16 = 1 << 10;
    /// [`ACK`] controls the byte after the one being received.
    pub(crate) const POS: u16 = 1 << 11;
    /// Hold the unit in reset.
    pub(crate) const RESET: u16 = 1 << 15;
}

/// Bits of the second control register.
pub(super) mod cr2 {
    /// Interrupt on errors.
    pub(crate) const ERRORS: u16 = 1 << 8;
    /// Interrupt on events.
    pub(crate) const EVENTS: u16 = 1 << 9;
    /// Interrupt also on a data register that is full or empty.
    pub(crate) const BUFFER: u16 = 1 << 10;
}

/// Bits of the first status register.
pub(super) mod sr1 {
    /// A start is on the bus.
    pub(crate) const STARTED: u16 = 1 << 0;
    /// The address was acknowledged.
    pub(crate) const ADDRESSED: u16 = 1 << 1;
    /// Byte finished: the unit holds the clock until the data register is served.
    pub(crate) const FINISHED: u16 = 1 << 2;
    /// The data register holds a received byte.
    pub(crate) const RECEIVED: u16 = 1 << 6;
    /// A misplaced start or stop.
    pub(crate) const BUS_ERROR: u16 = 1 << 8;
    /// Arbitration lost.
    pub(crate) const ARBITRATION_LOST: u16 = 1 << 9;
    /// Not acknowledged.
    pub(crate) const REFUSED: u16 = 1 << 10;
    /// All errors of the error interrupt.
    pub(crate) const ERRORS: u16 = 0xdf00;
}

/// Bits of the second status register.
pub(super) mod sr2 {
    /// The bus was seen busy and no stop since.
    pub(crate) const BUSY: u16 = 1 << 1;
}
