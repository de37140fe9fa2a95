//! Output of a faulty device: the right format with invalid values.

use devices::can::{CanFrame, CanId};

/// Each byte of a frame's values: far out of range for numbers of any size.
const BEYOND: u8 = 0x80;

/// A line of text whose numeric fields are not numbers any more, with a valid checksum if it had one.
pub(super) fn line(line: &[u8]) -> Vec<u8> {
    let text = String::from_utf8_lossy(line);
    let body = text.trim_matches(|c: char| c.is_ascii_control());
    let (leading, ending) = text.split_once(body).unwrap_or((&text, ""));
    let Some(sentence) = body.strip_prefix('$') else { return line.to_vec() };
    let (fields, had_sum) = sentence.split_once('*').map_or((sentence, false), |(fields, _)| (fields, true));
    let mut fields: Vec<&str> = fields.split(',').collect();
    for field in fields.iter_mut().skip(1).filter(|field| field.bytes().any(|byte| byte.is_ascii_digit())) {
        *field = "nan";
    }
    let fields = fields.join(",");
    let sum = fields.bytes().fold(0, |sum, byte| sum ^ byte);
    let sum = if had_sum { format!("*{sum:02X}") } else { String::new() };
    format!("{leading}${fields}{sum}{ending}").into_bytes()
}

/// A frame of the motor card: the same message, with values far out of range.
pub(super) fn frame(frame: &CanFrame) -> CanFrame {
    let mut data = frame.data().to_vec();
    data.iter_mut().skip(1).for_each(|byte| *byte = BEYOND);
    CanFrame::with_id(CanId::Extended(frame.id()), &data).unwrap_or(*frame)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences_keep_their_form_and_their_right_checksum() {
        let made = String::from_utf8(line(b"$GPHDT,359.4,T*32\r")).unwrap();
        assert_eq!(made, "$GPHDT,nan,T*7A\r");
        assert_eq!(line(b"$1044,0000600,TBR Sensor,297,12\r"), b"$1044,nan,TBR Sensor,nan,nan\r");
        assert_eq!((line(b"\n"), line(b"ack01\r")), (b"\n".to_vec(), b"ack01\r".to_vec()));
    }

    #[test]
    fn frames_keep_their_part() {
        let made = frame(&CanFrame::new(0x00E0_ABFF, &[2, 20, 0, 12, 0, 0, 80, 0]).unwrap());
        assert_eq!(
            (made.id(), made.data()),
            (0x00E0_ABFF, &[2, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80][..])
        );
    }
}
