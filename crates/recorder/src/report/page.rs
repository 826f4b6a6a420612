//! The frame of the page: head, style, contents, script.

use crate::chart::{SCRIPT, STYLE, escape};

const PAGE_STYLE: &str = include_str!("page.css");

pub(super) fn page(title: &str, subtitle: &str, contents: &[(String, String)], body: &str) -> String {
    let title = escape(title);
    let subtitle = if subtitle.is_empty() {
        String::new()
    } else {
        format!("<p class=\"sub\">{}</p>", escape(subtitle))
    };
    let links: String =
        contents.iter().map(|(id, heading)| format!("<a href=\"#{id}\">{}</a>", escape(heading))).collect();
    let nav = if contents.len() > 2 { format!("<nav>{links}</nav>") } else { String::new() };
    // The script only where something can be zoomed.
    let script =
        if body.contains("class=\"zoom\"") { format!("<script>{SCRIPT}</script>") } else { String::new() };
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"><meta name=\"color-scheme\" content=\"light dark\"><title>{title}</title><style>{STYLE}{PAGE_STYLE}</style></head>\n<body><header><h1>{title}</h1>{subtitle}</header>{nav}<main>\n{body}</main>{script}</body></html>\n"
    )
}
