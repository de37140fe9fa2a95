//! Whatever the files hold, reading ends, does not panic and stays small.

use std::fmt::Write as _;
use std::path::Path;

use config::{
    Config, InMemory, Ini, MAX_FILES, MAX_PROBLEMS_OF_A_KIND, MAX_VALUE_BYTES, ProblemKind, Report,
};
use proptest::prelude::*;

fn read(text: impl Into<Vec<u8>>) -> (Ini, Report) {
    Ini::read(&InMemory::new().with("a.ini", text), Path::new("a.ini"))
}

fn has(report: &Report, kind: ProblemKind) -> bool {
    report.problems().iter().any(|problem| problem.kind == kind)
}

/// All bytes that the settings keep.
fn kept_bytes(ini: &Ini) -> usize {
    let settings = ini.sections().flat_map(|(_, section)| section.settings());
    settings
        .map(|(key, setting)| {
            let history: usize = setting.history().iter().map(|change| change.text.len()).sum();
            key.len() + setting.value().len() + history
        })
        .sum()
}

#[test]
fn references_cannot_multiply_a_long_value() {
    let mut text = String::from("[S]\na = x\n");
    for _ in 0..60 {
        let _ = writeln!(text, "{}", "y".repeat(1000));
    }
    for number in 0..40_000 {
        let _ = writeln!(text, "k{number} = $(S, a)");
    }
    let (ini, report) = read(text);
    assert!(has(&report, ProblemKind::Limit));
    assert!(kept_bytes(&ini) < 8 << 20, "{}", kept_bytes(&ini));
}

#[test]
fn a_value_cannot_grow_without_end() {
    for line in ["a+ = 0123456789\n", "0123456789\n"] {
        let (ini, report) = read(format!("[S]\na = 1\n{}", line.repeat(20_000)));
        assert!(has(&report, ProblemKind::Limit), "{line}");
        assert!(ini.value("S", "a").unwrap().len() <= MAX_VALUE_BYTES, "{line}");
        assert!(report.problems().len() <= 2 * MAX_PROBLEMS_OF_A_KIND, "{line}");
    }
}

#[test]
fn files_that_require_others_twice_each_are_stopped() {
    let mut files = InMemory::new();
    for level in 0..15 {
        let next = format!("[Require {0}.ini]\n[Require {0}.ini]\n", level + 1);
        files = files.with(format!("{level}.ini"), next);
    }
    files = files.with("15.ini", "[S]\na = 1\n");
    let config = Config::load(&files, Path::new("0.ini"), &["Simulation"]);
    assert!(has(config.report(), ProblemKind::Limit));
    assert!(config.files().len() <= MAX_FILES);
}

#[test]
fn deep_nesting_and_many_lines_are_stopped() {
    let mut files = InMemory::new();
    for level in 0..40 {
        files = files.with(format!("{level}.ini"), format!("[Require {}.ini]", level + 1));
    }
    assert!(has(&Ini::read(&files, Path::new("0.ini")).1, ProblemKind::Limit));
    let (_, report) = read(format!("[S]\n{}", "a = 1\n".repeat(60_000)));
    assert!(has(&report, ProblemKind::Limit));
}

#[test]
fn removing_many_items_from_a_long_list_ends_soon() {
    let mut text = String::from("[S]\na = x\n");
    text.push_str(&"zzzzzzzzz,\n".repeat(5_000));
    text.push_str(&format!("a- = {}\n", "q,".repeat(450)).repeat(500));
    assert!(has(&read(text).1, ProblemKind::Limit));
}

/// Lines that look enough like configuration to reach every branch.
fn line() -> impl Strategy<Value = String> {
    let word = prop_oneof![
        Just("Enabled".to_owned()),
        Just("Entity Label".to_owned()),
        Just("Vehicle".to_owned()),
        Just("Control.Path.ILOS".to_owned()),
        Just("General".to_owned()),
        Just("IMC Addresses".to_owned()),
        Just("ILOS Lookahead Distance".to_owned()),
        Just("Initialization String 3 - Command".to_owned()),
        "[ -~é\\\\]{0,12}",
    ];
    let value = prop_oneof!["[ -~]{0,20}", Just("Always".to_owned()), "-?0?x?[0-9]{0,22}\\.?[0-9]{0,3}"];
    prop_oneof![
        word.clone().prop_map(|name| format!("[{name}]")),
        ("(Require|Include|require)", "[abc]\\.ini").prop_map(|(word, file)| format!("[{word} {file}]")),
        (word.clone(), "[+-]? ?", value.clone())
            .prop_map(|(name, sign, value)| format!("{name}{sign}= {value}")),
        (word.clone(), word.clone(), word.clone()).prop_map(|(a, b, c)| format!("{a} = $({b}, {c})")),
        (word, "[a-z:,]{0,12}", value.clone())
            .prop_map(|(name, inner, value)| format!("{name} {{{inner}}} = {value}")),
        value,
    ]
}

fn file() -> impl Strategy<Value = String> {
    prop::collection::vec(line(), 0..30).prop_map(|lines| lines.join("\n"))
}

/// A key that can be written; a value that can.
fn setting() -> impl Strategy<Value = (String, String)> {
    ("[A-Za-z][A-Za-z0-9 .-]{0,18}[a-z0-9]", "[A-Za-z0-9=:$(){}.,\\[\\]'\"\\\\]([ -:<-z]{0,40}[a-z0-9,])?")
}

proptest! {
    #[test]
    fn any_bytes_are_read_without_panic(
        first in prop::collection::vec(any::<u8>(), 0..2000),
        second in prop::collection::vec(any::<u8>(), 0..200),
    ) {
        let files = InMemory::new().with("a.ini", first).with("b.ini", second);
        let config = Config::load(&files, Path::new("a.ini"), &["Simulation"]);
        let _ = config.to_string();
        let _ = config.to_json();
    }

    #[test]
    fn any_lines_are_read_without_panic(a in file(), b in file(), c in file(), profile in "[A-Za-z/]{0,12}") {
        let length = a.len() + b.len() + c.len();
        let files = InMemory::new().with("a.ini", a).with("b.ini", b).with("c.ini", c);
        let config = Config::load(&files, Path::new("a.ini"), &["Simulation", &profile]);
        prop_assert!(kept_bytes(config.ini()) <= 64 * (length + 100) * 8);
        let _ = config.to_string();
        let _ = config.to_json();
    }

    #[test]
    fn what_is_written_reads_back_the_same(
        sections in prop::collection::btree_map(
            "[A-Z][A-Za-z./]{0,20}",
            prop::collection::btree_map(setting().prop_map(|(key, _)| key), setting().prop_map(|(_, value)| value), 0..6),
            0..6,
        ),
    ) {
        let mut text = String::new();
        for (section, settings) in &sections {
            let _ = writeln!(text, "[{section}]");
            for (key, value) in settings {
                let _ = writeln!(text, "{key} = {value}");
            }
        }
        let (ini, _) = read(text);
        if let Ok(written) = ini.to_text() {
            let (again, _) = read(written.clone());
            let values = |ini: &Ini| -> Vec<(String, String, String)> {
                ini.sections()
                    .flat_map(|(name, section)| {
                        section.settings().map(|(k, s)| (name.to_owned(), k.to_owned(), s.value().to_owned()))
                    })
                    .collect()
            };
            prop_assert_eq!(values(&ini), values(&again), "{}", written);
        }
    }

    #[test]
    fn numbers_are_written_as_they_are_read(number in any::<f64>().prop_filter("finite", |n| n.is_finite()), whole in -i64::MAX..) {
        prop_assert_eq!(config::parse_float(&number.to_string()).unwrap().to_bits(), number.to_bits());
        prop_assert_eq!(config::parse_int(&whole.to_string()).unwrap().value, whole);
    }
}
