//! One chapter: Markdown (CommonMark with tables and `{#anchor}` behind headings) into HTML, and what it links to.
//!
//! HTML in the text is a problem and is shown as it is written: a chapter looks the same wherever it is read, and no text can
//! bring a script into the page.

use crate::Section;
use pulldown_cmark::{CodeBlockKind, CowStr, Event, LinkType, Options, Parser, Tag, TagEnd, html};
use std::fmt;

/// Where a link or picture leads.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Target {
    /// Another server.
    Outside(String),
    /// An anchor of the same chapter.
    Here(String),
    /// A file beside the chapter.
    File { path: String, anchor: String },
}

impl Target {
    fn of(address: &str) -> Self {
        if ["https://", "http://", "mailto:"].iter().any(|begin| address.starts_with(begin)) {
            return Self::Outside(address.to_owned());
        }
        let (path, anchor) = address.split_once('#').unwrap_or((address, ""));
        if path.is_empty() {
            return Self::Here(anchor.to_owned());
        }
        Self::File { path: path.to_owned(), anchor: anchor.to_owned() }
    }
}

impl fmt::Display for Target {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Outside(address) => out.write_str(address),
            Self::Here(anchor) => write!(out, "#{anchor}"),
            Self::File { path, anchor } if anchor.is_empty() => out.write_str(path),
            Self::File { path, anchor } => write!(out, "{path}#{anchor}"),
        }
    }
}

/// A link or picture of a chapter.
pub(crate) struct Link {
    pub(crate) target: Target,
    pub(crate) is_picture: bool,
}

/// A chapter made into HTML.
pub(crate) struct Rendered {
    pub(crate) html: String,
    pub(crate) sections: Vec<Section>,
    pub(crate) links: Vec<Link>,
    pub(crate) problems: Vec<String>,
}

/// Renders a chapter. `address` gives what a browser goes to; a link without one is shown as its text.
pub(crate) fn chapter(text: &str, address: impl Fn(&Target) -> Option<String>) -> Rendered {
    let options = Options::ENABLE_TABLES | Options::ENABLE_HEADING_ATTRIBUTES;
    let events: Vec<_> = Parser::new_ext(text, options).collect();
    let mut writer = Writer {
        address,
        sections: Vec::new(),
        links: Vec::new(),
        problems: Vec::new(),
        plain: 0,
        in_heading: false,
    };
    let mut made = Vec::with_capacity(events.len());
    for (at, event) in events.iter().enumerate() {
        // What is wider than the page scrolls by itself, also by keyboard.
        if matches!(event, Event::Start(Tag::Table(_))) {
            made.push(Event::Html(begin_of_table(writer.sections.last()).into()));
        }
        made.extend(writer.event(&events, at));
        if matches!(event, Event::End(TagEnd::Table)) {
            made.push(Event::Html("</div>\n".into()));
        }
    }
    let mut html = String::with_capacity(text.len() * 2);
    html::push_html(&mut html, made.into_iter());
    let Writer { sections, links, mut problems, .. } = writer;
    if sections.first().is_none_or(|first| first.level != 1) {
        problems.push("it does not begin with a heading `# …`".to_owned());
    }
    Rendered { html, sections, links, problems }
}

struct Writer<A> {
    address: A,
    sections: Vec<Section>,
    links: Vec<Link>,
    problems: Vec<String>,
    /// Open links that are shown as their text.
    plain: usize,
    /// Whether a heading is open, whose words are no part of the text below it.
    in_heading: bool,
}

impl<A: Fn(&Target) -> Option<String>> Writer<A> {
    /// What takes the place of an event; `None` for nothing.
    fn event<'a>(&mut self, events: &[Event<'a>], at: usize) -> Option<Event<'a>> {
        let event = &events[at];
        self.collect(event);
        Some(match event {
            Event::Start(Tag::Heading { level, id, classes, attrs }) => {
                let heading = words(&events[at + 1..]);
                let anchor = id.as_ref().map_or_else(|| slug(&heading), ToString::to_string);
                let id = Some(CowStr::from(anchor.clone()));
                self.sections.push(Section { anchor, level: *level as u8, heading, text: String::new() });
                Event::Start(Tag::Heading {
                    level: *level,
                    id,
                    classes: classes.clone(),
                    attrs: attrs.clone(),
                })
            }
            Event::Start(Tag::Link { link_type, dest_url, title, id }) => {
                let Some(dest_url) = self.link(*link_type, dest_url, false) else {
                    self.plain += 1;
                    return None;
                };
                Event::Start(Tag::Link {
                    link_type: *link_type,
                    dest_url,
                    title: title.clone(),
                    id: id.clone(),
                })
            }
            Event::End(TagEnd::Link) if self.plain > 0 => {
                self.plain -= 1;
                return None;
            }
            Event::Start(Tag::Image { link_type, dest_url, title, id }) => {
                let dest_url = self.link(*link_type, dest_url, true).unwrap_or_else(|| CowStr::from(""));
                Event::Start(Tag::Image {
                    link_type: *link_type,
                    dest_url,
                    title: title.clone(),
                    id: id.clone(),
                })
            }
            Event::Start(Tag::CodeBlock(kind)) => Event::Html(begin_of_code(kind).into()),
            Event::End(TagEnd::CodeBlock) => Event::Html("</code></pre>\n".into()),
            Event::Html(raw) | Event::InlineHtml(raw) => {
                self.problems.push(format!("HTML is not taken: {}", raw.trim()));
                Event::Text(raw.clone())
            }
            other => other.clone(),
        })
    }

    fn link<'a>(&mut self, kind: LinkType, address: &str, is_picture: bool) -> Option<CowStr<'a>> {
        let target = if kind == LinkType::Email {
            Target::Outside(format!("mailto:{address}"))
        } else {
            Target::of(address)
        };
        let to = (self.address)(&target);
        self.links.push(Link { target, is_picture });
        to.map(CowStr::from)
    }

    /// Adds the words of an event to the section that they stand in.
    fn collect(&mut self, event: &Event<'_>) {
        if let Event::Start(Tag::Heading { .. }) | Event::End(TagEnd::Heading(_)) = event {
            self.in_heading = matches!(event, Event::Start(_));
        }
        let Some(section) = self.sections.last_mut().filter(|_| !self.in_heading) else { return };
        match event {
            Event::Text(words) | Event::Code(words) => section.text.push_str(words),
            Event::End(TagEnd::Emphasis | TagEnd::Strong | TagEnd::Link | TagEnd::Image) => {}
            Event::SoftBreak | Event::HardBreak | Event::End(_) => section.text.push(' '),
            _ => {}
        }
    }
}

/// A table is named by the heading above it.
fn begin_of_table(section: Option<&Section>) -> String {
    let heading = section.map(|section| escaped(&section.heading)).unwrap_or_default();
    format!("<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"{heading}\">")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

fn begin_of_code(kind: &CodeBlockKind<'_>) -> String {
    let language = match kind {
        CodeBlockKind::Fenced(language) => language.as_ref(),
        CodeBlockKind::Indented => "",
    };
    let is_word = !language.is_empty() && language.chars().all(|letter| letter.is_ascii_alphanumeric());
    // Wider than the page, it scrolls, also by keyboard.
    let class = if is_word { format!(" class=\"language-{language}\"") } else { String::new() };
    format!("<pre tabindex=\"0\"><code{class}>")
}

/// The words of a heading, from behind its beginning.
fn words(events: &[Event<'_>]) -> String {
    let mut all = String::new();
    for event in events {
        match event {
            Event::End(TagEnd::Heading(_)) => break,
            Event::Text(words) | Event::Code(words) => all.push_str(words),
            _ => {}
        }
    }
    all
}

/// The anchor of a heading that names none, as mdBook makes it.
fn slug(heading: &str) -> String {
    let mut all = String::with_capacity(heading.len());
    for letter in heading.trim().chars() {
        if letter.is_alphanumeric() || letter == '_' || letter == '-' {
            all.extend(letter.to_lowercase());
        } else if letter.is_whitespace() {
            all.push('-');
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn plain(text: &str) -> Rendered {
        chapter(text, |target| Some(target.to_string()))
    }

    #[test]
    fn headings_have_anchors_and_sections_have_their_words() {
        let rendered =
            plain("# The `imc` tool\n\nBefore.\n\n## What is *it*?\n\nA\ntool.\n\n## Known {#k}\n");
        assert!(rendered.html.contains("<h1 id=\"the-imc-tool\">The <code>imc</code> tool</h1>"));
        let anchors: Vec<_> = rendered.sections.iter().map(|one| (&*one.anchor, &*one.heading)).collect();
        assert_eq!(
            anchors,
            [("the-imc-tool", "The imc tool"), ("what-is-it", "What is it?"), ("k", "Known")]
        );
        assert_eq!(rendered.sections[1].text.trim(), "A tool.");
        assert!(rendered.problems.is_empty());
    }

    #[test]
    fn what_is_wider_than_the_page_scrolls_and_is_reached_by_keyboard() {
        let html = plain("# T\n\n| a | b |\n|---|---|\n| 1 | 2 |\n\n```console\n$ make <x>\n```\n").html;
        assert!(
            html.contains("<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"T\"><table>"),
            "{html}"
        );
        assert!(html.contains("</table>\n</div>"), "{html}");
        assert!(
            html.contains("<pre tabindex=\"0\"><code class=\"language-console\">$ make &lt;x&gt;"),
            "{html}"
        );
    }

    #[test]
    fn html_is_a_problem_and_brings_nothing_into_the_page() {
        let rendered = plain("# T\n\n<script>alert(1)</script>\n\nA <b>word</b>.\n");
        assert!(!rendered.html.contains("<script>") && !rendered.html.contains("<b>"), "{}", rendered.html);
        assert!(rendered.problems.len() >= 2);
    }

    #[test]
    fn a_chapter_without_a_title_is_a_problem() {
        assert_eq!(plain("words\n").problems.len(), 1);
        assert_eq!(plain("## Two\n").problems.len(), 1);
    }

    proptest! {
        #[test]
        fn no_text_brings_an_element_that_runs(text in "[ -~\n<>\"'`\\[\\]()#!|]{0,200}") {
            let html = plain(&format!("# T\n\n{text}")).html.to_lowercase();
            prop_assert!(!html.contains("<script") && !html.contains("<iframe") && !html.contains("<object"));
        }
    }
}
