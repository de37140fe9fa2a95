//! IMC names to Rust names.

/// A field's Rust name: `angAperture` becomes `ang_aperture`, `SNR` becomes `snr`, `type` becomes `r#type`.
pub(super) fn field(abbrev: &str) -> String {
    let snake = snake(abbrev);
    match snake.as_str() {
        "type" | "ref" | "move" | "mod" | "loop" | "use" | "in" | "as" => format!("r#{snake}"),
        _ => snake,
    }
}

/// `GpsFix` becomes `gps_fix`, `AUVComms` becomes `auv_comms`, `Acoustic Communication` loses its blank.
pub(super) fn snake(name: &str) -> String {
    let letters: Vec<char> = name.chars().collect();
    let mut out = String::new();
    for (at, &letter) in letters.iter().enumerate() {
        if letter == ' ' {
            out.push('_');
            continue;
        }
        if letter.is_uppercase() && at > 0 && letters[at - 1] != '_' && letters[at - 1] != ' ' {
            let after_lower = !letters[at - 1].is_uppercase();
            let before_lower = letters.get(at + 1).is_some_and(|next| next.is_lowercase());
            if after_lower || before_lower {
                out.push('_');
            }
        }
        out.extend(letter.to_lowercase());
    }
    out
}

/// `METERS_PS` becomes `MetersPs`, `op_mode` becomes `OpMode`, `3D` becomes `N3d`.
pub(super) fn pascal(name: &str) -> String {
    let snake = snake(name);
    let mut out: String = snake
        .split('_')
        .filter_map(|word| {
            let mut letters = word.chars();
            letters.next().map(|first| first.to_uppercase().chain(letters).collect::<String>())
        })
        .collect();
    if out.starts_with(|first: char| first.is_ascii_digit()) {
        out.insert(0, 'N');
    }
    out
}

/// A bit's constant name: as it is, unless it starts with a digit.
pub(super) fn constant(abbrev: &str) -> String {
    if abbrev.starts_with(|first: char| first.is_ascii_digit()) {
        format!("N{abbrev}")
    } else {
        abbrev.to_uppercase()
    }
}

/// `SCREAMING_SNAKE` of a message or type name.
pub(super) fn screaming(name: &str) -> String {
    snake(name).to_uppercase()
}
