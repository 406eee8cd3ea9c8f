//! The registers of the chip's CAN unit for its controller.

use stm32f4xx_hal::pac::CAN1;
use stm32f4xx_hal::rcc::{Enable, Rcc, Reset};

use amiro_ipf::board::can::{CanRegister, CanRegisters};

/// The registers of CAN1.
pub(crate) struct CanUnit(CAN1);

impl CanUnit {
    /// Clocks the unit and resets what a boot loader left in it.
    pub(super) fn start(unit: CAN1, rcc: &mut Rcc) -> Self {
        CAN1::enable(rcc);
        CAN1::reset(rcc);
        Self(unit)
    }

    fn pointer(register: CanRegister) -> *mut u32 {
        CAN1::ptr()
            .cast::<u32>()
            .cast_mut()
            .wrapping_byte_add(register.offset())
    }
}

#[expect(unsafe_code, reason = "the unit's registers take raw numbers")]
impl CanRegisters for CanUnit {
    fn read(&self, register: CanRegister) -> u32 {
        // SAFETY: the unit is ours and clocked, a `CanRegister` is a multiple of four
        // within its 1 KiB, and reading changes nothing in it.
        unsafe { Self::pointer(register).read_volatile() }
    }

    fn write(&mut self, register: CanRegister, bits: u32) {
        // SAFETY: as above; the unit reaches no memory, so that no value that is
        // written to it breaks anything but the bus.
        unsafe { Self::pointer(register).write_volatile(bits) }
    }
}
