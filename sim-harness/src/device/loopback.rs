//! A board in memory: the flash image's device endpoint on a thread of the host.
//!
//! It has sensors if it is given buses with their parts on them. Their time passes only
//! when a host requests something that takes time.

use std::io::{self, Read, Write};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;

use amiro_ipf::BUILD_ID;
use amiro_ipf::board::acquisition::{Acquisition, BUSES};
use amiro_ipf::board::clock_choice::ClockSource;
use amiro_ipf::filter::ParticleSet;
use amiro_ipf::link::{Boot, DeviceEndpoint, Message, Priority, WINDOW, WIRE_VERSION};
use amiro_ipf::node::Node;

use super::Board;
use crate::bus::RobotBuses;

/// As many particles as the flash image holds.
const CAPACITY: usize = 8000;

/// Period of the acquisition's poll, as in the flash image.
const POLL_PERIOD_US: u64 = 500;

/// Time in which working sensors become good and the memory is read, and in which any
/// measurement of the offsets ends and is written: 62 rounds.
const SETTLED_US: u64 = 500_000;

/// The `Boot` of a board that is no microcontroller, with a given particle capacity.
#[must_use]
pub fn boot_on_host(capacity: u32) -> Boot {
    Boot {
        wire_version: WIRE_VERSION,
        build_id: BUILD_ID,
        capacity,
        window: WINDOW,
        baud: 0,
        clock: ClockSource::Host,
        core_hz: 0,
    }
}

impl Board {
    /// A board that runs on a thread. `on_line` sees every frame that the board sends
    /// and returns whether it arrives; it may change the frame.
    #[must_use]
    pub fn in_memory(on_line: impl FnMut(&mut Vec<u8>) -> bool + Send + 'static) -> Self {
        Self::on_thread(None, on_line)
    }

    /// As [`Board::in_memory`], with the robot's acquisition on these buses: it answers a
    /// request to calibrate, and readings of that time are its own inputs.
    #[must_use]
    pub fn robot_in_memory(
        buses: RobotBuses,
        on_line: impl FnMut(&mut Vec<u8>) -> bool + Send + 'static,
    ) -> Self {
        Self::on_thread(Some(Body::new(buses)), on_line)
    }

    fn on_thread(
        mut body: Option<Body>,
        mut on_line: impl FnMut(&mut Vec<u8>) -> bool + Send + 'static,
    ) -> Self {
        let (to_board, from_host) = channel::<Vec<u8>>();
        let (to_host, from_board) = channel::<Vec<u8>>();
        thread::spawn(move || {
            let mut particles = Box::new(ParticleSet::<CAPACITY>::new());
            let boot = boot_on_host(CAPACITY as u32);
            let mut endpoint = DeviceEndpoint::new(Node::new(&mut particles), boot, 0);
            let mut send = |frame: &[u8], _| {
                let mut frame = frame.to_vec();
                if on_line(&mut frame) {
                    // The host may have closed the link; the loop below then ends.
                    let _ = to_host.send(frame);
                }
            };
            if let Some(body) = &mut body {
                body.live(&mut endpoint, &mut send);
            }
            for byte in from_host.into_iter().flatten() {
                endpoint.receive(byte, &mut send);
                if endpoint.take_calibration()
                    && let Some(body) = &mut body
                {
                    body.acquisition.calibrate();
                    body.live(&mut endpoint, &mut send);
                }
            }
        });
        let reader = ChannelReader {
            incoming: from_board,
            rest: Vec::new(),
        };
        Self::over(reader, ChannelWriter(to_board), ())
    }
}

/// A robot's acquisition and the parts on its buses.
struct Body {
    acquisition: Acquisition,
    buses: RobotBuses,
    now_us: u64,
}

impl Body {
    fn new(buses: RobotBuses) -> Self {
        Self {
            acquisition: Acquisition::new(),
            buses,
            now_us: 0,
        }
    }

    /// Lets half a second pass; the results of the acquisition go where they go in the
    /// flash image.
    fn live<const N: usize>(
        &mut self,
        endpoint: &mut DeviceEndpoint<'_, N>,
        send: &mut impl FnMut(&[u8], Priority),
    ) {
        let end_us = self.now_us + SETTLED_US;
        while self.now_us < end_us {
            self.buses.advance_to(self.now_us * 1_000);
            if let Some(input) = self.acquisition.poll(self.now_us) {
                endpoint.inject(&input, send);
            }
            self.exchange();
            if let Some(offsets) = self.acquisition.take_offsets() {
                endpoint.publish(&Message::Offsets(offsets), send);
            }
            // A transaction takes its time, and nothing else happens meanwhile.
            let bus_us = self.buses.now_ns().div_ceil(1_000);
            self.now_us = bus_us.max(self.now_us + POLL_PERIOD_US);
        }
    }

    /// Executes the acquisition's transactions until there are none.
    fn exchange(&mut self) {
        for (number, bus) in BUSES.into_iter().enumerate() {
            while let Some(transaction) = self.acquisition.next(bus, self.now_us) {
                let result = self.buses.bus_mut(number).run(&transaction);
                let result = result.as_deref().map_err(|error| (*error).into());
                self.acquisition.answer(bus, self.now_us, result);
            }
        }
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
