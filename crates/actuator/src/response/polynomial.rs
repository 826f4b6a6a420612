//! Real polynomials in `s`: sums, products, values and roots.

use std::ops::{Add, Mul};

use num_complex::Complex64;

/// A polynomial by its coefficients, the constant term first.
#[derive(Debug, Clone, PartialEq)]
pub struct Polynomial(Vec<f64>);

impl Polynomial {
    /// From coefficients, the constant term first. Leading zeros are dropped.
    #[must_use]
    pub fn new(coefficients: impl Into<Vec<f64>>) -> Self {
        let mut coefficients = coefficients.into();
        while coefficients.len() > 1 && coefficients.last() == Some(&0.0) {
            coefficients.pop();
        }
        Self(coefficients)
    }

    /// A number.
    #[must_use]
    pub fn constant(value: f64) -> Self {
        Self(vec![value])
    }

    /// The coefficients, the constant term first.
    #[must_use]
    pub fn coefficients(&self) -> &[f64] {
        &self.0
    }

    /// The value at `s`.
    #[must_use]
    pub fn at(&self, s: Complex64) -> Complex64 {
        self.0.iter().rev().fold(Complex64::new(0.0, 0.0), |sum, &c| sum * s + c)
    }

    /// All roots, by ascending magnitude; each as often as it occurs.
    ///
    /// Durand and Kerner's iteration on the polynomial scaled to roots of the order of one.
    #[must_use]
    pub fn roots(&self) -> Vec<Complex64> {
        let zeros_at_origin = self.0.iter().take_while(|c| **c == 0.0).count();
        let coefficients = &self.0[zeros_at_origin.min(self.0.len())..];
        let mut roots = vec![Complex64::new(0.0, 0.0); zeros_at_origin.min(self.0.len().saturating_sub(1))];
        let degree = coefficients.len().saturating_sub(1);
        if degree == 0 {
            return roots;
        }
        // s = scale * z makes the constant and the leading coefficient equal in magnitude.
        let scale = (coefficients[0] / coefficients[degree]).abs().powf(1.0 / degree as f64);
        let monic: Vec<f64> = (0..=degree)
            .map(|i| coefficients[i] / coefficients[degree] * scale.powi(i as i32 - degree as i32))
            .collect();
        let monic = Self(monic);
        let seed = Complex64::new(0.4, 0.9);
        let mut z: Vec<Complex64> = (0..degree).map(|i| seed.powu(i as u32 + 1)).collect();
        for _ in 0..500 {
            let mut moved: f64 = 0.0;
            for i in 0..degree {
                let others =
                    (0..degree).filter(|&j| j != i).fold(Complex64::new(1.0, 0.0), |p, j| p * (z[i] - z[j]));
                let step = monic.at(z[i]) / others;
                if step.is_finite() {
                    z[i] -= step;
                    moved = moved.max(step.norm() / z[i].norm().max(f64::MIN_POSITIVE));
                }
            }
            if moved < 1e-15 {
                break;
            }
        }
        roots.extend(z.into_iter().map(|root| root * scale));
        roots.sort_by(|a, b| a.norm().total_cmp(&b.norm()).then(a.im.total_cmp(&b.im)));
        roots
    }
}

impl Add for &Polynomial {
    type Output = Polynomial;

    fn add(self, other: Self) -> Polynomial {
        let length = self.0.len().max(other.0.len());
        let at = |p: &Polynomial, i: usize| p.0.get(i).copied().unwrap_or(0.0);
        Polynomial::new((0..length).map(|i| at(self, i) + at(other, i)).collect::<Vec<_>>())
    }
}

impl Mul for &Polynomial {
    type Output = Polynomial;

    fn mul(self, other: Self) -> Polynomial {
        let mut product = vec![0.0; self.0.len() + other.0.len() - 1];
        for (i, a) in self.0.iter().enumerate() {
            for (j, b) in other.0.iter().enumerate() {
                product[i + j] += a * b;
            }
        }
        Polynomial::new(product)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_roots_of_a_product_of_known_factors() {
        // s^2 (s + 3) (s^2 + 2 s + 1e4) (s + 2e5): origin, real and complex roots over six decades.
        let p = [
            Polynomial::new([0.0, 0.0, 1.0]),
            Polynomial::new([3.0, 1.0]),
            Polynomial::new([1e4, 2.0, 1.0]),
            Polynomial::new([2e5, 1.0]),
        ]
        .iter()
        .fold(Polynomial::constant(1.0), |product, factor| &product * factor);
        let roots = p.roots();
        assert_eq!(roots.len(), 6);
        let expected = [
            Complex64::new(0.0, 0.0),
            Complex64::new(0.0, 0.0),
            Complex64::new(-3.0, 0.0),
            Complex64::new(-1.0, -(1e4_f64 - 1.0).sqrt()),
            Complex64::new(-1.0, (1e4_f64 - 1.0).sqrt()),
            Complex64::new(-2e5, 0.0),
        ];
        for (root, expected) in roots.iter().zip(expected) {
            assert!((root - expected).norm() <= 1e-9 * expected.norm(), "{root} against {expected}");
        }
        assert!(Polynomial::constant(2.0).roots().is_empty());
        assert!(Polynomial::constant(0.0).roots().is_empty());
    }
}
