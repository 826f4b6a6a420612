//! What is said of a missing signal: at which port, on what it depends, and its curve.

use schemars::JsonSchema;
use sealegs_sysid::diagnose::{MissingForce, Port};
use serde::Serialize;

/// The signal that is missing at a port.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct MissingSignal {
    /// `rotor`, `spring`, `output`, `sensor/CHANNEL`; with its place before it on a leg.
    pub port: String,
    /// Its unit.
    pub unit: String,
    /// Root mean square.
    pub rms: f64,
    /// Root mean square that the sensors' noise alone would leave.
    pub uncertainty: f64,
    /// Whether it is more than noise.
    pub felt: bool,
    /// What it depends on, the best first: those that predict nearly as much as the best, the simplest of them first.
    pub depends_on: Vec<String>,
    /// Share of it above the noise that the first predicts on left-out blocks of the fit runs.
    pub explained: f64,
    /// All dependences with their shares.
    pub shares: Vec<Share>,
    /// The first's curve, where it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub curve: Option<CurveSaid>,
}

/// A dependence with its share.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Share {
    /// On what.
    pub on: String,
    /// Share predicted on left-out blocks.
    pub explained: f64,
}

/// A missing signal over what it depends on.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct CurveSaid {
    /// The abscissa.
    pub over: String,
    /// What the curve is multiplied by: `1`, `direction`, `deflection` or `command`.
    pub times: String,
    /// Abscissas.
    pub x: Vec<f64>,
    /// Ordinates, in the port's unit.
    pub y: Vec<f64>,
    /// One standard error of each.
    pub std: Vec<f64>,
}

/// A missing force, or what a sensor shows too much, in bins of what it depends on.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ForceSaid {
    /// The port, as in [`MissingSignal::port`].
    pub port: String,
    /// The unit of the ordinates.
    pub unit: String,
    /// The dependence, as in [`MissingSignal::depends_on`].
    pub depends_on: String,
    /// The abscissa in words.
    pub over: String,
    /// Its unit.
    pub over_unit: String,
    /// What the ordinates were divided by: `1`, `direction`, `deflection` or `command`.
    pub divided_by: String,
    /// Root mean square that the sensors' noise alone would leave, in the port's unit.
    pub noise: f64,
    /// Share of the port's mean square that the named effects give; none where nothing is named.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub explained_by_law: Option<f64>,
    /// The bins; two branches where it matters whether the abscissa grows or shrinks.
    pub branches: Vec<BranchSaid>,
}

/// Bins that belong to one line; all lists are of one length.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct BranchSaid {
    /// `growing` or `shrinking`; empty for the only branch.
    pub label: String,
    /// Mean abscissas, ascending.
    pub x: Vec<f64>,
    /// Means of what is missing.
    pub y: Vec<f64>,
    /// One standard error of each.
    pub std: Vec<f64>,
    /// What the named effects give there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub law: Option<Vec<f64>>,
}

impl ForceSaid {
    /// What is said of a missing force.
    #[must_use]
    pub fn of(force: &MissingForce) -> Self {
        let branch = |b: &sealegs_sysid::diagnose::Branch| BranchSaid {
            label: b.label.to_owned(),
            x: b.bins.iter().map(|b| b.x).collect(),
            y: b.bins.iter().map(|b| b.y).collect(),
            std: b.bins.iter().map(|b| b.std).collect(),
            law: b.bins.iter().map(|b| b.law).collect(),
        };
        Self {
            port: force.port.clone(),
            unit: force.unit.clone(),
            depends_on: force.on.clone(),
            over: force.over.clone(),
            over_unit: force.over_unit.clone(),
            divided_by: force.times.to_owned(),
            noise: force.noise,
            explained_by_law: force.by_law,
            branches: force.branches.iter().map(branch).filter(|b| !b.x.is_empty()).collect(),
        }
    }

    /// That of the first of some ports that has one.
    #[must_use]
    pub fn of_ports(ports: &[Port]) -> Option<Self> {
        ports.iter().find_map(|p| p.force.as_ref()).map(Self::of)
    }
}

/// Shares that are this near to the best one's are said as well.
const NEARLY: f64 = 0.05;

impl MissingSignal {
    /// What is said of a port.
    #[must_use]
    pub fn of(port: &Port) -> Self {
        let (missing, depends) = (&port.missing, &port.depends);
        let best = depends.iter().map(|d| d.explained).fold(0.0, f64::max);
        let near = depends.iter().filter(|d| d.explained > best - NEARLY);
        Self {
            port: missing.name(),
            unit: missing.unit.clone(),
            rms: missing.rms,
            uncertainty: missing.std,
            felt: missing.is_felt(),
            depends_on: near.map(|d| d.on.to_owned()).collect(),
            explained: depends.first().map_or(0.0, |d| d.explained),
            shares: depends.iter().map(|d| Share { on: d.on.to_owned(), explained: d.explained }).collect(),
            curve: depends.first().and_then(|d| d.curve.as_ref()).map(|c| CurveSaid {
                over: c.over.clone(),
                times: c.times.to_owned(),
                x: c.x.clone(),
                y: c.y.clone(),
                std: c.std.clone(),
            }),
        }
    }
}
