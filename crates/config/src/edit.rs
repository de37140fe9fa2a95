//! The effects of option lines on settings: assign, append, remove, refer, continue.

use crate::ini::{Action, Change, Ini, Setting};
use crate::line::{COMMENT_MARKS, Operator, OptionLine, Text, trim};
use crate::problem::{Place, Problem, ProblemKind, Report};

/// The longest value, in bytes.
pub const MAX_VALUE_BYTES: usize = 1 << 16;
/// How many bytes `$(Section, Option)` references may copy together.
const MAX_COPIED_BYTES: usize = 4 << 20;
/// How many items `name- = ..` lines may name together.
const MAX_REMOVED_ITEMS: usize = 1_000;

/// The reader's position in a file.
#[derive(Debug)]
pub(crate) struct Cursor {
    section: String,
    option: Option<(String, Operator)>,
}

impl Cursor {
    pub(crate) fn new(section: &str) -> Self {
        Self { section: section.to_owned(), option: None }
    }

    pub(crate) fn section(&self) -> &str {
        &self.section
    }
}

/// The settings so far, the problems so far, and how much was spent.
#[derive(Debug, Default)]
pub(crate) struct Edits {
    pub(crate) ini: Ini,
    pub(crate) report: Report,
    copied_bytes: usize,
    removed_items: usize,
}

impl Edits {
    /// `name = value` and its relatives.
    pub(crate) fn option(&mut self, cursor: &mut Cursor, line: &OptionLine<'_>, place: &Place) {
        self.check_name(line.name, place);
        self.check_cut(line.name, &line.value, place);
        self.check_list_above(cursor, line.name, place);
        if let Some(attributes) = line.attributes {
            self.attributes(cursor, line.name, attributes, place);
        }
        cursor.option = Some((line.name.to_owned(), line.operator));
        let text = line.value.text;
        match line.operator {
            Operator::Set if text.starts_with("$(") => self.refer(cursor, line.name, text, place),
            Operator::Set => self.set(cursor, line.name, text, place),
            Operator::Append => self.append(cursor, line.name, text, place),
            Operator::Remove => self.remove(cursor, line.name, text, place),
        }
    }

    /// A line that continues the option above.
    pub(crate) fn more(&mut self, cursor: &Cursor, text: &Text<'_>, place: &Place) {
        let Some((name, operator)) = &cursor.option else {
            let what = format!("`{}` is neither an option nor a part of one", shortened(text.text));
            let remedy = "write `name = value`, or put `#` in front if it is a comment";
            return self.error(ProblemKind::Syntax, place, what, remedy);
        };
        self.check_cut(name, text, place);
        if *operator == Operator::Remove {
            let what = format!("DUNE adds this line to `{name}` where `{name}- =` above takes items out");
            self.error(ProblemKind::ListEdit, place, what, "repeat `name- =` on each line");
        }
        if text.text.contains("$(") {
            let what = format!("the reference in `{}` is not replaced here", shortened(text.text));
            self.warning(ProblemKind::Reference, place, what, "a reference must be the whole value");
        }
        let setting = self.ini.open(&cursor.section, place).entry(name);
        if setting.value.len() + text.text.len() >= MAX_VALUE_BYTES {
            return self.too_long(name, place);
        }
        if !setting.value.is_empty() {
            setting.value.push(' ');
        }
        setting.value.push_str(text.text);
        if let Some(change) = setting.history.last_mut() {
            change.last_line = place.line;
            change.text.push(' ');
            change.text.push_str(text.text);
        }
    }

    /// `{k:v, k:v}` behind a name.
    pub(crate) fn attributes(&mut self, cursor: &Cursor, name: &str, attributes: &str, place: &Place) {
        for item in attributes.split(',').map(trim) {
            let Some((key, value)) = item.split_once(':').map(|(key, value)| (trim(key), trim(value))) else {
                let what = format!("`{}` is not an attribute", shortened(item));
                self.error(ProblemKind::Attribute, place, what, "write {key:value, key:value}");
                continue;
            };
            let allowed: &[&str] = match key {
                "scope" => &["global", "idle", "plan", "maneuver"],
                "visibility" => &["user", "developer"],
                "editable" => &["true", "false"],
                _ => &[],
            };
            if allowed.contains(&value) {
                let setting = self.ini.open(&cursor.section, place).entry(name);
                setting.attributes.insert(key.to_owned(), value.to_owned());
            } else if allowed.is_empty() {
                let what = format!("unknown attribute `{}`", shortened(key));
                self.warning(ProblemKind::Attribute, place, what, "known are scope, visibility and editable");
            } else {
                let what = format!("`{}` is not a value of {key}", shortened(value));
                let remedy = format!("one of {}", allowed.join(", "));
                self.warning(ProblemKind::Attribute, place, what, remedy);
            }
        }
    }

    fn set(&mut self, cursor: &Cursor, name: &str, text: &str, place: &Place) {
        let setting = self.ini.open(&cursor.section, place).entry(name);
        let earlier = setting.history.last().filter(|last| last.place.file == place.file);
        let earlier = earlier.map(|last| last.place.line).filter(|line| *line < place.line);
        text.clone_into(&mut setting.value);
        setting.record(place, Action::Set, text);
        if let Some(line) = earlier {
            let what = format!("`{name}` is set for a second time, the first was line {line}");
            self.warning(ProblemKind::Repeated, place, what, "take one of the two out");
        }
    }

    fn append(&mut self, cursor: &Cursor, name: &str, text: &str, place: &Place) {
        if text.starts_with("$(") {
            let what = format!("a reference behind `{name}+ =` replaces the whole list in DUNE");
            self.error(ProblemKind::ListEdit, place, what, "write the items themselves");
        }
        let setting = self.ini.open(&cursor.section, place).entry(name);
        if setting.value.len() + text.len() + 2 > MAX_VALUE_BYTES {
            return self.too_long(name, place);
        }
        if !setting.history.is_empty() {
            setting.value.push_str(", ");
        }
        setting.value.push_str(text);
        let first = setting.history.is_empty();
        setting.record(place, Action::Append, text);
        if first {
            let what = format!("nothing is set yet that `{name}+ =` could add to");
            self.warning(ProblemKind::ListEdit, place, what, "write `name = value`, or mend the name");
        }
    }

    fn remove(&mut self, cursor: &Cursor, name: &str, text: &str, place: &Place) {
        let mut problems = Vec::new();
        let setting = self.ini.open(&cursor.section, place).entry(name);
        for item in text.split(',').map(trim).filter(|item| !item.is_empty()) {
            self.removed_items += 1;
            if self.removed_items > MAX_REMOVED_ITEMS {
                break;
            }
            let whole = setting.value.split(',').any(|present| trim(present) == item);
            let Some(start) = setting.value.find(item) else {
                problems.push(format!("`{}` is not in `{name}`, so nothing is taken out", shortened(item)));
                continue;
            };
            let first = setting.value[..start].rfind(',').map_or(0, |comma| comma + 1);
            let end = setting.value[start..].find(',').map_or(setting.value.len(), |comma| start + comma);
            let hit = trim(&setting.value[first..end]).to_owned();
            if hit != item {
                let also = if whole { "" } else { " and it is not an item itself" };
                problems.push(format!("`{}` is cut out of `{}`{also}", shortened(item), shortened(&hit)));
            }
            let mut end = start + item.len();
            end += usize::from(setting.value[end..].starts_with(','));
            setting.value.replace_range(start..end, "");
        }
        // DUNE leaves the comma in front of a removed last item; the empty item behind it is never meant.
        setting.value = trim(setting.value.trim_end_matches([' ', ','])).to_owned();
        setting.record(place, Action::Remove, text);
        let remedy = "name whole items, in an order in which none begins another";
        for what in problems {
            self.error(ProblemKind::ListEdit, place, what, remedy);
        }
        if self.removed_items > MAX_REMOVED_ITEMS {
            let what = format!("more than {MAX_REMOVED_ITEMS} items are taken out of lists");
            self.error(ProblemKind::Limit, place, what, "write the list as it is meant");
        }
    }

    fn refer(&mut self, cursor: &Cursor, name: &str, text: &str, place: &Place) {
        let resolved = self.resolve(text, place);
        let value = resolved.unwrap_or_default();
        self.copied_bytes += value.len();
        if self.copied_bytes > MAX_COPIED_BYTES {
            return self.too_long(name, place);
        }
        let setting = self.ini.open(&cursor.section, place).entry(name);
        setting.value = value;
        setting.record(place, Action::Refer, text);
    }

    /// The value that `$(Section, Option)` stands for.
    fn resolve(&mut self, text: &str, place: &Place) -> Option<String> {
        let inside = text.strip_prefix("$(").and_then(|rest| rest.split_once(')'));
        let Some(((section, option), after)) =
            inside.and_then(|(inner, after)| Some((inner.split_once(',')?, after)))
        else {
            let what = format!("`{}` is not a reference", shortened(text));
            self.error(ProblemKind::Reference, place, what, "write $(Section, Option)");
            return None;
        };
        let option = option.trim_start();
        if !after.is_empty() {
            let what = format!("`{}` behind the reference is dropped", shortened(after));
            self.warning(ProblemKind::Reference, place, what, "a reference must be the whole value");
        }
        let found = self.ini.value(section, option).map(str::to_owned);
        if found.is_none() {
            let what = format!("`$({section}, {option})` is not set at this point");
            let options = self.ini.section(section).into_iter().flat_map(crate::ini::IniSection::settings);
            let near = match suggest::nearest(option, options.map(|(key, _)| key)) {
                Some(near) => format!("`$({section}, {near})`?"),
                None => "set it above this line, or in a file required before".to_owned(),
            };
            self.error(ProblemKind::Reference, place, what, near);
        }
        found
    }

    fn check_name(&mut self, name: &str, place: &Place) {
        if name.contains(COMMENT_MARKS) {
            let what = format!("the option is called `{}`, comment character included", shortened(name));
            let remedy = "a comment must not hold `=` unless the line begins with `#`";
            self.error(ProblemKind::CommentInName, place, what, remedy);
        } else if name.contains(['{', '}']) {
            let what = format!("`{}` has a brace in its name", shortened(name));
            self.error(ProblemKind::Attribute, place, what, "write `name {key:value} = value`");
        }
    }

    fn check_cut(&mut self, name: &str, value: &Text<'_>, place: &Place) {
        if let Some(mark) = value.doubtful_cut {
            let what = format!("`{mark}` ends the value of `{name}`, which is `{}`", shortened(value.text));
            let remedy =
                format!("put a blank before `{mark}` if a comment begins there; nothing else can protect it");
            self.warning(ProblemKind::ValueCut, place, what, remedy);
        }
    }

    /// An option that starts where the list above has not ended.
    fn check_list_above(&mut self, cursor: &Cursor, name: &str, place: &Place) {
        let Some((above, _)) = &cursor.option else { return };
        let open = self.ini.value(&cursor.section, above).is_some_and(|value| value.ends_with(','));
        if open && above != name && !name.contains(COMMENT_MARKS) {
            let what = format!("`{above}` above ends in a comma, but this line starts the option `{name}`");
            let remedy = "take the comma out, or the `=` from the list";
            self.warning(ProblemKind::EmptyItem, place, what, remedy);
        }
    }

    fn too_long(&mut self, name: &str, place: &Place) {
        let what = format!("the value of `{name}` grows beyond what is allowed; this line is left out");
        let remedy = format!("a value may have {MAX_VALUE_BYTES} bytes");
        self.error(ProblemKind::Limit, place, what, remedy);
    }

    fn error(&mut self, kind: ProblemKind, place: &Place, what: String, remedy: impl Into<String>) {
        self.report.add(Problem::error(kind, Some(place), what).remedy(remedy));
    }

    fn warning(&mut self, kind: ProblemKind, place: &Place, what: String, remedy: impl Into<String>) {
        self.report.add(Problem::warning(kind, Some(place), what).remedy(remedy));
    }
}

impl Setting {
    fn record(&mut self, place: &Place, action: Action, text: &str) {
        let (place, last_line, text) = (place.clone(), place.line, text.to_owned());
        self.history.push(Change { place, last_line, action, text });
    }
}

/// `text` short enough for a message.
pub(crate) fn shortened(text: &str) -> String {
    const LENGTH: usize = 60;
    match text.char_indices().nth(LENGTH) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}
