//! The one checksum of the project: CRC-32/ISO-HDLC, for frames and digests.

/// CRC-32/ISO-HDLC (polynomial 0x04c11db7 reflected; the CRC of Ethernet and zip).
pub static CRC: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);

#[cfg(test)]
mod tests {
    #[test]
    fn check_value_is_the_catalogue_s() {
        assert_eq!(super::CRC.checksum(b"123456789"), 0xcbf4_3926);
    }
}
