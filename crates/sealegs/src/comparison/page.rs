//! A comparison as one self-contained page.

use super::Compared;
use super::overlay::{self, Look, worst_run};
use crate::diagnosis::outcome::parameters;
use crate::diagnosis::provenance::Provenance;
use crate::diagnosis::text::{digits_for, figures};
use sealegs_recorder::chart::{Axis, Bar, BarChart, Dash, Hue};
use sealegs_recorder::report::{self, Report, Table, Tone};
use sealegs_sysid::frequency::ChannelResponse;
use sealegs_sysid::locate::Region;
use sealegs_sysid::residual;

/// How the two states of the model are drawn, and the one that is shown.
const AS_GIVEN: Look = ("as given", Hue::Vermillion, Dash::Dashed);
const REFITTED: Look = ("refitted", Hue::Blue, Dash::Solid);
const MODEL: Look = ("model", Hue::Blue, Dash::Solid);

/// The page.
#[must_use]
pub fn of(compared: &Compared, command: &str, provenance: &Provenance) -> String {
    let mut page = Report::new(&format!("{}: where the model fails", compared.campaign.name));
    page.subtitle(&compared.model);
    let error = compared.parts.last().map_or(0.0, |p| p.shown().rms);
    let tone = if error <= 1.1 * compared.floor.max(1.0) { Tone::Good } else { Tone::Bad };
    page.verdict(tone, &compared.sentence(), "");
    let mut numbers = Vec::new();
    for part in &compared.parts {
        let after = part.after.as_ref();
        numbers.push((
            format!("{} runs", part.role.as_str()),
            figures(part.shown().rms, 3),
            match after {
                Some(_) => format!("noise units; {} as given", figures(part.before.rms, 3)),
                None => "noise units, as given".to_owned(),
            },
        ));
    }
    let borrowed: Vec<_> = numbers.iter().map(|(a, b, c)| (a.as_str(), b.as_str(), c.as_str())).collect();
    page.numbers(&borrowed);
    crate::sanity::section(&mut page, &compared.sanity);
    place(&mut page, compared);
    depends(&mut page, compared);
    motion(&mut page, compared);
    responses(&mut page, &compared.responses);
    values(&mut page, compared);
    errors(&mut page, compared);
    remarks(&mut page, &compared.campaign.notes);
    page.provenance(&report::Provenance {
        command: command.to_owned(),
        versions: vec![("sealegs".to_owned(), provenance.version.to_owned())],
        inputs: provenance.inputs.iter().map(|i| (i.file.clone(), format!("sha256:{}", i.sha256))).collect(),
        seed: None,
        notes: vec![("Model".to_owned(), provenance.model.clone())],
    });
    page.to_html()
}

/// Remarks that fit on a page are shown; more of them, as a logger with a bad clock has in each run, open on demand.
const REMARKS_SHOWN: usize = 8;

/// What a person should know of the files.
pub(crate) fn remarks(page: &mut Report, notes: &[String]) {
    if notes.is_empty() {
        return;
    }
    page.section("Remarks on the files");
    if notes.len() <= REMARKS_SHOWN {
        page.list(notes);
    } else {
        page.details(&format!("All {} remarks", notes.len()), |page| {
            page.list(notes);
        });
    }
}

pub(crate) fn place(page: &mut Report, compared: &Compared) {
    page.section("Where it sits");
    let worst = compared.location.worst(5);
    if worst.is_empty() {
        page.paragraph("The residual sits nowhere in particular.");
    } else {
        page.list(&worst.iter().map(|r| r.sentence()).collect::<Vec<_>>());
    }
    let mut axes: Vec<String> = compared.location.regions.iter().map(Region::subject).collect();
    axes.dedup();
    page.details("All regions", |page| {
        for axis in axes {
            let bars = compared.location.regions.iter().filter(|r| r.subject() == axis);
            let chart = BarChart {
                title: format!("By {axis}"),
                axis: Axis::new("share", "%"),
                series: vec![
                    ("of the squared error".to_owned(), Hue::Vermillion),
                    (
                        if axis == "frequency" { "of the bandwidth" } else { "of the samples" }.to_owned(),
                        Hue::Grey,
                    ),
                ],
                bars: bars
                    .map(|r| Bar {
                        label: r.label.clone(),
                        values: vec![100.0 * r.error_share, 100.0 * r.sample_share],
                        text: format!("{} noise units", figures(r.error, 3)),
                    })
                    .collect(),
            };
            page.figure(&chart, &format!("Share of the squared error and of the samples by {axis}."));
        }
    });
}

pub(crate) fn depends(page: &mut Report, compared: &Compared) {
    page.section("What it depends on");
    let mut table = Table::new()
        .words("residual against")
        .numbers("explains", "%")
        .numbers("by chance", "%")
        .words("suggests");
    for t in &compared.tests {
        let on = t.detail.as_ref().map_or_else(|| t.on.to_owned(), |d| format!("{} ({d})", t.on));
        let cells = [
            on,
            figures(100.0 * t.explained, 2),
            figures(100.0 * t.by_chance, 2),
            if t.depends() { t.suggests.to_owned() } else { "nothing".to_owned() },
        ];
        if t.depends() {
            table.strong_row(cells)
        } else {
            table.row(cells)
        };
    }
    page.table(&table, "Share of the squared residual that each dependence explains.");
}

/// Measured and predicted in time, with the residual below, for the worst run of each role.
fn motion(page: &mut Report, compared: &Compared) {
    page.section("Measured and predicted");
    for part in &compared.parts {
        let mut models = vec![(AS_GIVEN, &part.before)];
        models.extend(part.after.as_ref().map(|after| (REFITTED, after)));
        overlay::in_time(page, part, worst_run(part, part.shown()), &models);
    }
}

fn responses(page: &mut Report, responses: &[ChannelResponse]) {
    let drawn: Vec<_> = responses.iter().filter(|r| overlay::is_drawn(r)).collect();
    if drawn.is_empty() {
        return;
    }
    page.section("Frequency responses");
    for r in drawn {
        overlay::in_frequency(page, r, &[(MODEL, &r.predicted)]);
    }
}

fn values(page: &mut Report, compared: &Compared) {
    let Some(fit) = &compared.fit else { return };
    page.section("Parameters");
    let mut table = Table::new()
        .words("parameter")
        .numbers("value", "")
        .numbers("standard error", "")
        .words("unit")
        .numbers("nominal", "")
        .words("remark");
    for (p, v) in fit.parameters.iter().zip(parameters(fit)).filter(|(p, _)| !p.fixed) {
        table.row([
            p.name.clone(),
            figures(v.value, digits_for(v.value, p.std)),
            figures(p.std, 2),
            p.unit.clone(),
            figures(p.nominal, 6),
            v.remark(),
        ]);
    }
    page.table(&table, "The model's own parameters after the refit.");
    if fit.std_inflation > 1.5 {
        page.remark(
            "The residual is not noise. Standard errors follow from how far stretches of the runs disagree; they \
             say how far the values would wander under the same wrong model, not how far they are from the truth.",
        );
    }
    let mut table = Table::new()
        .words("sensor")
        .numbers("gain", "")
        .numbers("bias", "")
        .words("unit")
        .numbers("runs scatter by", "");
    for s in fit.sensors() {
        let gain = if s.gain_at_limit { format!("{:.4} (limit)", s.gain) } else { format!("{:.4}", s.gain) };
        table.row([
            s.channel.clone(),
            gain,
            figures(s.bias, 3),
            super::text::unit(&s.channel).to_owned(),
            figures(s.bias_spread, 2),
        ]);
    }
    page.table(&table, "Sensors: measured = gain x true + bias.");
}

fn errors(page: &mut Report, compared: &Compared) {
    page.section("By run and channel");
    let mut table = Table::new()
        .words("run")
        .words("role")
        .words("channel")
        .numbers("error", "noise units")
        .numbers("of signal", "%")
        .numbers("rms", "")
        .words("unit");
    for l in compared.parts.iter().flat_map(|p| residual::table(&p.data, p.shown())) {
        table.row([
            l.run,
            l.role.as_str().to_owned(),
            l.channel.clone(),
            figures(l.error, 4),
            figures(l.percent, 3),
            figures(l.rms, 3),
            super::text::unit(&l.channel).to_owned(),
        ]);
    }
    page.table(&table, "Errors of every run and channel.");
}
