//! Tuple lists: `Name=value;Name=value`, as remote actions, plan statistics and custom settings have them.
//!
//! DUNE's reading is followed: split at `;`, then at the first `=`, trim both sides; names are
//! case-sensitive and pairs without `=` are passed over.

use std::fmt::Write as _;

/// Names and values, in the order of the text.
pub fn parse(list: &str) -> impl Iterator<Item = (&str, &str)> {
    list.split(';').filter_map(|pair| {
        let (name, value) = pair.split_once('=')?;
        Some((name.trim(), value.trim()))
    })
}

/// The value of a name; the last one when it is given twice.
pub fn get<'a>(list: &'a str, name: &str) -> Option<&'a str> {
    parse(list).filter(|(key, _)| *key == name).last().map(|(_, value)| value)
}

/// The value of a name as a number; `None` when it is missing or no finite number.
///
/// DUNE takes what is not a number as 0. Sticks are read this way, so NaN and infinities do not count as numbers.
pub fn number(list: &str, name: &str) -> Option<f64> {
    get(list, name)?.parse().ok().filter(|value: &f64| value.is_finite())
}

/// The text of names and values. What would end a name or pair, `;` and in names `=`, becomes a blank.
pub fn build<N: AsRef<str>, V: std::fmt::Display>(pairs: impl IntoIterator<Item = (N, V)>) -> String {
    let mut list = String::new();
    for (name, value) in pairs {
        let separator = if list.is_empty() { "" } else { ";" };
        let name = name.as_ref().replace([';', '='], " ");
        let value = value.to_string().replace(';', " ");
        write!(list, "{separator}{name}={value}").ok();
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_as_dune_does() {
        let list = " Port Motor = -127 ;Stop=1;note=a=b;broken;Stop=0;";
        let pairs: Vec<(&str, &str)> = parse(list).collect();
        assert_eq!(pairs, [("Port Motor", "-127"), ("Stop", "1"), ("note", "a=b"), ("Stop", "0")]);
        assert_eq!(get(list, "Stop"), Some("0"));
        assert_eq!(get(list, "stop"), None);
        assert_eq!(number(list, "Port Motor"), Some(-127.0));
        assert_eq!(number(list, "note"), None);
        for value in ["nan", "NaN", "inf", "-infinity", "1e999"] {
            assert_eq!(number(&format!("Throttle={value}"), "Throttle"), None, "{value}");
        }
    }

    #[test]
    fn what_is_built_reads_back() {
        assert_eq!(build([("Heading", 12), ("Throttle", -3)]), "Heading=12;Throttle=-3");
        assert_eq!(build([("te=xt", "a;b=c")]), "te xt=a b=c");
    }
}
