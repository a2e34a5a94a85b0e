//! The charts: right places, the same bytes every time, and nothing left out silently.

use host_tests::plot::{Axis, Chart, Directions, Figure, HeatMap, PlotError, Series, Sphere, save, to_png, to_svg};

fn decades() -> Chart {
    Chart::new("Decades", Axis::count("step"), Axis::log10("size (mm)"))
        .with(Series::line("falling", vec![(0.0, 100.0), (1.0, 10.0), (2.0, 1.0), (3.0, 0.1)]))
        .with_level("limit", 0.5)
}

fn figures() -> Vec<Box<dyn Figure>> {
    let map = HeatMap::new("Map", ("d (mm)", &[10.0, 50.0]), ("R (mm)", &[120.0]), "success", vec![vec![1.0, 0.4]]);
    let sphere = Sphere::new("Arm", 45.0).with(Directions::new("poses", vec![[0.0, 0.0, 1.0], [0.5, 0.1, 1.0]]));
    vec![Box::new(decades()), Box::new(map), Box::new(sphere)]
}

/// The value of an attribute of each circle of the first series' colour, in document order.
fn circles(svg: &str, attribute: &str) -> Vec<f32> {
    svg.lines()
        .filter(|line| line.starts_with("<circle") && line.contains("#0072b2"))
        .map(|line| line.split(&format!("{attribute}=\"")).nth(1).unwrap().split('"').next().unwrap().parse().unwrap())
        .collect()
}

#[test]
fn equal_ratios_are_equal_distances_on_a_logarithmic_axis() {
    // The first circle is the legend's sample; the other four are the data.
    let svg = to_svg(&decades()).unwrap();
    let (x, y) = (circles(&svg, "cx"), circles(&svg, "cy"));
    assert_eq!(y.len(), 5);
    for k in 1..4 {
        assert!((x[k + 1] - x[k] - (x[2] - x[1])).abs() < 0.02, "{x:?}");
        assert!((y[k + 1] - y[k] - (y[2] - y[1])).abs() < 0.02, "{y:?}");
    }
    assert!(y[2] > y[1] && x[2] > x[1], "smaller values lie lower, later ones to the right");
}

#[test]
fn the_picture_has_its_markers_where_the_drawing_has_them() {
    let svg = to_svg(&decades()).unwrap();
    let pixels = tiny_skia::Pixmap::decode_png(&to_png(&decades()).unwrap()).unwrap();
    assert_eq!((pixels.width(), pixels.height()), (1600, 1000));
    for (x, y) in circles(&svg, "cx").into_iter().zip(circles(&svg, "cy")) {
        let pixel = pixels.pixel((x * 2.0) as u32, (y * 2.0) as u32).unwrap();
        assert_eq!((pixel.red(), pixel.green(), pixel.blue()), (0x00, 0x72, 0xB2), "at {x}, {y}");
    }
}

#[test]
fn text_needs_no_installed_font() {
    // The title's bold letters: dark pixels in the top left corner, on an otherwise white strip.
    let pixels = tiny_skia::Pixmap::decode_png(&to_png(&decades()).unwrap()).unwrap();
    let dark = |x, y| pixels.pixel(x, y).is_some_and(|p| p.red() < 80);
    let count = |columns: std::ops::Range<u32>| {
        columns.flat_map(|x| (30..66).map(move |y| (x, y))).filter(|&(x, y)| dark(x, y)).count()
    };
    assert!(count(32..200) > 500, "{}", count(32..200));
    assert_eq!(count(800..1600), 0);
}

#[test]
fn the_same_data_gives_the_same_bytes() {
    for figure in figures() {
        assert_eq!(to_svg(figure.as_ref()).unwrap(), to_svg(figure.as_ref()).unwrap());
        assert_eq!(to_png(figure.as_ref()).unwrap(), to_png(figure.as_ref()).unwrap());
    }
}

#[test]
fn both_files_are_written_beside_each_other() {
    let stem = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("charts/decades.v1");
    let [svg, png] = save(&decades(), &stem).unwrap();
    assert!(svg.ends_with("charts/decades.v1.svg") && png.ends_with("charts/decades.v1.png"));
    assert_eq!(std::fs::read_to_string(svg).unwrap(), to_svg(&decades()).unwrap());
    assert_eq!(std::fs::read(png).unwrap(), to_png(&decades()).unwrap());
}

#[test]
fn what_cannot_be_shown_is_an_error_that_names_it() {
    let chart = |y: f64| {
        Chart::new("t", Axis::linear("x"), Axis::log10("y")).with(Series::line("s", vec![(0.0, 1.0), (1.0, y)]))
    };
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = to_svg(&chart(bad)).unwrap_err();
        assert!(matches!(&error, PlotError::OffScale { label, index: 1 } if label == "s"), "{error}");
    }
    let empty = Chart::new("t", Axis::linear("x"), Axis::linear("y"));
    assert!(matches!(to_svg(&empty), Err(PlotError::NoData)));
    let ragged = HeatMap::new("t", ("x", &[1.0, 2.0]), ("y", &[1.0]), "share", vec![vec![0.5]]);
    assert!(matches!(to_svg(&ragged), Err(PlotError::Ragged)));
    let over = HeatMap::new("t", ("x", &[1.0]), ("y", &[1.0]), "share", vec![vec![1.5]]);
    assert!(matches!(to_svg(&over), Err(PlotError::OffScale { .. })));
    let behind = Sphere::new("t", 90.0).with(Directions::new("d", vec![[0.0, 0.0, -1.0]]));
    assert!(matches!(to_svg(&behind), Err(PlotError::OffScale { index: 0, .. })));
}

#[test]
fn labels_may_hold_any_character() {
    let chart = Chart::new("a < b & c > d", Axis::linear("x"), Axis::linear("y"))
        .with(Series::line("\"s\" <&>", vec![(0.0, 0.0), (1.0, 1.0)]));
    let svg = to_svg(&chart).unwrap();
    assert!(svg.contains("a &lt; b &amp; c &gt; d</text>"));
    assert!(to_png(&chart).is_ok());
}
