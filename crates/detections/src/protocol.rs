//! The coding of a tag's transmission.

use imc::Payload as _;
use imc::catalogue::FieldDesc;
use imc::messages::TBRFishTag;
use std::fmt;

/// The codings that carry an identity and no measurement, by IMC's numbers: R256, R04K, R64K, R01M.
const ID_ONLY: [u8; 4] = [1, 2, 4, 5];

/// The coding of a tag's transmission: by its name, by its number in IMC, or both.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Protocol {
    number: Option<u8>,
    name: Option<String>,
}

impl Protocol {
    /// As a receiver writes it; a name that IMC has no number for stays unchanged.
    pub fn named(name: &str) -> Self {
        let number =
            field().and_then(|field| field.value_of_label(name)).and_then(|it| u8::try_from(it).ok());
        Self { number, name: Some(name.to_owned()) }
    }

    /// As TBRFishTag numbers it; a number that IMC does not list has no name.
    pub fn numbered(number: u8) -> Self {
        Self { number: Some(number), name: field().and_then(|field| field.label(number.into())) }
    }

    /// The number in IMC's TBRFishTag, where there is one.
    pub fn number(&self) -> Option<u8> {
        self.number
    }

    /// The name, such as `R64K`, where it is known.
    pub fn name(&self) -> Option<&str> {
        self.name.as_deref()
    }

    /// Whether its tags are known to send nothing but their number.
    pub(crate) fn is_id_only(&self) -> bool {
        self.number.is_some_and(|number| ID_ONLY.contains(&number))
    }
}

impl fmt::Display for Protocol {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.name, self.number) {
            (Some(name), _) => f.write_str(name),
            (None, Some(number)) => write!(f, "{number}"),
            (None, None) => Ok(()),
        }
    }
}

fn field() -> Option<&'static FieldDesc> {
    TBRFishTag::DESC.field("trans_protocol")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_numbers_are_those_of_imc() {
        for (number, name) in (1..).zip(["R256", "R04K", "S64K", "R64K", "R01M", "S256", "HS256", "DS256"]) {
            let one = Protocol::named(name);
            assert_eq!((one.number(), one.name()), (Some(number), Some(name)));
            assert_eq!(one, Protocol::numbered(number));
        }
    }

    #[test]
    fn what_imc_does_not_list_keeps_what_is_known_of_it() {
        let named = Protocol::named("OPi");
        assert_eq!((named.number(), named.to_string()), (None, "OPi".to_owned()));
        let numbered = Protocol::numbered(0);
        assert_eq!((numbered.name(), numbered.to_string()), (None, "0".to_owned()));
    }
}
