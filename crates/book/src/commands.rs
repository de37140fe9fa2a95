//! The commands that a chapter tells people to type, so that tests can hold them against the programs.
//!
//! Whole ones stand in blocks: in ```` ```console ```` behind `$ `, in ```` ```sh ```` each line. Those in running text, `` `imc info …` ``,
//! may leave things out. A line is taken apart as a shell would, as far as manuals need it: quotes, a backslash at the end, pipes,
//! `&&`, redirections, comments, `sudo` and variables before the program.

use pulldown_cmark::{CodeBlockKind, Event, Parser, Tag, TagEnd};

/// A command as it is to be typed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Command {
    /// The program and its arguments.
    pub words: Vec<String>,
    /// Whether all of it stands there.
    pub is_whole: bool,
    /// The line of the chapter, from 1.
    pub line: usize,
}

/// The commands of a chapter that begin with one of `programs`.
pub fn commands(text: &str, programs: &[&str]) -> Vec<Command> {
    let mut all = Vec::new();
    let mut block: Option<(bool, usize, String)> = None;
    for (event, range) in Parser::new(text).into_offset_iter() {
        let line = text[..range.start].matches('\n').count() + 1;
        match event {
            Event::Start(Tag::CodeBlock(CodeBlockKind::Fenced(language))) => {
                let prompts = language.as_ref() == "console";
                block = (prompts || language.as_ref() == "sh").then(|| (prompts, line, String::new()));
            }
            Event::End(TagEnd::CodeBlock) => {
                if let Some((prompts, line, lines)) = block.take() {
                    for (at, typed) in typed(&lines, prompts) {
                        parts(&typed, true, line + 1 + at, &mut all);
                    }
                }
            }
            Event::Text(words) => {
                if let Some((_, _, lines)) = &mut block {
                    lines.push_str(&words);
                }
            }
            Event::Code(words) => parts(&words, false, line, &mut all),
            _ => {}
        }
    }
    all.retain(|command| command.words.first().is_some_and(|program| programs.contains(&program.as_str())));
    all
}

/// The lines of a block that are typed, each with its number in the block; those that end with a backslash go on.
fn typed(block: &str, prompts: bool) -> Vec<(usize, String)> {
    let mut all: Vec<(usize, String)> = Vec::new();
    let mut goes_on = false;
    for (at, line) in block.lines().enumerate() {
        let begin = if prompts { line.strip_prefix("$ ") } else { Some(line) };
        let said = if goes_on { line } else { begin.unwrap_or_default() };
        let whole = said.trim_end_matches('\\').trim();
        match all.last_mut() {
            Some((_, before)) if goes_on => *before = format!("{before} {whole}"),
            _ if whole.is_empty() => {}
            _ => all.push((at, whole.to_owned())),
        }
        goes_on = said.ends_with('\\');
    }
    all
}

/// Adds each command of a line: what stands between pipes, `&&` and `;`.
fn parts(line: &str, is_whole: bool, at: usize, all: &mut Vec<Command>) {
    let mut words = Vec::new();
    let mut is_target = false;
    for word in split(line).into_iter().chain(["|".to_owned()]) {
        match word.as_str() {
            "|" | "&&" | ";" => {
                let words = without_sudo(std::mem::take(&mut words));
                all.extend((!words.is_empty()).then_some(Command { words, is_whole, line: at }));
            }
            ">" | ">>" | "<" => is_target = true,
            _ if std::mem::take(&mut is_target) => {}
            _ => words.push(word),
        }
    }
}

/// The words of a line as a shell reads them, without a comment.
fn split(line: &str) -> Vec<String> {
    let mut all = Vec::new();
    let (mut word, mut quote, mut begun) = (String::new(), None, false);
    for letter in line.chars() {
        match (letter, quote) {
            (one, Some(open)) if one == open => quote = None,
            ('\'' | '"', None) => (quote, begun) = (Some(letter), true),
            ('#', None) if word.is_empty() && !begun => break,
            (one, None) if one.is_whitespace() => {
                all.extend((begun || !word.is_empty()).then(|| std::mem::take(&mut word)));
                begun = false;
            }
            (one, _) => word.push(one),
        }
    }
    all.extend((begun || !word.is_empty()).then_some(word));
    all
}

/// A command without `sudo`, its `-u USER`, and variables that are set for it.
fn without_sudo(words: Vec<String>) -> Vec<String> {
    let mut words = words.into_iter().peekable();
    let is_variable = |word: &String| {
        let name = word.split_once('=').map(|(name, _)| name).unwrap_or_default();
        !name.is_empty() && name.chars().all(|letter| letter.is_ascii_uppercase() || letter == '_')
    };
    if words.next_if(|word| word == "sudo").is_some() && words.next_if(|word| word == "-u").is_some() {
        words.next();
    }
    while words.next_if(is_variable).is_some() {}
    words.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn found(text: &str) -> Vec<String> {
        commands(text, &["imc", "make"])
            .iter()
            .map(|one| format!("{}: {}", one.line, one.words.join("|")))
            .collect()
    }

    #[test]
    fn commands_are_taken_from_blocks_as_a_shell_would_read_them() {
        let text = "# T\n\n```console\n$ imc decode 'a b.lsf' | head   # the first\n{\"id\": 1}\n\
                    $ sudo -u lutra imc info \\\n    Abort > file.txt\n```\n\n```sh\nLUTRA_LOG=debug make demo && imc list\n```\n\n\
                    ```toml\nimc = 1\n```\n";
        assert_eq!(
            found(text),
            ["4: imc|decode|a b.lsf", "6: imc|info|Abort", "11: make|demo", "11: imc|list"]
        );
        assert!(commands(text, &["imc"]).iter().all(|one| one.is_whole));
    }

    #[test]
    fn commands_in_running_text_are_not_whole() {
        let all = commands("See `imc info NAME` or `the imc`.\n", &["imc"]);
        assert_eq!(
            all,
            [Command {
                words: ["imc", "info", "NAME"].map(str::to_owned).to_vec(),
                is_whole: false,
                line: 1
            }]
        );
    }

    proptest! {
        #[test]
        fn no_text_breaks_it(text in "(\\PC|\n|```console\n\\$ imc |```sh\n|['\"|&;#\\\\]){0,60}") {
            let _ = commands(&text, &["imc"]);
        }
    }
}
