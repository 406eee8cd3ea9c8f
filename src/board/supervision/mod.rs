//! Watching over the image itself: who still runs, how the last life ended, how much a
//! step may cost.
//!
//! Values and rules only: registers, memory that survives a reset and the watchdog are
//! the board's. What is found is said in the stream.

mod boot_history;
mod load;
mod post_mortem;
mod programming_port;
mod task_check_in;

use serde::{Deserialize, Serialize};

pub use boot_history::{LIVES, Lives, SHORT_MS};
pub use load::{LoadGuard, STAGES};
pub use post_mortem::{Cause, PLACE, PostMortem, Registers, WORDS};
pub use programming_port::ProgrammingPort;
pub use task_check_in::{Roll, Task};

/// How the image watches over itself, once a second and after a start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Supervision {
    /// Whether it does all it can.
    pub mode: Mode,
    /// What began this life.
    pub reset: ResetCause,
    /// Whether the flash holds what was built.
    pub image: ImageCheck,
    /// Whether AMiRo's boot loader started the image.
    pub is_under_loader: bool,
    /// Bytes of the stack that no task has used since the start; 0 before the first look.
    pub stack_unused: u32,
}

/// What the image does. Variants are appended, never reordered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Mode {
    /// Everything.
    #[default]
    Normal,
    /// It talks and does not filter: it died three times within ten seconds.
    SafeAfterDeaths,
    /// It talks and does not filter: its flash is damaged.
    SafeForImage,
    /// Somebody wants the robot off: it says so, and hands over to the boot loader if
    /// there is one.
    ShuttingDown,
}

/// What began a life, of the chip's own flags. Variants are appended, never reordered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ResetCause {
    /// The chip says nothing, as in an emulator.
    #[default]
    Unknown,
    /// Power came, or fell too low and came back.
    Power,
    /// The reset pin.
    Pin,
    /// The image itself: a panic, a fault, or the programming port.
    Software,
    /// The watchdog: a task no longer ran.
    Watchdog,
}

/// Whether the flash holds what was built. Variants are appended, never reordered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ImageCheck {
    /// Nobody wrote a checksum into it: it was flashed from the ELF file.
    #[default]
    Unmarked,
    /// It does.
    Good,
    /// It does not.
    Damaged,
}

impl ResetCause {
    /// The cause in the chip's flags: bits 25 to 31 of its clock control and status
    /// register (RM0090, 7.3.21). The pin's flag is set with every other one.
    #[must_use]
    pub const fn of_flags(csr: u32) -> Self {
        const LOW_POWER: u32 = 1 << 31;
        const WINDOW_WATCHDOG: u32 = 1 << 30;
        const WATCHDOG: u32 = 1 << 29;
        const SOFTWARE: u32 = 1 << 28;
        const POWER: u32 = 1 << 27;
        const PIN: u32 = 1 << 26;
        const BROWN_OUT: u32 = 1 << 25;
        if csr & (POWER | BROWN_OUT) != 0 {
            Self::Power
        } else if csr & (WATCHDOG | WINDOW_WATCHDOG) != 0 {
            Self::Watchdog
        } else if csr & SOFTWARE != 0 {
            Self::Software
        } else if csr & (PIN | LOW_POWER) != 0 {
            Self::Pin
        } else {
            Self::Unknown
        }
    }

    /// Whether the image itself may have been the cause. Where the chip says nothing, a
    /// record of a death speaks for itself.
    #[must_use]
    pub const fn may_be_death(self) -> bool {
        matches!(self, Self::Software | Self::Watchdog | Self::Unknown)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn f59_reset_flags_name_their_cause() {
        for (csr, cause) in [
            (0x0e00_0003, ResetCause::Power),
            (0x0600_0003, ResetCause::Power),
            (0x2400_0003, ResetCause::Watchdog),
            (0x1400_0003, ResetCause::Software),
            (0x0400_0003, ResetCause::Pin),
            (0x0000_0000, ResetCause::Unknown),
        ] {
            assert_eq!(ResetCause::of_flags(csr), cause, "{csr:#x}");
        }
    }

    #[test]
    fn f59_each_reset_flag_alone_has_its_cause() {
        // RM0090, 7.3.21, from bit 31 down: low power, window watchdog, independent
        // watchdog, software, power, pin, brown-out. Bit 24 clears them and says nothing.
        for (bit, cause) in [
            (31, ResetCause::Pin),
            (30, ResetCause::Watchdog),
            (29, ResetCause::Watchdog),
            (28, ResetCause::Software),
            (27, ResetCause::Power),
            (26, ResetCause::Pin),
            (25, ResetCause::Power),
            (24, ResetCause::Unknown),
        ] {
            assert_eq!(ResetCause::of_flags(1 << bit), cause, "bit {bit}");
        }
    }

    #[test]
    fn f58_only_what_the_image_can_do_itself_is_held_against_it() {
        for (cause, may_be_death) in [
            (ResetCause::Software, true),
            (ResetCause::Watchdog, true),
            (ResetCause::Unknown, true),
            (ResetCause::Power, false),
            (ResetCause::Pin, false),
        ] {
            assert_eq!(cause.may_be_death(), may_be_death, "{cause:?}");
        }
    }
}
