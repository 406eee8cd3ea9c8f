//! A line to an emulator that a host can close and reopen: a Unix socket.

use std::io::Write;
use std::net::Shutdown;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::{Duration, Instant};

use super::{Ends, LinkError};

/// Connects to the emulator's socket, which may take a moment to exist.
pub(super) fn connect(line: &Path) -> Result<Ends, LinkError> {
    let deadline = Instant::now() + Duration::from_secs(5);
    let failed = |error: std::io::Error| LinkError::Start(format!("{}: {error}", line.display()));
    let stream = loop {
        match UnixStream::connect(line) {
            Ok(stream) => break stream,
            Err(error) if Instant::now() > deadline => return Err(failed(error)),
            Err(_) => std::thread::sleep(Duration::from_millis(10)),
        }
    };
    let reader = stream.try_clone().map_err(failed)?;
    Ok((Box::new(reader), Box::new(Socket(stream))))
}

/// A socket that is shut down when it is dropped, so that its reader ends too.
struct Socket(UnixStream);

impl Write for Socket {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.0.flush()
    }
}

impl Drop for Socket {
    fn drop(&mut self) {
        // It may be closed already.
        let _ = self.0.shutdown(Shutdown::Both);
    }
}
