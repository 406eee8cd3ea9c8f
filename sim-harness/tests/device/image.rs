//! The files that are flashed, read as the boot loader and its flashing tool read them.

use std::path::Path;
use std::process::Command;

/// Where AMiRo's boot loader expects an application, and the end of the flash.
const APPLICATION: u32 = 0x0800_8000;
const FLASH_END: u32 = 0x0810_0000;

fn word(bytes: &[u8], offset: usize) -> u32 {
    u32::from_le_bytes(bytes[offset..offset + 4].try_into().unwrap())
}

/// The bytes of an S-record file and where they begin; every sum is checked.
fn read_records(text: &str) -> (u32, Vec<u8>) {
    let mut bytes = Vec::new();
    let mut start = None;
    let mut is_ended = false;
    for line in text.lines() {
        assert!(!is_ended, "a record after the end: {line}");
        let digits = line.strip_prefix('S').unwrap();
        let (kind, digits) = digits.split_at(1);
        let body: Vec<u8> = (0..digits.len())
            .step_by(2)
            .map(|at| u8::from_str_radix(&digits[at..at + 2], 16).unwrap())
            .collect();
        assert_eq!(body.len(), usize::from(body[0]) + 1, "{line}");
        let sum = body.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte));
        assert_eq!(sum, 0xff, "{line}");
        if kind == "0" {
            continue;
        }
        let address = u32::from_be_bytes(body[1..5].try_into().unwrap());
        match kind {
            "3" => {
                let expected = *start.get_or_insert(address) + bytes.len() as u32;
                assert_eq!(address, expected, "{line}");
                bytes.extend_from_slice(&body[5..body.len() - 1]);
            }
            "7" => {
                assert_eq!(Some(address), start, "{line}");
                is_ended = true;
            }
            other => assert_eq!(other, "3 or 7", "{line}"),
        }
    }
    assert!(is_ended, "no record ends the file");
    (start.unwrap(), bytes)
}

fn write_image(layout: &str, out: &Path) {
    let ended = Command::new(env!("CARGO_BIN_EXE_ipf"))
        .args(["image", "--layout", layout, "--out"])
        .arg(out)
        .output()
        .unwrap();
    assert!(ended.status.success(), "{ended:?}");
}

#[test]
fn amiro_s_boot_loader_would_start_the_image() {
    let folder = std::env::temp_dir().join(format!("ipf-image-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let binary = folder.join("firmware.bin");
    write_image("amiro", &binary);
    let bytes = std::fs::read(&binary).unwrap();
    // The loader sums the first seven vectors and the word at 0x1ac: zero, or no start.
    let sum = (0..7)
        .map(|vector| word(&bytes, 4 * vector))
        .chain([word(&bytes, 0x1ac)])
        .fold(0_u32, u32::wrapping_add);
    assert_eq!(sum, 0);
    assert_ne!(word(&bytes, 0x1ac), 0x55aa_11ee, "the placeholder");
    // It then takes the stack from word 0 and jumps to word 1, a Thumb address inside.
    assert_eq!(word(&bytes, 0), 0x2002_0000);
    let reset = word(&bytes, 4);
    assert_eq!(reset & 1, 1);
    assert!((APPLICATION + 0x200..APPLICATION + bytes.len() as u32).contains(&reset));
    // Nothing but that word lies between the 98 vectors and 0x200.
    for offset in (0x188..0x200).filter(|offset| !(0x1ac..0x1b0).contains(offset)) {
        assert!([0, 0xff].contains(&bytes[offset]), "{offset:#x}");
    }
    // The tool flashes the records: the same bytes, and within the application's flash.
    let records = std::fs::read_to_string(folder.join("firmware.srec")).unwrap();
    assert_eq!(read_records(&records), (APPLICATION, bytes.clone()));
    assert!(APPLICATION + bytes.len() as u32 <= FLASH_END);
    std::fs::remove_dir_all(folder).unwrap();
}

#[cfg(unix)]
#[test]
fn an_endless_file_is_given_up_before_it_fills_the_memory() {
    let error = sim_harness::device::Image::read(Path::new("/dev/zero")).unwrap_err();
    assert!(
        error.to_string().contains("more than 67108864 bytes"),
        "{error}"
    );
}
