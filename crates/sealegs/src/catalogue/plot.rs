//! A graph drawn: by dots in a terminal, and as SVG for a page.

use sealegs_actuator::effect::{Graph, GraphAxis};
use std::fmt::Write as _;

/// Size of a drawing in a terminal, characters; each holds two dots by four.
const COLUMNS: usize = 64;
const ROWS: usize = 10;

/// Width and height of a picture, and the room for its labels.
const WIDTH: f64 = 520.0;
const HEIGHT: f64 = 260.0;
const LEFT: f64 = 84.0;
const BELOW: f64 = 44.0;
const ABOVE: f64 = 26.0;
const RIGHT: f64 = 12.0;

/// Points of a curve in a picture; a longer one keeps its peaks.
const DRAWN: usize = 600;

/// Least and greatest of what is shown; a line without height gets some.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    if !low.is_finite() {
        return (0.0, 1.0);
    }
    if high - low > 1e-12 * high.abs().max(low.abs()) {
        return (low, high);
    }
    let half = if low == 0.0 { 1.0 } else { 0.5 * low.abs() };
    (low - half, high + half)
}

/// The ranges of a graph's argument and of its values.
fn ranges(graph: &Graph) -> ((f64, f64), (f64, f64)) {
    let points = || graph.curves.iter().flat_map(|c| &c.points);
    (range(points().map(|p| p.0)), range(points().map(|p| p.1)))
}

/// A factor and the unit that it leads to, so that numbers need few digits.
fn scaled(axis: &GraphAxis, (low, high): (f64, f64)) -> (f64, String) {
    let peak = low.abs().max(high.abs());
    let unit = axis.unit.as_str();
    if peak == 0.0 || !matches!(unit, "m" | "N" | "s" | "rad" | "A" | "V" | "J" | "m/s" | "rad/s" | "N m") {
        return (1.0, unit.to_owned());
    }
    let (factor, prefix) = match peak {
        p if p < 1e-3 => (1e6, "u"),
        p if p < 0.5 => (1e3, "m"),
        p if p >= 5e3 => (1e-3, "k"),
        _ => (1.0, ""),
    };
    (factor, format!("{prefix}{unit}"))
}

/// A number with three significant digits.
fn number(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let digits = (2 - value.abs().log10().floor() as i32).clamp(0, 12) as usize;
    let text = format!("{value:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// What an axis is, with its unit.
fn label(axis: &GraphAxis, unit: &str) -> String {
    if unit.is_empty() { axis.name.clone() } else { format!("{}, {unit}", axis.name) }
}

/// The graph in text, by dots; of several curves the first is dotted.
#[must_use]
pub fn braille(graph: &Graph) -> String {
    let (x, y) = ranges(graph);
    let (wide, high) = (2 * COLUMNS, 4 * ROWS);
    let mut dots = vec![false; wide * high];
    let place = |value: f64, (low, top): (f64, f64), count: usize| {
        (((value - low) / (top - low) * (count - 1) as f64).round() as usize).min(count - 1)
    };
    for (index, curve) in graph.curves.iter().enumerate() {
        let dotted = index == 0 && graph.curves.len() > 1;
        let mut drawn = 0_usize;
        for pair in curve.points.windows(2) {
            let ends = [pair[0], pair[1]].map(|(a, b)| (place(a, x, wide), place(b, y, high)));
            let steps = ends[0].0.abs_diff(ends[1].0).max(ends[0].1.abs_diff(ends[1].1)).max(1);
            for i in 0..=steps {
                let along = |a: usize, b: usize| {
                    (a as f64 + (b as f64 - a as f64) * i as f64 / steps as f64).round() as usize
                };
                let (column, row) = (along(ends[0].0, ends[1].0), along(ends[0].1, ends[1].1));
                drawn += 1;
                if !dotted || drawn.is_multiple_of(5) {
                    dots[(high - 1 - row) * wide + column] = true;
                }
            }
        }
    }
    let ((fx, ux), (fy, uy)) = (scaled(&graph.x, x), scaled(&graph.y, y));
    let (top, bottom) = (number(fy * y.1), number(fy * y.0));
    let margin = top.chars().count().max(bottom.chars().count());
    let mut out = format!("{}: {}\n", graph.title, label(&graph.y, &uy));
    for row in 0..ROWS {
        let named = if row == 0 {
            &top
        } else if row == ROWS - 1 {
            &bottom
        } else {
            ""
        };
        let _ = write!(out, "  {named:>margin$} ");
        for column in 0..COLUMNS {
            // The dots of a braille character: 1 2 3 7 down the left, 4 5 6 8 down the right.
            const BITS: [[u32; 4]; 2] = [[0x01, 0x02, 0x04, 0x40], [0x08, 0x10, 0x20, 0x80]];
            let mut code = 0x2800;
            for (dx, bits) in BITS.iter().enumerate() {
                for (dy, bit) in bits.iter().enumerate() {
                    if dots[(4 * row + dy) * wide + 2 * column + dx] {
                        code |= bit;
                    }
                }
            }
            out.push(char::from_u32(code).unwrap_or(' '));
        }
        out.push('\n');
    }
    let (from, to) = (number(fx * x.0), number(fx * x.1));
    let name = label(&graph.x, &ux);
    let between = COLUMNS.saturating_sub(from.chars().count() + to.chars().count());
    let _ = writeln!(out, "  {:margin$} {from}{name:^between$}{to}", "");
    if graph.curves.len() > 1 {
        let names: Vec<String> = graph
            .curves
            .iter()
            .enumerate()
            .map(|(i, c)| format!("{} {}", if i == 0 { "dotted:" } else { "line:" }, c.label))
            .collect();
        let _ = writeln!(out, "  {:margin$} {}", "", names.join("; "));
    }
    out
}

/// The graph as one `<svg>` element in one line, in the colour of the text around it.
#[must_use]
pub fn svg(graph: &Graph) -> String {
    use sealegs_recorder::chart::{decimate, escape};
    let (x, y) = ranges(graph);
    let (inner_width, inner_height) = (WIDTH - LEFT - RIGHT, HEIGHT - ABOVE - BELOW);
    let px = |v: f64| LEFT + (v - x.0) / (x.1 - x.0) * inner_width;
    let py = |v: f64| ABOVE + (y.1 - v) / (y.1 - y.0) * inner_height;
    let ((fx, ux), (fy, uy)) = (scaled(&graph.x, x), scaled(&graph.y, y));
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{}\" \
         style=\"max-width:{WIDTH}px\" fill=\"currentColor\" font-size=\"12\" font-family=\"sans-serif\">",
        escape(&graph.title)
    );
    let _ = write!(
        out,
        "<rect x=\"{LEFT}\" y=\"{ABOVE}\" width=\"{inner_width}\" height=\"{inner_height}\" fill=\"none\" \
         stroke=\"currentColor\" stroke-opacity=\"0.4\"/>"
    );
    for (axis, zero) in [(true, x.0 < 0.0 && x.1 > 0.0), (false, y.0 < 0.0 && y.1 > 0.0)] {
        if zero {
            let (x1, y1, x2, y2) = if axis {
                (px(0.0), ABOVE, px(0.0), ABOVE + inner_height)
            } else {
                (LEFT, py(0.0), LEFT + inner_width, py(0.0))
            };
            let _ = write!(
                out,
                "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" stroke=\"currentColor\" \
                 stroke-opacity=\"0.25\"/>"
            );
        }
    }
    for (index, curve) in graph.curves.iter().enumerate() {
        let first = index == 0 && graph.curves.len() > 1;
        let style =
            if first { " stroke-dasharray=\"5 4\" stroke-opacity=\"0.7\"" } else { " stroke-width=\"1.8\"" };
        let _ = write!(out, "<polyline fill=\"none\" stroke=\"currentColor\"{style} points=\"");
        let points = decimate(&curve.points, DRAWN);
        for (i, (a, b)) in points.iter().filter(|(a, b)| a.is_finite() && b.is_finite()).enumerate() {
            let _ = write!(out, "{}{:.1},{:.1}", if i == 0 { "" } else { " " }, px(*a), py(*b));
        }
        out.push_str("\"/>");
    }
    let mut say = |x: f64, y: f64, anchor: &str, text: &str| {
        let _ =
            write!(out, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}</text>", escape(text));
    };
    let bottom = ABOVE + inner_height;
    say(LEFT - 6.0, ABOVE + 10.0, "end", &number(fy * y.1));
    say(LEFT - 6.0, bottom, "end", &number(fy * y.0));
    say(LEFT, bottom + 16.0, "start", &number(fx * x.0));
    say(WIDTH - RIGHT, bottom + 16.0, "end", &number(fx * x.1));
    say(LEFT + 0.5 * inner_width, bottom + 16.0, "middle", &label(&graph.x, &ux));
    say(LEFT, ABOVE - 10.0, "start", &label(&graph.y, &uy));
    if graph.curves.len() > 1 {
        let names: Vec<&str> = graph.curves.iter().map(|c| c.label.as_str()).collect();
        let rest = names[1..].join(", ");
        say(
            LEFT + 0.5 * inner_width,
            bottom + 34.0,
            "middle",
            &format!("dashed: {}; line: {rest}", names[0]),
        );
    }
    out.push_str("</svg>");
    out
}
