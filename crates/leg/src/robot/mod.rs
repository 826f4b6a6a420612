//! What a robot is made of: links, joints, and where its actuators sit; loaded from URDF and a placement file.
//!
//! No type of the physics engine appears here. All frames are right-handed; the shipped legs use x forward,
//! y to the left, z up, and stand straight when every joint is at zero. A pose `world_from_link` maps
//! coordinates in the link's frame to the world. As in URDF, a link's frame is the frame of the joint that
//! carries it, and the joint turns about, or slides along, `axis` in that frame.

mod dae;
mod elements;
mod fault;
mod joint;
mod kinematics;
mod link;
mod load;
mod mend;
mod mesh;
mod mirror;
mod options;
mod placement;
mod placement_file;
mod sprung_mass;
mod tree;
mod urdf;
mod urdf_parts;
mod xml;

pub use fault::RobotFault;
pub use joint::{Joint, JointKind, JointLimits};
pub use kinematics::{Lever, Posture};
pub use link::{Geometry, Inertial, Link, Mesh, Shape};
pub use options::LoadOptions;
pub use placement::{Drive, HoekensMount, LengthRange, Placement};

use std::collections::BTreeMap;
use std::path::PathBuf;

/// A tree of links and joints with the actuators that drive it.
#[derive(Debug, Clone, PartialEq)]
pub struct Robot {
    /// The robot's name, from the URDF.
    pub name: String,
    /// The links in topological order: a parent comes before its children, the only root is `links[0]`.
    pub links: Vec<Link>,
    /// The joints, `joints[i]` carries `links[i + 1]`.
    pub joints: Vec<Joint>,
    /// Number of degrees of freedom: how many joints are not fixed.
    pub dofs: usize,
    /// The actuators, in the order of the placement file; empty where there is none.
    pub actuators: Vec<Placement>,
    /// What was mended, left out or is not supported, one sentence each with file, line and element.
    pub warnings: Vec<String>,
    /// Where the robot came from.
    pub source: Source,
}

/// Where a robot was read from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Source {
    /// Embedded in the program under this name.
    Preset(String),
    /// A user's files.
    Files {
        /// The URDF.
        urdf: PathBuf,
        /// The placement file, if there is one.
        placement: Option<PathBuf>,
    },
    /// Made from text or by a program, under this name.
    Text(String),
}

impl Source {
    /// What to call the placement file in a message.
    #[must_use]
    pub fn placement_name(&self) -> String {
        match self {
            Self::Preset(name) => format!("{name}.actuators.toml"),
            Self::Files { urdf, placement } => placement.as_ref().unwrap_or(urdf).display().to_string(),
            Self::Text(name) => name.clone(),
        }
    }
}

impl Robot {
    /// The index of the link with this name.
    #[must_use]
    pub fn link_index(&self, name: &str) -> Option<usize> {
        self.links.iter().position(|l| l.name == name)
    }

    /// The index of the joint with this name.
    #[must_use]
    pub fn joint_index(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|j| j.name == name)
    }

    /// The index of the actuator with this name.
    #[must_use]
    pub fn actuator_index(&self, name: &str) -> Option<usize> {
        self.actuators.iter().position(|a| a.name == name)
    }

    /// The joints that move, in the order of their degree of freedom.
    pub fn moving_joints(&self) -> impl Iterator<Item = &Joint> {
        self.joints.iter().filter(|j| j.dof.is_some())
    }

    /// The robot with these joints standing still at a position (rad or m): they are fixed there, and the others' degrees of freedom
    /// are counted anew. A name that no joint has changes nothing.
    #[must_use]
    pub fn holding(mut self, held: &BTreeMap<String, f64>) -> Self {
        self.dofs = 0;
        for joint in &mut self.joints {
            if let Some(position) = held.get(&joint.name) {
                joint.origin = joint.parent_from_child(*position);
                joint.kind = JointKind::Fixed;
            }
            joint.dof = (joint.kind != JointKind::Fixed).then_some(self.dofs);
            self.dofs += usize::from(joint.dof.is_some());
        }
        self
    }

    /// The joints on the way from one link to the other, in no particular order.
    #[must_use]
    pub fn joints_between(&self, link_1: usize, link_2: usize) -> Vec<usize> {
        // Topological order: the link with the higher index cannot be an ancestor of the other.
        let (mut a, mut b) = (link_1, link_2);
        let mut joints = Vec::new();
        while a != b {
            let higher = if a > b { &mut a } else { &mut b };
            joints.push(*higher - 1);
            *higher = self.joints[*higher - 1].parent;
        }
        joints
    }

    /// Mass of all links as the URDF states them, kg.
    #[must_use]
    pub fn mass_kg(&self) -> f64 {
        self.links.iter().filter_map(|l| l.inertial.as_ref()).map(|i| i.mass_kg).sum()
    }
}
