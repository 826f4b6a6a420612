//! The equations of motion of chapter 4 as they are printed, solved at one frequency: the other side of the
//! comparison with the product's one formula.

use num_complex::Complex64;
use sealegs_actuator::Coefficients;
use sealegs_actuator::response::{ForceResponse, Link};

type Matrix = [[Complex64; 3]; 3];

/// Largest relative deviation of the printed sprung-ball-nut equations (4-2 to 4-7) from the product's formula, over
/// links of several masses on springs and frequencies of 0.1 to 500 Hz.
#[must_use]
pub fn sbn_deviation(c: &Coefficients) -> f64 {
    worst(c, |s, m1, m2, k1, k2| {
        let (z, k) = (screw(c, s), Complex64::from(c.stiffness));
        // F1 = -k1 x1 and F2 = k2 x2 are what the ground springs exert; F_k = k (x_r - x_2).
        let rows = [
            [m1 * s * s + k1 + z, -z, Complex64::ZERO],
            [-z, c.sprung_mass * s * s + z + k, -k],
            [Complex64::ZERO, -k, m2 * s * s + k2 + k],
        ];
        let x = solve(rows, [-Complex64::ONE, Complex64::ONE, Complex64::ZERO]);
        (k * (x[1] - x[2]), Complex64::ONE - z * (x[1] - x[0]))
    })
}

/// The same for the sprung motor housing (4-8 to 4-13), with `x_p` counted towards link 1 and `F_k = k (x_1 + x_p)`: the
/// only reading under which the printed set is consistent.
#[must_use]
pub fn smh_deviation(c: &Coefficients) -> f64 {
    worst(c, |s, m1, m2, k1, k2| {
        let (z, k) = (screw(c, s), Complex64::from(c.stiffness));
        let rows = [
            [m1 * s * s + k1 + k, k, Complex64::ZERO],
            [k, c.sprung_mass * s * s + z + k, z],
            [Complex64::ZERO, z, m2 * s * s + k2 + z],
        ];
        let x = solve(rows, [Complex64::ZERO, Complex64::ONE, Complex64::ONE]);
        (k * (x[0] + x[1]), Complex64::ONE - z * (x[1] + x[2]))
    })
}

/// `(J/r^2) s^2 + (b_r/r^2) s`: what the screw's relative motion costs of the motor force.
fn screw(c: &Coefficients, s: Complex64) -> Complex64 {
    c.reflected_inertia * s * s + c.damping * s
}

/// `printed(s, m1, m2, k1, k2)` gives `F_k` and `F_bs` per motor force for links of these masses on ground springs.
fn worst(c: &Coefficients, printed: impl Fn(Complex64, f64, f64, f64, f64) -> (Complex64, Complex64)) -> f64 {
    let mut worst: f64 = 0.0;
    for (m1, m2, k1, k2) in [(5.0, 68.5, 0.0, 2240.0), (30.0, 2.0, 4e4, 0.0), (0.7, 12.0, 1e6, 3e3)] {
        let link = |mass_kg, stiffness_n_m| Link::Mass { mass_kg, stiffness_n_m };
        let response = ForceResponse::between(c, link(m1, k1), link(m2, k2));
        for i in 0..60 {
            let hz = 0.1 * 5000f64.powf(f64::from(i) / 59.0);
            let s = Complex64::new(0.0, std::f64::consts::TAU * hz);
            let (f_k, f_bs) = printed(s, m1, m2, k1, k2);
            for (theirs, ours) in [(f_k, response.sprung.at(s)), (f_bs, response.unsprung.at(s))] {
                worst = worst.max((theirs - ours).norm() / ours.norm());
            }
        }
    }
    worst
}

/// Cramer's rule.
fn solve(a: Matrix, b: [Complex64; 3]) -> [Complex64; 3] {
    let determinant = |m: &Matrix| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    let whole = determinant(&a);
    std::array::from_fn(|column| {
        let mut replaced = a;
        for row in 0..3 {
            replaced[row][column] = b[row];
        }
        determinant(&replaced) / whole
    })
}
