//! Bad lines, slow hosts, hosts and boards that come and go: what is lost is counted.
//!
//! Names that begin with f60 to f6b are entries of the fault catalogue: the serial link.
//! With `IPF_LONG` set, hundred times as many frames are sent.

#![cfg(unix)]

use std::collections::{BTreeMap, VecDeque};
use std::fs::{self, File};
use std::io::{BufWriter, Read, Write};
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver as Inbox, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use amiro_ipf::filter::{Outcome, ParticleSet, Profile};
use amiro_ipf::geometry::Pose;
use amiro_ipf::link::{
    BoardStatus, Decoder, DeviceEndpoint, Encoder, Message, Priority, Received, Status,
};
use amiro_ipf::model::Sample;
use amiro_ipf::node::{
    Config, Event, Input, Node, ParticleEvent, Particles, Source, StepBegun, StepRule,
};
use amiro_ipf::random::{Generator, uniform_below};
use serialport::{SerialPort, TTYPort};
use sim_harness::device::{
    Board, FaultInjector, FrameTally, Interrupt, LineRun, LineTally, LinkError, LossStats,
    QemuOptions, RecordingEvent, boot_on_host, drive, record,
};
use sim_harness::drive::{FilterRecords, Record};
use sim_harness::evaluation::{Scores, Truth};
use sim_harness::geometry::Pose2;
use sim_harness::mapping::{CountingMapper, Mapper};
use sim_harness::world::{Options, Scenario, simulate_with};
use sim_harness::{log, run};
use tempfile::TempDir;

use crate::common;

/// Frames of one run over a line.
fn frames_to_send() -> u64 {
    if std::env::var_os("IPF_LONG").is_some() {
        10_000_000
    } else {
        100_000
    }
}

/// The frames that make up the stream of a robot, from 11 to 127 bytes.
fn messages() -> Vec<Message> {
    let outcome = |x: i16| ParticleEvent::new((100 * x, -400), Outcome::SurvivedPastGate);
    let particles = |count| {
        Message::Event(Event::Particles(Particles {
            step: 3,
            outcomes: (0..count).map(outcome).collect(),
        }))
    };
    let stamp_us = 1_000_000;
    let samples = [Sample::Counts(-110); 8];
    let pose = Pose::new(0.1, 0.2, 0.3);
    vec![
        Message::Hello,
        particles(38),
        Message::Status(Status::default()),
        particles(15),
        Message::Input(Input::Proximity { stamp_us, samples }),
        particles(38),
        Message::Event(Event::StepBegun(StepBegun {
            index: 7,
            stamp_us,
            pose,
            samples,
        })),
    ]
}

/// The message with this number; a status says how many went before it.
fn message(messages: &[Message], number: u64) -> Message {
    let mut message = messages[(number % messages.len() as u64) as usize].clone();
    if let Message::Status(status) = &mut message {
        status.board.sent_frames = number as u32;
    }
    message
}

/// A line with these faults.
fn line_with(words: &str, seed: u64) -> FaultInjector {
    FaultInjector::new(&format!("link={words}").parse().unwrap(), seed)
}

/// What came of a stream of [`messages`] on a line.
struct Crossing {
    /// As the host counts, closed with what the sender says.
    tally: FrameTally,
    /// As the line knows.
    line: LineTally,
    /// Sent and received, by a frame's bytes.
    by_length: BTreeMap<usize, (u64, u64)>,
}

/// Sends frames over a line and checks that each that is accepted was really sent.
fn cross(faults: &str, seed: u64, frames: u64) -> Crossing {
    let messages = messages();
    let mut line = line_with(faults, seed);
    let mut encoder = Encoder::new(9);
    let mut decoder = Decoder::new();
    let mut loss_stats = LossStats::since_boot(9);
    let mut by_length = BTreeMap::<usize, (u64, u64)>::new();
    // By sequence number.
    let mut lengths = vec![0; 1 << 16];
    let mut take = |bytes: Vec<u8>,
                    newest: u64,
                    lengths: &[usize],
                    by_length: &mut BTreeMap<usize, (u64, u64)>| {
        for received in bytes.iter().filter_map(|byte| decoder.push(*byte)) {
            loss_stats.take(&received);
            let Received::Frame { frame, .. } = received else {
                continue;
            };
            assert_eq!(frame.boot_id, 9, "{faults}, seed {seed}: false accept");
            // The newest frame of this number: nothing is underway for longer.
            let age = u64::from((newest as u16).wrapping_sub(frame.sequence));
            assert_eq!(
                frame.message,
                message(&messages, newest - age),
                "{faults}, seed {seed}: false accept"
            );
            let bytes = lengths[usize::from(frame.sequence)];
            by_length.entry(bytes).or_default().1 += 1;
        }
    };
    for number in 0..frames {
        let frame = encoder.encode(&message(&messages, number));
        lengths[usize::from(number as u16)] = frame.len();
        by_length.entry(frame.len()).or_default().0 += 1;
        line.send(frame, Duration::ZERO);
        take(
            line.receive(Duration::MAX),
            number,
            &lengths,
            &mut by_length,
        );
    }
    line.flush(Duration::ZERO);
    take(
        line.receive(Duration::MAX),
        frames - 1,
        &lengths,
        &mut by_length,
    );
    loss_stats.close(frames);
    Crossing {
        tally: loss_stats.tally(),
        line: line.tally(),
        by_length,
    }
}

/// The sum rule, and that the host's figures are the line's own.
fn assert_balanced(crossing: &Crossing, faults: &str) {
    let Crossing { tally, line, .. } = crossing;
    tally.balance(line.sent).unwrap();
    assert_eq!(tally.received, line.whole, "{faults}: {tally}, {line:?}");
    assert_eq!(
        tally.lost,
        line.damaged + line.lost,
        "{faults}: {tally}, {line:?}"
    );
}

#[test]
fn f60_bit_errors_deliver_what_the_frames_lengths_allow_and_accept_nothing_false() {
    for (seed, rate) in [(1, 1e-5), (2, 1e-4), (3, 1e-3), (4, 1e-2)] {
        let faults = format!("ber:{rate}");
        let crossing = cross(&faults, seed, frames_to_send());
        assert_balanced(&crossing, &faults);
        // The first statuses are shorter than the rest, and too few to say anything.
        let often = |(_, (sent, _)): &(usize, (u64, u64))| *sent > 1000;
        for (bytes, (sent, received)) in crossing.by_length.into_iter().filter(often) {
            // Its own bits, the zero byte behind it, and the one in front of it.
            let expected = (1.0_f64 - rate).powf(8.0 * (bytes + 1) as f64);
            let share = received as f64 / sent as f64;
            // Four standard deviations; the catalogue allows two points below.
            let bound = 4.0 * (expected * (1.0 - expected) / sent as f64).sqrt();
            let difference = (share - expected).abs();
            assert!(
                difference < bound.min(0.02),
                "{faults}, {bytes} bytes: {share} arrived, {expected} expected"
            );
        }
    }
}

#[test]
fn f61_to_f63_what_is_cut_dropped_mixed_with_garbage_or_late_is_counted_to_the_frame() {
    let frames = frames_to_send() / 10;
    for faults in [
        "cut:0.05",
        "drop:1e-4",
        "drop:1e-4x300",
        "garbage:1e-3x200",
        "garbage:1e-5x50000",
        "lose:0.3",
        "off@1000B..500000B",
        "swap:0.2",
        "twice:0.2",
        "slow:9600+delay:20ms+ber:1e-4",
        "lose:0.05+swap:0.1+twice:0.1+cut:0.02+drop:1e-4x50+garbage:1e-4+ber:1e-4",
    ] {
        for seed in 1..=3 {
            let crossing = cross(faults, seed, frames);
            let line = crossing.line;
            assert_balanced(&crossing, &format!("{faults}, seed {seed}"));
            let is_harmless = faults == "swap:0.2" || faults == "twice:0.2";
            assert_eq!(line.whole == line.sent, is_harmless, "{faults}: {line:?}");
        }
    }
}

#[test]
fn f68_repeated_and_reordered_frames_change_no_event() {
    let config = Config {
        particles_per_sensor: 100,
        ..Config::amiro(Profile::Plus)
    };
    let mut clean = Vec::new();
    let mut line = |faults: &str, seed| {
        let mut line = LineRun::new(line_with(faults, seed));
        let mut came = Vec::new();
        let mut arrive = |event: &Event| came.push(event.clone());
        clean.clear();
        run(&config, &inputs(400), |event| {
            clean.push(event.clone());
            line.send(event, &mut arrive);
        })
        .unwrap();
        let outcome = line.finish(&mut arrive);
        outcome.frames.balance(outcome.line.sent).unwrap();
        assert!(came == clean, "{faults}, seed {seed}: events differ");
        outcome.frames
    };
    for seed in 1..=3 {
        assert!(line("twice:0.5", seed).repeated > 100);
        line("swap:0.3", seed);
        line("swap:0.3+twice:0.3", seed);
    }
}

/// A wall on the left, driven along at 80 mm/s with the sensors at 125 Hz.
fn inputs(rows: u64) -> Vec<Input> {
    (0..rows)
        .flat_map(|row| {
            let stamp_us = row * 8_000;
            let pose = Pose::new(row as f32 * 0.64e-3, 0.0, 0.0);
            let mut samples = [Sample::Counts(3); 8];
            samples[1] = Sample::Counts(110);
            samples[2] = Sample::Counts(100);
            [
                Input::Odometry { stamp_us, pose },
                Input::Proximity { stamp_us, samples },
            ]
        })
        .collect()
}

#[test]
fn f60_a_map_from_a_line_with_a_bit_error_in_a_thousand_is_within_a_point_of_the_clean_one() {
    let scenarios: &[&str] = if std::env::var_os("IPF_LONG").is_some() {
        &["msm_t", "msm_l"]
    } else {
        &["msm_t"]
    };
    for name in scenarios {
        let path = format!("{}/../scenarios/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let scenario = Scenario::load(Path::new(&path)).unwrap();
        for (seed, profile) in [(100, Profile::Paper), (101, Profile::Plus)] {
            let inputs = simulate_with(&scenario, seed, &Options::default()).inputs;
            let config = Config {
                seed,
                ..scenario.config(profile)
            };
            let error_of = |faults: &str| {
                let mut line = LineRun::new(line_with(faults, seed));
                let mut came = Vec::new();
                let mut arrive = |event: &Event| came.push(event.clone());
                run(&config, &inputs, |event| line.send(event, &mut arrive)).unwrap();
                let outcome = line.finish(&mut arrive);
                outcome.frames.balance(outcome.line.sent).unwrap();
                let poses: Vec<Pose2> = came.iter().filter_map(pose_of).collect();
                let truth = Truth::of(&scenario, &poses);
                let mut mapper = CountingMapper::new(scenario.cell_m);
                let mut records = FilterRecords::new(&config);
                let mut take = |record: &Record| mapper.take(record);
                came.iter()
                    .for_each(|event| records.translate(event, &mut take));
                let scores = Scores::of(&mapper.map(), &truth);
                let share = outcome.frames.received as f64 / outcome.frames.sent as f64;
                (scores.oe.unwrap(), share)
            };
            let (clean, all) = error_of("ok");
            let (disturbed, share) = error_of("ber:1e-3");
            assert!(all > 0.9999, "{all} arrived on a good line");
            assert!((0.3..0.5).contains(&share), "{share} arrived");
            assert!(
                disturbed <= clean + 0.01,
                "{name}, {profile:?}, seed {seed}: OE {disturbed}, clean {clean}"
            );
        }
    }
}

fn pose_of(event: &Event) -> Option<Pose2> {
    match event {
        Event::StepBegun(step) => Some(step.pose.into()),
        _ => None,
    }
}

/// A board on the host: the terminal of the flash image and its queue of 255 frames, of
/// which details leave 24, behind a line of so many bytes a beat.
struct SlowBoard {
    endpoint: DeviceEndpoint<'static, 800>,
    queue: VecDeque<Vec<u8>>,
    /// Bytes that the line had time for and that no frame took yet.
    credit: usize,
    sent: u64,
    status: BoardStatus,
}

impl SlowBoard {
    fn new(boot_id: u8) -> Self {
        // One of a handful in the whole program.
        let particles = Box::leak(Box::new(ParticleSet::new()));
        let mut endpoint = DeviceEndpoint::new(Node::new(particles), boot_on_host(800), boot_id);
        let (mut queue, mut sent, mut status) = (VecDeque::new(), 0, BoardStatus::default());
        endpoint.introduce(&mut |frame, priority| {
            enqueue(&mut queue, &mut sent, &mut status, frame, priority);
        });
        Self {
            endpoint,
            queue,
            credit: 0,
            sent,
            status,
        }
    }

    /// Does something with the terminal; what it says is queued.
    fn with<T>(
        &mut self,
        work: impl FnOnce(&mut DeviceEndpoint<'static, 800>, &mut dyn FnMut(&[u8], Priority)) -> T,
    ) -> T {
        let Self {
            endpoint,
            queue,
            sent,
            status,
            ..
        } = self;
        work(endpoint, &mut |frame, priority| {
            enqueue(queue, sent, status, frame, priority);
        })
    }

    fn inject(&mut self, input: &Input) {
        self.with(|endpoint, mut send| endpoint.inject(input, &mut send));
    }

    fn report(&mut self) {
        let status = self.status;
        self.with(|endpoint, mut send| endpoint.report(status, &mut send));
    }

    /// The whole frames that are out after so many more bytes' time.
    fn frames_of(&mut self, bytes: usize) -> Vec<u8> {
        self.credit = self.credit.saturating_add(bytes);
        let mut out = Vec::new();
        while let Some(frame) = self.queue.front()
            && frame.len() <= self.credit
        {
            self.credit -= frame.len();
            out.extend(self.queue.pop_front().unwrap());
        }
        if self.queue.is_empty() {
            self.credit = 0;
        }
        out
    }
}

fn enqueue(
    queue: &mut VecDeque<Vec<u8>>,
    sent: &mut u64,
    status: &mut BoardStatus,
    frame: &[u8],
    priority: Priority,
) {
    *sent += 1;
    let reserve = match priority {
        Priority::BestEffort => 24,
        Priority::Reliable => 0,
    };
    if 255 - queue.len() > reserve {
        queue.push_back(frame.to_vec());
        status.sent_frames += 1;
    } else {
        status.dropped_frames += 1;
    }
}

fn robot_config() -> Config {
    Config {
        particles_per_sensor: 100,
        source: Source::Board,
        ..Config::amiro(Profile::Paper)
    }
}

#[test]
fn f65_frames_dropped_by_a_slow_line_and_lost_by_a_bad_one_are_counted_separately() {
    for (faults, bytes_a_row) in [
        ("ok", 100_000),
        ("ok", 80),
        ("ok", 60),
        ("ber:1e-4", 80),
        ("drop:1e-3x20", 60),
        ("lose:0.5", 80),
    ] {
        let place = format!("{faults}, {bytes_a_row} bytes a row");
        let mut line = line_with(faults, 65);
        let mut board = SlowBoard::new(3);
        let mut decoder = Decoder::new();
        let mut loss_stats = LossStats::since_boot(3);
        let mut take = |bytes: Vec<u8>| {
            for received in bytes.iter().filter_map(|byte| decoder.push(*byte)) {
                loss_stats.take(&received);
            }
            loss_stats.clone()
        };
        board.inject(&Input::Configure(robot_config()));
        for (row, input) in inputs(2000).iter().enumerate() {
            board.inject(input);
            if row % 16 == 0 {
                board.report();
            }
            line.send(&board.frames_of(bytes_a_row), Duration::ZERO);
            take(line.receive(Duration::MAX));
        }
        // The line becomes good and quick: everything that waits arrives, and a status
        // says what was dropped.
        let damage = line.tally();
        let mut good = line_with("ok", 1);
        // The end of what was half delivered.
        take(vec![0]);
        board.report();
        good.send(&board.frames_of(usize::MAX), Duration::ZERO);
        board.report();
        good.send(&board.frames_of(usize::MAX), Duration::ZERO);
        let tally = take(good.receive(Duration::MAX)).tally();
        tally.balance(board.sent).unwrap();
        assert_eq!(
            tally.dropped,
            u64::from(board.status.dropped_frames),
            "{place}"
        );
        assert_eq!(tally.dropped > 0, bytes_a_row < 100_000, "{place}: {tally}");
        let lost = damage.damaged + damage.lost;
        assert_eq!(lost > 0, faults != "ok", "{place}");
        assert_eq!(tally.lost, lost, "{place}: {tally}, {damage:?}");
    }
}

#[test]
fn f60_a_board_behind_a_bad_line_is_balanced_whatever_ended_the_run() {
    let mut lost = 0;
    for seed in 1..=4 {
        let faults = ["ok", "ber:1e-5", "lose:1e-3", "ber:2e-6+drop:1e-5x200"][seed as usize - 1];
        let line = |faults: &str| line_with(faults, seed);
        let mut board = Board::in_memory(|_| true).behind(line("ok"), line(faults));
        board.greet().unwrap();
        let (_, before) = board.line_tallies().unwrap();
        let config = Config {
            source: Source::Link,
            ..robot_config()
        };
        let all = [vec![Input::Configure(config)], inputs(400)].concat();
        // An answer may be lost: the run ends at its deadline, and the account stays.
        match drive(&mut board, &all, |_| (), |_, _| ()) {
            Ok(_) | Err(LinkError::NoAnswer { .. }) => {}
            Err(error) => panic!("{faults}: {error}"),
        }
        board.greet().ok();
        let tally = board.tally();
        let (_, line) = board.line_tallies().unwrap();
        tally.balance(tally.sent).unwrap();
        assert!(line.sent > before.sent, "{faults}");
        assert_eq!(line.whole + line.damaged + line.lost, line.sent, "{faults}");
        lost += line.damaged + line.lost;
    }
    assert!(lost > 0);
}

/// What a test tells the robot behind a pseudo terminal.
enum Order {
    /// Goes through a reset and comes back under this boot id.
    Reset(u8),
    /// The device node goes away; the robot goes on.
    Vanish,
    /// A new device node comes.
    Appear,
    /// From now on noise instead of frames.
    Noise,
}

/// A robot on a thread, at the other end of a pseudo terminal that a link names.
struct Robot {
    port: PathBuf,
    orders: Sender<Order>,
}

impl Robot {
    fn start(name: &str) -> Self {
        let port = std::env::temp_dir().join(format!("ipf-{name}-{}", std::process::id()));
        let (orders, inbox) = channel();
        let master = plug(&port);
        let path = port.clone();
        thread::spawn(move || live(&path, master, &inbox));
        Self { port, orders }
    }

    fn order(&self, order: Order) {
        self.orders.send(order).unwrap();
    }

    fn name(&self) -> &str {
        self.port.to_str().unwrap()
    }
}

impl Drop for Robot {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.port);
    }
}

/// A new pseudo terminal under this name.
fn plug(port: &Path) -> TTYPort {
    let (mut master, slave) = TTYPort::pair().unwrap();
    master.set_timeout(Duration::from_millis(1)).unwrap();
    let _ = fs::remove_file(port);
    symlink(slave.name().unwrap(), port).unwrap();
    master
}

/// A robot's life: a row of readings every 5 ms, a status every 40 ms.
fn live(port: &Path, master: TTYPort, orders: &Inbox<Order>) {
    let mut master = Some(master);
    let mut board = SlowBoard::new(1);
    let mut noise = None::<Generator>;
    let mut rows = inputs(100_000).into_iter();
    let start = Instant::now();
    for turn in 0.. {
        match orders.try_recv() {
            Ok(Order::Reset(boot_id)) => {
                board = SlowBoard::new(boot_id);
                rows = inputs(100_000).into_iter();
            }
            Ok(Order::Vanish) => {
                master = None;
                let _ = fs::remove_file(port);
            }
            Ok(Order::Appear) => master = Some(plug(port)),
            Ok(Order::Noise) => noise = Some(Generator::seeded(67)),
            Err(std::sync::mpsc::TryRecvError::Empty) => {}
            Err(std::sync::mpsc::TryRecvError::Disconnected) => return,
        }
        for input in rows.by_ref().take(2) {
            board.inject(&input);
        }
        if turn % 8 == 0 {
            board.status.uptime_ms = start.elapsed().as_millis() as u64;
            board.report();
        }
        let mut received = [0; 4096];
        let count = master
            .as_mut()
            .map_or(0, |master| master.read(&mut received).unwrap_or(0));
        for byte in &received[..count] {
            board.with(|endpoint, mut send| endpoint.receive(*byte, &mut send));
        }
        let mut said = board.frames_of(4000);
        if let Some(random) = &mut noise {
            said.iter_mut().for_each(|byte| *byte = random.bits() as u8);
        }
        if let Some(master) = &mut master {
            // Nobody may listen.
            let _ = master.write_all(&said);
        }
        thread::sleep(Duration::from_millis(5));
    }
}

/// A folder for recordings; removed when dropped.
struct Folder(TempDir);

impl Folder {
    fn new(name: &str) -> Self {
        Self(common::own_folder(name))
    }

    fn part(&self, part: u32) -> PathBuf {
        self.0.path().join(format!("{part}.ipf"))
    }

    fn open(&self, part: u32) -> std::io::Result<BufWriter<File>> {
        Ok(BufWriter::new(File::create(self.part(part))?))
    }
}

/// That a recording begins with its configuration and its inputs step the filter again.
fn assert_replays(path: &Path) -> usize {
    let recording = log::read(path).unwrap();
    let config = Config {
        source: Source::Link,
        ..recording.config.unwrap()
    };
    let outcome = run(&config, &recording.inputs, |_| ()).unwrap();
    assert!(outcome.steps > 0, "{}", path.display());
    recording.inputs.len()
}

#[test]
fn f6b_a_device_node_that_vanishes_is_waited_for_and_the_recording_goes_on() {
    let (robot, folder) = (Robot::start("f6b"), Folder::new("f6b"));
    let mut board = Board::on_port(robot.name(), 2_000_000).unwrap();
    board.greet().unwrap();
    let mut statuses = 0;
    let mut asked_while_away = 0;
    let mut messages = Vec::new();
    let mut gone_at = None;
    let parts = record(
        &mut board,
        &robot_config(),
        |part| folder.open(part),
        |event| {
            match event {
                RecordingEvent::Message(Message::Status(_)) => {
                    statuses += 1;
                    if statuses == 10 {
                        robot.order(Order::Vanish);
                    }
                }
                RecordingEvent::Message(_) | RecordingEvent::Input(_) | RecordingEvent::Waiting => {
                }
                RecordingEvent::Away => {
                    asked_while_away += 1;
                    if asked_while_away == 10 {
                        robot.order(Order::Appear);
                    }
                }
                RecordingEvent::Vanished(error) => {
                    gone_at = Some(Instant::now());
                    messages.push(error.to_string());
                }
                other => messages.push(format!("{other:?}")),
            }
            statuses < 30
        },
    )
    .unwrap();
    assert_eq!(parts, 1);
    // Told from silence, and told once.
    assert_eq!(messages.len(), 2, "{messages:?}");
    assert_eq!(messages[1], "Back");
    // Ten times a second; waits of 0.2, 0.4, 0.8, 1.6 s.
    assert!((10..=50).contains(&asked_while_away), "{asked_while_away}");
    assert!(gone_at.unwrap().elapsed() < Duration::from_secs(10));
    let tally = board.tally();
    tally.balance(tally.sent).unwrap();
    assert!(tally.lost + tally.dropped > 0, "{tally}");
    assert!(assert_replays(&folder.part(1)) > 100);
}

#[test]
fn f6b_waiting_for_a_device_node_ends_within_a_fifth_of_a_second() {
    let (robot, folder) = (Robot::start("f6b-end"), Folder::new("f6b-end"));
    let mut board = Board::on_port(robot.name(), 2_000_000).unwrap();
    board.greet().unwrap();
    let load = Load::measure();
    let mut last_asked = None;
    let mut longest = Duration::ZERO;
    let mut since = None;
    record(
        &mut board,
        &robot_config(),
        |part| folder.open(part),
        |event| match event {
            RecordingEvent::Message(Message::Status(_)) => {
                if since.is_none() {
                    robot.order(Order::Vanish);
                }
                true
            }
            RecordingEvent::Message(_) | RecordingEvent::Input(_) | RecordingEvent::Waiting => true,
            _ => {
                let now = Instant::now();
                if let Some(last) = last_asked.replace(now) {
                    longest = longest.max(now - last);
                }
                now - *since.get_or_insert(now) < Duration::from_millis(1500)
            }
        },
    )
    .unwrap();
    let delay = load.longest_delay();
    assert!(
        longest < Duration::from_millis(200) + delay,
        "{longest:?}, of which this machine's {delay:?}"
    );
    assert!(assert_replays(&folder.part(1)) > 0);
}

#[test]
fn f6a_a_board_that_is_reset_begins_another_part_and_the_first_one_stays() {
    let (robot, folder) = (Robot::start("f6a"), Folder::new("f6a"));
    let mut board = Board::on_port(robot.name(), 2_000_000).unwrap();
    board.greet().unwrap();
    let mut statuses = 0;
    let mut said = Vec::new();
    let parts = record(
        &mut board,
        &robot_config(),
        |part| folder.open(part),
        |event| match event {
            RecordingEvent::Message(Message::Status(_)) => {
                statuses += 1;
                if statuses == 10 {
                    robot.order(Order::Reset(2));
                }
                statuses < 30
            }
            RecordingEvent::Message(_) | RecordingEvent::Input(_) | RecordingEvent::Waiting => true,
            other => {
                said.push(format!("{other:?}"));
                true
            }
        },
    )
    .unwrap();
    assert_eq!(
        (parts, said.as_slice()),
        (2, &["Restarted { part: 2 }".to_owned()][..])
    );
    for part in 1..=2 {
        assert!(assert_replays(&folder.part(part)) > 20, "part {part}");
        let bytes = fs::read(folder.part(part)).unwrap();
        let mut decoder = Decoder::new();
        for received in bytes.iter().filter_map(|byte| decoder.push(*byte)) {
            if let Received::Frame { frame, .. } = received {
                let is_in_place = frame.boot_id == 0xa5 || u32::from(frame.boot_id) == part;
                assert!(is_in_place, "boot {} in part {part}", frame.boot_id);
            }
        }
    }
}

#[test]
fn f67_a_wrong_baud_rate_is_named_within_three_seconds() {
    let robot = Robot::start("f67");
    robot.order(Order::Noise);
    let mut board = Board::on_port(robot.name(), 115_200).unwrap();
    let start = Instant::now();
    let error = board.greet().unwrap_err();
    assert!(matches!(error, LinkError::MostlyNoise), "{error}");
    assert!(error.to_string().contains("wrong baud rate"), "{error}");
    assert!(start.elapsed() < Duration::from_secs(3));
}

#[test]
fn f67_noise_in_the_middle_of_a_recording_is_named_within_four_seconds() {
    let (robot, folder) = (Robot::start("f67-mid"), Folder::new("f67-mid"));
    let mut board = Board::on_port(robot.name(), 115_200).unwrap();
    board.greet().unwrap();
    let mut noisy_since = None;
    let mut named_after = None;
    record(
        &mut board,
        &robot_config(),
        |part| folder.open(part),
        |event| match event {
            RecordingEvent::Message(Message::Status(status)) => {
                if status.node.steps > 2 && noisy_since.is_none() {
                    robot.order(Order::Noise);
                    noisy_since = Some(Instant::now());
                }
                true
            }
            RecordingEvent::MostlyNoise => {
                named_after = noisy_since.map(|since| since.elapsed());
                false
            }
            _ => true,
        },
    )
    .unwrap();
    let after = named_after.unwrap();
    assert!(after < Duration::from_secs(4), "{after:?}");
}

/// Measures how long this machine delays a thread: work of others is not the program's
/// fault.
struct Load {
    is_over: Arc<AtomicBool>,
    delays: thread::JoinHandle<Duration>,
}

impl Load {
    fn measure() -> Self {
        let is_over = Arc::new(AtomicBool::new(false));
        let end = Arc::clone(&is_over);
        let delays = thread::spawn(move || {
            const NAP: Duration = Duration::from_millis(5);
            let mut longest = Duration::ZERO;
            while !end.load(Ordering::Relaxed) {
                let start = Instant::now();
                thread::sleep(NAP);
                longest = longest.max(start.elapsed() - NAP);
            }
            longest
        });
        Self { is_over, delays }
    }

    /// Three times the longest delay of a nap: what is measured wakes as often in a row,
    /// after its sleep, to open the port and to be waited for.
    fn longest_delay(self) -> Duration {
        self.is_over.store(true, Ordering::Relaxed);
        3 * self.delays.join().unwrap()
    }
}

/// Not a test: the process that the next test interrupts, when it says so.
#[test]
#[ignore = "the other half of f6b_an_interrupt"]
fn recording_process() {
    let (Some(port), Some(out)) = (std::env::var_os("IPF_PORT"), std::env::var_os("IPF_OUT"))
    else {
        return;
    };
    let interrupt = Interrupt::on_signals().unwrap();
    let board = Board::on_port(port.to_str().unwrap(), 2_000_000).unwrap();
    let mut board = board.ended_by(interrupt);
    board.greet().unwrap();
    let open = |_| Ok(BufWriter::new(File::create(&out)?));
    record(&mut board, &robot_config(), open, |_| true).unwrap();
}

#[test]
fn f6b_an_interrupt_ends_a_recording_at_once_and_leaves_a_file_that_replays() {
    let (robot, folder) = (Robot::start("interrupt"), Folder::new("interrupt"));
    // The last two as in the background of a script: its shell has interrupts ignored.
    let cases = [
        (1, "", false),
        (2, "trap '' INT;", false),
        (3, "trap '' INT;", true),
    ];
    for (place, trap, is_away) in cases {
        let out = folder.part(place);
        let script = format!(
            "{trap} exec \"$0\" --exact link_stress::recording_process --ignored --nocapture"
        );
        let mut child = Command::new("sh")
            .args(["-c", &script])
            .arg(std::env::current_exe().unwrap())
            .env("IPF_PORT", &robot.port)
            .env("IPF_OUT", &out)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let start = Instant::now();
        while fs::metadata(&out).map_or(0, |file| file.len()) < 10_000 {
            assert!(
                start.elapsed() < Duration::from_secs(30),
                "nothing recorded"
            );
            thread::sleep(Duration::from_millis(10));
        }
        if is_away {
            robot.order(Order::Vanish);
            thread::sleep(Duration::from_millis(700));
        }
        let load = Load::measure();
        let start = Instant::now();
        let signal = ["-INT".to_owned(), child.id().to_string()];
        assert!(
            Command::new("kill")
                .args(signal)
                .status()
                .unwrap()
                .success()
        );
        while child.try_wait().unwrap().is_none() && start.elapsed() < Duration::from_secs(5) {
            thread::sleep(Duration::from_millis(5));
        }
        let waited = start.elapsed();
        let _ = child.kill();
        let status = child.wait().unwrap();
        let delay = load.longest_delay();
        assert!(
            waited < Duration::from_millis(200) + delay,
            "{waited:?}, of which this machine's {delay:?}"
        );
        assert!(status.success(), "{status}: it did not end in order");
        assert!(assert_replays(&out) > 20);
        // At most the frame at the end is cut.
        let refused = log::read(&out).unwrap().refusals;
        assert!(refused.count() <= 1, "{refused}");
    }
}

/// An image that counts instructions, so that a board's millisecond is exact.
fn counting() -> QemuOptions {
    QemuOptions {
        count_instructions: true,
        ..QemuOptions::default()
    }
}

/// A configuration with its own clock and one reading: a step every 125 ms.
fn own_clock() -> Vec<Input> {
    let config = Config {
        step_rule: StepRule::PerTick { own_clock: true },
        source: Source::Link,
        ..Config::amiro(Profile::Plus)
    };
    [vec![Input::Configure(config)], inputs(1)].concat()
}

/// Lets a board step by its own clock.
fn start_own_clock(board: &mut Board) {
    drive(
        board,
        &own_clock(),
        |_| (),
        |input, refused| {
            assert_eq!(refused, None, "input {input}");
        },
    )
    .unwrap();
}

fn next_status(board: &mut Board) -> Status {
    loop {
        if let Message::Status(status) = board.next_message().unwrap() {
            return status;
        }
    }
}

/// The sum rule on a sound line: as many frames came as the board says it has sent.
fn assert_nothing_lost(board: &Board) {
    let tally = board.tally();
    tally.balance(tally.sent).unwrap();
    assert_eq!(
        (tally.lost, tally.dropped, tally.broken),
        (0, 0, 0),
        "{tally}"
    );
}

#[test]
fn f46_a_flood_of_garbage_delays_no_status_of_the_board() {
    let Some(image) = common::image() else { return };
    let mut board = Board::in_qemu(image, &counting()).unwrap();
    board.greet().unwrap();
    start_own_clock(&mut board);
    let mut random = Generator::seeded(66);
    let mut before = next_status(&mut board);
    let first = before;
    // Fifty kilobytes, a fifth of them at a time, between statuses.
    for _ in 0..5 {
        let flood: Vec<u8> = (0..10_000)
            .map(|_| uniform_below(&mut random, 256) as u8)
            .collect();
        board.send_raw(&flood).unwrap();
        for _ in 0..2 {
            let status = next_status(&mut board);
            let gap_ms = status.board.uptime_ms - before.board.uptime_ms;
            assert!((124..=126).contains(&gap_ms), "{gap_ms} ms: {status:?}");
            before = status;
        }
    }
    board.send_raw(&[0]).unwrap();
    for _ in 0..8 {
        before = next_status(&mut board);
    }
    assert_eq!(before.board.overruns, 0, "{before:?}");
    assert_eq!(before.node.steps - first.node.steps, 18, "{before:?}");
    let broken = before.board.broken_frames - first.board.broken_frames;
    // A zero byte in 256: about 195 pieces. The emulator's line is as fast as the core
    // reads it, so that a flood in a step may fill the queue: its bytes are counted.
    assert!(broken > 100, "{before:?}");
    assert_nothing_lost(&board);
}

#[test]
fn f64_a_host_that_was_away_finds_a_status_within_an_eighth_of_a_second_when_it_is_back() {
    let Some(image) = common::image() else { return };
    let options = QemuOptions {
        can_disconnect: true,
        ..counting()
    };
    let mut board = Board::in_qemu(image, &options).unwrap();
    board.greet().unwrap();
    start_own_clock(&mut board);
    let left = next_status(&mut board);
    // The emulator's time runs about as quickly as this host's.
    let away_ms = if std::env::var_os("IPF_LONG").is_some() {
        60_000
    } else {
        6_000
    };
    let enough_ms = left.board.uptime_ms + away_ms;
    board.disconnect();
    // How quickly exactly, it says itself: calls until it has been long enough.
    thread::sleep(Duration::from_millis(away_ms));
    // A busy host's emulator runs slower.
    let deadline = Instant::now() + Duration::from_millis(90_000 + 4 * away_ms);
    let back = loop {
        thread::sleep(Duration::from_secs(2));
        board.reconnect().unwrap();
        // Before the first status no more than one beat's steps begin.
        let mut begun = 0;
        let status = loop {
            match board.next_message() {
                Ok(Message::Status(status)) => break status,
                Ok(Message::Event(Event::StepBegun(_))) => begun += 1,
                Err(LinkError::Silent) if Instant::now() < deadline => {}
                other => _ = other.unwrap(),
            }
        };
        assert!(begun <= 1, "{begun} steps before the first status");
        if status.board.uptime_ms >= enough_ms {
            break status;
        }
        assert!(
            Instant::now() < deadline,
            "only {} ms",
            status.board.uptime_ms
        );
        board.disconnect();
    };
    // It never waited: a step each 125 ms, none late, none skipped.
    let away_ms = back.board.uptime_ms - left.board.uptime_ms;
    let steps = u64::from(back.node.steps - left.node.steps);
    assert_eq!(steps, away_ms / 125, "{back:?}");
    assert_eq!(back.board.overruns, 0, "{back:?}");
    let next = next_status(&mut board);
    let gap_ms = next.board.uptime_ms - back.board.uptime_ms;
    assert!((124..=126).contains(&gap_ms), "{gap_ms} ms");
    let tally = board.tally();
    tally.balance(tally.sent).unwrap();
    assert!(tally.lost > 0, "{tally}");
}
