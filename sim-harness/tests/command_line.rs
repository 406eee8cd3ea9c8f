//! The program itself: what it prints and how it ends, with boards that play a part at
//! the other end of a pseudo terminal.

#![cfg(unix)]

use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::thread;
use std::time::Duration;

use amiro_ipf::driver::{OffsetOrigin, Offsets};
use amiro_ipf::event::{Boot, ClockSource, Event, OffsetReport, Status};
use amiro_ipf::fault::Fault;
use amiro_ipf::input::Input;
use amiro_ipf::supervision::{Cause, ImageCheck, Mode, PostMortem, Supervision};
use amiro_ipf::wire::{Decoder, Encoder, Message, Outgoing, Received, WIRE_VERSION};
use serialport::{SerialPort, TTYPort};

/// What a board says under a boot id, and why it refuses the input that it has heard.
#[derive(Default)]
struct Said {
    boot_id: u8,
    events: Vec<Event>,
    /// An input of its own, said behind the events.
    own: Option<Input>,
    refused: Option<Fault>,
}

/// Puts a board on a pseudo terminal; its port's name.
///
/// `play` is told each input that is heard, and `None` when there was none for 10 ms.
fn plug(mut play: impl FnMut(Option<&Input>) -> Said + Send + 'static) -> String {
    let (mut master, slave) = TTYPort::pair().unwrap();
    master.set_timeout(Duration::from_millis(10)).unwrap();
    let name = slave.name().unwrap();
    thread::spawn(move || {
        // The other end stays open, whoever comes and goes.
        let _slave = slave;
        let mut decoder = Decoder::new();
        let mut encoder = Encoder::new(0);
        let mut boot_id = 0;
        let mut heard = [0; 256];
        loop {
            let count = master.read(&mut heard).unwrap_or(0);
            let inputs: Vec<(u16, Input)> = heard[..count]
                .iter()
                .filter_map(|byte| match decoder.push(*byte)? {
                    Received::Frame { frame, .. } => match frame.message {
                        Message::Input(input) => Some((frame.sequence, input)),
                        _ => None,
                    },
                    Received::Broken(_) => None,
                })
                .collect();
            let turns = inputs.iter().map(Some).chain((count == 0).then_some(None));
            for turn in turns {
                let mut said = play(turn.map(|(_, input)| input));
                if said.boot_id != boot_id {
                    (boot_id, encoder) = (said.boot_id, Encoder::new(said.boot_id));
                }
                if let Some(&(input, _)) = turn {
                    let refused = said.refused;
                    said.events.push(Event::Answer { input, refused });
                }
                let events = said.events.iter().map(Outgoing::Event);
                for message in events.chain(said.own.as_ref().map(Outgoing::Input)) {
                    // Nobody may listen.
                    let _ = master.write_all(encoder.encode(message));
                }
            }
        }
    });
    name
}

fn boot(wire_version: u8) -> Event {
    Event::Boot(Boot {
        wire_version,
        build_id: 7,
        capacity: 8000,
        window: 8,
        baud: 2_000_000,
        clock: ClockSource::CrystalPll,
        core_hz: 168_000_000,
    })
}

fn ipf(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_ipf"))
        .args(arguments)
        .output()
        .unwrap()
}

/// Both of what was printed.
fn printed(output: &Output) -> String {
    let both = [output.stdout.as_slice(), &output.stderr].concat();
    String::from_utf8(both).unwrap()
}

/// A folder for what a command writes; removed when dropped.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("ipf-{name}-{}.d", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn file(&self, name: &str) -> String {
        self.0.join(name).to_str().unwrap().to_owned()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn scenario() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenarios/ssso.toml");
    path.to_str().unwrap().to_owned()
}

#[test]
fn f69_a_board_of_another_version_ends_each_command_that_greets_it_with_3() {
    let folder = Folder::new("version");
    let port = plug(|input| Said {
        events: input.map(|_| boot(77)).into_iter().collect(),
        ..Said::default()
    });
    let drive = folder.file("drive.ipf");
    let simulated = ipf(&["simulate", &scenario(), "--out", &drive]);
    assert_eq!(simulated.status.code(), Some(0), "{simulated:?}");
    let recording = folder.file("recording.ipf");
    let commands: [&[&str]; 3] = [
        &["offsets", "--on", &port],
        &["record", "--on", &port, "--out", &recording],
        &[
            "replay",
            &drive,
            "--on",
            &port,
            "--out",
            &folder.file("out"),
        ],
    ];
    for command in commands {
        let output = ipf(command);
        let shown = printed(&output);
        assert_eq!(output.status.code(), Some(3), "{command:?}: {shown}");
        let both = format!("the board speaks protocol version 77, this host {WIRE_VERSION}");
        assert!(shown.contains(&both), "{command:?}: {shown}");
    }
    assert!(
        !Path::new(&recording).exists(),
        "nothing was to be recorded"
    );
}

#[test]
fn f69_another_version_after_a_reset_in_mid_recording_ends_with_3_too() {
    let folder = Folder::new("version-later");
    let mut is_configured = false;
    let port = plug(move |input| {
        let boot_id = if is_configured { 2 } else { 1 };
        let events = match input {
            Some(Input::Hello) => vec![boot(if is_configured { 77 } else { WIRE_VERSION })],
            Some(Input::Configure(config)) => {
                is_configured = true;
                vec![Event::Configured(*config)]
            }
            _ => vec![Event::Status(Status::default())],
        };
        Said {
            boot_id,
            events,
            ..Said::default()
        }
    });
    let output = ipf(&["record", "--on", &port, "--out", &folder.file("drive.ipf")]);
    let shown = printed(&output);
    assert_eq!(output.status.code(), Some(3), "{shown}");
    assert!(shown.contains("the board started anew"), "{shown}");
    assert!(shown.contains("protocol version 77"), "{shown}");
}

#[test]
fn f55_f5a_recording_a_board_in_its_safe_mode_says_how_it_died_and_why_it_is_safe() {
    let folder = Folder::new("safe");
    let port = plug(|input| {
        let (events, refused) = match input {
            Some(Input::Hello) => {
                let died = PostMortem::new(Cause::Panic, 263, 12_375).at("src/node.rs", 77);
                (vec![boot(WIRE_VERSION), Event::PostMortem(died)], None)
            }
            Some(_) => (Vec::new(), Some(Fault::SafeMode)),
            None => {
                let how = Supervision {
                    mode: Mode::SafeForImage,
                    image: ImageCheck::Damaged,
                    ..Supervision::default()
                };
                (vec![Event::Supervision(how)], None)
            }
        };
        Said {
            boot_id: 1,
            events,
            refused,
            ..Said::default()
        }
    });
    let output = ipf(&["record", "--on", &port, "--out", &folder.file("drive.ipf")]);
    let shown = printed(&output);
    assert_eq!(output.status.code(), Some(2), "{shown}");
    for words in [
        "had ended by itself after 12.4 s: Panic at src/node.rs:77, step 263",
        "the board's mode: SafeForImage (image Damaged, reset Unknown)",
        "refused what it was told: SafeMode, the board is in its safe mode",
    ] {
        assert!(shown.contains(words), "{words}: {shown}");
    }
}

#[test]
fn f6a_a_board_that_dies_in_mid_recording_says_how_it_died_and_goes_on_in_a_second_part() {
    let folder = Folder::new("died");
    let mut lives = 0;
    let port = plug(move |input| {
        let events = match input {
            Some(Input::Hello) if lives > 0 => {
                let died = PostMortem::new(Cause::Watchdog, 5, 1_000);
                vec![boot(WIRE_VERSION), Event::PostMortem(died)]
            }
            Some(Input::Hello) => vec![boot(WIRE_VERSION)],
            Some(Input::Configure(config)) => {
                lives += 1;
                vec![Event::Configured(*config)]
            }
            _ => vec![
                Event::Status(Status::default()),
                Event::BrokeOff { stamp_us: 9 },
            ],
        };
        // Dies once, after its first configuration.
        let boot_id = if lives > 0 && !matches!(input, Some(Input::Configure(_))) {
            2
        } else {
            lives.max(1)
        };
        Said {
            boot_id,
            events,
            own: input.is_none().then_some(Input::Limit {
                particles_per_sensor: 750,
            }),
            refused: None,
        }
    });
    let out = folder.file("drive.ipf");
    let output = ipf(&["record", "--on", &port, "--seconds", "3", "--out", &out]);
    let shown = printed(&output);
    assert_eq!(output.status.code(), Some(0), "{shown}");
    for words in [
        "Watchdog at 0x00000000, step 5",
        "BrokeOff: the odometry broke off",
        "Limit: steps take too long, 750 particles",
    ] {
        assert!(shown.contains(words), "{words}: {shown}");
    }
    // The second part tells it too.
    let second = sim_harness::log::read(Path::new(&folder.file("drive.2.ipf"))).unwrap();
    let told = second
        .events
        .iter()
        .any(|event| matches!(event, Event::PostMortem(record) if record.cause == Cause::Watchdog));
    assert!(told, "{:?}", second.events);
}

#[test]
fn what_was_not_asked_for_well_ends_with_2_and_names_the_place() {
    let folder = Folder::new("wrong");
    let (drive, out) = (folder.file("drive.ipf"), folder.file("out"));
    let world = scenario();
    let cut = folder.file("cut.ipf");
    let simulated = ipf(&["simulate", &world, "--out", &drive]);
    assert_eq!(simulated.status.code(), Some(0), "{simulated:?}");
    let bytes = std::fs::read(&drive).unwrap();
    std::fs::write(&cut, &bytes[..20_001]).unwrap();
    let nowhere = folder.file("nowhere");
    let cases: [(&[&str], &str); 7] = [
        (
            &["record", "--on", &nowhere, "--out", &out],
            "the board cannot be reached: ",
        ),
        (
            &["offsets", "--on", "/dev/null"],
            "the board cannot be reached: /dev/null: ",
        ),
        (&["replay", &nowhere], "nowhere: cannot be read: "),
        (&["replay", &cut, "--strict", "--out", &out], "byte 19"),
        (
            &["replay", &drive, "--alpha", "0"],
            "alpha_counts_m2 must be ",
        ),
        (&["image", "--file", &drive], "drive.ipf: no flash image: "),
        (
            &[
                "simulate",
                &world,
                "--out",
                &out,
                "--fault",
                "s3=off, bus3=off",
            ],
            "\"bus3=off\" (character 9) names no part that can fail",
        ),
    ];
    for (command, words) in cases {
        let output = ipf(command);
        let shown = printed(&output);
        assert_eq!(output.status.code(), Some(2), "{command:?}: {shown}");
        assert!(shown.contains(words), "{command:?}: {shown}");
    }
}

/// A drive that was recorded as text: 30 rows of 5 mm each along x from every start.
fn text_drive(path: &str, starts_um: &[(i64, i64)]) {
    let rows = |(x, y): &(i64, i64)| (0..30).map(|row| (x + 5_000 * row, *y)).collect::<Vec<_>>();
    text_stations(path, &starts_um.iter().flat_map(rows).collect::<Vec<_>>());
}

/// A row of text at each place.
fn text_stations(path: &str, places_um: &[(i64, i64)]) {
    let mut text = String::from(
        "PRV 0\tPRV 1\tPRV 2\tPRV 3\tPRV 4\tPRV 5\tPRV 6\tPRV 7\tX [ym]\tY [ym]\tTheta [yrad]\n",
    );
    for (row, (x, y)) in places_um.iter().enumerate() {
        let noise = row % 3;
        text += &format!(
            "{}\t0\t0\t1900\t2200\t4\t19\t{noise}\t{x}\t{y}\t0\n",
            10 + noise
        );
    }
    std::fs::write(path, text).unwrap();
}

#[test]
fn a_map_that_is_cut_says_so_in_print_and_in_its_summary() {
    let folder = Folder::new("cut");
    let (drive, out) = (folder.file("jump.txt"), folder.file("out"));
    text_drive(&drive, &[(0, 0), (85_000_000, 85_000_000)]);
    let output = ipf(&["replay", &drive, "--particles", "100", "--out", &out]);
    let shown = printed(&output);
    assert_eq!(output.status.code(), Some(0), "{shown}");
    for words in [
        "30 steps over 0.2",
        "THE MAP IS CUT: it holds at most 64000000 cells",
        "leg 2 of 2",
        "left:  not mapped",
    ] {
        assert!(shown.contains(words), "{words}: {shown}");
    }
    let summary = std::fs::read_to_string(folder.file("out/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let figure = |key: &str| summary["figures"][key].as_f64().unwrap();
    assert!(figure("cells_refused") > 0.0, "{summary}");
    assert!(
        figure("path_m") < 0.3 && figure("mean_step_m") < 0.011,
        "{summary}"
    );
}

#[test]
fn a_series_whose_odometry_does_not_move_is_refused_with_the_command_for_it() {
    let folder = Folder::new("stepped");
    let (series, out) = (folder.file("series.txt"), folder.file("out"));
    let stations: Vec<(i64, i64)> = (0..17).map(|station| (256 * (station % 3), 0)).collect();
    text_stations(&series, &stations);
    let output = ipf(&["replay", &series, "--out", &out]);
    let shown = printed(&output);
    assert_eq!(output.status.code(), Some(2), "{shown}");
    for words in [
        "series.txt: the odometry does not move: its 17 poses lie within 0.5 mm",
        "evaluate --recordings",
        "--fixed",
    ] {
        assert!(shown.contains(words), "{words}: {shown}");
    }
    assert!(!Path::new(&out).exists(), "nothing is written");
    // With a step per tick there is a map.
    let output = ipf(&["replay", &series, "--fixed", "--out", &out]);
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
}

#[test]
fn offsets_are_no_success_without_a_measurement() {
    // The board takes the order, and then reports what its memory holds.
    let stored = OffsetReport {
        offsets: Offsets {
            origin: OffsetOrigin::Stored,
            ..Offsets::default()
        },
        is_kept: true,
        ..OffsetReport::default()
    };
    let port = plug(move |input| Said {
        boot_id: 1,
        events: match input {
            Some(Input::Hello) => vec![boot(WIRE_VERSION)],
            Some(Input::Configure(config)) => vec![Event::Configured(*config)],
            _ => vec![Event::Offsets(stored)],
        },
        ..Said::default()
    });
    let output = ipf(&["offsets", "--on", &port]);
    let shown = printed(&output);
    assert_eq!(output.status.code(), Some(1), "{shown}");
    assert!(shown.contains("no offsets were measured"), "{shown}");
}

#[test]
fn a_scenario_from_a_pipe_is_in_its_recording() {
    let folder = Folder::new("pipe");
    let text = std::fs::read_to_string(scenario()).unwrap();
    let out = folder.file("drive.ipf");
    let mut child = Command::new(env!("CARGO_BIN_EXE_ipf"))
        .args(["simulate", "/dev/stdin", "--out", &out])
        .stdin(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    child
        .stdin
        .take()
        .unwrap()
        .write_all(text.as_bytes())
        .unwrap();
    assert!(child.wait().unwrap().success());
    let recording = sim_harness::log::read(Path::new(&out)).unwrap();
    let told = recording.truth.and_then(|truth| truth.scenario).unwrap();
    assert!(told.ends_with(&text), "{told}");
}

#[test]
fn a_scenario_that_cannot_be_is_refused_with_its_file_and_nothing_is_written() {
    let folder = Folder::new("impossible");
    let (world, out) = (folder.file("world.toml"), folder.file("drive.ipf"));
    let text = std::fs::read_to_string(scenario()).unwrap();
    let inside = "[[cylinder]]\ncenter = [-0.400, 0]\nradius_m = 0.02\n";
    std::fs::write(&world, text.clone() + inside).unwrap();
    for command in [
        &["simulate", &world, "--out", &out][..],
        &["evaluate", "--scenario", &world, "--seeds", "100..101"],
    ] {
        let output = ipf(command);
        let shown = printed(&output);
        assert_eq!(output.status.code(), Some(2), "{command:?}: {shown}");
        let words = "world.toml: start: the robot's centre at [-0.400, 0.000] is inside cylinder 1";
        assert!(shown.contains(words), "{command:?}: {shown}");
    }
    assert!(!Path::new(&out).exists());
    // On purpose it is driven, and its recording replayed.
    std::fs::write(
        &world,
        "allow = [\"collision\"]\n".to_owned() + &text + inside,
    )
    .unwrap();
    let output = ipf(&["simulate", &world, "--out", &out]);
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let map = folder.file("map");
    let output = ipf(&["replay", &out, "--particles", "100", "--out", &map]);
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
}

#[test]
fn errors_stand_in_two_columns_beside_the_free_map_and_are_defined_where_they_stand() {
    let folder = Folder::new("errors");
    let (out, json) = (folder.file("demo"), folder.file("trials.json"));
    let demo = printed(&ipf(&["demo", "--out", &out]));
    let evaluate = printed(&ipf(&[
        "evaluate",
        "--scenario",
        "ssso",
        "--methods",
        "plus,all-free",
        "--seeds",
        "100..101",
        "--particles",
        "100",
        "--json",
        &json,
    ]));
    for shown in [&demo, &evaluate] {
        for words in [
            "OE: overall error, ",
            "Plain OE: ",
            "TPR, FPR: ",
            "Recall: ",
            "Coverage: ",
        ] {
            assert!(shown.contains(words), "{words}: {shown}");
        }
        let definition = shown.find("OE: overall error, ").unwrap();
        assert!(definition < shown.find("all-free  ").unwrap(), "{shown}");
    }
    assert!(demo.contains("plain OE   1.1 %"), "{demo}");
    assert!(evaluate.contains("OE % +- std  plain %"), "{evaluate}");
    let trials = std::fs::read_to_string(&json).unwrap();
    for key in ["\"oe\":", "\"oe_unexpanded\":"] {
        assert!(trials.contains(key), "{key}: {trials}");
    }
}

#[test]
fn a_map_with_its_footprint_off_is_the_counted_one() {
    let folder = Folder::new("footprint");
    let drive = folder.file("drive.txt");
    text_drive(&drive, &[(0, 0)]);
    let map = |footprint: &[&str]| {
        let out = folder.file("out");
        let mut command = vec!["replay", drive.as_str(), "--out", out.as_str()];
        command.extend(footprint);
        assert_eq!(ipf(&command).status.code(), Some(0));
        let summary = std::fs::read_to_string(folder.file("out/summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
        let radius = summary["figures"]["footprint_radius_m"].as_f64();
        (std::fs::read(folder.file("out/map.pgm")).unwrap(), radius)
    };
    let (counted, radius) = map(&["--footprint", "off"]);
    assert_eq!(radius, None);
    let (by_default, radius) = map(&[]);
    assert_eq!(radius, Some(0.05));
    assert!(by_default != counted);
    // Pinned: the map that this drive had before maps had a footprint.
    assert_eq!(amiro_ipf::checksum::CRC.checksum(&counted), 849_227_224);
}
