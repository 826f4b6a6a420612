//! Draws a chart as SVG: title, legend above the frame, axes, and what is between them.

use super::axis::axis_label;
use super::contour::contour_lines;
use super::svg::{line, open, points, px, text, text_width, wrap};
use super::{AxisScale, Chart, Dash, Hue, Line, Marker, Picture, Size, Ticks, decimate};

/// The frame of a chart and how values become pixels.
struct Frame<'a> {
    chart: &'a Chart,
    left: f64,
    top: f64,
    width: f64,
    height: f64,
    x: (f64, f64),
    y: (f64, f64),
}

impl Frame<'_> {
    fn share(scale: AxisScale, (low, high): (f64, f64), value: f64) -> f64 {
        match scale {
            AxisScale::Linear => (value - low) / (high - low),
            AxisScale::Logarithmic => (value / low).ln() / (high / low).ln(),
        }
    }

    fn px_x(&self, value: f64) -> f64 {
        self.left + self.width * Self::share(self.chart.x.scale, self.x, value)
    }

    fn px_y(&self, value: f64) -> f64 {
        // Far outside the frame is as good as anywhere outside it, and keeps numbers short.
        let share = Self::share(self.chart.y.scale, self.y, value).clamp(-20.0, 21.0);
        self.top + self.height * (1.0 - share)
    }

    fn point(&self, (a, b): (f64, f64)) -> Option<(f64, f64)> {
        (self.chart.x.admits(a) && self.chart.y.admits(b)).then(|| (self.px_x(a), self.px_y(b)))
    }

    fn right(&self) -> f64 {
        self.left + self.width
    }

    fn bottom(&self) -> f64 {
        self.top + self.height
    }
}

impl Picture for Chart {
    fn height(&self, size: Size) -> f64 {
        self.height.map_or(size.height, |h| if size.width < 500.0 { h.min(1.1 * size.height) } else { h })
    }

    fn svg(&self, size: Size) -> String {
        let (x, y) = self.ranges();
        // Room on the left for the widest tick label; the ticks depend on the height only weakly.
        let y_ticks = Ticks::new(self.y.scale, y, ((size.height - 90.0) / 48.0).max(3.0) as usize);
        let widest = y_ticks.major.iter().map(|(_, l)| text_width(l, 12.0)).fold(0.0, f64::max);
        // At least a usual width, so that pictures below each other have one left edge.
        let left = 12.0 + 18.0 + widest.max(36.0) + 8.0;
        let right = 16.0;
        let mut head = String::new();
        let mut top = 6.0;
        for part in wrap(&self.title, 16.0, size.width - 16.0) {
            top += 17.0;
            head.push_str(&text(8.0, top, "start", "ttl", &part));
        }
        top += 6.0;
        top = legend(self, left, size.width - right, top, &mut head) + 8.0;
        let bottom = size.height - 46.0;
        let frame = Frame {
            chart: self,
            left,
            top,
            width: size.width - right - left,
            height: (bottom - top).max(40.0),
            x,
            y,
        };
        let x_ticks = Ticks::new(self.x.scale, x, (frame.width / 85.0).max(2.0) as usize);

        let mut svg =
            open(size.width, size.height, &self.title, &zoom_attributes(&frame, &x_ticks, &y_ticks));
        svg.push_str(&head);
        svg.push_str(&axes(&frame, &x_ticks, &y_ticks));
        // Named by its own rectangle: equal names on a page are equal clips, and the same input the same text.
        let clip =
            [frame.left, frame.top, frame.width, frame.height].map(|v| format!("{:.0}", 10.0 * v)).join("-");
        let clip = format!("clip-{clip}");
        svg.push_str(&format!(
            "<clipPath id=\"{clip}\"><rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/></clipPath><g clip-path=\"url(#{clip})\">",
            px(frame.left), px(frame.top), px(frame.width), px(frame.height)
        ));
        let mut taken = Vec::new();
        svg.push_str(&inside(&frame, size, &mut taken));
        svg.push_str("</g>");
        svg.push_str(&references(&frame));
        svg.push_str(&notes(&frame, taken));
        svg.push_str("</svg>");
        svg
    }
}

fn zoom_attributes(frame: &Frame<'_>, x_ticks: &Ticks, y_ticks: &Ticks) -> String {
    let chart = frame.chart;
    match &chart.zoom {
        Some(group) if chart.x.scale == AxisScale::Linear => format!(
            "class=\"zoom\" data-box=\"{} {} {} {}\" data-x=\"{:e} {:e}\" data-y=\"{:e} {:e}\" data-unit=\"1e{} 1e{}\" data-logy=\"{}\" data-group=\"{}\"",
            px(frame.left),
            px(frame.top),
            px(frame.width),
            px(frame.height),
            frame.x.0,
            frame.x.1,
            frame.y.0,
            frame.y.1,
            x_ticks.exponent,
            y_ticks.exponent,
            u8::from(chart.y.scale == AxisScale::Logarithmic),
            super::escape(group)
        ),
        _ => String::new(),
    }
}

/// Draws the legend in rows from `top` and returns where it ends.
fn legend(chart: &Chart, left: f64, right: f64, top: f64, out: &mut String) -> f64 {
    enum Key<'a> {
        Line(&'a Line),
        Area(Hue, &'static str),
        Contour(Hue, Dash),
    }
    let mut entries: Vec<(&str, Key<'_>)> = Vec::new();
    entries.extend(chart.lines.iter().map(|l| (l.label.as_str(), Key::Line(l))));
    entries.extend(chart.contours.iter().map(|c| (c.label.as_str(), Key::Contour(c.hue, c.dash))));
    entries.extend(chart.bands.iter().map(|b| (b.label.as_str(), Key::Area(b.hue, "bd"))));
    entries.extend(chart.histogram.iter().map(|(_, _, label, hue)| (label.as_str(), Key::Area(*hue, "br"))));
    entries.retain(|(label, _)| !label.is_empty());
    if entries.is_empty() {
        return top;
    }
    let (mut x, mut y) = (left, top + 10.0);
    for (label, key) in entries {
        let width = 34.0 + text_width(label, 13.0) + 16.0;
        if x > left && x + width - 16.0 > right {
            x = left;
            y += 19.0;
        }
        let middle = y - 4.0;
        match key {
            Key::Line(l) => {
                if let Some(dash) = l.dash {
                    out.push_str(&polyline(&[(x, middle), (x + 28.0, middle)], l.hue, dash, ""));
                }
                if let Some(marker) = l.marker {
                    out.push_str(&mark(marker, (x + 14.0, middle), l.hue));
                }
            }
            Key::Contour(hue, dash) => {
                out.push_str(&polyline(&[(x, middle), (x + 28.0, middle)], hue, dash, ""));
            }
            Key::Area(hue, class) => out.push_str(&format!(
                "<rect x=\"{}\" y=\"{}\" width=\"28\" height=\"11\" class=\"{class} {}\"/>",
                px(x),
                px(middle - 5.5),
                hue.class()
            )),
        }
        out.push_str(&text(x + 34.0, y, "start", "leg", label));
        x += width;
    }
    y + 2.0
}

fn axes(frame: &Frame<'_>, x_ticks: &Ticks, y_ticks: &Ticks) -> String {
    let (left, right, top, bottom) = (frame.left, frame.right(), frame.top, frame.bottom());
    let mut svg = String::from("<g class=\"ticks\">");
    for v in &x_ticks.minor {
        svg.push_str(&line((frame.px_x(*v), top), (frame.px_x(*v), bottom), "gm"));
    }
    for v in &y_ticks.minor {
        svg.push_str(&line((left, frame.px_y(*v)), (right, frame.px_y(*v)), "gm"));
    }
    let mut free = f64::NEG_INFINITY;
    for (v, label) in &x_ticks.major {
        let x = frame.px_x(*v);
        svg.push_str(&line((x, top), (x, bottom), "gr"));
        let half = 0.5 * text_width(label, 12.0);
        // Labels that would touch are left out; the line stays.
        if x - half >= free && x + half <= right + 16.0 {
            svg.push_str(&text(x, bottom + 17.0, "middle", "tick", label));
            free = x + half + 6.0;
        }
    }
    let mut above = f64::INFINITY;
    for (v, label) in &y_ticks.major {
        let y = frame.px_y(*v);
        svg.push_str(&line((left, y), (right, y), "gr"));
        if y + 7.0 <= above {
            svg.push_str(&text(left - 7.0, y + 4.0, "end", "tick", label));
            above = y - 7.0;
        }
    }
    svg.push_str("</g>");
    svg.push_str(&format!(
        "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" class=\"fr\"/>",
        px(left),
        px(top),
        px(frame.width),
        px(frame.height)
    ));
    let x_label = axis_label(&frame.chart.x, x_ticks.exponent);
    svg.push_str(&text(0.5 * (left + right), bottom + 37.0, "middle", "lab", &x_label));
    let y_label = axis_label(&frame.chart.y, y_ticks.exponent);
    // A vertical label may be as long as the picture is high; a longer one is squeezed, not cut.
    let room = bottom - 4.0;
    let squeeze = if text_width(&y_label, 12.0) > room {
        format!(" textLength=\"{}\" lengthAdjust=\"spacingAndGlyphs\"", px(room))
    } else {
        String::new()
    };
    let centre = (0.5 * (top + bottom)).min(bottom - 0.5 * text_width(&y_label, 12.0).min(room) + 20.0);
    svg.push_str(&format!(
        "<text transform=\"translate(17 {}) rotate(-90)\" text-anchor=\"middle\" class=\"lab\"{squeeze}>{}</text>",
        px(centre),
        super::escape(&y_label)
    ));
    svg
}

/// What is clipped to the frame; the boxes of words in it are added to `taken`.
fn inside(frame: &Frame<'_>, size: Size, taken: &mut Vec<[f64; 4]>) -> String {
    let chart = frame.chart;
    let mut svg = String::new();
    for band in &chart.bands {
        let bounds: Vec<(f64, f64, f64)> = band
            .points
            .iter()
            .filter_map(|(a, low, high)| {
                Some((frame.point((*a, *low))?.0, frame.px_y(*low), frame.point((*a, *high))?.1))
            })
            .collect();
        let low: Vec<(f64, f64)> = bounds.iter().map(|b| (b.0, b.1)).collect();
        let high: Vec<(f64, f64)> = bounds.iter().map(|b| (b.0, b.2)).collect();
        let mut outline = decimate(&low, size.points / 2);
        outline.extend(decimate(&high, size.points / 2).into_iter().rev());
        svg.push_str(&format!(
            "<polygon points=\"{}\" class=\"bd {} d\"/>",
            points(&outline),
            band.hue.class()
        ));
    }
    if let Some((edges, heights, _, hue)) = &chart.histogram {
        for (edge, height) in edges.windows(2).zip(heights) {
            let (a, b, y) = (frame.px_x(edge[0]), frame.px_x(edge[1]), frame.px_y(*height));
            let ground = if chart.y.scale == AxisScale::Linear { frame.px_y(0.0) } else { frame.bottom() };
            if [a, b, y].iter().all(|v| v.is_finite()) {
                svg.push_str(&format!(
                    "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" class=\"br {}\"/>",
                    px(a + 0.5),
                    px(y.min(ground)),
                    px((b - a - 1.0).max(0.5)),
                    px((ground - y).abs()),
                    hue.class()
                ));
            }
        }
    }
    for contours in &chart.contours {
        for (level, label) in &contours.levels {
            let lines = contour_lines(contours, *level);
            let mut longest: Option<Vec<(f64, f64)>> = None;
            for path in lines {
                let drawn: Vec<(f64, f64)> = path.iter().filter_map(|p| frame.point(*p)).collect();
                svg.push_str(&polyline(&drawn, contours.hue, contours.dash, ""));
                if longest.as_ref().is_none_or(|l| l.len() < drawn.len()) {
                    longest = Some(drawn);
                }
            }
            if let Some((x, y)) = longest.as_ref().and_then(|l| l.get(l.len() / 2)) {
                let half = 0.5 * text_width(label, 12.0) + 2.0;
                let x = x.clamp(frame.left + half, (frame.right() - half).max(frame.left + half));
                svg.push_str(&text(x, y + 4.0, "middle", "halo", label));
                taken.push([x - half, y - 7.0, x + half, y + 7.0]);
            }
        }
    }
    for l in &chart.lines {
        svg.push_str(&series(frame, l, size));
    }
    svg
}

fn series(frame: &Frame<'_>, l: &Line, size: Size) -> String {
    let all: Vec<(f64, f64)> =
        l.points.iter().map(|p| frame.point(*p).unwrap_or((f64::NAN, f64::NAN))).collect();
    let mut svg = String::new();
    if let Some(dash) = l.dash {
        for run in decimate(&all, size.points).split(|p| !p.1.is_finite()).filter(|run| run.len() > 1) {
            svg.push_str(&polyline(run, l.hue, dash, " d"));
        }
    }
    if let Some(marker) = l.marker {
        let visible: Vec<(f64, f64)> = all.iter().copied().filter(|p| p.1.is_finite()).collect();
        // Marks on a line tell it from others; two dozen do. Scattered points are the data.
        let limit = if l.dash.is_some() { 24 } else { size.points };
        let every = visible.len().div_ceil(limit).max(1);
        if marker == Marker::Dot && visible.len() > 60 {
            let dots: String =
                visible.iter().step_by(every).map(|(x, y)| format!("M{} {}h0", px(*x), px(*y))).collect();
            svg.push_str(&format!(
                "<path d=\"{dots}\" class=\"ln {}\" style=\"stroke-width:3.2;stroke-linecap:round\"/>",
                l.hue.class()
            ));
        } else {
            svg.extend(visible.iter().step_by(every).map(|p| mark(marker, *p, l.hue)));
        }
    }
    svg
}

/// Reference lines with their names inside the frame.
fn references(frame: &Frame<'_>) -> String {
    let mut svg = String::new();
    for (i, (at, label)) in frame.chart.verticals.iter().enumerate() {
        let x = frame.px_x(*at);
        if !x.is_finite() || x < frame.left - 0.5 || x > frame.right() + 0.5 {
            continue;
        }
        svg.push_str(&line((x, frame.top), (x, frame.bottom()), "rf h7"));
        // At the bottom: peaks, which such lines mark, are at the top.
        let y = frame.bottom() - 8.0 - 15.0 * (i % 4) as f64;
        let width = text_width(label, 12.0);
        let (x, anchor) = if x + 4.0 + width <= frame.right() {
            (x + 4.0, "start")
        } else if x - 4.0 - width >= frame.left {
            (x - 4.0, "end")
        } else {
            (frame.left + 4.0, "start")
        };
        svg.push_str(&text(x, y, anchor, "halo", label));
    }
    for (at, label) in &frame.chart.horizontals {
        let y = frame.px_y(*at);
        if !y.is_finite() || y < frame.top - 0.5 || y > frame.bottom() + 0.5 {
            continue;
        }
        svg.push_str(&line((frame.left, y), (frame.right(), y), "rf h7"));
        let above = if y - 16.0 > frame.top { y - 5.0 } else { y + 15.0 };
        svg.push_str(&text(frame.right() - 5.0, above, "end", "halo", label));
    }
    svg
}

/// Marked points, each with its words where the frame leaves room and no earlier words are.
fn notes(frame: &Frame<'_>, mut taken: Vec<[f64; 4]>) -> String {
    let mut svg = String::new();
    for note in &frame.chart.notes {
        let Some((x, y)) = frame.point(note.at) else {
            continue;
        };
        svg.push_str(&mark(note.marker, (x, y), note.hue));
        let width = text_width(&note.text, 12.0);
        let places = [
            (9.0, -8.0),
            (-9.0 - width, -8.0),
            (9.0, 17.0),
            (-9.0 - width, 17.0),
            (9.0, -24.0),
            (-9.0 - width, -24.0),
        ];
        let boxed = |(dx, dy): (f64, f64)| [x + dx, y + dy - 11.0, x + dx + width, y + dy + 3.0];
        let free = |b: &[f64; 4]| {
            b[0] >= frame.left
                && b[2] <= frame.right()
                && b[1] >= frame.top
                && b[3] <= frame.bottom()
                && taken.iter().all(|t| b[2] < t[0] || b[0] > t[2] || b[3] < t[1] || b[1] > t[3])
        };
        let place = places.iter().map(|p| boxed(*p)).find(free).unwrap_or_else(|| boxed(places[0]));
        svg.push_str(&text(place[0], place[3] - 3.0, "start", "halo", &note.text));
        taken.push(place);
        taken.push([x - 6.0, y - 6.0, x + 6.0, y + 6.0]);
    }
    svg
}

fn polyline(path: &[(f64, f64)], hue: Hue, dash: Dash, extra: &str) -> String {
    if path.len() < 2 {
        return String::new();
    }
    format!("<polyline points=\"{}\" class=\"ln {}{extra}\"{}/>", points(path), hue.class(), dash.attribute())
}

fn mark(marker: Marker, (x, y): (f64, f64), hue: Hue) -> String {
    let hue = hue.class();
    let shape = |corners: &[(f64, f64)]| {
        let at: Vec<(f64, f64)> = corners.iter().map(|(a, b)| (x + a, y + b)).collect();
        format!("<polygon points=\"{}\" class=\"mk {hue}\"/>", points(&at))
    };
    match marker {
        Marker::Circle => format!("<circle cx=\"{}\" cy=\"{}\" r=\"4\" class=\"mk {hue}\"/>", px(x), px(y)),
        Marker::Dot => format!("<circle cx=\"{}\" cy=\"{}\" r=\"2\" class=\"dot {hue}\"/>", px(x), px(y)),
        Marker::Square => shape(&[(-3.6, -3.6), (3.6, -3.6), (3.6, 3.6), (-3.6, 3.6)]),
        Marker::Triangle => shape(&[(0.0, -4.8), (4.6, 3.6), (-4.6, 3.6)]),
        Marker::Diamond => shape(&[(0.0, -5.2), (5.2, 0.0), (0.0, 5.2), (-5.2, 0.0)]),
    }
}
