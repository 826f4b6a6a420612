//! Mass properties that no body has, made possible the way MuJoCo's compiler does.
//!
//! What moves as one is looked at as one: a link with everything that is fixed to it. Its mass is raised to
//! [`BOUND_MASS_KG`] (`boundmass`), its principal moments to [`BOUND_INERTIA_KG_M2`] (`boundinertia`), and where
//! the largest still exceeds the sum of the other two, all three become their mean (`balanceinertia`). The base
//! is left as it is: it never turns.

use super::{Inertial, Robot, RobotFault};
use nalgebra::{Isometry3, Matrix3, Point3, SymmetricEigen};

/// Least mass of what a joint moves, kg: a steel ball of 0.6 mm. MuJoCo leaves the number to the model.
pub(super) const BOUND_MASS_KG: f64 = 1e-6;

/// Least principal moment of what a joint moves, kg m^2: a fourth of a steel ball of one gram.
pub(super) const BOUND_INERTIA_KG_M2: f64 = 1e-9;

/// A negative moment of more than this part of the largest is no slip of rounding or of an estimate, but another
/// matrix. The worst that robots in use were found to have is 0.054.
const MOST_NEGATIVE: f64 = 0.1;

/// What moves as one: the link that a joint carries, with everything that is fixed to it.
struct Lump {
    /// The link that the joint carries.
    link: usize,
    inertial: Option<Inertial>,
    /// Links that are fixed to it and have mass.
    fixed: usize,
}

/// Makes every moving body of the robot physical. Returns a sentence for each that was changed, with the index of
/// its link.
///
/// # Errors
///
/// The link, and [`RobotFault::ImpossibleInertia`] where a moment is clearly negative.
pub(super) fn mend(robot: &mut Robot) -> Result<Vec<(usize, String)>, (usize, RobotFault)> {
    let mut remarks = Vec::new();
    for lump in lumps(robot).into_iter().skip(1) {
        let body = lump.inertial.unwrap_or(Inertial::NONE);
        let Some((mended, what)) = mended(&body).map_err(|fault| (lump.link, fault))? else { continue };
        // The difference goes to the carrying link: at the body's centre of mass it moves nothing else.
        let own =
            robot.links[lump.link].inertial.take().unwrap_or(Inertial { com: body.com, ..Inertial::NONE });
        let mut own = own.with_point_mass(mended.mass_kg - body.mass_kg, &body.com);
        own.inertia += mended.inertia - body.inertia;
        robot.links[lump.link].inertial = Some(own);
        let with = if lump.fixed > 0 { " with what is fixed to it" } else { "" };
        remarks.push((lump.link, format!("what the joint moves (the link{with}) {what}")));
    }
    Ok(remarks)
}

/// The bodies of the robot, the base first.
fn lumps(robot: &Robot) -> Vec<Lump> {
    let mut lumps = vec![Lump { link: 0, inertial: robot.links[0].inertial.clone(), fixed: 0 }];
    // For each link its lump, and the link's pose in it.
    let mut place = vec![(0, Isometry3::identity())];
    for joint in &robot.joints {
        let own = robot.links[joint.child].inertial.as_ref();
        if joint.dof.is_some() {
            place.push((lumps.len(), Isometry3::identity()));
            lumps.push(Lump { link: joint.child, inertial: own.cloned(), fixed: 0 });
            continue;
        }
        let (lump, parent) = place[joint.parent];
        let pose = parent * joint.origin;
        place.push((lump, pose));
        if let Some(own) = own.map(|i| i.seen_from(&pose)) {
            let lump = &mut lumps[lump];
            lump.fixed += 1;
            lump.inertial = Some(lump.inertial.as_ref().map_or(own.clone(), |all| all.joined_with(&own)));
        }
    }
    lumps
}

/// The mended mass properties and what was done to them, if anything was.
fn mended(body: &Inertial) -> Result<Option<(Inertial, String)>, RobotFault> {
    let eigen = SymmetricEigen::new(body.inertia);
    let sorted = |m: nalgebra::Vector3<f64>| {
        let mut m: [f64; 3] = m.into();
        m.sort_by(f64::total_cmp);
        m
    };
    let before = sorted(eigen.eigenvalues);
    if before[0] < -MOST_NEGATIVE * before[2].max(BOUND_INERTIA_KG_M2) {
        return Err(RobotFault::ImpossibleInertia(before, "each must be positive"));
    }
    let (mut changes, mut mass_kg) = (Vec::new(), body.mass_kg);
    if mass_kg < BOUND_MASS_KG {
        changes.push(format!("has a mass of {mass_kg:e} kg, raised to {BOUND_MASS_KG:e} kg"));
        mass_kg = BOUND_MASS_KG;
    }
    let list = |m: [f64; 3]| format!("{:.3e}, {:.3e}, {:.3e} kg m^2", m[0], m[1], m[2]);
    let mut moments = eigen.eigenvalues;
    if before[0] < BOUND_INERTIA_KG_M2 {
        moments = moments.map(|m| m.max(BOUND_INERTIA_KG_M2));
        let raised = list(sorted(moments));
        changes.push(format!("has the principal moments {}, raised to {raised}", list(before)));
    }
    let now = sorted(moments);
    if now[2] > (now[0] + now[1]) * (1.0 + Inertial::TRIANGLE_TOLERANCE) {
        let mean = moments.sum() / 3.0;
        changes.push(format!(
            "has the principal moments {}, of which the largest exceeds the sum of the other two: all set to their \
             mean {mean:.3e} kg m^2",
            list(now)
        ));
        moments.fill(mean);
    }
    if changes.is_empty() {
        return Ok(None);
    }
    let axes = eigen.eigenvectors;
    let inertia = axes * Matrix3::from_diagonal(&moments) * axes.transpose();
    let inertia = (inertia + inertia.transpose()) * 0.5;
    Ok(Some((Inertial { mass_kg, com: body.com, inertia }, changes.join("; it "))))
}

impl Inertial {
    /// Nothing at all, at the origin.
    pub(super) const NONE: Self = Self {
        mass_kg: 0.0,
        com: Point3::new(0.0, 0.0, 0.0),
        inertia: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    };
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Rotation3, Vector3};

    fn body(mass_kg: f64, moments: [f64; 3]) -> Inertial {
        let turn = Rotation3::from_euler_angles(0.3, -0.4, 1.1);
        let diagonal = Matrix3::from_diagonal(&Vector3::from(moments));
        Inertial { mass_kg, com: Point3::new(0.1, 0.0, 0.0), inertia: turn * diagonal * turn.transpose() }
    }

    #[test]
    fn analytic_what_is_possible_stays_as_it_is() {
        for moments in [[0.02, 0.02, 0.01], [1e-7, 1e-7, 2e-7], [0.1, 0.2, 0.3]] {
            assert!(mended(&body(1.0, moments)).expect("possible").is_none(), "{moments:?}");
        }
    }

    #[test]
    fn analytic_moments_are_raised_and_balanced() {
        // Rounding below zero: raised to the bound, the others as they were.
        let (new, said) = mended(&body(1.0, [-1e-16, 0.02, 0.02])).expect("slight").expect("changed");
        let mut moments: [f64; 3] = new.inertia.symmetric_eigenvalues().into();
        moments.sort_by(f64::total_cmp);
        assert!((moments[0] - 1e-9).abs() < 1e-14 && (moments[1] - 0.02).abs() < 1e-14, "{moments:?}");
        assert!(said.contains("raised to 1.000e-9"), "{said}");
        // 1 + 2 < 6: all become 3, which keeps the trace.
        let (new, said) = mended(&body(1.0, [1.0, 6.0, 2.0])).expect("slight").expect("changed");
        assert!((new.inertia - Matrix3::identity() * 3.0).norm() < 1e-14);
        assert!(said.contains("mean 3.000e0"), "{said}");
        assert!(new.is_physical());
    }

    #[test]
    fn another_matrix_is_not_mended() {
        assert!(mended(&body(1.0, [-0.004, 0.03, 0.05])).is_ok());
        assert!(matches!(mended(&body(1.0, [-0.01, 0.03, 0.05])), Err(RobotFault::ImpossibleInertia(..))));
    }
}
