//! A CAN frame.

use super::{CanIdentifier, StandardId};

/// A frame as it is on the bus: identifier, kind, at most eight bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CanFrame {
    identifier: CanIdentifier,
    is_remote: bool,
    length: u8,
    /// Zero beyond the length, so that equal frames are equal.
    bytes: [u8; 8],
}

impl CanFrame {
    /// A data frame with an 11-bit identifier; more than eight bytes do not compile.
    #[must_use]
    pub fn data<const LENGTH: usize>(identifier: StandardId, payload: [u8; LENGTH]) -> Self {
        const { assert!(LENGTH <= 8, "a frame has at most eight bytes") };
        let mut bytes = [0; 8];
        for (byte, given) in bytes.iter_mut().zip(payload) {
            *byte = given;
        }
        Self {
            identifier: CanIdentifier::Standard(identifier),
            is_remote: false,
            length: LENGTH as u8,
            bytes,
        }
    }

    /// A frame as a controller hands it over.
    ///
    /// `length_code` is the frame's DLC: 9 to 15 mean eight bytes as 8 does (ISO
    /// 11898-1). Bytes beyond the length are set to zero. A remote frame asks for data
    /// and has none, whatever its length code.
    #[must_use]
    pub fn received(
        identifier: CanIdentifier,
        is_remote: bool,
        length_code: u8,
        mut bytes: [u8; 8],
    ) -> Self {
        let length = length_code.min(8);
        let kept = if is_remote { 0 } else { usize::from(length) };
        for byte in bytes.iter_mut().skip(kept) {
            *byte = 0;
        }
        Self {
            identifier,
            is_remote,
            length,
            bytes,
        }
    }

    /// The identifier.
    #[must_use]
    pub const fn identifier(&self) -> CanIdentifier {
        self.identifier
    }

    /// Whether the frame requests data instead of carrying some.
    #[must_use]
    pub const fn is_remote(&self) -> bool {
        self.is_remote
    }

    /// The length that the frame names, 0 to 8.
    #[must_use]
    pub const fn length(&self) -> u8 {
        self.length
    }

    /// All eight bytes; zero beyond the payload.
    #[must_use]
    pub const fn bytes(&self) -> [u8; 8] {
        self.bytes
    }

    /// The payload; none in a remote frame.
    #[must_use]
    pub fn payload(&self) -> &[u8] {
        let length = if self.is_remote { 0 } else { self.length };
        self.bytes.get(..usize::from(length)).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ID: CanIdentifier = CanIdentifier::Standard(StandardId::ODOMETRY);

    #[test]
    fn bytes_beyond_the_length_are_zero() {
        let frame = CanFrame::received(ID, false, 3, [1, 2, 3, 4, 5, 6, 7, 8]);
        assert_eq!(frame.payload(), [1, 2, 3]);
        assert_eq!(frame.bytes(), [1, 2, 3, 0, 0, 0, 0, 0]);
        assert_eq!(frame, CanFrame::data(StandardId::ODOMETRY, [1, 2, 3]));
    }

    #[test]
    fn length_codes_beyond_eight_are_eight() {
        for code in 8..=15 {
            assert_eq!(
                CanFrame::received(ID, false, code, [7; 8]).payload(),
                [7; 8],
                "{code}"
            );
        }
    }

    #[test]
    fn remote_frame_has_a_length_and_no_payload() {
        let frame = CanFrame::received(ID, true, 8, [7; 8]);
        assert_eq!((frame.length(), frame.payload()), (8, &[][..]));
        let zeros = CanFrame::received(ID, false, 8, [0; 8]);
        assert_ne!(frame, zeros);
        assert_eq!((frame.is_remote(), zeros.is_remote()), (true, false));
    }
}
