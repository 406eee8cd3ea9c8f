//! The unit's registers (RM0090, section 32.9): offsets and the bits in use.

/// Access to the registers of a bxCAN unit. The second implementor is the tests' model.
pub trait CanRegisters {
    /// The register's bits.
    fn read(&self, register: CanRegister) -> u32;

    /// Writes all of the register's bits.
    fn write(&mut self, register: CanRegister, bits: u32);

    /// Sets and clears some of the register's bits.
    fn change(&mut self, register: CanRegister, clear: u32, set: u32) {
        let bits = self.read(register);
        self.write(register, (bits & !clear) | set);
    }
}

/// A register of the unit, by its offset; no other offset can be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CanRegister(u16);

impl CanRegister {
    /// Master control.
    pub const MCR: Self = Self(0x000);
    /// Master status.
    pub const MSR: Self = Self(0x004);
    /// Transmit status.
    pub const TSR: Self = Self(0x008);
    /// Receive FIFO 0.
    pub const RF0R: Self = Self(0x00c);
    /// Interrupt enable.
    pub const IER: Self = Self(0x014);
    /// Error status.
    pub const ESR: Self = Self(0x018);
    /// Bit timing.
    pub const BTR: Self = Self(0x01c);
    /// CanIdentifier of the first frame in FIFO 0.
    pub const RI0R: Self = Self(0x1b0);
    /// Its length.
    pub const RDT0R: Self = Self(0x1b4);
    /// Its bytes 0 to 3.
    pub const RDL0R: Self = Self(0x1b8);
    /// Its bytes 4 to 7.
    pub const RDH0R: Self = Self(0x1bc);
    /// Filter master.
    pub const FMR: Self = Self(0x200);
    /// Filter mode, one bit per bank: 1 for a list.
    pub const FM1R: Self = Self(0x204);
    /// Filter scale, one bit per bank: 0 for 16 bits.
    pub const FS1R: Self = Self(0x20c);
    /// FIFO of the accepted frames, one bit per bank.
    pub const FFA1R: Self = Self(0x214);
    /// Active filters, one bit per bank.
    pub const FA1R: Self = Self(0x21c);

    /// CanIdentifier, length, bytes 0 to 3 and 4 to 7 of the three mailboxes.
    pub const MAILBOXES: [[Self; 4]; 3] = [
        [Self(0x180), Self(0x184), Self(0x188), Self(0x18c)],
        [Self(0x190), Self(0x194), Self(0x198), Self(0x19c)],
        [Self(0x1a0), Self(0x1a4), Self(0x1a8), Self(0x1ac)],
    ];

    /// Both words of the first three filter banks.
    pub const BANKS: [[Self; 2]; 3] = [
        [Self(0x240), Self(0x244)],
        [Self(0x248), Self(0x24c)],
        [Self(0x250), Self(0x254)],
    ];

    /// Bytes from the unit's beginning: a multiple of four below 0x400.
    pub const fn offset(self) -> usize {
        self.0 as usize
    }
}

/// MCR: request to be in initialisation.
pub(super) const INRQ: u32 = 1;
/// MCR: mailboxes are sent in the order of their filling.
pub(super) const TXFP: u32 = 1 << 2;
/// MCR: traffic wakes a sleeping unit.
pub(super) const AWUM: u32 = 1 << 5;
/// MCR: bus-off ends by itself after 128 times 11 recessive bits.
pub(super) const ABOM: u32 = 1 << 6;

/// MSR: the unit is in initialisation.
pub(super) const INAK: u32 = 1;
/// MSR: an error that IER selects has come up; written to clear.
pub(super) const ERRI: u32 = 1 << 2;

/// RF0R: frames in the FIFO.
pub(super) const FMP0: u32 = 3;
/// RF0R: a frame was lost in a full FIFO; written to clear.
pub(super) const FOVR0: u32 = 1 << 4;
/// RF0R: release the first frame; set until that is done.
pub(super) const RFOM0: u32 = 1 << 5;

/// IER: interrupt while FIFO 0 holds a frame.
pub(super) const FMPIE0: u32 = 1 << 1;
/// IER: bus-off comes up in MSR. Without ERRIE it does not interrupt.
pub(super) const BOFIE: u32 = 1 << 10;

/// ESR: bus-off.
pub(super) const BOFF: u32 = 1 << 2;

/// FMR: filters may be changed; nothing is received meanwhile.
pub(super) const FINIT: u32 = 1;

/// Mailbox or FIFO: request to send.
pub(super) const TXRQ: u32 = 1;
/// Mailbox or FIFO: a frame that asks for data.
pub(super) const RTR: u32 = 1 << 1;
/// Mailbox or FIFO: an identifier of 29 bits, from bit 3; else 11, from bit 21.
pub(super) const IDE: u32 = 1 << 2;
