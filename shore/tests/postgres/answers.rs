//! What the history and the database answer, side by side, and what Grafana asks.

use crate::ashore::exported;
use crate::database::Postgres;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// A line of CSV whose cells hold no line ends.
pub(crate) fn cells(line: &str) -> Vec<String> {
    let (mut cells, mut cell, mut is_quoted) = (Vec::new(), String::new(), false);
    for sign in line.chars() {
        match sign {
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => cells.push(std::mem::take(&mut cell)),
            sign => cell.push(sign),
        }
    }
    cells.push(cell);
    cells
}

/// A value as both write it: a number in one form.
pub(crate) fn value(text: &str) -> String {
    match text.parse::<f64>() {
        Ok(number) if number.is_nan() => "NaN".to_owned(),
        Ok(number) => format!("{:?}", number + 0.0),
        Err(_) => text.strip_prefix("\\x").unwrap_or(text).to_owned(),
    }
}

/// All rows of a message as the history has them and as PostgreSQL has them, by the columns that both have.
pub(crate) fn both(data: &Path, postgres: &Postgres, message: &str) -> [Vec<Vec<String>>; 2] {
    let csv = exported(data, message);
    let mut lines = csv.lines();
    let heading = cells(lines.next().unwrap());
    let names: Vec<String> =
        heading.iter().map(|name| name.split(" [").next().unwrap().to_lowercase()).collect();
    let table = format!("lutra.{message}");
    let columns = postgres.say(&format!(
        "SELECT attname FROM pg_attribute WHERE attrelid = '{table}'::regclass AND attnum > 7 AND attgenerated = ''"
    ));
    let columns: Vec<&str> =
        columns.lines().filter(|column| names.iter().any(|name| name == column)).collect();
    let quoted = columns.iter().map(|column| format!("\"{column}\""));
    let selected: Vec<String> = ["extract(epoch FROM time)::numeric(30,6), src_ent, dst".to_owned()]
        .into_iter()
        .chain(quoted)
        .collect();
    let selected = selected.join(", ");
    let at = |name: &str| names.iter().position(|one| one == name).unwrap();
    let mut mine: Vec<Vec<String>> = lines
        .map(|line| {
            let cells = cells(line);
            let dst = u16::from_str_radix(cells[at("dst")].trim_start_matches("0x"), 16).unwrap().to_string();
            let first = [cells[at("unix_s")].clone(), cells[at("entity_id")].clone(), dst];
            let own = columns.iter().map(|column| cells[at(column)].clone());
            first.into_iter().chain(own).map(|cell| value(&cell)).collect()
        })
        .collect();
    let answer = postgres.say(&format!("SELECT {selected} FROM {table}"));
    let mut theirs: Vec<Vec<String>> =
        answer.lines().map(|line| cells(line).iter().map(|cell| value(cell)).collect()).collect();
    mine.sort();
    theirs.sort();
    [mine, theirs]
}

/// A role that may read what is there and what will be, as docs/postgresql.md has it.
pub(crate) fn reads_for_grafana(postgres: &Postgres) {
    postgres.admin("CREATE ROLE grafana LOGIN PASSWORD 'reads'");
    postgres.say(
        "GRANT USAGE ON SCHEMA lutra TO grafana; GRANT SELECT ON ALL TABLES IN SCHEMA lutra TO grafana; \
         ALTER DEFAULT PRIVILEGES IN SCHEMA lutra GRANT SELECT ON TABLES TO grafana",
    );
}

/// The statements of Grafana's dashboard, its macros written out: title and SQL.
pub(crate) fn dashboard() -> Vec<(String, String)> {
    let file = testkit::repository().join("docker/grafana/dashboards/postgres.json");
    let dashboard: Value = serde_json::from_str(&fs::read_to_string(file).unwrap()).unwrap();
    let vessels = &dashboard["templating"]["list"][0];
    let panels = dashboard["panels"].as_array().unwrap().iter();
    let panels = panels.map(|panel| (panel["title"].clone(), panel["targets"][0]["rawSql"].clone()));
    let all = panels.chain([(vessels["label"].clone(), vessels["query"].clone())]);
    let written_out = |(title, sql): (Value, Value)| {
        let mut sql = sql.as_str().unwrap().to_owned();
        for (macro_, meaning) in [
            ("$__timeFilter(time)", "time BETWEEN '2000-01-01' AND '2100-01-01'"),
            ("$__timeGroup(time, '1h')", "to_timestamp(floor(extract(epoch FROM time) / 3600) * 3600)"),
            ("$__timeGroup(time, '10s')", "to_timestamp(floor(extract(epoch FROM time) / 10) * 10)"),
            ("$__timeGroup(time, $__interval)", "to_timestamp(floor(extract(epoch FROM time) / 60) * 60)"),
            ("IN ($vessel)", "IN (SELECT src FROM lutra.vessels)"),
        ] {
            sql = sql.replace(macro_, meaning);
        }
        assert!(!sql.contains('$'), "a macro that is not known here: {sql}");
        (title.as_str().unwrap().to_owned(), sql)
    };
    let all: Vec<_> = all.map(written_out).collect();
    assert!(all.len() > 5);
    all
}
