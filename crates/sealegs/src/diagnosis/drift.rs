//! What is said where a joint under a force drifts away from its log in open loop: cut into pieces that begin at the measured
//! state, the same log tells what its forces are; and a robot's named model may have been fitted to such pieces.

use super::outcome::Side;
use sealegs_model::{Model, Unit};
use sealegs_sysid::data::Evaluation;
use sealegs_sysid::fit::{self, FitOptions};
use sealegs_sysid::{Campaign, Data, Role, residual, stats};

/// Share of a position's own standard deviation that a model leaves of it from which on it has gone astray: the error of a
/// motion that a force drives grows with the square of the time, and soon says little of the force.
const ASTRAY: f64 = 0.2;

/// The same where the model diverges: what it leaves is more than the motion itself.
const FAR_ASTRAY: f64 = 1.0;

/// Integration steps per sampling period of such a look.
const STEPS_PER_SAMPLE: f64 = 4.0;

/// Pieces that the longest run is proposed to be cut into, and the shortest one, s.
const PIECES: (f64, f64) = (10.0, 0.5);

/// The same pieces where the model diverges, as a share of these, and the shortest of them, s: in 0.3 s the error of an arm that stands
/// upright grows some tenfold, from what its start is known within to a few times the noise.
const FAR_SHORTER: f64 = 0.5;
const FAR_SHORTEST_S: f64 = 0.3;

/// Fewest rows of such a piece: the first ones tell its start. At 100 Hz pieces of 30 rows left 28 noise units after a bad start.
const FAR_ROWS: f64 = 50.0;

/// Pieces that the longest run must make to be worth cutting: fewer are hardly shorter than the runs that its user gave, or than
/// pieces that it was cut into before.
const FEWEST_PIECES: f64 = 5.0;

/// A length of pieces as a sentence says it, to a tenth of a second.
fn as_said(piece_s: f64) -> f64 {
    (10.0 * piece_s).round() / 10.0
}

/// The fit runs, and a model that is simulated with longer steps.
struct Look<'a> {
    campaign: &'a Campaign,
    data: Data<'a>,
    coarse: Box<dyn Model>,
}

impl<'a> Look<'a> {
    fn of(campaign: &'a Campaign, model: &dyn Model) -> Option<Self> {
        let coarse = model.coarser(STEPS_PER_SAMPLE);
        let data =
            campaign.bench.may_begin_in_motion().then(|| Data::new(campaign, Some(Role::Fit), model))?;
        Some(Self { campaign, data: data.ok()?, coarse })
    }

    /// How far the model goes astray with its own values, where it misses by more than a joint moves.
    fn as_it_stands(&self) -> Option<Astray> {
        let values: Vec<f64> = self.coarse.parameters().iter().map(|p| p.value).collect();
        self.far_astray(&self.data.evaluate(self.coarse.as_ref(), &values).ok()?)
    }

    /// How far a model goes astray that misses by more than a joint moves, where the runs are long enough to be cut.
    fn far_astray(&self, at: &Evaluation) -> Option<Astray> {
        let left = residual::by_channel(&self.data, at);
        let astray =
            Astray::of(self.campaign, Role::Fit, left.iter().map(|of| (of.channel.as_str(), of.rms)))?;
        let periods = self.campaign.runs_of(Role::Fit).map(|run| run.record.mean_period_s());
        let shortest_s = FAR_SHORTEST_S.max(FAR_ROWS * periods.fold(0.0, f64::max));
        let piece_s = as_said((astray.piece_s * FAR_SHORTER).max(shortest_s));
        (astray.share > FAR_ASTRAY && astray.is_worth_cutting()).then_some(Astray { piece_s, ..astray })
    }
}

/// How far a joint goes astray in open loop.
pub(crate) struct Astray {
    /// The channel that is furthest astray.
    channel: String,
    /// What is left of what it does, as a share of its standard deviation.
    pub share: f64,
    /// Length of the pieces that the runs are proposed to be cut into, s.
    pub piece_s: f64,
    /// The longest fit run, s.
    longest_s: f64,
}

impl Astray {
    /// Of the root mean square errors by channel on the runs of a role, in the channels' units; `None` where no position is astray.
    pub(crate) fn of<'a>(
        campaign: &Campaign,
        role: Role,
        left: impl IntoIterator<Item = (&'a str, f64)>,
    ) -> Option<Self> {
        if !campaign.bench.may_begin_in_motion() {
            return None;
        }
        let astray = |(channel, rms): (&'a str, f64)| {
            let is_position = matches!(Unit::of_channel(channel), Ok(Unit::Metre | Unit::Radian));
            let runs = campaign.runs_of(role);
            let values = runs.filter_map(|run| Some(&run.record.output(channel)?[run.scored.clone()]));
            let motion = stats::std(&values.flatten().copied().collect::<Vec<f64>>());
            (is_position && motion > 0.0).then(|| (channel, rms / motion))
        };
        let furthest = left.into_iter().filter_map(astray);
        let (channel, share) =
            furthest.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, share)| *share > ASTRAY)?;
        let longest_s = campaign.runs_of(Role::Fit).map(|run| run.record.duration_s()).fold(0.0, f64::max);
        let piece_s = as_said((longest_s / PIECES.0).max(PIECES.1));
        Some(Self { channel: channel.to_owned(), share, piece_s, longest_s })
    }

    /// Of a model as it stands, on the fit runs, where they are long enough to be cut: a refit of what diverges takes long and
    /// says little.
    pub(crate) fn before_a_fit(campaign: &Campaign, model: &dyn Model) -> Option<Self> {
        Look::of(campaign, model)?.as_it_stands()
    }

    /// The same of one that diverges as it stands, once it was refitted.
    pub(super) fn after_a_fit(campaign: &Campaign, model: &dyn Model) -> Option<Self> {
        let look = Look::of(campaign, model)?;
        look.as_it_stands()?;
        let options = FitOptions { starts: 1, ..FitOptions::of(look.coarse.as_ref()) };
        look.far_astray(&fit::fit(&look.data, look.coarse.as_ref(), &options).ok()?.evaluation)
    }

    /// Whether the runs are long enough to be cut.
    pub(super) fn is_worth_cutting(&self) -> bool {
        self.longest_s >= FEWEST_PIECES * self.piece_s
    }

    /// How far, in a sentence.
    fn said(&self) -> String {
        let within = match self.is_worth_cutting() {
            true => "In open loop".to_owned(),
            false => format!("Within the {:.1} s of a run", self.longest_s),
        };
        format!(
            "{within} the model diverges: it leaves {:.0} % of {} unexplained.",
            100.0 * self.share,
            self.channel
        )
    }

    /// What to do about it, if anything can be done.
    pub(crate) fn advice(&self) -> String {
        if !self.is_worth_cutting() {
            return self.said();
        }
        format!(
            "{} `window_s = {:.1}` in the campaign cuts its runs into pieces that each begin at the measured state.",
            self.said(),
            self.piece_s
        )
    }

    /// What was done about it.
    pub(super) fn cut(&self) -> String {
        format!(
            "{} The runs were therefore cut into pieces of {:.1} s that each begin at the measured state; all results are for these \
             pieces. Set `window_s = {:.1}` in the campaign to have `compare` and `add` do the same.",
            self.said(),
            self.piece_s,
            self.piece_s
        )
    }
}

/// A sentence where the named set leaves more of the fit runs than the base model does, and less of the held-out ones.
pub(super) fn fitted(base: &Side, after: &Side) -> Option<String> {
    (after.fit_error > base.fit_error && after.holdout_error < base.holdout_error).then(|| {
        format!(
            "The named model was fitted to short pieces of the runs, because its values then predict left-out runs best. In open \
             loop the base model, fitted to whole runs, fits the fit runs better ({:.0} noise units, the named one {:.0}).",
            base.fit_error, after.fit_error
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use sealegs_sysid::campaign::{Bench, RunColumns};
    use std::f64::consts::TAU;

    #[test]
    fn a_joint_that_goes_astray_is_to_be_cut_into_pieces_and_one_that_follows_is_not() {
        let time_s: Vec<f64> = (0..2000).map(|i| 0.01 * f64::from(i)).collect();
        let run = |role| {
            let position: Vec<f64> = time_s.iter().map(|t| 0.1 * (TAU * t / 5.0).sin()).collect();
            let columns =
                [("time_s", time_s.clone()), ("motor_force_n", position.clone()), ("position_m", position)];
            RunColumns::new(role, if role == "fit" { Role::Fit } else { Role::Holdout }, columns)
        };
        let on = |bench| {
            let built = Campaign::builder("lift", bench, "rigid-linear").run(run("fit")).run(run("held out"));
            built.build().expect("a campaign")
        };
        let left = |rms: f64| ("position_m", rms);
        // The standard deviation of a sine is its amplitude over the root of 2: 71 mm.
        let astray = |bench, rms| Astray::of(&on(bench), Role::Holdout, [left(rms)]);
        let half = astray(Bench::Free, 0.0354).expect("half of it is left");
        let said = half.advice();
        assert!(half.is_worth_cutting() && half.cut().contains("pieces of 2.0 s"));
        assert!(said.contains("leaves 50 %") && said.contains("window_s = 2.0"), "{said}");
        let again = on(Bench::Free).cut_into(half.piece_s);
        let piece = Astray::of(&again, Role::Holdout, [left(0.0354)]).expect("half of it is left").advice();
        assert!(piece.starts_with("Within the 2.0 s of a run") && !piece.contains("window_s"), "{piece}");
        assert!(astray(Bench::Free, 0.01).is_none() && astray(Bench::Locked, 0.0354).is_none());
    }

    #[test]
    fn a_named_model_that_leaves_more_of_the_fit_runs_only_is_explained() {
        let toy = super::super::toy::toy();
        let (base, after) = (toy.base.clone(), toy.after.clone().expect("a named model"));
        assert_eq!(fitted(&base, &after), None);
        let worse = Side { fit_error: 2.0 * base.fit_error, ..after };
        let said = fitted(&base, &worse).expect("a sentence");
        assert!(said.contains("(40 noise units, the named one 80)"), "{said}");
    }
}
