//! A plot of a run as one self-contained SVG: a map on the left, curves over time on the right.
//!
//! Metres on the map have the same length on both axes, north is up. Curves lose only points that lie within
//! a third of a pixel of what is drawn. Values that are not finite are left out, so that the file never contains NaN.
//! Colours are Okabe and Ito's (2008), which can be distinguished with any colour vision; start, end and plan differ in
//! shape too.

/// East and north (m), or time (s) and a value.
pub(crate) type Point = (f64, f64);

const WIDTH: f64 = 1040.0;
const HEIGHT: f64 = 620.0;
const MAP: Panel = Panel { left: 76.0, top: 128.0, width: 400.0, height: 400.0 };
const CURVES_TOP: f64 = MAP.top;
const CURVES_LEFT: f64 = 566.0;
const CURVES_WIDTH: f64 = 446.0;
const CURVES_GAP: f64 = 52.0;
/// Points closer than this to the drawn line are left out (px).
const TOLERANCE: f64 = 0.33;
/// A map shows at least this many metres.
const LEAST_SPAN_M: f64 = 10.0;

const TRACK: &str = "#0072B2";
const PLAN: &str = "#E69F00";
const START: &str = "#009E73";
const END: &str = "#D55E00";
const INK: &str = "#222222";
const GRID: &str = "#dddddd";
const SHADE: &str = "#e3edf5";

/// What a plot shows.
#[derive(Debug, Clone, Default)]
pub(crate) struct Plot {
    /// The headline.
    pub(crate) title: String,
    /// Lines below it: figures and conditions.
    pub(crate) notes: Vec<String>,
    /// Where the vessel was.
    pub(crate) track: Vec<Point>,
    /// The planned way.
    pub(crate) plan: Vec<Point>,
    /// Planned circles: centre and radius (m).
    pub(crate) circles: Vec<(Point, f64)>,
    /// Curves, from top to bottom.
    pub(crate) curves: Vec<Curve>,
}

/// A value over time.
#[derive(Debug, Clone, Default)]
pub(crate) struct Curve {
    /// Quantity and unit.
    pub(crate) title: String,
    /// Unit for the axis.
    pub(crate) unit: String,
    /// Stretches without a gap: time (s) and value.
    pub(crate) pieces: Vec<Vec<Point>>,
    /// Another value in the same unit, as stretches: time (s) and value.
    pub(crate) second: Vec<Vec<Point>>,
    /// Name of that value.
    pub(crate) second_title: String,
    /// The setpoint, as stretches: time (s) and value.
    pub(crate) wanted: Vec<Vec<Point>>,
    /// Name of the setpoint.
    pub(crate) wanted_title: String,
    /// Times to be shaded (s).
    pub(crate) shades: Vec<(f64, f64)>,
    /// What the shade means.
    pub(crate) shade_title: String,
}

/// A rectangle on the page (px).
#[derive(Debug, Clone, Copy)]
struct Panel {
    left: f64,
    top: f64,
    width: f64,
    height: f64,
}

/// Range of each axis in a panel.
#[derive(Debug, Clone, Copy)]
struct View {
    panel: Panel,
    x: (f64, f64),
    y: (f64, f64),
}

/// The side of a text that its place is at.
#[derive(Debug, Clone, Copy)]
enum Anchor {
    Start,
    Middle,
    End,
}

/// The text of the file.
#[derive(Debug, Default)]
struct Page(String);

impl Plot {
    /// The file.
    pub(crate) fn to_svg(&self) -> String {
        let mut page = Page::default();
        page.add(&format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" \
             height=\"{HEIGHT}\" role=\"img\" font-family=\"DejaVu Sans, Verdana, Helvetica, sans-serif\">"
        ));
        page.add(&format!("<title>{}</title>", escaped(&self.title)));
        page.add(&format!("<rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#ffffff\"/>"));
        page.text((24.0, 34.0), 18.0, Anchor::Start, true, &self.title);
        for (y, note) in [56.0, 75.0, 94.0].into_iter().zip(&self.notes) {
            page.text((24.0, y), 12.5, Anchor::Start, false, note);
        }
        self.map(&mut page);
        let count = self.curves.len().max(1) as f64;
        let height = (MAP.height + CURVES_GAP) / count - CURVES_GAP;
        let mut top = CURVES_TOP;
        for (left, curve) in (0..self.curves.len()).rev().zip(&self.curves) {
            let panel = Panel { left: CURVES_LEFT, top, width: CURVES_WIDTH, height };
            curve.draw(panel, self.end_s(), left == 0, &mut page);
            top += height + CURVES_GAP;
        }
        page.add("</svg>");
        page.0
    }

    fn end_s(&self) -> f64 {
        let pieces = self.curves.iter().flat_map(|curve| &curve.pieces).flatten();
        pieces.map(|point| point.0).filter(|time_s| time_s.is_finite()).fold(1.0, f64::max)
    }

    fn map(&self, page: &mut Page) {
        let rims = self.circles.iter().flat_map(|&((x, y), r)| [(x - r, y - r), (x + r, y + r)]);
        let shown = || self.track.iter().chain(&self.plan).copied().chain(rims.clone());
        let (x, y) = (bounds(shown().map(|point| point.0)), bounds(shown().map(|point| point.1)));
        let span_m = (x.1 - x.0).max(y.1 - y.0).max(LEAST_SPAN_M) * 1.12;
        let around = |(low, high): Point| {
            let middle = f64::midpoint(low, high);
            (middle - span_m / 2.0, middle + span_m / 2.0)
        };
        let view = View { panel: MAP, x: around(x), y: around(y) };
        page.text((MAP.left, MAP.top - 10.0), 13.0, Anchor::Start, true, "Track, north up");
        view.grid(page, "east (m)", "north (m)", 1.0, 56.0);
        view.line(page, &self.plan, PLAN, 4.0, "");
        for &(centre, radius_m) in &self.circles {
            let ((cx, cy), r) = (view.place(centre), radius_m / span_m * MAP.width);
            if [cx, cy, r].iter().all(|number| number.is_finite()) {
                page.add(&format!(
                    "<circle cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"{r:.1}\" fill=\"none\" stroke=\"{PLAN}\" \
                     stroke-width=\"4\"/>"
                ));
            }
        }
        view.line(page, &self.track, TRACK, 1.6, "");
        let mut finite = self.track.iter().filter(|point| point.0.is_finite() && point.1.is_finite());
        if let Some(first) = finite.next() {
            let last = finite.next_back().unwrap_or(first);
            page.start(view.place(*first));
            page.end(view.place(*last));
        }
        self.legend(page);
    }

    fn legend(&self, page: &mut Page) {
        let y = MAP.top + MAP.height + 62.0;
        let label = |page: &mut Page, x: f64, text: &str| {
            page.text((x, y + 4.0), 12.0, Anchor::Start, false, text);
        };
        page.segment((MAP.left, y), (MAP.left + 26.0, y), TRACK, 1.6, "");
        label(page, MAP.left + 32.0, "true track");
        page.segment((MAP.left + 124.0, y), (MAP.left + 150.0, y), PLAN, 4.0, "");
        label(page, MAP.left + 156.0, if self.plan.len() > 1 { "plan" } else { "planned circle" });
        page.start((MAP.left + 278.0, y));
        label(page, MAP.left + 288.0, "start");
        page.end((MAP.left + 350.0, y));
        label(page, MAP.left + 360.0, "end");
    }
}

impl Curve {
    fn draw(&self, panel: Panel, end_s: f64, last: bool, page: &mut Page) {
        let (unit_s, time) = if end_s > 600.0 { (60.0, "time (min)") } else { (1.0, "time (s)") };
        let lines =
            [(&self.pieces, TRACK, 1.4, ""), (&self.second, END, 1.1, ""), (&self.wanted, PLAN, 2.5, "7 4")];
        let values = lines.iter().flat_map(|line| line.0).flatten().map(|point| point.1);
        let (low, high) = bounds(values.chain([0.0]));
        let margin = ((high - low) * 0.06).max(0.05);
        let floor = if low < 0.0 { low - margin } else { 0.0 };
        let view = View { panel, x: (0.0, end_s), y: (floor, high + margin) };
        for &(from_s, to_s) in &self.shades {
            let ((left, _), (right, _)) = (view.place((from_s, 0.0)), view.place((to_s, 0.0)));
            if left.is_finite() && right > left {
                page.shade(Panel { left, width: right - left, ..panel });
            }
        }
        view.grid(page, if last { time } else { "" }, &self.unit, unit_s, 28.0);
        for (pieces, colour, width, dashes) in lines {
            for piece in pieces {
                view.line(page, piece, colour, width, dashes);
            }
        }
        let y = panel.top - 10.0;
        page.text((panel.left, y), 13.0, Anchor::Start, true, &self.title);
        let mut right = panel.left + panel.width;
        if !self.shades.is_empty() {
            page.text((right, y), 11.5, Anchor::End, false, &self.shade_title);
            right -= width_of(&self.shade_title) + 22.0;
            page.shade(Panel { left: right, top: y - 10.0, width: 16.0, height: 12.0 });
            right -= 14.0;
        }
        let mut line = |title: &str, colour: &str, width: f64, dashes: &str| {
            page.text((right, y), 11.5, Anchor::End, false, title);
            right -= width_of(title) + 6.0;
            page.segment((right - 26.0, y - 4.0), (right, y - 4.0), colour, width, dashes);
            right -= 40.0;
        };
        if !self.wanted.is_empty() {
            line(&self.wanted_title, PLAN, 2.5, "7 4");
        }
        if !self.second.is_empty() {
            line(&self.second_title, END, 1.1, "");
        }
    }
}

impl View {
    /// Where a point is on the page.
    fn place(&self, (x, y): Point) -> Point {
        let Panel { left, top, width, height } = self.panel;
        let across = (x - self.x.0) / (self.x.1 - self.x.0);
        let up = (y - self.y.0) / (self.y.1 - self.y.0);
        (left + across * width, top + (1.0 - up) * height)
    }

    /// Lines at round values with their labels; x is labelled in units of `x_unit`, y lines are at least `y_px` apart.
    fn grid(&self, page: &mut Page, x_title: &str, y_title: &str, x_unit: f64, y_px: f64) {
        let Panel { left, top, width, height } = self.panel;
        let (right, bottom) = (left + width, top + height);
        let (step, decimals) = step((self.x.1 - self.x.0) / x_unit, width / 56.0);
        for value in multiples(self.x.0 / x_unit, self.x.1 / x_unit, step) {
            let (x, _) = self.place((value * x_unit, self.y.0));
            page.segment((x, top), (x, bottom), GRID, 1.0, "");
            page.text((x, bottom + 17.0), 11.5, Anchor::Middle, false, &number(value, decimals));
        }
        let (step, decimals) = self::step(self.y.1 - self.y.0, height / y_px);
        for value in multiples(self.y.0, self.y.1, step) {
            let (_, y) = self.place((self.x.0, value));
            let colour = if value.abs() < step / 2.0 { "#888888" } else { GRID };
            page.segment((left, y), (right, y), colour, 1.0, "");
            page.text((left - 7.0, y + 4.0), 11.5, Anchor::End, false, &number(value, decimals));
        }
        page.add(&format!(
            "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"none\" \
             stroke=\"{INK}\"/>"
        ));
        if !x_title.is_empty() {
            page.text((left + width / 2.0, bottom + 36.0), 12.0, Anchor::Middle, false, x_title);
        }
        let (x, y) = (left - 52.0, top + height / 2.0);
        page.add(&format!(
            "<text transform=\"translate({x:.1} {y:.1}) rotate(-90)\" font-size=\"12\" fill=\"{INK}\" \
             text-anchor=\"middle\">{}</text>",
            escaped(y_title)
        ));
    }

    fn line(&self, page: &mut Page, points: &[Point], colour: &str, width: f64, dashes: &str) {
        let places: Vec<Point> = points
            .iter()
            .map(|point| self.place(*point))
            .filter(|(x, y)| x.is_finite() && y.is_finite())
            .collect();
        if places.len() < 2 {
            return;
        }
        let text: Vec<String> = thinned(&places).iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        page.add(&format!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" \
             stroke-linejoin=\"round\" stroke-linecap=\"round\"{}/>",
            text.join(" "),
            dash(dashes)
        ));
    }
}

impl Page {
    fn add(&mut self, line: &str) {
        self.0.push_str(line);
        self.0.push('\n');
    }

    fn text(&mut self, (x, y): Point, size: f64, anchor: Anchor, bold: bool, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let weight = if bold { " font-weight=\"bold\"" } else { "" };
        self.add(&format!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" fill=\"{INK}\" text-anchor=\"{anchor}\"\
             {weight}>{}</text>",
            escaped(text)
        ));
    }

    fn segment(&mut self, from: Point, to: Point, colour: &str, width: f64, dashes: &str) {
        self.add(&format!(
            "<path d=\"M{:.1} {:.1}L{:.1} {:.1}\" stroke=\"{colour}\" stroke-width=\"{width}\"{}/>",
            from.0,
            from.1,
            to.0,
            to.1,
            dash(dashes)
        ));
    }

    fn shade(&mut self, Panel { left, top, width, height }: Panel) {
        self.add(&format!(
            "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"{SHADE}\"/>"
        ));
    }

    fn start(&mut self, (x, y): Point) {
        self.add(&format!(
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"5.5\" fill=\"{START}\" stroke=\"#ffffff\"/>"
        ));
    }

    fn end(&mut self, (x, y): Point) {
        let (left, top) = (x - 5.0, y - 5.0);
        self.add(&format!(
            "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"10\" height=\"10\" fill=\"{END}\" stroke=\"#ffffff\"/>"
        ));
    }
}

fn dash(dashes: &str) -> String {
    if dashes.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{dashes}\"") }
}

fn escaped(text: &str) -> String {
    let legal = text.chars().filter(|letter| !letter.is_control());
    legal.collect::<String>().replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// Approximate width of a text of 11.5 px (px).
fn width_of(text: &str) -> f64 {
    6.8 * text.chars().count() as f64
}

/// Least and greatest finite value; 0 and 0 of none.
fn bounds(values: impl Iterator<Item = f64>) -> Point {
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    if low <= high { (low, high) } else { (0.0, 0.0) }
}

/// A step of 1, 2 or 5 times a power of ten that gives at most `most` of them, and its decimals.
fn step(span: f64, most: f64) -> (f64, usize) {
    let least = (span / most.max(1.0)).clamp(1e-6, 1e12);
    let power = 10.0_f64.powf(least.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= least * 0.999).unwrap_or(10.0);
    let step = factor * power;
    // Within 0 to 6 by the clamp above.
    let decimals = (-(step * 1.001).log10().floor()).clamp(0.0, 6.0) as usize;
    (step, decimals)
}

fn multiples(low: f64, high: f64, step: f64) -> impl Iterator<Item = f64> {
    let first = (low / step).ceil();
    // No more than a few hundred on a page.
    let count = ((high / step).floor() - first + 1.0).clamp(0.0, 500.0) as u16;
    (0..count).map(move |number| (first + f64::from(number)) * step)
}

fn number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    if text.trim_matches(['-', '0', '.']).is_empty() { "0".to_owned() } else { text.replace('-', "\u{2212}") }
}

/// The points that a line needs to stay within the tolerance (Ramer, Douglas and Peucker).
fn thinned(points: &[Point]) -> Vec<Point> {
    if points.is_empty() {
        return Vec::new();
    }
    let mut kept = vec![false; points.len()];
    let mut open = vec![(0, points.len() - 1)];
    while let Some((first, last)) = open.pop() {
        kept[first] = true;
        kept[last] = true;
        let off = |at: &usize| distance(points[*at], points[first], points[last]);
        let farthest = (first + 1..last).max_by(|a, b| off(a).total_cmp(&off(b)));
        if let Some(at) = farthest.filter(|at| off(at) > TOLERANCE) {
            open.extend([(first, at), (at, last)]);
        }
    }
    points.iter().zip(kept).filter_map(|(point, kept)| kept.then_some(*point)).collect()
}

/// From a point to a straight piece of line.
fn distance((x, y): Point, (ax, ay): Point, (bx, by): Point) -> f64 {
    let (dx, dy) = (bx - ax, by - ay);
    let square = dx * dx + dy * dy;
    let share = if square > 0.0 { (((x - ax) * dx + (y - ay) * dy) / square).clamp(0.0, 1.0) } else { 0.0 };
    (x - ax - share * dx).hypot(y - ay - share * dy)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot() -> Plot {
        let wave = |n: u16| (f64::from(n), (f64::from(n) / 50.0).sin());
        Plot {
            title: "a <b> & \"c\"".to_owned(),
            notes: vec!["RMS 0.31 m, largest 0.87 m".to_owned(), "calm".to_owned()],
            track: (0..2000).map(wave).chain([(f64::NAN, 1.0), (2.0, f64::INFINITY)]).collect(),
            plan: vec![(0.0, 0.0), (2000.0, 0.0)],
            circles: vec![((5.0, 5.0), 10.0), ((f64::NAN, 0.0), 1.0)],
            curves: vec![
                Curve {
                    title: "error".to_owned(),
                    unit: "m".to_owned(),
                    pieces: vec![(0..2000).map(wave).collect(), vec![(f64::NAN, f64::NAN)]],
                    second: vec![(0..2000).map(|n| (f64::from(n), 0.5)).collect()],
                    second_title: "another".to_owned(),
                    wanted: vec![vec![(0.0, 1.0), (2000.0, 1.0)]],
                    wanted_title: "wanted".to_owned(),
                    shades: vec![(10.0, 20.0), (f64::NAN, 3.0)],
                    shade_title: "counted".to_owned(),
                },
                Curve::default(),
            ],
        }
    }

    /// Every tag closes in its order, and every attribute has its quotes.
    fn assert_well_formed(svg: &str) {
        let mut open = Vec::new();
        for piece in svg.split('<').skip(1) {
            let (tag, text) = piece.split_once('>').unwrap();
            assert!(!text.contains('>'), "{text}");
            assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
            let name = tag.split([' ', '/']).next().unwrap();
            if let Some(closed) = tag.strip_prefix('/') {
                assert_eq!(open.pop(), Some(closed), "{tag}");
            } else if !tag.ends_with('/') {
                open.push(name);
            }
        }
        assert!(open.is_empty(), "{open:?}");
    }

    #[test]
    fn a_plot_is_well_formed_and_holds_its_figures() {
        let svg = plot().to_svg();
        assert_well_formed(&svg);
        let title = "a &lt;b&gt; &amp; \"c\"";
        for text in ["RMS 0.31 m, largest 0.87 m", title, "time (min)", "north (m)", ">another<"] {
            assert!(svg.contains(text), "{text}");
        }
        assert!(svg.starts_with("<svg xmlns=") && svg.len() < 60_000, "{}", svg.len());
    }

    #[test]
    fn coordinates_are_finite_and_text_can_be_read() {
        for svg in [plot().to_svg(), Plot::default().to_svg()] {
            assert_well_formed(&svg);
            assert!(!svg.contains("NaN") && !svg.contains("inf"));
            for points in svg.split(" points=\"").skip(1) {
                for number in points.split('"').next().unwrap().split([',', ' ']) {
                    let number: f64 = number.parse().unwrap();
                    assert!((0.0..=WIDTH).contains(&number), "{number}");
                }
            }
            for size in svg.split("font-size=\"").skip(1) {
                assert!(size.split('"').next().unwrap().parse::<f64>().unwrap() >= 11.0);
            }
        }
    }

    #[test]
    fn steps_are_round() {
        assert_eq!(step(1000.0, 8.0), (200.0, 0));
        assert_eq!(step(2.0, 8.0), (0.5, 1));
        assert_eq!(multiples(-0.3, 0.9, 0.5).collect::<Vec<_>>(), [0.0, 0.5]);
        assert_eq!(number(-0.0, 1), "0");
        assert_eq!(number(-1.5, 1), "\u{2212}1.5");
    }

    #[test]
    fn thinning_keeps_corners_and_peaks() {
        let mut line: Vec<Point> = (0..100).map(|n: u8| (f64::from(n), 0.0)).collect();
        line[40].1 = 3.0;
        let kept = thinned(&line);
        assert!(kept.contains(&(40.0, 3.0)) && kept.len() == 5, "{kept:?}");
        assert_eq!(thinned(&[]), []);
    }
}
