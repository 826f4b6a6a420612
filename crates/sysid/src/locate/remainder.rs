//! What a model leaves, described: its frequency, what it follows, and where it is largest.

use super::{Location, Region, band, locate, short};
use crate::data::{Data, Evaluation};
use crate::structure;

/// Share of the squared residual whose band is named.
const MOST: f64 = 0.5;

/// A dependence that explains less of the squared residual is not worth a sentence.
const WORTH_SAYING: f64 = 0.05;

/// Regions in a description.
const REGIONS: usize = 2;

/// Describes what is left in one or several evaluations, in sentences, the widest statement first; none where the
/// residual is at the noise floor.
#[must_use]
pub fn remainder(parts: &[(&Data, &Evaluation)]) -> Vec<String> {
    let location = locate(parts);
    if location.error < Location::NOTHING_LEFT {
        return Vec::new();
    }
    let mut said = Vec::new();
    if let Some((from, to)) = band::narrowest(parts, MOST) {
        said.push(format!("Half of the residual lies between {} and {} Hz.", short(from), short(to)));
    }
    let tests = structure::tests(parts);
    let follows = tests.iter().filter(|t| t.on != structure::OWN_PAST && t.depends());
    let strongest = follows.max_by(|a, b| a.explained.total_cmp(&b.explained));
    match strongest.filter(|t| t.explained > WORTH_SAYING) {
        Some(t) => {
            let detail = t.detail.as_ref().map_or_else(String::new, |d| format!(" ({d})"));
            said.push(format!(
                "It follows the {}{detail}: {:.0} % of its square.",
                t.on,
                100.0 * t.explained
            ));
        }
        None => {
            said.push("It follows none of input, speed, load, deflection, rotor angle and time.".to_owned())
        }
    }
    let places = |r: &&&Region| !matches!(r.axis, "frequency" | "run");
    let worst = location.worst(usize::MAX);
    said.extend(worst.iter().filter(places).take(REGIONS).map(|r| r.sentence()));
    said
}
