//! A real board at a serial port.

use std::time::Duration;

use super::{Board, LinkError};

impl Board {
    /// Opens a serial port, 8N1 at the given speed.
    ///
    /// # Errors
    /// [`LinkError::Start`] with the port's name and what the system said.
    pub fn on_port(name: &str, baud: u32) -> Result<Self, LinkError> {
        let failed = |error: serialport::Error| LinkError::Start(format!("{name}: {error}"));
        let port = serialport::new(name, baud)
            .timeout(Duration::from_millis(50))
            .open()
            .map_err(failed)?;
        let reader = port.try_clone().map_err(failed)?;
        Ok(Self::over(reader, port, ()))
    }
}
