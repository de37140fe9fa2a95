//! ORCID: the number of a researcher, whose last digit checks the others (ISO 7064, MOD 11-2).

/// Whether a text is an ORCID in its written form, `0000-0002-1825-0097`, with the right check digit.
pub fn is_orcid(text: &str) -> bool {
    let groups: Vec<&str> = text.split('-').collect();
    if groups.len() != 4 || groups.iter().any(|group| group.len() != 4) {
        return false;
    }
    let letters: Vec<u8> = text.bytes().filter(|byte| *byte != b'-').collect();
    let Some((check, digits)) = letters.split_last() else { return false };
    if !digits.iter().all(u8::is_ascii_digit) {
        return false;
    }
    let total = digits.iter().fold(0_u32, |total, digit| (total + u32::from(digit - b'0')) * 2 % 11);
    let wanted = match (12 - total) % 11 {
        10 => b'X',
        digit => b'0' + digit as u8,
    };
    *check == wanted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_digit_checks_the_others() {
        // Those of the ORCID documentation.
        for text in ["0000-0002-1825-0097", "0000-0001-5109-3700", "0000-0002-1694-233X"] {
            assert!(is_orcid(text), "{text}");
        }
        for text in [
            "0000-0002-1825-0098",
            "0000-0002-1694-2330",
            "0000-0002-1694-233x",
            "0000000218250097",
            "0000-0002-1825-009",
            "https://orcid.org/0000-0002-1825-0097",
            "",
            "a000-0002-1825-0097",
            "0000-0002-1825-é7",
        ] {
            assert!(!is_orcid(text), "{text}");
        }
    }

    #[test]
    fn a_slip_of_one_digit_is_noticed() {
        let good = "0000-0002-1825-0097";
        for at in (0..good.len()).filter(|at| good.as_bytes()[*at] != b'-') {
            for digit in b'0'..=b'9' {
                let mut bytes = good.as_bytes().to_vec();
                bytes[at] = digit;
                let text = String::from_utf8(bytes).unwrap();
                assert_eq!(is_orcid(&text), text == good, "{text}");
            }
        }
    }
}
