//! Parameters as a search sees them: free ones only, scaled, inside their bounds.

use sealegs_model::{Parameter, Scale};

/// The free parameters of a model, each mapped to a coordinate in which steps of order 1 (linear) or
/// of ratios (logarithmic) are natural.
#[derive(Debug, Clone)]
pub(crate) struct Coordinates {
    pub parameters: Vec<Parameter>,
    /// Indices of the free parameters.
    pub free: Vec<usize>,
}

/// On which bound a coordinate lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bound {
    /// The least admitted value.
    Min,
    /// The greatest.
    Max,
}

impl Coordinates {
    pub fn new(parameters: &[Parameter]) -> Self {
        let free =
            (0..parameters.len()).filter(|&i| !parameters[i].fixed && parameters[i].min < parameters[i].max);
        Self { free: free.collect(), parameters: parameters.to_vec() }
    }

    pub fn len(&self) -> usize {
        self.free.len()
    }

    fn of(&self, k: usize) -> &Parameter {
        &self.parameters[self.free[k]]
    }

    /// Whether a free parameter is searched in ratios: only where all of its range is positive in effect.
    fn logarithmic(&self, k: usize) -> bool {
        let p = self.of(k);
        p.scale == Scale::Logarithmic && p.min >= 0.0 && p.max > 0.0
    }

    /// The least value that a search uses: 0 has no logarithm.
    fn floor(&self, k: usize) -> f64 {
        let p = self.of(k);
        if self.logarithmic(k) {
            let size = if p.value > 0.0 { p.value } else { p.typical };
            p.min.max(1e-6 * size.min(p.max))
        } else {
            p.min
        }
    }

    pub fn value(&self, k: usize, u: f64) -> f64 {
        let p = self.of(k);
        let v = if self.logarithmic(k) { u.exp() } else { u * p.typical };
        v.clamp(self.floor(k), p.max)
    }

    pub fn coordinate(&self, k: usize, value: f64) -> f64 {
        let p = self.of(k);
        let v = value.clamp(self.floor(k), p.max);
        if self.logarithmic(k) { v.ln() } else { v / p.typical }
    }

    /// d value / d coordinate.
    pub fn slope(&self, k: usize, u: f64) -> f64 {
        if self.logarithmic(k) { self.value(k, u) } else { self.of(k).typical }
    }

    /// Step of a first finite difference: 0.2 % of a typical change, or 0.02 % of the value in ratios.
    pub fn difference(&self, k: usize) -> f64 {
        if self.logarithmic(k) { 2e-4 } else { 2e-3 }
    }

    /// The largest step that a search may take at once: ten typical changes, a factor of 4.5.
    pub fn largest_step(&self, k: usize) -> f64 {
        if self.logarithmic(k) { 1.5 } else { 10.0 }
    }

    /// All values, the fixed ones as given.
    pub fn values(&self, u: &[f64], base: &[f64]) -> Vec<f64> {
        let mut values = base.to_vec();
        for (k, &i) in self.free.iter().enumerate() {
            values[i] = self.value(k, u[k]);
        }
        values
    }

    pub fn coordinates(&self, values: &[f64]) -> Vec<f64> {
        (0..self.len()).map(|k| self.coordinate(k, values[self.free[k]])).collect()
    }

    pub fn bound(&self, k: usize, u: f64) -> Option<Bound> {
        let p = self.of(k);
        let v = self.value(k, u);
        let near = 1e-6 * p.typical;
        if v <= self.floor(k) + near.min(1e-3 * self.floor(k).abs() + f64::MIN_POSITIVE) || v <= p.min + near
        {
            Some(Bound::Min)
        } else if v >= p.max - near {
            Some(Bound::Max)
        } else {
            None
        }
    }

    /// Half the squared prior rows.
    pub fn prior_cost(&self, values: &[f64]) -> f64 {
        self.parameters
            .iter()
            .zip(values)
            .filter_map(|(p, v)| {
                (!p.fixed).then_some(p.prior_std.map(|s| 0.5 * ((v - p.value) / s).powi(2)))?
            })
            .sum()
    }

    /// A free parameter's prior row and its derivative by the coordinate.
    pub fn prior_row(&self, k: usize, u: f64) -> Option<(f64, f64)> {
        let p = self.of(k);
        p.prior_std.map(|s| ((self.value(k, u) - p.value) / s, self.slope(k, u) / s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_survive_the_way_there_and_back_and_respect_bounds() {
        let mut p = vec![
            Parameter::new("a", "", 3.0, -1.0, 5.0),
            Parameter::new("b", "", 10.0, 0.0, 1e4),
            Parameter::new("c", "", 1.0, 0.0, 2.0),
        ];
        p[1].scale = Scale::Logarithmic;
        p[2].fixed = true;
        let c = Coordinates::new(&p);
        assert_eq!(c.free, [0, 1]);
        let values = c.values(&c.coordinates(&[4.0, 123.0, 1.5]), &[0.0, 0.0, 1.5]);
        assert!((values[0] - 4.0).abs() < 1e-12 && (values[1] - 123.0).abs() < 1e-9 && values[2] == 1.5);
        assert_eq!(c.value(0, 1e9), 5.0);
        assert!(c.value(1, -1e9) > 0.0);
        assert_eq!(c.bound(0, 1e9), Some(Bound::Max));
        assert_eq!(c.bound(1, -1e9), Some(Bound::Min));
        assert_eq!(c.bound(1, 1.0), None);
    }
}
