//! Text in a cell of a CSV file: quoted by RFC 4180 and harmless in spreadsheets.
//!
//! A spreadsheet takes a cell that begins with `=`, `+`, `-`, `@` (some also by their wide forms), a tab or a line's end
//! for a formula, which can read files or call programs. Such *text* gets an apostrophe before it, as does text that begins
//! with an apostrophe; to get the text back, take one apostrophe from cells of text that begin with one.
//! Numbers are never changed.

use crate::dialect::Format;

/// Characters that some spreadsheets take for `=`, `+`, `-` and `@`.
const WIDE: [&str; 4] = ["＝", "＋", "－", "＠"];

/// Appends text as one cell, [escaped](imc::text::escape) where it is not text.
pub fn text(out: &mut Vec<u8>, bytes: &[u8], format: Format) {
    quoted(out, &imc::text::escape(bytes), format);
}

/// Appends text that needs no escape, such as JSON, which has its own.
pub fn quoted(out: &mut Vec<u8>, text: &str, format: Format) {
    let text = text.as_bytes();
    let separator = format.dialect.separator();
    let risky = format.guard
        && (matches!(text.first(), Some(b'=' | b'+' | b'-' | b'@' | b'\t' | b'\r' | b'\n' | b'\''))
            || WIDE.iter().any(|sign| text.starts_with(sign.as_bytes())));
    let quoted = text.iter().any(|byte| matches!(byte, b'"' | b'\n' | b'\r') || *byte == separator);
    if quoted {
        out.push(b'"');
    }
    if risky {
        out.push(b'\'');
    }
    if quoted {
        for byte in text {
            if *byte == b'"' {
                out.push(b'"');
            }
            out.push(*byte);
        }
        out.push(b'"');
    } else {
        out.extend_from_slice(text);
    }
}

/// Appends bytes in hexadecimal.
pub fn hex(out: &mut Vec<u8>, bytes: &[u8]) {
    let start = out.len();
    out.resize(start + 2 * bytes.len(), 0);
    // There is room for two digits of each byte.
    hex::encode_to_slice(bytes, &mut out[start..]).unwrap_or_default();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dialect::Dialect;

    fn cell(value: &str) -> String {
        let mut out = Vec::new();
        text(&mut out, value.as_bytes(), Format::default());
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn formulas_become_text_and_come_back() {
        for value in [
            "=cmd|' /C calc'!A0",
            "+1",
            "-1",
            "@SUM(A1)",
            "\tx",
            "\rx",
            "\nx",
            "'x",
            "''=1",
            "＝1",
            "＋1",
            "－1",
            "＠a",
        ] {
            let written = cell(value);
            let read = written.trim_matches('"').replace("\"\"", "\"");
            assert!(read.starts_with('\''), "{written}");
            assert_eq!(&read[1..], value);
        }
        assert_eq!(cell("a=1"), "a=1");
    }

    #[test]
    fn quotes_by_rfc_4180() {
        assert_eq!(cell("a,b"), "\"a,b\"");
        assert_eq!(cell("say \"hi\"\n"), "\"say \"\"hi\"\"\n\"");
        assert_eq!(cell("=\"a\""), "\"'=\"\"a\"\"\"");
        assert_eq!(cell(""), "");
        let mut out = Vec::new();
        let format = Format { dialect: Dialect::SpreadsheetComma, guard: false };
        text(&mut out, b"a,b", format);
        format.next(&mut out);
        text(&mut out, b"a;b", format);
        assert_eq!(out, b"a,b;\"a;b\"");
    }
}
