//! The catalogue as people see it: every card is full, every effect can be drawn, and a wrong id gets the nearest one.

use sealegs::actuator::effect::{CATALOGUE, Graph};
use sealegs::catalogue::{Entry, braille, entries, find, svg};
use std::collections::BTreeSet;

#[test]
fn all_effects_of_both_catalogues_are_there_once() {
    let all = entries().unwrap();
    let known = CATALOGUE.len() + sealegs::leg::effect::CATALOGUE.len();
    assert_eq!(all.len(), known);
    let pages: BTreeSet<String> = all.iter().map(Entry::page_name).collect();
    assert_eq!(pages.len(), all.len());
}

#[test]
fn every_card_says_how_the_effect_is_told_apart_and_cured() {
    for entry in entries().unwrap() {
        let card = entry.card();
        assert!(card.symbols.contains(": "), "{}: '{}'", card.id, card.symbols);
        for text in [&card.told_apart, &card.cure] {
            assert!(text.ends_with('.') && text.len() > 40, "{}: '{text}'", card.id);
        }
    }
}

#[test]
fn every_effect_has_a_law_to_draw_and_shows_in_a_log() {
    for entry in entries().unwrap() {
        let id = &entry.card().id;
        let signature = entry.signature().unwrap();
        let law = signature.law.unwrap_or_else(|| panic!("{id} has no law to draw"));
        for graph in [&law, &signature.residual] {
            let points = || graph.curves.iter().flat_map(|c| &c.points);
            assert!(points().all(|(x, y)| x.is_finite() && y.is_finite()), "{id}: {}", graph.title);
            let low = points().map(|p| p.1).fold(f64::INFINITY, f64::min);
            let high = points().map(|p| p.1).fold(f64::NEG_INFINITY, f64::max);
            // A constant force is flat, and not zero.
            assert!(high > low || low != 0.0, "{id}: {} shows nothing", graph.title);
            // Where two curves are drawn they differ.
            if let [first, second, ..] = graph.curves.as_slice() {
                assert!(first.points != second.points, "{id}: {}", graph.title);
            }
        }
    }
}

#[test]
fn an_unknown_id_gets_the_nearest_one() {
    let message = find("backslash").unwrap_err().to_string();
    assert!(message.contains("did you mean 'backlash'"), "{message}");
    let message = find("hysteresis").unwrap_err().to_string();
    assert!(message.contains("did you mean 'spring-hysteresis'"), "{message}");
    let message = find("friction").unwrap_err().to_string();
    assert!(
        message.contains("one of coulomb-friction, ") && message.contains("stribeck-friction"),
        "{message}"
    );
    assert_eq!(find("knee/sensor-lag@force_1_n").unwrap().card().id, "sensor-lag");
    assert_eq!(find("knee/output-friction").unwrap().page_name(), "leg-output-friction");
}

#[test]
fn drawings_have_all_their_points_within() {
    let graph = Graph::new("A line", ("x", "m"), ("y", "N")).curve("", [(0.0, -1.0), (1e-3, 2.0)]);
    let text = braille(&graph);
    assert!(text.contains("x, mm") && text.contains('2') && text.contains("-1"), "{text}");
    let picture = svg(&graph);
    assert!(picture.starts_with("<svg") && picture.ends_with("</svg>") && !picture.contains('\n'));
}
