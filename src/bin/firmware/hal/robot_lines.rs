//! The lines on which the robot's boards agree to start and to stop.

use stm32f4xx_hal::gpio::{Input, OpenDrain, Output, PC12, PC13};

/// Samples in a row, half a millisecond apart, that make a request.
const STEADY: u8 = 5;

/// SYS_SYNC: held low until this board is up; the others wait for that.
pub(crate) struct StartLine(pub(super) PC12<Output<OpenDrain>>);

impl StartLine {
    /// Lets go: this board is up. Who else holds it low is none of its business.
    pub(crate) fn release(mut self) {
        self.0.set_high();
    }
}

/// SYS_PD: pulled low by whoever wants the robot off.
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

    /// Looks at the line, two thousand times a second; whether somebody has just pulled
    /// it. One that was never high is not connected and means nothing.
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
