//! The flash image behind a boot loader that leaves the core in a bad state, in QEMU.

use amiro_ipf::board::supervision::{Mode, PostMortem, Supervision};
use amiro_ipf::filter::Profile;
use amiro_ipf::geometry::Pose;
use amiro_ipf::link::Message;
use amiro_ipf::model::Sample;
use amiro_ipf::node::{Config, Input};
use sim_harness::device::{Board, Comparison, LinkError, QemuOptions, drive};
use sim_harness::run;

use crate::common;

/// Start of the image, and its vector table.
const IMAGE: u32 = 0x0800_8000;

// CoreRegisters of the core (ARMv7-M Architecture Reference Manual, B3.2 to B3.5).
const SYST_CSR: u32 = 0xe000_e010;
const SYST_RVR: u32 = 0xe000_e014;
const NVIC_ISER: u32 = 0xe000_e100;
const NVIC_ISPR: u32 = 0xe000_e200;
const ICSR: u32 = 0xe000_ed04;
const VTOR: u32 = 0xe000_ed08;
const AIRCR: u32 = 0xe000_ed0c;
const SCR: u32 = 0xe000_ed10;
const CCR: u32 = 0xe000_ed14;
const SHCSR: u32 = 0xe000_ed24;
const CPACR: u32 = 0xe000_ed88;
const MPU_CTRL: u32 = 0xe000_ed94;
const MPU_RNR: u32 = 0xe000_ed98;
const MPU_RBAR: u32 = 0xe000_ed9c;
const MPU_RASR: u32 = 0xe000_eda0;
const FPDSCR: u32 = 0xe000_ef3c;

const PENDSV: Write = (ICSR, 1 << 28);
const FPU_ON: Write = (CPACR, 0xf << 20);
const OUR_VECTORS: Write = (VTOR, IMAGE);

/// A word and the address that it is written to, which stands first.
type Write = (u32, u32);

/// A name, whether the boot loader lets interrupts in, and what it writes.
type Case = (&'static str, bool, Vec<Write>);

/// Number of the interrupt CAN1_RX1, for which the image has no handler.
const CAN1_RX1: u32 = 21;

/// Floating point status and control: flush to zero, round towards plus infinity.
const OTHER_ROUNDING: u32 = 1 << 24 | 1 << 22;

/// A boot loader as machine code: it lets interrupts in or not, writes words to
/// addresses, sets the floating point status, and starts the image as AMiRo's does: the
/// stack from word 0, a jump to word 1.
fn boot_loader(lets_interrupts_in: bool, writes: &[Write], fpscr: u32) -> Vec<u8> {
    const CODE: usize = 0x200;
    let code: [u16; 24] = [
        if lets_interrupts_in { 0xb662 } else { 0xb672 }, // cpsie i, cpsid i
        0xa00b,                                           // adr r0, table
        0xf850,
        0x1b04, // next: ldr r1, [r0], #4
        0xb139, // cbz r1, end
        0xf850,
        0x2b04, // ldr r2, [r0], #4
        0x600a, // str r2, [r1]
        0xf3bf,
        0x8f4f, // dsb
        0xf3bf,
        0x8f6f, // isb
        0xe7f4, // b next
        0xf850,
        0x1b04, // end: ldr r1, [r0], #4
        0xeee1,
        0x1a10, // vmsr fpscr, r1
        0x6800, // ldr r0, [r0]
        0x6801, // ldr r1, [r0]
        0xf381,
        0x8808, // msr msp, r1
        0x6841, // ldr r1, [r0, #4]
        0x4708, // bx r1
        0xe7fe, // b to itself, where all other vectors lead
    ];
    let start = 0x0800_0000 + CODE as u32 + 1;
    let endless = start + 2 * (code.len() as u32 - 1);
    let mut words = vec![endless; CODE / 4];
    words[0] = 0x2002_0000;
    words[1] = start;
    let mut bytes: Vec<u8> = words.into_iter().flat_map(u32::to_le_bytes).collect();
    bytes.extend(code.into_iter().flat_map(u16::to_le_bytes));
    let table = writes.iter().flat_map(|&(address, word)| [address, word]);
    bytes.extend(table.chain([0, fpscr, IMAGE]).flat_map(u32::to_le_bytes));
    bytes
}

/// The board with this boot loader before its image; `None` where it cannot be run.
fn board_behind(boot_loader: Vec<u8>) -> Option<Board> {
    let image = common::amiro_image()?;
    let options = QemuOptions {
        boot_loader: Some(boot_loader),
        ram_fill: Some(0xa5),
        ..QemuOptions::default()
    };
    Some(Board::in_qemu(image, &options).unwrap())
}

/// What the board sends about itself at its start: how the life before ended, and
/// how this one began.
fn first_words(board: &mut Board) -> Result<(Option<PostMortem>, Supervision), LinkError> {
    let mut post_mortem = None;
    loop {
        match board.next_message()? {
            Message::PostMortem(record) => post_mortem = Some(record),
            Message::Supervision(supervision) => return Ok((post_mortem, supervision)),
            _ => {}
        }
    }
}

#[test]
fn f5c_interrupts_that_a_boot_loader_left_pending_do_not_stop_the_start() {
    let enabled = (NVIC_ISER, 1 << CAN1_RX1);
    let pending = (NVIC_ISPR, 1 << CAN1_RX1);
    let tick = [(SYST_RVR, 1_000), (SYST_CSR, 7)];
    let cases: [Case; 7] = [
        ("nothing", false, vec![OUR_VECTORS]),
        ("PendSV, masked", false, vec![PENDSV, OUR_VECTORS]),
        ("PendSV, taken", true, vec![OUR_VECTORS, PENDSV]),
        (
            "CAN1_RX1, masked",
            false,
            vec![enabled, pending, OUR_VECTORS],
        ),
        ("CAN1_RX1, taken", true, vec![OUR_VECTORS, enabled, pending]),
        (
            "every line, masked",
            false,
            (0..3)
                .flat_map(|word| [NVIC_ISER, NVIC_ISPR].map(|it| (it + 4 * word, u32::MAX)))
                .chain([OUR_VECTORS])
                .collect(),
        ),
        (
            "SysTick, masked",
            false,
            tick.into_iter().chain([OUR_VECTORS]).collect(),
        ),
    ];
    for (name, lets_interrupts_in, mut writes) in cases {
        writes.insert(0, FPU_ON);
        let Some(mut board) = board_behind(boot_loader(lets_interrupts_in, &writes, 0)) else {
            return;
        };
        let (post_mortem, supervision) =
            first_words(&mut board).unwrap_or_else(|error| unreachable!("{name}: {error}"));
        assert_eq!(post_mortem, None, "{name}");
        assert_eq!(supervision.mode, Mode::Normal, "{name}");
    }
}

/// A wall on the left, driven along at 80 mm/s with the sensors at 125 Hz.
fn inputs() -> Vec<Input> {
    (0..150)
        .flat_map(|row| {
            let stamp_us = row * 8_000;
            let pose = Pose::new(row as f32 * 0.64e-3, 0.0, 0.0);
            let mut samples = [Sample::Counts((row % 5) as i32); 8];
            samples[1] = Sample::Counts(110 - (row % 3) as i32);
            samples[2] = Sample::Counts(100 + (row % 7) as i32);
            [
                Input::Odometry { stamp_us, pose },
                Input::Proximity { stamp_us, samples },
            ]
        })
        .collect()
}

#[test]
fn f5c_what_a_boot_loader_left_in_the_core_changes_no_digest() {
    let writes = [
        FPU_ON,
        (FPDSCR, OTHER_ROUNDING),
        // Faults of their own, traps of unaligned accesses and of divisions by zero.
        (SHCSR, 7 << 16),
        (CCR, 1 << 9 | 1 << 4 | 1 << 3),
        // All priorities in one group, sleep as soon as an interrupt returns, deeply.
        (AIRCR, 0x05fa_0700),
        (SCR, 1 << 2 | 1 << 1),
        // Nobody may write to 32 KiB of the RAM.
        (MPU_RNR, 7),
        (MPU_RBAR, 0x2000_0000),
        (MPU_RASR, 7 << 24 | 14 << 1 | 1),
        (MPU_CTRL, 1 << 2),
        OUR_VECTORS,
    ];
    let Some(mut board) = board_behind(boot_loader(false, &writes, OTHER_ROUNDING)) else {
        return;
    };
    let config = Config::amiro(Profile::Plus);
    let mut comparison = Comparison::default();
    let outcome = run(&config, &inputs(), |event| comparison.expect(event)).unwrap();
    assert!(outcome.steps > 0, "{outcome:?}");
    board.greet().unwrap();
    let mut all = vec![Input::Configure(config)];
    all.extend(inputs());
    drive(&mut board, &all, |event| comparison.meet(event), |_, _| ()).unwrap();
    let verdict = comparison.verdict(board.boot(), &board.tally());
    assert!(verdict.equal, "{verdict}");
}
