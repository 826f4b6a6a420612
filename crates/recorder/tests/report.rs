//! Reports and their pictures are well-formed, say everything, and need no network.

use sealegs_recorder::chart::{
    Axis, Bar, BarChart, Chart, Contours, Dash, HeatMap, Hue, Marker, Picture, Size, figure_html,
};
use sealegs_recorder::report::{Provenance, Report, Table, Tone};

const NASTY: &str = "<script>alert('x')</script> & \"quotes\" \u{1}";

fn sine(n: usize) -> Vec<(f64, f64)> {
    (0..n).map(|i| (i as f64 * 1e-3, 300.0 * (i as f64 * 0.01).sin())).collect()
}

fn everything(label: &str) -> Vec<Box<dyn Picture>> {
    let axis: Vec<f64> = (1..20).map(f64::from).collect();
    let values = axis.iter().flat_map(|y| axis.iter().map(move |x| x * y)).collect();
    vec![
        Box::new(
            Chart::new(label, Axis::new("Time", "s"), Axis::new(label, label))
                .line(label, Hue::Ink, Dash::Solid, sine(30_000))
                .line("before", Hue::Vermillion, Dash::Dashed, sine(100))
                .band("95 %", Hue::Blue, sine(50).into_iter().map(|(x, y)| (x, y - 9.0, y + 9.0)).collect())
                .vertical(3.0, label)
                .horizontal(655.0, label)
                .note((2.0, 100.0), label, Marker::Diamond, Hue::Green)
                .zoomable(label),
        ),
        Box::new(
            Chart::new("Bode", Axis::new("Frequency", "Hz").log(), Axis::new("Gain", "").log())
                .marked(
                    "m",
                    Hue::Blue,
                    Dash::Dotted,
                    Marker::Square,
                    vec![(1.0, 1.0), (10.0, 30.0), (0.0, 5.0)],
                )
                .scatter("s", Hue::Orange, Marker::Dot, vec![(2.0, f64::NAN), (3.0, -1.0), (4.0, 2.0)]),
        ),
        Box::new(Chart::new("c", Axis::new("x", "m"), Axis::new("y", "m")).contours(Contours {
            x: axis.clone(),
            y: axis,
            values,
            levels: vec![(10.0, "10".into()), (50.0, label.into())],
            label: label.into(),
            ..Contours::default()
        })),
        Box::new(Chart::new("h", Axis::new("Residual", "N"), Axis::new("Samples", "")).histogram(
            label,
            Hue::Blue,
            vec![-1.0, 0.0, 1.0],
            vec![3.0, 5.0],
        )),
        Box::new(BarChart {
            title: label.into(),
            axis: Axis::new("Share", "%"),
            series: vec![(label.into(), Hue::Vermillion), ("samples".into(), Hue::Grey)],
            bars: vec![Bar { label: label.into(), values: vec![40.0, f64::NAN], text: label.into() }],
            marks: vec![(12.0, label.into())],
            row_height: None,
        }),
        Box::new(HeatMap {
            title: label.into(),
            columns: vec![label.into(), "b".into()],
            rows: vec!["r".into()],
            values: vec![1.0, f64::NAN],
            value_label: label.into(),
            ..HeatMap::default()
        }),
        Box::new(Chart::new("nothing at all", Axis::default(), Axis::default().log())),
        Box::new(BarChart::default()),
        Box::new(HeatMap::default()),
    ]
}

#[test]
fn pictures_are_well_formed_and_finite_whatever_is_in_them() {
    for picture in everything(NASTY) {
        for size in [Size::WIDE, Size::NARROW] {
            let svg = picture.svg(size);
            let tree = roxmltree::Document::parse(&svg).unwrap_or_else(|e| panic!("{e}\n{svg}"));
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
            assert!(tree.descendants().all(|n| !n.has_tag_name("script")));
        }
    }
}

#[test]
fn texts_stay_inside_the_picture() {
    for picture in everything("Force on link 1") {
        for size in [Size::WIDE, Size::NARROW] {
            let svg = picture.svg(size);
            let tree = roxmltree::Document::parse(&svg).unwrap();
            for text in tree.descendants().filter(|n| n.has_tag_name("text") && n.has_attribute("x")) {
                let x: f64 = text.attribute("x").unwrap().parse().unwrap();
                assert!((0.0..=size.width).contains(&x), "{x} in {svg}");
            }
        }
    }
}

#[test]
fn a_long_series_is_thinned_and_keeps_its_peak() {
    let mut points = sine(1_000_000);
    points[123_456].1 = 5000.0;
    let chart = Chart::new("t", Axis::new("Time", "s"), Axis::new("Force", "N"))
        .line("", Hue::Ink, Dash::Solid, points)
        .zoomable("t");
    let svg = chart.svg(Size::WIDE);
    assert!(svg.len() < 60_000, "{}", svg.len());
    let tree = roxmltree::Document::parse(&svg).unwrap();
    let frame = tree.descendants().find(|n| n.attribute("class") == Some("fr")).unwrap();
    let number = |name: &str| frame.attribute(name).unwrap().parse::<f64>().unwrap();
    let line = tree.descendants().find(|n| n.has_tag_name("polyline")).unwrap();
    let top = line
        .attribute("points")
        .unwrap()
        .split(' ')
        .map(|p| p.split(',').nth(1).unwrap().parse::<f64>().unwrap())
        .fold(f64::INFINITY, f64::min);
    // The range is 5 % wider than the data on both sides: the peak is drawn 0.05/1.1 below the frame's top.
    let expected = number("y") + number("height") * 0.05 / 1.1;
    assert!((top - expected).abs() < 0.2, "{top} {expected}");
}

#[test]
fn the_same_input_gives_the_same_text() {
    for (a, b) in everything("x").iter().zip(everything("x")) {
        assert_eq!(figure_html(a.as_ref()), figure_html(b.as_ref()));
    }
}

#[test]
fn a_report_escapes_all_and_refers_to_nothing_outside() {
    let mut table = Table::new().words(NASTY).numbers("Stiffness", "kN/m");
    table.row([NASTY, "655"]).strong_row(["b"]);
    let mut report = Report::new(NASTY);
    report
        .subtitle(NASTY)
        .verdict(Tone::Bad, NASTY, NASTY)
        .section(NASTY)
        .subsection(NASTY)
        .paragraph(NASTY)
        .remark(NASTY)
        .preformatted(NASTY)
        .list(&[NASTY])
        .numbers(&[(NASTY, NASTY, NASTY)])
        .table(&table, NASTY);
    for picture in everything(NASTY) {
        report.figure(picture.as_ref(), NASTY);
    }
    report.details(NASTY, |r| {
        r.paragraph(NASTY);
    });
    report.provenance(&Provenance {
        command: NASTY.into(),
        versions: vec![(NASTY.into(), NASTY.into())],
        inputs: vec![("run.csv".into(), "sha256:00".into())],
        seed: Some(7),
        notes: vec![],
    });
    let html = report.to_html();
    assert!(!html.contains("<script>alert"));
    // One script, ours; no address but the name of the SVG language itself.
    assert_eq!(html.matches("<script").count(), 1);
    let named = html.matches("http").count();
    assert_eq!(named, html.matches("http://www.w3.org/2000/svg").count());
    assert!(!html.contains("src=") && !html.contains("@import") && !html.contains("url(h"));
    for said in ["sha256:00", "Figure 9.", "Table 1.", "655", "kN/m", "Seed"] {
        assert!(html.contains(said), "{said}");
    }
    // The body is well-formed; only the head has tags that HTML leaves open, and the script its own language.
    let body = &html[html.find("<main>").unwrap()..html.find("</main>").unwrap() + 7];
    roxmltree::Document::parse(body).unwrap();
}
