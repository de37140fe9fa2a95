//! The layout of an export: which series, which columns.

use super::options::CsvOptions;
use super::select::Selection;
use crate::error::Result;
use crate::history::{GroupKey, Names};
use crate::range::TimeRange;
use crate::reader::Reader;
use std::collections::BTreeSet;
use tables::Field;

/// One message's fields, with the first column that they fill in a wide table.
#[derive(Debug)]
pub(crate) struct Message {
    pub(crate) id: u16,
    pub(crate) name: &'static str,
    pub(crate) fields: Vec<Field>,
    pub(crate) first_column: usize,
}

/// One series, and when it is asked for.
#[derive(Debug)]
pub(crate) struct Group {
    pub(crate) key: GroupKey,
    /// Its message's place in [`Plan::messages`].
    pub(crate) message: usize,
    pub(crate) spans: Vec<TimeRange>,
}

/// The plan of an export.
#[derive(Debug)]
pub(crate) struct Plan {
    pub(crate) messages: Vec<Message>,
    pub(crate) groups: Vec<Group>,
    pub(crate) names: Names,
    pub(crate) columns: usize,
}

impl Plan {
    /// Of a selection that is [known](Selection::known).
    pub(crate) fn new(reader: &mut Reader, selection: &Selection, options: CsvOptions) -> Result<Self> {
        let names = reader.names()?;
        let extents = reader.extents()?;
        let keys: Vec<GroupKey> =
            extents.keys().copied().filter(|group| selection.has_series(&names, *group)).collect();
        let mut asked: BTreeSet<u16> = keys.iter().map(|group| group.id).collect();
        // A message selected by name has its columns even without data.
        asked.extend(
            selection.messages.iter().filter_map(|name| imc::catalogue::by_abbrev(name)).map(|desc| desc.id),
        );
        let mut messages = Vec::new();
        let mut columns = 0;
        for desc in asked.into_iter().filter_map(imc::catalogue::by_id) {
            let mut fields = tables::fields(desc, options.style());
            let has_none = fields.is_empty();
            fields.retain(|field| selection.has_field(desc, field.name));
            if fields.is_empty() && !has_none {
                continue;
            }
            let first_column = columns;
            columns += fields.len();
            messages.push(Message { id: desc.id, name: desc.abbrev, fields, first_column });
        }
        let group = |key: GroupKey| {
            let message = messages.iter().position(|message: &Message| message.id == key.id)?;
            Some(Group { key, message, spans: selection.spans(&names, key.src, key.src_ent) })
        };
        let groups = keys.into_iter().filter_map(group).collect();
        Ok(Self { messages, groups, names, columns })
    }

    /// Whether one table has rows of several messages, so that each names its message.
    pub(crate) fn is_mixed(&self) -> bool {
        self.messages.len() > 1
    }

    /// All fields, in the order of their columns in a wide table.
    pub(crate) fn fields(&self) -> impl Iterator<Item = (&Message, &Field)> {
        self.messages.iter().flat_map(|message| message.fields.iter().map(move |field| (message, field)))
    }

    /// A field's column in a wide table. No two columns have one name.
    pub(crate) fn column(&self, message: &Message, field: &Field) -> String {
        tables::column_name(message.name, field, self.is_mixed())
    }
}
