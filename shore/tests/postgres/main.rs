//! A real PostgreSQL that everything recorded goes to: equal to the history, each row once, whole in the end although it is slow, killed,
//! emptied and set back; and what is wrong there is said with what to do.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

mod answers;
mod ashore;
mod database;
mod speed;

use answers::{both, dashboard, reads_for_grafana};
use ashore::{Shore, exported, packet, scratch, slow_line, until};
use database::Postgres;
use detections::{ClockState, Detection, Effort, Origin, Pose, Protocol, ReceiverClock};
use imc::messages::{Announce, CpuUsage, EstimatedState, LogBookEntry, TBRFishTag, Voltage};
use imc::{Address, Header, Packet};
use std::fs;
use std::net::TcpListener;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use store::Store;
use units::{LatLon, UtcTime};

const OTTER: Address = Address(0x2810);
/// When what is said here begins (s since 1970).
const START_S: f64 = 1_795_248_000.0;

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_recorded_log_is_there_value_for_value() {
    let Some(log) = testkit::shared("data/imc/dune_log_a/Data.lsf.gz") else { return };
    let Some(postgres) = Postgres::start() else { return };
    let (_scratch, data, password) = scratch();
    let shore = Shore::start(&data, &postgres.url(), &password).await;
    let now = UtcTime::from_micros(START_S as i64 * 1_000_000);
    let import = move |store: &mut Store| drop(store.import(&[log], now, &mut |_| true).unwrap());
    shore.running.shore.recorder.with_store(import).await.unwrap();
    shore.record(vec![packet(START_S, Voltage { value: 12.5 })]).await;
    shore.caught_up().await;
    shore.end().await;
    let tables = postgres.say(
        "SELECT c.relname FROM pg_class c JOIN pg_namespace n ON n.oid = c.relnamespace WHERE n.nspname = 'lutra' \
         AND c.relkind = 'r' AND c.relname NOT IN ('_lutra', 'vessels', 'detection_reports', '_raw')",
    );
    assert!(tables.lines().count() > 20, "{tables}");
    let mut compared = 0;
    for table in tables.lines() {
        let message = imc::catalogue::MESSAGES
            .iter()
            .find(|desc| desc.abbrev.eq_ignore_ascii_case(table))
            .unwrap()
            .abbrev;
        // Quoted cells may hold line ends and commas; what they hold is another test's.
        if exported(&data, message).contains('"') {
            continue;
        }
        let [mine, theirs] = both(&data, &postgres, message);
        assert_eq!(mine.len(), theirs.len(), "{message}");
        if let Some(at) = (0..mine.len()).find(|at| mine[*at] != theirs[*at]) {
            panic!("{message}: {:?} in the history, {:?} in PostgreSQL", mine[at], theirs[at]);
        }
        compared += mine.iter().map(Vec::len).sum::<usize>();
    }
    println!("{compared} values compared");
    assert!(compared > 200_000, "{compared}");
    let comment = "SELECT col_description('lutra.eulerangles'::regclass, attnum) FROM pg_attribute \
                   WHERE attrelid = 'lutra.eulerangles'::regclass AND attname = 'psi'";
    assert!(postgres.say(comment).contains("unit rad"));
    reads_for_grafana(&postgres);
    for (title, sql) in dashboard() {
        let rows = postgres.ask("grafana", "reads", &sql).unwrap_or_else(|error| panic!("{title}: {error}"));
        // This vessel had no hydrophone.
        assert!(!rows.is_empty() || title.contains("Detections"), "{title} shows nothing: {sql}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn each_row_is_there_once_although_it_is_slow_killed_emptied_and_set_back() {
    let Some(postgres) = Postgres::start() else { return };
    let (_scratch, data, password) = scratch();
    let rate = Arc::new(AtomicU64::new(1 << 30));
    let line = slow_line(postgres.address(), Arc::clone(&rate)).await;
    let url = format!("postgres://{line}/boats");
    let mut shore = Shore::start(&data, &url, &password).await;
    shore.say(10).await;
    shore.caught_up().await;
    assert_eq!(postgres.count("temperature"), 10);
    let cursor = data.join("sinks/postgres.json");
    let early = fs::read_to_string(&cursor).unwrap();

    // One that is slow holds up nothing: all is recorded long before it is there.
    rate.store(20_000, Ordering::Relaxed);
    shore.say(1_490).await;
    assert!(postgres.count("temperature") < 1_500, "it was not slow");
    // Killed in the middle of a batch.
    postgres.down("immediate");
    shore.say(100).await;
    until("noticed", || shore.state().trouble.is_some()).await;
    rate.store(1 << 30, Ordering::Relaxed);
    postgres.up();
    shore.caught_up().await;
    assert_eq!(postgres.count("temperature"), 1_600);

    // As if the shore was killed after commits and before it noted them: the rows come again, and are there once.
    shore.end().await;
    fs::write(&cursor, &early).unwrap();
    let mut shore = Shore { said: 1_600, ..Shore::start(&data, &url, &password).await };
    shore.caught_up().await;
    assert_eq!(postgres.count("temperature"), 1_600);

    // Emptied while the shore runs, then while it does not.
    postgres.say("DROP SCHEMA lutra CASCADE");
    shore.say(10).await;
    until("filled again", || postgres.count("temperature") == 1_610).await;
    shore.caught_up().await;
    shore.end().await;
    postgres.say("DROP SCHEMA lutra CASCADE");
    let shore = Shore::start(&data, &url, &password).await;
    until("filled once more", || postgres.count("temperature") == 1_610).await;
    shore.caught_up().await;

    // Set back, as by a backup of yesterday.
    shore.end().await;
    postgres.say("DELETE FROM lutra.temperature WHERE value > 500; UPDATE lutra._lutra SET batch = 0");
    let shore = Shore::start(&data, &url, &password).await;
    until("whole after the backup", || postgres.count("temperature") == 1_610).await;
    shore.caught_up().await;
    assert_eq!(postgres.say("SELECT address FROM lutra.vessels WHERE src = 10256"), "0x2810");
    shore.end().await;
}

/// Databases that cannot be written to: where, by the password of which file, and what is said.
fn troubles<'p>(
    postgres: &Postgres,
    password: &'p Path,
    wrong: &'p Path,
) -> [(String, &'p Path, &'static str); 5] {
    postgres.admin(
        "CREATE DATABASE latin ENCODING 'LATIN1' TEMPLATE template0 LC_COLLATE 'C' LC_CTYPE 'C' OWNER lutra",
    );
    postgres.admin("CREATE DATABASE foreigns");
    let address = postgres.address();
    let at = |database: &str| format!("postgres://{address}/{database}");
    let closed = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    [
        (at("boats"), wrong, "PostgreSQL refused the login"),
        (at("nowhere"), password, "the database is not there"),
        (at("latin"), password, "holds LATIN1 and not UTF8"),
        (at("foreigns"), password, "CREATE SCHEMA lutra AUTHORIZATION lutra"),
        (format!("postgres://{closed}/boats"), password, "it is not reached"),
    ]
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_is_wrong_there_is_said_and_once_mended_everything_comes() {
    let Some(postgres) = Postgres::start() else { return };
    let (scratch, data, password) = scratch();
    let wrong = scratch.path().join("wrong");
    fs::write(&wrong, "secret of nobody").unwrap();
    for (url, password, trouble) in troubles(&postgres, &password, &wrong) {
        let shore = Shore::start(&data, &url, password).await;
        shore.troubled(trouble).await;
        assert!(!format!("{:?}", shore.state()).contains("secret of nobody"));
        shore.end().await;
    }

    let at = |database: &str| format!("postgres://{}/{database}", postgres.address());
    // A password that is corrected in its file lets the server in at its next attempt.
    let shore = Shore::start(&data, &at("boats"), &wrong).await;
    shore.troubled("refused the login").await;
    fs::write(&wrong, "right").unwrap();
    until("let in", || shore.state().trouble.is_none()).await;
    shore.end().await;

    let mut shore = Shore::start(&data, &at("boats"), &password).await;
    shore.say(20).await;
    shore.caught_up().await;
    // A column of another type, by hand, while the shore is down: nothing is passed over.
    postgres.say("ALTER TABLE lutra.temperature ALTER COLUMN value TYPE text");
    let mut shore = shore.again(&at("boats"), &password).await;
    shore.say(10).await;
    shore.troubled("table temperature holds text in value, not real").await;
    // A column that is missing is made again.
    postgres.say("ALTER TABLE lutra.temperature DROP COLUMN value");
    shore.caught_up().await;
    assert_eq!(postgres.say("SELECT count(*), count(value) FROM lutra.temperature"), "30,10");
    // A column that every row must have, while the connection stands.
    postgres.say(
        "ALTER TABLE lutra.temperature ADD COLUMN who text NOT NULL DEFAULT ''; \
         ALTER TABLE lutra.temperature ALTER COLUMN who DROP DEFAULT",
    );
    shore.say(1).await;
    shore.troubled("wants a value for who in each row").await;
    postgres.say("ALTER TABLE lutra.temperature DROP COLUMN who");
    shore.caught_up().await;
    // A column that would round what it gets.
    postgres.say("ALTER TABLE lutra.temperature ALTER COLUMN value TYPE smallint");
    shore.say(1).await;
    shore.troubled("table temperature holds smallint in value, not real").await;
    postgres.say("ALTER TABLE lutra.temperature ALTER COLUMN value TYPE real");
    shore.caught_up().await;

    // A rule by hand that refuses one row of many: the others are there.
    postgres.say("ALTER TABLE lutra.temperature ADD CHECK (value <> 77)");
    shore.say(100).await;
    shore.caught_up().await;
    assert_eq!(postgres.count("temperature"), 131);
    assert_eq!((shore.state().refused, shore.state().kept), (1, 111));
    // One that refuses all of them: they wait until it is gone.
    postgres.say("ALTER TABLE lutra.temperature ADD CONSTRAINT maintenance CHECK (value < 0) NOT VALID");
    shore.say(150).await;
    shore.troubled("table lutra.temperature refuses every row").await;
    postgres.say("ALTER TABLE lutra.temperature DROP CONSTRAINT maintenance");
    shore.caught_up().await;
    assert_eq!(shore.state().refused, 1);
    shore.end().await;

    // Who only reads may read, and no more.
    reads_for_grafana(&postgres);
    assert_eq!(postgres.ask("grafana", "reads", "SELECT count(*) FROM lutra.temperature").unwrap(), "281");
    let denied = postgres.ask("grafana", "reads", "DELETE FROM lutra.temperature").unwrap_err();
    assert!(denied.contains("permission denied"), "{denied}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn whatever_a_packet_holds_is_there_and_can_be_turned_back() {
    let Some(postgres) = Postgres::start() else { return };
    let (_scratch, data, password) = scratch();
    let shore = Shore::start(&data, &postgres.url(), &password).await;
    let texts: [&[u8]; 4] = [b"a\0b", b"\xff\xfe", br"\x00 typed", "bl\u{e5}b\u{e6}r 'x\"".as_bytes()];
    let mut packets = Vec::new();
    for (at, text) in texts.iter().enumerate() {
        let htime = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -0.0][at];
        let entry = LogBookEntry { text: imc::Text::from_bytes(*text), htime, ..LogBookEntry::default() };
        packets.push(packet(START_S + at as f64, entry));
    }
    for (at, stamp) in [f64::NAN, 0.0, -1e17, 1e12].into_iter().enumerate() {
        packets.push(packet(stamp, CpuUsage { value: 250 + at as u8 }));
    }
    packets.push(packet(
        START_S,
        EstimatedState { lat: 1.1, lon: 0.2, x: 1_000.0, ..EstimatedState::default() },
    ));
    let nonsense = [1e308, f64::INFINITY, f64::NAN];
    for (at, lat) in nonsense.into_iter().enumerate() {
        let state = EstimatedState { lat, height: 7.0, ..EstimatedState::default() };
        packets.push(packet(START_S + 1.0 + at as f64, state));
    }
    let header = Header { timestamp: START_S, src: OTTER, ..Header::default() };
    let mut unknown = Packet::new(header, CpuUsage { value: 1 });
    // By its size the second is another message than the Otters' TBRFishTag, and the Event is cut off.
    for (id, payload) in [(60_001, vec![1, 2, 3]), (2_007, vec![7; 5]), (660, vec![9])] {
        unknown.body = imc::Body::Unknown { id, payload };
        packets.push(unknown.encode().unwrap());
    }
    shore.record(packets).await;
    shore.caught_up().await;
    shore.end().await;
    let told = postgres
        .say("SELECT text || '|' || htime FROM lutra.LogBookEntry WHERE htime IS NOT NULL ORDER BY time");
    let told: Vec<String> = told.lines().map(|line| line.trim_matches('"').replace("\"\"", "\"")).collect();
    let (values, escaped) = (["NaN", "Infinity", "-Infinity", "-0"], texts.map(imc::text::escape));
    for at in 0..texts.len() {
        assert_eq!(told[at], format!("{}|{}", escaped[at], values[at]));
        assert_eq!(imc::text::unescape(&escaped[at]).as_ref(), texts[at]);
    }
    assert_eq!(
        postgres.say("SELECT time FROM lutra.CpuUsage ORDER BY value").lines().collect::<Vec<_>>(),
        ["-infinity", "1970-01-01 00:00:00+00", "-infinity", "33658-09-27 01:46:40+00"]
    );
    let place = postgres.say("SELECT true_lat_deg > lat_deg, abs(lat_deg - degrees(1.1)) < 1e-12 FROM lutra.EstimatedState WHERE lat = 1.1");
    assert_eq!(place, "t,t");
    let degrees = "SELECT lat_deg FROM lutra.EstimatedState WHERE height = 7 ORDER BY time";
    assert_eq!(postgres.say(degrees), "\nInfinity\nNaN");
    assert_eq!(
        postgres.say("SELECT id, encode(payload, 'hex') FROM lutra._raw ORDER BY id"),
        "660,09\n2007,0707070707\n60001,010203"
    );
    assert!(
        postgres.say("SELECT problem FROM lutra._raw WHERE id = 2007").contains("is not that of TBRFishTag")
    );
}

/// What a vessel says of one detection: all of it as an Event, then what IMC's own message holds.
fn detection(tag: u32) -> Detection {
    Detection {
        origin: Origin {
            system: OTTER,
            entity: 9,
            reported: UtcTime::from_micros(START_S as i64 * 1_000_000 + i64::from(tag)),
            received: None,
        },
        receiver: 1_024,
        maker: None,
        clock: ReceiverClock { seconds: START_S as u32 - 2, millis: 250, state: ClockState::Disciplined },
        protocol: Protocol::named("S256"),
        tag_id: tag,
        data: Some(77),
        snr_db: Some(30),
        frequency_khz: Some(69),
        line: 5,
        pose: Some(Pose {
            place: LatLon::from_deg(63.4, 10.4).unwrap(),
            age_s: Some(0.2),
            sigma_m: Some(0.5),
        }),
        effort: Effort { lines_lost: Some(0), noise: None, propeller_rpm: Some(600.0) },
        raw: Some("$001024,1795247998,250,S256,101,77,30,69,5".to_owned()),
    }
}

/// PostGIS makes the view wider when it comes later: it takes more than 2 s to install itself in a database.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_detection_is_there_once_and_has_a_place_with_postgis() {
    let Some(postgres) = Postgres::start() else { return };
    let (_scratch, data, password) = scratch();
    let shore = Shore::start(&data, &postgres.url(), &password).await;
    let announce = Announce { sys_name: "otter-nils".into(), ..Announce::default() };
    let mut packets = vec![packet(START_S, announce)];
    for tag in [101, 102] {
        let one = detection(tag);
        let said_s = one.origin.reported.micros() as f64 / 1e6;
        packets.push(packet(said_s, one.report()));
        packets.push(packet(said_s, one.fish_tag().unwrap()));
    }
    // Another receiver does not know its place or its time.
    let lost = TBRFishTag { serial_no: 7, unix_timestamp: 600, trans_id: 103, ..TBRFishTag::default() };
    packets.push(packet(START_S, lost));
    // One whose stamp is no time counts as of its arrival.
    let never = TBRFishTag { serial_no: 7, unix_timestamp: 600, trans_id: 104, ..TBRFishTag::default() };
    packets.push(packet(f64::NAN, never));
    shore.record(packets).await;
    shore.caught_up().await;
    // It says its name once more; a log of before that, which comes later, does not rename it.
    for (after_s, name) in [(60.0, "otter-nils"), (30.0, "otter-old")] {
        let announce = Announce { sys_name: name.into(), ..Announce::default() };
        shore.record(vec![packet(START_S + after_s, announce)]).await;
        shore.caught_up().await;
    }
    shore.end().await;
    assert_eq!(postgres.count("detection_reports"), 6);
    assert_eq!(postgres.say("SELECT time = received FROM lutra.detections WHERE tag = 104"), "t");
    let seen = "SELECT tag, heard, clock, vessel, round(lat_deg::numeric, 6), pose_age_s, data, propeller_rpm, raw IS NULL \
                FROM lutra.detections ORDER BY tag";
    let heard = "2026-11-21 07:59:58.25+00,disciplined,otter-nils,63.400000,0.2,77,600,f";
    let lost = "not set,otter-nils,,,0,,t";
    assert_eq!(postgres.say(seen), format!("101,{heard}\n102,{heard}\n103,,{lost}\n104,,{lost}"));
    assert!(postgres.ask("lutra", "right", "SELECT place FROM lutra.detections").is_err());
    if postgres.ask("postgres", "admin", "CREATE EXTENSION postgis").is_err() {
        testkit::absent(testkit::Need::Postgis, "apt-get install postgresql-15-postgis-3");
        return;
    }
    let shore = Shore::start(&data, &postgres.url(), &password).await;
    let place = "SELECT tag, ST_AsText(place, 6), ST_SRID(place) FROM lutra.detections ORDER BY tag";
    until("placed", || postgres.ask("lutra", "right", place).is_ok()).await;
    shore.end().await;
    assert_eq!(postgres.say(place), "101,POINT(10.4 63.4),4326\n102,POINT(10.4 63.4),4326\n103,,\n104,,");
    assert_eq!(
        postgres.say("SELECT type, srid FROM geometry_columns WHERE f_table_name = 'detections'"),
        "POINT,4326"
    );
}

/// A view of an earlier version has other columns; who could read it still can, and what a person built on it is not torn down.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_view_of_an_earlier_version_is_made_anew_with_its_rights() {
    let Some(postgres) = Postgres::start() else { return };
    let (_scratch, data, password) = scratch();
    let shore = Shore::start(&data, &postgres.url(), &password).await;
    let one = detection(101);
    let said_s = one.origin.reported.micros() as f64 / 1e6;
    shore.record(vec![packet(said_s, one.report())]).await;
    shore.caught_up().await;
    let made = postgres.say("SELECT 'lutra.detections'::regclass::oid");
    let shore = shore.again(&postgres.url(), &password).await;
    shore.record(vec![packet(START_S, Voltage { value: 1.0 })]).await;
    shore.caught_up().await;
    shore.end().await;
    assert_eq!(postgres.say("SELECT 'lutra.detections'::regclass::oid"), made, "the same definition stays");

    let earlier = "DROP VIEW lutra.detections CASCADE; \
                   CREATE VIEW lutra.detections AS SELECT tag::text AS tag_name, 1 AS gone FROM lutra.detection_reports";
    let comment =
        "COMMENT ON VIEW lutra.detections IS 'Each detection of a tag once: as an earlier version had it'";
    postgres.admin("CREATE ROLE reader LOGIN PASSWORD 'reads'");
    postgres.say(&format!(
        "{earlier}; {comment}; GRANT USAGE ON SCHEMA lutra TO reader; GRANT SELECT ON lutra.detections TO reader"
    ));
    let shore = Shore::start(&data, &postgres.url(), &password).await;
    let seen = || postgres.ask("reader", "reads", "SELECT tag_name, snr_db > 0 FROM lutra.detections");
    until("made anew", || seen().is_ok()).await;
    shore.end().await;
    assert_eq!(seen().unwrap(), "S256-101,t");

    postgres
        .say(&format!("{earlier}; {comment}; CREATE VIEW lutra.mine AS SELECT gone FROM lutra.detections"));
    let shore = Shore::start(&data, &postgres.url(), &password).await;
    shore.record(vec![packet(START_S + 1.0, Voltage { value: 2.0 })]).await;
    shore.caught_up().await;
    shore.end().await;
    assert_eq!(postgres.say("SELECT gone FROM lutra.mine"), "1", "what a person built on it stays");
    assert_eq!(postgres.count("voltage"), 2, "and all is recorded");

    postgres.say(earlier);
    let shore = Shore::start(&data, &postgres.url(), &password).await;
    shore.record(vec![packet(START_S + 2.0, Voltage { value: 3.0 })]).await;
    shore.caught_up().await;
    shore.end().await;
    assert_eq!(
        postgres.say("SELECT gone FROM lutra.detections"),
        "1",
        "a view that Lutra did not make stays"
    );
}

/// PostGIS that is registered and whose functions do not answer: the place of a view that has one is not thrown away for that, and
/// a database without a view gets one without.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_failed_attempt_does_not_take_the_place_out_of_a_view() {
    let Some(postgres) = Postgres::start() else { return };
    postgres.admin(
        "SET allow_system_table_mods = on;
         INSERT INTO pg_extension (oid, extname, extowner, extnamespace, extrelocatable, extversion) \
           VALUES (70000, 'postgis', 10, 'public'::regnamespace, false, '3.3')",
    );
    let (_scratch, data, password) = scratch();
    let mut shore = Shore::start(&data, &postgres.url(), &password).await;
    shore.say(1).await;
    shore.caught_up().await;
    assert_eq!(postgres.say("SELECT count(tag) FROM lutra.detections"), "0", "it is made without geometry");
    postgres.say(
        "DROP VIEW lutra.detections; CREATE VIEW lutra.detections AS SELECT tag, 'POINT(10 63)'::text AS place \
           FROM lutra.detection_reports; \
         COMMENT ON VIEW lutra.detections IS 'Each detection of a tag once: as an earlier version had it'",
    );
    let mut shore = shore.again(&postgres.url(), &password).await;
    shore.say(1).await;
    shore.caught_up().await;
    shore.end().await;
    assert_eq!(postgres.count("temperature"), 2, "all is recorded");
    assert_eq!(postgres.say("SELECT count(place) FROM lutra.detections"), "0", "the place is still there");
}

/// TimescaleDB is not in Debian: a stand-in with the signature of its function notes what it is asked for.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn tables_become_hypertables_where_timescaledb_is_installed() {
    let Some(postgres) = Postgres::start() else { return };
    postgres.admin(
        "CREATE TABLE public.asked (name text, column_name text, chunk interval);
         CREATE FUNCTION public.create_hypertable(relation regclass, time_column_name name, partitioning_column name = NULL, \
           number_partitions integer = NULL, associated_schema_name name = NULL, associated_table_prefix name = NULL, \
           chunk_time_interval anyelement = NULL::bigint, create_default_indexes boolean = true, if_not_exists boolean = false) \
           RETURNS void LANGUAGE sql SECURITY DEFINER AS \
           'INSERT INTO public.asked VALUES (relation::text, time_column_name, chunk_time_interval::text::interval)';
         SET allow_system_table_mods = on;
         INSERT INTO pg_extension (oid, extname, extowner, extnamespace, extrelocatable, extversion) \
           VALUES (70000, 'timescaledb', 10, 'public'::regnamespace, false, '2.15')",
    );
    let (_scratch, data, password) = scratch();
    let mut shore = Shore::start(&data, &postgres.url(), &password).await;
    shore.say(3).await;
    shore.caught_up().await;
    assert_eq!(postgres.count("temperature"), 3);
    shore.end().await;
    assert_eq!(
        postgres.admin("SELECT * FROM public.asked ORDER BY name"),
        "lutra.detection_reports,time,7 days\nlutra.temperature,time,7 days"
    );
}
