//! A board in memory: the very terminal of the flash image, on a thread of the host.

use std::io::{self, Read, Write};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;

use amiro_ipf::BUILD_ID;
use amiro_ipf::event::{Boot, ClockSource};
use amiro_ipf::filter::ParticleSet;
use amiro_ipf::node::Node;
use amiro_ipf::wire::{Terminal, WINDOW, WIRE_VERSION};

use super::Board;

/// As many particles as the flash image holds.
const CAPACITY: usize = 8000;

impl Board {
    /// A board that runs on a thread. `on_line` sees every frame that the board sends
    /// and says whether it arrives; a frame may be changed on the way.
    #[must_use]
    pub fn in_memory(mut on_line: impl FnMut(&mut Vec<u8>) -> bool + Send + 'static) -> Self {
        let (to_board, from_host) = channel::<Vec<u8>>();
        let (to_host, from_board) = channel::<Vec<u8>>();
        thread::spawn(move || {
            let mut particles = Box::new(ParticleSet::<CAPACITY>::new());
            let boot = Boot {
                wire_version: WIRE_VERSION,
                build_id: BUILD_ID,
                capacity: CAPACITY as u32,
                window: WINDOW,
                baud: 0,
                clock: ClockSource::Host,
                core_hz: 0,
            };
            let mut terminal = Terminal::new(Node::new(&mut particles), boot, 0);
            let mut send = |frame: &[u8], _| {
                let mut frame = frame.to_vec();
                if on_line(&mut frame) {
                    // The host may have hung up; the loop below then ends.
                    let _ = to_host.send(frame);
                }
            };
            for byte in from_host.into_iter().flatten() {
                terminal.receive(byte, &mut send);
            }
        });
        let reader = ChannelReader {
            incoming: from_board,
            rest: Vec::new(),
        };
        Self::over(reader, ChannelWriter(to_board), ())
    }
}

struct ChannelWriter(Sender<Vec<u8>>);

impl Write for ChannelWriter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self.0.send(bytes.to_vec()) {
            Ok(()) => Ok(bytes.len()),
            Err(_) => Err(io::ErrorKind::BrokenPipe.into()),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

struct ChannelReader {
    incoming: Receiver<Vec<u8>>,
    rest: Vec<u8>,
}

impl Read for ChannelReader {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.rest.is_empty() {
            match self.incoming.recv() {
                Ok(bytes) => self.rest = bytes,
                Err(_) => return Ok(0),
            }
        }
        let count = self.rest.len().min(buffer.len());
        for (place, byte) in buffer.iter_mut().zip(self.rest.drain(..count)) {
            *place = byte;
        }
        Ok(count)
    }
}
