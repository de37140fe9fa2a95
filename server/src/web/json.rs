//! JSON bodies, strictly: an object is an object and no list of its values, a name stands once, and what is wrong is said with
//! its place.
//!
//! `serde` takes lists for structs, which formats without names need. A caller that sends `[]` for `{}` would be understood as one
//! that leaves everything out.

use super::wrong::Wrong;
use api::{Said, say};
use serde::de::value::{MapDeserializer, SeqDeserializer};
use serde::de::{
    self, DeserializeOwned, Deserializer, EnumAccess, IntoDeserializer, MapAccess, SeqAccess, Unexpected,
    VariantAccess, Visitor,
};
use serde::{Deserialize, forward_to_deserialize_any};
use std::fmt;

/// Reads a body.
///
/// # Errors
/// It is not JSON, or not what belongs there; the text names the place.
pub(super) fn read<T: DeserializeOwned>(body: &[u8]) -> Result<T, Said> {
    if body.iter().all(u8::is_ascii_whitespace) {
        return Err(say("The body is empty; send a JSON object").into());
    }
    let tree: Tree = serde_json::from_slice(body).map_err(|error| {
        say("The body is not JSON; look at line {line}, column {column}")
            .with("line", error.line())
            .with("column", error.column())
    })?;
    T::deserialize(tree).map_err(Wrong::said)
}

/// A value with all names of its objects, in their order.
enum Tree {
    Null,
    Bool(bool),
    Unsigned(u64),
    Signed(i64),
    Real(f64),
    Text(String),
    List(Vec<Self>),
    Object(Vec<(String, Self)>),
}

impl<'de> Deserialize<'de> for Tree {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        from.deserialize_any(TreeVisitor)
    }
}

struct TreeVisitor;

impl<'de> Visitor<'de> for TreeVisitor {
    type Value = Tree;

    fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("JSON")
    }

    fn visit_unit<E: de::Error>(self) -> Result<Tree, E> {
        Ok(Tree::Null)
    }

    fn visit_bool<E: de::Error>(self, value: bool) -> Result<Tree, E> {
        Ok(Tree::Bool(value))
    }

    fn visit_u64<E: de::Error>(self, value: u64) -> Result<Tree, E> {
        Ok(Tree::Unsigned(value))
    }

    fn visit_i64<E: de::Error>(self, value: i64) -> Result<Tree, E> {
        Ok(Tree::Signed(value))
    }

    fn visit_f64<E: de::Error>(self, value: f64) -> Result<Tree, E> {
        Ok(Tree::Real(value))
    }

    fn visit_str<E: de::Error>(self, value: &str) -> Result<Tree, E> {
        Ok(Tree::Text(value.to_owned()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut from: A) -> Result<Tree, A::Error> {
        let mut list = Vec::new();
        while let Some(value) = from.next_element()? {
            list.push(value);
        }
        Ok(Tree::List(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut from: A) -> Result<Tree, A::Error> {
        let mut object = Vec::new();
        while let Some(entry) = from.next_entry()? {
            object.push(entry);
        }
        Ok(Tree::Object(object))
    }
}

/// A value below a name or a number of a list, with which its errors begin.
struct Below(String, Tree);

impl IntoDeserializer<'_, Wrong> for Below {
    type Deserializer = Self;
    fn into_deserializer(self) -> Self {
        self
    }
}

/// Reads a list.
fn visit_list<'de, V: Visitor<'de>>(list: Vec<Tree>, visitor: V) -> Result<V::Value, Wrong> {
    let numbered = list.into_iter().enumerate().map(|(at, value)| Below(format!("[{at}]"), value));
    let mut from = SeqDeserializer::new(numbered);
    let value = visitor.visit_seq(&mut from)?;
    from.end()?;
    Ok(value)
}

/// Reads an object.
fn visit_object<'de, V: Visitor<'de>>(object: Vec<(String, Tree)>, visitor: V) -> Result<V::Value, Wrong> {
    let named = object.into_iter().map(|(name, value)| {
        let below = Below(name.clone(), value);
        (name, below)
    });
    let mut from = MapDeserializer::new(named);
    let value = visitor.visit_map(&mut from)?;
    from.end()?;
    Ok(value)
}

impl<'de> Deserializer<'de> for Tree {
    type Error = Wrong;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        match self {
            Self::Null => visitor.visit_unit(),
            Self::Bool(value) => visitor.visit_bool(value),
            Self::Unsigned(value) => visitor.visit_u64(value),
            Self::Signed(value) => visitor.visit_i64(value),
            Self::Real(value) => visitor.visit_f64(value),
            Self::Text(text) => visitor.visit_string(text),
            // `serde` takes lists for these too.
            Self::List(_) if is_tagged(&visitor) => Err(de::Error::invalid_type(Unexpected::Seq, &visitor)),
            Self::List(list) => visit_list(list, visitor),
            Self::Object(object) => visit_object(object, visitor),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Wrong> {
        match self {
            Self::Null => visitor.visit_none(),
            value => visitor.visit_some(value),
        }
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Wrong> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Wrong> {
        match self {
            Self::List(_) => Err(de::Error::invalid_type(Unexpected::Seq, &visitor)),
            value => value.deserialize_any(visitor),
        }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Wrong> {
        match self {
            Self::Text(name) => visitor.visit_enum(Variant { name, value: None }),
            Self::Object(mut object) if object.len() == 1 => {
                let (name, value) = object.remove(0);
                visitor.visit_enum(Variant { name, value: Some(value) })
            }
            Self::Object(_) => Err(Wrong::new(say("give one name, with its value"))),
            value => value.deserialize_any(visitor),
        }
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq tuple tuple_struct
        map identifier ignored_any
    }
}

/// Whether an object is expected in which one name says what the others are.
fn is_tagged(expected: &dyn de::Expected) -> bool {
    expected.to_string().contains("tagged enum")
}

/// A method that puts the place before an error.
macro_rules! below {
    ($($method:ident($($argument:ident: $type:ty),*)),* $(,)?) => {
        $(fn $method<V: Visitor<'de>>(self, $($argument: $type,)* visitor: V) -> Result<V::Value, Wrong> {
            let Self(place, value) = self;
            value.$method($($argument,)* visitor).map_err(|wrong| wrong.below(&place))
        })*
    };
}

impl<'de> Deserializer<'de> for Below {
    type Error = Wrong;

    below!(
        deserialize_any(),
        deserialize_option(),
        deserialize_newtype_struct(name: &'static str),
        deserialize_struct(name: &'static str, fields: &'static [&'static str]),
        deserialize_enum(name: &'static str, variants: &'static [&'static str]),
    );

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq tuple tuple_struct
        map identifier ignored_any
    }
}

/// One of several, with its value where it has one.
struct Variant {
    name: String,
    value: Option<Tree>,
}

impl<'de> EnumAccess<'de> for Variant {
    type Error = Wrong;
    type Variant = Content;

    fn variant_seed<S: de::DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, Content), Wrong> {
        let name = seed.deserialize(IntoDeserializer::<Wrong>::into_deserializer(self.name.clone()))?;
        Ok((name, Content(self.name, self.value)))
    }
}

/// The value of one of several.
struct Content(String, Option<Tree>);

impl Content {
    fn below(self) -> Below {
        Below(self.0, self.1.unwrap_or(Tree::Null))
    }
}

impl<'de> VariantAccess<'de> for Content {
    type Error = Wrong;

    fn unit_variant(self) -> Result<(), Wrong> {
        match self.1 {
            None | Some(Tree::Null) => Ok(()),
            Some(_) => Err(Wrong::new(say("it takes no value")).below(&self.0)),
        }
    }

    fn newtype_variant_seed<S: de::DeserializeSeed<'de>>(self, seed: S) -> Result<S::Value, Wrong> {
        seed.deserialize(self.below())
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, Wrong> {
        self.below().deserialize_any(visitor)
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Wrong> {
        self.below().deserialize_struct("", fields, visitor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;
    use std::collections::BTreeMap;

    #[derive(Debug, PartialEq, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Leg {
        speed_mps: f64,
        #[serde(default)]
        note: Option<String>,
    }

    #[derive(Debug, PartialEq, Deserialize)]
    #[serde(rename_all = "lowercase")]
    enum Kind {
        Loiter,
        Goto { at: [f64; 2] },
        Named(String),
    }

    #[derive(Debug, PartialEq, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    struct Plan {
        count: u16,
        legs: Vec<Leg>,
        kind: Kind,
        values: BTreeMap<String, i64>,
    }

    impl Default for Plan {
        fn default() -> Self {
            Self { count: 0, legs: Vec::new(), kind: Kind::Loiter, values: BTreeMap::new() }
        }
    }

    #[test]
    fn what_belongs_there_is_read() {
        let body = br#" {"count": 65535, "legs": [{"speed_mps": 1}, {"speed_mps": 1.5e0, "note": null}],
            "kind": {"goto": {"at": [63.4, -10.5]}}, "values": {"a": -3}} "#;
        let plan: Plan = read(body).unwrap();
        let leg = |speed_mps| Leg { speed_mps, note: None };
        let values = [("a".to_owned(), -3)].into();
        let kind = Kind::Goto { at: [63.4, -10.5] };
        assert_eq!(plan, Plan { count: u16::MAX, legs: vec![leg(1.0), leg(1.5)], kind, values });
        assert_eq!(read::<Plan>(b"{}").unwrap(), Plan::default());
        assert_eq!(read::<Plan>(br#"{"kind": {"named": "x"}}"#).unwrap().kind, Kind::Named("x".to_owned()));
        assert_eq!(read::<f64>(b"0.1").unwrap().to_bits(), 0.1_f64.to_bits());
    }

    #[test]
    fn what_is_wrong_is_said_with_its_place_and_what_belongs_there() {
        for (body, said) in [
            ("", "The body is empty; send a JSON object"),
            ("{\n  \"count\": 1,\n}", "The body is not JSON; look at line 3, column 1"),
            ("[]", "give a JSON object, not a JSON list"),
            ("7", "give a JSON object, not 7"),
            (r#"{"count": 70000}"#, "count: give a whole number, 0 to 65535, not 70000"),
            (r#"{"count": "x"}"#, "count: give a whole number, 0 to 65535, not `x`"),
            (r#"{"legs": [{"speed_mps": 1}, {}]}"#, "legs[1].speed_mps: this is missing"),
            (r#"{"legs": [[1.5]]}"#, "legs[0]: give a JSON object, not a JSON list"),
            (r#"{"legs": {"speed_mps": 1}}"#, "legs: give a JSON list, not a JSON object"),
            (r#"{"legs": [{"speed_mps": null}]}"#, "legs[0].speed_mps: give a number, not null"),
            (r#"{"cuont": 1}"#, "`cuont` is not known here; did you mean count?"),
            (r#"{"x": 1}"#, "`x` is not known here; there are count, legs, kind, values"),
            (r#"{"count": 1, "count": 2}"#, "count: give it once"),
            (r#"{"kind": "sail"}"#, "kind: `sail` is not one of loiter, goto, named"),
            (r#"{"kind": {"goto": {"at": [1]}}}"#, "kind.goto.at: give a JSON list, not 1 values"),
        ] {
            assert_eq!(read::<Plan>(body.as_bytes()).unwrap_err().as_str(), said, "{body}");
        }
    }

    #[derive(Debug, PartialEq, Deserialize)]
    #[serde(tag = "kind", rename_all = "lowercase")]
    enum Order {
        Start { plan: String },
    }

    #[test]
    fn a_list_is_no_order() {
        let plan = "a".to_owned();
        assert_eq!(read::<Order>(br#"{"kind": "start", "plan": "a"}"#), Ok(Order::Start { plan }));
        let said = read::<Order>(br#"["start", "a"]"#).unwrap_err();
        assert_eq!(said.as_str(), "give a JSON object, not a JSON list");
    }

    #[test]
    fn nesting_without_end_is_refused() {
        let deep = "[".repeat(100_000);
        let said = read::<Plan>(deep.as_bytes()).unwrap_err();
        assert!(said.starts_with("The body is not JSON; look at line 1"), "{said}");
    }
}
