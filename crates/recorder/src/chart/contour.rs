//! Lines of equal value by marching squares.

use super::Contours;
use std::collections::BTreeMap;

/// An edge of the grid: the lower left corner of it and whether it goes up.
type Edge = (usize, usize, bool);

/// The lines on which the grid's values, linear between its points, equal `level`; in data coordinates.
///
/// Cells with a corner that is not a number are left out.
pub(super) fn contour_lines(grid: &Contours, level: f64) -> Vec<Vec<(f64, f64)>> {
    let (columns, rows) = (grid.x.len(), grid.y.len());
    if columns < 2 || rows < 2 || grid.values.len() != columns * rows {
        return Vec::new();
    }
    let value = |i: usize, j: usize| grid.values[j * columns + i] - level;
    // Each edge that the level crosses belongs to at most two segments: a graph of paths and loops.
    let mut neighbours: BTreeMap<Edge, Vec<Edge>> = BTreeMap::new();
    let mut join = |a: Edge, b: Edge| {
        neighbours.entry(a).or_default().push(b);
        neighbours.entry(b).or_default().push(a);
    };
    for j in 0..rows - 1 {
        for i in 0..columns - 1 {
            let corners = [value(i, j), value(i + 1, j), value(i + 1, j + 1), value(i, j + 1)];
            if corners.iter().any(|v| !v.is_finite()) {
                continue;
            }
            let edges: [Edge; 4] = [(i, j, false), (i + 1, j, true), (i, j + 1, false), (i, j, true)];
            let above = corners.map(|v| v >= 0.0);
            let crossed: Vec<Edge> =
                (0..4).filter(|&e| above[e] != above[(e + 1) % 4]).map(|e| edges[e]).collect();
            match crossed[..] {
                [a, b] => join(a, b),
                [a, b, c, d] => {
                    // A saddle: the value in the middle says which corners hang together.
                    let middle = corners.iter().sum::<f64>() >= 0.0;
                    if middle == above[0] {
                        join(a, b);
                        join(c, d);
                    } else {
                        join(a, d);
                        join(b, c);
                    }
                }
                _ => {}
            }
        }
    }
    let place = |(i, j, up): Edge| {
        let (k, l) = if up { (i, j + 1) } else { (i + 1, j) };
        let (a, b) = (value(i, j), value(k, l));
        let t = if a == b { 0.5 } else { a / (a - b) };
        (grid.x[i] + t * (grid.x[k] - grid.x[i]), grid.y[j] + t * (grid.y[l] - grid.y[j]))
    };
    let mut lines = Vec::new();
    // Open lines from their ends first; what is left are loops.
    let ends: Vec<Edge> = neighbours.iter().filter(|(_, n)| n.len() == 1).map(|(e, _)| *e).collect();
    let all: Vec<Edge> = neighbours.keys().copied().collect();
    for start in ends.into_iter().chain(all) {
        let mut path = vec![start];
        while let Some(next) = path.last().and_then(|at| neighbours.get_mut(at)).and_then(Vec::pop) {
            let at = path[path.len() - 1];
            if let Some(back) = neighbours.get_mut(&next)
                && let Some(k) = back.iter().position(|e| *e == at)
            {
                back.swap_remove(k);
            }
            path.push(next);
        }
        if path.len() > 1 {
            lines.push(path.into_iter().map(place).collect());
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(f: impl Fn(f64, f64) -> f64) -> Contours {
        let axis: Vec<f64> = (0..41).map(|i| -2.0 + 0.1 * f64::from(i)).collect();
        let values =
            axis.iter().flat_map(|&y| axis.iter().map(move |&x| (x, y))).map(|(x, y)| f(x, y)).collect();
        Contours { x: axis.clone(), y: axis, values, ..Contours::default() }
    }

    #[test]
    fn analytic_a_circle_is_one_closed_line_at_its_radius() {
        let lines = contour_lines(&grid(|x, y| x * x + y * y), 1.5 * 1.5);
        assert_eq!(lines.len(), 1);
        assert_eq!(lines[0].first(), lines[0].last());
        // Linear interpolation of a parabola over a tenth is off by at most h^2/8 / slope.
        assert!(lines[0].iter().all(|(x, y)| (f64::hypot(*x, *y) - 1.5).abs() < 1e-3));
    }

    #[test]
    fn analytic_a_slope_is_one_straight_open_line() {
        let lines = contour_lines(&grid(|x, y| x + 0.5 * y), 0.25);
        assert_eq!(lines.len(), 1);
        assert!(lines[0].iter().all(|(x, y)| (x + 0.5 * y - 0.25).abs() < 1e-12));
        let ends = [lines[0][0].1, lines[0][lines[0].len() - 1].1];
        assert!(ends.contains(&-2.0) && ends.contains(&2.0));
    }

    #[test]
    fn a_level_that_is_nowhere_has_no_line() {
        assert!(contour_lines(&grid(|x, _| x), 9.0).is_empty());
        assert!(contour_lines(&Contours::default(), 0.0).is_empty());
    }
}
