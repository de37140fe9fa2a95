//! Bytes to frames.

use super::{
    Ack, Batch, Bye, ByeCode, Capabilities, ChartDigest, ChartOffer, ChartPart, ChartReport, ChartRequest,
    ChartStage, Command, Frame, Gap, GapReason, Heartbeat, Hello, Lease, MAX_MESSAGE_BYTES, MAX_TEXT_BYTES,
    Receipt, Stamp, Verdict, Welcome,
};
use crate::ways::{MOST_WAY_NAME_BYTES, MOST_WAYS, Thinning, WayHello, WayReport, WayState, WaysReport, Why};
use crate::wire::{DecodeError, Reader};
use bytes::Bytes;
use units::{MonoTime, UtcTime};

/// The frames of a message, one after the other. Unknown ones are skipped. Ends after an error.
#[derive(Debug)]
pub struct Frames {
    rest: Option<Reader>,
}

/// The frames of a message.
///
/// # Errors
/// When the message is longer than [`MAX_MESSAGE_BYTES`].
pub fn decode(message: Bytes) -> Result<Frames, DecodeError> {
    let (have, most) = (message.len() as u64, MAX_MESSAGE_BYTES as u64);
    if have > most {
        return Err(DecodeError::TooLong { what: "a message", have, most });
    }
    Ok(Frames { rest: Some(Reader::new(message)) })
}

impl Iterator for Frames {
    type Item = Result<Frame, DecodeError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let rest = self.rest.as_mut().filter(|rest| !rest.is_empty())?;
            match one(rest) {
                Ok(None) => {}
                Ok(Some(frame)) => return Some(Ok(frame)),
                Err(error) => {
                    self.rest = None;
                    return Some(Err(error));
                }
            }
        }
    }
}

fn one(rest: &mut Reader) -> Result<Option<Frame>, DecodeError> {
    let number = rest.u8("the type of a frame")?;
    let length = rest.u32("the length of a frame")?;
    let body = Reader::new(rest.take(length as usize, "a frame")?);
    Ok(Some(match number {
        1 => Frame::Hello(hello(body)?),
        2 => Frame::Welcome(welcome(body)?),
        3 => Frame::Records(batch(body)?),
        4 => Frame::Live(batch(body)?),
        5 => Frame::Gap(gap(body)?),
        6 => Frame::Ack(ack(body)?),
        7 => Frame::Command(command(body, false)?),
        8 => Frame::Receipt(receipt(body)?),
        9 => Frame::Heartbeat(heartbeat(body)?),
        10 => Frame::Bye(bye(body)?),
        11 => Frame::Lease(lease(body)?),
        12 => Frame::Chart(chart_offer(body)?),
        13 => Frame::ChartRequest(chart_ask(body)?),
        14 => Frame::ChartPart(chart_part(body)?),
        15 => Frame::ChartReport(chart_report(body)?),
        16 => Frame::Ways(ways(body)?),
        17 => Frame::Command(command(body, true)?),
        _ => return Ok(None),
    }))
}

fn hello(mut body: Reader) -> Result<Hello, DecodeError> {
    const WHAT: &str = "the greeting";
    if &body.take(4, WHAT)?[..] != b"LLNK" {
        return Err(DecodeError::NoLink);
    }
    let mut hello = Hello {
        version: body.u16(WHAT)?,
        oldest_version: body.u16(WHAT)?,
        capabilities: Capabilities(body.u32(WHAT)?),
        address: body.u16(WHAT)?,
        incarnation: body.u64(WHAT)?,
        attempt: body.u64(WHAT)?,
        stream: body.u64(WHAT)?,
        first: body.u64(WHAT)?,
        next: body.u64(WHAT)?,
        stamp: stamp(&mut body)?,
        name: body.text(MAX_TEXT_BYTES, "the vessel's name")?,
        software: body.text(MAX_TEXT_BYTES, "the program's name")?,
        way: None,
    };
    if hello.capabilities.has(Capabilities::WAYS) && !body.is_empty() {
        let index = body.u8(WHAT)?;
        if usize::from(index) >= MOST_WAYS {
            return Err(DecodeError::BadValue { what: "the place of a way", value: u64::from(index) });
        }
        let metered = body.u8(WHAT)? & 1 == 1;
        let name = body.text(MOST_WAY_NAME_BYTES, "the name of a way")?;
        hello.way = Some(WayHello { index, metered, name });
    }
    Ok(hello)
}

fn welcome(mut body: Reader) -> Result<Welcome, DecodeError> {
    const WHAT: &str = "the welcome";
    let mut welcome = Welcome {
        version: body.u16(WHAT)?,
        capabilities: Capabilities(body.u32(WHAT)?),
        resume: body.u64(WHAT)?,
        window_bytes: body.u32(WHAT)?,
        stamp: stamp(&mut body)?,
        run: None,
    };
    if welcome.capabilities.has(Capabilities::WAYS) && !body.is_empty() {
        welcome.run = Some(body.u64(WHAT)?);
    }
    Ok(welcome)
}

fn batch(mut body: Reader) -> Result<Batch, DecodeError> {
    const WHAT: &str = "a batch";
    Ok(Batch {
        first: body.u64(WHAT)?,
        base: UtcTime::from_micros(body.i64(WHAT)?),
        count: body.u32(WHAT)?,
        raw_bytes: body.u32(WHAT)?,
        compressed: is_compressed(&mut body, "a batch's method")?,
        data: body.rest(),
    })
}

/// The method by which data is packed.
fn is_compressed(body: &mut Reader, what: &'static str) -> Result<bool, DecodeError> {
    match body.u8(what)? {
        0 => Ok(false),
        1 => Ok(true),
        other => Err(DecodeError::BadValue { what, value: u64::from(other) }),
    }
}

fn gap(mut body: Reader) -> Result<Gap, DecodeError> {
    const WHAT: &str = "a gap";
    let gap = Gap {
        from: body.u64(WHAT)?,
        to: body.u64(WHAT)?,
        since: UtcTime::from_micros(body.i64(WHAT)?),
        until: UtcTime::from_micros(body.i64(WHAT)?),
        reason: GapReason::from_code(body.u8(WHAT)?),
    };
    if gap.to <= gap.from {
        return Err(DecodeError::BadValue { what: "the end of a gap", value: gap.to });
    }
    Ok(gap)
}

fn ack(mut body: Reader) -> Result<Ack, DecodeError> {
    const WHAT: &str = "an acknowledgement";
    Ok(Ack { received: body.u64(WHAT)?, durable: body.u64(WHAT)?, bytes: body.u64(WHAT)? })
}

fn command(mut body: Reader, of_order: bool) -> Result<Command, DecodeError> {
    const WHAT: &str = "a command";
    let command = Command {
        id: body.u64(WHAT)?,
        sent: MonoTime::from_micros(body.u64(WHAT)?),
        ttl_ms: body.u32(WHAT)?,
        lease: body.u64(WHAT)?,
        order: if of_order { body.u64(WHAT)? } else { 0 },
        packet: body.rest(),
    };
    let (have, most) = (command.packet.len() as u64, imc::MAX_PACKET_BYTES as u64);
    if have > most { Err(DecodeError::TooLong { what: WHAT, have, most }) } else { Ok(command) }
}

fn receipt(mut body: Reader) -> Result<Receipt, DecodeError> {
    const WHAT: &str = "a receipt";
    Ok(Receipt {
        id: body.u64(WHAT)?,
        verdict: match body.u8(WHAT)? {
            1 => Verdict::Received,
            2 => Verdict::Expired,
            3 => Verdict::Refused,
            other => return Err(DecodeError::BadValue { what: "a verdict", value: u64::from(other) }),
        },
        text: body.text(MAX_TEXT_BYTES, WHAT)?,
        order: if body.is_empty() { 0 } else { body.u64(WHAT)? },
    })
}

fn heartbeat(mut body: Reader) -> Result<Heartbeat, DecodeError> {
    const WHAT: &str = "a heartbeat";
    Ok(Heartbeat {
        stamp: stamp(&mut body)?,
        bytes: body.u64(WHAT)?,
        next: body.u64(WHAT)?,
        durable: body.u64(WHAT)?,
        waiting_us: body.u64(WHAT)?,
        kept_us: body.u64(WHAT)?,
    })
}

fn bye(mut body: Reader) -> Result<Bye, DecodeError> {
    const WHAT: &str = "a farewell";
    Ok(Bye { code: ByeCode::from_code(body.u8(WHAT)?), text: body.text(MAX_TEXT_BYTES, WHAT)? })
}

fn lease(mut body: Reader) -> Result<Lease, DecodeError> {
    const WHAT: &str = "a lease";
    Ok(Lease {
        epoch: body.u64(WHAT)?,
        ttl_ms: body.u32(WHAT)?,
        holder: body.text(MAX_TEXT_BYTES, "the holder of a lease")?,
        number: if body.is_empty() { 0 } else { body.u64(WHAT)? },
    })
}

fn ways(mut body: Reader) -> Result<WaysReport, DecodeError> {
    const WHAT: &str = "the report of ways";
    let place = |byte: u8| (usize::from(byte) < MOST_WAYS).then_some(byte);
    let mut report = WaysReport {
        choice: body.u64(WHAT)?,
        live: place(body.u8(WHAT)?),
        live_why: Why::from_code(body.u8(WHAT)?),
        records: place(body.u8(WHAT)?),
        records_why: Why::from_code(body.u8(WHAT)?),
        ways: Vec::new(),
    };
    let count = usize::from(body.u8(WHAT)?);
    if count > MOST_WAYS {
        let (have, most) = (count as u64, MOST_WAYS as u64);
        return Err(DecodeError::TooLong { what: "the ways of a vessel", have, most });
    }
    for _ in 0..count {
        report.ways.push(WayReport {
            metered: body.u8(WHAT)? & 1 == 1,
            state: WayState::from_code(body.u8(WHAT)?),
            thinning: Thinning::from_code(body.u8(WHAT)?),
            late_per_mille: body.u16(WHAT)?,
            round_trip_us: body.u32(WHAT)?,
            rate_bytes_per_s: body.u32(WHAT)?,
            failures: body.u32(WHAT)?,
            today_bytes: body.u64(WHAT)?,
            daily_bytes: body.u64(WHAT)?,
            name: body.text(MOST_WAY_NAME_BYTES, "the name of a way")?,
        });
    }
    Ok(report)
}

fn chart_offer(mut body: Reader) -> Result<ChartOffer, DecodeError> {
    const WHAT: &str = "the offer of a chart";
    Ok(ChartOffer {
        digest: digest(&mut body, WHAT)?,
        bytes: body.u64(WHAT)?,
        edition: body.text(MAX_TEXT_BYTES, "the edition of a chart")?,
    })
}

fn chart_ask(mut body: Reader) -> Result<ChartRequest, DecodeError> {
    const WHAT: &str = "the wish for a part of a chart";
    Ok(ChartRequest { digest: digest(&mut body, WHAT)?, offset: body.u64(WHAT)?, length: body.u32(WHAT)? })
}

fn chart_part(mut body: Reader) -> Result<ChartPart, DecodeError> {
    const WHAT: &str = "a part of a chart";
    Ok(ChartPart {
        digest: digest(&mut body, WHAT)?,
        offset: body.u64(WHAT)?,
        raw_bytes: body.u32(WHAT)?,
        compressed: is_compressed(&mut body, "a chart part's method")?,
        data: body.rest(),
    })
}

fn chart_report(mut body: Reader) -> Result<ChartReport, DecodeError> {
    const WHAT: &str = "the report of a chart";
    Ok(ChartReport {
        held: digest(&mut body, WHAT)?,
        edition: body.text(MAX_TEXT_BYTES, "the edition of a chart")?,
        stage: ChartStage::from_code(body.u8(WHAT)?),
        have: body.u64(WHAT)?,
        of: body.u64(WHAT)?,
        text: body.text(MAX_TEXT_BYTES, WHAT)?,
    })
}

fn digest(body: &mut Reader, what: &'static str) -> Result<ChartDigest, DecodeError> {
    body.array(what)
}

fn stamp(body: &mut Reader) -> Result<Stamp, DecodeError> {
    const WHAT: &str = "a stamp";
    Ok(Stamp {
        mono: MonoTime::from_micros(body.u64(WHAT)?),
        utc: UtcTime::from_micros(body.i64(WHAT)?),
        echo: MonoTime::from_micros(body.u64(WHAT)?),
        echo_received: MonoTime::from_micros(body.u64(WHAT)?),
    })
}
