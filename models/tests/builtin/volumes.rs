//! Sections, turned areas and rounded corners -> volumes, by the theorems of Pappus and Steiner.

use glam::DVec2;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

/// Area and perimeter of a plane figure.
#[derive(Clone, Copy)]
pub(crate) struct Section {
    pub(crate) area: f64,
    pub(crate) outline: f64,
}

impl Section {
    /// A convex, counter-clockwise polygon with corners `(x, y, radius)`.
    pub(crate) fn rounded(corners: &[(f64, f64, f64)]) -> Self {
        let mut section = Self { area: 0.0, outline: 0.0 };
        let n = corners.len();
        let at = |k: usize| DVec2::new(corners[k % n].0, corners[k % n].1);
        for (k, &(x, y, radius)) in corners.iter().enumerate() {
            let (before, here, after) = (at(k + n - 1), DVec2::new(x, y), at(k + 1));
            let turn = (here - before).angle_to(after - here);
            let cut = (0.5 * turn).tan();
            section.area += 0.5 * here.perp_dot(after) - radius * radius * (cut - 0.5 * turn);
            section.outline += here.distance(after) - radius * (2.0 * cut - turn);
        }
        section
    }

    /// Volume of the prism of this height with the edges of `ends` ends (0 to 2) rounded. The outline must be smooth.
    /// Negative radii are fillets around the foot.
    pub(crate) fn prism(&self, height: f64, ends: f64, radius: f64) -> f64 {
        let r = radius.abs();
        // The integrals of the outline's offset and of its square over the height of the rounding.
        let (first, second) = (r * r * (1.0 - FRAC_PI_4), r * r * r * (5.0 / 3.0 - FRAC_PI_2));
        self.area * height + ends * (PI * second - radius.signum() * self.outline * first)
    }
}

/// Volume of a ring of rectangular section.
pub(crate) fn ring(inner: f64, outer: f64, height: f64) -> f64 {
    PI * (outer * outer - inner * inner) * height
}

/// Volume of a frustum of a cone.
pub(crate) fn frustum(a: f64, b: f64, height: f64) -> f64 {
    PI / 3.0 * (a * a + a * b + b * b) * height
}

/// Volume that rounding a corner of a turned section removes, or adds in a hollow corner.
///
/// `corner` is its distance from the axis. The material is outwards of a convex corner (`outwards` 1) or towards the
/// axis (-1); for a hollow corner it is the other way round.
pub(crate) fn rounding(corner: f64, outwards: f64, radius: f64) -> f64 {
    let area = radius * radius * (1.0 - FRAC_PI_4);
    let centroid = radius * (10.0 - 3.0 * PI) / (3.0 * (4.0 - PI));
    TAU * (corner + outwards * centroid) * area
}

/// Integral of a polynomial of degree at most 9, by Gauss quadrature.
pub(crate) fn integral(f: impl Fn(f64) -> f64, (a, b): (f64, f64)) -> f64 {
    const NODES: [(f64, f64); 5] = [
        (0.0, 0.568_888_888_888_888_9),
        (0.538_469_310_105_683, 0.478_628_670_499_366_47),
        (-0.538_469_310_105_683, 0.478_628_670_499_366_47),
        (0.906_179_845_938_664, 0.236_926_885_056_189_08),
        (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
    ];
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    NODES.iter().map(|&(x, w)| w * f(middle + half * x)).sum::<f64>() * half
}
