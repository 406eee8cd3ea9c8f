//! Any bytes through the decoder.

use amiro_ipf::link::{Decoder, Frame, MAX_FRAME, Message, Received};

use crate::framing::frame_around;

/// The bytes as a line gives them, and as the payload of a whole frame: what is a
/// message is written in one way only, and a good frame after them is read.
pub fn check(bytes: &[u8]) {
    decode_all(bytes);
    let (&[boot_id, low, high], payload) = bytes
        .split_first_chunk::<3>()
        .unwrap_or((&[0, 0, 0], bytes));
    decode_all(&frame_around(
        boot_id,
        u16::from_le_bytes([low, high]),
        payload,
    ));
}

fn decode_all(bytes: &[u8]) {
    let mut decoder = Decoder::new();
    let mut answers = 0;
    for &byte in bytes {
        let answer = decoder.push(byte);
        assert!(
            byte == 0 || answer.is_none(),
            "only a zero byte ends a frame"
        );
        answers += usize::from(answer.is_some());
        if let Some(Received::Frame { frame, .. }) = answer {
            assert_is_written_one_way(&frame);
        }
    }
    let zeros = bytes.iter().filter(|byte| **byte == 0).count();
    assert!(answers <= zeros);
    // In step again at the next zero byte, whatever came before.
    decoder.push(0);
    assert!(!decoder.is_inside_frame());
    let good = frame_around(7, 1, &[0, 0]);
    let mut last = None;
    for byte in good {
        last = decoder.push(byte);
    }
    assert!(matches!(last, Some(Received::Frame { .. })), "{last:?}");
}

/// Bytes are compared, not values: a configuration may hold a NaN, and is refused later.
fn assert_is_written_one_way(frame: &Frame) {
    let (mut once, mut twice) = ([0; MAX_FRAME], [0; MAX_FRAME]);
    let once = postcard::to_slice(&frame.message, &mut once).unwrap();
    let bytes = frame_around(frame.boot_id, frame.sequence, once);
    assert!(bytes.len() <= MAX_FRAME);
    let mut inside = bytes[..bytes.len() - 1].to_vec();
    let again = Frame::decode(&mut inside);
    let again = again.unwrap_or_else(|error| panic!("{error:?}: {:?}, {once:02x?}", frame.message));
    assert_eq!(
        (again.boot_id, again.sequence),
        (frame.boot_id, frame.sequence)
    );
    let twice = postcard::to_slice(&again.message, &mut twice).unwrap();
    assert_eq!(once, twice, "{:?}", frame.message);
    if let Message::Event(amiro_ipf::node::Event::Particles(particles)) = &frame.message {
        for event in &particles.outcomes {
            let place = event.position();
            assert!(place.x.abs() <= 0.512 && place.y.abs() <= 0.512);
        }
    }
}
