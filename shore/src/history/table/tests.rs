//! What people may write for times and series.

use super::*;

#[test]
fn a_time_is_milliseconds_or_iso_8601() {
    let us = |from: &str, to: &str| range(from, to).map(|range| (range.from_us, range.to_us)).unwrap();
    assert_eq!(us("1795248000000", "1795248000001"), (1_795_248_000_000_000, 1_795_248_000_001_000));
    let iso = us("2026-11-21T08:00:00.000Z", " 2026-11-21T09:00+01:00 ");
    assert_eq!(iso, (1_795_248_000_000_000, 1_795_248_000_000_000));
    for (from, to, said) in [
        ("", "1", "from: `` is not a time"),
        ("now-6h", "1", "from: `now-6h` is not a time"),
        ("1795248000000", "-5", "to: `-5` is not a time"),
        ("1795248000", "1795251600", "from: `1795248000` is not a time"),
        ("0", "2026", "to: `2026` is not a time"),
        ("99999999999999999999", "1", "from: `99999999999999999999` is not a time"),
        ("9223372036854775807", "1", "from: `9223372036854775807` is not a time"),
        ("1795248000001", "1795248000000", "to: is before `from`"),
    ] {
        let error = range(from, to).unwrap_err().to_string();
        assert!(error.contains(said), "{from} {to}: {error}");
    }
}

#[test]
fn a_series_is_named_by_message_entity_and_field() {
    for text in ["Voltage.2.value", "voltage.Battery.value", "Voltage.A.B. C.value", "EstimatedState.psi"] {
        assert!(SeriesName::new(text).is_ok(), "{text}");
    }
    for text in ["", "Voltage", "Voltage.", ".value", "Voltage..value", "Voltage.2."] {
        let error = SeriesName::new(text).unwrap_err().to_string();
        assert!(error.contains("is not a series; write message, entity and field"), "{text}: {error}");
    }
    assert!(SeriesName::new("Voltag.2.value").unwrap_err().to_string().contains("did you mean `Voltage`"));
}

#[test]
fn values_are_given_once_each_or_with_commas() {
    let texts = ["a, b".to_owned(), String::new(), "c".to_owned(), "b,a".to_owned()];
    assert_eq!(several("series", &texts).unwrap(), ["a", "b", "c"]);
    // A label may hold the separator, and what people write for it a backslash.
    let texts = [r"Voltage.Motor\, left.value,Voltage.2.value".to_owned(), r"a\b,c\\,d\".to_owned()];
    let names = ["Voltage.Motor, left.value", "Voltage.2.value", r"a\b", r"c\", r"d\"];
    assert_eq!(several("series", &texts).unwrap(), names);
}

#[test]
fn too_many_names_and_too_long_ones_are_refused_before_they_are_looked_up() {
    let names = |count: usize| (0..count).map(|at| at.to_string()).collect::<Vec<_>>().join(",");
    assert_eq!(several("series", &[names(500), names(500)]).unwrap().len(), 500, "each counts once");
    let error = several("series", &[names(501)]).unwrap_err().to_string();
    assert!(error.contains("series: more than 500 names"), "{error}");
    let error = several("vessel", &["x".repeat(301)]).unwrap_err().to_string();
    assert!(error.contains("vessel: `xxx") && error.contains("longer than 300 letters"), "{error}");
    assert!(error.len() < 200, "{error}");
}
