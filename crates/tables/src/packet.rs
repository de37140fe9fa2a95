//! A packet as a line of its message's table.

use crate::cell;
use crate::column::{Computed, Field, computed_place};
use crate::dialect::Format;
use crate::number::{self, IsoTime};
use imc::catalogue::{FieldDesc, MessageDesc};
use imc::json::NestedText;
use imc::messages::TBRFishTag;
use imc::names::Names;
use imc::reflect::{self, Value, Visitor, WalkError};
use imc::{PacketView, Payload as _};
use units::UtcTime;

/// Fields of `EstimatedState` by which it says where the vessel is.
const PLACE_FIELDS: usize = 6;

/// Writes packets as lines, with the columns that [`crate::FIXED`] and [`crate::fields`] name.
#[derive(Debug)]
pub struct PacketRow {
    format: Format,
    iso: IsoTime,
    nested: NestedText,
}

impl PacketRow {
    /// At the beginning of a table.
    pub fn new(format: Format) -> Self {
        Self { format, iso: IsoTime::new(), nested: NestedText::default() }
    }

    /// Appends the line of a packet of this message. An older sender may have left out the last fields.
    ///
    /// # Errors
    /// When its fields do not fit its payload; `out` is as before then.
    pub fn write(
        &mut self,
        out: &mut Vec<u8>,
        view: &PacketView<'_>,
        (desc, fields): (&'static MessageDesc, &[Field]),
        names: &Names,
    ) -> Result<(), WalkError> {
        let start = out.len();
        self.start(out, view, names);
        let own: Vec<&Field> = fields.iter().filter(|field| field.at.is_some()).collect();
        let mut values =
            Values { row: self, out: Vec::new(), fields: &own, next: 0, first: [f64::NAN; PLACE_FIELDS] };
        values.row.nested.reset();
        let walked = match reflect::walk_payload(desc, view.payload(), view.order(), true, &mut values) {
            Ok(walked) => walked,
            Err(error) => {
                out.truncate(start);
                return Err(error);
            }
        };
        let (cells, first) = (values.out, values.first);
        let place = (walked.fields >= PLACE_FIELDS).then(|| computed_place(first)).flatten();
        for field in fields {
            if let Some(computed) = field.computed {
                self.format.next(out);
                self.computed(out, computed, view, place);
            }
        }
        out.extend_from_slice(&cells);
        self.format.skip(out, own.len() - walked.fields);
        out.push(b'\n');
        Ok(())
    }

    /// The cells at the start of every line.
    fn start(&mut self, out: &mut Vec<u8>, view: &PacketView<'_>, names: &Names) {
        let (header, format) = (view.header(), self.format);
        let time_us = header.time().map(UtcTime::micros);
        number::stamp(out, &mut self.iso, time_us, format.dialect);
        format.next(out);
        cell::text(out, names.system(header.src).as_bytes(), format);
        format.next(out);
        out.extend_from_slice(format!("{:#06x}", header.src.0).as_bytes());
        format.next(out);
        let label = names.entity(header.src, header.src_ent, time_us.unwrap_or(i64::MIN)).unwrap_or_default();
        cell::text(out, label.as_bytes(), format);
        format.next(out);
        number::integer(out, header.src_ent.into());
        format.next(out);
        out.extend_from_slice(format!("{:#06x}", header.dst.0).as_bytes());
        format.next(out);
        number::integer(out, header.dst_ent.into());
    }

    fn computed(
        &mut self,
        out: &mut Vec<u8>,
        computed: Computed,
        view: &PacketView<'_>,
        place: Option<(f64, f64)>,
    ) {
        let dialect = self.format.dialect;
        let heard = |view| {
            let tag = (TBRFishTag::ID == PacketView::id(view))
                .then(|| imc::decode::<TBRFishTag>(view).ok().flatten());
            tag.flatten().and_then(|tag| Computed::heard(tag.unix_timestamp, tag.millis))
        };
        match computed {
            Computed::Heard => {
                if let Some((seconds, millis)) = heard(view) {
                    self.iso.write_ms(out, i64::from(seconds) * 1_000_000 + i64::from(millis) * 1_000);
                }
            }
            Computed::HeardUnix => {
                if let Some((seconds, millis)) = heard(view) {
                    number::double(out, f64::from(seconds) + f64::from(millis) / 1_000.0, dialect);
                }
            }
            Computed::TrueLat | Computed::TrueLon => {
                let at = place.map(
                    |(lat_deg, lon_deg)| {
                        if computed == Computed::TrueLat { lat_deg } else { lon_deg }
                    },
                );
                if let Some(deg) = at {
                    number::double(out, deg, dialect);
                }
            }
        }
    }
}

/// The message's own fields as cells, each after a separator.
struct Values<'r, 'f> {
    row: &'r mut PacketRow,
    out: Vec<u8>,
    fields: &'f [&'f Field],
    next: usize,
    /// The first numbers of the message.
    first: [f64; PLACE_FIELDS],
}

impl Values<'_, '_> {
    /// Begins the cell of the next field.
    fn begin(&mut self) -> usize {
        self.row.format.next(&mut self.out);
        self.next += 1;
        self.next - 1
    }

    fn end_nested(&mut self) {
        if !self.row.nested.is_open() {
            self.begin();
            cell::quoted(&mut self.out, self.row.nested.text(), self.row.format);
        }
    }
}

impl<'a> Visitor<'a> for Values<'_, '_> {
    fn value(&mut self, desc: &'static FieldDesc, value: Value<'a>) {
        if self.row.nested.is_open() {
            return self.row.nested.value(desc, value);
        }
        let at = self.begin();
        if let (Some(first), Some(number)) = (self.first.get_mut(at), value.as_f64()) {
            *first = number;
        }
        let (out, format) = (&mut self.out, self.row.format);
        let field = self.fields[at];
        match value {
            Value::Integer(value) => field.write_integer(out, value, format),
            Value::Single(value) => field.write_real(out, value.into(), format),
            Value::Double(value) => field.write_real(out, value, format),
            Value::Text(text) => cell::text(out, text, format),
            Value::Raw(bytes) => cell::hex(out, bytes),
        }
    }

    fn null(&mut self, desc: &'static FieldDesc) {
        if self.row.nested.is_open() {
            self.row.nested.null(desc);
        } else {
            self.begin();
        }
    }

    fn enter_message(&mut self, desc: &'static FieldDesc, message: &'static MessageDesc) {
        self.row.nested.enter_message(desc, message);
    }

    fn leave_message(&mut self) {
        self.row.nested.leave_message();
        self.end_nested();
    }

    fn enter_list(&mut self, desc: &'static FieldDesc, _: usize) {
        self.row.nested.enter_list(desc);
    }

    fn leave_list(&mut self) {
        self.row.nested.leave_list();
        self.end_nested();
    }
}
