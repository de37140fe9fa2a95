//! Conditions on the value of a field, as `--where` takes them.

use imc::catalogue::{FieldDesc, MESSAGES, MessageDesc};
use imc::reflect::{Field, Value};
use std::str::FromStr;

/// `FIELD OP VALUE`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Condition {
    /// The field's place, without the indices of lists: `lat`, `maneuvers.data.speed`.
    path: String,
    op: Op,
    value: String,
    /// The value, when it is a number.
    number: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Op {
    Equal,
    Unequal,
    Less,
    AtMost,
    Greater,
    AtLeast,
    Contains,
}

/// Longer ones first, because `<` begins `<=`.
const OPS: [(&str, Op); 8] = [
    ("==", Op::Equal),
    ("!=", Op::Unequal),
    ("<=", Op::AtMost),
    (">=", Op::AtLeast),
    ("=", Op::Equal),
    ("<", Op::Less),
    (">", Op::Greater),
    ("~", Op::Contains),
];

impl FromStr for Condition {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = "expected FIELD OP VALUE with =, !=, <, <=, >, >= or ~, such as 'sog>0.5'";
        let at = text.find(['=', '!', '<', '>', '~']).ok_or(expected)?;
        let (path, rest) = text.split_at(at);
        let (sign, op) = OPS.iter().find(|(sign, _)| rest.starts_with(sign)).ok_or(expected)?;
        let (path, value) = (path.trim().to_owned(), rest[sign.len()..].trim().to_owned());
        if path.is_empty() {
            return Err(expected.to_owned());
        }
        let number = number(&value);
        let ordered = [Op::Less, Op::AtMost, Op::Greater, Op::AtLeast].contains(op);
        if ordered && number.is_none() {
            return Err(format!("`{value}` is not a number to compare with"));
        }
        Ok(Self { path, op: *op, value, number })
    }
}

/// A number; one followed by `deg` or `°` is turned into the radians that messages hold.
fn number(text: &str) -> Option<f64> {
    let degrees = text.strip_suffix("deg").or_else(|| text.strip_suffix('°'));
    match degrees {
        Some(degrees) => degrees.trim().parse().ok().map(f64::to_radians),
        None => text.parse().ok(),
    }
}

impl Condition {
    /// Checks that some message has the field.
    ///
    /// # Errors
    /// When none of `messages` (or of all, when it is empty) has it.
    pub(crate) fn check(&self, messages: &[u16]) -> Result<(), String> {
        let wanted = |desc: &&&MessageDesc| messages.is_empty() || messages.contains(&desc.id);
        let first = self.path.split(['.', '[']).next().unwrap_or_default();
        let mut fields = MESSAGES.iter().filter(wanted).flat_map(|desc| desc.fields);
        if fields.any(|field| field.abbrev == first) {
            return Ok(());
        }
        let fields = MESSAGES.iter().filter(wanted).flat_map(|desc| desc.fields);
        let mut names: Vec<&str> = fields.map(|field| field.abbrev).collect();
        names.sort_unstable();
        names.dedup();
        let alike = suggest::alike(first, names.into_iter());
        let hint =
            if alike.is_empty() { String::new() } else { format!("; did you mean {}?", alike.join(", ")) };
        let whose = if messages.is_empty() { "any message" } else { "the messages chosen" };
        Err(format!("--where: `{first}` is not a field of {whose}{hint}"))
    }

    /// Whether one of a packet's fields meets the condition.
    pub(crate) fn holds(&self, fields: &[Field<'_>]) -> bool {
        fields.iter().any(|field| self.is_place(&field.path) && self.is_value(field))
    }

    /// Whether the path matches, in lists at any index unless one is given.
    fn is_place(&self, path: &str) -> bool {
        if path == self.path {
            return true;
        }
        let mut inside = false;
        let without = path.chars().filter(|&letter| {
            inside = (inside || letter == '[') && letter != ']';
            !inside && letter != ']'
        });
        path.contains('[') && without.eq(self.path.chars())
    }

    fn is_value(&self, field: &Field<'_>) -> bool {
        match field.value {
            Value::Text(text) => self.is_text(&imc::text::escape(text)),
            Value::Raw(bytes) => self.is_text(&hex::encode(bytes)),
            Value::Integer(value) => self.is_integer(field.desc, value),
            Value::Single(value) => self.is_single(value),
            Value::Double(value) => self.number.is_some_and(|wanted| self.compare(value, wanted)),
        }
    }

    fn is_text(&self, text: &str) -> bool {
        match self.op {
            Op::Equal => text == self.value,
            Op::Unequal => text != self.value,
            Op::Contains => text.to_lowercase().contains(&self.value.to_lowercase()),
            Op::Less | Op::AtMost | Op::Greater | Op::AtLeast => false,
        }
    }

    fn is_integer(&self, desc: &FieldDesc, value: i64) -> bool {
        if self.op == Op::Contains {
            return desc.label(value).is_some_and(|label| self.is_text(&label));
        }
        let wanted = self.number.or_else(|| desc.value_of_label(&self.value).map(|value| value as f64));
        // A label that the field does not have is a value that it does not have.
        wanted.map_or(self.op == Op::Unequal, |wanted| self.compare(value as f64, wanted))
    }

    /// A single-precision value equals the decimal number that it represents.
    fn is_single(&self, value: f32) -> bool {
        let Some(wanted) = self.number else { return false };
        match self.op {
            Op::Equal | Op::Unequal => self.compare(value.into(), f64::from(wanted as f32)),
            _ => self.compare(value.into(), wanted),
        }
    }

    #[expect(clippy::float_cmp, reason = "the user asks for the very value")]
    fn compare(&self, value: f64, wanted: f64) -> bool {
        match self.op {
            Op::Equal => value == wanted || value.is_nan() && wanted.is_nan(),
            Op::Unequal => value != wanted && !(value.is_nan() && wanted.is_nan()),
            Op::Less => value < wanted,
            Op::AtMost => value <= wanted,
            Op::Greater => value > wanted,
            Op::AtLeast => value >= wanted,
            Op::Contains => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use imc::messages::{GpsFix, PlanControl, PlanControlOp, Temperature};
    use imc::{Header, Packet, PacketView, reflect};

    fn holds(condition: &str, message: impl Into<imc::Message>) -> bool {
        let bytes = Packet::new(Header::default(), message).encode().unwrap();
        let view = PacketView::new(&bytes).unwrap();
        let fields = reflect::fields(&view).unwrap().unwrap();
        condition.parse::<Condition>().unwrap().holds(&fields)
    }

    #[test]
    fn compares_numbers_labels_and_texts() {
        let fix = || GpsFix { lat: 1.107, sog: 0.1, hdop: f32::NAN, ..GpsFix::default() };
        for condition in [
            "sog=0.1",
            "sog > 0.05",
            "sog<=0.2",
            "lat>63.4deg",
            "lat<63.5°",
            "hdop=NaN",
            "satellites!=3",
            "type=STANDALONE",
        ] {
            assert!(holds(condition, fix()), "{condition}");
        }
        for condition in ["sog!=0.1", "sog<0.1", "hdop>0", "hdop<=0", "type=DIFFERENTIAL", "salmon=0"] {
            assert!(!holds(condition, fix()), "{condition}");
        }
        let plan = || PlanControl {
            op: PlanControlOp::Stop,
            info: "Plan Loaded".into(),
            arg: Temperature { value: 4.5 }.into(),
            ..PlanControl::default()
        };
        for condition in ["op=stop", "op==1", "info~loaded", "info=Plan Loaded", "op~sto", "arg.value>=4.5"] {
            assert!(holds(condition, plan()), "{condition}");
        }
        assert!(!holds("info=plan loaded", plan()));
    }

    #[test]
    fn finds_fields_in_lists_at_any_index() {
        let condition: Condition = "maneuvers.data.speed>1".parse().unwrap();
        assert!(condition.is_place("maneuvers[12].data.speed"));
        assert!(!condition.is_place("maneuvers[12].data.speed_units"));
    }

    #[test]
    fn refuses_what_is_no_condition() {
        for text in ["", "sog", ">1", "sog>fast", "sog!1"] {
            assert!(text.parse::<Condition>().is_err(), "{text}");
        }
        let misspelt: Condition = "satelites>3".parse().unwrap();
        assert!(misspelt.check(&[]).unwrap_err().contains("satellites"));
        assert!(misspelt.check(&[253]).unwrap_err().contains("satellites"));
    }
}
