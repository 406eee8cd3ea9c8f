//! Writing a recording: the bytes of the link, frame by frame.

use std::io::{BufRead, Error, Write};

use amiro_ipf::link::{Encoder, FAULTS_CHUNK, Message, SCENARIO_CHUNK, TruthMessage};
use amiro_ipf::node::Input;

/// Boot id of a recording host; a board draws its own.
const HOST_BOOT_ID: u8 = 0xA5;

/// Writes a host's inputs, a simulator's ground truth and a board's messages.
///
/// Every frame ends with its zero byte, so that a cut recording has lost at most its last
/// frame. Writes go to `W` one frame at a time: give it a buffered writer. The file is
/// `W`'s to finish; see [`finish`](Self::finish).
#[derive(Debug)]
pub struct RecordingWriter<W: Write> {
    write: W,
    encoder: Encoder,
}

impl<W: Write> RecordingWriter<W> {
    /// Begins a recording, with the zero byte that identifies its format.
    ///
    /// # Errors
    /// The error of `W`.
    pub fn new(mut write: W) -> Result<Self, Error> {
        write.write_all(&[0])?;
        Ok(Self {
            write,
            encoder: Encoder::new(HOST_BOOT_ID),
        })
    }

    /// Writes an input; the first should be the configuration.
    ///
    /// # Errors
    /// The error of `W`.
    pub fn write_input(&mut self, input: &Input) -> Result<(), Error> {
        self.write_message(&Message::Input(*input))
    }

    /// Writes a true pose, a seed or a piece of a scenario.
    ///
    /// # Errors
    /// The error of `W`.
    pub fn write_truth(&mut self, truth: &TruthMessage) -> Result<(), Error> {
        self.write_message(&Message::Truth(truth.clone()))
    }

    /// Writes the text of a scenario, in as many pieces as it takes.
    ///
    /// Readers take at most 64 KiB.
    ///
    /// # Errors
    /// The error of `W`.
    pub fn write_scenario(&mut self, text: &str) -> Result<(), Error> {
        for chunk in text.as_bytes().chunks(SCENARIO_CHUNK) {
            // A chunk is at most as long as its place: nothing is cut.
            let chunk = chunk.iter().copied().collect();
            self.write_truth(&TruthMessage::Scenario(chunk))?;
        }
        Ok(())
    }

    /// Writes the text of the injected faults and the seed of their random part, in as many
    /// pieces as it takes.
    ///
    /// Readers take at most 4 KiB of all such texts; two in a row need two seeds.
    ///
    /// # Errors
    /// The error of `W`.
    pub fn write_faults(&mut self, text: &str, seed: u64) -> Result<(), Error> {
        for chunk in text.as_bytes().chunks(FAULTS_CHUNK) {
            let text = chunk.iter().copied().collect();
            self.write_truth(&TruthMessage::Faults { seed, text })?;
        }
        Ok(())
    }

    /// The frame of an input as [`write_input`](Self::write_input) would write it, with its
    /// number used up: for a line that may lose it.
    ///
    /// # Errors
    /// An input that does not fit into a frame; there is none.
    pub fn frame_of(&mut self, input: &Input) -> Result<&[u8], Error> {
        match self.encoder.encode(&Message::Input(*input)) {
            [] => Err(Error::other("a message does not fit into a frame")),
            frame => Ok(frame),
        }
    }

    /// Writes whole frames of a board unchanged.
    ///
    /// A last zero byte that is missing is added, so that the next frame is not lost
    /// with this one.
    ///
    /// # Errors
    /// The error of `W`.
    pub fn write_frames(&mut self, frames: &[u8]) -> Result<(), Error> {
        self.write_frames_of(frames)
    }

    /// The same for frames from a reader.
    ///
    /// # Errors
    /// The error of `W` or of the reader.
    pub fn write_frames_of(&mut self, mut frames: impl BufRead) -> Result<(), Error> {
        let mut last = 0;
        loop {
            let bytes = frames.fill_buf()?;
            let Some(&end) = bytes.last() else {
                break;
            };
            last = end;
            self.write.write_all(bytes)?;
            let length = bytes.len();
            frames.consume(length);
        }
        match last {
            0 => Ok(()),
            _ => self.write.write_all(&[0]),
        }
    }

    /// Flushes what was written so far.
    ///
    /// # Errors
    /// The error of `W`.
    pub fn flush(&mut self) -> Result<(), Error> {
        self.write.flush()
    }

    /// Flushes, and returns `W`.
    ///
    /// # Errors
    /// The error of `W`.
    pub fn finish(mut self) -> Result<W, Error> {
        self.write.flush()?;
        Ok(self.write)
    }

    /// Writes any message.
    ///
    /// # Errors
    /// The error of `W`.
    pub fn write_message(&mut self, message: &Message) -> Result<(), Error> {
        match self.encoder.encode(message) {
            [] => Err(Error::other("a message does not fit into a frame")),
            frame => self.write.write_all(frame),
        }
    }
}
