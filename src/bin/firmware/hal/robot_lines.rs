//! The lines between the robot's boards for start and shutdown.

use stm32f4xx_hal::gpio::{Input, OpenDrain, Output, PC12, PC13};

/// Samples in a row, half a millisecond apart, that make a request.
const STEADY: u8 = 5;

/// SYS_SYNC: held low until this board is up; the others wait for that.
pub(crate) struct StartLine(pub(super) PC12<Output<OpenDrain>>);

impl StartLine {
    /// Releases the line: this board is up. Other boards may still hold it low.
    pub(crate) fn release(mut self) {
        self.0.set_high();
    }
}

/// SYS_PD: pulled low to request a shutdown.
pub(crate) struct ShutdownLine {
    pin: PC13<Input>,
    was_high: bool,
    low: u8,
}

impl ShutdownLine {
    pub(super) fn new(pin: PC13<Input>) -> Self {
        Self {
            pin,
            was_high: false,
            low: 0,
        }
    }

    /// Samples the line, to be called 2000 times per second; whether it has just been
    /// pulled low. A line that was never high is not connected and is ignored.
    pub(crate) fn is_pulled(&mut self) -> bool {
        if self.pin.is_high() {
            self.was_high = true;
            self.low = 0;
            return false;
        }
        self.low = self.low.saturating_add(1);
        self.was_high && self.low == STEADY
    }
}
