//! The flash image watches over itself: faults provoked in QEMU from outside, by its
//! debugger, in the very image that is flashed.

#![cfg(unix)]

use std::cell::RefCell;
use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::{Duration, Instant};

use amiro_ipf::board::supervision::{
    FailureCause, ImageCheck, Mode, PostMortem, ResetCause, Supervision,
};
use amiro_ipf::filter::Profile;
use amiro_ipf::link::Message;
use amiro_ipf::node::{Config, Input, InputError, Source, StepRule};
use sim_harness::device::{Board, Image, LinkError, QemuOptions, RecordingEvent, drive, record};
use sim_harness::{log, run};

use crate::common;

/// A piece of RAM that the image does not need when it is about to die: in the middle of
/// the particles.
const SCRATCH: u32 = 0x2001_0000;

/// Numbers of the registers in the debugger's protocol.
const SP: u8 = 13;
const PC: u8 = 15;

/// A debugger: the few packets of its protocol that are needed here.
struct Debugger(UnixStream);

impl Debugger {
    /// Connects, which stops the core.
    fn attach(socket: &Path) -> Self {
        let deadline = Instant::now() + Duration::from_secs(5);
        loop {
            match UnixStream::connect(socket) {
                Ok(stream) => {
                    stream
                        .set_read_timeout(Some(Duration::from_secs(5)))
                        .unwrap();
                    // Why it stopped comes by itself, and once more when it is asked.
                    let mut debugger = Self(stream);
                    debugger.send("?");
                    // Only who has asked for the registers' names may write one.
                    debugger.ask("qXfer:features:read:target.xml:0,ff");
                    return debugger;
                }
                Err(error) => assert!(Instant::now() < deadline, "{error}"),
            }
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    fn send(&mut self, packet: &str) {
        let sum = packet
            .bytes()
            .fold(0_u8, |sum, byte| sum.wrapping_add(byte));
        write!(self.0, "${packet}#{sum:02x}").unwrap();
    }

    /// Sends a packet and takes its answer: the first that says no more than why the core
    /// has stopped.
    fn ask(&mut self, packet: &str) -> String {
        self.send(packet);
        loop {
            let answer = self.receive();
            if !answer.starts_with('T') {
                return answer;
            }
        }
    }

    /// The next packet, without its frame.
    fn receive(&mut self) -> String {
        let mut byte = [0];
        let mut answer = String::new();
        while !answer.ends_with('#') {
            self.0.read_exact(&mut byte).unwrap();
            match byte[0] {
                b'+' | b'-' if answer.is_empty() => {}
                b'$' => answer.clear(),
                other => answer.push(char::from(other)),
            }
        }
        // The sum of the answer, and ours that it was taken.
        self.0.read_exact(&mut [0; 2]).unwrap();
        self.0.write_all(b"+").unwrap();
        answer.trim_end_matches('#').to_owned()
    }

    fn set_register(&mut self, number: u8, value: u32) {
        let hex: String = value
            .to_le_bytes()
            .map(|byte| format!("{byte:02x}"))
            .concat();
        assert_eq!(self.ask(&format!("P{number:x}={hex}")), "OK");
    }

    fn write(&mut self, address: u32, bytes: &[u8]) {
        let hex: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        let answer = self.ask(&format!("M{address:x},{:x}:{hex}", bytes.len()));
        assert_eq!(answer, "OK", "{address:#x}");
    }

    /// Lets the core run on and leaves it alone.
    fn detach(mut self) {
        assert_eq!(self.ask("D"), "OK");
    }
}

/// A board in QEMU with a debugger's socket.
struct Bench {
    board: Board,
    socket: PathBuf,
    image: &'static Image,
}

impl Bench {
    fn new() -> Option<Self> {
        let image = common::image()?;
        let socket = std::env::temp_dir().join(format!(
            "ipf-debugger-{}-{:?}",
            std::process::id(),
            std::thread::current().id()
        ));
        let options = QemuOptions {
            debugger: Some(socket.clone()),
            ..QemuOptions::default()
        };
        let mut board = Board::in_qemu(image, &options).unwrap();
        board.greet().unwrap();
        Some(Self {
            board,
            socket,
            image,
        })
    }

    /// Stops the core, changes it, and lets it go.
    fn provoke(&self, change: impl FnOnce(&mut Debugger)) {
        provoke(&self.socket, change);
    }

    /// What the board says after its next boot message: how it ended, if it says so, and
    /// how it has begun.
    fn next_boot(&mut self) -> (Option<PostMortem>, Supervision) {
        let mut post_mortem = None;
        loop {
            match self.board.next_message().unwrap() {
                Message::Boot(_) => {
                    // The very next message is the record.
                    if let Message::PostMortem(record) = self.board.next_message().unwrap() {
                        post_mortem = Some(record);
                    }
                }
                Message::Supervision(supervision) if post_mortem.is_some() => {
                    return (post_mortem, supervision);
                }
                _ => {}
            }
        }
    }

    /// Ends the life in a panic as if a line of a file had found itself wrong.
    fn panic_at(&self, file: &str, line: u32) {
        panic_at(&self.socket, self.image, file, line);
    }
}

fn provoke(socket: &Path, change: impl FnOnce(&mut Debugger)) {
    let mut debugger = Debugger::attach(socket);
    change(&mut debugger);
    debugger.detach();
}

fn panic_at(socket: &Path, image: &Image, file: &str, line: u32) {
    // `core::panicking::panic(message)`, which takes the place of its caller too.
    let panic = image
        .address_of(|name| name.ends_with("4core9panicking5panic"))
        .unwrap() as u32;
    provoke(socket, |debugger| {
        debugger.write(SCRATCH, file.as_bytes());
        let location: Vec<u8> = [SCRATCH, file.len() as u32, line, 1]
            .into_iter()
            .flat_map(u32::to_le_bytes)
            .collect();
        debugger.write(SCRATCH + 0x100, &location);
        debugger.set_register(0, SCRATCH);
        debugger.set_register(1, 4);
        debugger.set_register(2, SCRATCH + 0x100);
        debugger.set_register(PC, panic & !1);
    });
}

impl Drop for Bench {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.socket);
    }
}

#[test]
fn f55_a_panic_comes_back_as_its_place_after_the_reset() {
    let Some(mut bench) = Bench::new() else {
        return;
    };
    bench.panic_at("src/some/where.rs", 4242);
    let (record, supervision) = bench.next_boot();
    let record = record.unwrap();
    assert_eq!(record.cause, FailureCause::Panic);
    assert_eq!(
        (record.place.as_str(), record.line),
        ("src/some/where.rs", 4242)
    );
    assert_eq!(supervision.mode, Mode::Normal);
    assert_eq!(
        supervision.reset,
        ResetCause::Unknown,
        "an emulator says nothing"
    );
}

#[test]
fn f56_an_undefined_instruction_comes_back_with_its_address() {
    let Some(mut bench) = Bench::new() else {
        return;
    };
    bench.provoke(|debugger| {
        // udf #0
        debugger.write(SCRATCH, &[0x00, 0xde]);
        debugger.set_register(PC, SCRATCH);
    });
    let record = bench.next_boot().0.unwrap();
    assert_eq!(record.cause, FailureCause::Fault);
    assert_eq!(record.registers.pc, SCRATCH);
    // Usage fault: undefined instruction.
    assert_eq!(record.registers.cfsr >> 16, 1, "{record:?}");
}

#[test]
fn f56_an_access_to_nothing_comes_back_with_both_addresses() {
    let Some(mut bench) = Bench::new() else {
        return;
    };
    bench.provoke(|debugger| {
        // ldr r0, [r0]
        debugger.write(SCRATCH, &[0x00, 0x68]);
        debugger.set_register(0, 0x6000_0000);
        debugger.set_register(PC, SCRATCH);
    });
    let record = bench.next_boot().0.unwrap();
    assert_eq!(record.cause, FailureCause::Fault);
    assert_eq!(record.registers.pc, SCRATCH);
    assert_eq!(record.registers.address, 0x6000_0000, "{record:?}");
}

#[test]
fn f5c_an_interrupt_without_a_handler_comes_back_as_its_number() {
    // Interrupts CAN1_RX1 and DMA1_STREAM0, and PendSV.
    for (exception, writes) in [
        (16 + 21, [(0xe000_e100, 1 << 21), (0xe000_e200, 1 << 21)]),
        (16 + 11, [(0xe000_e100, 1 << 11), (0xe000_e200, 1 << 11)]),
        (14, [(0xe000_ed04, 1 << 28); 2]),
    ] {
        let Some(mut bench) = Bench::new() else {
            return;
        };
        bench.provoke(|debugger| {
            // str r1, [r0]; str r3, [r2]; b to itself
            debugger.write(SCRATCH, &[0x01, 0x60, 0x13, 0x60, 0xfe, 0xe7]);
            for (register, value) in (0..).zip(writes.into_iter().flat_map(<[u32; 2]>::from)) {
                debugger.set_register(register, value);
            }
            debugger.set_register(PC, SCRATCH);
        });
        let record = bench.next_boot().0.unwrap();
        assert_eq!(record.cause, FailureCause::Panic, "{record:?}");
        assert_eq!(record.place, "unhandled exception");
        assert_eq!(record.line, exception);
        let pc = record.registers.pc;
        assert!((SCRATCH..SCRATCH + 6).contains(&pc), "{record:?}");
    }
}

#[test]
fn f57_a_stack_that_meets_its_guard_comes_back_as_that() {
    let Some(mut bench) = Bench::new() else {
        return;
    };
    bench.provoke(|debugger| {
        // push {r0-r7}; b to itself: down through the stack, whatever its size.
        debugger.write(SCRATCH, &[0xff, 0xb4, 0xfd, 0xe7]);
        debugger.set_register(PC, SCRATCH);
    });
    let record = bench.next_boot().0.unwrap();
    assert_eq!(record.cause, FailureCause::StackOverflow, "{record:?}");
}

#[test]
fn f57_a_stack_pointer_within_the_guard_is_survived_too() {
    let Some(mut bench) = Bench::new() else {
        return;
    };
    let statics = bench.image.address_of(|name| name == "_stack_end").unwrap();
    let guard = (statics as u32).next_multiple_of(1024);
    bench.provoke(|debugger| {
        debugger.write(SCRATCH, &[0xff, 0xb4, 0xfd, 0xe7]);
        // Nothing can be put on it, not even the frame of the fault.
        debugger.set_register(SP, guard + 512);
        debugger.set_register(PC, SCRATCH);
    });
    let record = bench.next_boot().0.unwrap();
    assert_eq!(record.cause, FailureCause::StackOverflow, "{record:?}");
}

#[test]
fn f6a_a_recording_of_an_image_that_fails_continues_in_another_part() {
    let Some(mut bench) = Bench::new() else {
        return;
    };
    let config = Config {
        step_rule: StepRule::PerTick { own_clock: true },
        source: Source::Board,
        ..Config::amiro(Profile::Plus)
    };
    // Where each part is written; a writer of its own for each.
    let files: [Shared; 2] = Default::default();
    let Bench {
        board,
        socket,
        image,
    } = &mut bench;
    let mut statuses = 0;
    let mut ends = Vec::new();
    let parts = record(
        board,
        &config,
        |part| Ok(files[part as usize - 1].clone()),
        |event| {
            match event {
                RecordingEvent::Message(Message::Status(_)) => {
                    statuses += 1;
                    if statuses == 10 {
                        panic_at(socket, image, "src/node.rs", 77);
                    }
                }
                RecordingEvent::Message(Message::PostMortem(record)) => {
                    ends.push((record.cause, record.place.to_string(), record.line));
                }
                _ => {}
            }
            statuses < 20
        },
    )
    .unwrap();
    assert_eq!(parts, 2);
    assert_eq!(ends, [(FailureCause::Panic, "src/node.rs".to_owned(), 77)]);
    for (place, file) in files.iter().enumerate() {
        let recording = log::read_from(&file.0.borrow()[..]).unwrap();
        assert!(recording.refusals.is_empty(), "{}", recording.refusals);
        // Which image it was, and, in the second part, how it died.
        let count =
            |is: fn(&Message) -> bool| recording.messages.iter().filter(|it| is(it)).count();
        assert_eq!(count(|event| matches!(event, Message::Boot(_))), 1);
        assert_eq!(
            count(|event| matches!(event, Message::PostMortem(_))),
            place
        );
        // Without sensors there are ticks, each refused: on the board and again here.
        let config = recording.config.unwrap();
        let outcome = run(&config, &recording.inputs, |_| ()).unwrap();
        let faults: Vec<(InputError, u64)> = outcome.faults().collect();
        assert!(
            matches!(faults[..], [(InputError::NoReading, 8..=10)]),
            "{faults:?}"
        );
    }
}

/// Bytes that a recorder writes and a test reads.
#[derive(Clone, Default)]
struct Shared(Rc<RefCell<Vec<u8>>>);

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.borrow_mut().write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn f58_the_third_death_in_ten_seconds_ends_in_the_safe_mode() {
    let Some(mut bench) = Bench::new() else {
        return;
    };
    let mut modes = Vec::new();
    for _ in 0..3 {
        bench.panic_at("src/again.rs", 7);
        let (record, supervision) = bench.next_boot();
        assert_eq!(record.unwrap().line, 7);
        modes.push(supervision.mode);
    }
    assert_eq!(modes, [Mode::Normal, Mode::Normal, Mode::SafeAfterDeaths]);
    // It talks: greetings are answered, statuses come, and all else is refused.
    bench.board.greet().unwrap();
    let config = amiro_ipf::node::Config::default();
    let mut refused = None;
    drive(
        &mut bench.board,
        &[Input::Configure(config)],
        |_| (),
        |_, fault| refused = fault,
    )
    .unwrap();
    assert_eq!(refused, Some(InputError::SafeMode));
    let status = bench.board.next_message();
    assert!(status.is_ok(), "{status:?}");
}

/// The first word about itself of an image with a flipped bit; `None` if it says none.
fn flipped(image: &Image, byte: usize) -> Option<Supervision> {
    let options = QemuOptions {
        flipped: Some(byte),
        ..QemuOptions::default()
    };
    let mut board = Board::in_qemu(image, &options).unwrap();
    loop {
        match board.next_message() {
            Ok(Message::Supervision(supervision)) => return Some(supervision),
            Ok(_) => {}
            Err(LinkError::Silent | LinkError::Gone) => return None,
            Err(error) => unreachable!("{error}"),
        }
    }
}

#[test]
fn f5a_a_flipped_bit_in_the_flash_is_found_and_nothing_is_filtered() {
    let Some(image) = common::image() else { return };
    let length = image.flash().len();
    // Bytes that the start does not need: near the end are constants, and in the vector
    // table those of units that are never started.
    for byte in [0x170, length - 1, length - 700, length - 3_000] {
        let supervision = flipped(image, byte).unwrap();
        assert_eq!(supervision.image, ImageCheck::Damaged, "byte {byte:#x}");
        assert_eq!(supervision.mode, Mode::SafeForImage, "byte {byte:#x}");
    }
    let whole = flipped(image, usize::MAX).unwrap();
    assert_eq!((whole.image, whole.mode), (ImageCheck::Good, Mode::Normal));
}

#[test]
fn a_second_s_supervision_reports_the_unused_stack() {
    let Some(mut bench) = Bench::new() else {
        return;
    };
    let room = bench.image.stack_room() as u32;
    loop {
        if let Message::Supervision(supervision) = bench.board.next_message().unwrap()
            && supervision.stack_unused > 0
        {
            // Two fifths of the stack stay unused at least; the guard takes up to 2 KiB.
            let used = room - supervision.stack_unused;
            assert!(used * 5 <= room * 3, "{used} of {room} bytes");
            return;
        }
    }
}
