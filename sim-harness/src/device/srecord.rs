//! Motorola S-records: the text in which AMiRo's flashing tool takes an image.

use std::fmt::Write;

/// Data bytes of one record: lines of 78 characters.
const BYTES_PER_RECORD: usize = 32;

/// An image as S-records with 32-bit addresses: a header (S0), the data (S3), and the
/// address of the start (S7). Lines end with a line feed.
#[must_use]
pub fn to_s_records(name: &str, address: u32, bytes: &[u8]) -> String {
    let mut text = String::new();
    // The count byte covers two address bytes, the name and the checksum.
    let name: Vec<u8> = name.bytes().take(64).collect();
    push_record(&mut text, '0', &[0, 0], &name);
    let mut at = address;
    for chunk in bytes.chunks(BYTES_PER_RECORD) {
        push_record(&mut text, '3', &at.to_be_bytes(), chunk);
        at = at.wrapping_add(BYTES_PER_RECORD as u32);
    }
    push_record(&mut text, '7', &address.to_be_bytes(), &[]);
    text
}

/// A record: kind, count, address, data, and the inverted sum of all bytes before.
fn push_record(text: &mut String, kind: char, address: &[u8], data: &[u8]) {
    let count = (address.len() + data.len() + 1) as u8;
    let body = [&[count], address, data].concat();
    let sum = body.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte));
    let _ = write!(text, "S{kind}");
    for byte in body.iter().chain([&!sum]) {
        let _ = write!(text, "{byte:02X}");
    }
    text.push('\n');
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_are_as_computed_by_hand() {
        // S0: 05 + 00 + 00 + 48 + 49 = 96, inverted 69.
        // S3: 07 + 08 + 00 + 80 + 00 + 01 + 02 = 92, inverted 6D.
        // S7: 05 + 08 + 00 + 80 + 00 = 8D, inverted 72.
        assert_eq!(
            to_s_records("HI", 0x0800_8000, &[1, 2]),
            "S00500004849 69\nS30708008000 0102 6D\nS70508008000 72\n".replace(' ', "")
        );
    }

    #[test]
    fn long_images_go_on_at_the_next_address() {
        let text = to_s_records("", 0x0800_0000, &[0xaa; 70]);
        let data = text.lines().skip(1).take(3);
        let starts: Vec<&str> = data.map(|line| &line[..12]).collect();
        assert_eq!(starts, ["S32508000000", "S32508000020", "S30B08000040"]);
    }
}
