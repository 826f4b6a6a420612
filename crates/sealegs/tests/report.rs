//! The pages of `compare` and of `add`, whose page is that of `diagnose`: what comes first, and how figures are numbered.

use sealegs::{Campaign, Options, add, compare};

fn bench_knee() -> Campaign {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/campaigns/bench-knee");
    Campaign::read(folder.as_ref()).unwrap()
}

/// What stands on the page before anything is opened.
fn open(html: &str) -> String {
    let mut text = String::new();
    for (i, part) in html.split("<details").enumerate() {
        let rest = if i == 0 { part } else { part.split_once("</details>").unwrap().1 };
        text.push_str(rest);
    }
    text
}

/// The numbers of the figures in the order of the page.
fn figures(html: &str) -> Vec<usize> {
    html.split("<figcaption>Figure ").skip(1).map(|s| s.split('.').next().unwrap().parse().unwrap()).collect()
}

/// What every page must be, and its sections in their order.
fn holds(html: &str, sections: &[&str]) {
    let mut from = 0;
    for section in sections {
        from +=
            html[from..].find(section).unwrap_or_else(|| panic!("'{section}' after {from}")) + section.len();
    }
    let (seen, all) = (figures(&open(html)), figures(html));
    assert_eq!(seen, (1..=seen.len()).collect::<Vec<_>>(), "open figures");
    let mut sorted = all.clone();
    sorted.sort_unstable();
    assert_eq!(sorted, (1..=all.len()).collect::<Vec<_>>(), "each number once");
    assert!(seen.len() < all.len() && html.contains("name=\"viewport\""));
    // Tables of all runs and channels are folded; nothing is shown as a share of more than all.
    assert!(!open(html).contains("<table"));
    assert!(!html.contains("NaN"));
}

#[test]
fn a_comparison_says_first_where_the_model_fails_and_what_is_missing_there() {
    let comparison =
        compare(&bench_knee(), Options::new().command("sealegs compare knee --report c.html")).unwrap();
    let html = comparison.to_html().unwrap();
    holds(
        &html,
        &[
            "<section id=\"answer\">",
            "The model fails most in",
            "Missing at",
            "Figure 1.",
            "sealegs diagnose knee",
            "</section>",
            "Where the model fails",
            "error, noise units",
            "Details",
            "Missing signals at every port",
            "Provenance",
        ],
    );
    let summary = comparison.summary();
    let first = &summary.missing_signals[0];
    assert!(first.felt && first.rms > 2.0 * first.uncertainty, "{first:?}");
    let force = summary.missing_force.as_ref().unwrap();
    assert!(force.explained_by_law.is_none() && force.branches[0].x.len() > 10, "{force:?}");
    assert!(comparison.to_text().unwrap().contains("Missing at each port"));
}

#[test]
fn an_added_effect_is_drawn_over_the_force_that_was_missing() {
    let better = add(&["spring-hysteresis".to_owned()], &bench_knee(), Options::new()).unwrap();
    let html = better.to_html().unwrap();
    holds(
        &html,
        &[
            "<section id=\"answer\">",
            "Added: spring hysteresis",
            "Error on the held-out runs after each effect",
            "Figure 1.",
            "law found",
            "Figure 2.",
            "</section>",
            "Where the model fails",
            "Details",
            "Parameters and sensors",
            "Provenance",
        ],
    );
}
