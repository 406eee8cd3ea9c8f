//! The program itself: what it prints and how it ends, with boards that play a part at
//! the other end of a pseudo terminal.

#![cfg(unix)]

use std::io::{Read, Write};
use std::path::Path;
use std::process::{Command, Output};
use std::thread;
use std::time::Duration;

use amiro_ipf::board::clock_choice::ClockSource;
use amiro_ipf::board::offsets::{OffsetOrigin, OffsetReport, Offsets};
use amiro_ipf::board::supervision::{FailureCause, ImageCheck, Mode, PostMortem, Supervision};
use amiro_ipf::link::{
    Boot, Decoder, Encoder, Frame, Message, MessageRef, Received, Status, WIRE_VERSION,
};
use amiro_ipf::node::{Event, Input, InputError};
use serialport::{SerialPort, TTYPort};
use tempfile::TempDir;

use crate::common;

/// What a board says under a boot id, and why it refuses the input that it has heard.
#[derive(Default)]
struct Said {
    boot_id: u8,
    events: Vec<Message>,
    /// An input of its own, said behind the events.
    own: Option<Input>,
    refused: Option<InputError>,
}

/// Puts a board on a pseudo terminal; its port's name.
///
/// `play` is told each input that is heard, and `None` when there was none for 10 ms.
fn plug(mut play: impl FnMut(Option<&Message>) -> Said + Send + 'static) -> String {
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
            let inputs: Vec<(u16, Message)> = heard[..count]
                .iter()
                .filter_map(|byte| match decoder.push(*byte)? {
                    Received::Frame { frame, .. } => match frame.message {
                        message @ (Message::Hello | Message::Calibrate | Message::Input(_)) => {
                            Some((frame.sequence, message))
                        }
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
                    said.events.push(Message::Answer { input, refused });
                }
                let events = said.events.iter().map(MessageRef::from);
                for message in events.chain(said.own.as_ref().map(MessageRef::Input)) {
                    // Nobody may listen.
                    let _ = master.write_all(encoder.encode(message));
                }
            }
        }
    });
    name
}

fn boot(wire_version: u8) -> Message {
    Message::Boot(Boot {
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
struct Folder(TempDir);

impl Folder {
    fn new(name: &str) -> Self {
        Self(common::own_folder(name))
    }

    fn file(&self, name: &str) -> String {
        self.0.path().join(name).to_str().unwrap().to_owned()
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
            Some(Message::Hello) => vec![boot(if is_configured { 77 } else { WIRE_VERSION })],
            Some(Message::Input(Input::Configure(config))) => {
                is_configured = true;
                vec![Event::Configured(*config).into()]
            }
            _ => vec![Message::Status(Status::default())],
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
            Some(Message::Hello) => {
                let died = PostMortem::new(FailureCause::Panic, 263, 12_375).at("src/node.rs", 77);
                (vec![boot(WIRE_VERSION), Message::PostMortem(died)], None)
            }
            Some(_) => (Vec::new(), Some(InputError::SafeMode)),
            None => {
                let how = Supervision {
                    mode: Mode::SafeForImage,
                    image: ImageCheck::Damaged,
                    ..Supervision::default()
                };
                (vec![Message::Supervision(how)], None)
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
            Some(Message::Hello) if lives > 0 => {
                let died = PostMortem::new(FailureCause::Watchdog, 5, 1_000);
                vec![boot(WIRE_VERSION), Message::PostMortem(died)]
            }
            Some(Message::Hello) => vec![boot(WIRE_VERSION)],
            Some(Message::Input(Input::Configure(config))) => {
                lives += 1;
                vec![Event::Configured(*config).into()]
            }
            _ => vec![
                Message::Status(Status::default()),
                Event::OdometryReset { stamp_us: 9 }.into(),
            ],
        };
        // Dies once, after its first configuration.
        let boot_id = if lives > 0 && !matches!(input, Some(Message::Input(Input::Configure(_)))) {
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
    let told = second.messages.iter().any(
        |event| matches!(event, Message::PostMortem(record) if record.cause == FailureCause::Watchdog),
    );
    assert!(told, "{:?}", second.messages);
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

/// A board that sends statuses once it is configured, or refuses its configuration; it is
/// reset after each configuration if `is_reset`.
fn plug_recorded(is_reset: bool, refused: Option<InputError>) -> String {
    let mut boots = 1;
    plug(move |input| {
        let boot_id = boots;
        let (events, refused) = match input {
            Some(Message::Hello) => (vec![boot(WIRE_VERSION)], None),
            Some(Message::Input(Input::Configure(config))) => {
                boots += u8::from(is_reset);
                (vec![Event::Configured(*config).into()], refused)
            }
            _ => (vec![Message::Status(Status::default())], None),
        };
        Said {
            boot_id,
            events,
            own: None,
            refused,
        }
    })
}

fn names(folder: &Folder) -> Vec<String> {
    let mut names: Vec<_> = std::fs::read_dir(&folder.0)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn an_existing_recording_is_not_truncated_when_the_board_refuses() {
    let folder = Folder::new("refuses");
    let out = folder.file("drive.ipf");
    std::fs::write(&out, "a drive").unwrap();
    std::fs::write(folder.file("drive.2.ipf"), "its second part").unwrap();
    // Without --force no board is needed to know it.
    let output = ipf(&["record", "--on", "/dev/null", "--out", &out]);
    let shown = printed(&output);
    assert_eq!(output.status.code(), Some(2), "{shown}");
    assert!(
        shown.contains("drive.ipf exists") && shown.contains("--force replaces it"),
        "{shown}"
    );
    assert!(shown.contains("drive.3.ipf is free"), "{shown}");
    // With it the board has to take its configuration first.
    let port = plug_recorded(false, Some(InputError::TooManyParticles));
    let output = ipf(&["record", "--on", &port, "--force", "--out", &out]);
    let shown = printed(&output);
    assert_eq!(output.status.code(), Some(2), "{shown}");
    assert!(shown.contains("TooManyParticles"), "{shown}");
    assert_eq!(std::fs::read(&out).unwrap(), b"a drive");
}

#[test]
fn a_board_that_refuses_its_configuration_leaves_no_file() {
    let folder = Folder::new("no-file");
    let port = plug_recorded(false, Some(InputError::TooManyParticles));
    let output = ipf(&["record", "--on", &port, "--out", &folder.file("drive.ipf")]);
    assert_eq!(output.status.code(), Some(2), "{}", printed(&output));
    assert_eq!(names(&folder), [""; 0]);
}

#[test]
fn a_recording_is_replaced_with_force_once_the_board_is_configured() {
    let folder = Folder::new("force");
    let out = folder.file("drive.ipf");
    std::fs::write(&out, "a drive").unwrap();
    let port = plug_recorded(false, None);
    let output = ipf(&[
        "record",
        "--on",
        &port,
        "--force",
        "--seconds",
        "1",
        "--out",
        &out,
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    assert_eq!(std::fs::read(&out).unwrap()[0], 0);
    assert_eq!(names(&folder), ["drive.ipf"]);
}

#[test]
fn a_part_that_nobody_named_is_not_overwritten_after_a_reset() {
    let folder = Folder::new("parts");
    let second = folder.file("drive.2.ipf");
    std::fs::write(&second, "another drive").unwrap();
    let port = plug_recorded(true, None);
    let out = folder.file("drive.ipf");
    // A board that is reset in a loop begins no more than a part each second.
    let output = ipf(&[
        "record",
        "--on",
        &port,
        "--seconds",
        "3",
        "--force",
        "--out",
        &out,
    ]);
    let shown = printed(&output);
    assert_eq!(output.status.code(), Some(0), "{shown}");
    assert_eq!(std::fs::read(&second).unwrap(), b"another drive");
    assert!(shown.contains("it goes on in "), "{shown}");
    assert!(Path::new(&folder.file("drive.3.ipf")).exists(), "{shown}");
    assert!(names(&folder).len() <= 6, "{:?}", names(&folder));
}

/// Runs `record --seconds 1`; how long it took, and its output.
fn recorded_for_a_second(port: &str, out: &str) -> (Duration, Output) {
    let start = std::time::Instant::now();
    let output = ipf(&["record", "--on", port, "--seconds", "1", "--out", out]);
    (start.elapsed(), output)
}

#[test]
fn a_recording_ends_in_time_when_the_board_sends_readings_only() {
    let folder = Folder::new("readings");
    let port = plug(|input| {
        let events = match input {
            Some(Message::Hello) => vec![boot(WIRE_VERSION)],
            Some(Message::Input(Input::Configure(config))) => {
                vec![Event::Configured(*config).into()]
            }
            _ => Vec::new(),
        };
        Said {
            boot_id: 1,
            events,
            own: Some(Input::Odometry {
                stamp_us: 1,
                pose: amiro_ipf::geometry::Pose::default(),
            }),
            refused: None,
        }
    });
    let (took, output) = recorded_for_a_second(&port, &folder.file("drive.ipf"));
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    assert!(took < Duration::from_secs(3), "{took:?}");
}

/// Puts a board on a pseudo terminal that becomes `noise`, again and again, once it is
/// configured.
fn plug_noisy(noise: Vec<u8>) -> String {
    let (mut master, slave) = TTYPort::pair().unwrap();
    master.set_timeout(Duration::from_millis(10)).unwrap();
    let name = slave.name().unwrap();
    thread::spawn(move || {
        let _slave = slave;
        let (mut decoder, mut encoder) = (Decoder::new(), Encoder::new(1));
        let mut heard = [0; 256];
        let mut turns_left = u32::MAX;
        while turns_left > 0 {
            let count = master.read(&mut heard).unwrap_or(0);
            for received in heard[..count].iter().filter_map(|byte| decoder.push(*byte)) {
                let Received::Frame { frame, .. } = received else {
                    continue;
                };
                let answer = Message::Answer {
                    input: frame.sequence,
                    refused: None,
                };
                let event = match frame.message {
                    Message::Hello => boot(WIRE_VERSION),
                    Message::Input(Input::Configure(config)) => {
                        turns_left = 3000;
                        Event::Configured(config).into()
                    }
                    _ => continue,
                };
                for event in [event, answer] {
                    let _ = master.write_all(encoder.encode(&event));
                }
            }
            if turns_left < u32::MAX {
                turns_left -= 1;
                let _ = master.set_timeout(Duration::from_millis(1));
                let _ = master.write_all(&noise);
            }
        }
    });
    name
}

#[test]
fn a_recording_of_noise_without_zero_bytes_ends_in_time_and_stays_small() {
    let folder = Folder::new("noise");
    let out = folder.file("drive.ipf");
    let port = plug_noisy(vec![0x55; 4000]);
    let (took, output) = recorded_for_a_second(&port, &out);
    let shown = printed(&output);
    assert_eq!(output.status.code(), Some(0), "{shown}");
    assert!(took < Duration::from_secs(3), "{took:?}");
    let length = std::fs::metadata(&out).unwrap().len();
    assert!(length < 2000, "{length} bytes of noise were kept");
}

#[test]
fn a_recording_of_broken_frames_ends_in_time() {
    let folder = Folder::new("broken");
    let port = plug_noisy([0x55, 0x55, 0x55, 0].repeat(1000));
    let (took, output) = recorded_for_a_second(&port, &folder.file("drive.ipf"));
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    assert!(took < Duration::from_secs(3), "{took:?}");
}

#[test]
fn record_writes_no_terminal_escape_into_a_pipe() {
    let folder = Folder::new("escapes");
    let port = plug_recorded(false, None);
    let (_, output) = recorded_for_a_second(&port, &folder.file("drive.ipf"));
    let shown = printed(&output);
    assert!(
        !shown.contains(|c: char| c.is_control() && c != '\n'),
        "{shown:?}"
    );
    assert!(
        shown.contains("the board's mode") || shown.contains("board up"),
        "{shown}"
    );
}

/// Sends a signal to `record` while it records, after a shell has set SIGINT as `trap`
/// says; its exit code, and what it printed.
fn interrupted(signal: &str, trap: &str, out: &str) -> (Option<i32>, String) {
    let port = plug_recorded(false, None);
    let script = format!("{trap} exec \"$0\" record --on \"$1\" --out \"$2\"");
    let child = Command::new("sh")
        .args(["-c", &script, env!("CARGO_BIN_EXE_ipf"), &port, out])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    for _ in 0..1000 {
        if std::fs::metadata(out).is_ok_and(|file| file.len() > 500) {
            break;
        }
        thread::sleep(Duration::from_millis(10));
    }
    let id = child.id().to_string();
    let sent = Command::new("kill").args([signal, &id]).status().unwrap();
    assert!(sent.success());
    let output = child.wait_with_output().unwrap();
    (output.status.code(), printed(&output))
}

#[test]
fn an_interrupted_recording_is_whole_and_its_account_is_printed() {
    let folder = Folder::new("interrupted");
    let cases = [("-INT", ""), ("-TERM", ""), ("-INT", "trap '' INT;")];
    for (number, (signal, trap)) in cases.into_iter().enumerate() {
        let out = folder.file(&format!("{number}.ipf"));
        let (code, shown) = interrupted(signal, trap, &out);
        assert_eq!(code, Some(0), "{signal} {trap}: {shown}");
        assert!(shown.contains("steps in "), "{signal} {trap}: {shown}");
        assert!(shown.contains("lost"), "no account of frames: {shown}");
        let recording = sim_harness::log::read(Path::new(&out)).unwrap();
        assert!(recording.refusals.is_empty(), "{}", recording.refusals);
        assert!(recording.messages.len() > 3);
    }
}

#[test]
fn a_greeting_that_is_interrupted_leaves_no_file_and_ends_with_130() {
    let folder = Folder::new("greeting");
    let port = plug(|_| Said {
        // No boot: it never introduces itself.
        boot_id: 1,
        ..Said::default()
    });
    let out = folder.file("drive.ipf");
    let child = Command::new(env!("CARGO_BIN_EXE_ipf"))
        .args(["record", "--on", &port, "--out", &out])
        .stderr(std::process::Stdio::null())
        .spawn();
    let mut child = child.unwrap();
    thread::sleep(Duration::from_millis(1500));
    let id = child.id().to_string();
    assert!(
        Command::new("kill")
            .args(["-INT", &id])
            .status()
            .unwrap()
            .success()
    );
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(names(&folder), [""; 0]);
}

#[test]
fn no_command_replaces_the_recording_of_a_robot() {
    let folder = Folder::new("replaces");
    let recorded = folder.file("recorded.ipf");
    let port = plug_recorded(false, None);
    let (_, output) = recorded_for_a_second(&port, &recorded);
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let ours = std::fs::read(&recorded).unwrap();
    let amiro = b"PRV 0\tPRV 1\tPRV 2\tPRV 3".to_vec();
    let (world, drive) = (scenario(), folder.file("drive.ipf"));
    let simulated = ipf(&["simulate", &world, "--out", &drive]);
    assert_eq!(simulated.status.code(), Some(0), "{simulated:?}");
    let (out, file) = (folder.file("out"), folder.file("out/file"));
    let table = folder.file("table.csv");
    std::fs::write(&table, "range_mm,angle_deg,counts\n").unwrap();
    let commands: [(&[&str], &str); 9] = [
        (&["simulate", &world, "--out", &file], "file"),
        (&["replay", &drive, "--out", &out], "stream.ipf"),
        (&["replay", &drive, "--out", &out], "map.pgm"),
        (&["calibrate", &table, "--out", &out], "fit.csv"),
        (&["image", "--file", "nowhere", "--out", &file], "file"),
        (&["image", "--file", "nowhere", "--out", &file], "file.srec"),
        (&["evaluate", "--seeds", "1..2", "--json", &file], "file"),
        (&["demo", "--out", &out], "both.png"),
        (
            &[
                "figures", "--out", &out, "--seeds", "1..2", "--only", "figure-1",
            ],
            "index.html",
        ),
    ];
    for content in [ours, amiro] {
        for (command, name) in commands {
            let _ = std::fs::remove_dir_all(&out);
            std::fs::create_dir(&out).unwrap();
            let path = Path::new(&out).join(name);
            std::fs::write(&path, &content).unwrap();
            let output = ipf(command);
            let shown = printed(&output);
            assert_eq!(output.status.code(), Some(2), "{command:?}: {shown}");
            assert!(
                shown.contains(&format!("{name}: it is the recording of a robot")),
                "{command:?}: {shown}"
            );
            assert_eq!(std::fs::read(&path).unwrap(), content, "{command:?}");
        }
    }
    // What can be made again is replaced.
    for command in [
        &["simulate", &world, "--out", &drive][..],
        &["replay", &drive, "--out", &out],
        &["replay", &drive, "--out", &out],
    ] {
        let output = ipf(command);
        assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    }
}

#[test]
fn no_command_writes_over_what_it_reads() {
    let folder = Folder::new("reads");
    let (drive, out) = (folder.file("stream.ipf"), folder.file(""));
    let world = folder.file("world.toml");
    std::fs::copy(scenario(), &world).unwrap();
    let table = folder.file("fit.csv");
    std::fs::write(&table, "range_mm,angle_deg,counts\n").unwrap();
    let simulated = ipf(&["simulate", &world, "--out", &drive]);
    assert_eq!(simulated.status.code(), Some(0), "{simulated:?}");
    // By another name too.
    let link = folder.file("link.toml");
    std::os::unix::fs::symlink(&world, &link).unwrap();
    let commands: [(&[&str], &str); 5] = [
        (&["replay", &drive, "--alpha", "2", "--out", &out], &drive),
        (&["simulate", &world, "--out", &world], &world),
        (&["simulate", &world, "--out", &link], &world),
        (&["calibrate", &table, "--out", &out], &table),
        (
            &["evaluate", "--scenario", &world, "--json", &world],
            &world,
        ),
    ];
    for (command, path) in commands {
        let before = std::fs::read(path).unwrap();
        let output = ipf(command);
        let shown = printed(&output);
        assert_eq!(output.status.code(), Some(2), "{command:?}: {shown}");
        assert!(
            shown.contains("this command reads it"),
            "{command:?}: {shown}"
        );
        assert_eq!(std::fs::read(path).unwrap(), before, "{command:?}");
    }
}

#[test]
fn a_file_that_appears_while_the_board_is_configured_is_not_overwritten() {
    let folder = Folder::new("appears");
    let out = folder.file("drive.ipf");
    let path = out.clone();
    let port = plug(move |input| {
        let events = match input {
            Some(Message::Hello) => vec![boot(WIRE_VERSION)],
            Some(Message::Input(Input::Configure(config))) => {
                std::fs::write(&path, "another's").unwrap();
                vec![Event::Configured(*config).into()]
            }
            _ => Vec::new(),
        };
        Said {
            boot_id: 1,
            events,
            ..Said::default()
        }
    });
    let output = ipf(&["record", "--on", &port, "--out", &out]);
    let shown = printed(&output);
    assert_eq!(output.status.code(), Some(2), "{shown}");
    assert!(shown.contains("--force replaces it"), "{shown}");
    assert_eq!(std::fs::read(&out).unwrap(), b"another's");
}

/// A board that sends so many statuses once it is configured, then nothing.
fn plug_falling_silent(mut statuses: u32) -> String {
    let mut is_configured = false;
    plug(move |input| {
        let events = match input {
            Some(Message::Hello) => vec![boot(WIRE_VERSION)],
            Some(Message::Input(Input::Configure(config))) => {
                is_configured = true;
                vec![Event::Configured(*config).into()]
            }
            None if is_configured && statuses > 0 => {
                statuses -= 1;
                vec![Message::Status(Status::default())]
            }
            _ => Vec::new(),
        };
        Said {
            boot_id: 1,
            events,
            ..Said::default()
        }
    })
}

#[test]
fn a_board_that_falls_silent_ends_a_good_recording_with_0_and_an_empty_one_with_2() {
    let folder = Folder::new("silent");
    let out = folder.file("drive.ipf");
    let port = plug_falling_silent(20);
    let output = ipf(&["record", "--on", &port, "--out", &out]);
    let shown = printed(&output);
    assert_eq!(output.status.code(), Some(0), "{shown}");
    assert!(
        shown.contains("the board sent nothing for 2 s: the recording ends here"),
        "{shown}"
    );
    let recording = sim_harness::log::read(Path::new(&out)).unwrap();
    let statuses = recording.messages.iter();
    let statuses = statuses.filter(|message| matches!(message, Message::Status(_)));
    assert_eq!(statuses.count(), 20);
    let port = plug_falling_silent(0);
    let output = ipf(&["record", "--on", &port, "--out", &folder.file("none.ipf")]);
    let shown = printed(&output);
    assert_eq!(output.status.code(), Some(2), "{shown}");
    assert!(shown.contains("the board fell silent"), "{shown}");
}

#[test]
fn a_board_that_is_reset_every_ten_milliseconds_ends_with_6() {
    let folder = Folder::new("storm");
    let mut boot_id = 0_u8;
    let port = plug(move |_| {
        boot_id = boot_id.wrapping_add(1);
        Said {
            boot_id,
            events: vec![boot(WIRE_VERSION)],
            ..Said::default()
        }
    });
    let output = ipf(&["record", "--on", &port, "--out", &folder.file("drive.ipf")]);
    let shown = printed(&output);
    assert_eq!(output.status.code(), Some(6), "{shown}");
    assert!(
        shown.contains("the board was reset 100 times while it was greeted"),
        "{shown}"
    );
    assert_eq!(names(&folder), [""; 0]);
}

#[test]
fn a_wrong_baud_rate_is_named_once_and_zero_bytes_are_none() {
    let folder = Folder::new("baud");
    let run = |noise, out| {
        let port = plug_noisy(noise);
        let out = folder.file(out);
        let output = ipf(&["record", "--on", &port, "--seconds", "5", "--out", &out]);
        let shown = printed(&output);
        (shown.matches("wrong baud rate").count(), shown)
    };
    let (count, shown) = run(vec![0x55; 100], "noise.ipf");
    assert_eq!(count, 1, "{shown}");
    let (count, shown) = run(vec![0; 100], "zeros.ipf");
    assert_eq!(count, 0, "{shown}");
    assert!(shown.contains("the board fell silent"), "{shown}");
}

#[test]
fn the_port_of_the_board_is_not_its_recording() {
    let port = plug_recorded(false, None);
    for force in [&[][..], &["--force"]] {
        let command = [&["record", "--on", &port, "--out", &port], force].concat();
        let output = ipf(&command);
        let shown = printed(&output);
        assert_eq!(output.status.code(), Some(2), "{shown}");
        assert!(shown.contains("is the port of the board"), "{shown}");
    }
}

/// With `IPF_LONG` set, since it takes 100 s.
#[test]
fn a_board_that_is_reset_in_a_loop_ends_a_recording_with_6() {
    if std::env::var_os("IPF_LONG").is_none() {
        return;
    }
    let folder = Folder::new("resets");
    let port = plug_recorded(true, None);
    let output = ipf(&["record", "--on", &port, "--out", &folder.file("drive.ipf")]);
    let shown = printed(&output);
    assert_eq!(output.status.code(), Some(6), "{shown}");
    assert!(shown.contains("the board was reset 100 times"), "{shown}");
    assert_eq!(names(&folder).len(), 100);
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
            Some(Message::Hello) => vec![boot(WIRE_VERSION)],
            Some(Message::Input(Input::Configure(config))) => {
                vec![Event::Configured(*config).into()]
            }
            _ => vec![Message::Offsets(stored)],
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

#[test]
fn a_recording_with_a_lost_particle_frame_replays_as_equal_with_exit_code_4() {
    let folder = Folder::new("lost-particles");
    let (drive, out) = (folder.file("drive.ipf"), folder.file("out"));
    let scenario = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/ssso.toml");
    let arguments = ["simulate", scenario, "--seed", "100", "--out", &drive];
    assert_eq!(ipf(&arguments).status.code(), Some(0));
    let arguments = ["replay", &drive, "--particles", "100", "--out", &out];
    assert_eq!(ipf(&arguments).status.code(), Some(0));
    let whole = std::fs::read(folder.file("out/stream.ipf")).unwrap();
    let replayed = |bytes: &[u8]| {
        let path = folder.file("stream.ipf");
        std::fs::write(&path, bytes).unwrap();
        let output = ipf(&["replay", &path, "--out", &folder.file("again")]);
        (output.status.code(), printed(&output))
    };
    let (code, shown) = replayed(&whole);
    assert_eq!(code, Some(0), "{shown}");
    assert!(shown.contains("\nEQUAL: "), "{shown}");
    // Without one particle frame, and without the end of one step.
    let without = |is_lost: fn(&Event) -> bool| -> Vec<u8> {
        let mut lost = 0;
        let pieces = whole.split_inclusive(|byte| *byte == 0);
        let kept = pieces.filter(|piece| {
            let mut bytes = piece.strip_suffix(&[0]).unwrap_or(piece).to_vec();
            match Frame::decode(&mut bytes).map(|frame| frame.message) {
                Ok(Message::Event(event)) if is_lost(&event) => {
                    lost += 1;
                    lost != 3
                }
                _ => true,
            }
        });
        kept.flatten().copied().collect()
    };
    let (code, shown) = replayed(&without(|event| matches!(event, Event::Particles(_))));
    assert_eq!(code, Some(4), "{shown}");
    assert!(
        shown.contains("\nEQUAL, 1 particle messages lost: "),
        "{shown}"
    );
    let (code, shown) = replayed(&without(|event| matches!(event, Event::StepDone(_))));
    assert_eq!(code, Some(1), "{shown}");
    assert!(shown.contains("\nDIFFERENT at step 2: "), "{shown}");
}

#[test]
fn a_replay_with_the_profile_wall_leaves_walls_and_another_one_removes_them() {
    let folder = Folder::new("walls");
    let (drive, out) = (folder.file("drive.ipf"), folder.file("out"));
    let scenario = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios/msm_l.toml");
    let arguments = ["simulate", scenario, "--physics", "patch", "--out", &drive];
    assert_eq!(ipf(&arguments).status.code(), Some(0));
    let replay = |file: &str, more: &[&str]| {
        let output = ipf(&[&["replay", file, "--out", &out], more].concat());
        (output.status.code(), printed(&output))
    };
    let read = |name: &str| std::fs::read_to_string(folder.file(&format!("out/{name}"))).ok();
    let particles = ["--particles", "50"];
    let (code, shown) = replay(&drive, &[&particles[..], &["--profile", "wall"]].concat());
    assert_eq!(code, Some(0), "{shown}");
    assert!(shown.contains(" wall segments of "), "{shown}");
    let table = read("walls.csv").unwrap();
    assert!(table.lines().count() > 4, "{table}");
    // The stream alone gives the same walls, and each missing message is counted.
    let stream = std::fs::read(folder.file("out/stream.ipf")).unwrap();
    let copy = folder.file("stream.ipf");
    std::fs::write(&copy, &stream).unwrap();
    let (code, shown) = replay(&copy, &[]);
    assert_eq!(code, Some(0), "{shown}");
    assert!(shown.contains(" walls messages too"), "{shown}");
    assert_eq!(read("walls.csv").unwrap(), table);
    let mut count = 0;
    let pieces = stream.split_inclusive(|byte| *byte == 0);
    let kept = pieces.filter(|piece| {
        let mut bytes = piece.strip_suffix(&[0]).unwrap_or(piece).to_vec();
        let message = Frame::decode(&mut bytes).map(|frame| frame.message);
        count += usize::from(matches!(message, Ok(Message::Event(Event::Walls(_)))));
        !matches!(message, Ok(Message::Event(Event::Walls(_)))) || count != 3
    });
    std::fs::write(&copy, kept.flatten().copied().collect::<Vec<u8>>()).unwrap();
    let (code, shown) = replay(&copy, &[]);
    assert_eq!(code, Some(4), "{shown}");
    assert!(
        shown.contains("\nEQUAL, 1 walls messages lost: "),
        "{shown}"
    );
    let json: serde_json::Value = serde_json::from_str(&read("walls.json").unwrap()).unwrap();
    assert_eq!(json["type"], "FeatureCollection");
    let (code, shown) = replay(&drive, &[&particles[..], &["--profile", "plus"]].concat());
    assert_eq!(code, Some(0), "{shown}");
    assert_eq!((read("walls.csv"), read("walls.json")), (None, None));
}

#[test]
fn a_sonar_drive_is_mapped_with_its_rig_and_nothing_else() {
    let folder = Folder::new("map");
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let path = |name: &str| root.join(name).display().to_string();
    let (drive, rig) = (
        path("sim-harness/tests/data/robond"),
        path("rigs/kcma.toml"),
    );
    let out = folder.file("out");
    let output = ipf(&["map", &drive, "--rig", &rig, "--out", &out]);
    let shown = printed(&output);
    assert_eq!(output.status.code(), Some(0), "{shown}");
    assert!(
        shown.contains("1753 occupied and 11924 free cells of 100 mm"),
        "{shown}"
    );
    for name in ["map.png", "map.pgm", "map.yaml", "summary.json"] {
        assert!(Path::new(&out).join(name).is_file(), "{name}");
    }
    let other = folder.file("other");
    let (amiro, nowhere) = (path("rigs/amiro.toml"), folder.file("nowhere"));
    for (arguments, reason) in [
        (
            vec![&*drive, "--rig", &*amiro],
            "rig amiro: the recording needs 8 cones",
        ),
        (vec![&*drive, "--rig", &*nowhere], "nowhere: No such file"),
        (vec![&*nowhere, "--rig", &*rig], "nowhere: No such file"),
        (
            vec![&*drive, "--rig", &*rig, "--method", "best"],
            "--methods best: all, all-free, ism, ",
        ),
        (
            vec![&*drive, "--rig", &*rig, "--sensors", "radar"],
            "--sensors radar: rig kcma",
        ),
        (
            vec![&*drive, "--rig", &*rig, "--matched"],
            "the recording has no matched poses",
        ),
        (vec![&*drive, "--rig", &*rig, "--cell-mm", "0"], "--cell-mm"),
    ] {
        let all: Vec<&str> = ["map"]
            .into_iter()
            .chain(arguments)
            .chain(["--out", &*other])
            .collect();
        let output = ipf(&all);
        let shown = printed(&output);
        assert_eq!(output.status.code(), Some(2), "{all:?}: {shown}");
        assert!(shown.contains(reason), "{all:?}: {shown}");
        assert!(!Path::new(&other).join("map.pgm").exists(), "{all:?}");
    }
}
