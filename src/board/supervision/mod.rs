//! Rules by which the image supervises itself: do all tasks run, how did the last boot
//! end, how long may a step take.
//!
//! Values and rules only: the flash image owns the registers, the memory that survives a
//! reset and the watchdog. The findings go out as [`Supervision`] and [`PostMortem`].

mod boot_history;
mod load;
mod post_mortem;
mod programming_port;
mod task_check_in;

use serde::{Deserialize, Serialize};

pub use boot_history::{BootHistory, HISTORY_WORDS, KEPT_BOOTS, SHORT_MS};
pub use load::{LoadGuard, STAGES};
pub use post_mortem::{CoreRegisters, FailureCause, MAX_PLACE_BYTES, PostMortem, RECORD_WORDS};
pub use programming_port::ProgrammingPort;
pub use task_check_in::{Task, TaskCheckIn};

/// State of the image, sent after a start and once per second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Supervision {
    /// Whether it does everything.
    pub mode: Mode,
    /// What caused the last reset.
    pub reset: ResetCause,
    /// Whether the flash holds what was built.
    pub image: ImageCheck,
    /// Whether AMiRo's boot loader started the image.
    pub is_under_loader: bool,
    /// Bytes of the stack that no task has used since the start; 0 before the first check.
    pub stack_unused: u32,
}

/// What the image does. Variants are appended, never reordered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Mode {
    /// Everything.
    #[default]
    Normal,
    /// It communicates and does not filter: three boots failed within ten seconds.
    SafeAfterDeaths,
    /// It communicates and does not filter: its flash is damaged.
    SafeForImage,
    /// A shutdown was requested: it reports that, and hands over to the boot loader if
    /// there is one.
    ShuttingDown,
}

/// What caused a reset, by the chip's own flags. Variants are appended, never reordered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ResetCause {
    /// The chip has no flag set, as in an emulator.
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
    /// It has no checksum: it was flashed from the ELF file.
    #[default]
    Unmarked,
    /// The checksum matches.
    Good,
    /// The checksum does not match.
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

    /// Whether the image itself may have caused it. Where the chip has no flag, a kept
    /// post-mortem record decides.
    #[must_use]
    pub const fn may_be_failure(self) -> bool {
        matches!(self, Self::Software | Self::Watchdog | Self::Unknown)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn f59_reset_flags_name_their_cause() {
        // RM0090, 7.3.21, from bit 31 down: low power, window watchdog, independent
        // watchdog, software, power, pin, brown-out. Bit 24 clears them. The chip sets the
        // pin's flag with every other one, and both of power.
        for (csr, cause) in [
            (1 << 31, ResetCause::Pin),
            (1 << 30, ResetCause::Watchdog),
            (1 << 29, ResetCause::Watchdog),
            (1 << 28, ResetCause::Software),
            (1 << 27, ResetCause::Power),
            (1 << 26, ResetCause::Pin),
            (1 << 25, ResetCause::Power),
            (1 << 24, ResetCause::Unknown),
            (0, ResetCause::Unknown),
            (0x0e00_0003, ResetCause::Power),
            (0x0600_0003, ResetCause::Power),
            (0x2400_0003, ResetCause::Watchdog),
            (0x1400_0003, ResetCause::Software),
        ] {
            assert_eq!(ResetCause::of_flags(csr), cause, "{csr:#x}");
        }
    }

    #[test]
    fn f58_only_resets_that_the_image_can_cause_may_be_failures() {
        for (cause, may_be_failure) in [
            (ResetCause::Software, true),
            (ResetCause::Watchdog, true),
            (ResetCause::Unknown, true),
            (ResetCause::Power, false),
            (ResetCause::Pin, false),
        ] {
            assert_eq!(cause.may_be_failure(), may_be_failure, "{cause:?}");
        }
    }
}
