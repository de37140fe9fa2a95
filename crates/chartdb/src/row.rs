//! The parts of a feature that are not numbers, as columns: attributes and links as JSON, edges as bytes.
//!
//! Attributes are one object by acronym, or by number where the code has no acronym, in the order of the
//! file, so that a feature comes back as it was and QGIS can still pick values out of it.

use charts::s57::{Attribute, AttributeCode, EdgeUse, FeatureLink, LinkRole, ObjectId, Path};
use serde::de::{Deserializer as _, MapAccess, Visitor};
use std::fmt::Formatter;

/// Attributes as a JSON object.
pub(crate) fn attributes(list: &[Attribute]) -> String {
    let mut text = String::from("{");
    for one in list {
        let key = one.code.acronym().map_or_else(|| one.code.0.to_string(), str::to_owned);
        if text.len() > 1 {
            text.push(',');
        }
        text += &serde_json::Value::from(key).to_string();
        text.push(':');
        text += &serde_json::Value::from(one.value.as_str()).to_string();
    }
    text.push('}');
    text
}

struct Pairs;

impl<'de> Visitor<'de> for Pairs {
    type Value = Vec<(String, String)>;

    fn expecting(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        f.write_str("attributes as an object of texts")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let mut pairs = Vec::new();
        while let Some(pair) = map.next_entry()? {
            pairs.push(pair);
        }
        Ok(pairs)
    }
}

/// Reads the attributes that [`attributes`] wrote; `None` where the text is not such a list.
pub(crate) fn read_attributes(text: &str) -> Option<Vec<Attribute>> {
    let pairs = serde_json::Deserializer::from_str(text).deserialize_map(Pairs).ok()?;
    let attribute = |(key, value): (String, String)| {
        let code = AttributeCode::from_acronym(&key).or_else(|| key.parse().ok().map(AttributeCode))?;
        Some(Attribute { code, value })
    };
    pairs.into_iter().map(attribute).collect()
}

/// An object's worldwide identity: agency, number and subdivision.
pub(crate) fn object(id: ObjectId) -> String {
    format!("{}:{}:{}", id.agency, id.number, id.subdivision)
}

/// The identity of [`object`].
pub(crate) fn read_object(text: &str) -> Option<ObjectId> {
    let mut parts = text.splitn(3, ':');
    Some(ObjectId {
        agency: parts.next()?.parse().ok()?,
        number: parts.next()?.parse().ok()?,
        subdivision: parts.next()?.parse().ok()?,
    })
}

/// Links as JSON: a list of role and object; `None` where there are none.
pub(crate) fn links(list: &[FeatureLink]) -> Option<String> {
    let role = |role| match role {
        LinkRole::Master => "master",
        LinkRole::Slave => "slave",
        LinkRole::Peer => "peer",
        LinkRole::Other => "other",
    };
    let pairs: Vec<(&str, String)> = list.iter().map(|link| (role(link.role), object(link.to))).collect();
    if pairs.is_empty() { None } else { serde_json::to_string(&pairs).ok() }
}

/// The links of [`links`].
pub(crate) fn read_links(text: Option<&str>) -> Option<Vec<FeatureLink>> {
    let pairs: Vec<(String, String)> = serde_json::from_str(text.unwrap_or("[]")).ok()?;
    let link = |(role, to): (String, String)| {
        let role = match role.as_str() {
            "master" => LinkRole::Master,
            "slave" => LinkRole::Slave,
            "peer" => LinkRole::Peer,
            _ => LinkRole::Other,
        };
        Some(FeatureLink { to: read_object(&to)?, role })
    };
    pairs.into_iter().map(link).collect()
}

/// The edges of paths: for each path their number, then of each its record, first vertex and flags (1 reversed,
/// 2 masked, 4 limit of the data), all little-endian. `None` where no path has any.
pub(crate) fn edges<'a>(paths: impl Iterator<Item = &'a Path> + Clone) -> Option<Vec<u8>> {
    if paths.clone().all(|path| path.edges.is_empty()) {
        return None;
    }
    let mut out = Vec::new();
    for path in paths {
        out.extend((path.edges.len() as u32).to_le_bytes());
        for used in &path.edges {
            out.extend(used.edge.to_le_bytes());
            out.extend((used.from as u32).to_le_bytes());
            let flags = [used.reversed, used.masked, used.data_limit];
            out.push(flags.iter().rev().fold(0, |bits, flag| bits << 1 | u8::from(*flag)));
        }
    }
    Some(out)
}

/// Gives paths the edges of [`edges`]; false where the bytes do not fit them.
pub(crate) fn read_edges<'a>(bytes: Option<&[u8]>, paths: impl Iterator<Item = &'a mut Path>) -> bool {
    let Some(mut bytes) = bytes else { return true };
    let number = |bytes: &mut &[u8]| {
        let (head, rest) = bytes.split_first_chunk::<4>()?;
        *bytes = rest;
        Some(u32::from_le_bytes(*head))
    };
    let mut read = |path: &mut Path| -> Option<()> {
        let count = number(&mut bytes)? as usize;
        if count > bytes.len() / 9 {
            return None;
        }
        for _ in 0..count {
            let (edge, from) = (number(&mut bytes)?, number(&mut bytes)? as usize);
            let (flags, rest) = bytes.split_first()?;
            bytes = rest;
            let [reversed, masked, data_limit] = [1, 2, 4].map(|bit| flags & bit != 0);
            path.edges.push(EdgeUse { edge, from, reversed, masked, data_limit });
        }
        Some(())
    };
    let whole = paths.into_iter().map(&mut read).all(|done| done.is_some());
    whole && bytes.is_empty()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn attributes_come_back_in_order(list in prop::collection::vec((any::<u16>(), any::<String>()), 0..9)) {
            let list: Vec<Attribute> =
                list.into_iter().map(|(code, value)| Attribute { code: AttributeCode(code), value }).collect();
            prop_assert_eq!(read_attributes(&attributes(&list)), Some(list));
        }

        #[test]
        fn edges_come_back_and_cut_ones_do_not(
            list in prop::collection::vec(prop::collection::vec((any::<u32>(), any::<u32>(), 0..8_u8), 1..4), 1..4),
        ) {
            let edge = |(edge, from, flags): (u32, u32, u8)| {
                let [reversed, masked, data_limit] = [1, 2, 4].map(|bit| flags & bit != 0);
                EdgeUse { edge, from: from as usize, reversed, masked, data_limit }
            };
            let path = |list: Vec<(u32, u32, u8)>| {
                Path { points: Vec::new(), edges: list.into_iter().map(edge).collect() }
            };
            let paths: Vec<Path> = list.into_iter().map(path).collect();
            let bytes = edges(paths.iter()).unwrap();
            let mut back = vec![Path::default(); paths.len()];
            prop_assert!(read_edges(Some(&bytes), back.iter_mut()));
            prop_assert_eq!(&back, &paths);
            let mut back = vec![Path::default(); paths.len()];
            prop_assert!(!read_edges(Some(&bytes[..bytes.len() - 1]), back.iter_mut()));
        }
    }

    #[test]
    fn identities_and_links_come_back() {
        let to = ObjectId { agency: 550, number: 4_000_000_000, subdivision: 7 };
        let list = vec![FeatureLink { to, role: LinkRole::Slave }, FeatureLink { to, role: LinkRole::Other }];
        assert_eq!(read_links(links(&list).as_deref()), Some(list));
        assert_eq!((links(&[]), read_links(None)), (None, Some(Vec::new())));
        assert_eq!(read_object("550:1"), None);
    }
}
