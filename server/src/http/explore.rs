//! Detections counted, for plots.

use crate::AppState;
use crate::web::{ApiError, QueryParams, Who, extract};
use api::{DetectionsFileQuery, DetectionsSummary, DetectionsSummaryQuery, ExportSize};
use axum::Json;
use axum::extract::State;
use shore::history::heard::{self, HeardFile};
use shore::history::{explore, export};
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::time::Duration;
use store::{DetectionsWanted, Reader, StoreError, TimeRange};

/// So much of a file is written to learn how long its rows are, bytes.
const SAMPLE_BYTES: usize = 1 << 17;
/// So long may be read to learn how many rows it has.
const PATIENCE: Duration = Duration::from_secs(10);

/// `GET /api/v1/detections/summary`.
pub(crate) async fn summary(
    State(state): State<AppState>,
    Who(who): Who,
    QueryParams(query): QueryParams<DetectionsSummaryQuery>,
) -> Result<Json<DetectionsSummary>, ApiError> {
    extract::range(query.from_us.unwrap_or(0), query.to_us.unwrap_or(extract::LAST_US))?;
    let vessels = export::list(query.vessel.as_deref());
    let may = move |vessel: u16| who.grants.on(vessel).is_some();
    if let Some(vessel) = export::addresses(&vessels).find(|vessel| !may(*vessel)) {
        return Err(ApiError::forbidden(format!("vessel: you may not see vessel {vessel}. Ask an admin.")));
    }
    let named = state.shore.people.vessels();
    let (_, study) = state.shore.register.study().await?;
    let explorer = state.shore.history.explorer.clone();
    let ask = move |reader: &mut Reader| {
        let systems = export::systems(reader, &vessels, &named, &may)?;
        explorer.summary(reader, &explore::question(&query, &systems, &study)?, &study)
    };
    Ok(Json(state.shore.history.ask(ask).await?))
}

/// `GET /api/v1/detections/size`.
pub(crate) async fn size(
    State(state): State<AppState>,
    Who(who): Who,
    QueryParams(query): QueryParams<DetectionsFileQuery>,
) -> Result<Json<ExportSize>, ApiError> {
    extract::range(query.from_us.unwrap_or(0), query.to_us.unwrap_or(extract::LAST_US))?;
    let vessels = export::list(query.vessel.as_deref());
    let may = super::export::may(who, &vessels)?;
    let named = state.shore.people.vessels();
    let names: BTreeMap<u16, String> =
        named.iter().map(|vessel| (vessel.address, vessel.name.clone())).collect();
    let (_, study) = state.shore.register.study().await?;
    let file = HeardFile::new(query.format.as_deref(), query.spreadsheet.as_deref())?;
    let asked = DetectionsSummaryQuery {
        from_us: query.from_us,
        to_us: query.to_us,
        vessel: None,
        tag: query.tag,
        project: query.project,
        area: query.area,
    };
    let history = state.shore.history.clone();
    let ask = move |reader: &mut Reader| {
        let systems = export::systems(reader, &vessels, &named, &may)?;
        let question = explore::question(&asked, &systems, &study)?;
        let (range, tags) =
            (TimeRange { from_us: question.from_us, to_us: question.to_us }, question.tags.clone());
        let file = HeardFile { narrowed: question.narrowed.clone(), ..file };
        let wanted = DetectionsWanted { systems: Some(systems), range, came_from: None, tags };
        let mut sample = Sample::default();
        match heard::write(history.data(), &wanted, &names, &study, &file, &mut sample) {
            // All of it fits into the sample.
            Ok(all) => return Ok(ExportSize { rows: all.rows, bytes: all.bytes }),
            Err(error) if sample.bytes < SAMPLE_BYTES => return Err(error),
            Err(_) => {}
        }
        let counted = history.explorer.summary_within(reader, &question, &study, PATIENCE)?;
        if counted.left_out_before_us.is_some() || counted.read_from_us.is_some() {
            let text = "there are more detections than the server counts beforehand; choose a shorter time, or \
                        download without knowing the size";
            return Err(StoreError::Query(text.into()));
        }
        let bytes = counted.detections as f64 * sample.bytes as f64 / sample.lines.max(1) as f64;
        Ok(ExportSize { rows: counted.detections, bytes: bytes as u64 })
    };
    Ok(Json(state.shore.history.ask(ask).await?))
}

/// The begin of a file.
#[derive(Default)]
struct Sample {
    bytes: usize,
    lines: usize,
}

impl Write for Sample {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.bytes >= SAMPLE_BYTES {
            return Err(io::ErrorKind::WriteZero.into());
        }
        self.bytes += bytes.len();
        self.lines += bytes.split(|byte| *byte == b'\n').count() - 1;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
