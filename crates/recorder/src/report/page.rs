//! The frame of the page: head, style, contents, script.

use super::Text;
use crate::chart::{SCRIPT, STYLE};
use maud::{DOCTYPE, Markup, PreEscaped, html};

const PAGE_STYLE: &str = include_str!("page.css");

pub(super) fn page(
    (title, subtitle): (&str, &str),
    wide: bool,
    contents: &[(String, String)],
    body: &str,
) -> Markup {
    // The script only where something can be zoomed.
    let zooms = body.contains("class=\"zoom\"");
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width,initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (Text(title)) }
                style { (PreEscaped(STYLE)) (PreEscaped(PAGE_STYLE)) }
            }
            body class=[wide.then_some("broad")] {
                header {
                    h1 { (Text(title)) }
                    @if !subtitle.is_empty() { p.sub { (Text(subtitle)) } }
                }
                // A wide page answers first: its sections are folded, and named where they are.
                @if contents.len() > 2 && !wide {
                    nav { @for (id, heading) in contents { a href={ "#" (id) } { (Text(heading)) } } }
                }
                main { "\n" (PreEscaped(body)) }
                @if zooms { script { (PreEscaped(SCRIPT)) } }
            }
        }
    }
}
