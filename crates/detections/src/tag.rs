//! Which tags a query selects.

use crate::detection::Detection;
use crate::protocol::Protocol;
use std::str::FromStr;

/// Letters of a protocol's name at most.
const NAME_LETTERS: usize = 40;

/// A tag as people write it: protocol and number (`S256-101`), or the number alone (`101`) for that of any protocol.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TagFilter {
    protocol: Option<String>,
    id: u32,
}

/// A text that names no tag; its words are made above, where the catalogue of words has them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NoTag;

impl FromStr for TagFilter {
    type Err = NoTag;

    fn from_str(text: &str) -> Result<Self, NoTag> {
        let (protocol, id) = match text.trim().rsplit_once('-') {
            Some((protocol, id)) => (Some(protocol), id),
            None => (None, text.trim()),
        };
        if protocol.is_some_and(|name| name.is_empty() || name.chars().count() > NAME_LETTERS) {
            return Err(NoTag);
        }
        if !id.bytes().all(|byte| byte.is_ascii_digit()) {
            return Err(NoTag);
        }
        Ok(Self { protocol: protocol.map(str::to_owned), id: id.parse().map_err(|_| NoTag)? })
    }
}

impl TagFilter {
    /// Whether a detection is of this tag. Receivers write names of protocols in either case.
    pub fn admits(&self, one: &Detection) -> bool {
        self.admits_code(&one.protocol, one.tag_id)
    }

    /// Whether this is the tag of this protocol and number.
    pub fn admits_code(&self, protocol: &Protocol, id: u32) -> bool {
        let is_it = |name: &String| protocol.to_string().eq_ignore_ascii_case(name);
        id == self.id && self.protocol.as_ref().is_none_or(is_it)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tag_is_named_by_protocol_and_number_or_by_number() {
        for (text, protocol, id) in
            [("S256-101", Some("S256"), 101), (" 101 ", None, 101), ("A69-1303-7", Some("A69-1303"), 7)]
        {
            assert_eq!(text.parse(), Ok(TagFilter { protocol: protocol.map(str::to_owned), id }));
        }
        for text in ["", "S256", "S256-", "-7", "+7", "S256-x", "1e3", "99999999999"] {
            assert_eq!(text.parse::<TagFilter>(), Err(NoTag), "{text}");
        }
    }
}
