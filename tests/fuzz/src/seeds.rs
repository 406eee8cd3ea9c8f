//! Where fuzzing begins: the golden frames, a drive, the scenarios, a sound robot.

use amiro_ipf::filter::Profile;
use amiro_ipf::geometry::Pose;
use amiro_ipf::link::{Encoder, MAX_FRAME, Message};
use amiro_ipf::model::Sample;
use amiro_ipf::node::{Config, Input};

use crate::framing::piece_of;
use crate::{recordings, terminal};

/// The names of the targets.
pub const TARGETS: [&str; 6] = [
    "wire",
    "terminal",
    "recordings",
    "scenarios",
    "senses",
    "words",
];

const PROTOCOL: &str = include_str!("../../../docs/protocol.md");

const SCENARIOS: [&str; 5] = [
    include_str!("../../../scenarios/ssso.toml"),
    include_str!("../../../scenarios/msso.toml"),
    include_str!("../../../scenarios/msod.toml"),
    include_str!("../../../scenarios/msm_l.toml"),
    include_str!("../../../scenarios/msm_t.toml"),
];

/// A scenario that is short enough to be driven, with every kind of key.
const SMALL: &str = "name = \"small\"\nabout = \"all\"\ncell_m = 0.01\n\
    extent_m = [-1, -1, 1, 1]\nspeed_m_per_s = 0.08\nsensors_deg = [0, 90.0]\n\
    start = [0, 0, 0]\n[[drive]]\nstraight_m = 0.02\n[[drive]]\narc_deg = 20\n\
    radius_m = 0.04\n[[drive]]\nturn_deg = 5\n[[box]]\nmin = [0.2, 0.05]\n\
    max = [0.3, 0.15]\nangle_deg = 30\nreflectivity = 0.5\n[[cylinder]]\n\
    center = [0.05, 0.3]\nradius_m = 0.03\n[[opening]]\nmin = [0, 0]\nmax = [0.1, 0.1]\n\
    judged_at_m = 0.5\n";

const TEXT: &str = "PRV 0\tPRV 1\tPRV 2\tPRV 3\tPRV 4\tPRV 5\tPRV 6\tPRV 7\t\
    X [ym]\tY [ym]\tTheta [yrad]\n\
    8\t0\t0\t2185\t2436\t3\t22\t11\t100000\t-907520\t5819904\n\
    4\t2\t7\t2184\t2435\t0\t23\t6\t108000\t-907520\t5819904\n\
    6\t0\t2\t-5\t65535\t11\t17\t16\t116000\t-907520\t6282240\n";

/// Words of every kind, and a table of counts.
const WORDS: [&str; 6] = [
    "ber:1e-3+drop:1e-4x300@2s..5s+garbage:0.5x9@100B..2000B+cut:0.1",
    "lose:0.2+twice:1+swap:0.3+delay:2ms+slow:9600+off@1s",
    "real",
    "counting",
    "beta=-16.25 xi=1.0",
    "range_mm bearing_deg counts\n30 0 900\n60 10 240\n",
];

/// The seeds of a target; none for a name that is no target's.
pub fn of(target: &str) -> Vec<Vec<u8>> {
    match target {
        "wire" => golden_frames(),
        "terminal" => vec![
            link_of(terminal::FRAMED),
            link_of(terminal::OWN),
            raw_link(),
        ],
        "recordings" => recordings_of(),
        "scenarios" => SCENARIOS
            .iter()
            .chain([&SMALL])
            .map(|text| text.as_bytes().to_vec())
            .collect(),
        "senses" => vec![
            rounds(&[0x00, 0x08]),
            rounds(&[0x00, 0x09, 0x10, 0x19]),
            frames(),
        ],
        "words" => WORDS.iter().map(|text| text.as_bytes().to_vec()).collect(),
        _ => Vec::new(),
    }
}

/// The frames of the specification, each by itself, those of version 1 too.
fn golden_frames() -> Vec<Vec<u8>> {
    let byte = |digits: &[u8]| u8::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok();
    PROTOCOL
        .split("```golden")
        .skip(1)
        .flat_map(|block| {
            block
                .split("```")
                .next()
                .unwrap_or_default()
                .lines()
                .skip(1)
        })
        .filter_map(|line| line.split_once(' '))
        .map(|(_, digits)| {
            digits
                .trim()
                .as_bytes()
                .chunks(2)
                .filter_map(byte)
                .collect()
        })
        .collect()
}

/// A drive past a wall, short enough for a fuzzer.
fn inputs() -> Vec<Message> {
    let config = Config {
        particles_per_sensor: 8,
        ..Config::amiro(Profile::Plus)
    };
    let rows = (0..6_u64).flat_map(|row| {
        let stamp_us = row * 50_000;
        let pose = Pose::new(row as f32 * 0.004, 0.0, 0.01 * row as f32);
        let samples = [
            Sample::Counts(100),
            Sample::Saturated,
            Sample::Missing,
            Sample::Counts(-3),
            Sample::Counts(400),
            Sample::Counts(30),
            Sample::Counts(0),
            Sample::Counts(60_000),
        ];
        [
            Input::Odometry { stamp_us, pose },
            Input::Proximity { stamp_us, samples },
            Input::Tick { stamp_us },
        ]
    });
    let limit = Input::Limit {
        particles_per_sensor: 3,
    };
    [Message::Hello, Input::Configure(config).into()]
        .into_iter()
        .chain(rows.map(Message::Input))
        .chain([limit.into(), Message::Calibrate])
        .collect()
}

/// The inputs' payloads, each after its operation's first byte.
fn link_of(operation: u8) -> Vec<u8> {
    let mut link = Vec::new();
    for input in inputs() {
        let mut room = [0; MAX_FRAME];
        if let Ok(payload) = postcard::to_slice(&input, &mut room) {
            link.push(operation);
            link.extend(piece_of(payload));
        }
    }
    link
}

/// The inputs' frames as a host sends them.
fn stream() -> Vec<Vec<u8>> {
    let mut encoder = Encoder::new(0xa5);
    inputs()
        .iter()
        .map(|input| encoder.encode(input).to_vec())
        .collect()
}

fn raw_link() -> Vec<u8> {
    let mut link = Vec::new();
    for frame in stream() {
        link.push(terminal::RAW);
        link.extend(piece_of(&frame));
    }
    link
}

fn recordings_of() -> Vec<Vec<u8>> {
    let text = [&[recordings::AS_IT_IS], TEXT.as_bytes()].concat();
    let mut bytes = vec![recordings::AS_IT_IS, 0];
    bytes.extend(stream().concat());
    let mut golden = vec![recordings::AS_IT_IS, 0];
    golden.extend(golden_frames().concat());
    let mut pieces = vec![recordings::FRAMES];
    pieces.extend(link_of(0));
    vec![text, bytes, golden, pieces]
}

/// A round on both buses, its answers all zero or what the fuzzer makes of them, with
/// time between: each of the operations over and over.
fn rounds(operations: &[u8]) -> Vec<u8> {
    let mut rounds = vec![1, 4];
    for round in 0..3_u8 {
        for operation in operations {
            rounds.push(*operation);
            // A read register's bytes, a multiplexer's channel.
            rounds.extend([0x21, 0x05 + round % 4, 0x0a]);
        }
        rounds.extend([6, 4]);
    }
    rounds
}

/// One frame of every message that the board reads, and of some that it does not.
fn frames() -> Vec<u8> {
    let mut frames = vec![0];
    for (bits, length) in [
        (0x281_u16, 8_u8),
        (0x101, 8),
        (0x084, 8),
        (0x082, 8),
        (0x414, 0),
        (0x404, 2),
        (0x401, 2),
        (0x7ff, 15),
        (0x281, 0x18),
        (0x281, 0x28),
    ] {
        frames.push(5);
        frames.extend(bits.to_le_bytes());
        frames.push(length);
        frames.extend([0xff, 0xfe, 1, 0, 2, 0, 3, 0]);
        frames.extend([3, 0x50, 0xc3]);
    }
    frames
}
