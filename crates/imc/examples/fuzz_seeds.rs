//! Writes the seeds of the fuzz targets into `fuzz/seeds`: `cargo run -p imc --example fuzz_seeds`.

use flate2::{Compression, write::GzEncoder};
use imc::catalogue::MESSAGES;
use imc::messages::{
    DesiredSpeed, EntityParameter, EntityState, EstimatedState, Goto, MsgList, PlanManeuver,
    PlanSpecification, Reference, Rpm, SetEntityParameters, TBRFishTag,
};
use imc::{ByteOrder, Header, Message, Packet, PacketView, ShortPayload, json};
use std::fs;
use std::io::Write as _;
use std::path::Path;

fn messages() -> Vec<Message> {
    let parameter = EntityParameter { name: "Active".into(), value: "true".into() };
    let payload = SetEntityParameters { name: "TBLive".into(), params: [parameter].into_iter().collect() };
    let goto = PlanManeuver {
        maneuver_id: "wp1".into(),
        data: Goto { lat: 1.107, lon: 0.18, speed: 1.2, custom: "a=1;b=2".into(), ..Goto::default() }.into(),
        start_actions: [payload].into_iter().collect(),
        ..PlanManeuver::default()
    };
    let plan = PlanSpecification {
        plan_id: "survey".into(),
        start_man_id: "wp1".into(),
        maneuvers: [goto].into_iter().collect(),
        ..PlanSpecification::default()
    };
    let speed = DesiredSpeed { value: f64::NAN, ..DesiredSpeed::default() };
    vec![
        EstimatedState { lat: 1.107, lon: 0.18, x: 12.5, ..EstimatedState::default() }.into(),
        EntityState { description: "på vei".into(), ..EntityState::default() }.into(),
        Rpm { value: -700 }.into(),
        TBRFishTag { serial_no: 45, trans_id: 1023, ..TBRFishTag::default() }.into(),
        TBRFishTag { lat: Some(1.1), lon: Some(0.18), ..TBRFishTag::default() }.into(),
        Reference { speed: speed.into(), ..Reference::default() }.into(),
        plan.clone().into(),
        MsgList { msgs: [Message::from(plan), Rpm { value: -700 }.into()].into_iter().collect() }.into(),
    ]
}

fn write(folder: &Path, name: &str, bytes: &[u8]) -> std::io::Result<()> {
    fs::create_dir_all(folder)?;
    fs::write(folder.join(name), bytes)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let seeds = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/seeds"));
    let header = Header { timestamp: 1_590_400_000.125, ..Header::default() };
    let mut stream = Vec::new();
    for (at, message) in messages().into_iter().enumerate() {
        let order = if at % 2 == 0 { ByteOrder::Little } else { ByteOrder::Big };
        let packet = Packet { order, ..Packet::new(header, message) };
        let bytes = packet.encode()?;
        let view = PacketView::new(&bytes)?;
        let name = format!("{at}_{}", packet.message().map_or("", Message::abbrev));
        write(&seeds.join("imc_packet"), &name, &bytes)?;
        let taken_apart =
            [&[u8::from(order == ByteOrder::Big)], &view.id().to_le_bytes()[..], view.payload()];
        write(&seeds.join("imc_packet"), &format!("{name}_apart"), &taken_apart.concat())?;
        let mut text = Vec::new();
        json::write_packet(&mut text, &view, ShortPayload::default())?;
        write(&seeds.join("imc_json"), &name, &text)?;
        stream.extend_from_slice(&bytes);
        stream.extend_from_slice(&b"rubbish"[..at]);
    }
    // Every id once, so that the fuzzer need not guess them.
    for desc in MESSAGES {
        let text = format!(r#"{{"abbrev":"{}","fields":{{}}}}"#, desc.abbrev);
        let packet = json::read_packet(&serde_json::from_str(&text)?, &json::ReadDefaults::default())?;
        let bytes = packet.encode()?;
        let apart = [&[0], &desc.id.to_le_bytes()[..], PacketView::new(&bytes)?.payload()].concat();
        write(&seeds.join("imc_packet"), &format!("id_{:04}", desc.id), &apart)?;
    }
    write(&seeds.join("imc_deframer"), "stream", &[&[16], &stream[..]].concat())?;
    write(&seeds.join("imc_deframer"), "false_starts", &[&[0], &[0x54, 0xFE].repeat(60)[..]].concat())?;
    write(&seeds.join("imc_lsf"), "plain", &stream)?;
    let mut gzip = GzEncoder::new(Vec::new(), Compression::default());
    gzip.write_all(&stream)?;
    let member = gzip.finish()?;
    write(&seeds.join("imc_lsf"), "two_members", &[&member[..], &member].concat())?;
    write(&seeds.join("imc_lsf"), "cut", &member[..member.len() / 2])?;
    Ok(())
}
