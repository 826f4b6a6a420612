//! The linear part of the plant as mass, damping and stiffness matrices over its generalised coordinates.

use super::{GRAVITY_M_S2, Link, Plant};

/// Greatest number of generalised coordinates.
pub(super) const MOST: usize = 5;

/// A row or column over the generalised coordinates.
pub(super) type Row = [f64; MOST];

/// Which generalised coordinate is where; `None` where it does not move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Coordinates {
    /// Position of link 1.
    pub link_1: Option<usize>,
    /// Position of link 2.
    pub link_2: Option<usize>,
    /// End of the screw, if it is not link 2.
    pub screw_end: Option<usize>,
    /// Displacement of the wobbling mass.
    pub wobbling: Option<usize>,
    /// How many there are; the first, 0, is the screw's extension.
    pub count: usize,
}

impl Coordinates {
    /// The coordinates of a plant.
    #[must_use]
    pub fn of(plant: &Plant) -> Self {
        let mut count = 1;
        let mut next = |moves: bool| {
            moves.then(|| {
                count += 1;
                count - 1
            })
        };
        let link_1 = next(plant.link_1 != Link::Fixed);
        let link_2 = next(plant.link_2 != Link::Fixed);
        let screw_end = next(plant.series.is_some());
        let wobbling = next(plant.wobbling.is_some() && plant.link_2 != Link::Fixed);
        Self { link_1, link_2, screw_end, wobbling, count }
    }
}

/// `M q'' + C q' + K q`, with the rows of deflection and sprung mass.
#[derive(Debug, Clone)]
pub(super) struct LinearPart {
    pub coordinates: Coordinates,
    pub mass: [Row; MOST],
    pub damping: [Row; MOST],
    pub stiffness: [Row; MOST],
    /// `delta = deflection . q`.
    pub deflection: Row,
    /// `x_p = sprung . q`.
    pub sprung: Row,
}

impl LinearPart {
    pub fn of(plant: &Plant) -> Self {
        let at = Coordinates::of(plant);
        let unit = |i: Option<usize>| {
            let mut row = [0.0; MOST];
            if let Some(i) = i {
                row[i] = 1.0;
            }
            row
        };
        let (y, x_1, x_2) = (unit(Some(0)), unit(at.link_1), unit(at.link_2));
        let x_s = if at.screw_end.is_some() { unit(at.screw_end) } else { x_2 };
        let sprung = combine(1.0, &x_s, -1.0, &y);
        let deflection = combine(1.0, &x_1, -1.0, &sprung);

        let mut part = Self {
            coordinates: at,
            mass: [[0.0; MOST]; MOST],
            damping: [[0.0; MOST]; MOST],
            stiffness: [[0.0; MOST]; MOST],
            deflection,
            sprung,
        };
        add_square(&mut part.mass, plant.reflected_inertia, &y);
        add_square(&mut part.mass, plant.sprung_mass, &sprung);
        add_square(&mut part.damping, plant.damping, &y);
        if let Some(load) = plant.rigid.filter(|load| *load != Link::Fixed) {
            add_square(&mut part.mass, load.mass_kg(), &y);
            add_square(&mut part.stiffness, load.stiffness_n_m(), &y);
        }
        add_square(&mut part.damping, plant.laws.spring_damping, &deflection);
        add_square(&mut part.stiffness, plant.stiffness, &deflection);
        for (link, row) in [(plant.link_1, x_1), (plant.link_2, x_2)] {
            if link != Link::Fixed {
                add_square(&mut part.mass, link.mass_kg(), &row);
                add_square(&mut part.stiffness, link.stiffness_n_m(), &row);
                add_square(&mut part.damping, link.damping_n_s_m(), &row);
            }
        }
        if let Some(series) = plant.series {
            add_square(&mut part.mass, series.mass, &x_s);
            add_square(&mut part.stiffness, series.stiffness, &combine(1.0, &x_s, -1.0, &x_2));
        }
        if let (Some(wobbling), Some(w), Link::Pendulum { arm_m, .. }) =
            (plant.wobbling, at.wobbling, plant.link_2)
        {
            let w = unit(Some(w));
            let place = combine(wobbling.radius / arm_m, &x_2, 1.0, &w);
            let m = wobbling.mass;
            add_square(&mut part.mass, m, &place);
            add_square(&mut part.stiffness, m * wobbling.angular_frequency.powi(2), &w);
            add_square(&mut part.damping, 2.0 * wobbling.damping_ratio * wobbling.angular_frequency * m, &w);
            // Gravity about hanging: m g (radius theta^2 / 2 + w theta).
            add_square(&mut part.stiffness, m * GRAVITY_M_S2 * wobbling.radius / (arm_m * arm_m), &x_2);
            add_product(&mut part.stiffness, m * GRAVITY_M_S2 / arm_m, &x_2, &w);
        }
        part
    }
}

fn combine(a: f64, left: &Row, b: f64, right: &Row) -> Row {
    std::array::from_fn(|i| a * left[i] + b * right[i])
}

/// Adds `factor row row^T`.
fn add_square(matrix: &mut [Row; MOST], factor: f64, row: &Row) {
    for i in 0..MOST {
        for j in 0..MOST {
            matrix[i][j] += factor * row[i] * row[j];
        }
    }
}

/// Adds `factor (left right^T + right left^T)`, the Hessian of `factor (left.q) (right.q)`.
fn add_product(matrix: &mut [Row; MOST], factor: f64, left: &Row, right: &Row) {
    for i in 0..MOST {
        for j in 0..MOST {
            matrix[i][j] += factor * (left[i] * right[j] + right[i] * left[j]);
        }
    }
}

impl LinearPart {
    /// The inverse of the mass matrix, or `None` if it is singular.
    pub fn inverse_mass<const N: usize>(&self) -> Option<[[f64; N]; N]> {
        inverse(&self.mass)
    }
}

/// What a step of length `h` does: exact for the linear part and forces that are constant over the step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Propagator<const N: usize> {
    /// Position after a step from position and from velocity.
    pub position_from: ([[f64; N]; N], [[f64; N]; N]),
    /// Velocity after a step from position and from velocity.
    pub velocity_from: ([[f64; N]; N], [[f64; N]; N]),
    /// Change of position and of velocity per force.
    pub by_force: ([[f64; N]; N], [[f64; N]; N]),
}

/// Size of the matrix whose exponential holds a step: position, velocity, force.
const AUGMENTED: usize = 3 * MOST;
type Augmented = [[f64; AUGMENTED]; AUGMENTED];

impl LinearPart {
    /// The propagator over a step, or `None` if the mass matrix is singular.
    ///
    /// The exponential of `h [[0, 1, 0], [-M^-1 K, -M^-1 C, M^-1], [0, 0, 0]]` by its Taylor series after
    /// scaling, squared back (C. Van Loan 1978, IEEE Trans. Automatic Control 23(3), for the force block).
    pub fn propagator<const N: usize>(&self, h: f64) -> Option<Propagator<N>> {
        let inverse = inverse::<N>(&self.mass)?;
        let mut a = [[0.0; AUGMENTED]; AUGMENTED];
        for i in 0..N {
            a[i][N + i] = h;
            for j in 0..N {
                for k in 0..N {
                    a[N + i][j] -= h * inverse[i][k] * self.stiffness[k][j];
                    a[N + i][N + j] -= h * inverse[i][k] * self.damping[k][j];
                }
                a[N + i][2 * N + j] = h * inverse[i][j];
            }
        }
        let e = exponential(&a, 3 * N);
        let block = |row: usize, column: usize| -> [[f64; N]; N] {
            std::array::from_fn(|i| std::array::from_fn(|j| e[row * N + i][column * N + j]))
        };
        Some(Propagator {
            position_from: (block(0, 0), block(0, 1)),
            velocity_from: (block(1, 0), block(1, 1)),
            by_force: (block(0, 2), block(1, 2)),
        })
    }
}

/// The exponential of the leading `n` x `n` block.
fn exponential(a: &Augmented, n: usize) -> Augmented {
    let product = |x: &Augmented, y: &Augmented| {
        let mut z = [[0.0; AUGMENTED]; AUGMENTED];
        for i in 0..n {
            for k in 0..n {
                for j in 0..n {
                    z[i][j] += x[i][k] * y[k][j];
                }
            }
        }
        z
    };
    let norm = (0..n).map(|i| a[i][..n].iter().map(|v| v.abs()).sum::<f64>()).fold(0.0, f64::max);
    let squarings = if norm.is_finite() { (norm / 0.25).log2().ceil().clamp(0.0, 60.0) as i32 } else { 0 };
    let scale = 0.5_f64.powi(squarings);
    let mut scaled = *a;
    scaled.iter_mut().flatten().for_each(|v| *v *= scale);
    let mut sum = [[0.0; AUGMENTED]; AUGMENTED];
    let mut term = sum;
    for i in 0..n {
        sum[i][i] = 1.0;
        term[i][i] = 1.0;
    }
    // 0.25^13 / 13! is below the rounding of 1.
    for order in 1..=13 {
        term = product(&term, &scaled);
        term.iter_mut().flatten().for_each(|v| *v /= f64::from(order));
        for i in 0..n {
            for j in 0..n {
                sum[i][j] += term[i][j];
            }
        }
    }
    for _ in 0..squarings {
        sum = product(&sum, &sum);
    }
    sum
}

/// The inverse of the leading N x N block by Gauss-Jordan elimination with partial pivoting, or `None` if
/// it is singular.
fn inverse<const N: usize>(matrix: &[Row; MOST]) -> Option<[[f64; N]; N]> {
    let mut a: [[f64; N]; N] = std::array::from_fn(|i| std::array::from_fn(|j| matrix[i][j]));
    let mut inverse: [[f64; N]; N] =
        std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    for column in 0..N {
        let pivot = (column..N).max_by(|&i, &j| a[i][column].abs().total_cmp(&a[j][column].abs()))?;
        if a[pivot][column] == 0.0 || !a[pivot][column].is_finite() {
            return None;
        }
        a.swap(column, pivot);
        inverse.swap(column, pivot);
        let scale = 1.0 / a[column][column];
        for j in 0..N {
            a[column][j] *= scale;
            inverse[column][j] *= scale;
        }
        for i in 0..N {
            if i != column {
                let factor = a[i][column];
                for j in 0..N {
                    a[i][j] -= factor * a[column][j];
                    inverse[i][j] -= factor * inverse[column][j];
                }
            }
        }
    }
    Some(inverse)
}
