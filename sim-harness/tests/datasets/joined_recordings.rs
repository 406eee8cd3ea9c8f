//! Recordings that were joined: the first run is read, and a notice says where another
//! one begins.

use amiro_ipf::filter::Profile;
use amiro_ipf::geometry::Pose;
use amiro_ipf::link::{DeviceEndpoint, Encoder, TruthMessage};
use amiro_ipf::model::Sample;
use amiro_ipf::node::{Config, Event, Input};
use amiro_ipf::{filter::ParticleSet, node::Node};
use sim_harness::device::boot_on_host;
use sim_harness::log::{Place, Reason, Recording, RecordingWriter, read_from};
use sim_harness::world::Scenario;

const HEADER: &str = "PRV 0\tPRV 1\tPRV 2\tPRV 3\tPRV 4\tPRV 5\tPRV 6\tPRV 7\t\
                      X [ym]\tY [ym]\tTheta [yrad]\n";

const SSSO: &str = include_str!("../../../scenarios/ssso.toml");
const MSOD: &str = include_str!("../../../scenarios/msod.toml");

fn config() -> Config {
    Config {
        particles_per_sensor: 100,
        ..Config::amiro(Profile::Paper)
    }
}

fn drive() -> Vec<Input> {
    let rows = (0..=30_u64).flat_map(|row| {
        let stamp_us = row * 25_000;
        let pose = Pose::new(row as f32 * 2e-3, 0.0, 0.0);
        let samples = [Sample::Counts(100); 8];
        [
            Input::Odometry { stamp_us, pose },
            Input::Proximity { stamp_us, samples },
        ]
    });
    rows.collect()
}

/// A recording as the simulator writes it: the truth, the configuration, the inputs with
/// the true poses among them.
fn simulated(scenario: &str, seed: u64) -> Vec<u8> {
    let mut writer = RecordingWriter::new(Vec::new()).unwrap();
    writer.write_truth(&TruthMessage::Seed(seed)).unwrap();
    writer.write_scenario(scenario).unwrap();
    writer.write_input(&Input::Configure(config())).unwrap();
    for input in drive() {
        writer.write_input(&input).unwrap();
        if let Input::Odometry { stamp_us, pose } = input {
            writer
                .write_truth(&TruthMessage::Pose { stamp_us, pose })
                .unwrap();
        }
    }
    writer.finish().unwrap()
}

/// A recording as `record` writes it: the host's only frame is its configuration, behind it
/// stand the board's frames, the inputs that it read itself among them. The second one of
/// the same boot lacks the frame that says that the configuration was taken.
fn two_of_one_boot() -> [Vec<u8>; 2] {
    let mut board = Encoder::new(7);
    let halves = drive();
    let (first, second) = halves.split_at(halves.len() / 2);
    [(first, true), (second, false)].map(|(inputs, has_configured)| {
        let mut writer = RecordingWriter::new(Vec::new()).unwrap();
        writer.write_input(&Input::Configure(config())).unwrap();
        let configured = board.encode(&Event::Configured(config()));
        if has_configured {
            writer.write_frames(configured).unwrap();
        }
        for input in inputs {
            writer.write_frames(board.encode(input)).unwrap();
        }
        writer.finish().unwrap()
    })
}

/// A recording of a board: the host's configuration, and what the board sends after it.
fn of_a_board() -> Vec<u8> {
    let mut particles = ParticleSet::<800>::new();
    let mut terminal = DeviceEndpoint::new(Node::new(&mut particles), boot_on_host(800), 7);
    let mut host = Encoder::new(0xa5);
    let mut sent = Vec::new();
    let all = [vec![Input::Configure(config())], drive()].concat();
    for input in &all {
        for byte in host.encode(input) {
            terminal.receive(*byte, &mut |frame, _| sent.extend_from_slice(frame));
        }
    }
    let mut writer = RecordingWriter::new(Vec::new()).unwrap();
    for input in &all {
        writer.write_input(input).unwrap();
    }
    writer.write_frames(&sent).unwrap();
    writer.finish().unwrap()
}

fn text(rows: i64) -> String {
    let row = |index: i64| {
        let x = 100_000 + 8_000 * index;
        format!("0\t110\t108\t0\t0\t3\t{index}\t0\t{x}\t-1280\t6282240\n")
    };
    HEADER.to_owned() + &(0..rows).map(row).collect::<String>()
}

/// That the joined bytes read as the first run, with a notice at the place where the rest
/// begins, and nothing but the number that starts over beside it.
fn assert_first_run_is_read(first: &[u8], joined: &[u8], place: Place) {
    let alone = read_from(first).unwrap();
    let recording = read_from(joined).unwrap();
    let shown = recording.refusals.to_string();
    let notice = recording.refusals.first().last().unwrap();
    assert_eq!(notice.reason, Reason::SecondRun, "{shown}");
    assert_eq!(notice.place, place, "{shown}");
    assert!(
        notice.text.ends_with("what follows is another run"),
        "{shown}"
    );
    let started_over = recording.refusals.count_of(Reason::StartedOver);
    assert_eq!(recording.refusals.count(), 1 + started_over, "{shown}");
    assert_eq!(without_refusals(recording), without_refusals(alone));
}

fn without_refusals(recording: Recording) -> Recording {
    Recording {
        refusals: Default::default(),
        ..recording
    }
}

#[test]
fn two_and_three_joined_simulated_recordings_read_as_the_first() {
    let first = simulated(SSSO, 100);
    // The zero byte in front of the second recording is no frame.
    let place = Place::Byte(first.len() as u64 + 1);
    for second in [
        simulated(SSSO, 100),
        simulated(SSSO, 7),
        simulated(MSOD, 100),
    ] {
        let two = [first.as_slice(), &second].concat();
        assert_first_run_is_read(&first, &two, place);
        let three = [two.as_slice(), &second].concat();
        assert_first_run_is_read(&first, &three, place);
        let scenario = read_from(two.as_slice()).unwrap().truth.unwrap().scenario;
        assert!(Scenario::parse(&scenario.unwrap()).is_ok());
    }
}

#[test]
fn a_second_simulated_recording_that_is_cut_anywhere_leaves_the_first_as_it_is() {
    let first = simulated(SSSO, 100);
    let alone = without_refusals(read_from(first.as_slice()).unwrap());
    for cut in (0..first.len()).step_by(97).chain(0..60) {
        let joined = [&first, &first[..cut]].concat();
        let recording = read_from(joined.as_slice()).unwrap();
        assert_eq!(without_refusals(recording), alone, "cut after {cut} bytes");
    }
}

#[test]
fn a_simulated_recording_that_ends_within_its_scenario_costs_the_second_nothing() {
    let whole = simulated(SSSO, 100);
    let cut = [&whole[..400], &whole].concat();
    let recording = read_from(cut.as_slice()).unwrap();
    assert_eq!(recording.refusals.count_of(Reason::BeforeConfiguration), 1);
    let alone = read_from(whole.as_slice()).unwrap();
    assert_eq!(without_refusals(recording), without_refusals(alone));
}

#[test]
fn joined_recordings_of_a_board_read_as_the_first() {
    let first = of_a_board();
    let place = Place::Byte(first.len() as u64 + 1);
    let two = [first.as_slice(), &first].concat();
    assert_first_run_is_read(&first, &two, place);
    let three = [two.as_slice(), &first].concat();
    assert_first_run_is_read(&first, &three, place);
    // A simulated one behind it, and the other way round.
    let other = simulated(SSSO, 1);
    assert_first_run_is_read(&first, &[first.as_slice(), &other].concat(), place);
    let place = Place::Byte(other.len() as u64 + 1);
    assert_first_run_is_read(&other, &[other.as_slice(), &first].concat(), place);
}

#[test]
fn a_second_recording_of_the_same_boot_without_its_configured_is_another_run() {
    let [first, second] = two_of_one_boot();
    let place = Place::Byte(first.len() as u64 + 1);
    assert_first_run_is_read(&first, &[first.as_slice(), &second].concat(), place);
}

#[test]
fn a_configuration_that_a_line_repeated_is_one_configuration() {
    let [first, _] = two_of_one_boot();
    let mut writer = RecordingWriter::new(Vec::new()).unwrap();
    writer.write_input(&Input::Configure(config())).unwrap();
    let head = writer.finish().unwrap();
    let repeated = [&head, &first[1..]].concat();
    let recording = read_from(repeated.as_slice()).unwrap();
    assert_eq!(recording.refusals.count_of(Reason::Repeated), 1);
    let alone = read_from(first.as_slice()).unwrap();
    assert_eq!(without_refusals(recording), without_refusals(alone));
}

#[test]
fn joined_texts_of_amiro_read_as_the_first() {
    let (first, second) = (text(20), text(9));
    let two = format!("{first}{second}");
    // A header, twenty rows, a header.
    assert_first_run_is_read(first.as_bytes(), two.as_bytes(), Place::Line(22));
    let three = format!("{two}\u{feff}{second}");
    assert_first_run_is_read(first.as_bytes(), three.as_bytes(), Place::Line(22));
    for cut in 0..second.len() {
        let joined = format!("{first}{}", &second[..cut]);
        let inputs = read_from(joined.as_bytes()).unwrap().inputs;
        // A header of which the end is missing is a row that is none.
        assert_eq!(inputs.len(), 40, "cut after {cut} bytes");
    }
}

#[test]
fn a_header_behind_a_last_row_without_line_end_is_another_recording_too() {
    let (first, second) = (text(20), text(9));
    let joined = format!("{}{second}", first.trim_end());
    let recording = read_from(joined.as_bytes()).unwrap();
    let shown = recording.refusals.to_string();
    assert_eq!(
        shown,
        "line 21: no line end: the last number may be cut\n\
         line 21: a second header: what follows is another run"
    );
    // The last row may be cut; the other nineteen are used.
    assert_eq!(recording.inputs.len(), 38);
}

#[test]
fn the_notice_of_another_run_is_shown_behind_any_number_of_refusals() {
    let first = simulated(SSSO, 100);
    let broken = [first.as_slice(), &[1, 2, 3, 0].repeat(20), &first].concat();
    let shown = read_from(broken.as_slice()).unwrap().refusals.to_string();
    let place = first.len() + 80 + 1;
    let notice = format!("\nbyte {place}: the truth of another simulation: what follows");
    assert!(shown.contains(&notice), "{shown}");
}
