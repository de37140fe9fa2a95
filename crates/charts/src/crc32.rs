//! The checksum of catalogue files and of saved indexes: CRC-32 of ISO 3309 and IEEE 802.3 (S-57 appendix B.1, 5.6.3).

/// The checksum of some bytes.
pub(crate) fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |crc, byte| {
        let at = (crc ^ u32::from(*byte)) & 0xFF;
        TABLE[at as usize] ^ (crc >> 8)
    })
}

const TABLE: [u32; 256] = {
    let mut table = [0; 256];
    let mut at = 0;
    while at < 256 {
        let mut value = at as u32;
        let mut bit = 0;
        while bit < 8 {
            value = if value & 1 == 1 { 0xEDB8_8320 ^ (value >> 1) } else { value >> 1 };
            bit += 1;
        }
        table[at] = value;
        at += 1;
    }
    table
};

#[cfg(test)]
mod tests {
    #[test]
    fn matches_the_check_value() {
        // The check value of the Rocksoft model for CRC-32.
        assert_eq!(super::crc32(b"123456789"), 0xCBF4_3926);
    }
}
