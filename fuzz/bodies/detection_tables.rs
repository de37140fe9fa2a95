//! What must hold for any bytes that claim to be a table of detections, in CSV or Parquet. The fuzz target calls this with bytes
//! of its own making, and `make test` with the committed seeds.

use research::{Carriers, ReadDetections, Study, is_detections, read_detections, read_parquet};

/// A table is read or refused in words, with the line and the column of what is wrong.
pub(crate) fn table(data: &[u8]) {
    if let Err(why) = is_detections(data) {
        assert!(!why.to_string().is_empty());
    }
    let study = Study::default();
    let carriers = Carriers { system: Some(0x2810), address: &|_| Ok(0x2810), study: &study };
    let mut rows = 0;
    let mut take = |one: detections::Detection| {
        assert!(!one.id().is_empty());
        rows += 1;
        Ok(())
    };
    if data.starts_with(b"PAR1") {
        let read = read_parquet(bytes::Bytes::copy_from_slice(data), &carriers, &mut take);
        read.map_or_else(|error| assert!(!error.to_string().is_empty()), |read| told(&read, rows));
    } else {
        told(&read_detections(data, &carriers, &mut take).expect("memory can be read"), rows);
    }
}

fn told(read: &ReadDetections, rows: u64) {
    assert_eq!(read.rows, rows);
    // By rows, what is wrong with the file itself has none.
    assert!(read.wrong.iter().all(|one| (one.line > 0 || read.has_rows) && !one.text.to_string().is_empty()));
}
