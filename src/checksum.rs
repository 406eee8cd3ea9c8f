//! Checksums: CRC-32 against damage on the line, a digest against drift of the filter.

/// CRC-32/ISO-HDLC (polynomial 0x04c11db7 reflected; the CRC of Ethernet and zip).
pub static CRC: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);

/// A running 32-bit digest of words, in five instructions per word.
///
/// It detects a difference between two runs of a deterministic program; the first
/// difference changes all later digests. It does not protect against damage or intent. Each
/// word does h = (rotate_left(h, 5) xor word) * 0x9e3779b1, from h = 0; the multiplier is
/// odd, so no information about h is lost.
#[derive(Clone, Copy, Debug, Default)]
pub struct Digest(u32);

impl Digest {
    /// Takes a word.
    #[inline]
    pub fn update(&mut self, word: u32) {
        self.0 = (self.0.rotate_left(5) ^ word).wrapping_mul(0x9e37_79b1);
    }

    /// The digest of the words so far.
    #[must_use]
    pub const fn value(self) -> u32 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digest_depends_on_every_bit_and_on_the_order() {
        let digest = |words: &[u32]| {
            let mut digest = Digest::default();
            words.iter().for_each(|&word| digest.update(word));
            digest.value()
        };
        let words = [3, 1, 4, 1, 5, 9, 2, 6];
        let reference = digest(&words);
        for index in 0..words.len() {
            for bit in 0..32 {
                let mut changed = words;
                changed[index] ^= 1 << bit;
                assert_ne!(digest(&changed), reference, "word {index}, bit {bit}");
            }
        }
        assert_ne!(digest(&[1, 3, 4, 1, 5, 9, 2, 6]), reference);
    }

    #[test]
    fn check_value_is_the_catalogue_s() {
        assert_eq!(CRC.checksum(b"123456789"), 0xcbf4_3926);
    }
}
