//! The robot's bus through the public door: golden frames, garbage, turns.
//!
//! Names that begin with f and a number are entries of the fault catalogue: CAN and
//! odometry.

use std::f32::consts::{FRAC_PI_2, TAU};

use amiro_ipf::can::{
    Board, BodySpeed, Frame, Identifier, Ignored, Message, READ, StandardId, TransmittedPose,
    actual_speed, odometry, target_speed,
};
use amiro_ipf::geometry::Pose;
use amiro_ipf::model::DifferentialDrive;
use amiro_ipf::node::odometry::Odometry;
use amiro_ipf::random::Generator;
use proptest::prelude::*;

/// 256 um or 256 urad, and the rounding of numbers of some metres.
const STEP: f32 = 256e-6 + 1e-6;

fn data<const LENGTH: usize>(identifier: u16, bytes: [u8; LENGTH]) -> Frame {
    Frame::data(StandardId::from_bits(identifier), bytes)
}

fn pose_of(frame: &Frame) -> Pose {
    match Message::decode(frame) {
        Ok(Message::Odometry(pose)) => pose,
        other => unreachable!("{other:?}"),
    }
}

#[test]
fn golden_odometry_is_read_in_metres_and_radians() {
    // x = 0x000f42 = 3906 steps = 999936 um. y = 0xfffffe = -2 steps = -512 um.
    // Heading 0x17f7 = 6135 steps = 1570560 urad, 0.236 mrad less than pi / 2.
    let frame = data(0x281, [0x42, 0x0f, 0x00, 0xfe, 0xff, 0xff, 0xf7, 0x17]);
    let pose = pose_of(&frame);
    assert_eq!(pose, Pose::new(0.999_936, -0.000_512, 1.570_56));
    assert_eq!(odometry(&Pose::new(1.0, -0.000_500, FRAC_PI_2)), frame);
    // The farthest corner: 0x7fffff steps = 2147.483392 m, 0x800000 = -2147.483648 m.
    let corner = data(0x281, [0xff, 0xff, 0x7f, 0x00, 0x00, 0x80, 0, 0]);
    assert_eq!(pose_of(&corner), Pose::new(2_147.483_4, -2_147.483_6, 0.0));
}

#[test]
fn golden_speeds_are_read_in_metres_and_radians_a_second() {
    // 80000 um/s = 0x00013880; -200000 urad/s = 0xfffcf2c0.
    let bytes = [0x80, 0x38, 0x01, 0x00, 0xc0, 0xf2, 0xfc, 0xff];
    let speed = BodySpeed {
        forward_m_per_s: 0.08,
        turn_rad_per_s: -0.2,
    };
    assert_eq!(
        Message::decode(&data(0x101, bytes)),
        Ok(Message::ActualSpeed(speed))
    );
    for sender in [0x082, 0x084] {
        let target = Message::decode(&data(sender, bytes));
        assert_eq!(target, Ok(Message::TargetSpeed(speed)), "{sender:#x}");
    }
    assert_eq!(actual_speed(&speed), data(0x101, bytes));
    assert_eq!(target_speed(&speed), data(0x084, bytes));
}

#[test]
fn golden_calls_are_read_from_their_senders() {
    assert_eq!(
        Message::decode(&data(0x414, [])),
        Ok(Message::CalibrateRing)
    );
    for (identifier, board) in [
        (0x401, Board::DiWheelDrive),
        (0x402, Board::PowerManagement),
        (0x403, Board::LightRing),
        (0x404, Board::Cognition),
    ] {
        // 0xaa55, lowest byte first.
        let frame = data(identifier, [0x55, 0xaa]);
        assert_eq!(Message::decode(&frame), Ok(Message::Shutdown(board)));
        let swapped = data(identifier, [0xaa, 0x55]);
        assert_eq!(Message::decode(&swapped), Err(Ignored::ImpossibleValue));
    }
}

#[test]
fn f23_frames_for_others_and_misshapen_ones_are_ignored_by_their_reason() {
    let long = Identifier::Standard(StandardId::ODOMETRY);
    for (frame, reason) in [
        (
            Frame::received(Identifier::Extended(0x281), false, 8, [0; 8]),
            Ignored::Extended,
        ),
        (Frame::received(long, true, 8, [0; 8]), Ignored::NotData),
        (Frame::received(long, true, 0, [0; 8]), Ignored::NotData),
        (data(0x000, []), Ignored::UnknownId),
        // ODOMETRY from another board, the ring, the boot loader, a board that is none.
        (data(0x282, [0; 8]), Ignored::UnknownId),
        (data(0x182, [0; 2]), Ignored::UnknownId),
        (data(0x600, [0; 8]), Ignored::UnknownId),
        (data(0x405, [0x55, 0xaa]), Ignored::UnknownId),
        (data(0x400, [0x55, 0xaa]), Ignored::UnknownId),
        (data(0x281, [0; 7]), Ignored::WrongLength),
        (data(0x101, [0; 6]), Ignored::WrongLength),
        (data(0x084, []), Ignored::WrongLength),
        (data(0x414, [0]), Ignored::WrongLength),
        (data(0x402, [0x55]), Ignored::WrongLength),
    ] {
        assert_eq!(Message::decode(&frame), Err(reason), "{frame:?}");
    }
}

#[test]
fn f23_values_that_no_robot_sends_are_ignored() {
    let heading = |steps: u16| {
        let [low, high] = steps.to_le_bytes();
        Message::decode(&data(0x281, [0, 0, 0, 0, 0, 0, low, high]))
    };
    // 2 pi is 24543.7 steps; 24544 is the step that it lies in, 24545 is beyond.
    assert!(heading(24_543).is_ok());
    assert!(heading(24_544).is_ok());
    assert_eq!(heading(24_545), Err(Ignored::ImpossibleValue));
    assert_eq!(heading(u16::MAX), Err(Ignored::ImpossibleValue));
    for (forward, turn, is_read) in [
        (10_000_000, -300_000_000, true),
        (-10_000_000, 300_000_000, true),
        (10_000_001, 0, false),
        (0, -300_000_001, false),
        (i32::MIN, 0, false),
        (0, i32::MIN, false),
    ] {
        let [v0, v1, v2, v3] = i32::to_le_bytes(forward);
        let [w0, w1, w2, w3] = i32::to_le_bytes(turn);
        let read = Message::decode(&data(0x101, [v0, v1, v2, v3, w0, w1, w2, w3]));
        assert_eq!(read.is_ok(), is_read, "{forward} {turn}: {read:?}");
    }
}

#[test]
fn f23_every_reason_for_ignoring_a_frame_has_its_own_words() {
    let words = [
        Ignored::Extended,
        Ignored::NotData,
        Ignored::UnknownId,
        Ignored::WrongLength,
        Ignored::ImpossibleValue,
    ]
    .map(|reason| reason.to_string());
    for (index, word) in words.iter().enumerate() {
        assert!(!word.is_empty(), "{words:?}");
        assert!(!words[..index].contains(word), "{words:?}");
    }
}

#[test]
fn f23_of_all_payloads_one_alone_switches_the_robot_off() {
    for identifier in 0x401..=0x404 {
        for word in 0..=u16::MAX {
            let read = Message::decode(&data(identifier, word.to_le_bytes()));
            let is_shutdown = matches!(read, Ok(Message::Shutdown(_)));
            assert_eq!(is_shutdown, word == 0xaa55, "{identifier:#x}, {word:#06x}");
            let is_refused = read == Err(Ignored::ImpossibleValue);
            assert_ne!(is_refused, is_shutdown, "{identifier:#x}, {word:#06x}");
        }
        // The right bytes with others before, behind or missing are another message.
        for frame in [
            data(identifier, []),
            data(identifier, [0x55]),
            data(identifier, [0x55, 0xaa, 0x00]),
            data(identifier, [0x00, 0x55, 0xaa]),
            data(identifier, [0x55, 0xaa, 0, 0, 0, 0, 0, 0]),
        ] {
            let read = Message::decode(&frame);
            assert_eq!(read, Err(Ignored::WrongLength), "{frame:?}");
        }
    }
}

#[test]
fn f23_exactly_the_listed_identifiers_are_read() {
    for bits in 0..0x800 {
        let identifier = StandardId::from_bits(bits);
        let is_unknown = [data(bits, []), data(bits, [0; 2]), data(bits, [0; 8])]
            .iter()
            .all(|frame| Message::decode(frame) == Err(Ignored::UnknownId));
        assert_eq!(READ.contains(&identifier), !is_unknown, "{bits:#x}");
    }
}

/// A frame of random bits, every second one with an identifier that is read.
fn random_frame(random: &mut Generator) -> Frame {
    let [head, first, second] = [(); 3].map(|()| random.bits());
    let identifier = match head & 3 {
        0 => Identifier::Extended(head >> 3),
        1 => Identifier::Standard(StandardId::from_bits((head >> 8) as u16)),
        _ => Identifier::Standard(READ[(head >> 8) as usize % READ.len()]),
    };
    let [a, b, c, d] = first.to_le_bytes();
    let [e, f, g, h] = second.to_le_bytes();
    let is_remote = head >> 28 == 0;
    // Every second frame of eight bytes, the others of any length code.
    let length_code = if head & 4 == 0 {
        8
    } else {
        (head >> 4) as u8 & 15
    };
    Frame::received(identifier, is_remote, length_code, [a, b, c, d, e, f, g, h])
}

#[test]
fn f23_a_million_random_frames_are_read_in_range_or_ignored() {
    let mut random = Generator::seeded(23);
    let mut counts = [0_u32; 6];
    for _ in 0..1_000_000 {
        let frame = random_frame(&mut random);
        let count = match Message::decode(&frame) {
            Ok(message) => {
                assert_in_range(&message);
                0
            }
            Err(Ignored::Extended) => 1,
            Err(Ignored::NotData) => 2,
            Err(Ignored::UnknownId) => 3,
            Err(Ignored::WrongLength) => 4,
            Err(Ignored::ImpossibleValue) => 5,
        };
        counts[count] += 1;
    }
    // Each kind is tested by some thousands.
    assert!(counts.iter().all(|count| *count > 5_000), "{counts:?}");
}

fn assert_in_range(message: &Message) {
    match message {
        Message::Odometry(pose) => {
            assert!(pose.is_finite(), "{pose:?}");
            let farthest = pose.position.x.abs().max(pose.position.y.abs());
            assert!(farthest <= 2_147.483_7, "{pose:?}");
        }
        Message::ActualSpeed(speed) | Message::TargetSpeed(speed) => {
            assert!(speed.forward_m_per_s.abs() <= 10.0, "{speed:?}");
            assert!(speed.turn_rad_per_s.abs() <= 300.0, "{speed:?}");
        }
        Message::CalibrateRing | Message::Shutdown(_) => {}
    }
}

#[test]
fn f36_headings_across_zero_give_small_motions() {
    const DRIVE: DifferentialDrive = DifferentialDrive::AMIRO;
    // Turns in place of 20 mrad a frame, three times round, to the left and to the right.
    for direction in [1.0_f32, -1.0] {
        let mut robot = Odometry::default();
        let mut last: Option<Pose> = None;
        for index in 0..=943_u32 {
            let heading = direction * 0.02 * index as f32;
            let told = pose_of(&odometry(&Pose::new(0.1, -0.1, heading)));
            let stamp_us = u64::from(index) * 63_000;
            robot.take_pose(stamp_us, told).unwrap();
            let pose = robot.pose_at(&DRIVE, stamp_us).unwrap();
            if let Some(last) = last {
                let turn = last.motion_to(&pose).turn.radians();
                let error = (turn - direction * 0.02).abs();
                assert!(error < STEP, "{index}: {turn} rad");
                let between = robot.pose_at(&DRIVE, stamp_us - 31_500).unwrap();
                let half = last.motion_to(&between).turn.radians();
                assert!((half - 0.5 * turn).abs() < 1e-6, "{index}: {half} rad");
            }
            last = Some(pose);
        }
    }
}

#[test]
fn f36_a_million_frames_of_turning_lose_nothing_but_the_rounding_of_two_pi() {
    // 0.1 rad a frame: 15915 turns. Each takes f32's 2 pi off, 1.75e-7 rad too much,
    // and rounds at most twice by 6e-8; the steps of 256 urad do not add up.
    let mut turned = 0.0_f64;
    let mut last = Pose::default();
    for index in 1..=1_000_000_u32 {
        let heading = (f64::from(index) * 0.1) % std::f64::consts::TAU;
        let told = pose_of(&odometry(&Pose::new(0.0, 0.0, heading as f32)));
        turned += f64::from(last.motion_to(&told).turn.radians());
        last = told;
    }
    let error = (turned - 100_000.0).abs();
    assert!(error < 256e-6 + 15_915.0 * 3e-7, "{error}");
}

fn heading_error(sent: &Pose, told: &Pose) -> f32 {
    sent.motion_to(told).turn.radians()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 4096, ..ProptestConfig::default() })]

    #[test]
    fn poses_come_back_within_a_step_below(
        x in -100.0_f32..100.0, y in -1.0_f32..1.0, heading in -TAU..TAU,
    ) {
        let sent = Pose::new(x, y, heading);
        let told = pose_of(&odometry(&sent));
        // Rounded down; f32 at 100 m has steps of 8 um.
        prop_assert!((-8e-6..STEP + 8e-6).contains(&(x - told.position.x)), "{:?}", told);
        prop_assert!((-1e-6..STEP).contains(&(y - told.position.y)), "{:?}", told);
        let error = heading_error(&told, &sent);
        prop_assert!((-1e-6..STEP).contains(&error), "{} rad", error);
        // Sent once more, it is a step lower at most: f32 may lie below the step.
        let again = pose_of(&odometry(&told));
        prop_assert!((again.position - told.position).norm() < 2.0 * STEP);
        prop_assert_eq!(TransmittedPose::of(&sent).pose(), told);
    }

    #[test]
    fn speeds_come_back_within_a_millionth(v in -2.0_f32..2.0, w in -20.0_f32..20.0) {
        let speed = BodySpeed { forward_m_per_s: v, turn_rad_per_s: w };
        let Ok(Message::ActualSpeed(told)) = Message::decode(&actual_speed(&speed)) else {
            unreachable!("{speed:?}");
        };
        // 1 um/s rounded down; f32 at 20 rad/s has steps of 2e-6.
        prop_assert!((-2e-7..1.3e-6).contains(&(v - told.forward_m_per_s)), "{:?}", told);
        prop_assert!((-2e-6..4e-6).contains(&(w - told.turn_rad_per_s)), "{:?}", told);
    }

    #[test]
    fn f23_arbitrary_frames_never_panic_and_forget_what_is_beyond_their_length(
        bits in any::<u32>(), is_extended: bool, is_remote: bool, code in any::<u8>(),
        bytes: [u8; 8],
    ) {
        let identifier = if is_extended {
            Identifier::Extended(bits)
        } else {
            Identifier::Standard(StandardId::from_bits(bits as u16))
        };
        let frame = Frame::received(identifier, is_remote, code, bytes);
        let again = Frame::received(identifier, is_remote, code, frame.bytes());
        prop_assert_eq!(frame, again);
        if let Ok(message) = Message::decode(&frame) {
            assert_in_range(&message);
        }
    }
}
