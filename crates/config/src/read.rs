//! Reads the text of a value as its parameter wants it: type, number of items, range.

use std::fmt;
use std::net::Ipv4Addr;

use crate::edit::shortened;
use crate::problem::ProblemKind;
use crate::spec::{Kind, Length, ParamSpec, Unit};
use crate::value::{Value, ValueError, parse_bool, parse_float, parse_int, parse_pair, split_list, unescape};

/// A complaint about one value, without its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Complaint {
    pub(crate) kind: ProblemKind,
    pub(crate) what: String,
    pub(crate) remedy: String,
}

/// The result of reading a text: a value unless there is a fault, and warnings.
#[derive(Debug, Default)]
pub(crate) struct Outcome {
    pub(crate) value: Option<Value>,
    pub(crate) faults: Vec<Complaint>,
    pub(crate) cautions: Vec<Complaint>,
}

/// Reads `text` as a value of `spec`; an empty text is the default.
pub(crate) fn read(spec: &ParamSpec, text: &str) -> Outcome {
    if text.is_empty() {
        return Outcome { value: default(&spec.kind), ..Outcome::default() };
    }
    let mut reader = Reader { unit: spec.unit, outcome: Outcome::default() };
    let value = reader.value(&spec.kind, text);
    let mut outcome = reader.outcome;
    outcome.value = value.filter(|_| outcome.faults.is_empty());
    outcome
}

impl ParamSpec {
    /// The value that a text means, whether it stands in a file or comes while the program runs.
    ///
    /// # Errors
    /// Says what is wrong with the text, and what is allowed. No text at all is not a value.
    pub fn value_of(&self, text: &str) -> Result<Value, String> {
        let text = text.trim();
        if text.is_empty() {
            return Err("a value is missing".to_owned());
        }
        let outcome = read(self, text);
        outcome.value.ok_or_else(|| {
            let fault = outcome.faults.into_iter().next();
            fault.map_or_else(
                || format!("`{text}` is not a value"),
                |fault| {
                    if fault.remedy.is_empty() {
                        fault.what
                    } else {
                        format!("{}; {}", fault.what, fault.remedy)
                    }
                },
            )
        })
    }
}

/// The value used when a file says nothing; `None` for what has no value.
pub(crate) fn default(kind: &Kind) -> Option<Value> {
    Some(match *kind {
        Kind::Bool { default } => Value::Bool(default),
        Kind::Int { default, .. } => Value::Int(default),
        Kind::Float { default, .. } => Value::Float(default),
        Kind::Text { default } => Value::Text(default.to_owned()),
        Kind::Bytes { default } => Value::Bytes(unescape(default).unwrap_or_default()),
        Kind::Choice { default, .. } => Value::Choice(default),
        Kind::Address { default } => Value::Address(Ipv4Addr::from(default)),
        Kind::Floats { default, .. } => Value::Floats(default.to_vec()),
        Kind::Ints { default, .. } => Value::Ints(default.to_vec()),
        Kind::Texts { default } => Value::Texts(default.iter().map(|text| (*text).to_owned()).collect()),
        Kind::Rates { default, .. } => {
            Value::Rates(default.iter().map(|(name, rate)| ((*name).to_owned(), *rate)).collect())
        }
        Kind::Pairs => Value::Pairs(Vec::new()),
        Kind::Unused => return None,
    })
}

struct Reader {
    unit: Unit,
    outcome: Outcome,
}

impl Reader {
    fn value(&mut self, kind: &Kind, text: &str) -> Option<Value> {
        match *kind {
            Kind::Bool { .. } => self.wanted(parse_bool(text)).map(Value::Bool),
            Kind::Int { min, max, .. } => self.int(text, min, max).map(Value::Int),
            Kind::Float { min, max, .. } => self.float(text, min, max).map(Value::Float),
            Kind::Text { .. } => Some(Value::Text(text.to_owned())),
            Kind::Bytes { .. } => self.wanted(unescape(text)).map(Value::Bytes),
            Kind::Choice { options, .. } => self.choice(text, options).map(Value::Choice),
            Kind::Address { .. } => {
                let address = text.parse().map_err(|_| ValueError::NotAddress(text.to_owned()));
                self.wanted(address).map(Value::Address)
            }
            Kind::Floats { length, min, max, .. } => {
                let values = self.items(text, |reader, item| reader.float(item, min, max));
                self.length(values.len(), length);
                Some(Value::Floats(values))
            }
            Kind::Ints { min, max, .. } => {
                Some(Value::Ints(self.items(text, |reader, item| reader.int(item, min, max))))
            }
            Kind::Texts { .. } => Some(Value::Texts(self.items(text, |_, item| Some(item.to_owned())))),
            Kind::Rates { min, max, .. } => Some(Value::Rates(self.items(text, |reader, item| {
                let (name, rate) = reader.wanted(parse_pair(item))?;
                Some((name.to_owned(), reader.float(rate, min, max)?))
            }))),
            Kind::Pairs => Some(Value::Pairs(self.items(text, |reader, item| {
                let (name, value) = reader.wanted(parse_pair(item))?;
                Some((name.to_owned(), value.to_owned()))
            }))),
            Kind::Unused => None,
        }
    }

    /// The items of a list without the empty ones, which are reported.
    fn items<T>(&mut self, text: &str, mut item: impl FnMut(&mut Self, &str) -> Option<T>) -> Vec<T> {
        let mut items = Vec::new();
        let mut empty = 0;
        for part in split_list(text) {
            if part.is_empty() {
                empty += 1;
            } else {
                items.extend(item(self, part));
            }
        }
        if empty > 0 {
            self.outcome.cautions.push(Complaint {
                kind: ProblemKind::EmptyItem,
                what: format!("the list has {empty} empty item(s), left out here; DUNE keeps them"),
                remedy: "take the comma that is too many out".to_owned(),
            });
        }
        items
    }

    fn int(&mut self, text: &str, min: i64, max: i64) -> Option<i64> {
        let number = self.wanted(parse_int(text))?;
        if number.octal {
            self.outcome.cautions.push(Complaint {
                kind: ProblemKind::Octal,
                what: format!("`{text}` is octal because of its leading zero: it means {}", number.value),
                remedy: "take the leading zero out if it was meant as decimal".to_owned(),
            });
        }
        let inside = (min..=max).contains(&number.value);
        self.range(inside, text, || (bound(min == i64::MIN, min), bound(max == i64::MAX, max)));
        Some(number.value)
    }

    fn float(&mut self, text: &str, min: f64, max: f64) -> Option<f64> {
        let number = self.wanted(parse_float(text))?;
        let inside = (min..=max).contains(&number);
        self.range(inside, text, || (bound(min <= f64::MIN, min), bound(max >= f64::MAX, max)));
        Some(number)
    }

    fn choice(&mut self, text: &str, options: &'static [&'static str]) -> Option<&'static str> {
        if let Some(option) = options.iter().find(|option| **option == text) {
            return Some(option);
        }
        let list = options.join(", ");
        let remedy = match suggest::nearest(text, options.iter().copied()) {
            Some(near) => format!("`{near}`? Allowed are {list}"),
            None => format!("one of {list}"),
        };
        let what = format!("`{}` is not one of the allowed words", shortened(text));
        self.outcome.faults.push(Complaint { kind: ProblemKind::WrongType, what, remedy });
        None
    }

    fn length(&mut self, found: usize, wanted: Length) {
        if let Length::Exactly(wanted) = wanted
            && found != wanted
            && self.outcome.faults.is_empty()
        {
            self.outcome.faults.push(Complaint {
                kind: ProblemKind::WrongLength,
                what: format!("the list has {found} items"),
                remedy: format!("give exactly {wanted} items"),
            });
        }
    }

    fn wanted<T>(&mut self, result: Result<T, ValueError>) -> Option<T> {
        match result {
            Ok(value) => Some(value),
            Err(error) => {
                let what = shortened(&error.to_string());
                let remedy = error.remedy().to_owned();
                self.outcome.faults.push(Complaint { kind: ProblemKind::WrongType, what, remedy });
                None
            }
        }
    }

    fn range(&mut self, inside: bool, text: &str, bounds: impl FnOnce() -> (Option<String>, Option<String>)) {
        if inside {
            return;
        }
        let remedy = allowed(bounds(), self.unit).unwrap_or_default();
        let what = format!("{} is out of range", shortened(text));
        self.outcome.faults.push(Complaint { kind: ProblemKind::OutOfRange, what, remedy });
    }
}

fn bound(absent: bool, number: impl fmt::Display) -> Option<String> {
    (!absent).then(|| number.to_string())
}

/// "1 to 50 m", "at least 0", or nothing where anything goes.
fn allowed(bounds: (Option<String>, Option<String>), unit: Unit) -> Option<String> {
    let range = match bounds {
        (Some(min), Some(max)) => format!("allowed is {min} to {max}"),
        (Some(min), None) => format!("allowed is {min} or more"),
        (None, Some(max)) => format!("allowed is {max} or less"),
        (None, None) => return None,
    };
    let symbol = unit.symbol();
    Some(if symbol.is_empty() { range } else { format!("{range} {symbol}") })
}

/// What the documentation says about the values allowed; `None` where anything of the type goes.
pub(crate) fn allowed_values(spec: &ParamSpec) -> Option<String> {
    match spec.kind {
        Kind::Int { min, max, .. } | Kind::Ints { min, max, .. } => {
            allowed((bound(min == i64::MIN, min), bound(max == i64::MAX, max)), spec.unit)
        }
        Kind::Float { min, max, .. } | Kind::Floats { min, max, .. } | Kind::Rates { min, max, .. } => {
            allowed((bound(min <= f64::MIN, min), bound(max >= f64::MAX, max)), spec.unit)
        }
        Kind::Choice { options, .. } => Some(format!("one of {}", options.join(", "))),
        Kind::Bool { .. } => Some("true or false".to_owned()),
        Kind::Text { .. }
        | Kind::Bytes { .. }
        | Kind::Address { .. }
        | Kind::Texts { .. }
        | Kind::Pairs
        | Kind::Unused => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::{choice, float, floats, int, rates, texts};

    fn only_fault(spec: &ParamSpec, text: &str) -> Complaint {
        let outcome = read(spec, text);
        assert_eq!((outcome.value, outcome.faults.len()), (None, 1), "{text}");
        outcome.faults[0].clone()
    }

    #[test]
    fn names_the_allowed_range_with_its_unit() {
        let spec = float("Lookahead", 10.0, Unit::Metre).within(1.0, 50.0).spec;
        let fault = only_fault(&spec, "70");
        assert_eq!(fault.kind, ProblemKind::OutOfRange);
        assert_eq!(fault.remedy, "allowed is 1 to 50 m");
        assert_eq!(read(&spec, "50").value, Some(Value::Float(50.0)));
        assert_eq!(only_fault(&int("Count", 1, Unit::None).spec, "-1").remedy, "allowed is 0 or more");
    }

    #[test]
    fn an_empty_text_is_the_default() {
        let spec = int("Port", 6002, Unit::None).spec;
        assert_eq!(read(&spec, "").value, Some(Value::Int(6002)));
    }

    #[test]
    fn lists_must_have_their_length() {
        let spec = floats("Gains", &[0.0, 0.0, 0.0], Unit::None).of_length(3).spec;
        assert_eq!(only_fault(&spec, "1, 2").remedy, "give exactly 3 items");
        assert_eq!(read(&spec, "1, 2, 3").value, Some(Value::Floats(vec![1.0, 2.0, 3.0])));
        assert_eq!(only_fault(&spec, "1, x, 3").kind, ProblemKind::WrongType);
    }

    #[test]
    fn empty_items_are_left_out_and_reported() {
        let outcome = read(&texts("List", &[]).spec, "a, , b,");
        assert_eq!(outcome.value, Some(Value::Texts(vec!["a".into(), "b".into()])));
        assert_eq!(outcome.cautions[0].kind, ProblemKind::EmptyItem);
    }

    #[test]
    fn a_leading_zero_is_octal_and_reported() {
        let outcome = read(&int("N", 0, Unit::None).spec, "010");
        assert_eq!((outcome.value, outcome.cautions[0].kind), (Some(Value::Int(8)), ProblemKind::Octal));
    }

    #[test]
    fn a_wrong_word_gets_a_suggestion() {
        let spec = choice("Level", "None", &["None", "Debug"]).spec;
        assert_eq!(only_fault(&spec, "debug").remedy, "`Debug`? Allowed are None, Debug");
    }

    #[test]
    fn rates_are_pairs_of_name_and_number() {
        let spec = rates("Rates", &[], Unit::Hertz).spec;
        assert_eq!(
            read(&spec, "A:1,B:0.5").value,
            Some(Value::Rates(vec![("A".into(), 1.0), ("B".into(), 0.5)]))
        );
        for text in ["A", "A:", ":1", "A:x", "A:-1"] {
            only_fault(&spec, text);
        }
    }
}
