//! What a campaign's columns say of a robot beside its file: which joints stand still, and which are of another kind than the drive
//! of all.

use crate::{Error, Result};
use sealegs_actuator::text::nearest;
use sealegs_actuator::{ActuatorSpec, Kind};
use sealegs_leg::bench::RobotFile;
use sealegs_leg::robot::{Joint, JointKind, Robot};
use sealegs_model::Signal;
use sealegs_sysid::Campaign;
use std::collections::{BTreeMap, BTreeSet};

/// Joints that a remark names.
const NAMED: usize = 6;

/// Columns of a joint that sensors show.
const MEASURED: [&str; 5] = ["angle_rad", "speed_rad_s", "position_m", "speed_m_s", "motor_angle_rad"];

/// Its angles that its limits bound, measured and wanted.
const ANGLES: [&str; 2] = ["angle_rad", "position_rad"];

/// An angle beyond this is in degrees, rad, where it is also beyond so many times its joint's limits: no drive turns a joint so far
/// through its stops.
const IN_DEGREES: f64 = 20.0;
const BEYOND: f64 = 3.0;

/// Share of the widest motion of a joint of its kind below which one stands still: a brake, or a loop that holds it, lets it move by
/// steps of its encoder.
const STILL: f64 = 1e-3;

/// A robot's file with what the campaign's columns say beside it. Joints whose columns stand still in every run, or that no column
/// of any run belongs to and of which the file says nothing, a hand or wheels, stand still, and a joint of another kind than the
/// drive of all gets one of its own, each with a remark. The columns of what stands still leave the campaign.
pub(crate) fn completed(campaign: &mut Campaign, mut file: RobotFile) -> RobotFile {
    // Whatever is wrong with the URDF is said where the model is made of it.
    let Ok(robot) = Robot::load(&file.urdf().display().to_string(), None) else { return file };
    let logged = logged(campaign);
    let places = said(&file);
    let free = |file: &RobotFile| -> Vec<&Joint> {
        robot.moving_joints().filter(|joint| !file.hold.contains_key(&joint.name)).collect()
    };
    let mut unsaid = free(&file);
    unsaid.retain(|joint| !places.contains(&joint.name));
    let still = standing(campaign, &unsaid);
    let all = robot.moving_joints().count();
    hold(campaign, &mut file, (&still, all), "where their columns say, which move in no run");
    let moves = |joint: &&Joint| logged.contains(&joint.name) || places.contains(&joint.name);
    let (moving, idle): (Vec<&Joint>, Vec<&Joint>) = free(&file).into_iter().partition(moves);
    suit(campaign, &mut file, &moving);
    if !moving.is_empty() {
        let at = |joint: &&Joint| (joint.name.clone(), 0.0_f64.clamp(joint.limits.lower, joint.limits.upper));
        let idle: Vec<(String, f64)> = idle.iter().map(at).collect();
        hold(campaign, &mut file, (&idle, all), "at 0 or the nearest limit, as no column belongs to them");
    }
    leave_out(campaign, &file.hold);
    file
}

/// Refuses what only a wrong name or a wrong unit explains: a column of a joint that the URDF has not, and an angle far beyond its
/// joint's limits.
///
/// # Errors
///
/// [`Error::RefusedInput`] for the first of them.
pub(crate) fn check(campaign: &Campaign, robot: &Robot) -> Result<()> {
    for run in &campaign.runs {
        for signal in run.record.inputs.iter().chain(&run.record.outputs) {
            if let Some(reason) = refused(robot, signal) {
                let (file, channel) = (run.path.clone(), signal.channel.clone());
                return Err(Error::RefusedInput { file, channel, reason });
            }
        }
    }
    Ok(())
}

fn refused(robot: &Robot, signal: &Signal) -> Option<String> {
    let (joint, what) = signal.channel.rsplit_once('.')?;
    let names = || robot.moving_joints().map(|j| j.name.as_str());
    let Some(of) = robot.joints.iter().find(|j| j.name == joint) else {
        // What commands no joint is said by the model.
        let hint = nearest(joint, names());
        let hint = hint.map_or_else(|| "its".to_owned(), |n| format!("did you mean '{n}.{what}'? Its"));
        let all: Vec<&str> = names().collect();
        return MEASURED
            .contains(&what)
            .then(|| format!("is of no joint of {}; {hint} joints are {}", robot.name, all.join(", ")));
    };
    let most = signal.values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let (lower, upper) = (of.limits.lower, of.limits.upper);
    let beyond = ANGLES.contains(&what) && most > IN_DEGREES && most > BEYOND * lower.abs().max(upper.abs());
    beyond.then(|| {
        format!(
            "goes to {most:.0} rad, and its joint from {lower:.2} to {upper:.2} rad: is it in degrees? \
             {{ as = \"{}\", unit = \"deg\" }} under [columns] says so",
            signal.channel
        )
    })
}

/// The joints that columns belong to.
fn logged(campaign: &Campaign) -> BTreeSet<String> {
    let signals = campaign.runs.iter().flat_map(|run| run.record.inputs.iter().chain(&run.record.outputs));
    signals.filter_map(|s| Some(s.channel.rsplit_once('.')?.0.to_owned())).collect()
}

/// The joints that a robot's file says something of.
fn said(file: &RobotFile) -> BTreeSet<String> {
    let at_places = file.parameters.keys().chain(file.effects.iter().map(|effect| &effect.id));
    let places = at_places.filter_map(|id| Some(id.split_once('/')?.0));
    file.drive.keys().map(String::as_str).chain(places).map(str::to_owned).collect()
}

/// A drive of its own for each joint that slides where the drive of all turns, or the other way around. One that suits none of
/// them is a mistake.
fn suit(campaign: &mut Campaign, file: &mut RobotFile, moving: &[&Joint]) {
    let Ok(drive) = ActuatorSpec::load(&file.actuator, Some(&file.folder)) else { return };
    let suits = |joint: &Joint| (joint.kind == JointKind::Prismatic) == (drive.kind == Kind::Linear);
    let (other, does) = match drive.kind {
        Kind::Linear => ("rigid-rotary", "turns"),
        Kind::Rotary => ("rigid-linear", "slides"),
    };
    if !moving.iter().any(|joint| suits(joint)) {
        return;
    }
    for joint in moving.iter().filter(|joint| !suits(joint)) {
        if !file.drive.contains_key(&joint.name) {
            file.drive.insert(joint.name.clone(), other.to_owned());
            let (urdf, own) = (&file.robot, &file.actuator);
            note(campaign, format!("{urdf}: '{}' {does}: its drive is '{other}', not '{own}'", joint.name));
        }
    }
}

/// Joints whose position stands still in every run beside another joint's of their kind, and where. A column that is one number
/// from end to end may be a dead sensor's: its joint stands still only if a measured speed says so, too.
fn standing(campaign: &Campaign, joints: &[&Joint]) -> Vec<(String, f64)> {
    let column = |joint: &Joint, what: [&str; 2]| {
        let slides = joint.kind == JointKind::Prismatic;
        Span::of(campaign, &format!("{}.{}", joint.name, what[usize::from(slides)]))
    };
    let all = |what: [&str; 2]| -> Vec<Option<Span>> { joints.iter().map(|j| column(j, what)).collect() };
    let (positions, speeds) = (all(["angle_rad", "position_m"]), all(["speed_rad_s", "speed_m_s"]));
    let widest = |spans: &[Option<Span>], joint: &Joint| {
        let alike = joints.iter().zip(spans).filter(|(j, _)| j.kind == joint.kind);
        alike.filter_map(|(_, span)| span.as_ref()).map(Span::width).fold(0.0, f64::max)
    };
    let stands = |i: usize| -> Option<(String, f64)> {
        let (joint, position) = (joints[i], positions[i].as_ref()?);
        let is_still = |span: &Span, all: &[Option<Span>]| span.width() < STILL * widest(all, joint);
        let speed_says = speeds[i].as_ref().map(|speed| is_still(speed, &speeds) || speed.width() == 0.0);
        let still = is_still(position, &positions) && speed_says.unwrap_or(position.width() > 0.0);
        still.then(|| (joint.name.clone(), position.middle()))
    };
    (0..joints.len()).filter_map(stands).collect()
}

/// The least and the greatest value of a column.
struct Span(f64, f64);

impl Span {
    /// `None` where a run lacks the column.
    fn of(campaign: &Campaign, channel: &str) -> Option<Self> {
        let values =
            campaign.runs.iter().map(|run| run.record.output(channel)).collect::<Option<Vec<_>>>()?;
        let all = || values.iter().copied().flatten().copied();
        Some(Self(all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max)))
    }

    fn width(&self) -> f64 {
        self.1 - self.0
    }

    fn middle(&self) -> f64 {
        f64::midpoint(self.0, self.1)
    }
}

/// Joints of so many that stand still, with a remark that says where.
fn hold(campaign: &mut Campaign, file: &mut RobotFile, (joints, of): (&[(String, f64)], usize), at: &str) {
    if joints.is_empty() {
        return;
    }
    let mut names: Vec<&str> = joints.iter().map(|(name, _)| name.as_str()).take(NAMED).collect();
    let more = format!("and {} more", joints.len().saturating_sub(NAMED));
    if joints.len() > NAMED {
        names.push(&more);
    }
    let (urdf, names) = (&file.robot, names.join(", "));
    let number = joints.len();
    let said = format!(
        "{urdf}: {number} of {of} joints stand still, {at}: {names}; a robot's file may say where under [hold]"
    );
    note(campaign, said);
    file.hold.extend(joints.iter().cloned());
}

/// Leaves out the columns of joints that stand still: nothing of the model moves or drives them.
fn leave_out(campaign: &mut Campaign, held: &BTreeMap<String, f64>) {
    let is_held = |channel: &str| channel.rsplit_once('.').is_some_and(|(joint, _)| held.contains_key(joint));
    let mut left_out = BTreeSet::new();
    for run in &mut campaign.runs {
        for signals in [&mut run.record.inputs, &mut run.record.outputs] {
            left_out.extend(signals.extract_if(.., |s| is_held(&s.channel)).map(|s| s.channel));
        }
    }
    if !left_out.is_empty() {
        note(campaign, format!("{} columns of joints that stand still are left out", left_out.len()));
    }
    campaign.noise.retain(|noise| !is_held(&noise.channel));
}

/// Adds a remark to a campaign, once.
fn note(campaign: &mut Campaign, what: String) {
    if !campaign.notes.contains(&what) {
        campaign.notes.push(what);
    }
}
