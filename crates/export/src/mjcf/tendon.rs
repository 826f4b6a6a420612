//! Tendons whose length is a sum of joints' positions: springs between coordinates, and springs that yield.

use crate::bench::BenchDescription;
use crate::term::Term;
use crate::text::num;
use std::fmt::Write;

/// A tendon along joints, each with how much of it.
pub fn fixed(o: &mut String, name: &str, attributes: &str, joints: &[(&str, f64)]) {
    let _ = writeln!(o, "    <fixed name=\"{name}\"{attributes}>");
    for (joint, coef) in joints {
        let _ = writeln!(o, "      <joint joint=\"{joint}\" coef=\"{}\"/>", num(*coef));
    }
    let _ = writeln!(o, "    </fixed>");
}

/// What yields in a drive: elastic friction at the `rotor`'s joint, and a clamp beside the spring, whose `deflection` is the
/// joints' sum; none where that is empty. The tendons' names begin with `prefix`.
pub fn yielding(
    o: &mut String,
    bench: &BenchDescription,
    prefix: &str,
    rotor: &str,
    deflection: &[(&str, f64)],
) {
    for (_, term) in bench.terms() {
        match *term {
            Term::Presliding { force, stiffness } if force > 0.0 => {
                fixed(o, &format!("{prefix}presliding"), &yields_at(force, stiffness), &[(rotor, 1.0)]);
            }
            Term::SpringSlip { stiffness, force } if force > 0.0 && !deflection.is_empty() => {
                fixed(o, &format!("{prefix}clamp_slip"), &yields_at(force, stiffness), deflection);
            }
            _ => {}
        }
    }
}

/// A spring that yields at a force: an elastic element in series with a dry slider.
fn yields_at(force: f64, stiffness: f64) -> String {
    format!(" stiffness=\"{}\" springlength=\"0\" springyield=\"{}\"", num(stiffness), num(force / stiffness))
}
