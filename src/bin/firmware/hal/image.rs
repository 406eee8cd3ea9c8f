//! Checks the flash against the image's checksum.

#![expect(unsafe_code, reason = "the linker places the image")]

use amiro_ipf::board::supervision::ImageCheck;
use amiro_ipf::checksum::CRC;

/// Length and checksum of the image, written when a file to flash is made; erased flash,
/// as in the ELF file, means that there is none. The checksum is over the whole image with
/// these eight bytes erased.
// SAFETY: nothing else has this name.
#[unsafe(no_mangle)]
static IMAGE_MARK: [u32; 2] = [UNMARKED; 2];

const UNMARKED: u32 = u32::MAX;

/// Bytes of the mark.
const MARK: usize = 8;

/// No image is longer: the chip's flash.
const LONGEST: usize = 1024 * 1024;

unsafe extern "C" {
    /// The image's first byte, from the linker script.
    static __vector_table: u8;
}

/// Compares the flash with its mark: about 8 ms for 120 kB.
pub(super) fn check() -> ImageCheck {
    let mark = &raw const IMAGE_MARK;
    // SAFETY: a static of our own; volatile, since what the compiler saw it hold is not
    // what is flashed.
    let [length, expected] = unsafe { mark.read_volatile() };
    // Addresses: the image is larger than either object.
    let (start, mark) = ((&raw const __vector_table).addr(), mark.addr());
    let length = length as usize;
    let Some(before) = mark.checked_sub(start) else {
        return ImageCheck::Unmarked;
    };
    if expected == UNMARKED && length == UNMARKED as usize {
        return ImageCheck::Unmarked;
    }
    if length > LONGEST || before + MARK > length {
        return ImageCheck::Damaged;
    }
    let piece = |address: usize, length: usize| {
        let first = core::ptr::with_exposed_provenance::<u8>(address);
        // SAFETY: both pieces lie in the chip's flash, between the image's start and the
        // length that was just found to be no more than the flash, which is not written.
        unsafe { core::slice::from_raw_parts(first, length) }
    };
    let (head, tail) = (
        piece(start, before),
        piece(mark + MARK, length - before - MARK),
    );
    let mut digest = CRC.digest();
    digest.update(head);
    digest.update(&[0xff; MARK]);
    digest.update(tail);
    if digest.finalize() == expected {
        ImageCheck::Good
    } else {
        ImageCheck::Damaged
    }
}
