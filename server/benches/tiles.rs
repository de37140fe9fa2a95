//! How soon the chart's tiles are there by the real route: `cargo bench -p server --bench tiles`.
//!
//! The archipelago of the demonstration and the shared cells, where they are, are imported into one set; a server
//! listens on a socket, and one client asks on one connection for every tile that a map of each cell shows, up to
//! `MOST` of each zoom: once when none was drawn yet, once when all are kept.

#![expect(clippy::unwrap_used, reason = "a benchmark ends where it unwraps nothing")]

use chartdb::{ChartDb, ImportOptions, import};
use server::config::Config;
use std::collections::BTreeSet;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use units::UtcTime;

/// From the world to the finest that the map asks for.
const ZOOMS: std::ops::RangeInclusive<u8> = 0..=16;
/// Tiles of a cell at a zoom, at most.
const MOST: usize = 60;
const CELLS: [&str; 9] = [
    "US4MD81M", "US5WA22M", "US5MD1MC", "US1BS01M", "GB4X0000", "GB5X01NE", "GB5X01NW", "GB5X01SE",
    "GB5X02SE",
];

/// Zoom, column and row.
type Tile = (u8, u32, u32);

fn main() {
    let data = tempfile::tempdir().unwrap();
    let tiles = fill(data.path());
    let token = token(data.path());
    let mut config = Config { data: data.path().to_owned(), ..Config::default() };
    config.http.listen = "127.0.0.1:0".parse().unwrap();
    config.imc.active = false;
    config.transports.imcproxy.listen = "127.0.0.1:0".to_owned().try_into().unwrap();
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().unwrap();
    let start = Instant::now();
    let serving = runtime.block_on(server::serve(config)).unwrap();
    let mut client = Client::connect(serving.address, token);
    // A tile where nothing is charted: it waits only for the data that are made once for a set.
    let (_, bytes) = client.tile((16, 0, 0));
    println!("chart set ready to be drawn {:.0?} after the start ({bytes} bytes)", start.elapsed());
    let cold: Vec<(Tile, Duration, usize)> = asked(&mut client, &tiles);
    told("cold", &cold);
    for zoom in ZOOMS {
        told(
            &format!("  zoom {zoom}"),
            &cold.iter().copied().filter(|(tile, ..)| tile.0 == zoom).collect::<Vec<_>>(),
        );
    }
    let slowest = cold.iter().max_by_key(|(_, taken, _)| *taken).unwrap();
    println!("the slowest: {}/{}/{}, {} bytes packed", slowest.0.0, slowest.0.1, slowest.0.2, slowest.2);
    told("kept", &asked(&mut client, &tiles));
    runtime.block_on(serving.stop());
}

/// Makes the chart set; returns the tiles to be requested.
fn fill(data: &Path) -> Vec<Tile> {
    let folder = data.join("cells");
    std::fs::create_dir_all(&folder).unwrap();
    for file in charts::demo::archipelago().unwrap() {
        std::fs::write(folder.join(file.name), file.bytes).unwrap();
    }
    let mut inputs = vec![folder];
    let shared: Option<Vec<PathBuf>> =
        CELLS.iter().map(|name| testkit::shared(&format!("data/charts/{name}.000"))).collect();
    inputs.extend(shared.unwrap_or_default());
    let db = data.join("charts/chart.gpkg");
    std::fs::create_dir_all(db.parent().unwrap()).unwrap();
    let report = import(&db, &inputs, &ImportOptions::new(UtcTime::from_micros(0)), &mut |_| true).unwrap();
    assert!(report.applied, "{:?}", report.failures);
    let mut tiles = BTreeSet::new();
    for chart in ChartDb::open(&db).unwrap().charts().unwrap() {
        let [west, south, east, north] = chart.bounds_deg.unwrap();
        for zoom in ZOOMS {
            let ((left, top), (right, bottom)) = (tile_of(zoom, west, north), tile_of(zoom, east, south));
            let all: Vec<Tile> =
                (top..=bottom).flat_map(|y| (left..=right).map(move |x| (zoom, x, y))).collect();
            tiles.extend(all.iter().step_by(all.len().div_ceil(MOST)));
        }
    }
    tiles.into_iter().collect()
}

fn tile_of(zoom: u8, lon_deg: f64, lat_deg: f64) -> (u32, u32) {
    let wide = f64::from(1_u32 << zoom);
    let y = (1.0 - lat_deg.to_radians().tan().asinh() / std::f64::consts::PI) / 2.0;
    let whole = |share: f64| (share * wide).clamp(0.0, wide - 1.0) as u32;
    (whole((lon_deg + 180.0) / 360.0), whole(y))
}

/// A token of the first person, who must be an admin.
fn token(data: &Path) -> String {
    let command = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lutra-server"));
        command.args(arguments).arg("--data").arg(data);
        command
    };
    let mut add = command(&["user", "add", "bench", "--role", "admin", "--password-stdin"]);
    let mut add = add.stdin(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    add.stdin.take().unwrap().write_all(b"seven otters measure by night\n").unwrap();
    assert!(add.wait().unwrap().success());
    let made = command(&["token", "create", "--person", "bench"]).output().unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    String::from_utf8(made.stdout).unwrap().trim().to_owned()
}

/// One connection that is kept, as a browser keeps it.
struct Client {
    stream: BufReader<TcpStream>,
    token: String,
}

impl Client {
    fn connect(to: SocketAddr, token: String) -> Self {
        let stream = TcpStream::connect(to).unwrap();
        stream.set_nodelay(true).unwrap();
        Self { stream: BufReader::new(stream), token }
    }

    /// From the request to the last byte, and how many there are.
    fn tile(&mut self, (zoom, x, y): Tile) -> (Duration, usize) {
        let request = format!(
            "GET /api/v1/chart/tiles/{zoom}/{x}/{y} HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {}\r\n\
             Accept-Encoding: gzip\r\n\r\n",
            self.token
        );
        let start = Instant::now();
        self.stream.get_mut().write_all(request.as_bytes()).unwrap();
        let (mut length, mut line) = (0, String::new());
        loop {
            line.clear();
            self.stream.read_line(&mut line).unwrap();
            assert!(!line.starts_with("HTTP/1.1") || line.contains("200"), "{line}");
            if line == "\r\n" {
                break;
            }
            let Some((name, value)) = line.split_once(':') else { continue };
            if name.eq_ignore_ascii_case("content-length") {
                length = value.trim().parse().unwrap();
            }
        }
        let mut body = vec![0; length];
        self.stream.read_exact(&mut body).unwrap();
        (start.elapsed(), length)
    }
}

fn asked(client: &mut Client, tiles: &[Tile]) -> Vec<(Tile, Duration, usize)> {
    let one = |tile: &Tile| {
        let (taken, bytes) = client.tile(*tile);
        (*tile, taken, bytes)
    };
    tiles.iter().map(one).collect()
}

fn told(what: &str, times: &[(Tile, Duration, usize)]) {
    let mut ms: Vec<f64> = times.iter().map(|(_, taken, _)| taken.as_secs_f64() * 1e3).collect();
    ms.sort_by(f64::total_cmp);
    let share = |share: f64| ms.get(((ms.len().max(1) - 1) as f64 * share) as usize).copied().unwrap_or(0.0);
    println!(
        "{what}: {} tiles, p50 {:.2} ms, p99 {:.2} ms, most {:.2} ms, {:.0} kB packed at most",
        ms.len(),
        share(0.5),
        share(0.99),
        share(1.0),
        times.iter().map(|(_, _, bytes)| *bytes).max().unwrap_or(0) as f64 / 1e3,
    );
}
