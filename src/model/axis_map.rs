//! Natural parameters of analytic surfaces <-> parameters of their exact NURBS.

/// Maps one natural parameter of a surface to the parameter of its NURBS form, and back.
///
/// Both ways strictly increasing; the identity at span ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AxisMap {
    /// Both parameters are equal.
    Identity,
    /// An angle, in `spans` equal spans of `step` ≤ 90° from `start`. Each is a rational quadratic with weights
    /// 1, cos(step/2), 1.
    Arc {
        /// First angle, radians.
        start: f64,
        /// Angle per span, radians.
        step: f64,
        /// Number of spans.
        spans: u32,
    },
}

/// Parameters within this share of all spans from a span's end map to the knot itself.
const SNAP: f64 = 1e-14;

impl AxisMap {
    /// Converts a natural parameter to the NURBS parameter.
    ///
    /// Within a span, `tan(φ/2) = s·tan(step/4)`, with φ the angle from the span's middle and s in [-1, 1] the NURBS
    /// parameter across it (the tangent half-angle form of the circle). Extrapolates linearly beyond the ends.
    #[must_use]
    pub fn to_nurbs(&self, natural: f64) -> f64 {
        self.with_rates()(natural).0
    }

    /// [`to_nurbs`](Self::to_nurbs) and [`rate`](Self::rate) for many parameters: computes what they share once.
    pub(crate) fn with_rates(self) -> impl Fn(f64) -> (f64, f64) {
        let quarter = self.quarter();
        move |natural| {
            let Self::Arc { start, step, spans } = self else { return (natural, 1.0) };
            let turns = (natural - start) / step;
            let last = f64::from(spans);
            let inside = turns.clamp(0.0, last);
            let span = inside.floor().min(last - 1.0);
            let s = libm::tan(0.5 * step * (inside - span - 0.5)) / quarter;
            let near = turns.round();
            let nurbs = if turns < 0.0 {
                natural_end(natural, start, slope(1.0, step, quarter))
            } else if turns > last {
                natural_end(natural, start + step * last, slope(1.0, step, quarter))
            } else if (turns - near).abs() <= SNAP * last.max(1.0) {
                start + step * near
            } else {
                start + step * (span + 0.5 * (1.0 + s))
            };
            (nurbs, slope(s, step, quarter))
        }
    }

    /// The natural parameters that divide each span into `parts`, its ends included, between two of them; increasing.
    pub(crate) fn parts_of_spans(self, parts: u32, low: f64, high: f64) -> impl Iterator<Item = f64> {
        let (start, part, count) = match self {
            Self::Identity => (0.0, 1.0, 0),
            Self::Arc { start, step, spans } => (start, step / f64::from(parts), parts * spans + 1),
        };
        // Not below 0, nor beyond the last: converting to an integer saturates.
        let (first, last) = (((low - start) / part) as u32, ((high - start) / part) as u32);
        (first..last.saturating_add(1).min(count))
            .map(move |k| start + part * f64::from(k))
            .filter(move |at| low < *at && *at < high)
    }

    /// `tan(step/4)` of an arc.
    fn quarter(&self) -> f64 {
        if let Self::Arc { step, .. } = *self { libm::tan(0.25 * step) } else { 0.0 }
    }

    /// Converts a NURBS parameter to the natural parameter: the inverse of [`to_nurbs`](Self::to_nurbs).
    #[must_use]
    pub fn to_natural(&self, nurbs: f64) -> f64 {
        self.naturals()(nurbs)
    }

    /// [`to_natural`](Self::to_natural) for many parameters: computes what they share once.
    pub fn naturals(self) -> impl Fn(f64) -> f64 {
        let quarter = self.quarter();
        move |nurbs| {
            let Self::Arc { start, step, spans } = self else { return nurbs };
            let turns = (nurbs - start) / step;
            if turns < 0.0 {
                return natural_end(nurbs, start, 1.0 / slope(1.0, step, quarter));
            }
            let last = f64::from(spans);
            if turns > last {
                return natural_end(nurbs, start + step * last, 1.0 / slope(1.0, step, quarter));
            }
            // Not below 0: converting to an integer rounds down, without a call.
            let below = f64::from(turns as u32);
            let near = if turns - below < 0.5 { below } else { below + 1.0 };
            if (turns - near).abs() <= SNAP * last.max(1.0) {
                return start + step * near;
            }
            let span = below.min(last - 1.0);
            let s = 2.0 * (turns - span) - 1.0;
            start + step * (span + 0.5) + 2.0 * libm::atan(s * quarter)
        }
    }

    /// The derivative of the NURBS parameter by the natural one at `natural`; between 0.785 and 1.28 for arcs.
    #[must_use]
    pub fn rate(&self, natural: f64) -> f64 {
        self.with_rates()(natural).1
    }
}

/// `d nurbs / d angle` at s across a span; `quarter` is `tan(step/4)`.
fn slope(s: f64, step: f64, quarter: f64) -> f64 {
    0.25 * step * (1.0 + s * s * quarter * quarter) / quarter
}

/// The line of the given slope through (`end`, `end`), at `t`.
fn natural_end(t: f64, end: f64, slope: f64) -> f64 {
    end + (t - end) * slope
}
