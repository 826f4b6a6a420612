//! Small symmetric positive definite systems.

/// Most unknowns.
pub(super) const MOST: usize = 16;

/// A matrix as the product of a lower triangle with its transpose, after Cholesky.
pub(super) struct Factor {
    lower: [[f64; MOST]; MOST],
    count: usize,
}

impl Factor {
    /// Of the leading block of a matrix, which is symmetric; not a number where it is not positive.
    pub fn of(mut a: [[f64; MOST]; MOST], count: usize) -> Self {
        for j in 0..count {
            for i in j..count {
                let mut sum = a[i][j];
                for k in 0..j {
                    sum -= a[i][k] * a[j][k];
                }
                a[i][j] = if i == j { sum.sqrt() } else { sum / a[j][j] };
            }
        }
        Self { lower: a, count }
    }

    /// Solves for a right-hand side.
    pub fn solve(&self, mut b: [f64; MOST]) -> [f64; MOST] {
        let l = &self.lower;
        for i in 0..self.count {
            for k in 0..i {
                b[i] -= l[i][k] * b[k];
            }
            b[i] /= l[i][i];
        }
        for i in (0..self.count).rev() {
            for k in i + 1..self.count {
                b[i] -= l[k][i] * b[k];
            }
            b[i] /= l[i][i];
        }
        b
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_a_known_solution_comes_back() {
        let mut a = [[0.0; MOST]; MOST];
        let rows = [[4.0, 1.0, -0.5], [1.0, 3.0, 0.25], [-0.5, 0.25, 2.0]];
        let x = [1.0, -2.0, 0.5];
        let mut b = [0.0; MOST];
        for i in 0..3 {
            a[i][..3].copy_from_slice(&rows[i]);
            b[i] = (0..3).map(|j| rows[i][j] * x[j]).sum();
        }
        let found = Factor::of(a, 3).solve(b);
        for i in 0..3 {
            assert!((found[i] - x[i]).abs() < 1e-14, "{found:?}");
        }
    }
}
