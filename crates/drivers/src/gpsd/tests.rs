//! gpsd's side played by hand: its banner, the receiver's sentences, its reports, and what it lacks.

use super::*;
use units::UtcTime;

fn at(ms: u64) -> Now {
    Now { mono: MonoTime::from_micros(ms * 1000), utc: UtcTime::from_micros(ms as i64 * 1000) }
}

fn open(watch: Watch) -> Gpsd {
    let mut gpsd = Gpsd::new(watch, &CompassSettings::default());
    gpsd.handle(at(0), Input::Opened);
    gpsd
}

fn outputs(gpsd: &mut Gpsd) -> Vec<Output> {
    std::iter::from_fn(|| gpsd.poll_output()).collect()
}

fn sent(outputs: &[Output]) -> Vec<String> {
    let sent = |output: &Output| match output {
        Output::Send { bytes, .. } => Some(String::from_utf8(bytes.clone()).unwrap()),
        _ => None,
    };
    outputs.iter().filter_map(sent).collect()
}

fn run_to(gpsd: &mut Gpsd, ms: u64) {
    while let Some(due) = gpsd.poll_timeout().filter(|due| *due <= at(ms).mono) {
        gpsd.handle(at(due.micros().div_ceil(1000)), Input::Time);
    }
}

const BANNER: &[u8] = b"{\"class\":\"VERSION\",\"release\":\"3.22\"}\r\n{\"class\":\"DEVICES\",\"devices\":[{\"path\":\"/dev/x\"}]}\r\n";

#[test]
fn the_receivers_own_sentences_are_asked_for_and_read() {
    let mut gpsd = open(Watch::Nmea);
    assert_eq!(sent(&outputs(&mut gpsd)), ["?WATCH={\"enable\":true,\"nmea\":true}\r\n"]);
    gpsd.handle(at(10), Input::Bytes(BANNER));
    gpsd.handle(
        at(20),
        Input::Bytes(b"$GPHDT,81.01,T*3D\r\n$GPGGA,100000.00,6326.4300000,N,01021.0360000,E,1,07,0.6"),
    );
    gpsd.handle(at(30), Input::Bytes(b",1.10,M,39.16,M,,*60\r\n"));
    run_to(&mut gpsd, 200);
    let found = outputs(&mut gpsd);
    let Some(Output::Reading { reading: Reading::Gnss(reading), .. }) = found.last() else {
        panic!("{found:?}")
    };
    assert!((reading.fix.unwrap().lat_rad.to_degrees() - 63.4405).abs() < 1e-9);
    assert!((reading.heading_rad.unwrap().to_degrees() - 81.01).abs() < 1e-9);
    assert!(found.contains(&Output::State(State::Working)));
}

#[test]
fn its_reports_are_readings_too() {
    let mut gpsd = open(Watch::Json);
    gpsd.handle(at(10), Input::Bytes(BANNER));
    gpsd.handle(
        at(20),
        Input::Bytes(
            b"{\"class\":\"ATT\",\"heading\":10.0}\r\n{\"class\":\"SKY\",\"hdop\":0.7,\"uSat\":9}\r\n",
        ),
    );
    let tpv = b"{\"class\":\"TPV\",\"mode\":3,\"lat\":63.5,\"lon\":10.25,\"speed\":1.0,\"track\":5.0}\r\n";
    gpsd.handle(at(30), Input::Bytes(tpv));
    gpsd.handle(at(3030), Input::Bytes(tpv));
    let readings: Vec<_> = outputs(&mut gpsd)
        .into_iter()
        .filter_map(|output| match output {
            Output::Reading { reading: Reading::Gnss(reading), .. } => Some(reading),
            _ => None,
        })
        .collect();
    assert_eq!(readings.len(), 2);
    assert_eq!((readings[0].satellites, readings[0].fix.unwrap().hdop), (9, 0.7));
    // The heading is of three seconds before the second.
    assert_eq!(readings.iter().map(|one| one.heading_rad.is_some()).collect::<Vec<_>>(), [true, false]);
}

#[test]
fn what_gpsd_lacks_is_said() {
    for watch in [Watch::Nmea, Watch::Json] {
        let mut gpsd = open(watch);
        gpsd.handle(at(10), Input::Bytes(b"{\"class\":\"DEVICES\",\"devices\":[]}\r\n"));
        outputs(&mut gpsd);
        run_to(&mut gpsd, 4500);
        let found = outputs(&mut gpsd);
        assert!(found.iter().any(
            |output| matches!(output, Output::State(State::Failing(why)) if why.contains("has no receiver"))
        ));
        assert_eq!(sent(&found).len(), 1);
        gpsd.handle(at(5000), Input::Lost);
        let found = outputs(&mut gpsd);
        assert!(
            matches!(&found[..], [Output::State(State::Failing(why))] if why.contains("port 2947")),
            "{found:?}"
        );
        assert_eq!(gpsd.poll_timeout(), None);
    }
}

#[test]
fn an_endless_line_is_bounded_and_the_next_is_read() {
    let mut gpsd = open(Watch::Json);
    for _ in 0..100 {
        gpsd.handle(at(10), Input::Bytes(&[b'{'; 1000]));
        assert!(gpsd.lines.kept() <= LONGEST);
    }
    gpsd.handle(at(20), Input::Bytes(b"\n{\"class\":\"TPV\",\"mode\":1}\n"));
    assert!(outputs(&mut gpsd).iter().any(|output| matches!(output, Output::Reading { .. })));
}
