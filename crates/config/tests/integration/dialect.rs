//! The dialect as DUNE reads it: the given cases, and every trap with what the report says about it.

use std::path::Path;

use config::{Config, Counts, Disk, InMemory, Ini, Problem, ProblemKind, Report, Severity};
use serde_json::Value as Json;

fn read(text: &str) -> (Ini, Report) {
    Ini::read(&InMemory::new().with("a.ini", text), Path::new("a.ini"))
}

fn only(report: &Report) -> &Problem {
    assert_eq!(report.problems().len(), 1, "{report}");
    &report.problems()[0]
}

#[track_caller]
fn complains(text: &str, severity: Severity, kind: ProblemKind, line: u32) -> Ini {
    let (ini, report) = read(text);
    let problem = only(&report);
    let place = problem.place.as_ref().map(|place| place.line);
    assert_eq!((problem.severity, problem.kind, place), (severity, kind, Some(line)), "{problem}");
    assert!(!problem.remedy.is_empty(), "{problem}");
    ini
}

#[test]
fn the_given_cases_read_as_expected() {
    let Some(folder) = testkit::shared("data/onboard/ini_cases") else { return };
    let expected: Json =
        serde_json::from_str(&std::fs::read_to_string(folder.join("expected.json")).unwrap()).unwrap();
    let config = Config::load(&Disk, &folder.join("main.ini"), &["Simulation"]);
    for (section, settings) in expected.as_object().unwrap() {
        if section == "enabled" {
            continue;
        }
        for (key, value) in settings.as_object().unwrap() {
            if let Some(key) = key.strip_suffix("_as_list") {
                let items = config::split_list(config.ini().value(section, key).unwrap());
                assert_eq!(Json::from(items), *value, "[{section}] {key}");
            } else {
                assert_eq!(config.ini().value(section, key), value.as_str(), "[{section}] {key}");
            }
        }
    }
    for (section, profiles) in expected["enabled"].as_object().unwrap() {
        for (profile, runs) in profiles.as_object().unwrap() {
            let enabled = config.section(section).unwrap().enabled();
            assert_eq!(Some(enabled.in_profile(profile)), runs.as_bool(), "[{section}] in {profile}");
        }
    }
    // Nothing else is there, apart from what base.ini alone says.
    let names: Vec<&str> = config.ini().sections().map(|(name, _)| name).collect();
    let wanted: Vec<&str> =
        expected.as_object().unwrap().keys().map(String::as_str).filter(|name| *name != "enabled").collect();
    assert_eq!(names.len(), wanted.len(), "{names:?}");
    assert!(names.iter().all(|name| wanted.contains(name)), "{names:?}");
}

#[test]
fn a_value_knows_its_line_and_what_it_overrides() {
    let files = InMemory::new()
        .with("v/main.ini", "[Require ../common/base.ini]\n[General]\nVehicle = b\n")
        .with("common/base.ini", "[General]\n\nVehicle = a,\n  more\n");
    let (ini, report) = Ini::read(&files, Path::new("v/main.ini"));
    assert_eq!(report.counts(), Counts::default());
    let setting = ini.setting("General", "Vehicle").unwrap();
    assert_eq!(setting.place().unwrap().to_string(), "v/main.ini:3");
    let history: Vec<_> = setting.history().iter().map(|c| (c.place.to_string(), c.last_line)).collect();
    assert_eq!(history, [("common/base.ini:3".to_owned(), 4), ("v/main.ini:3".to_owned(), 3)]);
    assert_eq!(setting.history()[0].text, "a, more");
}

#[test]
fn text_before_the_first_section_is_an_error() {
    complains("a = 1\n[S]\nb = 2", Severity::Error, ProblemKind::Syntax, 1);
}

#[test]
fn a_keyword_in_other_case_loads_nothing() {
    for line in ["[require b.ini]", "[INCLUDE b.ini]", "[Require]", "[ Require b.ini]", "[Requre b.ini]"] {
        complains(line, Severity::Error, ProblemKind::MisspeltKeyword, 1);
    }
}

#[test]
fn options_behind_a_require_land_in_a_section_of_that_name() {
    let files = InMemory::new().with("a.ini", "[Require b.ini]\nx = 1\ny = 2").with("b.ini", "[S]");
    let (ini, report) = Ini::read(&files, Path::new("a.ini"));
    assert_eq!(only(&report).kind, ProblemKind::StraySection);
    assert_eq!(ini.value("Require b.ini", "y"), Some("2"));
}

#[test]
fn a_missing_file_is_an_error_when_required_and_a_warning_when_included() {
    complains("[Require b.ini]", Severity::Error, ProblemKind::FileMissing, 1);
    complains("[Include b.ini]", Severity::Warning, ProblemKind::FileMissing, 1);
}

#[test]
fn files_that_require_each_other_are_caught() {
    let files = InMemory::new()
        .with("a.ini", "[Require x/b.ini]\n[S]\na = 1")
        .with("x/b.ini", "[S]\nb = 1\n[Include ../a.ini]");
    let (ini, report) = Ini::read(&files, Path::new("a.ini"));
    let problem = only(&report);
    assert_eq!(problem.kind, ProblemKind::IncludeCycle);
    assert_eq!(problem.place.as_ref().unwrap().to_string(), "x/b.ini:3");
    assert!(problem.what.contains("a.ini -> x/b.ini -> a.ini"), "{problem}");
    assert_eq!((ini.value("S", "a"), ini.value("S", "b")), (Some("1"), Some("1")));
}

#[test]
fn a_comment_character_cuts_a_value_and_is_reported_when_doubtful() {
    let ini = complains("[S]\nLevel = Spew#None", Severity::Warning, ProblemKind::ValueCut, 2);
    assert_eq!(ini.value("S", "Level"), Some("Spew"));
    let ini = complains("[S]\nL = a,\n b|c", Severity::Warning, ProblemKind::ValueCut, 3);
    assert_eq!(ini.value("S", "L"), Some("a, b"));
}

#[test]
fn a_comment_character_in_a_name_is_an_error() {
    let ini = complains("[S]\nL = Daemon,\nGPS # a = b", Severity::Error, ProblemKind::CommentInName, 3);
    assert_eq!(ini.value("S", "GPS # a"), Some("b"));
}

#[test]
fn lists_are_appended_to_and_taken_from() {
    let (ini, report) = read("[S]\nL = a, b,\n c\n\nL+ = d\nL- = a, d\nN = x\nN- = x");
    assert_eq!(report.counts(), Counts::default(), "{report}");
    let items = |key| config::split_list(ini.value("S", key).unwrap());
    assert_eq!(items("L"), ["b", "c"]);
    assert_eq!(ini.setting("S", "L").unwrap().history().len(), 3);
    assert_eq!(ini.value("S", "N"), Some(""));
}

#[test]
fn list_edits_that_surprise_are_reported() {
    complains("[S]\nL+ = a", Severity::Warning, ProblemKind::ListEdit, 2);
    complains("[S]\nL = a\nL- = b", Severity::Error, ProblemKind::ListEdit, 3);
    complains("[S]\nL = Alphabet, b\nL- = Alpha", Severity::Error, ProblemKind::ListEdit, 3);
    let ini = complains("[S]\nL = a, b\nL- = a,\n b", Severity::Error, ProblemKind::ListEdit, 4);
    assert_eq!(ini.value("S", "L"), Some("b b"), "as in DUNE, the continuation is added");
}

#[test]
fn references_take_the_value_at_this_point() {
    let (ini, report) = read("[A]\nx = 1\ny = $(A, x)\nx = 2\n[B]\nz = $(A, y)");
    assert_eq!(report.counts().errors, 0);
    assert_eq!((ini.value("A", "y"), ini.value("B", "z")), (Some("1"), Some("1")));
    for text in ["[A]\ny = $(A, later)", "[A]\ny = $(A)", "[A]\ny = $(A, x"] {
        complains(text, Severity::Error, ProblemKind::Reference, 2);
    }
    complains("[A]\nx = 1\ny = $(A, x) more", Severity::Warning, ProblemKind::Reference, 3);
}

#[test]
fn attributes_belong_to_the_option_they_stand_behind() {
    let (ini, report) = read("[S]\nGain {scope:plan, visibility:user} = 3\nOther {editable:false}");
    assert_eq!(report.counts(), Counts::default(), "{report}");
    assert_eq!(ini.value("S", "Gain"), Some("3"));
    assert_eq!(ini.setting("S", "Gain").unwrap().attributes()["visibility"], "user");
    assert_eq!(ini.setting("S", "Other").unwrap().attributes()["editable"], "false");
    complains("[S]\nGain {scope:ever} = 3", Severity::Warning, ProblemKind::Attribute, 2);
    complains("[S]\nGain {scop} = 3", Severity::Error, ProblemKind::Attribute, 2);
}

#[test]
fn a_long_line_is_read_as_two() {
    let text = format!("[S]\na = {}, b", "x".repeat(1019));
    let ini = complains(&text, Severity::Error, ProblemKind::LongLine, 2);
    assert!(ini.value("S", "a").unwrap().ends_with("x , b"));
}

#[test]
fn other_broken_lines_are_reported_where_they_are() {
    for (text, line) in [
        ("[S", 1),
        ("[]", 1),
        ("[ S]", 1),
        ("[S]\n= 1", 2),
        ("[S]\ntext without a meaning", 2),
        ("[S]\na = 1\n| text", 3),
    ] {
        complains(text, Severity::Error, ProblemKind::Syntax, line);
    }
    complains("[S] rest", Severity::Warning, ProblemKind::Syntax, 1);
    complains("[S]\na = 1\na = 2", Severity::Warning, ProblemKind::Repeated, 3);
    complains("[S]\na = 1,\nb = 2", Severity::Warning, ProblemKind::EmptyItem, 3);
}

#[test]
fn bytes_that_are_no_text_are_reported() {
    for bytes in [&b"[S]\na = \xff"[..], b"[S]\na = 1\0 2", b"\xef\xbb\xbf[S]"] {
        let (_, report) = Ini::read(&InMemory::new().with("a.ini", bytes), Path::new("a.ini"));
        assert_eq!(only(&report).kind, ProblemKind::NotText, "{bytes:?}");
    }
    let comment = InMemory::new().with("a.ini", &b"# Lauv\xe5s\n[S]"[..]);
    assert_eq!(Ini::read(&comment, Path::new("a.ini")).1.counts(), Counts::default());
}
