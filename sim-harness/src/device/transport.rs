//! The two ends of a byte stream, read by a thread.

use std::io::{ErrorKind, Read, Write};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;

use super::LinkError;

/// Pieces of received bytes that wait to be read, at most.
pub(super) const MOST_WAITING: usize = 1024;

/// The two ends of a byte stream.
pub(super) struct Transport {
    outgoing: Box<dyn Write + Send>,
    pub(super) incoming: Receiver<Vec<u8>>,
}

impl Transport {
    /// A thread of its own reads, so that waiting always has a deadline.
    pub(super) fn over(
        mut reader: impl Read + Send + 'static,
        writer: impl Write + Send + 'static,
    ) -> Self {
        let (sender, incoming) = sync_channel(MOST_WAITING);
        thread::spawn(move || pump(&mut reader, &sender));
        Self {
            outgoing: Box::new(writer),
            incoming,
        }
    }

    /// Neither end leads anywhere.
    pub(super) fn closed() -> Self {
        Self {
            outgoing: Box::new(std::io::sink()),
            incoming: sync_channel(1).1,
        }
    }

    /// Writes bytes at once.
    ///
    /// # Errors
    /// [`LinkError::Write`].
    pub(super) fn write(&mut self, bytes: &[u8]) -> Result<(), LinkError> {
        if bytes.is_empty() {
            return Ok(());
        }
        self.outgoing
            .write_all(bytes)
            .and_then(|()| self.outgoing.flush())
            .map_err(LinkError::Write)
    }
}

/// A reader and a writer that were opened.
pub type Ends = (Box<dyn Read + Send>, Box<dyn Write + Send>);

/// How a link is opened again.
pub(super) type Opener = Box<dyn FnMut() -> Result<Ends, LinkError> + Send>;

/// Reads until the stream ends or the receiver is dropped.
fn pump(reader: &mut impl Read, sender: &SyncSender<Vec<u8>>) {
    let mut buffer = [0; 4096];
    loop {
        match reader.read(&mut buffer) {
            Ok(0) => return,
            Ok(count) => {
                let bytes = buffer.get(..count).unwrap_or_default().to_vec();
                if sender.send(bytes).is_err() {
                    return;
                }
            }
            Err(error) => match error.kind() {
                ErrorKind::Interrupted => {}
                // A serial port that is silent.
                ErrorKind::TimedOut | ErrorKind::WouldBlock => {}
                _ => return,
            },
        }
    }
}
