//! A packet as rows of PostgreSQL's binary COPY.
//!
//! Values are exact: integers in the type that holds all of them, singles as `real`, NaN and infinities as they are. A field that
//! an older sender left out is NULL. Text that is not UTF-8 or holds NUL, which PostgreSQL refuses, is escaped as in CSV
//! ([`imc::text::escape`]); nested messages and lists are JSON as in the history.

use super::layout::{DETECTION, KEY, TableId, Type};
use detections::{Detection, Noise, Pose};
use imc::PacketView;
use imc::catalogue::{FieldDesc, MessageDesc};
use imc::json::NestedText;
use imc::messages::{EstimatedState, Payload as _};
use imc::names::{self, SystemName, Told};
use imc::reflect::{self, Value, Visitor, WalkError};
use units::UtcTime;

/// 2000-01-01 in microseconds since 1970: PostgreSQL counts from there.
const EPOCH_US: i64 = 946_684_800_000_000;
/// The first time that PostgreSQL has, 4714-11-24 BC, in its count.
const FIRST_US: i64 = -211_813_488_000_000_000;
/// PostgreSQL's `-infinity`.
const NEVER: i64 = i64::MIN;
/// What a NULL has for a length.
const NULL: [u8; 4] = (-1_i32).to_be_bytes();

/// What goes there of a packet.
#[derive(Debug)]
pub(crate) struct Item {
    pub(super) row: Row,
    /// What it says of a detection.
    pub(super) detection: Option<Row>,
    /// The name that its sender gives itself.
    pub(super) name: Option<SystemName>,
}

/// A row of some table.
#[derive(Debug)]
pub(super) struct Row {
    pub(super) table: TableId,
    pub(super) key: Key,
    pub(super) received_us: i64,
    /// As COPY has it.
    pub(super) tuple: Vec<u8>,
}

/// What no two rows of a table have in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Key {
    pub(super) src: u16,
    /// By PostgreSQL's count, in which all that is no time is one.
    pub(super) time: i64,
    pub(super) src_ent: u8,
    pub(super) hash: i64,
    pub(super) id: u16,
}

impl Item {
    pub(super) fn of(view: &PacketView<'_>, received: UtcTime) -> Self {
        let (time_us, hash) = store::row_key(view);
        let key =
            Key { src: view.src().0, time: time(time_us), src_ent: view.src_ent(), hash, id: view.id() };
        let row = row(view, key, received);
        let detection = detections::is_report(view)
            .then(|| Detection::from_packet(view, received))
            .flatten()
            .map(|one| detection(view, key, received, &one));
        let name = names::told(view).into_iter().find_map(|told| match told {
            Told::System(name) => Some(name),
            Told::Entity(..) => None,
        });
        Self { row, detection, name }
    }

    /// Bytes that it takes in memory, about.
    pub(super) fn bytes(&self) -> usize {
        let detection = self.detection.as_ref().map_or(0, |row| row.tuple.len());
        size_of::<Self>() + self.row.tuple.len() + detection
    }
}

/// A time in PostgreSQL's count; what it cannot hold is `-infinity`.
pub(super) fn time(us: i64) -> i64 {
    let time = us.saturating_sub(EPOCH_US);
    if time < FIRST_US { NEVER } else { time }
}

fn row(view: &PacketView<'_>, key: Key, received: UtcTime) -> Row {
    let received_us = received.micros();
    let (problem, known) = match view.desc() {
        Some(desc) => match fields(desc, view, key, received) {
            Ok(tuple) => {
                return Row { table: TableId::Message(desc.id), key, received_us, tuple: tuple.0 };
            }
            Err(problem) => (problem.to_string(), Some(desc)),
        },
        None => (String::new(), imc::catalogue::by_id(view.id())),
    };
    let bytes = view.payload().len();
    let problem = match (problem.is_empty(), known) {
        (false, _) => problem,
        (true, Some(desc)) => {
            format!(
                "its payload of {bytes} bytes is not that of {}: another message has this id in the sender's IMC",
                desc.abbrev
            )
        }
        (true, None) => "the catalogue has no message with this id".to_owned(),
    };
    let mut tuple = Tuple::begin(KEY.len() + 3, view, key, received);
    tuple.integer(Type::Integer, view.id().into());
    tuple.bytes(view.payload());
    tuple.text(problem.as_bytes());
    Row { table: TableId::Raw, key, received_us, tuple: tuple.0 }
}

fn fields(
    desc: &'static MessageDesc,
    view: &PacketView<'_>,
    key: Key,
    received: UtcTime,
) -> Result<Tuple, WalkError> {
    let is_state = desc.id == EstimatedState::ID;
    let columns = KEY.len() + desc.fields.len() + if is_state { tables::TRUE_POSITION.len() } else { 0 };
    let tuple = Tuple::begin(columns, view, key, received);
    let mut values =
        Values { tuple, nested: NestedText::default(), written: 0, first: [f64::NAN; PLACE_FIELDS] };
    reflect::walk_payload(desc, view.payload(), view.order(), true, &mut values)?;
    let Values { mut tuple, written, first, .. } = values;
    for _ in written..desc.fields.len() {
        tuple.null();
    }
    if is_state {
        let place = (written >= PLACE_FIELDS).then(|| tables::computed_place(first)).flatten();
        tuple.double(place.map(|(lat_deg, _)| lat_deg));
        tuple.double(place.map(|(_, lon_deg)| lon_deg));
    }
    Ok(tuple)
}

fn detection(view: &PacketView<'_>, key: Key, received: UtcTime, one: &Detection) -> Row {
    let mut tuple = Tuple::begin(KEY.len() + DETECTION.len(), view, key, received);
    tuple.integer(Type::BigInt, one.receiver.into());
    tuple.integer(Type::Time, time(one.clock.micros()));
    tuple.integer(Type::SmallInt, one.clock.state as i64);
    tuple.text(one.protocol.to_string().as_bytes());
    tuple.integer(Type::BigInt, one.tag_id.into());
    tuple.optional(Type::Integer, one.data);
    tuple.optional(Type::SmallInt, one.snr_db);
    tuple.optional(Type::SmallInt, one.frequency_khz);
    tuple.integer(Type::Integer, one.line.into());
    tuple.double(one.pose.map(|pose| pose.place.lat_deg()));
    tuple.double(one.pose.map(|pose| pose.place.lon_deg()));
    let pose = one.pose.as_ref();
    tuple.double(pose.and_then(|Pose { age_s, .. }| *age_s));
    tuple.double(pose.and_then(|Pose { sigma_m, .. }| *sigma_m));
    tuple.optional(Type::Integer, one.effort.lines_lost);
    let noise = one.effort.noise.as_ref();
    tuple.optional(Type::SmallInt, noise.map(|Noise { average, .. }| *average));
    tuple.optional(Type::SmallInt, noise.map(|Noise { peak, .. }| *peak));
    tuple.double(noise.map(|Noise { age_s, .. }| *age_s));
    tuple.double(one.effort.propeller_rpm);
    match &one.raw {
        Some(raw) => tuple.text(raw.as_bytes()),
        None => tuple.null(),
    }
    tuple.text(view.desc().map_or("", |desc| desc.abbrev).as_bytes());
    match one.maker {
        Some(maker) => tuple.text(maker.word().as_bytes()),
        None => tuple.null(),
    }
    Row { table: TableId::Detections, key, received_us: received.micros(), tuple: tuple.0 }
}

/// One row as COPY has it: the number of columns, then each with its length.
struct Tuple(Vec<u8>);

impl Tuple {
    fn begin(columns: usize, view: &PacketView<'_>, key: Key, received: UtcTime) -> Self {
        let mut bytes = Vec::with_capacity(96 + view.payload().len() * 2);
        // A message has some 60 fields at most.
        bytes.extend_from_slice(&(columns as i16).to_be_bytes());
        let mut tuple = Self(bytes);
        tuple.integer(Type::Integer, key.src.into());
        tuple.integer(Type::Time, key.time);
        tuple.integer(Type::SmallInt, key.src_ent.into());
        tuple.integer(Type::BigInt, key.hash);
        tuple.integer(Type::Time, time(received.micros()));
        tuple.integer(Type::Integer, view.dst().0.into());
        tuple.integer(Type::SmallInt, view.dst_ent().into());
        tuple
    }

    /// An integer in the width of its column, which holds all values of its field.
    fn integer(&mut self, kind: Type, value: i64) {
        match kind {
            Type::SmallInt => self.bytes(&(value as i16).to_be_bytes()),
            Type::Integer => self.bytes(&(value as i32).to_be_bytes()),
            _ => self.bytes(&value.to_be_bytes()),
        }
    }

    fn optional(&mut self, kind: Type, value: Option<impl Into<i64>>) {
        match value {
            Some(value) => self.integer(kind, value.into()),
            None => self.null(),
        }
    }

    fn double(&mut self, value: Option<f64>) {
        match value {
            Some(value) => self.bytes(&value.to_be_bytes()),
            None => self.null(),
        }
    }

    fn text(&mut self, text: &[u8]) {
        self.bytes(imc::text::escape(text).as_bytes());
    }

    fn bytes(&mut self, bytes: &[u8]) {
        // Longest are payloads, of 64 KiB, and what is made of one.
        self.0.extend_from_slice(&(bytes.len() as i32).to_be_bytes());
        self.0.extend_from_slice(bytes);
    }

    fn null(&mut self) {
        self.0.extend_from_slice(&NULL);
    }
}

/// `EstimatedState` begins with lat, lon, height, x, y and z.
const PLACE_FIELDS: usize = 6;

/// A message's own fields.
struct Values {
    tuple: Tuple,
    nested: NestedText,
    written: usize,
    first: [f64; PLACE_FIELDS],
}

impl Values {
    fn end_nested(&mut self) {
        if !self.nested.is_open() {
            self.tuple.bytes(self.nested.text().as_bytes());
            self.written += 1;
        }
    }
}

impl<'a> Visitor<'a> for Values {
    fn value(&mut self, field: &'static FieldDesc, value: Value<'a>) {
        if self.nested.is_open() {
            return self.nested.value(field, value);
        }
        if let (Some(first), Some(number)) = (self.first.get_mut(self.written), value.as_f64()) {
            *first = number;
        }
        match value {
            Value::Integer(value) => self.tuple.integer(Type::of(field.kind), value),
            Value::Single(value) => self.tuple.bytes(&value.to_be_bytes()),
            Value::Double(value) => self.tuple.bytes(&value.to_be_bytes()),
            Value::Text(text) => self.tuple.text(text),
            Value::Raw(bytes) => self.tuple.bytes(bytes),
        }
        self.written += 1;
    }

    fn null(&mut self, field: &'static FieldDesc) {
        if self.nested.is_open() {
            self.nested.null(field);
        } else {
            self.tuple.null();
            self.written += 1;
        }
    }

    fn enter_message(&mut self, field: &'static FieldDesc, message: &'static MessageDesc) {
        self.nested.enter_message(field, message);
    }

    fn leave_message(&mut self) {
        self.nested.leave_message();
        self.end_nested();
    }

    fn enter_list(&mut self, field: &'static FieldDesc, _: usize) {
        self.nested.enter_list(field);
    }

    fn leave_list(&mut self) {
        self.nested.leave_list();
        self.end_nested();
    }
}

#[cfg(test)]
mod tests {
    use super::super::layout::Table;
    use super::*;
    use proptest::prelude::*;

    /// How many columns a tuple says to have, if it holds just as many.
    fn columns(tuple: &[u8]) -> Option<usize> {
        let count = usize::try_from(i16::from_be_bytes(tuple.get(..2)?.try_into().ok()?)).ok()?;
        let mut rest = &tuple[2..];
        for _ in 0..count {
            let length = i32::from_be_bytes(rest.get(..4)?.try_into().ok()?);
            rest = rest.get(4 + usize::try_from(length).unwrap_or(0)..)?;
        }
        rest.is_empty().then_some(count)
    }

    #[test]
    fn times_that_postgresql_has_not_are_minus_infinity() {
        assert_eq!(time(EPOCH_US), 0);
        assert_eq!(time(0), -EPOCH_US);
        assert_eq!(time(store::NO_TIME_US), NEVER);
        assert_eq!(time(FIRST_US + EPOCH_US), FIRST_US);
        assert_eq!(time(FIRST_US + EPOCH_US - 1), NEVER);
        assert_eq!(time(i64::MAX), i64::MAX - EPOCH_US);
    }

    proptest! {
        #[test]
        fn any_payload_becomes_a_row_with_the_columns_of_its_table(
            at in 0..imc::catalogue::MESSAGES.len() + 1,
            payload in proptest::collection::vec(any::<u8>(), 0..200),
        ) {
            let id = imc::catalogue::MESSAGES.get(at).map_or(60_001, |desc| desc.id);
            let mut packet = imc::Packet::new(imc::Header::default(), imc::messages::Heartbeat);
            packet.body = imc::Body::Unknown { id, payload };
            let bytes = packet.encode().unwrap();
            let view = PacketView::new(&bytes).unwrap();
            let item = Item::of(&view, UtcTime::from_micros(7));
            for row in std::iter::once(&item.row).chain(&item.detection) {
                prop_assert_eq!(columns(&row.tuple), Some(Table::new(row.table).columns.len()));
            }
        }
    }
}
