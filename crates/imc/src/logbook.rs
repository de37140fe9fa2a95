//! What Lutra's vessels write at the end of a log book entry: the command of the shore that led to it, by the number that the
//! shore's logs have. Consoles show it as part of the text.

/// The end of an entry that the command with this number led to.
pub fn of_command(number: u64) -> String {
    format!(" [command {number}]")
}

/// The text of an entry, and the number of the command that led to it, where it names one.
pub fn split_command(text: &str) -> (&str, Option<u64>) {
    let split = || {
        let (said, end) = text.rsplit_once(" [command ")?;
        Some((said, end.strip_suffix(']')?.parse().ok()?))
    };
    split().map_or((text, None), |(said, number)| (said, Some(number)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_is_found_where_it_was_written_and_nowhere_else() {
        let entry = format!("stopped by 0x4001{}", of_command(1_790_000_000_000));
        assert_eq!(split_command(&entry), ("stopped by 0x4001", Some(1_790_000_000_000)));
        for text in ["", "stopped", "x [command ]", "x [command 7] y", "x [command -7]"] {
            assert_eq!(split_command(text), (text, None));
        }
    }
}
