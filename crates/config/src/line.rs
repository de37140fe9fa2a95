//! Splits a file into lines and recognises the forms of a line, as DUNE's scanner does.
//!
//! DUNE reads with C's `scanf`: white space (empty lines included) in front of every line is skipped, a line
//! ends after 1023 bytes at the latest, and what is left of it is taken as a line of its own. The characters
//! `;`, `|` and `#` end a value wherever they stand; nothing protects them.

/// The longest line that DUNE reads at once, in bytes.
pub const MAX_LINE_BYTES: usize = 1023;

/// The characters that end a value.
pub(crate) const COMMENT_MARKS: [char; 3] = [';', '|', '#'];

/// One line as DUNE's reader passes it on, without the white space in front.
#[derive(Debug)]
pub(crate) struct RawLine<'a> {
    /// Number of the line in the file, from 1.
    pub(crate) number: u32,
    /// At most [`MAX_LINE_BYTES`].
    pub(crate) bytes: &'a [u8],
    /// Whether more of the same line follows as a line of its own.
    pub(crate) cut: bool,
}

/// Iterates over the lines of a file.
#[derive(Debug)]
pub(crate) struct Lines<'a> {
    rest: &'a [u8],
    number: u32,
}

impl<'a> Lines<'a> {
    pub(crate) const fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes, number: 1 }
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = RawLine<'a>;

    fn next(&mut self) -> Option<RawLine<'a>> {
        let blanks = self.rest.iter().take_while(|byte| is_c_space(**byte)).count();
        let (skipped, rest) = self.rest.split_at(blanks);
        self.number += skipped.split(|byte| *byte == b'\n').count() as u32 - 1;
        if rest.is_empty() {
            self.rest = rest;
            return None;
        }
        let end = rest.iter().position(|byte| *byte == b'\n').unwrap_or(rest.len());
        let taken = end.min(MAX_LINE_BYTES);
        let cut = rest[taken..end].iter().any(|byte| !is_c_space(*byte));
        self.rest = &rest[taken..];
        Some(RawLine { number: self.number, bytes: &rest[..taken], cut })
    }
}

/// What C's `isspace` accepts.
fn is_c_space(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\n' | b'\x0b' | b'\x0c' | b'\r')
}

fn is_blank(character: char) -> bool {
    u8::try_from(character).is_ok_and(is_c_space)
}

/// `text` without the white space that C's `isspace` accepts, at both ends.
pub(crate) fn trim(text: &str) -> &str {
    text.trim_matches(is_blank)
}

/// Whether a section's name was probably meant as `Require path` or `Include path`.
pub(crate) fn is_misspelt_keyword(name: &str) -> bool {
    let mut words = trim(name).split(char::is_whitespace);
    let first = words.next().unwrap_or_default().trim_end_matches(':').to_lowercase();
    let argument = name.contains(".ini") || words.next().is_none();
    let keywords = ["require", "required", "include", "includes"];
    argument && keywords.iter().any(|keyword| suggest::distance(&first, keyword) <= 1)
}

/// The forms a line can have.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Line<'a> {
    /// Begins with `#` or `;`.
    Comment,
    /// `[Name]`.
    Section(Header<'a>),
    /// `name = value`, `name+ = value`, `name- = value`, each perhaps with attributes.
    Option(OptionLine<'a>),
    /// `name {attributes}` without a value.
    Attributes {
        /// The option.
        name: &'a str,
        /// The text between the braces.
        attributes: &'a str,
    },
    /// Anything else: more text for the option above.
    More(Text<'a>),
    /// Fits no form; says why.
    Bad(&'static str),
}

/// A line that begins with `[`.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Header<'a> {
    /// Trailing blanks removed, leading ones kept.
    pub(crate) name: &'a str,
    /// Whether the `]` is there.
    pub(crate) closed: bool,
    /// Text after the `]` that is not a comment and is ignored.
    pub(crate) ignored: &'a str,
}

/// What an option line does to the option.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Operator {
    Set,
    Append,
    Remove,
}

/// A line with a `=`.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct OptionLine<'a> {
    pub(crate) name: &'a str,
    pub(crate) operator: Operator,
    pub(crate) attributes: Option<&'a str>,
    pub(crate) value: Text<'a>,
}

/// A value or a part of one, ended by a comment character or the end of the line.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Text<'a> {
    pub(crate) text: &'a str,
    /// The comment character that ended it where it may have been meant as part of the value.
    pub(crate) doubtful_cut: Option<char>,
}

/// Returns which form `line` has; it has no white space in front and is not empty.
pub(crate) fn classify(line: &str) -> Line<'_> {
    if line.starts_with(['#', ';']) {
        return Line::Comment;
    }
    if let Some(rest) = line.strip_prefix('[') {
        return header(rest);
    }
    if let Some((name, value)) = line.split_once('=') {
        return option(name, value);
    }
    let more = until_comment(line);
    if more.text.is_empty() {
        return Line::Bad("a line that begins with `|` is neither a comment nor a value");
    }
    if let Some((name, attributes)) = braces(more.text).filter(|(_, inner)| inner.contains(':')) {
        return Line::Attributes { name, attributes };
    }
    Line::More(more)
}

fn header(rest: &str) -> Line<'_> {
    let (name, after, closed) = match rest.split_once(']') {
        Some((name, after)) => (name, after, true),
        None => (rest, "", false),
    };
    let name = name.trim_end_matches(is_blank);
    if name.is_empty() {
        return Line::Bad("a section without a name");
    }
    let after = trim(after);
    let ignored = if after.starts_with(COMMENT_MARKS) { "" } else { after };
    Line::Section(Header { name, closed, ignored })
}

fn option<'a>(name: &'a str, value: &'a str) -> Line<'a> {
    let (name, attributes) = match braces(trim(name)) {
        Some((name, attributes)) => (name, Some(attributes)),
        None => (trim(name), None),
    };
    let (name, operator) = if let Some(name) = name.strip_suffix('+') {
        (trim(name), Operator::Append)
    } else if let Some(name) = name.strip_suffix('-') {
        (trim(name), Operator::Remove)
    } else {
        (name, Operator::Set)
    };
    if name.is_empty() {
        return Line::Bad("no name before the `=`");
    }
    Line::Option(OptionLine { name, operator, attributes, value: until_comment(value) })
}

/// Splits `name {inner}`.
fn braces(text: &str) -> Option<(&str, &str)> {
    let (name, inner) = text.strip_suffix('}')?.split_once('{')?;
    let name = trim(name);
    (!name.is_empty()).then_some((name, inner))
}

fn until_comment(text: &str) -> Text<'_> {
    let Some(end) = text.find(COMMENT_MARKS) else {
        return Text { text: trim(text), doubtful_cut: None };
    };
    let (kept, rest) = text.split_at(end);
    let mark = rest.chars().next();
    let glued = kept.ends_with(|before: char| !is_blank(before));
    let quoted = kept.matches('"').count() % 2 == 1;
    let doubtful_cut = mark.filter(|mark| glued || quoted || *mark == '|');
    Text { text: trim(kept), doubtful_cut }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(text: &str) -> Text<'_> {
        Text { text, doubtful_cut: None }
    }

    fn assigned<'a>(name: &'a str, operator: Operator, value: &'a str) -> Line<'a> {
        Line::Option(OptionLine { name, operator, attributes: None, value: plain(value) })
    }

    #[test]
    fn blank_lines_and_indents_are_skipped_but_counted() {
        let lines: Vec<_> = Lines::new(b"\n\n  a\r\n\t\nb").map(|line| (line.number, line.bytes)).collect();
        assert_eq!(lines, [(3, &b"a\r"[..]), (5, &b"b"[..])]);
    }

    #[test]
    fn a_line_of_1023_bytes_is_whole_and_one_of_1024_is_cut() {
        let mut text = vec![b'x'; MAX_LINE_BYTES];
        assert!(!Lines::new(&text).next().unwrap().cut);
        text.push(b'y');
        let lines: Vec<_> = Lines::new(&text).collect();
        assert!(lines[0].cut);
        assert_eq!((lines[1].number, lines[1].bytes), (1, &b"y"[..]));
    }

    #[test]
    fn tells_the_forms_of_a_line_apart() {
        let header = |name, closed, ignored| Line::Section(Header { name, closed, ignored });
        for (text, expected) in [
            ("# a = b", Line::Comment),
            ("; a = b", Line::Comment),
            ("[A.B/C ] rest", header("A.B/C", true, "rest")),
            ("[A] # rest", header("A", true, "")),
            ("[ A", header(" A", false, "")),
            ("a b = c = d # e", assigned("a b", Operator::Set, "c = d")),
            ("a =", assigned("a", Operator::Set, "")),
            ("a = # nothing", assigned("a", Operator::Set, "")),
            ("a+ = b", assigned("a", Operator::Append, "b")),
            ("a - = b, c", assigned("a", Operator::Remove, "b, c")),
            ("GPS # a = b", assigned("GPS # a", Operator::Set, "b")),
            ("more, text  ; comment", Line::More(plain("more, text"))),
            ("name {scope:idle}", Line::Attributes { name: "name", attributes: "scope:idle" }),
            ("{a:b}", Line::More(plain("{a:b}"))),
        ] {
            assert_eq!(classify(text), expected, "{text}");
        }
    }

    #[test]
    fn attributes_stand_between_name_and_value() {
        let Line::Option(line) = classify("Gain {scope:global, visibility:user} = 3") else { panic!() };
        assert_eq!((line.name, line.value.text), ("Gain", "3"));
        assert_eq!(line.attributes, Some("scope:global, visibility:user"));
    }

    #[test]
    fn a_cut_that_may_not_have_been_meant_is_marked() {
        for (text, value, mark) in [
            ("a = Spew#None", "Spew", Some('#')),
            ("a = Spew # None", "Spew", None),
            ("a = x | y", "x", Some('|')),
            ("a = \"x ; y\"", "\"x", Some(';')),
        ] {
            let Line::Option(line) = classify(text) else { panic!("{text}") };
            assert_eq!((line.value.text, line.value.doubtful_cut), (value, mark), "{text}");
        }
    }

    #[test]
    fn lines_without_a_form_are_bad() {
        for text in ["[]", "[  ]", "= b", " + = b", "| text"] {
            assert!(matches!(classify(text.trim_start()), Line::Bad(_)), "{text}");
        }
    }
}
