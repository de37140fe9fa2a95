//! The query of an address as a type: each parameter once, or as often as there are values where the type has a list.
//!
//! `serde_urlencoded`, which axum uses, has no lists: a name that contains the separator of a list written as one text could not
//! be asked for.

use super::wrong::Wrong;
use api::say;
use serde::de::value::{MapDeserializer, SeqDeserializer, StringDeserializer};
use serde::de::{DeserializeOwned, Deserializer, IntoDeserializer, Visitor};
use serde::forward_to_deserialize_any;
use std::str::FromStr;

/// Most names of parameters that are read, and the bytes of the longest: no route has as many, and a refusal must stay short.
const NAMES: usize = 64;
const NAME_BYTES: usize = 64;

/// Reads what stands behind the `?` of an address.
///
/// # Errors
/// There are more than 64 parameters, or one is missing, unknown, given more than once where it has one value, or not what it must be.
pub(crate) fn read<T: DeserializeOwned>(query: &str) -> Result<T, Wrong> {
    let mut parameters: Vec<(String, Values)> = Vec::new();
    for (name, value) in form_urlencoded::parse(query.as_bytes()) {
        if name.len() > NAME_BYTES {
            let shown: String = name.chars().take(30).collect();
            return Err(Wrong::new(say("{name} is not known here").with("name", format!("`{shown}…`"))));
        }
        let is_full = parameters.len() == NAMES;
        match parameters.iter_mut().find(|(known, _)| *known == name) {
            Some((_, values)) => values.all.push(value.into_owned()),
            None if is_full => {
                return Err(Wrong::new(say("there are more than {most} parameters").with("most", NAMES)));
            }
            None => parameters
                .push((name.to_string(), Values { name: name.into_owned(), all: vec![value.into_owned()] })),
        }
    }
    let pairs = parameters.into_iter();
    T::deserialize(MapDeserializer::new(pairs))
}

/// All values of one parameter, in their order.
struct Values {
    name: String,
    all: Vec<String>,
}

impl Values {
    /// Its value, where it has one.
    fn one(mut self) -> Result<String, Wrong> {
        match (self.all.pop(), self.all.is_empty()) {
            (Some(value), true) => Ok(value),
            _ => Err(Wrong::new(say("give it once")).below(&self.name)),
        }
    }

    fn parsed<T: FromStr>(self, rust: &str) -> Result<T, Wrong> {
        let name = self.name.clone();
        let value = self.one()?;
        value.parse().map_err(|_| Wrong::value(&value, rust).below(&name))
    }
}

impl IntoDeserializer<'_, Wrong> for Values {
    type Deserializer = Self;
    fn into_deserializer(self) -> Self {
        self
    }
}

/// A method that parses a number.
macro_rules! number {
    ($($method:ident $visit:ident $rust:literal),* $(,)?) => {
        $(fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
            visitor.$visit(self.parsed($rust)?)
        })*
    };
}

impl<'de> Deserializer<'de> for Values {
    type Error = Wrong;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        visitor.visit_string(self.one()?)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        visitor.visit_some(self)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        let Self { name, all } = self;
        let each = all.into_iter().map(|value| Self { name: name.clone(), all: vec![value] });
        visitor.visit_seq(SeqDeserializer::new(each))
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Wrong> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Wrong> {
        let name = self.name.clone();
        let value: StringDeserializer<Wrong> = self.one()?.into_deserializer();
        visitor.visit_enum(value).map_err(|wrong| wrong.below(&name))
    }

    number!(
        deserialize_bool visit_bool "bool",
        deserialize_u8 visit_u8 "u8",
        deserialize_u16 visit_u16 "u16",
        deserialize_u32 visit_u32 "u32",
        deserialize_u64 visit_u64 "u64",
        deserialize_i8 visit_i8 "i8",
        deserialize_i16 visit_i16 "i16",
        deserialize_i32 visit_i32 "i32",
        deserialize_i64 visit_i64 "i64",
        deserialize_f32 visit_f32 "f32",
        deserialize_f64 visit_f64 "f64",
    );

    forward_to_deserialize_any! {
        i128 u128 char str string bytes byte_buf unit unit_struct tuple tuple_struct map struct identifier ignored_any
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Debug, PartialEq, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Asked {
        from_us: i64,
        flags: Option<bool>,
        area: Option<String>,
        #[serde(default)]
        project: Vec<String>,
    }

    #[test]
    fn a_list_has_as_many_values_as_were_given() {
        let asked: Asked =
            read("from_us=-5&project=Cod%3B+north&flags=true&project=&project=Salmon").unwrap();
        let project = ["Cod; north", "", "Salmon"].map(str::to_owned).to_vec();
        assert_eq!(asked, Asked { from_us: -5, flags: Some(true), area: None, project });
        assert_eq!(read::<Asked>("from_us=1").unwrap().project, Vec::<String>::new());
    }

    /// Each name is compared with those before it.
    #[test]
    fn names_without_number_are_refused_at_the_first_that_is_too_many() {
        let many: String = (0..30_000).map(|at| at.to_string()).collect::<Vec<_>>().join("&");
        let error = read::<Asked>(&many).unwrap_err().to_string();
        assert_eq!(error, "there are more than 64 parameters");
        let long = read::<Asked>(&"x".repeat(60_000)).unwrap_err().to_string();
        assert!(long.starts_with("`xxx") && long.ends_with("is not known here") && long.len() < 80, "{long}");
        let again = format!("from_us=1{}", "&project=Cod".repeat(3_000));
        assert_eq!(read::<Asked>(&again).unwrap().project.len(), 3_000, "a list may be long");
    }

    #[test]
    fn what_is_wrong_is_said_with_the_name_of_the_parameter() {
        for (query, said) in [
            ("", "from_us: this is missing"),
            ("from_us=1&from_us=2", "from_us: give it once"),
            ("from_us=1&area=a&area=b", "area: give it once"),
            ("from_us=1.5", "from_us: give a whole number, not `1.5`"),
            ("from_us=1&flags=yes", "flags: give true or false, not `yes`"),
            ("from_us=1&form_us=2", "`form_us` is not known here; did you mean from_us?"),
        ] {
            let error = read::<Asked>(query).unwrap_err().to_string();
            assert!(error.starts_with(said), "{query}: {error}");
        }
    }
}
