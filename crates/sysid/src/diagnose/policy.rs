//! Every threshold of a diagnosis, each with where it comes from; a verdict's provenance lists them all.

/// Declares the thresholds and the table that lists them.
macro_rules! policy {
    ($($(#[doc = $doc:literal])+ $name:ident = $value:expr;)+) => {
        $($(#[doc = $doc])+ pub(crate) const $name: f64 = $value;)+

        /// The thresholds by name, with their values and their reasons.
        #[must_use]
        pub fn policy() -> Vec<(&'static str, f64, &'static str)> {
            vec![$((stringify!($name), $value, concat!($($doc),+).trim_ascii())),+]
        }
    };
}

policy! {
    /// Error over the noise floor up to which nothing more is searched: a stated noise is rounded, and an encoder's
    /// quantum is not quite white.
    AT_FLOOR = 1.01;
    /// The same on left-out stretches, where every parameter costs a little.
    NEAR_FLOOR = 1.05;
    /// Error over the floor on held-out runs up to which a model is adequate: 5 % more than the noise is what a stated
    /// noise of one digit can be off.
    ADEQUATE = 1.05;
    /// Error over the floor on held-out runs up to which effects explain everything: what the fitted values' own
    /// uncertainty adds on runs of other amplitudes.
    EXPLAINED = 1.25;
    /// Mean square above the floor on held-out runs, in units of what the uncertainty of the fitted values makes one
    /// expect, up to which it says nothing against the model; few directions make most of it.
    WITHIN_UNCERTAINTY = 3.0;
    /// Share of the base model's held-out error above the floor that an effect must take to be named; the contract's.
    NAMED_SHARE = 0.01;
    /// Share of the base model's held-out error above the floor that may stay under the verdict `missing-effect`; the
    /// contract's.
    LEFT_SHARE = 0.01;
    /// Share of the missing energy on held-out runs that a set must take to be named where much stays: less is within
    /// what flexible laws take of anything.
    WORTH_NAMING = 0.25;
    /// The same from which on it is named even if one held-out run gains nothing.
    MOST_OF_IT = 0.5;
    /// Share of the missing energy that a set leaves on held-out runs over the share that it leaves on fit runs, beyond
    /// which it is overfitted to them.
    HOLDS_UP = 3.0;
    /// Share that it may leave on held-out runs in any case.
    LITTLE_LEFT = 0.1;
    /// How many times less than the best set of known effects a curve must leave on left-out stretches for that set not to
    /// be named: half the error. Laws of one family (a step, a root, a line over the speed) do not differ by less.
    CURVE_BEATS = 4.0;
    /// Share of the missing energy that a curve may leave and still explain so much that no further effect is searched: twelve
    /// straight pieces leave that of a spring with a kink.
    CURVE_LEAVES = 0.05;
    /// Share of what the best single effect leaves that a further one, or a pair, must promise beside it to be fitted before a
    /// curve is looked for: what is not in the catalogue is promised by nothing in it.
    PROMISES_MOST = 0.8;
    /// Share of what a set leaves under the observer that an effect or a pair must promise beside it for it to grow there: a
    /// resonance that starts beside its frequency promises a seventh of what it takes.
    PROMISES_ON = 0.1;
    /// Share of the motor's force that a curve at the drive may take: beyond it the curve takes the command away, and bodies
    /// without mass explain the rest. An estimate: a drive that loses half of its force is seen without any model.
    MOST_LOST = 0.5;
    /// Share of what a curve over the speed predicts that the direction of motion must predict by itself for that curve to
    /// be dry friction: in a sinusoidal motion it predicts 0.914 of a force that grows with the root of the speed.
    DRY_MOSTLY = 0.95;
    /// Force of an ordinate of a curve when it is screened, as a share of what the port lacks or its noise leaves: small enough
    /// that a rotor does not stick for it.
    CURVE_UNIT = 0.05;
    /// Ratio in what a curve promises that is worth moving its knots: chance gives two more of them less.
    KNOTS_WORTH_MOVING = 1.02;
    /// Curves that are fitted under the observer, beside the best one of each place where they may act: three dependences of
    /// each of two ports.
    CURVES = 6.0;
    /// The same where a simulation is dear.
    CURVES_DEAR = 2.0;
    /// Of them those that are fitted in open loop, beside the best one of each place, too.
    CURVES_FITTED = 2.0;
    /// Least gain in the mean squared residual, in squared floors, that is worth an effect: two integrators of the same
    /// physics differ by that.
    WORTH_SQUARED_NOISE = 0.006;
    /// Least share of what is unexplained on left-out stretches that is worth an effect: one standard error of a mean
    /// over some thirty independent stretches.
    WORTH_SHARE = 0.03;
    /// The same of what a fit leaves, which is known better.
    WORTH_SHARE_FITTED = 0.05;
    /// Least gain in the sum of squares per further parameter, in units of the mean squared residual: a likelihood
    /// ratio that chance passes once in 10 000 for each of some hundred laws and places tried.
    WORTH_PER_PARAMETER = 15.0;
    /// Most samples of a residual that remembers which count as one: a longer memory is known from too few stretches.
    MOST_MEMORY = 1000.0;
    /// Share of what is gained on some left-out stretches that may be lost on others.
    MOST_OPPOSED = 0.4;
    /// Standard errors within which the amplitude of a member of a set that leaves something must not hold zero: 95 %.
    KNOWN_FROM_ZERO = 1.96;
    /// Cost over the chosen set's above which a set is no tie, whatever is predicted.
    TIED_COST = 1.1;
    /// Times that what a last fit frees starts again on either side of where it was fitted: each goes two fifths of the way.
    FREED_ROUNDS = 3.0;
    /// Fall of the cost below which it does not start again: half a squared standard error.
    NOTHING_MORE = 0.5;
    /// Parts of the fit runs that are left out one at a time where a set is fitted again without them: with three the others are
    /// still two thirds of what is known.
    FOLDS = 3.0;
    /// Integration steps of an actuator after which sets only grow, up to pairs, and no further looks are taken: half as many again as
    /// until the latest of 66 right sets was found, three effects at once on a pendulum (0.98e9; half of all were found within 0.1e9).
    LONG_SEARCH = 1.5e9;
    /// Members of a set that is grown under the observer alone: what leaves something with as many is searched in open loop.
    SEEN_TOGETHER = 3.0;
    /// Error over the floor under the observer up to which a set may explain everything, and is fitted in open loop; or it
    /// leaves a hundredth of what the base model leaves there. Fits under the observer end near their minimum, not in it.
    MAY_EXPLAIN = 2.0;
    /// Members of a set beyond which what is screened badly is fitted alone first: it may explain what three others do not.
    PAIR = 2.0;
    /// Times that members are exchanged and taken out in turn: what a second time changes is rare.
    EXCHANGES = 2.0;
    /// Rivals of a member that are fitted at its port, and at others: a family of laws of friction has no more in common.
    RIVALS = 3.0;
    /// Rivals of a member of a set that leaves something that are fitted from every start: of four laws of dry friction the right
    /// one had left 2 % more than the least.
    FROM_EVERY_START = 4.0;
    /// Effects of the screening in open loop that are fitted: a simulation there is dear, and a faulty sensor stands out.
    OPEN_LOOP = 4.0;
    /// Effects in a set: a rig with more unknowns needs other experiments first.
    MOST_EFFECTS = 4.0;
    /// Starting values of an effect in the first look of the screening.
    STARTS = 16.0;
    /// The same on a model with many parameters, where a simulation is dear.
    STARTS_DEAR = 6.0;
    /// Single effects that are fitted beside a set.
    SHORTLIST = 10.0;
    /// Those of them that are fitted whatever they promise: a resonance that starts beside its frequency promises a seventh of
    /// what it takes.
    ANYHOW = 3.0;
    /// Share of the greatest promise below which no other one is fitted beside effects: a regression that is wrong by a
    /// factor of ten does not make it the best.
    PROMISES_LITTLE = 0.05;
    /// Pairs that are fitted beside a set.
    SHORTLIST_PAIRS = 4.0;
    /// Effects that may be half of a pair, by what each promises alone.
    PAIRED = 14.0;
    /// Share of what is left that a pair must promise beyond its better half.
    PAIR_WORTH = 0.1;
    /// Share of what the best single effect takes from which another one is fitted from many starts, too, with every effect
    /// at another port, where nothing is known of a base parameter: alone, all members of a family of laws take as much.
    SCATTERED = 0.5;
    /// Greatest ratio of such a start to the stated value, up or down: what is stated without a tolerance is an order of
    /// magnitude.
    SCATTERED_RATIO = 10.0;
    /// Steps of a fit under the observer, which leads to the neighbourhood of the solution.
    OBSERVED_STEPS = 8.0;
    /// The first of them, after which the sets that may still be the best go on alone.
    RACE_STEPS = 3.0;
    /// Cost over the best set's after them up to which a set goes on: three steps take a cost to a third of itself where
    /// they take it anywhere.
    RACED = 4.0;
    /// A part of what a linear regression promises of an effect, from which a fit starts where that leaves less.
    WEAKER = 0.3;
    /// Times that what a linear regression promises of an effect is simulated, as strong as the time before promised it to
    /// help most, or half as strong: four halvings lead from the widest start of play to the next one.
    LOOKS = 5.0;
    /// Share of the greatest promise below which an effect is not looked at again, if there are enough others: a resonance that
    /// starts beside its frequency promises a seventh of what it takes, and what takes little beside the best is seen once that
    /// is in the model.
    LOOKED_AT_AGAIN = 0.02;
    /// Ratio of strengths within which a promise is held: a fit goes the rest of the way in a step.
    PROMISE_HELD = 1.25;
    /// Share of a promised fall that a simulation must show for the promise to be followed on: a parabola that is off by
    /// less than half still points the right way.
    PROMISE_KEPT = 0.5;
    /// What an effect is weakened by where its promise was broken: a bisection.
    HALF_AS_STRONG = 0.5;
    /// Relative difference of two falls of the cost below which two strengths show the same, as of a gap that is wide open:
    /// far above rounding, far below what tells starts apart.
    LOOKS_ALIKE = 1e-3;
    /// Times that an effect is weakened before a fit in open loop: together they lead as far as a promise may be off.
    WEAKENINGS = 4.0;
    /// The same under the observer: they lead from the widest promise to a tenth of it.
    WEAKENINGS_OBSERVED = 10.0;
    /// By how much each time: play that is wide open under an observer has an end.
    SLIGHTLY_WEAKER = 0.8;
    /// Steps of a fit in the search.
    STEPS = 20.0;
    /// The same where a simulation is dear: the best of them is fitted on.
    STEPS_DEAR = 5.0;
    /// Most steps with the model itself where derivatives are dear: a delay of a joint that follows a clock's skew takes a dozen.
    DEAR_STEPS = 20.0;
    /// Standard deviations of what is known of a base parameter beyond which a last fit starts again there, where derivatives
    /// are dear: 95 %.
    FAR_FROM_KNOWN = 2.0;
    /// Standard error of a parameter over its stated standard deviation from which on a last fit looks along its profile:
    /// data that say ten times as much as what was stated have found the value.
    HARDLY_KNOWN = 0.1;
    /// What counts as stated of an effect's parameter, as a share of its value: catalogues guess within a factor of two.
    EFFECT_STATED = 0.5;
    /// Gain of a step of a fit along a profile with which it is content, in cost: a fifth of what ends an interval of one
    /// standard error.
    PROFILE_TOLERANCE = 0.1;
    /// Times that a last fit goes on from the lowest place of such profiles: each leads to where another one is lower.
    PROFILE_ROUNDS = 2.0;
    /// Distance of the places of a profile, in standard errors: the error of a value that is known as well as its curvature
    /// says is four times that of a standard error there.
    PROFILE_STEP = 2.0;
    /// The widest distance, in stated standard deviations: ten places over what is known.
    PROFILE_WIDEST = 0.5;
    /// How far a profile leads from the nominal value, in the same: 99 %.
    PROFILE_TO = 2.5;
    /// Places of a profile to either side: as far as twenty standard errors.
    PROFILE_PLACES = 10.0;
    /// Cost over the lowest beyond which a profile ends: that of the third place where a value is known as well as its curvature
    /// says.
    PROFILE_HEIGHT = 10.0;
    /// How far another one's profile must have led a value, in standard errors, for it to need none of its own: as far as
    /// its own would have.
    FOLLOWED = 4.0;
    /// Most steps of a last fit with half the integrator's steps: the first corrects the values, the second that.
    HALF_STEPS = 3.0;
    /// Most steps of a fit of the beginnings of the runs: it leads to the neighbourhood of the solution.
    HORIZON_STEPS = 10.0;
    /// Ratio of how far a value goes until as much more is left as is left, to how far the curvature says, from which on the
    /// error is rugged: a law that bends is off by less.
    RUGGED = 5.0;
    /// Windows of a run, where an error in open loop grows or adds up: short beside the swing of a link (a second, in runs of
    /// ten), so that an error is nearly linear in what is missing and where friction sticks hardly depends on what came
    /// before. On two pendulums with dry friction 160 and 240 order sets alike, 40 rests in other minima for each start.
    WINDOWS = 160.0;
    /// Integration steps per sampling period in the search; what it finds is fitted again with the model itself.
    STEPS_PER_SAMPLE = 4.0;
    /// The same in screening.
    SCREEN_STEPS_PER_SAMPLE = 2.0;
    /// Mean squared error of the search's steps, as a share of what a set leaves above the floor, from which on the search
    /// goes on with the model's own, or the set grows no further where these are the model's own.
    STEP_SHARE = 0.25;
    /// How far an amplitude is trusted beyond the value that was simulated.
    FARTHEST = 3.0;
    /// Least share of the value that was simulated with which a fit starts: closer to nothing a search would not leave it.
    NEAREST = 0.2;
    /// Share of what a set leaves above the floor that the best one found under the observer must leave for a look in open loop:
    /// with half of it taken the next round has less beside it to hide what it looks for.
    OPEN_LOOP_WORTH = 0.5;
    /// Share of the mean square that the base model leaves below which a set leaves a trace only: other sets are then
    /// fitted as rivals of it and no more.
    TRACE = 1e-4;
    /// Cost under the observer over the best set's up to which a set is fitted in open loop as its rival.
    RIVAL_COST = 1.5;
    /// Cost under the observer over that of a set that explains everything from which on a set without one of its members
    /// needs no fit in open loop to be told worse.
    NEEDED_COST = 3.0;
    /// Cost in open loop over that under the observer from which on a run drifts: ten times the error. Where both leave the
    /// noise they are alike, and a motion that is bounded keeps an error within a few times what the observer lets stand.
    DRIFTS = 100.0;
    /// Sets that are fitted in open loop in any case, by their cost under the observer.
    LEADERS = 2.0;
    /// The same where the leaders do not explain what is missing.
    FOLLOWERS = 8.0;
    /// The same where a simulation is dear.
    FOLLOWERS_DEAR = 4.0;
    /// Cost under the observer over the least up to which a set is fitted in open loop however many there are: the observer
    /// forgives much, and its fits end within some per cent of their minimum. Of five laws of dry friction at a leg's hip the
    /// right one cost 3 % more than the least.
    ALIKE_COST = 1.1;
    /// Missing signal over its uncertainty from which on a port is said to lack something.
    PORT_FELT = 2.0;
    /// Error over the floor, fitted under the observer, up to which the base parameters are where they should be: what is
    /// missing is then smaller than what wrong stated values would show.
    LITTLE_SEEN = 2.0;
    /// Rows of a free-form regression, each the mean of neighbours: the noise of a missing force is fast, what depends on a
    /// signal of the machine is slow, and over some 20 ms of a run at 1 kHz a friction of a tenth of that noise stands out.
    CURVE_ROWS = 2000.0;
    /// Rows of the power of a missing force along the screw: some ten of the shortest of a thousand waves.
    PERIOD_ROWS = 10_000.0;
    /// Distance of the periods that it is taken at, in waves along the travel: a quarter turns no crest into a trough.
    WAVES_APART = 0.25;
    /// Periods of the greatest power that are simulated.
    PERIODS = 4.0;
    /// Size of a wave along the screw when its signature is simulated, as a share of the law that it is looked for beside: small
    /// enough that a rotor sticks no longer for it.
    SLIGHT_WAVE = 0.1;
    /// Frequencies of the greatest power of what is left at which a resonance starts: the residual beside a fitted model has
    /// its lobes on either side of it.
    RESONANCES = 3.0;
    /// Ratio of the frequencies that the power is taken at: the half width of a mode of 4 %.
    RESONANCES_APART = 1.04;
    /// The lowest of them, Hz: a run of some ten seconds holds ten of its periods.
    LOWEST_HZ = 1.0;
    /// Cycles per turn of the rotor that are simulated where a simulation is dear, of all those that have the greatest power: a
    /// ripple that noise puts behind a quarter of them is not seen by a fit either.
    CYCLES = 12.0;
    /// Rows of a picture: more add correlated samples only.
    DRAWN_ROWS = 6000.0;
    /// Blocks that are left out one at a time in a free-form regression.
    CURVE_BLOCKS = 10.0;
    /// Held-out share of a missing signal from which on a dependence is said.
    DEPENDS = 0.1;
    /// Gain in held-out share that a richer dependence must bring over a simpler one.
    RICHER = 0.02;
}

#[cfg(test)]
mod tests {
    use super::policy;

    #[test]
    fn every_threshold_has_a_reason() {
        let all = policy();
        assert!(all.len() > 20 && all.iter().all(|(_, value, why)| value.is_finite() && why.len() > 20));
    }
}
