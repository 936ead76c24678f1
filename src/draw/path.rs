//! Points of the page -> the `d` attribute of an SVG path, relative and in whole units: a few bytes per point.

use glam::{DVec2, IVec2};
use std::fmt::Write as _;

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

    pub(super) fn into_data(self) -> String {
        self.data
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

    /// Closes the figure.
    pub(super) fn close(&mut self) {
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

    /// Adds a line between two points.
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
        assert_eq!(path.into_data(), "m10 5h10v3l-13-7zm1-1h0zm0 0");
    }
}
