//! Any bytes as a recording, of either format.

use amiro_ipf::node::Input;
use sim_harness::log::{Format, Recording, read_from};

use crate::framing::{Script, frame_around};

/// First byte of bytes that are read as they are.
pub const AS_IT_IS: u8 = 0;
/// First byte of pieces that each become a whole frame.
pub const FRAMES: u8 = 1;

/// Reads the bytes after the first as a file, or frames around pieces of them.
pub fn check(bytes: &[u8]) {
    let mut script = Script(bytes);
    if script.byte() & 1 == AS_IT_IS {
        check_file(script.0);
        return;
    }
    let mut file = vec![0];
    let mut sequence = 0;
    while !script.is_over() {
        let boot_id = if script.byte() & 1 == 0 { 0xa5 } else { 3 };
        file.extend(frame_around(boot_id, sequence, script.piece()));
        sequence += 1;
    }
    check_file(&file);
}

fn check_file(file: &[u8]) {
    match read_from(file) {
        Ok(recording) => assert_is_orderly(&recording, file.len()),
        Err(error) => assert_is_printable(&error.to_string()),
    }
}

/// What the reader promises of a recording.
fn assert_is_orderly(recording: &Recording, bytes: usize) {
    // A row of text is two inputs and eleven numbers long, a frame one and 9 bytes.
    let entries = recording.inputs.len() + recording.messages.len();
    assert!(entries <= bytes, "{entries} entries of {bytes} bytes");
    assert!(recording.segments <= entries);
    // Each kind has stamps of its own; and each sender, of which a stream has two.
    let is_of_one = recording.format == Format::AmiroText;
    let (mut moved_us, mut driven_us, mut sampled_us) = (0, 0, 0);
    for input in &recording.inputs {
        match input {
            Input::Odometry { stamp_us, pose } => {
                assert!(pose.is_finite(), "{input:?}");
                assert!(!is_of_one || *stamp_us >= moved_us, "{input:?}");
                moved_us = *stamp_us;
            }
            Input::Wheels { stamp_us, speeds } => {
                assert!(speeds.left_m_per_s.is_finite() && speeds.right_m_per_s.is_finite());
                assert!(!is_of_one || *stamp_us >= driven_us, "{input:?}");
                driven_us = *stamp_us;
            }
            Input::Proximity { stamp_us, .. } => {
                assert!(!is_of_one || *stamp_us >= sampled_us, "{input:?}");
                sampled_us = *stamp_us;
            }
            _ => {}
        }
    }
    if let Some(config) = &recording.config {
        assert_eq!(config.validate(), Ok(()));
    }
    if let Some(truth) = &recording.truth {
        assert!(truth.poses.is_sorted_by_key(|(stamp_us, _)| *stamp_us));
        assert!(truth.poses.iter().all(|(_, pose)| pose.is_finite()));
        assert!(
            truth
                .scenario
                .as_ref()
                .is_none_or(|text| text.len() <= 65_536)
        );
    }
    assert_is_printable(&recording.refusals.to_string());
}

/// Text for a terminal brings no control characters of a file's with it.
pub fn assert_is_printable(text: &str) {
    let control = |letter: &char| letter.is_control() && *letter != '\n';
    assert_eq!(text.chars().find(control), None, "in {text:?}");
    assert!(text.len() < 100_000, "{} bytes of message", text.len());
}
