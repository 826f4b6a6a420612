//! Steps that normal equations propose: the damped one inside the bounds, and those along the flattest directions alone.

use super::coordinates::{Bound, Coordinates};
use nalgebra::{DMatrix, DVector};

/// Most of the flattest directions that are tried together.
const FLATTEST: usize = 5;

/// What the normal equations propose.
pub(super) enum Proposal {
    /// Where the damped step leads, inside the bounds, and by how much the cost should fall.
    Step(Vec<f64>, f64),
    /// No coordinate can move.
    Stuck,
    /// Nearly the same columns, and rounding made the matrix indefinite: more damping is needed.
    Singular,
}

/// The damped step inside the bounds.
pub(super) fn proposal(
    coordinates: &Coordinates,
    u: &[f64],
    a: &DMatrix<f64>,
    g: &DVector<f64>,
    damping: f64,
) -> Proposal {
    // What neither data nor prior feels stays where it is: a typical change must move the residuals at all.
    let mut moving: Vec<usize> =
        (0..u.len()).filter(|&k| a[(k, k)] > 1e-9 && !outward(coordinates, k, u[k], -g[k])).collect();
    // A step that leads out of the box at a coordinate on the bound is taken again without it.
    for _ in 0..=u.len() {
        if moving.is_empty() {
            return Proposal::Stuck;
        }
        let n = moving.len();
        let mut damped = DMatrix::from_fn(n, n, |i, j| a[(moving[i], moving[j])]);
        for i in 0..n {
            damped[(i, i)] *= 1.0 + damping;
        }
        let rhs = DVector::from_fn(n, |i, _| -g[moving[i]]);
        let Some(cholesky) = damped.cholesky() else { return Proposal::Singular };
        let mut step = cholesky.solve(&rhs);
        let excess = (0..n).map(|i| step[i].abs() / coordinates.largest_step(moving[i])).fold(1.0, f64::max);
        step /= excess;
        let blocked = (0..n).find(|&i| outward(coordinates, moving[i], u[moving[i]], step[i]));
        if let Some(i) = blocked {
            moving.remove(i);
            continue;
        }
        let mut moved = u.to_vec();
        for (i, &k) in moving.iter().enumerate() {
            moved[k] = coordinates.coordinate(k, coordinates.value(k, u[k] + step[i]));
        }
        let d = DVector::from_fn(u.len(), |k, _| moved[k] - u[k]);
        let promised = -(g.dot(&d) + 0.5 * d.dot(&(a * &d)));
        return Proposal::Step(moved, promised);
    }
    Proposal::Stuck
}

/// Whether a move from a bound leads out.
fn outward(coordinates: &Coordinates, k: usize, u: f64, direction: f64) -> bool {
    match coordinates.bound(k, u) {
        Some(Bound::Min) => direction < 0.0,
        Some(Bound::Max) => direction > 0.0,
        None => false,
    }
}

/// Where steps lead along the flattest directions alone, one, then two of them, and so on, each with what it promises: where
/// the error is rough across them (friction that sticks and slips), every step that also leads across fails, and a search
/// would rest wherever it came upon them.
pub(super) fn along_flattest(
    coordinates: &Coordinates,
    u: &[f64],
    (a, g): (&DMatrix<f64>, &DVector<f64>),
) -> Vec<(Vec<f64>, f64)> {
    let moving: Vec<usize> =
        (0..u.len()).filter(|&k| a[(k, k)] > 1e-9 && coordinates.bound(k, u[k]).is_none()).collect();
    let n = moving.len();
    let scale: Vec<f64> = moving.iter().map(|&k| a[(k, k)].sqrt()).collect();
    let scaled = DMatrix::from_fn(n, n, |i, j| a[(moving[i], moving[j])] / (scale[i] * scale[j]));
    if n < 2 || scaled.iter().any(|v| !v.is_finite()) {
        return Vec::new();
    }
    let eigen = scaled.symmetric_eigen();
    let mut order: Vec<usize> = (0..n).filter(|&j| eigen.eigenvalues[j] > 0.0).collect();
    order.sort_by(|&i, &j| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]));
    let slope = DVector::from_fn(n, |i, _| g[moving[i]] / scale[i]);
    let mut step = DVector::<f64>::zeros(n);
    let mut steps = Vec::new();
    for &j in order.iter().take(FLATTEST.min(n - 1)) {
        let direction = eigen.eigenvectors.column(j);
        step -= direction * (direction.dot(&slope) / eigen.eigenvalues[j]);
        let mut moved = u.to_vec();
        for (i, &k) in moving.iter().enumerate() {
            let wanted = u[k] + step[i] / scale[i];
            moved[k] = coordinates.coordinate(k, coordinates.value(k, wanted));
        }
        steps.push((moved, -0.5 * step.dot(&slope)));
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;
    use sealegs_model::Parameter;

    #[test]
    fn analytic_the_flattest_directions_come_first_and_their_steps_lead_to_the_minimum() {
        let mut parameters = ["x", "y", "z"].map(|name| Parameter::new(name, "", 1.0, -9.0, 9.0));
        parameters.iter_mut().for_each(|p| p.typical = 1.0);
        let coordinates = Coordinates::new(&parameters);
        // Of x + y the cost knows much, of x - y little; z is free of both. The minimum is at (2, -1, 3).
        let a = DMatrix::from_row_slice(3, 3, &[1.01, 0.99, 0.0, 0.99, 1.01, 0.0, 0.0, 0.0, 1.0]);
        let to = DVector::from_vec(vec![2.0, -1.0, 3.0]);
        let g = -(&a * &to);
        let steps = along_flattest(&coordinates, &[0.0; 3], (&a, &g));
        let [(flattest, little), (two, more)] = &steps[..] else { panic!("{}", steps.len()) };
        assert!((flattest[0] - 1.5).abs() < 1e-9 && (flattest[1] + 1.5).abs() < 1e-9, "{flattest:?}");
        assert!(flattest[2].abs() < 1e-9 && (two[2] - 3.0).abs() < 1e-9, "{two:?}");
        // Half the curvature along x - y, 0.02, times the square of 3 over the root of two; 4.5 more along z.
        assert!((little - 0.045).abs() < 1e-9 && (more - 4.545).abs() < 1e-9, "{little} {more}");
    }

    #[test]
    fn analytic_a_step_beyond_a_bound_is_taken_without_that_coordinate() {
        let mut parameters =
            [Parameter::new("x", "", 1.0, -9.0, 1.0), Parameter::new("y", "", 0.0, -9.0, 9.0)];
        parameters.iter_mut().for_each(|p| p.typical = 1.0);
        let coordinates = Coordinates::new(&parameters);
        let u = coordinates.coordinates(&[1.0, 0.0]);
        let (a, g) = (DMatrix::identity(2, 2), DVector::from_vec(vec![-1.0, -1.0]));
        let Proposal::Step(moved, promised) = proposal(&coordinates, &u, &a, &g, 0.0) else {
            panic!("a step")
        };
        assert!((moved[0] - u[0]).abs() < 1e-12 && (moved[1] - u[1] - 1.0).abs() < 1e-9, "{moved:?}");
        assert!((promised - 0.5).abs() < 1e-9, "{promised}");
    }
}
