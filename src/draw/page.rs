//! Panels, a title and a legend -> one SVG document, by the crate `svg`.

use glam::{DVec2, IVec2};
use std::fmt::Write as _;
use svg::node::element::{Element, Path as PathElement, Rectangle, SVG, Text};
use svg::{Document, Node};

/// A path under construction, in whole units of the page.
#[derive(Default)]
pub(super) struct Path {
    data: String,
    /// Position of the pen, and start of the current figure.
    at: IVec2,
    start: IVec2,
    /// Number of closed figures.
    pub(super) closed: usize,
}

impl Path {
    pub(super) fn is_empty(&self) -> bool {
        self.data.is_empty()
    }

    /// Starts a figure.
    pub(super) fn move_to(&mut self, p: DVec2) {
        let p = whole(p);
        let d = p - self.at;
        self.put('m', d.x, Some(d.y));
        (self.at, self.start) = (p, p);
    }

    /// Adds a straight line. Lines shorter than a unit of the page are skipped.
    pub(super) fn line_to(&mut self, p: DVec2) {
        let p = whole(p);
        let d = p - self.at;
        match (d.x, d.y) {
            (0, 0) => return,
            (x, 0) => self.put('h', x, None),
            (0, y) => self.put('v', y, None),
            (x, y) => self.put('l', x, Some(y)),
        }
        self.at = p;
    }

    fn close(&mut self) {
        self.data.push('z');
        self.at = self.start;
        self.closed += 1;
    }

    /// Adds a closed polygon.
    pub(super) fn polygon(&mut self, points: impl IntoIterator<Item = DVec2>) {
        let mut points = points.into_iter();
        let Some(first) = points.next() else { return };
        self.move_to(first);
        points.for_each(|p| self.line_to(p));
        self.close();
    }

    pub(super) fn line(&mut self, a: DVec2, b: DVec2) {
        self.move_to(a);
        self.line_to(b);
    }

    /// Adds a figure without extent: a dot as wide as the line, if line ends are round.
    pub(super) fn dot(&mut self, p: DVec2) {
        self.move_to(p);
        self.data.push_str("h0z");
        self.closed += 1;
    }

    /// Adds an axis-parallel square.
    pub(super) fn square(&mut self, p: DVec2, radius: f64) {
        let (d, e) = (DVec2::splat(radius), DVec2::new(radius, -radius));
        self.polygon([p - d, p + e, p + d, p - e]);
    }

    /// Adds a square standing on a corner.
    pub(super) fn diamond(&mut self, p: DVec2, radius: f64) {
        let (x, y) = (DVec2::new(radius, 0.0), DVec2::new(0.0, radius));
        self.polygon([p - x, p - y, p + x, p + y]);
    }

    /// Adds an arrow head centred on `p`.
    pub(super) fn arrow_head(&mut self, p: DVec2, direction: DVec2, length: f64) {
        let along = direction.normalize_or_zero() * length;
        let across = along.perp() * 0.45;
        self.polygon([p + 0.5 * along, p - 0.5 * along + across, p - 0.5 * along - across]);
    }

    fn put(&mut self, command: char, x: i32, y: Option<i32>) {
        // Writing to a string cannot fail.
        let _ = write!(self.data, "{command}{x}");
        if let Some(y) = y {
            let _ = write!(self.data, "{}{y}", if y < 0 { "" } else { " " });
        }
    }
}

fn whole(p: DVec2) -> IVec2 {
    p.round().as_ivec2()
}

/// Units of the page per pixel. Coordinates are whole units: precise enough, and short.
pub(super) const UNIT: f64 = 20.0;

/// Pixels around everything.
const MARGIN: f64 = 16.0;
const FONT: f64 = 14.0;
/// Line spacing of text, pixels.
const LEADING: f64 = 22.0;
/// Width of a legend's symbol with the space to its text, pixels.
const SYMBOL: f64 = 34.0;
/// Estimated width of a character in font sizes, to keep texts apart.
const CHARACTER: f64 = 0.56;

/// Style of a path.
#[derive(Clone, Copy, Default)]
pub(super) struct Style {
    /// Class of the element, for scripts and style sheets.
    pub(super) class: &'static str,
    /// Fill colour; none if empty.
    pub(super) fill: &'static str,
    /// Line colour; none if empty.
    pub(super) stroke: &'static str,
    /// Line width, pixels.
    pub(super) width: f64,
    /// Round line ends, which turn figures without extent into dots.
    pub(super) round: bool,
    /// Length of dashes and gaps, pixels.
    pub(super) dash: Option<f64>,
    /// Opacity; 0 means opaque.
    pub(super) opacity: f64,
}

/// Symbol of a legend's line.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Symbol {
    Area,
    Line,
    Arrow,
    Dot,
    Square,
    Diamond,
    Triangle,
}

/// A line of the legend.
pub(super) struct Entry {
    pub(super) style: Style,
    pub(super) symbol: Symbol,
    pub(super) words: String,
}

/// A window of the plane with a drawing.
pub(super) struct Panel {
    /// Lower left and upper right corner of the window.
    low: DVec2,
    high: DVec2,
    /// Size on the page, units.
    size: DVec2,
    caption: Vec<String>,
    content: SVG,
}

impl Panel {
    /// Creates a panel that shows `low` to `high` at a size in pixels.
    pub(super) fn new(low: DVec2, high: DVec2, pixels: DVec2) -> Self {
        let size = (pixels * UNIT).round();
        // A nested viewport clips the drawing.
        let content = SVG::new()
            .set("width", size.x)
            .set("height", size.y)
            .set("viewBox", (0, 0, size.x as i32, size.y as i32))
            .set("overflow", "hidden");
        Self { low, high, size, caption: Vec::new(), content }
    }

    /// Adds a line of text below the panel.
    pub(super) fn caption(&mut self, words: impl Into<String>) {
        self.caption.push(words.into());
    }

    /// Maps a point of the plane to units of the panel.
    pub(super) fn place(&self, p: DVec2) -> DVec2 {
        let share = (p - self.low) / (self.high - self.low);
        DVec2::new(share.x, 1.0 - share.y) * self.size
    }

    /// Pixels per unit of the plane, in both directions.
    pub(super) fn scale(&self) -> DVec2 {
        self.size / (self.high - self.low) / UNIT
    }

    /// Whether the box with corners `a` and `b` meets the window. Touching counts.
    pub(super) fn shows(&self, a: DVec2, b: DVec2) -> bool {
        a.max(b).cmpge(self.low).all() && a.min(b).cmple(self.high).all()
    }

    /// Whether the box with corners `a` and `b` overlaps the window. Touching does not count.
    pub(super) fn shows_area(&self, a: DVec2, b: DVec2) -> bool {
        a.max(b).cmpgt(self.low).all() && a.min(b).cmplt(self.high).all()
    }

    /// Adds a path unless it is empty.
    pub(super) fn draw(&mut self, path: Path, style: &Style) {
        if !path.is_empty() {
            self.content.append(styled(path, style));
        }
    }
}

fn styled(path: Path, style: &Style) -> Element {
    let or_none = |colour: &'static str| if colour.is_empty() { "none" } else { colour };
    let mut element = PathElement::new()
        .set("class", style.class)
        .set("fill", or_none(style.fill))
        .set("stroke", or_none(style.stroke))
        .set("d", path.data);
    if !style.stroke.is_empty() {
        element = element.set("stroke-width", (style.width * UNIT).max(1.0).round()).set("stroke-linejoin", "round");
    }
    if style.round {
        element = element.set("stroke-linecap", "round");
    }
    if let Some(dash) = style.dash {
        element = element.set("stroke-dasharray", (dash * UNIT).round());
    }
    if style.opacity > 0.0 {
        element = element.set("opacity", style.opacity);
    }
    element.into()
}

fn text(at: DVec2, words: &str) -> Text {
    Text::new(words)
        .set("x", at.x.round())
        .set("y", at.y.round())
        .set("font-size", (FONT * UNIT).round())
        .set("font-family", "sans-serif")
        .set("fill", "#222")
}

/// Lays out a title, a row of panels, and the legend: right of a single panel, below several.
pub(super) fn page(title: &[String], panels: Vec<Panel>, legend: &[Entry]) -> String {
    let beside = panels.len() == 1;
    let longest = |lines: &mut dyn Iterator<Item = &String>| {
        lines.map(|line| line.chars().count()).max().unwrap_or(0) as f64 * FONT * CHARACTER
    };
    let legend_width = SYMBOL + longest(&mut legend.iter().map(|entry| &entry.words));
    let captions = panels.iter().map(|panel| panel.caption.len()).max().unwrap_or(0);
    let mut y = MARGIN + LEADING * title.len() as f64;
    let tallest = panels.iter().map(|panel| panel.size.y / UNIT).fold(0.0, f64::max);
    let below = y + tallest + LEADING * captions as f64 + MARGIN;
    let mut width = longest(&mut title.iter()) + 2.0 * MARGIN;
    let mut items: Vec<Box<dyn Node>> = Vec::new();
    for (k, line) in title.iter().enumerate() {
        let at = DVec2::new(MARGIN, MARGIN + FONT * 0.8 + LEADING * k as f64);
        items.push(text(at * UNIT, line).into());
    }
    let mut x = MARGIN;
    for panel in panels {
        let at = DVec2::new(x, y) * UNIT;
        let Panel { content, caption, size, .. } = panel;
        // Widen panels to their captions, so that captions do not overlap. A single panel needs no room for that.
        let words = if beside { 0.0 } else { longest(&mut caption.iter()) };
        items.push(content.set("x", at.x.round()).set("y", at.y.round()).into());
        items.push(outline(at, size).into());
        for (k, line) in caption.iter().enumerate() {
            let place = DVec2::new(x, y + size.y / UNIT + LEADING * (k as f64 + 0.8)) * UNIT;
            items.push(text(place, line).into());
        }
        x += (size.x / UNIT).max(words) + MARGIN;
    }
    width = width.max(x);
    let (left, mut height) = if beside { (x, below) } else { (MARGIN, below) };
    if !beside {
        y = below;
    }
    for (k, entry) in legend.iter().enumerate() {
        let middle = DVec2::new(left + 0.4 * SYMBOL, y + LEADING * (k as f64 + 0.5)) * UNIT;
        items.push(styled(entry.symbol(middle), &entry.style).into());
        let at = DVec2::new(left + SYMBOL, y + LEADING * (k as f64 + 0.5) + 0.35 * FONT) * UNIT;
        items.push(text(at, &entry.words).into());
    }
    if !legend.is_empty() {
        width = width.max(left + legend_width + MARGIN);
        height = height.max(y + LEADING * legend.len() as f64 + MARGIN);
    }
    let size = DVec2::new(width, height).ceil();
    let units = size * UNIT;
    let mut document = Document::new()
        .set("width", size.x)
        .set("height", size.y)
        .set("viewBox", (0, 0, units.x as i32, units.y as i32))
        .add(Rectangle::new().set("width", units.x).set("height", units.y).set("fill", "#fff"));
    items.into_iter().for_each(|item| document.append(item));
    let mut text = document.to_string();
    text.push('\n');
    text
}

/// The rectangle around a panel.
fn outline(at: DVec2, size: DVec2) -> Rectangle {
    let at = at.round();
    let outline = Rectangle::new().set("x", at.x).set("y", at.y).set("width", size.x).set("height", size.y);
    outline.set("fill", "none").set("stroke", "#999").set("stroke-width", UNIT)
}

impl Entry {
    /// Draws the symbol around a point of the page.
    fn symbol(&self, middle: DVec2) -> Path {
        let half = DVec2::new(0.3 * SYMBOL, 0.0) * UNIT;
        let up = DVec2::new(0.0, -0.3 * LEADING) * UNIT;
        let mut path = Path::default();
        match self.symbol {
            Symbol::Area => {
                path.polygon([middle - half - up, middle + half - up, middle + half + up, middle - half + up])
            }
            Symbol::Line => path.line(middle - half, middle + half),
            Symbol::Arrow => path.arrow_head(middle, half, 0.5 * LEADING * UNIT),
            Symbol::Dot => path.dot(middle),
            Symbol::Square => path.square(middle, 0.16 * LEADING * UNIT),
            Symbol::Diamond => path.diamond(middle, 0.22 * LEADING * UNIT),
            Symbol::Triangle => path.polygon([middle - half - up, middle + half - up, middle + up]),
        }
        path
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_relative_and_short() {
        let mut path = Path::default();
        path.polygon([DVec2::new(10.0, 5.0), DVec2::new(20.0, 5.0), DVec2::new(20.4, 8.0), DVec2::new(7.0, 1.0)]);
        path.dot(DVec2::new(11.0, 4.0));
        path.line(DVec2::new(11.0, 4.0), DVec2::new(11.0, 4.2));
        assert_eq!(path.closed, 2);
        assert_eq!(path.data, "m10 5h10v3l-13-7zm1-1h0zm0 0");
    }
}
