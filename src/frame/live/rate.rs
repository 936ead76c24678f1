//! Pixels per millimetre -> a step of a geometric series of densities, with hysteresis.
//!
//! Between two frames the density of everything changes a little, and without steps everything would be rebuilt. So
//! densities are rounded up to steps, and a step is lowered only when the density is well below it.

use crate::frame::tolerance::{BoxTolerances, Tolerance};

/// Steps per doubling of the pixels per millimetre. The number of lines grows with its square root, so a step is a
/// factor of 2^(1/4) in lines: 9 % more than needed on average, in each direction.
const STEPS: f64 = 2.0;
/// Hysteresis: a step is lowered once the density is more than this many steps below it.
const SLACK: f64 = 1.5;

/// A step of the series; the higher, the finer. `None`: off-screen.
pub(crate) type Step = Option<i16>;

/// The current step, or steps, of a tile or edge.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Rate {
    /// One step everywhere.
    Even(Step),
    /// One step per bounding box, for what is close to the eye or partly off-screen.
    Each(Box<[Step]>),
}

impl Rate {
    /// The finest step.
    pub(crate) fn finest(&self) -> Step {
        match self {
            Self::Even(step) => *step,
            Self::Each(steps) => steps.iter().copied().max().flatten(),
        }
    }

    /// Whether each box has its own step.
    pub(crate) fn is_each(&self) -> bool {
        matches!(self, Self::Each(_))
    }

    /// The step of box `k`.
    pub(crate) fn step(&self, k: usize) -> Step {
        match self {
            Self::Even(step) => *step,
            Self::Each(steps) => steps.get(k).copied().flatten(),
        }
    }
}

/// The step of a density, in allowed deviations per millimetre. Keeps `before` within the hysteresis. `None` for
/// densities that are NaN or not positive.
pub(crate) fn step(density: f64, before: Step) -> Step {
    if density <= 0.0 || density.is_nan() {
        return None;
    }
    let exact = STEPS * libm::log2(density);
    let kept = before.filter(|&k| exact <= f64::from(k) && exact >= f64::from(k) - SLACK);
    #[allow(clippy::cast_possible_truncation, reason = "clamped")]
    kept.or_else(|| Some(exact.ceil().clamp(f64::from(i16::MIN), f64::from(i16::MAX)) as i16))
}

/// Steps by which a density grows with this factor.
pub(crate) fn steps_of(factor: f64) -> f64 {
    STEPS * libm::log2(factor)
}

/// Factor on the cells of a tile that becomes finer by so many steps: its lines grow with the root of the density, in
/// both directions.
pub(crate) fn growth_of(steps: f64) -> f64 {
    libm::exp2((steps / STEPS).clamp(-40.0, 40.0))
}

/// The range of densities for which a step is kept.
pub(crate) fn band(step: Step) -> (f64, f64) {
    let Some(k) = step.map(f64::from) else { return (0.0, 0.0) };
    (libm::exp2((k - SLACK) / STEPS), libm::exp2(k / STEPS))
}

/// What all rates of a frame have in common, besides their steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Terms {
    /// Largest turning of the normal across a cell, radians.
    pub(crate) angle: f64,
    /// Largest length of mesh edges, as a multiple of the deviation.
    pub(crate) size: Option<f64>,
    /// Steps by which everything is coarsened to stay within the limits.
    pub(crate) coarser: i16,
}

impl Terms {
    /// Factor by which the limits reduce the number of lines.
    pub(crate) fn coarsened(&self) -> f64 {
        libm::exp2(0.5 * f64::from(self.coarser) / STEPS)
    }

    fn density(&self, step: i16) -> f64 {
        libm::exp2((f64::from(step) - f64::from(self.coarser)) / STEPS)
    }

    /// The tolerances of a tile or edge with this rate, in a part of this radius.
    pub(crate) fn need(&self, rate: &Rate, radius: f64) -> BoxTolerances {
        let most = rate.finest();
        let shares = match (rate, most) {
            (Rate::Each(steps), Some(most)) if steps.iter().any(|step| *step != Some(most)) => {
                let share = |step: &Step| step.map_or(0.0, |k| self.density(k) / self.density(most));
                steps.iter().map(share).collect()
            }
            _ => Vec::new(),
        };
        let density = most.map_or(0.0, |step| self.density(step));
        // Lines by the angle become as sparse as those by the chord.
        let angle = self.angle * self.coarsened();
        let tolerance = Tolerance { chord: 1.0 / density, angle, max_edge: self.size.map(|size| size / density) };
        BoxTolerances { tolerance: tolerance.usable(radius), shares, radius }
    }

    /// Rounds a chord tolerance down to a power of two. It then changes only every two steps, and so does what is
    /// measured against it.
    pub(crate) fn settled(chord: f64) -> f64 {
        if chord > 0.0 && chord.is_finite() { libm::exp2(libm::log2(chord).floor()) } else { chord }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_rise_at_once_and_fall_with_hysteresis() {
        assert_eq!(step(0.0, Some(3)), None);
        assert_eq!([step(1.0, None), step(1.01, None), step(0.99, None)], [Some(0), Some(1), Some(0)]);
        for k in -40..40_i16 {
            let (low, high) = band(Some(k));
            assert_eq!(step(high * 0.999_999, Some(k)), Some(k));
            assert_eq!(step(high * 1.000_001, Some(k)), Some(k + 1));
            assert_eq!(step(low * 1.000_001, Some(k)), Some(k));
            assert_eq!(step(low * 0.999_999, Some(k)), Some(k - 1), "{k}");
        }
    }

    #[test]
    fn needs_are_at_least_as_strict_as_the_views() {
        let terms = Terms { angle: 0.3, size: Some(20.0), coarser: 0 };
        for k in 0..60 {
            let density = 1.13_f64.powi(k - 30);
            let need = terms.need(&Rate::Even(step(density, None)), 1.0);
            assert!(need.tolerance.chord * density <= 1.0 && need.tolerance.chord * density > 0.7);
            assert_eq!((need.tolerance.max_edge, need.shares), (Some(20.0 * need.tolerance.chord), vec![]));
        }
        let each = Rate::Each(Box::new([Some(-4), None, Some(-2)]));
        let need = terms.need(&each, 1.0);
        assert_eq!((need.tolerance.chord, need.shares), (2.0, vec![0.5, 0.0, 1.0]));
        let coarser = Terms { coarser: 2, ..terms };
        assert_eq!(coarser.need(&each, 1.0).tolerance.chord, 4.0);
        let unseen = terms.need(&Rate::Each(Box::new([None; 2])), 1.0);
        assert_eq!((unseen.tolerance.chord, unseen.shares), (f64::INFINITY, vec![]));
        assert_eq!(
            [Terms::settled(0.3), Terms::settled(0.25), Terms::settled(f64::INFINITY)],
            [0.25, 0.25, f64::INFINITY]
        );
    }
}
