//! Boards at the end of a link: lock-step, what it compares, what it says when it fails.
//!
//! Names that begin with f64 to f69 are entries of the fault catalogue: the serial link.

#![expect(clippy::panic, reason = "a test that cannot go on says why")]

use std::time::{Duration, Instant};

use amiro_ipf::BUILD_ID;
use amiro_ipf::board::calibration::OffsetRefusal;
use amiro_ipf::board::health::Health;
use amiro_ipf::board::offsets::{OffsetOrigin, Offsets, STORE_BYTES};
use amiro_ipf::filter::{ParticleSet, Profile};
use amiro_ipf::geometry::Pose;
use amiro_ipf::link::{
    BoardStatus, Decoder, DeviceEndpoint, Encoder, Frame, Message, MessageRef, Received, Status,
    TruthMessage, WIRE_VERSION,
};
use amiro_ipf::model::Sample;
use amiro_ipf::node::{Config, Event, Input, InputError, Node, Source};
use amiro_ipf::random::{Generator, uniform_below};
use sim_harness::bus::RobotBuses;
use sim_harness::device::{
    Board, Comparison, Equality, FrameTally, LinkError, Verdict, boot_on_host, drive,
    measure_offsets, offsets_in_words, record,
};
use sim_harness::log::read_from;
use sim_harness::run;

/// Steps of [`inputs`]: one at the start and one per 10 mm.
const STEPS: usize = 7;

fn config() -> Config {
    Config {
        particles_per_sensor: 100,
        ..Config::amiro(Profile::Paper)
    }
}

/// Sixty millimetres along a wall, in readings 2 mm apart.
fn inputs_with(config: Config) -> Vec<Input> {
    let mut samples = [Sample::Counts(3); 8];
    samples[1] = Sample::Counts(110);
    samples[2] = Sample::Counts(100);
    let rows = (0..=30_u64).flat_map(|row| {
        let stamp_us = row * 25_000;
        let pose = Pose::new(row as f32 * 2e-3, 0.0, 0.0);
        [
            Input::Odometry { stamp_us, pose },
            Input::Proximity { stamp_us, samples },
        ]
    });
    [Input::Configure(config)].into_iter().chain(rows).collect()
}

fn inputs() -> Vec<Input> {
    inputs_with(config())
}

/// The host's own run, without any link.
fn host_events(inputs: &[Input]) -> Vec<Event> {
    let mut particles = Box::new(ParticleSet::<800>::new());
    let mut node = Node::new(&mut particles);
    let mut events = Vec::new();
    for input in inputs {
        node.handle(input, &mut |event| events.push(event.clone()))
            .unwrap();
    }
    events
}

/// A board's run of `inputs` held against the host's run of [`inputs`].
fn verdict_of<M>(
    inputs: &[M],
    on_line: impl FnMut(&mut Vec<u8>) -> bool + Send + 'static,
) -> Verdict
where
    M: Clone,
    for<'m> &'m M: Into<MessageRef<'m>>,
{
    let mut comparison = Comparison::default();
    for event in host_events(&self::inputs()) {
        comparison.expect(&event);
    }
    let mut board = Board::in_memory(on_line);
    board.greet().unwrap();
    drive(
        &mut board,
        inputs,
        |event| comparison.meet(event),
        |_, _| (),
    )
    .unwrap();
    comparison.verdict(board.boot(), &board.tally())
}

fn assert_fails_because(verdict: &Verdict, reasons: &[&str]) {
    assert!(!verdict.equal, "{verdict}");
    let shown = verdict.to_string();
    assert!(shown.starts_with("DIFFERENT"), "{shown}");
    for reason in reasons {
        let is_given = verdict.reasons.iter().any(|stated| stated.contains(reason));
        assert!(is_given, "{reason} is not among the reasons of\n{shown}");
    }
}

fn read(bytes: &[u8]) -> Frame {
    match decode_all(bytes).as_slice() {
        [Received::Frame { frame, .. }] => frame.clone(),
        other => panic!("{other:?}"),
    }
}

fn decode_all(bytes: &[u8]) -> Vec<Received> {
    let mut decoder = Decoder::new();
    bytes
        .iter()
        .filter_map(|&byte| decoder.push(byte))
        .collect()
}

/// The frame's bytes, under its own number and with a correct checksum.
fn write(frame: &Frame) -> Vec<u8> {
    Encoder::numbered_from(frame.boot_id, frame.sequence)
        .encode(&frame.message)
        .to_vec()
}

/// A line that changes the events that a board says, and loses those that become `None`.
fn line(
    mut change: impl FnMut(Message) -> Option<Message> + Send + 'static,
) -> impl FnMut(&mut Vec<u8>) -> bool + Send + 'static {
    move |bytes| {
        let mut frame = read(bytes);
        if !frame.message.is_from_board() {
            return true;
        }
        let Some(message) = change(frame.message) else {
            return false;
        };
        frame.message = message;
        *bytes = write(&frame);
        true
    }
}

#[test]
fn an_undisturbed_run_is_equal_and_reports_how_much_was_compared() {
    let verdict = verdict_of(&inputs(), |_| true);
    assert_eq!(verdict.reasons, Vec::<String>::new());
    assert!(verdict.equal);
    assert_eq!(verdict.steps, STEPS);
    assert_eq!(verdict.digests, STEPS);
    assert_eq!(verdict.expected_steps, STEPS);
    let outcomes: u32 = host_events(&inputs())
        .iter()
        .map(|event| match event {
            Event::StepDone(done) => done.outcomes(),
            _ => 0,
        })
        .sum();
    // All 800 have an outcome in all steps but the first, which draws them.
    assert!(outcomes > 4000, "{outcomes}");
    assert_eq!(verdict.particles, outcomes as usize);
    let shown = verdict.to_string();
    assert!(
        shown.starts_with("EQUAL: 7 of 7 steps, 7 digests, "),
        "{shown}"
    );
    assert!(shown.contains(&format!("{outcomes} outcomes")), "{shown}");
}

#[test]
fn re_framing_alone_changes_nothing() {
    let verdict = verdict_of(&inputs(), line(Some));
    assert!(verdict.equal, "{verdict}");
}

#[test]
fn a_parameter_that_differs_on_one_side_is_found() {
    let mut other = config();
    other.parameters.model_error_m *= 1.01;
    let verdict = verdict_of(&inputs_with(other), |_| true);
    assert_fails_because(&verdict, &["differs in step", "of 7 digests were met"]);
    let other = Config {
        seed: 2,
        ..config()
    };
    let verdict = verdict_of(&inputs_with(other), |_| true);
    assert_fails_because(&verdict, &["differs in step 0 (step done)"]);
}

#[test]
fn a_dropped_particle_frame_is_found() {
    let mut batches = 0;
    let lossy = line(move |event| {
        batches += usize::from(matches!(event, Message::Event(Event::Particles(_))));
        (batches != 30 || !matches!(event, Message::Event(Event::Particles(_)))).then_some(event)
    });
    let verdict = verdict_of(&inputs(), lossy);
    let reasons = [
        "1 frames of the board were lost",
        "1 particle messages never came",
    ];
    assert_fails_because(&verdict, &reasons);
}

#[test]
fn a_frame_that_is_damaged_on_the_line_is_found() {
    let mut frames = 0;
    let verdict = verdict_of(&inputs(), move |bytes| {
        frames += 1;
        if frames == 40 {
            bytes[5] ^= 0x40;
        }
        true
    });
    assert_fails_because(&verdict, &["1 frames of the board were lost"]);
}

#[test]
fn one_other_byte_in_one_particle_message_is_found() {
    let mut batches = 0;
    let verdict = verdict_of(&inputs(), move |bytes| {
        let mut frame = read(bytes);
        if let Message::Event(Event::Particles(batch)) = &mut frame.message {
            batches += 1;
            if batches == 50 {
                // The step's number: one byte, and the frame is good.
                batch.step ^= 1;
                *bytes = write(&frame);
            }
        }
        true
    });
    assert_fails_because(&verdict, &["differs in step 3 (particles)"]);
    assert_eq!(verdict.reasons.len(), 1, "{verdict}");
    assert_eq!(verdict.digests, STEPS, "{verdict}");
}

#[test]
fn one_other_digest_is_found() {
    let verdict = verdict_of(
        &inputs(),
        line(|mut event| {
            if let Message::Event(Event::StepDone(done)) = &mut event
                && done.index == 4
            {
                done.digest ^= 1 << 17;
            }
            Some(event)
        }),
    );
    let reasons = ["differs in step 4 (step done)", "6 of 7 digests were met"];
    assert_fails_because(&verdict, &reasons);
}

#[test]
fn another_build_is_found() {
    let verdict = verdict_of(
        &inputs(),
        line(|mut event| {
            if let Message::Boot(boot) = &mut event {
                boot.build_id ^= 1;
            }
            Some(event)
        }),
    );
    assert_fails_because(&verdict, &["the board runs another build"]);
    assert_eq!(verdict.reasons.len(), 1, "{verdict}");
    assert!(verdict.reasons[0].contains(&format!("{BUILD_ID:016x}")));
}

#[test]
fn a_board_that_did_not_introduce_itself_is_found() {
    let mut comparison = Comparison::default();
    let events = host_events(&inputs());
    events.iter().for_each(|event| comparison.expect(event));
    events.iter().for_each(|event| comparison.meet(event));
    let verdict = comparison.verdict(None, &FrameTally::default());
    assert_fails_because(&verdict, &["did not introduce itself"]);
}

#[test]
fn nothing_compared_is_not_equal() {
    let mut board = Board::in_memory(|_| true);
    board.greet().unwrap();
    let mut comparison = Comparison::default();
    let only_configured = &inputs()[..1];
    for event in host_events(only_configured) {
        comparison.expect(&event);
    }
    drive(
        &mut board,
        only_configured,
        |event| comparison.meet(event),
        |_, _| (),
    )
    .unwrap();
    let verdict = comparison.verdict(board.boot(), &board.tally());
    assert_fails_because(&verdict, &["nothing was compared"]);
    assert_eq!(verdict.reasons.len(), 1, "{verdict}");
}

#[test]
fn a_missing_step_is_found() {
    // The board never hears of the last millimetres.
    let inputs = inputs();
    let verdict = verdict_of(&inputs[..inputs.len() - 2], |_| true);
    let reasons = ["the end of step 6 never came"];
    assert_fails_because(&verdict, &reasons);
    assert_eq!((verdict.steps, verdict.expected_steps), (6, 7), "{verdict}");
}

#[test]
fn a_step_too_many_is_found() {
    let mut inputs = inputs();
    let stamp_us = 1_000_000;
    let pose = Pose::new(0.0705, 0.0, 0.0);
    let samples = [Sample::Counts(3); 8];
    inputs.push(Input::Odometry { stamp_us, pose });
    inputs.push(Input::Proximity { stamp_us, samples });
    let verdict = verdict_of(&inputs, |_| true);
    assert_fails_because(&verdict, &["step begins came after the last"]);
    assert_eq!(verdict.digests, STEPS, "{verdict}");
}

/// The host's run met by itself, and the verdict with these figures of the link.
fn verdict_with(tally: FrameTally, status: Status) -> Verdict {
    let mut comparison = Comparison::default();
    let events = host_events(&inputs());
    events.iter().for_each(|event| comparison.expect(event));
    events.iter().for_each(|event| comparison.meet(event));
    comparison.meet(&Message::Status(status));
    comparison.verdict(Some(&boot_on_host(800)), &tally)
}

#[test]
fn f65_frames_that_the_board_dropped_are_found() {
    let tally = FrameTally {
        dropped: 3,
        ..FrameTally::default()
    };
    let verdict = verdict_with(tally, Status::default());
    assert_fails_because(&verdict, &["3 frames were dropped by the board"]);
    assert_eq!(verdict.reasons.len(), 1, "{verdict}");
}

#[test]
fn frames_that_were_dropped_before_the_greeting_are_no_difference() {
    // The counter of the status begins with the board's boot.
    let board = BoardStatus {
        dropped_frames: 3,
        ..BoardStatus::default()
    };
    let status = Status {
        board,
        ..Status::default()
    };
    let verdict = verdict_with(FrameTally::default(), status);
    assert!(verdict.equal, "{verdict}");
}

#[test]
fn an_account_that_the_board_contradicts_is_no_equality() {
    let tally = FrameTally {
        contradicted: 2,
        ..FrameTally::default()
    };
    let verdict = verdict_with(tally, Status::default());
    let reason = "2 statuses of the board contradict its frames' numbers";
    assert_fails_because(&verdict, &[reason]);
    assert_eq!(verdict.reasons.len(), 1, "{verdict}");
}

/// A board's run of all inputs, and the verdict that counts its answers too.
fn audited(on_line: impl FnMut(&mut Vec<u8>) -> bool + Send + 'static) -> Verdict {
    let mut comparison = Comparison::default();
    for event in host_events(&inputs()) {
        comparison.expect(&event);
    }
    let mut board = Board::in_memory(on_line);
    board.greet().unwrap();
    let meet = |message: &Message| comparison.meet(message);
    let audit = drive(&mut board, &inputs(), meet, |_, _| ()).unwrap();
    comparison.take_audit(audit);
    comparison.verdict(board.boot(), &board.tally())
}

#[test]
fn surplus_answers_are_no_equality() {
    let mut encoder = Encoder::new(0);
    let mut answers = 0;
    let verdict = audited(move |bytes| {
        let frame = read(bytes);
        let mut sent = encoder.encode(&frame.message).to_vec();
        if let Message::Answer { input, .. } = frame.message {
            answers += 1;
            if answers == 5 {
                // The same input is answered once more.
                let refused = None;
                sent.extend(encoder.encode(&Message::Answer { input, refused }));
            }
        }
        *bytes = sent;
        true
    });
    assert_fails_because(&verdict, &["1 answers to no input of this run"]);
    assert_eq!(verdict.reasons.len(), 1, "{verdict}");
}

#[test]
fn answers_out_of_order_are_no_equality() {
    // The answers to two inputs change places.
    let mut held = None;
    let mut answers = 0;
    let verdict = audited(line(move |event| {
        let Message::Answer { input, refused } = event else {
            return Some(event);
        };
        answers += 1;
        match answers {
            6 => {
                held = Some(input);
                Some(Message::Answer {
                    input: input.wrapping_add(1),
                    refused,
                })
            }
            7 => held.take().map(|input| Message::Answer { input, refused }),
            _ => Some(Message::Answer { input, refused }),
        }
    }));
    assert_fails_because(&verdict, &["1 answers came out of order"]);
    assert_eq!(verdict.reasons.len(), 1, "{verdict}");
}

/// The verdict over recorded events of which `keep` lets some through.
fn verdict_of_recorded(mut keep: impl FnMut(&Event) -> bool) -> Verdict {
    let mut comparison = Comparison::default();
    let events = host_events(&inputs());
    events.iter().for_each(|event| comparison.expect(event));
    let kept = events.iter().filter(|event| keep(event));
    kept.for_each(|event| comparison.meet(event));
    comparison.verdict_of_recording()
}

#[test]
fn a_recording_with_lost_particle_messages_is_equal_and_reports_their_number() {
    // The first, the last of a step, and two in a row.
    let mut batches = 0;
    let verdict = verdict_of_recorded(|event| {
        batches += u32::from(matches!(event, Event::Particles(_)));
        !matches!(event, Event::Particles(_)) || ![1, 22, 30, 31].contains(&batches)
    });
    assert_eq!(verdict.equality, Equality::ParticlesLost, "{verdict}");
    assert_eq!(verdict.particle_messages_lost, 4);
    assert_eq!((verdict.steps, verdict.digests), (STEPS, STEPS));
    assert!(!verdict.equal && verdict.reasons.is_empty(), "{verdict}");
    let shown = verdict.to_string();
    assert!(
        shown.starts_with("EQUAL, 4 particle messages lost: 7 of 7 steps, 7 digests, "),
        "{shown}"
    );
}

/// A recording with the profile `wall`, without some of its events, in an order of one's own.
fn verdict_of_walls(change: impl FnOnce(&mut Vec<Event>)) -> Verdict {
    let config = Config {
        particles_per_sensor: 100,
        ..Config::amiro(Profile::Wall)
    };
    let mut events = host_events(&inputs_with(config));
    let mut comparison = Comparison::default();
    events.iter().for_each(|event| comparison.expect(event));
    change(&mut events);
    events.iter().for_each(|event| comparison.meet(event));
    comparison.verdict_of_recording()
}

#[test]
fn a_recording_with_lost_walls_messages_is_equal_and_reports_their_number() {
    let verdict = verdict_of_walls(|_| ());
    assert_eq!(verdict.equality, Equality::Equal, "{verdict}");
    assert_eq!(verdict.walls_messages, STEPS);
    let shown = verdict.to_string();
    assert!(shown.contains(", 7 walls messages too"), "{shown}");
    let is_lost =
        |event: &Event| matches!(event, Event::Walls(walls) if [0, 3].contains(&walls.index));
    let verdict = verdict_of_walls(|events| events.retain(|event| !is_lost(event)));
    assert_eq!(verdict.equality, Equality::ParticlesLost, "{verdict}");
    assert_eq!(
        (verdict.walls_messages, verdict.walls_messages_lost),
        (STEPS - 2, 2)
    );
    assert_eq!(
        (verdict.digests, verdict.particle_messages_lost),
        (STEPS, 0)
    );
    let shown = verdict.to_string();
    assert!(
        shown.starts_with("EQUAL, 2 walls messages lost: 7 of 7"),
        "{shown}"
    );
}

#[test]
fn a_walls_message_that_is_changed_surplus_or_late_is_a_difference() {
    let third = |events: &[Event]| {
        let is_third = |event: &Event| matches!(event, Event::Walls(walls) if walls.index == 3);
        events.iter().position(is_third).unwrap()
    };
    let changes: [fn(&mut Vec<Event>, usize); 3] = [
        |events, at| {
            if let Event::Walls(walls) = &mut events[at] {
                walls.block[0] += 1;
            }
        },
        |events, at| events.insert(at, events[at].clone()),
        |events, at| events.swap(at, at + 1),
    ];
    for change in changes {
        let verdict = verdict_of_walls(|events| {
            let at = third(events);
            change(events, at);
        });
        assert_eq!(verdict.equality, Equality::Different, "{verdict}");
        assert_eq!(verdict.first_different_step, Some(3), "{verdict}");
    }
}

#[test]
fn a_recording_without_any_particle_message_is_equal_with_all_of_them_lost() {
    let verdict = verdict_of_recorded(|event| !matches!(event, Event::Particles(_)));
    assert_eq!(verdict.equality, Equality::ParticlesLost, "{verdict}");
    assert_eq!((verdict.digests, verdict.particle_messages), (STEPS, 0));
}

#[test]
fn a_recording_that_ends_within_its_last_step_is_equal_up_to_there() {
    let count = host_events(&inputs()).len();
    let last_begin = host_events(&inputs())
        .iter()
        .rposition(|event| matches!(event, Event::StepBegun(_)))
        .unwrap();
    // In front of the last step, behind its begin, amid its particles, before its end.
    for end in [last_begin, last_begin + 1, last_begin + 3, count - 1] {
        let mut number = 0;
        let verdict = verdict_of_recorded(|_| {
            number += 1;
            number <= end
        });
        assert_eq!(verdict.equality, Equality::Equal, "{verdict}");
        assert_eq!(verdict.digests, STEPS - 1);
        assert_eq!(verdict.ends_within_step, Some(6));
        assert!(
            verdict
                .to_string()
                .ends_with("\n  the recording ends within step 6")
        );
    }
    // More than that is missing.
    let mut number = 0;
    let verdict = verdict_of_recorded(|_| {
        number += 1;
        number < last_begin
    });
    assert_fails_because(
        &verdict,
        &["5 of 7 digests were met", "2 steps never ended"],
    );
}

#[test]
fn a_recording_that_lost_a_steps_frame_differs_there_and_is_compared_to_its_end() {
    type Keep = fn(&Event) -> bool;
    let cases: [(Keep, &str, usize); 3] = [
        (
            |event| !matches!(event, Event::StepBegun(step) if step.index == 3),
            "step 3 (its begin never came)",
            STEPS,
        ),
        (
            |event| !matches!(event, Event::StepDone(step) if step.index == 3),
            "step 3 (its end never came)",
            STEPS - 1,
        ),
        (
            |event| match event {
                Event::StepBegun(step) => step.index != 3,
                Event::StepDone(step) => step.index != 3,
                Event::Particles(batch) => batch.step != 3,
                _ => true,
            },
            "step 3 (it never came)",
            STEPS - 1,
        ),
    ];
    for (keep, reason, digests) in cases {
        let verdict = verdict_of_recorded(keep);
        assert_fails_because(&verdict, &[reason]);
        assert_eq!(verdict.digests, digests, "{verdict}");
        assert_eq!(verdict.first_different_step, Some(3), "{verdict}");
        assert!(verdict.to_string().starts_with("DIFFERENT at step 3: "));
    }
}

#[test]
fn an_input_without_an_answer_ends_the_run_within_the_deadline() {
    let mut answers = 0;
    // The greeting and two inputs are answered.
    let mut board = Board::in_memory(line(move |event| {
        answers += usize::from(matches!(event, Message::Answer { .. }));
        (answers <= 4 || !matches!(event, Message::Answer { .. })).then_some(event)
    }));
    board.greet().unwrap();
    let start = Instant::now();
    let mut answered = 0;
    let driven = drive(&mut board, &inputs(), |_| (), |_, _| answered += 1);
    let Err(error @ LinkError::NoAnswer { input: 2 }) = driven else {
        panic!("{driven:?}");
    };
    assert_eq!(error.to_string(), "input 2 was not answered within 2 s");
    assert_eq!(answered, 2);
    let waited = start.elapsed();
    assert!(waited >= Duration::from_millis(1900), "{waited:?}");
    assert!(waited < Duration::from_secs(4), "{waited:?}");
}

#[test]
fn an_input_that_the_board_alone_refuses_is_a_difference_and_is_named() {
    let mut inputs = inputs();
    let late = Input::Odometry {
        stamp_us: 0,
        pose: Pose::default(),
    };
    inputs.insert(9, late);
    for (expected, equal) in [
        (vec![(9, InputError::StampBackward)], true),
        (vec![], false),
    ] {
        let mut board = Board::in_memory(|_| true);
        board.greet().unwrap();
        let mut comparison = Comparison::default();
        run(&config(), &inputs[1..], |event| comparison.expect(event)).unwrap();
        comparison.expect_refusals(&expected);
        let mut answers = Vec::new();
        drive(
            &mut board,
            &inputs,
            |event| comparison.meet(event),
            |input, refused| answers.push((input, refused)),
        )
        .unwrap();
        for (input, refused) in answers {
            comparison.meet_answer(input, refused);
        }
        let verdict = comparison.verdict(board.boot(), &board.tally());
        assert_eq!(verdict.equal, equal, "{verdict}");
        let named = verdict
            .to_string()
            .contains("input 9 was refused (stamp lies");
        assert_eq!(named, !equal, "{verdict}");
    }
}

#[test]
fn f69_another_version_is_refused_with_both_numbers() {
    let mut board = Board::in_memory(line(|mut event| {
        if let Message::Boot(boot) = &mut event {
            boot.wire_version = 77;
        }
        Some(event)
    }));
    let error = board.greet().unwrap_err();
    assert!(matches!(error, LinkError::Version { board: 77 }));
    let shown = error.to_string();
    assert!(shown.contains("version 77"), "{shown}");
    assert!(shown.contains(&format!("host {WIRE_VERSION}")), "{shown}");
}

#[test]
fn f6a_a_board_that_starts_anew_in_the_middle_ends_the_run() {
    let mut frames = 0;
    let mut board = Board::in_memory(move |bytes| {
        let mut frame = read(bytes);
        frames += 1;
        frame.boot_id += u8::from(frames > 60);
        *bytes = write(&frame);
        true
    });
    board.greet().unwrap();
    let error = drive(&mut board, &inputs(), |_| (), |_, _| ()).unwrap_err();
    assert!(matches!(error, LinkError::Restarted { .. }), "{error}");
}

#[test]
fn greetings_and_status_do_not_disturb_a_comparison() {
    // A second greeting amid the run is answered and changes no digest.
    let mut messages: Vec<Message> = inputs().into_iter().map(Message::Input).collect();
    messages.insert(20, Message::Hello);
    let verdict = verdict_of(&messages, |_| true);
    assert!(verdict.equal, "{verdict}");
}

/// Raw counts of a robot's sensors on a table, as published.
const TABLE: [u16; 8] = [2469, 2412, 2381, 2491, 2488, 2449, 2413, 2320];

/// A robot on that table; its memory is AMiRo's and holds offsets that are 20 less.
fn robot() -> RobotBuses {
    let mut buses = RobotBuses::default();
    for (sensor, raw) in TABLE.into_iter().enumerate() {
        buses.set_signal(sensor, raw);
    }
    let stored = Offsets {
        counts: TABLE.map(|raw| raw - 20),
        origin: OffsetOrigin::Stored,
    };
    let mut bytes = [0; STORE_BYTES];
    stored.encode(&mut bytes);
    let memory = buses.two.parts_mut().memory.as_mut().unwrap();
    memory.bytes_mut()[..STORE_BYTES].copy_from_slice(&bytes);
    buses
}

#[test]
fn a_robot_on_a_table_has_its_offsets_measured_and_kept() {
    let mut board = Board::robot_in_memory(robot(), |_| true);
    board.greet().unwrap();
    let report = measure_offsets(&mut board).unwrap().unwrap();
    assert_eq!(report.offsets.counts, TABLE);
    assert_eq!(report.offsets.origin, OffsetOrigin::Measured);
    assert!(report.is_kept && report.refused == [None; 8], "{report:?}");
    assert_eq!(
        offsets_in_words(&report),
        "offsets of sensors 0 to 7: 2469 2412 2381 2491 2488 2449 2413 2320 counts\n\
         measured, kept in the board's memory"
    );
    // Whoever greets it later is told the same.
    board.greet().unwrap();
    assert_eq!(board.offsets(), Some(&report));
}

#[test]
fn a_greeted_board_sends_the_offsets_of_its_memory() {
    let mut board = Board::robot_in_memory(robot(), |_| true);
    board.greet().unwrap();
    let report = board.offsets().unwrap();
    assert_eq!(report.offsets.counts, TABLE.map(|raw| raw - 20));
    assert_eq!(report.offsets.origin, OffsetOrigin::Stored);
    // A blank memory holds none, and is not written either.
    let mut buses = robot();
    let memory = buses.two.parts_mut().memory.as_mut().unwrap();
    *memory.bytes_mut() = [0xff; 128];
    let mut board = Board::robot_in_memory(buses, |_| true);
    board.greet().unwrap();
    let report = *board.offsets().unwrap();
    assert_eq!(report.offsets, Offsets::DEFAULTS);
    assert!(!report.is_kept);
    let report = measure_offsets(&mut board).unwrap().unwrap();
    assert_eq!(report.offsets.counts, TABLE);
    assert!(!report.is_kept);
    let words = offsets_in_words(&report);
    assert!(
        words.ends_with("measured, not kept in the board's memory"),
        "{words}"
    );
}

#[test]
fn a_wall_before_one_sensor_refuses_the_offsets_with_sensor_and_reason() {
    let mut buses = robot();
    buses.set_signal(3, TABLE[3] + 300);
    let mut board = Board::robot_in_memory(buses, |_| true);
    board.greet().unwrap();
    let before = board.offsets().unwrap().offsets;
    let report = measure_offsets(&mut board).unwrap().unwrap();
    assert_eq!(report.offsets, before, "none is taken");
    let refused: Vec<usize> = (0..8).filter(|i| report.refused[*i].is_some()).collect();
    assert_eq!(refused, [3]);
    let Some(OffsetRefusal::AboveRing(counts)) = report.refused[3] else {
        panic!("{report:?}");
    };
    let words = offsets_in_words(&report);
    let expected = format!(
        "\nsensor 3 refused: {counts} counts above the ring's median: \
         something is near this sensor"
    );
    assert!(words.ends_with(&expected), "{words}");
}

#[test]
fn a_board_that_sends_no_offsets_is_given_up_after_five_seconds() {
    let mut board = Board::in_memory(|_| true);
    board.greet().unwrap();
    assert_eq!(board.offsets(), None);
    let start = Instant::now();
    assert_eq!(measure_offsets(&mut board).unwrap(), None);
    let waited = start.elapsed();
    assert!(waited >= Duration::from_secs(5), "{waited:?}");
    assert!(waited < Duration::from_secs(8), "{waited:?}");
}

#[test]
fn a_line_on_which_only_the_board_s_health_comes_is_no_answer() {
    // The first two answers are the greetings'; every later one becomes a health.
    let mut answers = 0;
    let mut board = Board::in_memory(line(move |event| {
        answers += usize::from(matches!(event, Message::Answer { .. }));
        let is_hidden = answers > 2 && matches!(event, Message::Answer { .. });
        Some(if is_hidden {
            Message::Health(Health::default())
        } else {
            event
        })
    }));
    board.greet().unwrap();
    let mut received = 0;
    let driven = drive(
        &mut board,
        &[Input::Tick { stamp_us: 0 }],
        |event| received += usize::from(matches!(event, Message::Health(_))),
        |_, _| (),
    );
    assert!(
        matches!(driven, Err(LinkError::NoAnswer { input: 0 })),
        "{driven:?}"
    );
    assert_eq!(received, 1);
}

/// Frames of a run that a board is amid: before its answers, as if it read itself.
fn amid_a_run() -> impl FnMut(&mut Vec<u8>) -> bool + Send + 'static {
    let mut encoder = Encoder::new(0);
    let stale: Vec<Event> = host_events(&inputs());
    let mut is_over = false;
    move |bytes| {
        let mut frame = read(bytes);
        let mut stated = Vec::new();
        let mut send = |message: &Message| stated.extend_from_slice(encoder.encode(message));
        if matches!(frame.message, Message::Event(Event::Configured(_))) && !is_over {
            is_over = true;
            for input in &inputs()[1..] {
                send(&Message::Input(*input));
            }
            for event in stale.iter().skip(1) {
                send(&Message::Event(event.clone()));
            }
        }
        send(&frame.message);
        frame.boot_id = 0;
        *bytes = stated;
        true
    }
}

#[test]
fn the_run_that_a_board_was_amid_is_not_compared() {
    let verdict = verdict_of(&inputs(), amid_a_run());
    assert!(verdict.equal, "{verdict}");
    assert_eq!(verdict.digests, STEPS);
}

#[test]
fn the_run_that_a_board_was_amid_is_not_recorded() {
    let mut board = Board::robot_in_memory(robot(), amid_a_run());
    board.greet().unwrap();
    let mut parts = [Vec::new()];
    let mut rest = parts.iter_mut();
    let open = |_| rest.next().ok_or(std::io::ErrorKind::StorageFull.into());
    // It says nothing more once it is configured: silence ends the recording.
    let ended = record(&mut board, &config(), open, |_| true).unwrap_err();
    assert_eq!(ended.to_string(), "the board fell silent");
    let recording = read_from(parts[0].as_slice()).unwrap();
    let own = Config {
        source: Source::Board,
        ..config()
    };
    assert_eq!(recording.config, Some(own));
    assert!(recording.inputs.is_empty(), "{:?}", recording.inputs);
    assert!(recording.refusals.is_empty(), "{}", recording.refusals);
    assert!(
        matches!(
            recording.messages.as_slice(),
            [
                Message::Event(Event::Configured(_)),
                Message::Answer { refused: None, .. },
                // To the recorder's second greeting.
                Message::Boot(_),
                Message::Offsets(_),
                Message::Answer { refused: None, .. },
            ]
        ),
        "{:?}",
        recording.messages
    );
}

/// What a terminal that hears `bytes` says, and how many frames it found broken.
fn received(bytes: impl IntoIterator<Item = u8>) -> (Vec<Message>, u32) {
    let mut particles = Box::new(ParticleSet::<800>::new());
    let mut endpoint = DeviceEndpoint::new(Node::new(&mut particles), boot_on_host(800), 3);
    let mut stated = Vec::new();
    for byte in bytes {
        endpoint.receive(byte, &mut |frame, _| stated.extend_from_slice(frame));
    }
    let broken = endpoint.broken_frames();
    let events = decode_all(&stated)
        .into_iter()
        .map(|received| match received {
            Received::Frame {
                frame: Frame { message, .. },
                lost: 0,
            } if message.is_from_board() => message,
            other => panic!("{other:?}"),
        })
        .collect();
    (events, broken)
}

fn frames(inputs: &[Input]) -> Vec<Vec<u8>> {
    let mut encoder = Encoder::new(0xa5);
    inputs
        .iter()
        .map(|input| encoder.encode(input).to_vec())
        .collect()
}

/// Numbers of the answered inputs that were taken.
fn taken(events: &[Message]) -> Vec<u16> {
    events
        .iter()
        .filter_map(|event| match event {
            Message::Answer {
                input,
                refused: None,
            } => Some(*input),
            _ => None,
        })
        .collect()
}

fn digests(events: &[Message]) -> Vec<u32> {
    events
        .iter()
        .filter_map(|event| match event {
            Message::Event(Event::StepDone(done)) => Some(done.digest),
            _ => None,
        })
        .collect()
}

#[test]
fn f66_garbage_between_inputs_costs_none_of_them() {
    let good = frames(&inputs());
    let (clean, broken) = received(good.concat());
    assert_eq!(taken(&clean).len(), good.len());
    assert_eq!(digests(&clean).len(), STEPS);
    assert_eq!(broken, 0);
    for seed in 1..=3 {
        let mut random = Generator::seeded(seed);
        let mut noisy = Vec::new();
        for frame in &good {
            let length = uniform_below(&mut random, 700);
            noisy.extend((0..length).map(|_| random.bits() as u8));
            noisy.push(0);
            noisy.extend(frame);
        }
        let (events, broken) = received(noisy);
        assert_eq!(events, clean, "seed {seed}");
        assert!(broken > 0, "seed {seed}");
    }
}

#[test]
fn f66_garbage_that_runs_into_an_input_costs_that_input_alone() {
    let good = frames(&inputs());
    let (clean, _) = received(good.concat());
    // An odometry without which its neighbours say the same: the way is straight.
    let hit = 3;
    let mut noisy = good.clone();
    noisy[hit].insert(0, 0x55);
    let (events, broken) = received(noisy.concat());
    let expected: Vec<u16> = (0..good.len() as u16)
        .filter(|number| usize::from(*number) != hit)
        .collect();
    assert_eq!(taken(&events), expected);
    assert_eq!(digests(&events).len(), digests(&clean).len());
    assert_eq!(broken, 1);
}

#[test]
fn f66_hostile_frames_are_refused_and_change_nothing() {
    let good = frames(&inputs());
    let (clean, _) = received(good.concat());
    let bad_config = Config {
        particles_per_sensor: 0,
        ..config()
    };
    let too_many = Config {
        particles_per_sensor: u16::MAX,
        ..config()
    };
    let hostile = [
        Message::Input(Input::Configure(bad_config)),
        Message::Input(Input::Configure(too_many)),
        Message::Input(Input::Odometry {
            stamp_us: u64::MAX,
            pose: Pose::new(f32::NAN, f32::INFINITY, 0.0),
        }),
        Message::Input(Input::Proximity {
            stamp_us: u64::MAX,
            samples: [Sample::Counts(i32::MIN); 8],
        }),
        Message::Boot(boot_on_host(800)),
        Message::Event(Event::Configured(bad_config)),
        Message::Truth(TruthMessage::Seed(1)),
    ];
    let expected = [
        InputError::BadParameter,
        InputError::TooManyParticles,
        InputError::NotFinite,
        InputError::StalePose,
        InputError::NotAnInput,
        InputError::NotAnInput,
        InputError::NotAnInput,
    ];
    let mut other_board = Encoder::new(0x77);
    let bytes: Vec<u8> = good
        .iter()
        .flat_map(|frame| {
            let strange = hostile.iter().flat_map(|m| other_board.encode(m).to_vec());
            [frame.clone(), strange.collect()].concat()
        })
        .collect();
    let (events, broken) = received(bytes);
    assert_eq!(broken, 0);
    let (refused, rest): (Vec<Message>, Vec<Message>) = events.into_iter().partition(|event| {
        matches!(
            event,
            Message::Answer {
                refused: Some(_),
                ..
            }
        )
    });
    assert_eq!(rest, clean);
    assert_eq!(refused.len(), good.len() * hostile.len());
    // Once there is odometry, which the first two frames do not bring.
    for (number, event) in refused.iter().enumerate().skip(2 * hostile.len()) {
        let Message::Answer { refused, .. } = event else {
            panic!("{event:?}");
        };
        assert_eq!(*refused, Some(expected[number % hostile.len()]), "{number}");
    }
}

#[test]
fn f66_a_hundred_thousand_random_bytes_are_never_an_input() {
    let mut random = Generator::seeded(66);
    let (events, broken) = received((0..100_000).map(|_| random.bits() as u8));
    assert!(events.is_empty(), "{events:?}");
    assert!(broken > 300, "{broken}");
}
