//! Bytes as bad lines make them: the fuzz target's body over its committed seeds, everything it ever found, and what
//! proptest makes of good lines by cutting, gluing, corrupting, reversing and stretching them.

#[path = "../../../../fuzz/bodies/receivers.rs"]
mod bodies;

use proptest::collection::vec;
use proptest::prelude::*;

#[test]
fn seeds_hold() {
    let folder = testkit::repository().join("fuzz/seeds/receivers");
    let mut files: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(!files.is_empty(), "{} has no seeds", folder.display());
    for file in files {
        println!("{}", file.display());
        let bytes = std::fs::read(file).unwrap();
        for cut in 0..bytes.len() {
            bodies::lines(&bytes[..cut]);
        }
        bodies::lines(&bytes);
    }
}

/// Good lines of every device, and beginnings that mean something.
const LINES: [&[u8]; 13] = [
    b"$GPHDT,81.01,T*3D\r\n",
    b"$GPGGA,100000.00,6326.4300000,N,01021.0360000,E,1,07,0.6,1.10,M,39.16,M,,*60\r\n",
    b"$GPZDA,100000.00,21,11,2026,00,00*62\r\n",
    b"$000025,1487343577,721,S256,40,13,17,67,15790\r",
    b"$1000042,0000000600,TBR Sensor,297,15,29,69,6\r",
    b"ack01\rack02\rLIVECM\rFC=69\rFV=v1.0.6\rEX!\r",
    b"450123,017,2026-09-21 12:43:17,A69-1303,12345,#D0\r\n",
    b"457777,204,2026-09-21 12:44:02.317,A69-1602,48211,S=61,N=34,C=0,#C8\r\n",
    b"{\"class\":\"TPV\",\"mode\":3,\"lat\":63.5,\"lon\":10.2,\"time\":\"2026-11-21T10:00:01.000Z\"}\r\n",
    b"$>JATT,NMEAHE,OK\r\n",
    b"$77,1795000000250,R64K,1705,,21,69,8*3D\r\n",
    b"{id},{unix_s}.{ms},{data?}#{sum8}\n7,1795000000.250,#3D\n",
    b"$",
];

/// A line, whole or hurt.
fn piece() -> impl Strategy<Value = Vec<u8>> {
    let line = (0..LINES.len()).prop_map(|index| LINES[index].to_vec());
    let cut = (line.clone(), any::<prop::sample::Index>()).prop_map(|(mut line, at)| {
        line.truncate(at.index(line.len()));
        line
    });
    let corrupt =
        (line.clone(), any::<prop::sample::Index>(), any::<u8>()).prop_map(|(mut line, at, byte)| {
            let index = at.index(line.len());
            line[index] = byte;
            line
        });
    let reversed = line.clone().prop_map(|mut line| {
        line.reverse();
        line
    });
    let endless = (any::<u8>(), 200..1200_usize).prop_map(|(byte, length)| vec![byte; length]);
    prop_oneof![4 => line, 2 => cut, 3 => corrupt, 1 => reversed, 1 => endless, 1 => vec(any::<u8>(), 0..60)]
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(testkit::so_many(150, 5000)) })]

    #[test]
    fn hurt_lines_cost_themselves_alone(first in any::<u8>(), pieces in vec(piece(), 0..12)) {
        let mut data = vec![first];
        data.extend(pieces.concat());
        bodies::lines(&data);
    }
}
