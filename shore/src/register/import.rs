//! The changes of a file of entries.

use super::rows::{Row, Step, told_to};
use api::{
    RegisterFieldChange, RegisterImport, RegisterImportChange, RegisterKind, RegisterProblem, RegisterRecord,
    Said,
};
use research::{Names, Read, blank, check_all, differences, kind_of, name_of, read_csv};

/// Most problems that are reported.
const PROBLEMS: usize = 1_000;

/// The changes of a file, with their steps. `may` checks whether the user may make an entry. Entries that the user may not
/// see are neither changed nor revealed.
pub(super) fn look(
    kind: RegisterKind,
    bytes: &[u8],
    (version, rows): (i64, &[Row]),
    names: &Names<'_>,
    may: &dyn Fn(&RegisterRecord) -> Option<Said>,
    sees: &dyn Fn(&RegisterRecord) -> bool,
) -> (RegisterImport, Vec<Step>) {
    let known: Vec<&Row> =
        rows.iter().filter(|row| kind_of(&row.record) == kind && sees(&row.record)).collect();
    let records: Vec<&RegisterRecord> = known.iter().map(|row| &row.record).collect();
    let read = read_csv(kind, bytes, &records, names);
    let mut answer = RegisterImport {
        applied: false,
        version,
        added: 0,
        changed: 0,
        same: 0,
        problems: read
            .wrong
            .iter()
            .map(|wrong| problem(Some(wrong.line), &wrong.column, wrong.text.clone()))
            .collect(),
        changes: Vec::new(),
    };
    let mut steps = Vec::new();
    for row in &read.rows {
        let before = row.known.and_then(|at| known.get(at));
        let fields =
            differences(&before.map_or_else(|| blank(kind), |row| row.record.clone()), &row.record, names);
        match before {
            Some(_) if fields.is_empty() => {
                answer.same += 1;
                continue;
            }
            Some(before) => {
                answer.changed += 1;
                steps.push(Step::Change(before.id, before.revision, row.record.clone()));
            }
            None => {
                answer.added += 1;
                steps.push(Step::Add(row.record.clone()));
            }
        }
        let refused = may(&row.record).or_else(|| before.and_then(|before| may(&before.record)));
        if let Some(text) = refused {
            answer.problems.push(problem(Some(row.line), "", text));
        }
        let fields = fields.into_iter().map(|field| RegisterFieldChange {
            column: field.column.to_owned(),
            before: field.before,
            after: field.after,
        });
        let name = name_of(&row.record).to_owned();
        answer.changes.push(RegisterImportChange {
            line: row.line,
            name,
            is_new: before.is_none(),
            fields: fields.collect(),
        });
    }
    answer.problems.extend(together(&read, rows, &known, sees));
    answer.problems.sort_by_key(|problem| problem.line.unwrap_or(u32::MAX));
    answer.problems.truncate(PROBLEMS);
    (answer, steps)
}

fn problem(line: Option<u32>, column: &str, text: impl Into<Said>) -> RegisterProblem {
    let (text, says) = text.into().into_parts();
    RegisterProblem { line, column: column.to_owned(), text, says }
}

/// Problems of the resulting register, at the lines that cause them.
fn together(
    read: &Read,
    rows: &[Row],
    known: &[&Row],
    sees: &dyn Fn(&RegisterRecord) -> bool,
) -> Vec<RegisterProblem> {
    let mut lines: Vec<Option<u32>> = vec![None; rows.len()];
    let mut records: Vec<RegisterRecord> = rows.iter().map(|row| row.record.clone()).collect();
    for row in &read.rows {
        let of_known = row.known.and_then(|at| known.get(at)).map(|row| row.id);
        if let Some(at) = of_known.and_then(|id| rows.iter().position(|row| row.id == id)) {
            (records[at], lines[at]) = (row.record.clone(), Some(row.line));
        } else {
            records.push(row.record.clone());
            lines.push(Some(row.line));
        }
    }
    // Entries of the file itself may be reported, even for a vessel that the user may not see.
    let is_hidden = |at: usize| lines[at].is_none() && !sees(&records[at]);
    let faults = check_all(&records).into_iter();
    let told = faults.filter_map(|fault| {
        let line = lines.get(fault.entry).copied().flatten();
        let text = told_to(&is_hidden, &records, &fault, line.is_none())?;
        Some(problem(line, fault.column, text))
    });
    told.collect()
}
