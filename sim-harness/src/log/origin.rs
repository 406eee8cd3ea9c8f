//! Detects the recording of a robot, which cannot be repeated.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use amiro_ipf::link::{Decoder, Message, Received};
use amiro_ipf::node::{Input, Source};

use super::stream::is_stream;

/// Bytes of a file's beginning that are enough to decide.
const DECIDING_BYTES: u64 = 8192;

/// The beginning of a file, enough to decide what it is.
///
/// # Errors
/// What the system reports.
pub(crate) fn head_of(path: &Path) -> io::Result<Vec<u8>> {
    let mut head = Vec::new();
    File::open(path)?
        .take(DECIDING_BYTES)
        .read_to_end(&mut head)?;
    Ok(head)
}

/// Whether a file that begins with these bytes is the recording of a robot: AMiRo's text,
/// or frames that begin with the configuration of a board that reads its own sensors.
///
/// The output of `simulate` and `replay` is none: a simulated recording begins with its
/// truth, and the stream of a replay has its inputs from the link.
pub(crate) fn is_of_a_robot(head: &[u8]) -> bool {
    if is_text(head) {
        return true;
    }
    let mut decoder = Decoder::new();
    let mut frames = head.iter().filter_map(|byte| match decoder.push(*byte)? {
        Received::Frame { frame, .. } => Some(frame.message),
        Received::Broken(_) => None,
    });
    matches!(
        frames.next(),
        Some(Message::Input(Input::Configure(config))) if config.source == Source::Board
    )
}

/// Whether a file that begins with these bytes is a recording of an AMiRo, robot or
/// simulated: AMiRo's text or frames of the link.
pub(crate) fn is_of_an_amiro(head: &[u8]) -> bool {
    is_text(head) || is_stream(head)
}

/// Whether these bytes begin as the header of AMiRo's text.
fn is_text(head: &[u8]) -> bool {
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    let mut letters = text.iter().filter(|byte| !byte.is_ascii_whitespace());
    b"PRV0PRV1".iter().all(|letter| {
        let next = letters.next();
        next.is_some_and(|next| next.eq_ignore_ascii_case(letter))
    })
}

#[cfg(test)]
mod tests {
    use amiro_ipf::node::Config;

    use super::*;
    use crate::log::RecordingWriter;

    fn recording(source: Source) -> Vec<u8> {
        let config = Config {
            source,
            ..Config::default()
        };
        let mut bytes = Vec::new();
        let mut writer = RecordingWriter::new(&mut bytes).unwrap();
        writer.write_input(&Input::Configure(config)).unwrap();
        bytes
    }

    #[test]
    fn a_robots_recordings_differ_from_simulated_ones() {
        assert!(is_of_a_robot(&recording(Source::Board)));
        assert!(is_of_a_robot(b"PRV 0\tPRV 1\tPRV 2"));
        assert!(is_of_a_robot(b"\xef\xbb\xbfprv0\tPRV 1"));
        for other in [
            &recording(Source::Link)[..],
            b"",
            b"PRV 0",
            b"P5\n",
            b"\0\0\0",
        ] {
            assert!(!is_of_a_robot(other), "{other:?}");
        }
    }
}
