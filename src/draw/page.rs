//! Panels, a title and a legend -> one SVG document, by the crate `svg`.

use super::path::Path;
use glam::DVec2;
use svg::node::element::{Element, Path as PathElement, Rectangle, SVG, Text};
use svg::{Document, Node};

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
        .set("d", path.into_data());
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
