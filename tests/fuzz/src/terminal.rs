//! A stream of frames and bytes into a board's end of a link.

use amiro_ipf::board::clock_choice::ClockSource;
use amiro_ipf::filter::{ParticleSet, Profile};
use amiro_ipf::geometry::Pose;
use amiro_ipf::link::{
    Boot, DeviceEndpoint, Encoder, Frame, MAX_FRAME, Message, WINDOW, WIRE_VERSION,
};
use amiro_ipf::model::Sample;
use amiro_ipf::node::{BATCH, Config, Event, Input, Node};

use crate::framing::{Script, frame_around};

/// Particles; a fuzzer's step is short.
const N: usize = 64;

/// Most frames that one byte may bring: a step's begin, walls, particles and end, and the
/// answer; a greeting's four are fewer.
const MOST_FRAMES: usize = 4 + N.div_ceil(BATCH);

/// The corner of what a particle's place can say: 512 mm each way.
const FARTHEST_M: f32 = 0.512 * core::f32::consts::SQRT_2;

/// Half a unit of a particle's place, and as much for rounding.
const ROUNDING_M: f32 = 2e-5;

/// Bits of an operation's first byte.
pub const RAW: u8 = 0;
/// A whole frame around a payload.
pub const FRAMED: u8 = 1;
/// What a board says that it read itself.
pub const OWN: u8 = 2;

/// Runs the operations that the bytes say; afterwards the board still steps.
pub fn check(bytes: &[u8]) {
    let mut particles = ParticleSet::<N>::new();
    let mut endpoint = DeviceEndpoint::new(Node::new(&mut particles), BOOT, 1);
    let mut script = Script(bytes);
    let mut sequence = 0_u16;
    while !script.is_over() {
        let operation = script.byte();
        let piece = script.piece();
        match operation & 3 {
            RAW => receive(&mut endpoint, piece),
            OWN => inject(&mut endpoint, piece),
            _ => {
                receive(&mut endpoint, &frame_around(0xa5, sequence, piece));
                // Now and then numbers that are out of order.
                sequence = sequence.wrapping_add(u16::from(operation >> 2) + 1);
            }
        }
        assert_particles_are_near(&endpoint);
    }
    assert_still_steps(&mut endpoint);
}

const BOOT: Boot = Boot {
    wire_version: WIRE_VERSION,
    build_id: 0,
    capacity: N as u32,
    window: WINDOW,
    baud: 0,
    clock: ClockSource::Host,
    core_hz: 0,
};

fn receive(endpoint: &mut DeviceEndpoint<'_, N>, bytes: &[u8]) {
    for byte in bytes {
        let mut frames = 0;
        endpoint.receive(*byte, &mut |frame, _| {
            frames += 1;
            assert_is_sent_whole(frame);
        });
        assert!(frames <= MOST_FRAMES, "{frames} frames for one");
    }
}

fn inject(endpoint: &mut DeviceEndpoint<'_, N>, payload: &[u8]) {
    let Ok(Message::Input(input)) = postcard::from_bytes(payload) else {
        return;
    };
    let mut frames = 0;
    endpoint.inject(&input, &mut |frame, _| {
        frames += 1;
        assert_is_sent_whole(frame);
    });
    assert!(frames <= MOST_FRAMES, "{frames} frames for one");
}

fn assert_is_sent_whole(frame: &[u8]) {
    assert!((9..=MAX_FRAME).contains(&frame.len()), "{frame:02x?}");
    assert_eq!(
        frame.iter().position(|byte| *byte == 0),
        Some(frame.len() - 1)
    );
}

fn assert_particles_are_near(endpoint: &DeviceEndpoint<'_, N>) {
    let node = endpoint.node();
    let radius_m = node.config().parameters.local_radius_m;
    for (place, steps) in node.filter().live() {
        // A particle may be drawn farther off, and departs in the next step.
        let most_m = if steps == 0 { FARTHEST_M } else { radius_m };
        assert!(
            place.norm() <= most_m + ROUNDING_M,
            "{place:?} is beyond {most_m} m after {steps} steps"
        );
    }
    assert_eq!(node.config().validate(), Ok(()));
    assert!(node.config().particles() <= N);
}

/// A new session after anything: two steps, nothing refused.
fn assert_still_steps(endpoint: &mut DeviceEndpoint<'_, N>) {
    receive(endpoint, &[0]);
    let config = Config {
        particles_per_sensor: 4,
        ..Config::amiro(Profile::Plus)
    };
    let mut encoder = Encoder::new(0xa5);
    let mut inputs = vec![Message::Hello, Input::Configure(config).into()];
    for (stamp_us, x) in [(0, 0.0), (1_000_000, 0.05)] {
        let pose = Pose::new(x, 0.0, 0.0);
        let samples = [Sample::Counts(100); 8];
        inputs.push(Input::Odometry { stamp_us, pose }.into());
        inputs.push(Input::Proximity { stamp_us, samples }.into());
    }
    let refused = endpoint.node().status().refused;
    let mut steps = 0;
    for input in inputs {
        for byte in encoder.encode(&input).to_vec() {
            endpoint.receive(byte, &mut |frame, _| {
                let mut inside = frame[..frame.len() - 1].to_vec();
                let said = Frame::decode(&mut inside).unwrap();
                let done = matches!(said.message, Message::Event(Event::StepDone(_)));
                steps += u32::from(done);
            });
        }
    }
    assert_eq!((steps, endpoint.node().status().refused), (2, refused));
}
