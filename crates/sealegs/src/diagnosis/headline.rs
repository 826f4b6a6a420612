//! The first screen of a diagnosis's report: what is missing, how sure, the ladder, the missing force, rivals, what to do next.

use super::confidence::Level;
use super::outcome::{Outcome, OutcomeKind, ParameterValue, RungSaid, percent};
use super::sentence::TOLD;
use super::text::{another_name, other_conventions};
use crate::report::units::{capital, error, symbol, with_interval};
use crate::report::{WIDE_RATIO, force};
use sealegs_recorder::chart::{Axis, Bar, BarChart, Chart, Hue};
use sealegs_recorder::report::{Answer, Report, Tone};

/// Values of effects that the headline shows.
const VALUES: usize = 6;

/// Rivals that are listed.
const RIVALS: usize = 4;

/// An effect in words with its place: `knee/coulomb-friction` is `Coulomb friction at knee`.
fn in_words(effect: &str) -> String {
    let (place, effect) = effect.rsplit_once('/').map_or((None, effect), |(place, e)| (Some(place), e));
    let words = effect.replace('-', " ").replace("coulomb", "Coulomb").replace("stribeck", "Stribeck");
    place.map_or(words.clone(), |place| format!("{words} at {place}"))
}

/// What was found, in a few words.
pub(super) fn sentence(o: &Outcome) -> String {
    let set = o.effects.iter().map(|e| in_words(e)).collect::<Vec<_>>().join(" and ");
    match o.verdict {
        OutcomeKind::Adequate => "Nothing is missing: the model fits to the noise floor".to_owned(),
        OutcomeKind::MissingEffect => format!("Missing: {set}"),
        OutcomeKind::PartlyExplained => format!("Partly explained by {set}"),
        OutcomeKind::Added => format!("Added: {set}"),
        _ if o.law.is_some() => format!(
            "Not explained by any known effect: something at {} that depends on {}",
            o.law.as_ref().map_or("", |l| &l.port),
            o.law.as_ref().map_or("", |l| &l.depends_on)
        ),
        _ => match o.missing_signals.first().filter(|m| m.explained > 0.0) {
            Some(m) => format!(
                "Not explained by any known effect: something at {} that depends on {}",
                m.port,
                m.depends_on.first().map_or("", String::as_str)
            ),
            None => "Not explained by any known effect".to_owned(),
        },
    }
}

/// The values of the named effects with their intervals: name, value, remark.
fn values(o: &Outcome) -> Vec<(String, String, String)> {
    let Some(after) = &o.after else { return Vec::new() };
    let many = o.effects.len() > 1;
    let interval = if o.confidence.intervals_conditional {
        "95 % interval, if this model is right"
    } else {
        "95 % interval"
    };
    after
        .parameters
        .iter()
        .filter(|p| !p.fixed && o.effects.iter().any(|e| e == effect_of(&p.name)))
        .take(VALUES)
        .map(|p| {
            let own = symbol(&p.name);
            let name = if many { format!("{}, {own}", in_words(effect_of(&p.name))) } else { own };
            let std = stated(p);
            let remark = match (p.at_bound, p.felt) {
                (true, _) => "at its bound: no interval",
                (_, false) => "not identifiable from these runs",
                _ if std.is_some() => interval,
                _ => "no interval",
            };
            let (value, remark) = match under_conventions(o, p) {
                Some(values) => (values, "by the log's convention"),
                None => (with_interval(p.value, std, &p.unit), remark),
            };
            (capital(&name), value, remark.to_owned())
        })
        .collect()
}

/// The named effects by their ids, each with its values and their 95 % intervals:
/// `knee/coulomb-friction (force 44.77 ± 0.15 N)`.
pub(super) fn set_with_values(o: &Outcome) -> String {
    let parameters = o.after.as_ref().map_or(&[][..], |after| &after.parameters);
    let with_values = |effect: &String| {
        let own = parameters.iter().filter(|p| !p.fixed && effect_of(&p.name) == effect);
        let value = |p: &ParameterValue| match under_conventions(o, p) {
            Some(values) => values,
            None if !p.felt => "not identifiable".to_owned(),
            None => with_interval(p.value, stated(p), &p.unit),
        };
        let values: Vec<String> = own.map(|p| format!("{} {}", symbol(&p.name), value(p))).collect();
        if values.is_empty() { effect.clone() } else { format!("{effect} ({})", values.join(", ")) }
    };
    o.effects.iter().map(with_values).collect::<Vec<_>>().join(" + ")
}

/// The effect that a parameter belongs to; empty for the base model's.
fn effect_of(parameter: &str) -> &str {
    parameter.rsplit_once('.').map_or("", |(effect, _)| effect)
}

/// A value under each convention of the log that these runs leave open: `2.39 ms or 1.39 ms`; none where it is the same.
fn under_conventions(o: &Outcome, p: &ParameterValue) -> Option<String> {
    let others = o.equally_good_choices.iter().filter_map(|other| other.parameters.get(&p.name));
    let all: Vec<String> =
        [&p.value].into_iter().chain(others).map(|value| with_interval(*value, None, &p.unit)).collect();
    (all.len() > 1).then(|| all.join(" or "))
}

/// A standard error that makes an interval: at a bound, or where the data say nothing, there is none.
fn stated(p: &ParameterValue) -> Option<f64> {
    p.std.filter(|s| *s > 0.0 && !p.at_bound && p.felt)
}

/// The errors from the base model to the named set, one effect after the other, and with the curve beyond the catalogue.
pub(super) fn ladder(o: &Outcome) -> BarChart {
    let mut known = 0;
    let rung = |rung: &RungSaid| {
        let new = rung.effects[known.min(rung.effects.len())..].join(" + ");
        let label = if rung.effects.is_empty() { "base model".to_owned() } else { format!("+ {new}") };
        known = rung.effects.len();
        (label, rung.holdout_error)
    };
    let mut steps: Vec<(String, f64)> = o.ladder.iter().map(rung).collect();
    steps.extend(o.law.as_ref().map(|law| (format!("+ {}", law.effect), law.holdout_error)));
    let errors = || steps.iter().map(|(_, error)| *error).chain([o.noise_floor]);
    let (least, most) = (errors().fold(f64::INFINITY, f64::min), errors().fold(0.0, f64::max));
    let logarithmic = least > 0.0 && most / least > WIDE_RATIO;
    let bar = |(label, e)| Bar { label, values: vec![e], text: error(e) };
    let bars: Vec<Bar> = steps.into_iter().map(bar).collect();
    let axis = if logarithmic {
        Axis::new("error, logarithmic", "noise units").log().range(0.5 * least, 1.2 * most)
    } else {
        Axis::new("error", "noise units")
    };
    BarChart {
        title: "Error on the held-out runs after each effect".to_owned(),
        axis,
        series: vec![(String::new(), Hue::Blue)],
        // As high as the picture beside it, as far as bars look like bars.
        row_height: Some((240.0 / bars.len().max(1) as f64).clamp(30.0, 80.0)),
        bars,
        marks: vec![(o.noise_floor, format!("noise floor {}", error(o.noise_floor)))],
    }
}

/// Effects that explain alike, and the next best.
fn rivals(o: &Outcome) -> Vec<String> {
    let mut lines = Vec::new();
    let held_out = |set: &[String]| {
        o.ranking
            .iter()
            .find(|r| r.effects == set)
            .map_or_else(String::new, |r| format!(" ({})", error(r.holdout_error)))
    };
    for set in o.indistinguishable.iter().take(RIVALS) {
        lines.push(format!("Fits as well: {}{}.", set.join(" + "), held_out(set)));
    }
    lines.extend(another_name(o));
    lines.extend(other_conventions(o));
    let others: Vec<String> = o
        .ranking
        .iter()
        .filter(|r| r.effects != o.effects && !o.indistinguishable.contains(&r.effects))
        .filter(|r| !o.same_by_another_name.contains(&r.effects))
        .take(RIVALS.saturating_sub(lines.len()))
        .map(|r| format!("{} ({})", r.effects.join(" + "), error(r.holdout_error)))
        .collect();
    if !others.is_empty() {
        let first = if o.effects.is_empty() { "Tried" } else { "Next best" };
        lines.push(format!("{first}: {}.", others.join("; ")));
    }
    if lines.is_empty() {
        lines.push("No other set of effects was worth fitting.".to_owned());
    } else {
        lines.push("In brackets: error on the held-out runs, noise units.".to_owned());
    }
    lines
}

/// What to do next.
fn next(o: &Outcome, command: &str) -> Vec<String> {
    let mut lines = Vec::new();
    if !o.effects.is_empty() && o.verdict != OutcomeKind::Added {
        lines.push(format!(
            "$ sealegs add {}{} --campaign {} -o better.toml",
            o.effects.join("+"),
            to_model_of(command),
            campaign_of(command)
        ));
    }
    if let Some(law) = &o.law {
        lines.push(law.sentence());
        lines.push("$ sealegs diagnose CAMPAIGN --law law.toml".replace("CAMPAIGN", campaign_of(command)));
        lines.push(format!(
            "$ sealegs add law.toml{} --campaign {} -o better.toml",
            to_model_of(command),
            campaign_of(command)
        ));
    } else if o.verdict == OutcomeKind::Unexplained {
        lines.push(
            "Describe the missing force yourself: an effect as an expression, given with --effect."
                .to_owned(),
        );
    }
    if !o.next_experiment.is_empty() {
        lines.push(o.next_experiment.clone());
    }
    lines
}

/// What `add` is told of the model that a command line names; nothing where that is the campaign's own.
fn to_model_of(command: &str) -> String {
    model_of(command).map_or(String::new(), |model| format!(" --to {model}"))
}

/// The model that a command line names.
pub(crate) fn model_of(command: &str) -> Option<&str> {
    let mut words = command.split_whitespace().skip_while(|w| *w != "--model");
    words.nth(1)
}

/// The campaign in a command line; a placeholder where it is none.
pub(crate) fn campaign_of(command: &str) -> &str {
    let mut words = command.split_whitespace().skip_while(|w| !matches!(*w, "diagnose" | "compare"));
    words.nth(1).filter(|w| !w.starts_with('-')).unwrap_or("CAMPAIGN")
}

/// What the errors are.
fn judged(o: &Outcome) -> Vec<String> {
    let mut lines = Vec::new();
    match &o.after {
        Some(after) => {
            lines.push(format!(
                "Held-out runs: {} → {} noise units; fit runs: {} → {}.",
                error(o.base.holdout_error),
                error(after.holdout_error),
                error(o.base.fit_error),
                error(after.fit_error)
            ));
            lines.extend(o.worst_channels(TOLD).map(|w| format!("Root mean square, held-out: {w}.")));
            lines.push(format!(
                "{} of the residual energy above the noise floor is left.",
                capital(&percent(o.unexplained_share))
            ));
        }
        None => {
            let (held_out, fitted) = (error(o.base.holdout_error), error(o.base.fit_error));
            lines.push(match &o.law {
                Some(law) => format!(
                    "Held-out runs: {held_out} → {} noise units; fit runs: {fitted} → {}, with the curve.",
                    error(law.holdout_error),
                    error(law.fit_error)
                ),
                None => format!("Held-out runs: {held_out} noise units; fit runs: {fitted}."),
            });
        }
    }
    if !o.traces.is_empty() {
        lines.push(format!("Minor effects, below 1 % of the error: {}.", o.traces.join(", ")));
    }
    let stop = o.sanity.iter().filter(|f| f.stops()).count();
    if stop > 0 {
        lines.push(format!("The log has {stop} faults that would stop a diagnosis (below)."));
    }
    lines
}

/// The first screen.
///
/// `foremost` is the channel that improved most, drawn where no missing force is.
pub(super) fn screen(page: &mut Report, o: &Outcome, command: &str, foremost: Option<&Chart>) {
    let (tone, certainty) = match o.confidence.level {
        Level::Sure => (Tone::Good, "Sure"),
        Level::Reserved => (Tone::Caution, "With reservations"),
        Level::Open => (Tone::Bad, "Not explained"),
        Level::Asked => (Tone::Neutral, "As asked for"),
    };
    let mut reasons = o.confidence.reasons.clone();
    if reasons.is_empty() {
        reasons.push(o.sentence.clone());
    }
    let answer = Answer { headline: &sentence(o), values: &values(o), certainty, reasons: &reasons };
    page.first_screen(|page| {
        page.answer(tone, &answer);
        let ladder = ladder(o);
        let rungs = "Root mean square residual over the noise of each channel; the held-out runs took no part in the search.";
        // Where nothing is missing, what noise depends on is no answer.
        let adequate = o.verdict == OutcomeKind::Adequate;
        match (o.missing_force.as_ref().filter(|_| !adequate), foremost) {
            (Some(missing), _) => {
                let (chart, caption) = (force::chart(missing), force::caption(missing, &o.effects));
                page.side_by_side(&[(&ladder, rungs), (&chart, &caption)]);
            }
            (None, Some(chart)) => {
                let measured = "Measured, and the model before and after, in the channel that improved most (at the effect's \
                                place, if one improved there). Its error in noise units is above it.";
                page.side_by_side(&[(&ladder, rungs), (chart, measured)]);
            }
            (None, None) => {
                page.side_by_side(&[(&ladder, rungs)]);
                page.remark(match adequate {
                    true => "No missing force is drawn: the model predicts the held-out runs to their noise.",
                    false => {
                        "No missing force is drawn: the runs measure no motion that an observer could follow, or what is missing depends on \
                         none of the signals that were tried."
                    }
                });
            }
        }
        let mut cards = vec![("Judged on", judged(o))];
        if o.verdict != OutcomeKind::Added {
            cards.insert(0, ("Rivals", rivals(o)));
            cards.insert(1, ("What to do next", next(o, command)));
        }
        cards.retain(|(_, lines)| !lines.is_empty());
        page.cards(&cards);
    });
}

#[cfg(test)]
mod tests {
    use super::super::confidence::{Confidence, Level};
    use super::super::law::LawSaid;
    use super::super::outcome::Ranked;
    use super::super::toy::{html, toy};
    use super::*;
    use sealegs_model::{Curve, Factor, Law, Over};

    #[test]
    fn the_first_screen_answers_in_the_order_of_the_questions() {
        let page = html(&toy());
        let screen = &page[page.find("<section id=\"answer\">").unwrap()..page.find("</section>").unwrap()];
        let order = [
            "Missing: backlash at knee and Coulomb friction at knee",
            "80.0 ± 0.4 µm",
            "42.1 ± 0.6 N",
            "Sure",
            "Error on the held-out runs after each effect",
            "+ knee/backlash",
            "+ knee/coulomb-friction",
            "Figure 1.",
            "Missing force at knee/rotor over speed",
            "law found",
            "Figure 2.",
            "Rivals",
            "knee/torque-ripple (6.30)",
            "What to do next",
            "sealegs add knee/backlash+knee/coulomb-friction --campaign data/toy",
            "Repeat the drop from 5 cm.",
        ];
        let mut from = 0;
        for words in order {
            let at =
                screen[from..].find(words).unwrap_or_else(|| panic!("'{words}' after {from} in {screen}"));
            from += at + words.len();
        }
        // Errors between 40 and 1 need a logarithmic axis, which says so.
        assert!(screen.contains("error, logarithmic [noise units]"), "{screen}");
    }

    #[test]
    fn a_verdict_is_as_sure_as_it_sounds() {
        let sure = toy();
        assert_eq!(sure.confidence.level, Level::Sure);
        assert!(!html(&sure).contains("if this model is right"));
        let level = |change: &dyn Fn(&mut Outcome)| {
            let mut o = toy();
            change(&mut o);
            o.confidence = Confidence::of(&o);
            let reasons = o.confidence.reasons.join(" ");
            assert!(
                o.confidence.level != Level::Reserved
                    || html(&o).contains("class=\"verdict answer caution\"")
            );
            (o.confidence.level, o.confidence.intervals_conditional, reasons)
        };
        let (tied, conditional, why) = level(&|o| o.indistinguishable = vec![vec!["a".into(), "b".into()]]);
        assert!(tied == Level::Reserved && !conditional && why.contains("a + b"), "{why}");
        let far = |o: &mut Outcome| o.after.as_mut().unwrap().parameters[0].from_nominal = Some(-8.1);
        let (level_far, conditional, why) = level(&far);
        assert!(
            level_far == Level::Reserved && conditional && why.contains("8.1 standard deviations"),
            "{why}"
        );
        let bound = |o: &mut Outcome| o.after.as_mut().unwrap().parameters[1].at_bound = true;
        let (at_bound, _, why) = level(&bound);
        assert!(
            at_bound == Level::Reserved && why.contains("knee/backlash.gap_m ended at its bound"),
            "{why}"
        );
        let (stays, conditional, why) = level(&|o| o.after.as_mut().unwrap().holdout_error = 1.2);
        assert!(stays == Level::Reserved && conditional && why.contains("1.20"), "{why}");
        assert_eq!(level(&|o| o.verdict = OutcomeKind::PartlyExplained).0, Level::Reserved);
        assert_eq!(level(&|o| o.verdict = OutcomeKind::Unexplained).0, Level::Open);
        let without_interval = |o: &mut Outcome| o.after.as_mut().unwrap().parameters[1].at_bound = true;
        let mut o = toy();
        without_interval(&mut o);
        assert!(html(&o).contains("at its bound: no interval") && !html(&o).contains("80.0 ± 0.4 µm"));
    }

    #[test]
    fn the_headline_sentence_has_values_with_their_intervals() {
        assert_eq!(
            set_with_values(&toy()),
            "knee/backlash (gap 80.0 ± 0.4 µm) + knee/coulomb-friction (force 42.1 ± 0.6 N)"
        );
    }

    #[test]
    fn a_curve_beyond_the_catalogue_is_the_last_step() {
        let mut o = toy();
        (o.verdict, o.effects, o.after) = (OutcomeKind::Unexplained, Vec::new(), None);
        o.ladder.truncate(1);
        let curve =
            Curve { over: Over::Speed, times: Factor::One, x: vec![-1.0, 1.0], y: vec![3.0, -3.0], dry: 0.0 };
        o.law = Some(LawSaid {
            effect: "knee/unknown-at-rotor".to_owned(),
            port: "knee/rotor".to_owned(),
            depends_on: "speed".to_owned(),
            beside: Vec::new(),
            holdout_error: 1.26,
            fit_error: 1.02,
            explained: 0.999,
            law: Law {
                id: "unknown-at-rotor".to_owned(),
                place: Some("knee".to_owned()),
                acts_on: "rotor".to_owned(),
                summary: "A curve.".to_owned(),
                curve,
            },
        });
        o.remainder = vec!["It follows the time in the run.".to_owned()];
        o.confidence = Confidence::of(&o);
        let page = html(&o);
        for words in [
            "something at knee/rotor that depends on speed",
            "40.0 noise units on the held-out runs with the base model, 1.26 with the curve",
            "+ knee/unknown-at-rotor",
            "Held-out runs: 40.0 → 1.26 noise units; fit runs: 40.0 → 1.02, with the curve.",
        ] {
            assert!(page.contains(words), "{words} is not in {page}");
        }
        // What the curve takes is described by the curve.
        assert!(!o.confidence.reasons.contains(&o.remainder[0]));
        // A set that the held-out runs prefer is said beside it.
        let rival = Ranked { holdout_error: 1.2, ..o.ranking[0].clone() };
        o.ranking.push(rival);
        let said = Confidence::of(&o).reasons.concat();
        assert!(said.contains("predicted better by") && said.contains("(1.20)"), "{said}");
    }
}
