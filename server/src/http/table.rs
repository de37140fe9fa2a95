//! Rows for Grafana, notebooks and spreadsheets: series, detections, and lists to choose from, as JSON or CSV.

use crate::AppState;
use crate::web::{ApiError, QueryParams, Who, extract};
use api::{Next, TableChoice, TableDetections, TableDetectionsQuery, TableQuery, TableSeriesQuery, say};
use axum::Json;
use axum::extract::State;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::{IntoResponse as _, Response};
use serde::Serialize;
use shore::history::export;
use shore::history::table::{self, CsvRow, SeriesName};
use shore::identity::Principal;
use store::{DetectionsWanted, Reader};
use tokio_util::sync::CancellationToken;
use units::UtcTime;

const CSV: &str = "text/csv; charset=utf-8";

/// `GET /api/v1/table`.
pub(crate) async fn rows(
    State(state): State<AppState>,
    Who(who): Who,
    headers: HeaderMap,
    QueryParams(query): QueryParams<TableQuery>,
) -> Result<Response, ApiError> {
    let form = Form::asked(query.format.as_deref(), &headers)?;
    let names = table::several("series", &query.series)?;
    if names.is_empty() {
        return Err(ApiError::bad_request(say(
            "series: name one, such as Voltage.2.value; /api/v1/table/series lists them",
        )));
    }
    let asked = table::Asked {
        series: names.iter().map(|name| SeriesName::new(name)).collect::<Result<_, _>>()?,
        range: table::range(&query.from, &query.to)?,
        points: extract::number("points", query.points, 1_000, 1..=10_000)?,
        degrees: degrees(query.angles.as_deref())?,
    };
    let vessels = Vessels::asked(&state, who, &query.vessel)?;
    // A dashboard that asks anew gives up what it asked before.
    let given_up = CancellationToken::new();
    let _here = given_up.clone().drop_guard();
    let read = move |reader: &mut Reader| {
        let systems = vessels.systems(reader)?;
        asked.rows(reader, &systems, &vessels.named, &given_up)
    };
    Ok(form.answer(&state.shore.history.ask(read).await?))
}

/// `GET /api/v1/table/vessels`.
pub(crate) async fn vessels(
    State(state): State<AppState>,
    Who(who): Who,
) -> Result<Json<Vec<TableChoice>>, ApiError> {
    let named = state.shore.people.vessels();
    let may = move |vessel: u16| who.grants.on(vessel).is_some();
    Ok(Json(state.shore.history.ask(move |reader| table::vessels(reader, &named, &may)).await?))
}

/// `GET /api/v1/table/series`.
pub(crate) async fn series(
    State(state): State<AppState>,
    Who(who): Who,
    QueryParams(query): QueryParams<TableSeriesQuery>,
) -> Result<Json<Vec<TableChoice>>, ApiError> {
    let vessels = Vessels::asked(&state, who, &query.vessel)?;
    let given_up = CancellationToken::new();
    let _here = given_up.clone().drop_guard();
    let read = move |reader: &mut Reader| {
        let systems = vessels.systems(reader)?;
        table::choices(reader, &systems, &given_up)
    };
    Ok(Json(state.shore.history.ask(read).await?))
}

/// `GET /api/v1/table/detections`.
pub(crate) async fn detections(
    State(state): State<AppState>,
    Who(who): Who,
    headers: HeaderMap,
    QueryParams(query): QueryParams<TableDetectionsQuery>,
) -> Result<Response, ApiError> {
    let form = Form::asked(query.format.as_deref(), &headers)?;
    let range = table::range(&query.from, &query.to)?;
    let tags = export::tags(query.tag.as_deref())?;
    let page = extract::page(query.limit.or(Some(10_000)), query.skip)?;
    let order = extract::order(query.order.as_deref())?;
    let vessels = Vessels::asked(&state, who, &query.vessel)?;
    let given_up = CancellationToken::new();
    let _here = given_up.clone().drop_guard();
    let read = move |reader: &mut Reader| {
        let systems = Some(vessels.systems(reader)?);
        let wanted = DetectionsWanted { systems, range, came_from: None, tags };
        table::detections(reader, &wanted, (order, page), &given_up, &vessels.named)
    };
    let (rows, next) = state.shore.history.ask(read).await?;
    let next = next.map(|next| rest(&query, next));
    // By RFC 8288; CSV has no other place for it.
    let link = next.as_ref().and_then(|next| HeaderValue::from_str(&format!("<{next}>; rel=\"next\"")).ok());
    let mut response = match form {
        Form::Csv => form.answer(&rows),
        Form::Json => varied(Json(TableDetections { rows, next }).into_response()),
    };
    if let Some(link) = link {
        response.headers_mut().insert(header::LINK, link);
    }
    Ok(response)
}

/// The address of the rows that did not fit.
fn rest(query: &TableDetectionsQuery, next: Next) -> String {
    let mut address = form_urlencoded::Serializer::new(String::new());
    for (name, time_us) in [("from", next.from_us), ("to", next.to_us)] {
        address.append_pair(name, &UtcTime::from_micros(time_us).to_string());
    }
    for vessel in &query.vessel {
        address.append_pair("vessel", vessel);
    }
    for (name, text) in [("tag", &query.tag), ("order", &query.order), ("format", &query.format)] {
        if let Some(text) = text {
            address.append_pair(name, text);
        }
    }
    if let Some(limit) = query.limit {
        address.append_pair("limit", &limit.to_string());
    }
    address.append_pair("skip", &next.skip.to_string());
    format!("/api/v1/table/detections?{}", address.finish())
}

/// Whether angles are asked for in degrees.
fn degrees(angles: Option<&str>) -> Result<bool, ApiError> {
    match angles.unwrap_or_default() {
        "" | "rad" => Ok(false),
        "deg" => Ok(true),
        _ => Err(ApiError::bad_request(say("angles: give `rad` or `deg`"))),
    }
}

/// The vessels that were asked for, and those that the person may see.
struct Vessels {
    asked: Vec<String>,
    named: std::sync::Arc<[api::Vessel]>,
    who: Principal,
}

impl Vessels {
    /// # Errors
    /// One is named by an address that the person may not see.
    fn asked(state: &AppState, who: Principal, texts: &[String]) -> Result<Self, ApiError> {
        let asked = table::several("vessel", texts)?;
        let hidden = export::addresses(&asked).find(|vessel| who.grants.on(*vessel).is_none());
        if let Some(vessel) = hidden {
            return Err(ApiError::forbidden(
                say("vessel: you may not see vessel {vessel}. Ask an admin.").with("vessel", vessel),
            ));
        }
        Ok(Self { asked, named: state.shore.people.vessels(), who })
    }

    /// # Errors
    /// There is no such vessel among those that the person may see, or the history cannot be read.
    fn systems(&self, reader: &mut Reader) -> store::Result<Vec<imc::Address>> {
        export::systems(reader, &self.asked, &self.named, &|vessel| self.who.grants.on(vessel).is_some())
    }
}

/// The form of an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    Json,
    Csv,
}

impl Form {
    /// By `format`, else by `Accept`.
    ///
    /// # Errors
    /// There is no such format.
    fn asked(format: Option<&str>, headers: &HeaderMap) -> Result<Self, ApiError> {
        match format.unwrap_or_default() {
            "json" => Ok(Self::Json),
            "csv" => Ok(Self::Csv),
            "" => Ok(Self::accepted(headers)),
            _ => Err(ApiError::bad_request(say("format: give `json` or `csv`"))),
        }
    }

    /// CSV where the client prefers it (RFC 9110, 12.5.1).
    fn accepted(headers: &HeaderMap) -> Self {
        let all = headers.get_all(header::ACCEPT).iter().filter_map(|value| value.to_str().ok());
        let (mut csv, mut json) = (0.0_f64, 0.0_f64);
        for one in all.flat_map(|value| value.split(',')) {
            let mut parts = one.split(';').map(str::trim);
            let media = parts.next().unwrap_or_default().to_ascii_lowercase();
            let weight = parts.find_map(|part| part.strip_prefix("q=")).map_or(Ok(1.0), str::parse);
            let weight = weight.unwrap_or(0.0);
            match media.as_str() {
                "text/csv" => csv = csv.max(weight),
                "application/json" | "application/*" | "*/*" => json = json.max(weight),
                _ => {}
            }
        }
        if csv > 0.0 && csv >= json { Self::Csv } else { Self::Json }
    }

    fn answer<R: CsvRow + Serialize>(self, rows: &[R]) -> Response {
        varied(match self {
            Self::Json => Json(rows).into_response(),
            Self::Csv => ([(header::CONTENT_TYPE, CSV)], table::csv(rows)).into_response(),
        })
    }
}

/// Notes that the form depends on `Accept`.
fn varied(mut response: Response) -> Response {
    response.headers_mut().append(header::VARY, HeaderValue::from_static("accept"));
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn csv_is_given_where_it_is_preferred() {
        let form = |accept: &'static str| {
            let headers = [(header::ACCEPT, HeaderValue::from_static(accept))].into_iter().collect();
            Form::asked(None, &headers).unwrap()
        };
        for accept in ["text/csv", "text/csv, */*;q=0.1", "application/json;q=0.5, Text/CSV", "text/csv,*/*"]
        {
            assert_eq!(form(accept), Form::Csv, "{accept}");
        }
        for accept in ["", "*/*", "application/json, text/csv;q=0.9", "text/csv;q=0", "text/html"] {
            assert_eq!(form(accept), Form::Json, "{accept}");
        }
        let headers = HeaderMap::new();
        assert_eq!(Form::asked(Some("csv"), &headers).unwrap(), Form::Csv);
        assert!(Form::asked(Some("xlsx"), &headers).is_err());
    }
}
