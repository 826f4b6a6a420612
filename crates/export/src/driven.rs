//! Drives, each at a joint of its own: one without a spring on a bench, or a robot with its drives.
//!
//! A bench is a robot of one joint. Its drive's numbers are those of the drive's own coordinate `y` (the output of a rotary
//! drive, the travel of a linear one); a lever turns them into those of the joint, `y = arm angle`.

use crate::ExportError;
use crate::bench::{BenchDescription, Output};
use crate::mjcf::STEP_S;
use crate::term::{Included, Term};
use nalgebra::{Isometry3, Matrix3, Point3, Unit, Vector3};
use sealegs_actuator::Kind;
use sealegs_actuator::bench::{Bench, BenchModel};
use sealegs_actuator::plant::{GRAVITY_M_S2, Link as Load, Plant, Servo, Winding};
use sealegs_actuator::spec::ServoSpec;
use sealegs_leg::bench::RobotModel;
use sealegs_leg::robot::{Geometry, Inertial, Joint, JointKind, JointLimits, Link, Robot, Shape, Source};
use sealegs_model::Model;

/// What the command of a drive is.
#[derive(Debug, Clone, PartialEq)]
pub enum Command {
    /// A current, force or torque.
    Effort,
    /// A voltage at the winding.
    Voltage(Winding),
    /// A goal of the drive's own position loop, which sets a voltage.
    Goal(Winding, Servo),
    /// The same of one that commands a torque.
    Impedance(Servo),
}

/// Where a rotor meets its joint: at a series spring, or in a transmission that yields or has play. In the drive's own
/// coordinate `y`; the stiffness is the drive's.
#[derive(Debug, Clone, PartialEq)]
pub struct Coupling {
    /// N s/m.
    pub damping: f64,
    /// Whether it acts only where the play is closed, as in gears; beside a series spring it always does.
    pub in_contact: bool,
    /// Width of the play, m.
    pub gap: f64,
    /// The longest step, s, that follows rotor against joint.
    pub step_s: f64,
}

/// A joint that a drive moves.
#[derive(Debug, Clone)]
pub struct DrivenJoint {
    pub name: String,
    /// The drive's numbers in its own coordinate.
    pub drive: BenchDescription,
    pub command: Command,
    /// Travel of the drive per motion of the joint: 1, or a lever's arm in m.
    pub arm: f64,
    /// Where the rotor meets the joint, unless they move as one.
    pub coupling: Option<Coupling>,
    /// Whether that is a series spring.
    pub sprung: bool,
    /// Viscous damping of the joint itself, behind a series spring.
    pub damping: f64,
    /// What its sensors show: the channel on the drive's own bench, and its name here.
    pub channels: Vec<(String, String)>,
}

/// Where a joint begins a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start {
    pub position: f64,
    pub speed: f64,
    /// How far the rotor is ahead of the joint, in the drive's own coordinate.
    pub ahead: f64,
}

/// A robot, or a bench, whose joints are driven.
#[derive(Debug, Clone)]
pub struct DrivenRobot {
    pub name: String,
    /// What it is in a sentence's words.
    pub title: String,
    pub robot: Robot,
    /// By degree of freedom.
    pub joints: Vec<DrivenJoint>,
    pub gravity_m_s2: f64,
    /// Where runs begin: a name, and every joint's start.
    pub starts: Vec<(String, Vec<Start>)>,
    /// Whether it is a bench rather than a user's robot.
    pub is_bench: bool,
    /// Whether values of the links were fitted and stand in the place of the URDF's.
    pub links_fitted: bool,
}

impl DrivenRobot {
    /// A drive without a spring on a bench. With `run` the rig, the start and the servo's gain are that run's.
    ///
    /// # Errors
    ///
    /// [`ExportError::Model`] for values that no drive can have.
    pub fn of_bench(model: &BenchModel, input: &str, run: Option<&str>) -> Result<Self, ExportError> {
        let values: Vec<f64> = model.parameters().iter().map(|p| p.value).collect();
        let setup = run.and_then(|name| model.run(name));
        let bench = setup.map_or(model.bench(), |s| s.bench);
        let own;
        let model = if bench == model.bench() {
            model
        } else {
            own = model.on(bench);
            &own
        };
        let plant = model.plant(&values, input)?;
        let mut command = command_of(&plant);
        if let (Command::Goal(_, servo) | Command::Impedance(servo), Some(setup)) = (&mut command, setup) {
            *servo = servo.times(setup.servo_gain);
        }
        let slides = model.spec().kind == Kind::Linear && !matches!(bench, Bench::Pendulum(_));
        let (arm, name) = match (bench, slides) {
            (Bench::Pendulum(rig), _) => (rig.arm_m, "lever"),
            (_, true) => (1.0, "carriage"),
            (_, false) => (1.0, "shaft"),
        };
        let mut drive = BenchDescription::of_plant(model, &values, &plant, input, Output::Held);
        if let (Command::Goal(..) | Command::Impedance(_), Some(servo)) = (&command, &model.spec().servo) {
            drive.effects.splice(0..0, of_servo(servo));
        }
        let channels = drive.channels.iter().map(|c| ((*c).to_owned(), (*c).to_owned())).collect();
        let starts = setup.map(|s| {
            let (x, v) = s.start;
            let ahead = if plant.is_parted() { plant.ahead_at_rest(x) } else { 0.0 };
            (s.record.clone(), vec![Start { position: x / arm, speed: v / arm, ahead }])
        });
        let coupling = coupling_of(&plant, &drive);
        Ok(Self {
            name: "bench".to_owned(),
            title: model.name(),
            robot: bench_robot(name, slides, plant.rigid.unwrap_or(plant.link_2)),
            joints: vec![DrivenJoint {
                name: name.to_owned(),
                drive,
                command,
                arm,
                coupling,
                sprung: false,
                damping: 0.0,
                channels,
            }],
            gravity_m_s2: GRAVITY_M_S2,
            starts: starts.into_iter().collect(),
            is_bench: true,
            links_fitted: false,
        })
    }

    /// A robot with its drives, with its nominal values and the effects of its file.
    ///
    /// # Errors
    ///
    /// [`ExportError::Model`] for values that no drive can have.
    pub fn of_robot(model: &RobotModel) -> Result<Self, ExportError> {
        let values = model.nominal();
        let robot = model.robot_at(&values);
        let (mut joints, mut plants) = (Vec::new(), Vec::new());
        for joint in model.driven_joints(&values) {
            let plant = joint.plant()?;
            let drive =
                BenchDescription::of_plant(joint.drive, &joint.values, &plant, &joint.command, Output::Held);
            let channels = joint.channels.iter().map(|(at, here)| ((*at).to_owned(), here.clone())).collect();
            joints.push(DrivenJoint {
                name: joint.name.to_owned(),
                command: command_of(&plant),
                arm: 1.0,
                coupling: coupling_of(&plant, &drive),
                sprung: !joint.drive.spec().is_rigid(),
                damping: joint.damping,
                drive,
                channels,
            });
            plants.push(plant);
        }
        let start_of = |(name, start): (&str, &[(f64, f64)])| {
            let ahead = model.rotors_ahead(&values, &plants, start).into_iter();
            let of = |((position, speed), ahead): (&(f64, f64), f64)| Start {
                position: *position,
                speed: *speed,
                ahead,
            };
            (name.to_owned(), start.iter().zip(ahead).map(of).collect())
        };
        if let Some(first) = joints.first_mut() {
            first.drive.sensors = model.sensors();
        }
        Ok(Self {
            name: robot.name.clone(),
            title: Model::name(model),
            links_fitted: robot.links != model.robot().links,
            robot,
            joints,
            gravity_m_s2: GRAVITY_M_S2,
            starts: model.starts().map(start_of).collect(),
            is_bench: false,
        })
    }

    /// The ids of a joint's effects with the joint's name where there may be several.
    pub fn id_of(&self, joint: &DrivenJoint, id: &str) -> String {
        if self.is_bench { id.to_owned() } else { format!("{}/{id}", joint.name) }
    }
}

impl DrivenJoint {
    /// The joint of the rotor, the drive's numbers as they are there, and the drive's travel per motion of that joint: the joint
    /// itself, unless the rotor moves on its own.
    pub fn at_rotor(&self) -> (String, BenchDescription, f64) {
        match self.coupling {
            Some(_) => (format!("{}_rotor", self.name), self.drive.clone(), 1.0),
            None => (self.name.clone(), self.at_joint(), self.arm),
        }
    }

    /// The drive's numbers as they are at the joint.
    pub fn at_joint(&self) -> BenchDescription {
        let arm = self.arm;
        let size = arm.abs();
        let mut drive = self.drive.clone();
        drive.inertia *= arm * arm;
        drive.damping *= arm * arm;
        drive.gain *= arm;
        drive.offset_force *= arm;
        drive.travel_per_rad /= arm;
        for included in &mut drive.effects {
            match &mut included.term {
                Term::Coulomb { force } | Term::Warming { force, .. } => *force *= size,
                Term::Presliding { force, stiffness } => {
                    *force *= size;
                    *stiffness *= arm * arm;
                }
                Term::Stribeck { coulomb, at_rest, velocity } => {
                    *coulomb *= size;
                    *at_rest *= size;
                    *velocity /= size;
                }
                Term::DirectedFriction { force, asymmetry } => {
                    *force *= size;
                    *asymmetry *= arm.signum();
                }
                Term::Drag { coefficient } => *coefficient *= size * arm * arm,
                Term::Ripple { amplitude, .. } => *amplitude *= arm,
                _ => {}
            }
        }
        drive
    }

    /// The greatest torque that a loop's command comes to, as a force along `y` of a drive with these numbers.
    pub fn most_of(&self, servo: &Servo, drive: &BenchDescription) -> f64 {
        (drive.gain * servo.limit.min(drive.command_limit().unwrap_or(f64::INFINITY))).abs()
    }

    /// The winding at the joint, where the command is a voltage or a goal: torque per current, which is also the back-EMF
    /// per speed, and resistance.
    pub fn winding(&self) -> Option<(f64, f64)> {
        match &self.command {
            Command::Effort | Command::Impedance(_) => None,
            Command::Voltage(w) | Command::Goal(w, _) => {
                Some((w.force_per_current * self.arm, w.resistance_ohm))
            }
        }
    }
}

/// What a servo's file says of its drive beside the loop's law, as effects.
fn of_servo(servo: &ServoSpec) -> Vec<Included> {
    let mut said = Vec::new();
    let mut say = |id: &str, term| said.push(Included { id: id.to_owned(), term });
    if servo.command_delay_s > 0.0 {
        say("servo's command_delay_s", Term::Delay { delay_s: servo.command_delay_s });
    }
    if servo.duty_dead_zone > 0.0 {
        say("servo's duty_dead_zone", Term::DeadZone { duty: servo.duty_dead_zone });
    }
    if let Some(limit) = servo.current_limit_a {
        say("servo's current_limit_a", Term::CommandLimit { limit });
    }
    said
}

/// Least step, s, for the oscillation of a rotor against its joint.
const LEAST_STEP_S: f64 = 1e-6;

/// How much shorter a step of Runge and Kutta's is than one of the project's own, which follows a linear spring implicitly.
const PARTS: f64 = 3.0;

fn coupling_of(plant: &Plant, drive: &BenchDescription) -> Option<Coupling> {
    if plant.rigid.is_some() {
        return None;
    }
    Some(Coupling {
        damping: plant.laws.spring_damping,
        in_contact: plant.transmission.gap > 0.0,
        gap: plant.transmission.gap + drive.gap(),
        step_s: plant.step_following(PARTS * STEP_S, PARTS * LEAST_STEP_S) / PARTS,
    })
}

fn command_of(plant: &Plant) -> Command {
    match (plant.winding, plant.servo) {
        (Some(winding), Some(servo)) => Command::Goal(winding, servo),
        (Some(winding), None) => Command::Voltage(winding),
        (None, Some(servo)) => Command::Impedance(servo),
        (None, None) => Command::Effort,
    }
}

/// Moments of a point mass over `m l^2`: as good as none, which no format admits.
const POINT: f64 = 1e-9;

/// A base and what the drive moves. The joint slides along x, or turns about -y so that a pendulum at a positive angle swings
/// to +x.
fn bench_robot(joint: &str, slides: bool, load: Load) -> Robot {
    let at = |com: Point3<f64>, mass_kg: f64, moment: f64| Inertial {
        mass_kg,
        com,
        inertia: Matrix3::identity() * moment,
    };
    let (inertial, shape) = match load {
        // Of weight and moment of inertia mass and place follow as those of a point: I = m l^2, G = m g l.
        Load::Pendulum { inertia_kg_m2, gravity_torque_nm, .. } if gravity_torque_nm != 0.0 => {
            let length = inertia_kg_m2 * GRAVITY_M_S2 / gravity_torque_nm;
            let mass = gravity_torque_nm / (GRAVITY_M_S2 * length);
            (Some(at(Point3::new(0.0, 0.0, -length), mass, POINT * mass * length * length)), Some(length))
        }
        Load::Pendulum { inertia_kg_m2, .. } => {
            (Some(at(Point3::origin(), inertia_kg_m2, inertia_kg_m2)), None)
        }
        // The moments of a body that does not turn are of no account.
        Load::Mass(mass) if mass > 0.0 && slides => (Some(at(Point3::origin(), mass, 1e-4 * mass)), None),
        Load::Mass(moment) if moment > 0.0 => (Some(at(Point3::origin(), moment, moment)), None),
        _ => (None, None),
    };
    let visual = shape.map(|length| Shape {
        name: String::new(),
        origin: Isometry3::translation(0.0, 0.0, -0.5 * length),
        geometry: Geometry::Cylinder { radius_m: 0.02 * length.abs(), length_m: length.abs() },
        color: None,
    });
    let link = |name: &str, inertial, visuals| Link {
        name: name.to_owned(),
        inertial,
        visuals,
        collisions: Vec::new(),
    };
    Robot {
        name: "bench".to_owned(),
        links: vec![link("frame", None, Vec::new()), link("load", inertial, visual.into_iter().collect())],
        joints: vec![Joint {
            name: joint.to_owned(),
            kind: if slides { JointKind::Prismatic } else { JointKind::Continuous },
            parent: 0,
            child: 1,
            origin: Isometry3::identity(),
            axis: if slides { Vector3::x_axis() } else { Unit::new_unchecked(-Vector3::y()) },
            limits: JointLimits::NONE,
            damping: 0.0,
            friction: 0.0,
            dof: Some(0),
        }],
        dofs: 1,
        actuators: Vec::new(),
        warnings: Vec::new(),
        source: Source::Text("bench".to_owned()),
    }
}
