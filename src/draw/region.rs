//! Trimming curves and a rule -> a diagram of the curves with their directions and the kept region shaded.
//!
//! The paper's Figure 2, but with u to the right and v up. Shades the loops from [`FreeRegion`].

use super::page::{Entry, Panel, Path, Style, Symbol, UNIT, page};
use crate::model::{FreeTrims, TrimCurve, TrimPiece};
use crate::prepare::{FreeRegion, NoRegion, UvDomain};
use glam::DVec2;

/// Side of a panel, pixels.
const SIDE: f64 = 230.0;
/// Margin shown around the domain, as a fraction of its size.
const AROUND: f64 = 0.06;
/// Points per monotone arc of a curve.
const PER_ARC: usize = 24;
/// Points per span of a given curve.
const PER_SPAN: usize = 48;
/// Distance of arrow heads, pixels.
const ARROWS: f64 = 70.0;

/// One panel of [`regions`].
#[derive(Clone, Debug)]
pub struct RegionPanel<'a> {
    /// The curves and their rule.
    pub trims: &'a FreeTrims,
    /// The domain that they trim.
    pub domain: UvDomain,
    /// Draw v to the right and u up as in the paper, which mirrors the picture and reverses all curves.
    pub as_in_paper: bool,
    /// Lines of text below the panel.
    pub caption: Vec<String>,
}

/// Draws the regions that trimming curves keep, as panels side by side.
///
/// # Errors
/// If a panel's curves do not give a region, see [`FreeRegion::new`].
pub fn regions(title: &[String], panels: &[RegionPanel<'_>]) -> Result<String, NoRegion> {
    let drawn: Result<Vec<Panel>, NoRegion> = panels.iter().map(panel).collect();
    let legend = [
        (KEPT, Symbol::Area, "kept"),
        (DOMAIN, Symbol::Line, "border of the domain"),
        (CURVE, Symbol::Line, "trimming curve"),
        (HEAD, Symbol::Arrow, "its direction: its left is its kept side"),
        (OUTLINE, Symbol::Line, "boundary of what is kept"),
    ];
    let legend = legend.map(|(style, symbol, words)| Entry { style, symbol, words: words.into() });
    Ok(page(title, drawn?, &legend))
}

const KEPT: Style = Style { class: "kept", fill: "#cfe3f5", ..NONE };
const DOMAIN: Style = Style { class: "domain", stroke: "#888888", width: 1.0, dash: Some(5.0), ..NONE };
const CURVE: Style = Style { class: "curve", stroke: "#b03a2e", width: 1.2, ..NONE };
const HEAD: Style = Style { class: "directions", fill: "#b03a2e", ..NONE };
const OUTLINE: Style = Style { class: "outline", stroke: "#1f4e79", width: 2.4, ..NONE };
const NONE: Style = Style { class: "", fill: "", stroke: "", width: 0.0, round: false, dash: None, opacity: 0.0 };

fn panel(of: &RegionPanel<'_>) -> Result<Panel, NoRegion> {
    let region = FreeRegion::new(of.trims, &of.domain)?;
    let UvDomain { low, high, .. } = of.domain;
    let turned = |p: DVec2| if of.as_in_paper { DVec2::new(p.y, p.x) } else { p };
    let (low, high) = (turned(low), turned(high));
    let size = high - low;
    let mut panel = Panel::new(low - AROUND * size, high + AROUND * size, size / size.max_element() * SIDE);
    // One path for all loops: nested boundaries are filled by winding number, and loops of one region never overlap.
    let polygons = region.polygons(PER_ARC);
    let outlined = |panel: &Panel| {
        let mut path = Path::default();
        polygons.iter().for_each(|polygon| path.polygon(polygon.iter().map(|&p| panel.place(turned(p)))));
        path
    };
    panel.draw(outlined(&panel), &KEPT);
    let mut border = Path::default();
    border.polygon([low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)].map(|p| panel.place(p)));
    panel.draw(border, &DOMAIN);
    panel.draw(outlined(&panel), &OUTLINE);
    let (mut lines, mut heads) = (Path::default(), Path::default());
    for curve in &of.trims.curves {
        let mut points: Vec<DVec2> = points(curve).into_iter().map(|p| panel.place(turned(p))).collect();
        if of.as_in_paper {
            points.reverse();
        }
        let Some(&first) = points.first() else { continue };
        lines.move_to(first);
        let mut since = 0.5 * ARROWS;
        for ends in points.windows(2) {
            lines.line_to(ends[1]);
            since += ends[0].distance(ends[1]) / UNIT;
            if since >= ARROWS {
                since %= ARROWS;
                heads.arrow_head(0.5 * (ends[0] + ends[1]), ends[1] - ends[0], 11.0 * UNIT);
            }
        }
    }
    panel.draw(lines, &CURVE);
    panel.draw(heads, &HEAD);
    of.caption.iter().for_each(|line| panel.caption(line.as_str()));
    Ok(panel)
}

/// Points along a given curve.
fn points(curve: &TrimCurve) -> Vec<DVec2> {
    let mut out: Vec<DVec2> = Vec::new();
    for piece in &curve.pieces {
        match piece {
            TrimPiece::Polyline(points) => {
                for ends in points.windows(2) {
                    // Subdivide, so that long lines get arrow heads, too.
                    out.extend((0..=8).map(|k| ends[0].lerp(ends[1], f64::from(k) / 8.0)));
                }
            }
            TrimPiece::Nurbs(curve) => {
                let (from, to) = curve.domain();
                let spans = curve.points.len().saturating_sub(curve.degree).max(1);
                let count = PER_SPAN * spans;
                out.extend((0..=count).map(|k| curve.point(from + (to - from) * k as f64 / count as f64)));
            }
        }
    }
    out.dedup();
    out
}
