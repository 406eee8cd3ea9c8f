//! The serial protocol through the public door: the bytes of `docs/protocol.md`.
//!
//! Names that begin with f60 to f69 are entries of the fault catalogue: the serial link.

#![expect(clippy::panic, reason = "a test that cannot go on says why")]

use std::time::{Duration, Instant};

use amiro_ipf::board::calibration::OffsetRefusal;
use amiro_ipf::board::can::CanState;
use amiro_ipf::board::clock_choice::ClockSource;
use amiro_ipf::board::health::{BusHealth, BusState, CanHealth, Health, SensorHealth};
use amiro_ipf::board::offsets::{OffsetOrigin, OffsetReport, Offsets};
use amiro_ipf::board::sensor_state::{SensorFault, SensorState};
use amiro_ipf::board::supervision::{
    CoreRegisters, FailureCause, ImageCheck, MAX_PLACE_BYTES, Mode, PostMortem, ResetCause,
    Supervision,
};
use amiro_ipf::checksum::Digest;
use amiro_ipf::filter::{
    FilterParameters, NothingDraw, Outcome, ParticleSet, Profile, SurvivalRule,
};
use amiro_ipf::geometry::{Point, Pose};
use amiro_ipf::link::{
    BoardStatus, Boot, Decoder, Encoder, FAULTS_CHUNK, Frame, FrameError, MAX_FRAME, Message,
    Received, SCENARIO_CHUNK, Status, TruthMessage, WINDOW, WIRE_VERSION,
};
use amiro_ipf::model::{
    DifferentialDrive, Gain, Photometry, Ring, Sample, SensorMask, WheelSpeeds,
};
use amiro_ipf::node::odometry::{MAX_AGE_US, MAX_GAP_US, MAX_SPEED_M_PER_S, MAX_TURN_RAD_PER_S};
use amiro_ipf::node::{
    BATCH, Config, Event, Input, InputError, Node, NodeStatus, Obstacle, ParticleEvent, Particles,
    SampleSelection, SeedSource, Source, StepBegun, StepDone, StepRule, TrackedWall, Walls,
};
use amiro_ipf::random::{Generator, uniform_below};
use proptest::prelude::*;

const DOCUMENT: &str = include_str!("../../docs/protocol.md");

const OUTCOMES: [Outcome; 4] = [
    Outcome::SurvivedPastGate,
    Outcome::SurvivedBelowGate,
    Outcome::RejectedFree,
    Outcome::RejectedUnobserved,
];

/// That the document holds every row; all that it lacks is in the message.
fn assert_stated(rows: impl IntoIterator<Item = String>) {
    let lacking: String = rows
        .into_iter()
        .filter(|row| !DOCUMENT.contains(row.as_str()))
        .map(|row| row + "\n")
        .collect();
    assert!(lacking.is_empty(), "the document lacks:\n{lacking}");
}

fn kind(message: &Message) -> &'static str {
    match message {
        Message::Hello => "Hello",
        Message::Input(Input::Configure(_)) => "Configure",
        Message::Input(Input::Proximity { .. }) => "Proximity",
        Message::Input(Input::Odometry { .. }) => "Odometry",
        Message::Input(Input::Wheels { .. }) => "Wheels",
        Message::Input(Input::Tick { .. }) => "Tick",
        Message::Calibrate => "Calibrate",
        Message::Input(Input::Limit { .. }) => "Limit",
        Message::Boot(_) => "Boot",
        Message::Event(Event::Configured(_)) => "Configured",
        Message::Event(Event::StepBegun(_)) => "StepBegun",
        Message::Event(Event::Particles(_)) => "Particles",
        Message::Event(Event::Walls(_)) => "Walls",
        Message::Event(Event::StepDone(_)) => "StepDone",
        Message::Answer { .. } => "Answer",
        Message::Status(_) => "Status",
        Message::Event(Event::OdometryReset { .. }) => "BrokeOff",
        Message::Health(_) => "Health",
        Message::PostMortem(_) => "PostMortem",
        Message::Supervision(_) => "Supervision",
        Message::Offsets(_) => "Offsets",
        Message::Truth(TruthMessage::Pose { .. }) => "Truth pose",
        Message::Truth(TruthMessage::Scenario(_)) => "Truth scenario",
        Message::Truth(TruthMessage::Seed(_)) => "Truth seed",
        Message::Truth(TruthMessage::Faults { .. }) => "Truth faults",
    }
}

/// An encoder whose next frame has the given number.
fn encoder_at(boot_id: u8, sequence: u16) -> Encoder {
    Encoder::numbered_from(boot_id, sequence)
}

fn encode(frame: &Frame) -> Vec<u8> {
    encoder_at(frame.boot_id, frame.sequence)
        .encode(&frame.message)
        .to_vec()
}

/// What a new decoder makes of a frame with its zero byte.
fn decode(bytes: &[u8]) -> Result<Frame, FrameError> {
    let mut decoder = Decoder::new();
    match decode_all(&mut decoder, bytes).as_slice() {
        [Received::Frame { frame, .. }] => Ok(frame.clone()),
        [Received::Broken(error)] => Err(*error),
        other => panic!("{} frames in {bytes:02x?}", other.len()),
    }
}

fn decode_all(decoder: &mut Decoder, bytes: &[u8]) -> Vec<Received> {
    bytes
        .iter()
        .filter_map(|&byte| decoder.push(byte))
        .collect()
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn payload_of(message: &Message) -> Vec<u8> {
    let mut room = [0; 2 * MAX_FRAME];
    postcard::to_slice(message, &mut room).unwrap().to_vec()
}

/// A frame as the document describes it, by none of the library's code: CRC bit by
/// bit, COBS piece by piece.
fn frame_by_the_document(boot_id: u8, sequence: u16, payload: &[u8]) -> Vec<u8> {
    let [low, high] = sequence.to_le_bytes();
    let mut body = [&[boot_id, low, high], payload].concat();
    let mut register = u32::MAX;
    for byte in &body {
        register ^= u32::from(*byte);
        for _ in 0..8 {
            let feedback = if register & 1 == 1 { 0xedb8_8320 } else { 0 };
            register = (register >> 1) ^ feedback;
        }
    }
    body.extend((!register).to_le_bytes());
    let mut encoded = Vec::new();
    for piece in body.split(|byte| *byte == 0) {
        encoded.push(piece.len() as u8 + 1);
        encoded.extend(piece);
    }
    encoded.push(0);
    encoded
}

fn example_batch(count: i16) -> Particles {
    Particles {
        step: 7,
        outcomes: (0..count)
            .map(|i| {
                let place = (i * 800 - 15_000, 12_000 - i * 650);
                ParticleEvent::new(place, OUTCOMES[i as usize % 4])
            })
            .collect(),
    }
}

/// Two walls in front of a robot that is 20 m left of the origin, one that is out of
/// reach, one that was left behind.
fn example_walls() -> Walls {
    let seen = [
        TrackedWall {
            id: 3,
            ends: [[240, 7512], [-160, 7514]],
            along: [9, 255],
            across: [3, 2],
            evidence: 255,
        },
        TrackedWall {
            id: 300,
            ends: [[-200, 7300], [-198, 7420]],
            along: [40, 41],
            across: [6, 12],
            evidence: 0,
        },
    ];
    Walls {
        index: 263,
        block: [0, 1],
        seen: seen.into_iter().collect(),
        out_of_reach: [1].into_iter().collect(),
        left: [0].into_iter().collect(),
    }
}

fn example_status() -> Status {
    Status {
        node: NodeStatus {
            steps: 80,
            inputs: 2345,
            refused: 1,
            last_fault: Some(InputError::StalePose),
            without: 0x81,
            obstacle: Some(Obstacle {
                range_m: 0.125,
                bearing_rad: -0.5,
            }),
            own_ticks: false,
        },
        board: BoardStatus {
            uptime_ms: 12_345,
            step_cycles: 9_000_000,
            step_cycles_max: 9_500_000,
            overruns: 0,
            dropped_frames: 3,
            broken_frames: 2,
            lost_bytes: 1,
            sent_frames: 70_000,
        },
    }
}

/// A robot with a sensor that is unplugged and one that touches a wall.
fn example_post_mortem(file: &str) -> PostMortem {
    let mut record = PostMortem::new(FailureCause::StackOverflow, 263, 12_375).at(file, 77);
    record.registers = CoreRegisters {
        pc: 0x0800_1234,
        lr: 0x0800_5679,
        psr: 0x2100_0000,
        sp: 0x2001_b3f0,
        cfsr: 0x0082,
        hfsr: 0,
        address: 0x2001_b3fc,
    };
    record
}

fn example_health() -> Health {
    let good = SensorHealth {
        state: SensorState::Good,
        age_ms: 4,
        failed: 0,
    };
    let mut sensors = [good; 8];
    sensors[1] = SensorHealth {
        state: SensorState::Missing,
        age_ms: 255,
        failed: 300,
    };
    sensors[2].state = SensorState::Faulty(SensorFault::Dazzled);
    sensors[7].state = SensorState::TooClose;
    let works = BusHealth {
        state: BusState::Working,
        failed: 3,
        recoveries: 1,
    };
    let silent = BusHealth::default();
    Health {
        sensors,
        buses: [works, silent],
        can: CanHealth {
            state: CanState::On,
            taken: 16_000,
            ignored: 5,
            overruns: 0,
            bus_offs: 1,
            unsent: 200,
        },
        seed: SeedSource::RandomUnit,
        offsets: OffsetOrigin::Stored,
    }
}

/// Offsets of a robot on a table, and how each refusal looks.
fn example_offsets() -> [OffsetReport; 2] {
    let measured = OffsetReport {
        offsets: Offsets {
            counts: [2469, 2412, 2381, 2491, 2488, 2449, 2413, 2320],
            origin: OffsetOrigin::Measured,
        },
        is_kept: true,
        refused: [None; 8],
    };
    let mut refused = OffsetReport::default();
    refused.refused[..5].copy_from_slice(&OFFSET_REFUSALS.map(Some));
    [measured, refused]
}

/// Every reason, in the order of its code on the wire.
const OFFSET_REFUSALS: [OffsetRefusal; 5] = [
    OffsetRefusal::NotDelivering,
    OffsetRefusal::Unsteady(41),
    OffsetRefusal::OutOfRange(1499),
    OffsetRefusal::AboveRing(101),
    OffsetRefusal::AboveStored(300),
];

/// One message of every kind, as in the document's list of golden frames.
fn golden_messages() -> Vec<(&'static str, u8, u16, Message)> {
    let pose = Pose::new(0.25, -0.5, 1.5);
    let [measured, refused] = example_offsets();
    let samples = [
        Sample::Counts(0),
        Sample::Counts(-3),
        Sample::Counts(110),
        Sample::Counts(65_000),
        Sample::Saturated,
        Sample::Missing,
        Sample::Counts(-70_000),
        Sample::Counts(64),
    ];
    let host = [
        ("hello", Message::Hello),
        (
            "configure-paper",
            Message::Input(Input::Configure(Config::amiro(Profile::Paper))),
        ),
        (
            "configure-plus",
            Message::Input(Input::Configure(Config::amiro(Profile::Plus))),
        ),
        (
            "proximity",
            Message::Input(Input::Proximity {
                stamp_us: 1_000_000,
                samples,
            }),
        ),
        (
            "odometry",
            Message::Input(Input::Odometry {
                stamp_us: 1_008_000,
                pose,
            }),
        ),
        (
            "wheels",
            Message::Input(Input::Wheels {
                stamp_us: 300,
                speeds: WheelSpeeds {
                    left_m_per_s: 0.08,
                    right_m_per_s: -0.08,
                },
            }),
        ),
        ("tick", Message::Input(Input::Tick { stamp_us: 125_000 })),
    ];
    let truth = [
        (
            "truth-pose",
            TruthMessage::Pose {
                stamp_us: 1_000_000,
                pose,
            },
        ),
        (
            "truth-scenario",
            TruthMessage::Scenario(b"[robot]\n".iter().copied().collect()),
        ),
        ("truth-seed", TruthMessage::Seed(42)),
    ]
    .map(|(name, truth)| (name, Message::Truth(truth)));
    let limit = Message::Input(Input::Limit {
        particles_per_sensor: 750,
    });
    let host_since_2 = [("calibrate", Message::Calibrate), ("limit", limit)];
    let truth_since_2 = TruthMessage::Faults {
        seed: 7,
        text: b"s3=off@5s".iter().copied().collect(),
    };
    let truth_since_2 = [("truth-faults", Message::Truth(truth_since_2))];
    let wall = Message::Input(Input::Configure(Config::amiro(Profile::Wall)));
    let host_since_4 = [("configure-wall", wall)];
    let board = [
        (
            "boot",
            Message::Boot(Boot {
                wire_version: 4,
                build_id: 0x0123_4567_89ab_cdef,
                capacity: 8000,
                window: 8,
                baud: 2_000_000,
                clock: ClockSource::CrystalPll,
                core_hz: 168_000_000,
            }),
        ),
        (
            "configured",
            Message::Event(Event::Configured(Config {
                step_rule: StepRule::PerTick { own_clock: true },
                ..Config::amiro(Profile::Paper)
            })),
        ),
        (
            "step-begun",
            Message::Event(Event::StepBegun(StepBegun {
                index: 263,
                stamp_us: 1_000_000,
                pose,
                samples,
            })),
        ),
        (
            "particles-1",
            Message::Event(Event::Particles(example_batch(1))),
        ),
        (
            "particles-38",
            Message::Event(Event::Particles(example_batch(38))),
        ),
        (
            "step-done",
            Message::Event(Event::StepDone(StepDone {
                index: 263,
                digest: 0xdead_beef,
                past_gate: 812,
                below_gate: 5000,
                free: 2000,
                unobserved: 100,
                departed: 88,
                degenerate: false,
            })),
        ),
        (
            "answer",
            Message::Answer {
                input: 2,
                refused: None,
            },
        ),
        (
            "answer-refused",
            Message::Answer {
                input: 300,
                refused: Some(InputError::StampBackward),
            },
        ),
        ("status", Message::Status(example_status())),
        ("status-first", Message::Status(Status::default())),
        (
            "configured-board",
            Message::Event(Event::Configured(Config {
                choice: SampleSelection::Median,
                source: Source::Board,
                ..Config::amiro(Profile::Plus)
            })),
        ),
        (
            "broke-off",
            Message::Event(Event::OdometryReset {
                stamp_us: 3_000_000,
            }),
        ),
        ("health", Message::Health(example_health())),
        ("health-first", Message::Health(Health::default())),
        ("offsets", Message::Offsets(measured)),
        ("offsets-refused", Message::Offsets(refused)),
        (
            "answer-not-the-source",
            Message::Answer {
                input: 5,
                refused: Some(InputError::NotTheSource),
            },
        ),
        (
            "post-mortem",
            Message::PostMortem(example_post_mortem("src/node.rs")),
        ),
        (
            "supervision",
            Message::Supervision(Supervision {
                mode: Mode::SafeForImage,
                reset: ResetCause::Watchdog,
                image: ImageCheck::Damaged,
                is_under_loader: true,
                stack_unused: 12_000,
            }),
        ),
        ("walls", Message::Event(Event::Walls(example_walls()))),
        ("walls-none", Message::Event(Event::Walls(Walls::default()))),
    ];
    let from = |boot_id, first: u16| {
        move |(place, (name, message))| (name, boot_id, first + place as u16, message)
    };
    let from_host = host.into_iter().chain(truth).chain(host_since_2);
    let from_host = from_host.chain(truth_since_2).chain(host_since_4);
    let from_host = from_host.enumerate().map(from(0xa5, 0));
    let from_board = board.into_iter().enumerate().map(from(3, 254));
    // A session that does not begin at 0.
    let hello = Message::Hello;
    let answer = Message::Answer {
        input: 0x9c41,
        refused: None,
    };
    let ratios = [1.08, 0.92, 1.0, 1.1, 0.95, 0.25, 4.0, 0.88];
    let gains = Message::Input(Input::Configure(Config {
        gains: ratios.map(|ratio| Gain::of(ratio).unwrap()),
        ..Config::amiro(Profile::Plus)
    }));
    let session = [
        ("hello-session", 0xa5, 0x9c41, hello),
        ("answer-session", 3, 300, answer),
        ("configure-gains", 0xa5, 0x9c42, gains),
    ];
    from_host.chain(from_board).chain(session).collect()
}

/// The golden frames in a block of the document: name and bytes.
fn golden_bytes(block: &str) -> Vec<(&'static str, Vec<u8>)> {
    let (_, rest) = DOCUMENT.split_once(&format!("```{block}\n")).unwrap();
    let (block, _) = rest.split_once("```").unwrap();
    let byte = |place: &str| u8::from_str_radix(place, 16).unwrap();
    block
        .lines()
        .map(|line| {
            let (name, hex) = line.split_once(' ').unwrap();
            let digits: Vec<char> = hex.trim().chars().collect();
            let bytes = digits.chunks(2).map(|pair| byte(&String::from_iter(pair)));
            (name, bytes.collect())
        })
        .collect()
}

#[test]
fn golden_frames_decode_to_their_messages_and_encode_to_their_bytes() {
    let messages = golden_messages();
    let bytes = golden_bytes("golden");
    let expected: String = messages
        .iter()
        .map(|(name, boot_id, sequence, message)| {
            let frame = encoder_at(*boot_id, *sequence).encode(message).to_vec();
            format!("{name} {}\n", hex(&frame))
        })
        .collect();
    assert_eq!(
        bytes.len(),
        messages.len(),
        "the document lacks:\n{expected}"
    );
    for ((name, boot_id, sequence, message), (listed, bytes)) in messages.into_iter().zip(bytes) {
        assert_eq!(name, listed);
        let frame = Frame {
            boot_id,
            sequence,
            message,
        };
        assert_eq!(decode(&bytes), Ok(frame.clone()), "{name}");
        assert_eq!(hex(&encode(&frame)), hex(&bytes), "{name}");
    }
}

#[test]
fn f69_frames_of_older_versions_that_changed_are_refused_and_their_boot_can_be_read() {
    let changed: [(u8, &str, &[&str]); 3] = [
        (
            1,
            "golden-1",
            &["configure-paper", "configure-plus", "boot", "configured"],
        ),
        (2, "golden-2", &["boot", "status", "status-first"]),
        (
            3,
            "golden-3",
            &[
                "configure-paper",
                "configure-plus",
                "boot",
                "configured",
                "configured-board",
            ],
        ),
    ];
    for (version, block, names) in changed {
        let old = golden_bytes(block);
        assert!(old.iter().map(|(name, _)| name).eq(names), "{block}");
        for (name, bytes) in old {
            // Whole frames all of them: it is the message that is another.
            let decoded = decode(&bytes);
            if name != "boot" {
                assert_eq!(decoded, Err(FrameError::NotAMessage), "{name}");
                continue;
            }
            let Ok(Frame {
                message: Message::Boot(boot),
                ..
            }) = decoded
            else {
                panic!("{decoded:?}");
            };
            assert_eq!((boot.wire_version, boot.capacity), (version, 8000));
        }
    }
}

#[test]
fn frames_are_what_an_encoder_by_the_document_makes() {
    for (name, boot_id, sequence, message) in golden_messages() {
        let payload = payload_of(&message);
        assert_eq!(
            hex(&frame_by_the_document(boot_id, sequence, &payload)),
            hex(encoder_at(boot_id, sequence).encode(&message)),
            "{name}"
        );
    }
}

#[test]
fn particle_event_of_the_document_has_its_three_bytes() {
    // +123.5 mm is 1024 + 247, -40.0 mm is 1024 - 80.
    let bits = 1 | 1271_u32 << 2 | 944 << 13;
    let [low, middle, high, _] = bits.to_le_bytes();
    assert_stated([format!("`{low:02x} {middle:02x} {high:02x}`")]);
    // 7904 units of 1/64 mm are 123.5 mm.
    let event = ParticleEvent::new((7904, -2560), Outcome::SurvivedBelowGate);
    let batch = Particles {
        step: 0,
        outcomes: [event].into_iter().collect(),
    };
    let payload = payload_of(&Message::Event(Event::Particles(batch)));
    assert_eq!(payload, [1, 3, 0, 3, low, middle, high]);
    // Exact in half millimetres; in metres to single precision.
    let error = event.position() - Point::new(0.1235, -0.04);
    assert!(error.norm() < 1e-7, "{error:?}");
}

#[test]
fn walls_of_the_document_have_their_bytes_and_places() {
    let walls = example_walls();
    let payload = payload_of(&Message::Event(Event::Walls(walls.clone())));
    let (head, rest) = payload.split_at(7);
    // 263 is 2 x 128 + 7; one block is zigzag 2; two walls have 30 bytes.
    assert_eq!(head, [1, 12, 0x87, 0x02, 0, 2, 30]);
    let (first, rest) = rest.split_at(15);
    assert_stated([hex_spaced(first)]);
    assert_eq!(rest[15..], [1, 1, 1, 0]);
    // x 240 and y 32768 + 7512 half millimetres.
    assert_eq!(walls.ends_half_mm(&walls.seen[0])[0], [240, 40_280]);
    assert_stated(["(0.120 m, 20.140 m)".to_owned()]);
}

fn hex_spaced(bytes: &[u8]) -> String {
    let bytes: Vec<String> = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    bytes.join(" ")
}

#[test]
fn walls_alone_fit_a_line_of_9600_baud_at_eight_hertz() {
    let longest = longest_frame("Walls");
    assert!(longest * 8 * 10 <= 9600, "{longest} bytes");
    let six = Walls {
        index: 263,
        block: [0, 1],
        seen: (0..6).map(wall_of).collect(),
        ..Walls::default()
    };
    let length = |walls| frame_length(&Message::Event(Event::Walls(walls)));
    assert_stated([
        format!("without a segment {} bytes", length(Walls::default())),
        format!("six within reach {} bytes", length(six)),
        format!("{} baud", longest * 80),
    ]);
}

/// A wall of a number.
fn wall_of(id: u16) -> TrackedWall {
    TrackedWall {
        id,
        ends: [[100, 200], [300, 400]],
        along: [8, 9],
        across: [2, 3],
        evidence: 77,
    }
}

#[test]
fn every_constant_of_the_document_is_the_code_s() {
    let particles = frame_by_the_document(0, 1, &[1; 4 + 3 * BATCH]).len();
    let batches = Config::default().particles().div_ceil(BATCH);
    assert_stated([
        format!("| Version of the messages | {WIRE_VERSION} |"),
        format!("| Longest frame, its zero byte included | {MAX_FRAME} bytes |"),
        format!("| Window: inputs ahead of their answers | {WINDOW} |"),
        format!("| Outcomes in one particle message | at most {BATCH} |"),
        format!("| Bytes of a scenario in one truth message | at most {SCENARIO_CHUNK} |"),
        format!("| Bytes of the faults' text in one truth message | at most {FAULTS_CHUNK} |"),
        format!("| Frame of {BATCH} outcomes | {particles} bytes |"),
        format!("| Frames of a step of 8000 outcomes | {batches} |"),
        "0xcbf43926".to_owned(),
        "255 frames".to_owned(),
        "24 places".to_owned(),
    ]);
    assert_eq!(amiro_ipf::checksum::CRC.checksum(b"123456789"), 0xcbf4_3926);
    // The board's line is the firmware's alone: its source is all a host can ask.
    let board = include_str!("../../src/bin/firmware/hal/mod.rs");
    assert!(board.contains("const FAST: u32 = 2_000_000;"));
    assert!(board.contains("const SLOW: u32 = 115_200;"));
    let budget = include_str!("../../src/board/budget.rs");
    assert!(budget.contains("const SEND_QUEUE: usize = 256;"));
    assert!(budget.contains("const RESERVE: usize = 24;"));
}

/// Bytes of an event's frame with a number of two bytes, neither of them zero.
fn frame_length(message: &Message) -> usize {
    encoder_at(1, 257).encode(message).len()
}

/// Bits on the line in a second of steps of 8000 outcomes, 8 of them, with a status and
/// a health beside each; ten bits a byte.
fn injected_baud() -> usize {
    let batch = |count| Message::Event(Event::Particles(example_batch(count)));
    let full = frame_length(&batch(BATCH as i16));
    let rest = frame_length(&batch((8000 % BATCH) as i16));
    let others: usize = golden_messages()
        .iter()
        .filter(|(name, ..)| ["step-begun", "step-done", "status", "health"].contains(name))
        .map(|(.., message)| frame_length(message))
        .sum();
    (8000 / BATCH * full + rest + others) * 8 * 10
}

/// Bits in a second of a board's own readings and poses, an hour after its reset, with
/// something in front of two sensors.
fn own_inputs_baud() -> usize {
    let stamp_us = 3_600_000_000;
    let mut samples = [Sample::Counts(3); 8];
    samples[1] = Sample::Counts(110);
    samples[2] = Sample::Counts(100);
    let pose = Pose::new(0.256, -0.128, 0.784);
    let reading = Message::Input(Input::Proximity { stamp_us, samples });
    let pose = Message::Input(Input::Odometry { stamp_us, pose });
    (125 * frame_length(&reading) + 16 * frame_length(&pose)) * 10
}

#[test]
fn full_detail_at_eight_hertz_needs_the_rate_of_the_document() {
    let full = frame_length(&Message::Event(Event::Particles(example_batch(38)))) as f64;
    let injected = injected_baud() as f64;
    let live = injected + own_inputs_baud() as f64;
    // Of 211 particle frames a step, those that 2 Mbaud have no room for.
    let one_in = |baud: f64| 211.0 * 8.0 * 10.0 * full / (baud - 2e6);
    let mbaud = |baud: f64| format!("{:.2} Mbaud", baud * 1e-6);
    let step = injected / 80.0 * 1e-3;
    assert_stated([
        format!("is {step:.1} kB"),
        format!("at 8 Hz need {}", mbaud(injected)),
        format!("a live board needs {}", mbaud(live)),
        format!("one particle frame in {:.0} and", one_in(live)),
    ]);
}

#[test]
fn every_fault_of_the_document_has_its_code_and_words() {
    for (code, fault) in InputError::ALL.into_iter().enumerate() {
        assert_stated([format!("| {code} | `{fault:?}` | {fault} |")]);
        let answer = Message::Answer {
            input: 0,
            refused: Some(fault),
        };
        assert_eq!(payload_of(&answer), [1, 5, 0, 1, code as u8], "{fault:?}");
    }
}

/// A configuration with one parameter changed.
fn with(change: impl FnOnce(&mut Config)) -> Config {
    let mut config = Config::default();
    change(&mut config);
    config
}

#[test]
fn every_range_of_the_document_is_the_one_that_is_checked() {
    let illegal = [
        with(|c| c.particles_per_sensor = 0),
        with(|c| c.sensors = SensorMask::NONE),
        with(|c| c.step_rule = StepRule::PerDistance { step_m: 1.0 }),
        with(|c| c.parameters.gate = 201),
        with(|c| c.parameters.model_error_m = 0.2),
        with(|c| c.parameters.wheel_noise = 2.0),
        with(|c| c.parameters.local_radius_m = 0.6),
        with(|c| c.parameters.side_margin = 11.0),
        with(|c| c.parameters.veto = 1.1),
        with(|c| c.photometry.alpha_counts_m2 = 0.0),
        with(|c| c.photometry.beta_counts = f32::NAN),
        with(|c| c.photometry.delta_m2 = 1.0),
        with(|c| c.photometry.xi = 2.0),
        with(|c| c.photometry.sigma_counts = 0.0),
        with(|c| c.photometry.x_max_m = 1.0),
        with(|c| c.photometry.theta_max_rad = 2.0),
        with(|c| c.ring.radius_m = -1.0),
        with(|c| c.ring.axis_rad[7] = 8.0),
        with(|c| c.drive.track_m = 0.0),
        with(|c| c.gains[7] = Gain::from_code(4095)),
    ];
    for config in illegal {
        let error = config.validate().unwrap_err();
        let name = error.parameter.trim_start_matches("ring ");
        let is_stated = DOCUMENT
            .lines()
            .any(|line| line.contains(&format!("`{name}`")) && line.contains(error.range));
        assert!(is_stated, "{error}");
    }
}

#[test]
fn every_default_of_the_document_is_the_profiles() {
    let [paper, plus] = [Profile::Paper, Profile::Plus].map(Config::amiro);
    let row = |name: &str, of: fn(&Config) -> String| {
        format!("| `{name}` | {} | {} |", of(&paper), of(&plus))
    };
    assert_stated([
        row("seed", |c| c.seed.to_string()),
        row("particles_per_sensor", |c| {
            c.particles_per_sensor.to_string()
        }),
        row("sensors", |c| format!("{:#04x}", c.sensors.0)),
        row("step_m", |c| match c.step_rule {
            StepRule::PerDistance { step_m } => step_m.to_string(),
            StepRule::PerTick { .. } => "none".to_owned(),
        }),
        row("survival", |c| format!("{:?}", c.parameters.survival)),
        row("gate", |c| c.parameters.gate.to_string()),
        row("model_error_m", |c| c.parameters.model_error_m.to_string()),
        row("wheel_noise", |c| c.parameters.wheel_noise.to_string()),
        row("local_radius_m", |c| {
            c.parameters.local_radius_m.to_string()
        }),
        row("side_test", |c| c.parameters.side_test.to_string()),
        row("side_margin", |c| c.parameters.side_margin.to_string()),
        row("veto", |c| c.parameters.veto.to_string()),
        row("nothing_draw", |c| {
            format!("{:?}", c.parameters.nothing_draw)
        }),
        row("alpha_counts_m2", |c| {
            c.photometry.alpha_counts_m2.to_string()
        }),
        row("beta_counts", |c| c.photometry.beta_counts.to_string()),
        row("delta_m2", |c| c.photometry.delta_m2.to_string()),
        row("xi", |c| c.photometry.xi.to_string()),
        row("sigma_counts", |c| c.photometry.sigma_counts.to_string()),
        row("x_max_m", |c| c.photometry.x_max_m.to_string()),
        row("theta_max_rad", |c| c.photometry.theta_max_rad.to_string()),
        row("radius_m", |c| c.ring.radius_m.to_string()),
        row("track_m", |c| c.drive.track_m.to_string()),
        row("choice", |c| format!("{:?}", c.choice)),
        row("source", |c| format!("{:?}", c.source)),
        row("gains", |c| {
            let all_one = c.gains == [Gain::ONE; 8];
            if all_one { "1 each" } else { "others" }.to_owned()
        }),
    ]);
}

#[test]
fn every_limit_of_the_document_is_the_one_that_is_kept() {
    assert_stated([
        format!("{MAX_SPEED_M_PER_S:.1} m/s"),
        format!("{MAX_TURN_RAD_PER_S} rad/s"),
        format!("more than {} s", MAX_GAP_US / 1_000_000),
        format!("more than {} ms after the last pose", MAX_AGE_US / 1_000),
        format!(
            "more than {} ms older",
            amiro_ipf::node::MAX_SAMPLE_AGE_US / 1_000
        ),
        format!("the last {} counts", amiro_ipf::node::WINDOW),
    ]);
}

/// A row of the document's lists of words: number and name.
fn word(number: usize, name: &impl std::fmt::Debug) -> String {
    let name = format!("{name:?}");
    let (name, _) = name.split_once('(').unwrap_or((&name, ""));
    format!("{number} `{name}`")
}

const CAUSES: [FailureCause; 5] = [
    FailureCause::Panic,
    FailureCause::Fault,
    FailureCause::StackOverflow,
    FailureCause::Watchdog,
    FailureCause::Clock,
];
const MODES: [Mode; 4] = [
    Mode::Normal,
    Mode::SafeAfterDeaths,
    Mode::SafeForImage,
    Mode::ShuttingDown,
];
const RESETS: [ResetCause; 5] = [
    ResetCause::Unknown,
    ResetCause::Power,
    ResetCause::Pin,
    ResetCause::Software,
    ResetCause::Watchdog,
];
const IMAGE_CHECKS: [ImageCheck; 3] = [ImageCheck::Unmarked, ImageCheck::Good, ImageCheck::Damaged];

#[test]
fn every_word_of_supervision_has_the_document_s_number() {
    for (number, cause) in CAUSES.into_iter().enumerate() {
        let record = PostMortem::new(cause, 0, 0);
        let payload = payload_of(&Message::PostMortem(record));
        assert_eq!(payload[..3], [1, 10, number as u8], "{cause:?}");
    }
    for (number, mode) in MODES.into_iter().enumerate() {
        let supervision = Supervision {
            mode,
            ..Supervision::default()
        };
        let payload = payload_of(&Message::Supervision(supervision));
        assert_eq!(payload[..3], [1, 11, number as u8], "{mode:?}");
    }
    let causes = (0..).zip(&CAUSES).map(|(n, c)| word(n, c));
    let modes = (0..).zip(&MODES).map(|(n, m)| word(n, m));
    let resets = (0..).zip(&RESETS).map(|(n, r)| word(n, r));
    let checks = (0..).zip(&IMAGE_CHECKS).map(|(n, c)| word(n, c));
    assert_stated(causes.chain(modes).chain(resets).chain(checks));
}

#[test]
fn every_word_of_health_and_offsets_has_the_document_s_number() {
    for (number, state) in SENSOR_STATES.into_iter().enumerate() {
        let encoded = payload_of(&Message::Health(Health {
            sensors: [SensorHealth {
                state,
                ..SensorHealth::default()
            }; 8],
            ..Health::default()
        }));
        let expected = match state {
            SensorState::Faulty(fault) => vec![6, fault as u8],
            _ => vec![number as u8],
        };
        assert!(encoded[2..].starts_with(&expected), "{state:?}");
    }
    let states = (0..).zip(&SENSOR_STATES[..7]).map(|(n, s)| word(n, s));
    let faults = (0..).zip(&SENSOR_FAULTS).map(|(n, f)| word(n, f));
    let buses = (0..).zip(&BUS_STATES).map(|(n, b)| word(n, b));
    let cans = (0..).zip(&CAN_STATES).map(|(n, c)| word(n, c));
    let seeds = (0..).zip(&SEED_SOURCES).map(|(n, s)| word(n, s));
    let origins = (0..).zip(&OFFSET_ORIGINS).map(|(n, o)| word(n, o));
    let refusals = (0..).zip(&OFFSET_REFUSALS).map(|(n, r)| word(n, r));
    let all = states.chain(faults).chain(buses).chain(cans);
    assert_stated(all.chain(seeds).chain(origins).chain(refusals));
    for (number, refusal) in (0..).zip(OFFSET_REFUSALS) {
        let [_, mut report] = example_offsets();
        report.refused = [Some(refusal); 8];
        let encoded = payload_of(&Message::Offsets(report));
        // Eight counts of two bytes, origin, kept, then the reasons.
        assert_eq!(encoded[2 + 16 + 2..][..2], [1, number], "{refusal:?}");
    }
}

const SENSOR_FAULTS: [SensorFault; 3] = [
    SensorFault::WrongIdentity,
    SensorFault::Garbage,
    SensorFault::Dazzled,
];

const SENSOR_STATES: [SensorState; 9] = [
    SensorState::Missing,
    SensorState::NoData,
    SensorState::TooClose,
    SensorState::Nothing,
    SensorState::Good,
    SensorState::Stale,
    SensorState::Faulty(SensorFault::WrongIdentity),
    SensorState::Faulty(SensorFault::Garbage),
    SensorState::Faulty(SensorFault::Dazzled),
];

const BUS_STATES: [BusState; 4] = [
    BusState::Silent,
    BusState::Working,
    BusState::Failing,
    BusState::HeldLow,
];

const CAN_STATES: [CanState; 4] = [
    CanState::Absent,
    CanState::Joining,
    CanState::On,
    CanState::BusOff,
];

const SEED_SOURCES: [SeedSource; 3] = [
    SeedSource::Configured,
    SeedSource::RandomUnit,
    SeedSource::UniqueNumber,
];

const OFFSET_ORIGINS: [OffsetOrigin; 3] = [
    OffsetOrigin::Defaults,
    OffsetOrigin::Stored,
    OffsetOrigin::Measured,
];

#[test]
fn digest_is_the_document_s() {
    fn mixed(h: u32, word: u32) -> u32 {
        (h.rotate_left(5) ^ word).wrapping_mul(2_654_435_761)
    }
    // The document's example: two slots, one at (+1 mm, -1 mm) in its first step, one dead.
    let words = [64 | 0xffc0 << 16, 1, 0, 0];
    let by_hand = words.into_iter().fold(0, mixed);
    let mut digest = Digest::default();
    words.into_iter().for_each(|word| digest.update(word));
    assert_eq!(digest.value(), by_hand);
    assert_stated([format!("{by_hand:#010x}")]);
    // A node's, from the particles that it shows: all of them live after a step.
    let mut particles = ParticleSet::<80>::new();
    let mut node = Node::new(&mut particles);
    let mut said = None;
    for input in drive_past_a_wall() {
        node.handle(&input, &mut |event| {
            if let Event::StepDone(done) = event {
                said = Some(done.digest);
            }
        })
        .unwrap();
    }
    assert_eq!(node.filter().live().count(), 80);
    let units = |metres: f32| u32::from((metres * 64_000.0) as i16 as u16);
    let shown = node.filter().live().fold(0, |h, (place, age)| {
        let word = units(place.x) | units(place.y) << 16;
        mixed(mixed(h, word), u32::from(age) + 1)
    });
    assert_eq!(said, Some(shown));
}

fn drive_past_a_wall() -> Vec<Input> {
    let mut samples = [Sample::Counts(3); 8];
    samples[1] = Sample::Counts(110);
    samples[2] = Sample::Counts(100);
    (0..=60_u64)
        .flat_map(|millimetre| {
            let stamp_us = millimetre * 12_500;
            let pose = Pose::new(millimetre as f32 * 1e-3, 0.0, 0.0);
            [
                Input::Odometry { stamp_us, pose },
                Input::Proximity { stamp_us, samples },
            ]
        })
        .collect()
}

/// Of every kind the message whose every number takes the most bytes.
fn longest_messages() -> Vec<Message> {
    let pose = Pose::new(f32::MAX, f32::MIN, 3.0);
    let stamp_us = u64::MAX;
    let samples = [Sample::Counts(i32::MIN); 8];
    let config = Config {
        seed: u64::MAX,
        particles_per_sensor: u16::MAX,
        choice: SampleSelection::Median,
        source: Source::Board,
        gains: [Gain::from_code(u16::MAX); 8],
        ..Config::amiro(Profile::Plus)
    };
    let node = NodeStatus {
        steps: u32::MAX,
        inputs: u32::MAX,
        refused: u32::MAX,
        last_fault: Some(InputError::NotTheSource),
        without: 0xff,
        obstacle: Some(Obstacle {
            range_m: 0.3,
            bearing_rad: 3.0,
        }),
        own_ticks: true,
    };
    let board = BoardStatus {
        uptime_ms: u64::MAX,
        step_cycles: u32::MAX,
        step_cycles_max: u32::MAX,
        overruns: u32::MAX,
        dropped_frames: u32::MAX,
        broken_frames: u32::MAX,
        lost_bytes: u32::MAX,
        sent_frames: u32::MAX,
    };
    let inputs = [
        Message::Hello,
        Message::Input(Input::Configure(config)),
        Message::Input(Input::Proximity { stamp_us, samples }),
        Message::Input(Input::Odometry { stamp_us, pose }),
        Message::Input(Input::Wheels {
            stamp_us,
            speeds: WheelSpeeds::default(),
        }),
        Message::Input(Input::Tick { stamp_us }),
        Message::Calibrate,
        Message::Input(Input::Limit {
            particles_per_sensor: u16::MAX,
        }),
    ];
    let events = [
        Message::Boot(Boot {
            wire_version: u8::MAX,
            build_id: u64::MAX,
            capacity: u32::MAX,
            window: u8::MAX,
            baud: u32::MAX,
            clock: ClockSource::Unknown,
            core_hz: u32::MAX,
        }),
        Message::Event(Event::Configured(config)),
        Message::Event(Event::StepBegun(StepBegun {
            index: u32::MAX,
            stamp_us,
            pose,
            samples,
        })),
        Message::Event(Event::Particles(example_batch(BATCH as i16))),
        Message::Event(Event::Walls(Walls {
            index: u32::MAX,
            block: [i16::MIN; 2],
            seen: (0xfff0..0xfff6).map(wall_of).collect(),
            out_of_reach: Walls::default().out_of_reach,
            left: [u16::MAX].into_iter().collect(),
        })),
        Message::Event(Event::StepDone(StepDone {
            index: u32::MAX,
            digest: u32::MAX,
            past_gate: u16::MAX,
            below_gate: u16::MAX,
            free: u16::MAX,
            unobserved: u16::MAX,
            departed: u16::MAX,
            degenerate: true,
        })),
        Message::Answer {
            input: u16::MAX,
            refused: Some(InputError::NotTheSource),
        },
        Message::Status(Status { node, board }),
        Message::Event(Event::OdometryReset { stamp_us }),
        Message::Health(longest_health()),
        Message::PostMortem(PostMortem {
            step: u32::MAX,
            uptime_ms: u32::MAX,
            line: u32::MAX,
            registers: CoreRegisters {
                pc: u32::MAX,
                lr: u32::MAX,
                psr: u32::MAX,
                sp: u32::MAX,
                cfsr: u32::MAX,
                hfsr: u32::MAX,
                address: u32::MAX,
            },
            ..example_post_mortem(&"x".repeat(MAX_PLACE_BYTES))
        }),
        Message::Supervision(Supervision {
            stack_unused: u32::MAX,
            ..Supervision::default()
        }),
        Message::Offsets(OffsetReport {
            offsets: Offsets {
                counts: [u16::MAX; 8],
                origin: OffsetOrigin::Measured,
            },
            is_kept: true,
            refused: [Some(OffsetRefusal::AboveStored(u16::MAX)); 8],
        }),
    ];
    let truths = [
        TruthMessage::Pose { stamp_us, pose },
        TruthMessage::Scenario([0xff; SCENARIO_CHUNK].into_iter().collect()),
        TruthMessage::Seed(u64::MAX),
        TruthMessage::Faults {
            seed: u64::MAX,
            text: [0xff; FAULTS_CHUNK].into_iter().collect(),
        },
    ];
    let inputs = inputs.into_iter();
    inputs
        .chain(events)
        .chain(truths.map(Message::Truth))
        .collect()
}

fn longest_health() -> Health {
    Health {
        sensors: [SensorHealth {
            state: SensorState::Faulty(SensorFault::Dazzled),
            age_ms: u8::MAX,
            failed: u16::MAX,
        }; 8],
        buses: [BusHealth {
            state: BusState::HeldLow,
            failed: u16::MAX,
            recoveries: u16::MAX,
        }; 2],
        can: CanHealth {
            state: CanState::BusOff,
            taken: u32::MAX,
            ignored: u16::MAX,
            overruns: u16::MAX,
            bus_offs: u16::MAX,
            unsent: u16::MAX,
        },
        seed: SeedSource::UniqueNumber,
        offsets: OffsetOrigin::Measured,
    }
}

fn longest_frame(kind_of: &str) -> usize {
    longest_messages()
        .iter()
        .filter(|message| kind(message) == kind_of)
        .map(|message| frame_by_the_document(0xff, 0xffff, &payload_of(message)).len())
        .max()
        .unwrap()
}

#[test]
fn every_message_at_its_longest_fits_a_frame_and_is_stated() {
    assert_stated(longest_messages().iter().map(|message| {
        let length = longest_frame(kind(message));
        format!("| {} | {length} |", kind(message))
    }));
    for message in longest_messages() {
        let length = longest_frame(kind(&message));
        assert!(length <= MAX_FRAME, "{message:?}: {length} bytes");
        let frame = Frame {
            boot_id: 0xff,
            sequence: 0xffff,
            message,
        };
        let bytes = encode(&frame);
        assert_eq!(bytes.len(), length, "{frame:?}");
        assert_eq!(decode(&bytes), Ok(frame));
    }
}

fn any_float() -> impl Strategy<Value = f32> {
    use prop::num::f32::{INFINITE, NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
    POSITIVE | NEGATIVE | NORMAL | SUBNORMAL | ZERO | INFINITE
}

fn any_pose() -> impl Strategy<Value = Pose> {
    // Headings that are already wrapped; others do not survive decoding.
    (any_float(), any_float(), -3.1_f32..3.1).prop_map(|(x, y, turn)| Pose::new(x, y, turn))
}

fn any_samples() -> impl Strategy<Value = [Sample; 8]> {
    prop::array::uniform8(prop_oneof![
        3 => any::<i32>().prop_map(Sample::Counts),
        3 => (-100..1000).prop_map(Sample::Counts),
        1 => Just(Sample::Saturated),
        1 => Just(Sample::Missing),
    ])
}

fn any_config() -> impl Strategy<Value = Config> {
    let step_rule = prop_oneof![
        any_float().prop_map(|step_m| StepRule::PerDistance { step_m }),
        any::<bool>().prop_map(|own_clock| StepRule::PerTick { own_clock }),
    ];
    let choices = (any::<bool>(), any::<bool>(), any::<bool>(), any::<u8>());
    let choice = prop::sample::select(&[SampleSelection::Newest, SampleSelection::Median][..]);
    let source = prop::sample::select(&[Source::Link, Source::Board][..]);
    let floats = prop::collection::vec(any_float(), 22);
    let numbers = any::<(u64, u16, u8)>();
    let codes = any::<[u16; 8]>();
    (numbers, step_rule, choices, (choice, source, codes), floats).prop_map(
        |(
            (seed, particles_per_sensor, mask),
            step_rule,
            (survival, draw, side_test, gate),
            (choice, source, codes),
            f,
        )| {
            let parameters = FilterParameters {
                survival: if survival {
                    SurvivalRule::Systematic
                } else {
                    SurvivalRule::Bernoulli
                },
                gate,
                model_error_m: f[0],
                wheel_noise: f[1],
                local_radius_m: f[2],
                side_test,
                side_margin: f[3],
                veto: f[4],
                nothing_draw: if draw {
                    NothingDraw::AtLimit
                } else {
                    NothingDraw::OverLobe
                },
            };
            let photometry = Photometry {
                alpha_counts_m2: f[5],
                beta_counts: f[6],
                delta_m2: f[7],
                xi: f[8],
                sigma_counts: f[9],
                x_max_m: f[10],
                theta_max_rad: f[11],
            };
            let ring = Ring {
                radius_m: f[12],
                axis_rad: std::array::from_fn(|sensor| f[13 + sensor]),
            };
            Config {
                seed,
                particles_per_sensor,
                sensors: SensorMask(mask),
                step_rule,
                parameters,
                photometry,
                ring,
                drive: DifferentialDrive { track_m: f[21] },
                choice,
                source,
                gains: std::array::from_fn(|sensor| Gain::from_code(codes[sensor])),
            }
        },
    )
}

fn any_message_to_a_board() -> impl Strategy<Value = Message> {
    prop_oneof![
        Just(Message::Hello),
        any_config().prop_map(|config| Message::Input(Input::Configure(config))),
        (any::<u64>(), any_samples())
            .prop_map(|(stamp_us, samples)| Message::Input(Input::Proximity { stamp_us, samples })),
        (any::<u64>(), any_pose())
            .prop_map(|(stamp_us, pose)| Message::Input(Input::Odometry { stamp_us, pose })),
        (any::<u64>(), any_float(), any_float()).prop_map(|(stamp_us, left, right)| {
            let speeds = WheelSpeeds {
                left_m_per_s: left,
                right_m_per_s: right,
            };
            Message::Input(Input::Wheels { stamp_us, speeds })
        }),
        any::<u64>().prop_map(|stamp_us| Message::Input(Input::Tick { stamp_us })),
        Just(Message::Calibrate),
        any::<u16>().prop_map(|particles_per_sensor| Message::Input(Input::Limit {
            particles_per_sensor
        })),
    ]
}

fn any_fault() -> impl Strategy<Value = Option<InputError>> {
    prop::option::of(prop::sample::select(&InputError::ALL[..]))
}

fn any_particles() -> impl Strategy<Value = Particles> {
    let outcome = prop::sample::select(&OUTCOMES[..]);
    let event = (any::<(i16, i16)>(), outcome)
        .prop_map(|(place, outcome)| ParticleEvent::new(place, outcome));
    (any::<u8>(), prop::collection::vec(event, 0..=BATCH)).prop_map(|(step, outcomes)| Particles {
        step,
        outcomes: outcomes.into_iter().collect(),
    })
}

/// Up to six tracked walls with different numbers, and as many left ones as there can be.
fn any_walls() -> impl Strategy<Value = Walls> {
    let wall = any::<([i16; 2], [i16; 2], [u8; 2], [u8; 2], u8)>()
        .prop_filter("a wall has a length", |(from, to, ..)| from != to);
    let seen = prop::collection::vec(wall, 0..=6);
    let others = any::<(u32, [i16; 2], u16, [u16; 7], u8, u8)>();
    (seen, others).prop_map(|(seen, (index, block, first, left, frozen, gone))| {
        let free = 6 - seen.len();
        let frozen = usize::from(frozen) % (free + 1);
        let gone = usize::from(gone) % (7 - seen.len() - frozen).min(6).saturating_add(1);
        let id = |place: usize| first.wrapping_add(1000 * place as u16);
        let tracked = seen.len();
        let walls = seen.into_iter().enumerate();
        let walls = walls.map(|(place, (from, to, along, across, evidence))| TrackedWall {
            id: id(place),
            ends: [from, to],
            along,
            across,
            evidence,
        });
        Walls {
            index,
            block,
            seen: walls.collect(),
            out_of_reach: (tracked..tracked + frozen).map(id).collect(),
            left: left.into_iter().take(gone).collect(),
        }
    })
}

fn any_status() -> impl Strategy<Value = Status> {
    let obstacle = prop::option::of((any_float(), any_float()).prop_map(
        |(range_m, bearing_rad)| Obstacle {
            range_m,
            bearing_rad,
        },
    ));
    let node = (any::<(u32, u32, u32, u8, bool)>(), any_fault(), obstacle).prop_map(
        |((steps, inputs, refused, without, own_ticks), last_fault, obstacle)| NodeStatus {
            steps,
            inputs,
            refused,
            last_fault,
            without,
            obstacle,
            own_ticks,
        },
    );
    let board = any::<(u64, [u32; 7])>().prop_map(|(uptime_ms, n)| BoardStatus {
        uptime_ms,
        step_cycles: n[0],
        step_cycles_max: n[1],
        overruns: n[2],
        dropped_frames: n[3],
        broken_frames: n[4],
        lost_bytes: n[5],
        sent_frames: n[6],
    });
    (node, board).prop_map(|(node, board)| Status { node, board })
}

fn any_post_mortem() -> impl Strategy<Value = PostMortem> {
    let cause = prop::sample::select(&CAUSES[..]);
    (any::<([u32; 10], String)>(), cause).prop_map(|((n, file), cause)| {
        let mut record = PostMortem::new(cause, n[0], n[1]).at(&file, n[2]);
        record.registers = CoreRegisters {
            pc: n[3],
            lr: n[4],
            psr: n[5],
            sp: n[6],
            cfsr: n[7],
            hfsr: n[8],
            address: n[9],
        };
        record
    })
}

fn any_supervision() -> impl Strategy<Value = Supervision> {
    (
        prop::sample::select(&MODES[..]),
        prop::sample::select(&RESETS[..]),
        prop::sample::select(&IMAGE_CHECKS[..]),
        any::<(bool, u32)>(),
    )
        .prop_map(
            |(mode, reset, image, (is_under_loader, stack_unused))| Supervision {
                mode,
                reset,
                image,
                is_under_loader,
                stack_unused,
            },
        )
}

fn any_health() -> impl Strategy<Value = Health> {
    let select = prop::sample::select::<SensorState>;
    let sensor =
        (select(&SENSOR_STATES[..]), any::<(u8, u16)>()).prop_map(|(state, (age_ms, failed))| {
            SensorHealth {
                state,
                age_ms,
                failed,
            }
        });
    let bus = (prop::sample::select(&BUS_STATES[..]), any::<(u16, u16)>()).prop_map(
        |(state, (failed, recoveries))| BusHealth {
            state,
            failed,
            recoveries,
        },
    );
    let can = (
        prop::sample::select(&CAN_STATES[..]),
        any::<(u32, [u16; 4])>(),
    )
        .prop_map(|(state, (taken, n))| CanHealth {
            state,
            taken,
            ignored: n[0],
            overruns: n[1],
            bus_offs: n[2],
            unsent: n[3],
        });
    (
        prop::array::uniform8(sensor),
        prop::array::uniform2(bus),
        can,
        prop::sample::select(&SEED_SOURCES[..]),
        prop::sample::select(&OFFSET_ORIGINS[..]),
    )
        .prop_map(|(sensors, buses, can, seed, offsets)| Health {
            sensors,
            buses,
            can,
            seed,
            offsets,
        })
}

fn any_offsets() -> impl Strategy<Value = OffsetReport> {
    let refusal = (0..5_usize, any::<u16>()).prop_map(|(reason, counts)| match reason {
        0 => OffsetRefusal::NotDelivering,
        1 => OffsetRefusal::Unsteady(counts),
        2 => OffsetRefusal::OutOfRange(counts),
        3 => OffsetRefusal::AboveRing(counts),
        _ => OffsetRefusal::AboveStored(counts),
    });
    let refused = prop::array::uniform8(prop::option::of(refusal));
    let origin = prop::sample::select(&OFFSET_ORIGINS[..]);
    (any::<([u16; 8], bool)>(), origin, refused).prop_map(|((counts, is_kept), origin, refused)| {
        OffsetReport {
            offsets: Offsets { counts, origin },
            is_kept,
            refused,
        }
    })
}

fn any_message_of_a_board() -> impl Strategy<Value = Message> {
    let clock = prop::sample::select(&[
        ClockSource::Host,
        ClockSource::CrystalPll,
        ClockSource::InternalPll,
        ClockSource::Internal,
        ClockSource::Unknown,
    ]);
    let boot = (any::<(u8, u64, u32, u8, u32, u32)>(), clock).prop_map(
        |((wire_version, build_id, capacity, window, baud, core_hz), clock)| Boot {
            wire_version,
            build_id,
            capacity,
            window,
            baud,
            clock,
            core_hz,
        },
    );
    let begun = (any::<(u32, u64)>(), any_pose(), any_samples()).prop_map(
        |((index, stamp_us), pose, samples)| StepBegun {
            index,
            stamp_us,
            pose,
            samples,
        },
    );
    let done =
        any::<(u32, u32, [u16; 5], bool)>().prop_map(|(index, digest, n, degenerate)| StepDone {
            index,
            digest,
            past_gate: n[0],
            below_gate: n[1],
            free: n[2],
            unobserved: n[3],
            departed: n[4],
            degenerate,
        });
    prop_oneof![
        boot.prop_map(Message::Boot),
        any_config().prop_map(|config| Event::Configured(config).into()),
        begun.prop_map(|step| Event::StepBegun(step).into()),
        any_particles().prop_map(|batch| Event::Particles(batch).into()),
        any_walls().prop_map(|walls| Event::Walls(walls).into()),
        done.prop_map(|step| Event::StepDone(step).into()),
        (any::<u16>(), any_fault()).prop_map(|(input, refused)| Message::Answer { input, refused }),
        any_status().prop_map(Message::Status),
        any::<u64>().prop_map(|stamp_us| Event::OdometryReset { stamp_us }.into()),
        any_health().prop_map(Message::Health),
        any_post_mortem().prop_map(Message::PostMortem),
        any_supervision().prop_map(Message::Supervision),
        any_offsets().prop_map(Message::Offsets),
    ]
}

fn any_message() -> impl Strategy<Value = Message> {
    let truth = prop_oneof![
        (any::<u64>(), any_pose())
            .prop_map(|(stamp_us, pose)| TruthMessage::Pose { stamp_us, pose }),
        prop::collection::vec(any::<u8>(), 0..=SCENARIO_CHUNK)
            .prop_map(|bytes| TruthMessage::Scenario(bytes.into_iter().collect())),
        any::<u64>().prop_map(TruthMessage::Seed),
        (
            any::<u64>(),
            prop::collection::vec(any::<u8>(), 0..=FAULTS_CHUNK)
        )
            .prop_map(|(seed, bytes)| TruthMessage::Faults {
                seed,
                text: bytes.into_iter().collect(),
            }),
    ];
    prop_oneof![
        7 => any_message_to_a_board(),
        11 => any_message_of_a_board(),
        4 => truth.prop_map(Message::Truth),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn what_was_encoded_is_decoded(message in any_message(), boot_id: u8, sequence in 0..2000_u16) {
        let frame = Frame { boot_id, sequence, message };
        let bytes = encode(&frame);
        prop_assert!(bytes.len() <= longest_frame(kind(&frame.message)));
        prop_assert_eq!(bytes.last(), Some(&0));
        prop_assert!(!bytes[..bytes.len() - 1].contains(&0));
        let decoded = decode(&bytes);
        prop_assert_eq!(&decoded, &Ok(frame));
        // By bits too: -0 equals 0, but is not the same bytes.
        prop_assert_eq!(encode(&decoded.unwrap()), bytes);
    }

    #[test]
    fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        let mut decoder = Decoder::new();
        for byte in &bytes {
            decoder.push(*byte);
        }
        let _ = Frame::decode(&mut bytes.clone());
    }

    #[test]
    fn arbitrary_payloads_in_good_frames_never_panic(
        payload in prop::collection::vec(any::<u8>(), 0..=117),
        lead in 0..3_u8,
        variant in 0..14_u8,
    ) {
        let bytes = frame_by_the_document(1, 2, &[&[lead, variant], &payload[..]].concat());
        match decode(&bytes) {
            Ok(frame) => prop_assert_eq!(frame.sequence, 2),
            Err(error) => prop_assert_eq!(error, FrameError::NotAMessage),
        }
    }
}

#[test]
fn what_is_no_message_of_this_version_is_refused() {
    let hello = [0, 0];
    assert!(decode(&frame_by_the_document(1, 2, &hello)).is_ok());
    let seven_of_particles = [&[1, 3, 0, 7][..], &[9; 7]].concat();
    let cases: [(&str, &[u8]); 12] = [
        ("no payload", &[]),
        ("unknown kind", &[3, 0]),
        ("unknown input", &[0, 8]),
        ("unknown event", &[1, 13]),
        ("unknown truth", &[2, 4]),
        ("unknown fault", &[1, 5, 0, 1, 12]),
        ("a Calibrate with a field", &[0, 6, 0]),
        ("unknown sensor state", &[&[1, 8, 7][..], &[0; 60]].concat()),
        ("half a health", &[1, 8, 4, 0, 0]),
        ("a field too many", &[0, 0, 0]),
        ("a field too few", &[0, 5]),
        ("outcomes that are no triples", &seven_of_particles),
    ];
    for (name, payload) in cases {
        let frame = frame_by_the_document(1, 2, payload);
        assert_eq!(decode(&frame), Err(FrameError::NotAMessage), "{name}");
    }
}

#[test]
fn walls_that_no_board_tracks_are_refused() {
    let decoded = |walls: &Walls| {
        let payload = payload_of(&Message::Event(Event::Walls(walls.clone())));
        decode(&frame_by_the_document(1, 2, &payload)).map(drop)
    };
    let six = Walls {
        seen: (0..6).map(wall_of).collect(),
        ..Walls::default()
    };
    assert_eq!(decoded(&six), Ok(()));
    let mut flat = six.clone();
    flat.seen[2].ends[1] = flat.seen[2].ends[0];
    let mut twice = six.clone();
    twice.seen[5].id = 0;
    let mut frozen_too = example_walls();
    frozen_too.out_of_reach.push(3).unwrap();
    let mut seven = six.clone();
    seven.out_of_reach.push(9).unwrap();
    let mut eight = six.clone();
    eight.left.extend([7, 8]);
    for (name, walls) in [
        ("a wall without length", flat),
        ("two walls of one number", twice),
        ("one within and out of reach", frozen_too),
        ("seven walls", seven),
        ("eight numbers", eight),
    ] {
        assert_eq!(decoded(&walls), Err(FrameError::NotAMessage), "{name}");
    }
    // Lengths that are no multiple of a wall's, and more walls than the bytes can hold.
    for bytes in [1, 14, 16, 7 * 15] {
        let payload = [
            &[1, 12, 0, 0, 0, bytes][..],
            &vec![7; usize::from(bytes)],
            &[0, 0],
        ]
        .concat();
        let frame = frame_by_the_document(1, 2, &payload);
        assert_eq!(
            decode(&frame),
            Err(FrameError::NotAMessage),
            "{bytes} bytes"
        );
    }
}

#[test]
fn pieces_that_are_no_frame_are_distinguished() {
    let hello = frame_by_the_document(1, 2, &[0, 0]);
    let mut damaged = hello.clone();
    damaged[1] ^= 2;
    let cases: [(&[u8], FrameError); 6] = [
        (
            &[[1; MAX_FRAME].as_slice(), &[0]].concat(),
            FrameError::TooLong,
        ),
        (&[[1; 1000].as_slice(), &[0]].concat(), FrameError::TooLong),
        (&[2, 0], FrameError::NotCobs),
        (&[200, 1, 1, 0], FrameError::NotCobs),
        (&[4, 1, 1, 1, 0], FrameError::TooShort),
        (&damaged, FrameError::BadChecksum),
    ];
    for (bytes, error) in cases {
        assert_eq!(decode(bytes), Err(error), "{bytes:02x?}");
    }
    assert!(decode_all(&mut Decoder::new(), &[0; 1000]).is_empty());
}

/// Frames of all lengths from one sender, numbered from 0.
fn long_run(frames: u16) -> Vec<Vec<u8>> {
    let messages: Vec<Message> = golden_messages()
        .into_iter()
        .map(|(.., message)| message)
        .collect();
    let mut encoder = Encoder::new(9);
    (0..usize::from(frames))
        .map(|index| encoder.encode(&messages[index % messages.len()]).to_vec())
        .collect()
}

/// Numbers of the good frames, after a check that each was really sent.
fn numbers(received: &[Received], sent: &[Vec<u8>]) -> Vec<u16> {
    received
        .iter()
        .filter_map(|received| match received {
            Received::Frame { frame, .. } => {
                let original = decode(&sent[usize::from(frame.sequence)]).unwrap();
                assert_eq!(*frame, original, "a damaged frame was accepted");
                Some(frame.sequence)
            }
            Received::Broken(_) => None,
        })
        .collect()
}

fn total_lost(received: &[Received]) -> u32 {
    received
        .iter()
        .map(|received| match received {
            Received::Frame { lost, .. } => u32::from(*lost),
            Received::Broken(_) => 0,
        })
        .sum()
}

#[test]
fn f60_bit_errors_cost_the_frames_they_hit_and_nothing_is_falsely_accepted() {
    let sent = long_run(40_000);
    for (seed, bit_error_rate) in [(1, 1e-4_f64), (2, 1e-3), (3, 1e-2)] {
        let mut random = Generator::seeded(seed);
        // Bits to the next error are distributed geometrically.
        let mut gap = || {
            let uniform = (f64::from(random.bits()) + 1.0) / 4_294_967_296.0;
            (uniform.ln() / (-bit_error_rate).ln_1p()) as u64
        };
        let mut until_error = gap();
        let mut decoder = Decoder::new();
        let mut received = Vec::new();
        let mut whole = Vec::new();
        let (mut expected, mut variance) = (0.0, 0.0);
        let mut delimiter_is_whole = true;
        for (number, frame) in sent.iter().enumerate() {
            let mut damaged = frame.clone();
            let bits = 8 * frame.len() as u64;
            while until_error < bits {
                damaged[until_error as usize / 8] ^= 1 << (until_error % 8);
                until_error += 1 + gap();
            }
            until_error -= bits;
            if damaged == *frame && delimiter_is_whole {
                whole.push(number as u16);
            }
            delimiter_is_whole = damaged.last() == Some(&0);
            received.extend(decode_all(&mut decoder, &damaged));
            // Its own bits and those of the zero byte before it.
            let share = (1.0 - bit_error_rate).powf((bits + 8) as f64);
            expected += share;
            variance += share * (1.0 - share);
        }
        let arrived = numbers(&received, &sent);
        // Exactly the undamaged frames: none is lost beside them, none is invented.
        assert_eq!(arrived, whole, "bit error rate {bit_error_rate}");
        // Neighbours share a zero byte, which correlates them a little: 5 sigma.
        let error = arrived.len() as f64 - expected;
        assert!(
            error.abs() < 5.0 * variance.sqrt(),
            "bit error rate {bit_error_rate}: {} of {expected}",
            arrived.len()
        );
        let last = arrived.last().map_or(0, |last| u32::from(*last));
        let first = u32::from(arrived[0]);
        let seen = arrived.len() as u32 + total_lost(&received);
        assert_eq!(seen, last + 1 - first, "lost frames are counted");
    }
}

#[test]
fn f61_truncation_at_every_byte_loses_at_most_two_frames() {
    let sent = long_run(4 * 20);
    for first in (0..sent.len()).step_by(4) {
        let [before, cut, after, last] = &sent[first..first + 4] else {
            unreachable!("four frames at a time");
        };
        for length in 0..cut.len() {
            let stream = [before, &cut[..length], after, last].concat();
            let received = decode_all(&mut Decoder::new(), &stream);
            let arrived = numbers(&received, &sent);
            let place = format!("frame {} cut to {length} bytes", first + 1);
            assert!(arrived.len() >= 2, "{place}: {arrived:?}");
            assert_eq!(arrived.last(), Some(&(first as u16 + 3)), "{place}");
            assert_eq!(total_lost(&received), 4 - arrived.len() as u32, "{place}");
        }
    }
}

#[test]
fn f62_a_megabyte_of_garbage_is_passed_over_in_bounded_room_and_time() {
    assert!(size_of::<Decoder>() <= 2 * MAX_FRAME);
    let mut random = Generator::seeded(62);
    let mut noise = |lowest: u8| -> Vec<u8> {
        let byte = |_| (random.bits() as u8).max(lowest);
        (0..1 << 20).map(byte).collect()
    };
    let sent = long_run(2);
    for (name, garbage) in [
        ("with zeros", noise(0)),
        ("without zeros", noise(1)),
        ("ones", vec![1; 1 << 20]),
        ("zeros", vec![0; 1 << 20]),
        ("short runs", [1, 0].repeat(1 << 19)),
    ] {
        let mut decoder = Decoder::new();
        // The eighth megabyte takes no longer than the first may: 1 s is 50 times
        // what a slow build needs.
        for _ in 0..8 {
            let start = Instant::now();
            let received = decode_all(&mut decoder, &garbage);
            assert!(start.elapsed() < Duration::from_secs(1), "{name}");
            assert!(numbers(&received, &sent).is_empty(), "{name}");
        }
        // The first frame ends the garbage, the second is whole.
        let after = decode_all(&mut decoder, &sent.concat());
        assert_eq!(numbers(&after, &sent).last(), Some(&1), "{name}");
        // With a zero byte between, both are.
        let mut decoder = Decoder::new();
        decode_all(&mut decoder, &[&garbage[..], &[0]].concat());
        let after = decode_all(&mut decoder, &sent.concat());
        assert_eq!(numbers(&after, &sent), [0, 1], "{name}");
    }
}

#[test]
fn f63_bursts_of_dropped_bytes_cost_the_frames_they_touch_and_one_more() {
    let sent = long_run(2000);
    for seed in 1..=3 {
        let mut random = Generator::seeded(seed);
        let mut below = |bound| uniform_below(&mut random, bound) as usize;
        let mut decoder = Decoder::new();
        let mut received = Vec::new();
        let mut hit = 0;
        let mut to_drop = 0;
        for frame in &sent[..1998] {
            let mut left = Vec::new();
            for byte in frame {
                if to_drop == 0 && below(4000) == 0 {
                    to_drop = 1 + below(300);
                    // The frame behind a burst that ate a zero byte.
                    hit += 1;
                }
                if to_drop > 0 {
                    to_drop -= 1;
                } else {
                    left.push(*byte);
                }
            }
            hit += usize::from(left.len() < frame.len());
            received.extend(decode_all(&mut decoder, &left));
        }
        for frame in &sent[1998..] {
            received.extend(decode_all(&mut decoder, frame));
        }
        let arrived = numbers(&received, &sent);
        assert!(hit > 20, "seed {seed}: only {hit} frames hit");
        assert!(arrived.len() >= 2000 - hit, "seed {seed}");
        assert!(arrived.is_sorted_by(|a, b| a < b), "seed {seed}");
        let seen = arrived.len() as u32 + total_lost(&received);
        assert_eq!(seen, 2000 - u32::from(arrived[0]), "seed {seed}");
    }
}

#[test]
fn f68_repeated_and_reordered_frames_show_in_lost() {
    let sent = long_run(6);
    let lost_of = |order: &[usize]| -> Vec<u16> {
        let stream: Vec<u8> = order
            .iter()
            .flat_map(|&place| sent[place].clone())
            .collect();
        decode_all(&mut Decoder::new(), &stream)
            .into_iter()
            .map(|received| match received {
                Received::Frame { lost, .. } => lost,
                Received::Broken(error) => panic!("{error}"),
            })
            .collect()
    };
    assert_eq!(lost_of(&[0, 1, 2, 3]), [0, 0, 0, 0]);
    assert_eq!(lost_of(&[0, 3, 4]), [0, 2, 0]);
    assert_eq!(lost_of(&[0, 1, 1, 2]), [0, 0, 65_535, 0], "repeated");
    assert_eq!(lost_of(&[0, 2, 1, 3]), [0, 1, 65_534, 1], "reordered");
}

#[test]
fn numbers_go_on_from_65535_to_0_and_another_boot_starts_over() {
    let mut decoder = Decoder::new();
    let mut lost_before = |boot_id, sequence| {
        let bytes = frame_by_the_document(boot_id, sequence, &[0, 0]);
        match decode_all(&mut decoder, &bytes).as_slice() {
            [Received::Frame { lost, .. }] => *lost,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(lost_before(1, 65_534), 0);
    assert_eq!(lost_before(1, 65_535), 0);
    assert_eq!(lost_before(1, 0), 0);
    assert_eq!(lost_before(1, 2), 1);
    assert_eq!(lost_before(2, 0), 0, "another boot");
}
