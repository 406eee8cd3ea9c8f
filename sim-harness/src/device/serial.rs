//! A real board at a serial port.

use std::time::Duration;

use super::{Board, Ends, LinkError};

impl Board {
    /// Opens a serial port, 8N1 at the given speed; again, when its device went away.
    ///
    /// # Errors
    /// [`LinkError::Start`] with the port's name and the system's error.
    pub fn on_port(name: &str, baud: u32) -> Result<Self, LinkError> {
        let name = name.to_owned();
        let open = move || {
            let failed = |error: serialport::Error| LinkError::Start(format!("{name}: {error}"));
            let port = serialport::new(&name, baud)
                .timeout(Duration::from_millis(50))
                .open()
                .map_err(failed)?;
            // Bytes from before this session belong to an earlier one.
            port.clear(serialport::ClearBuffer::Input).map_err(failed)?;
            let reader = port.try_clone().map_err(failed)?;
            let ends: Ends = (Box::new(reader), Box::new(port));
            Ok(ends)
        };
        Self::reopened_by(open, ())
    }
}
