//! What a file states of a B-spline curve or surface -> its degrees, knots and weights, checked, without breaks where
//! both sides meet.

use super::spline;
use super::table::{Entity, Read, Trouble};
use crate::model::{self, MAX_DEGREE, NurbsCurve3, NurbsSurface, SplineError, StepTrouble};
use std::iter::repeat_n;

/// Implied knot vectors of B-splines that state none.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Form {
    /// Clamped, inner knots equally spaced and single.
    QuasiUniform,
    /// All knots equally spaced and single.
    Uniform,
    /// Clamped, inner knots of multiplicity `degree`.
    Bezier,
}

impl Form {
    /// The form of a curve or surface; `what` is `CURVE` or `SURFACE`.
    pub(super) fn of(instance: Entity<'_>, what: &str) -> Self {
        let is = |form: &str| instance.types().any(|name| name.strip_suffix(what) == Some(form));
        if is("UNIFORM_") {
            Self::Uniform
        } else if is("BEZIER_") {
            Self::Bezier
        } else {
            Self::QuasiUniform
        }
    }
}

/// The stated knots, repeated by multiplicity, else those that the form implies.
pub(super) fn knots_of(
    stated: Option<(Vec<usize>, Vec<f64>)>,
    form: Form,
    count: usize,
    degree: usize,
    id: u64,
) -> Read<Vec<f64>> {
    if let Some((multiplicities, values)) = stated {
        if let Some(index) = (1..values.len()).find(|&k| values[k] < values[k - 1]) {
            let error = SplineError::Decreasing { index, before: values[index - 1], knot: values[index] };
            return Err(Trouble::new(id, error));
        }
        if multiplicities.len() != values.len() {
            return Err(Trouble::new(id, StepTrouble::Layout { what: "multiplicities", wanted: "one per knot" }));
        }
        let total = multiplicities.iter().fold(0, |sum: usize, times| sum.saturating_add(*times));
        if total != count + degree + 1 {
            return Err(Trouble::new(id, SplineError::Count { degree, knots: total, points: count }));
        }
        let knots: Vec<f64> = values.iter().zip(multiplicities).flat_map(|(v, times)| repeat_n(*v, times)).collect();
        if knots[degree] >= knots[count] {
            return Err(Trouble::new(id, SplineError::Empty { at: knots[count] }));
        }
        return Ok(knots);
    }
    let clamped = |inner: &mut dyn Iterator<Item = f64>, last: f64| -> Vec<f64> {
        let ends = |value: f64| repeat_n(value, degree + 1);
        ends(0.0).chain(inner).chain(ends(last)).collect()
    };
    match form {
        Form::Uniform => Ok((0..=count + degree).map(|i| i as f64 - degree as f64).collect()),
        Form::QuasiUniform => {
            let spans = count - degree;
            Ok(clamped(&mut (1..spans).map(|i| i as f64), spans as f64))
        }
        Form::Bezier if (count - 1).is_multiple_of(degree) => {
            let spans = (count - 1) / degree;
            let mut inner = (1..spans).flat_map(|i| repeat_n(i as f64, degree));
            Ok(clamped(&mut inner, spans as f64))
        }
        Form::Bezier => Err(Trouble::new(id, SplineError::Chain { degree, points: count })),
    }
}

pub(super) fn check_degree(degree: usize, count: usize, id: u64) -> Read<()> {
    if !(1..=MAX_DEGREE).contains(&degree) {
        return Err(Trouble::new(id, SplineError::Degree { degree }));
    }
    if count <= degree {
        return Err(Trouble::new(id, SplineError::Points { degree, points: count }));
    }
    Ok(())
}

/// Checks weights; drops them if all are equal.
pub(super) fn check_weights(weights: Vec<f64>, count: usize, id: u64) -> Read<Vec<f64>> {
    if weights.len() != count {
        return Err(Trouble::new(id, SplineError::Weights { weights: weights.len(), points: count }));
    }
    if weights[0] > 0.0 && weights[0] < f64::INFINITY && weights.iter().all(|w| *w == weights[0]) {
        return Ok(Vec::new());
    }
    model::check_weights(&weights).map_err(|error| Trouble::new(id, error))?;
    Ok(weights)
}

/// Removes knots of too high multiplicity where both sides of the break meet in one point.
pub(super) fn drop_breaks(curve: &mut NurbsCurve3, tolerance: f64, id: u64) -> Read<()> {
    let joins = |a: usize, b: usize| curve.points[a].distance(curve.points[b]) <= tolerance;
    let left = spline::without_breaks(&curve.knots, curve.degree, joins)
        .map_err(|knot| Trouble::new(id, SplineError::Jump { knot }))?;
    if let Some((points, knots)) = left {
        curve.points = points.iter().map(|i| curve.points[*i]).collect();
        if !curve.weights.is_empty() {
            curve.weights = points.iter().map(|i| curve.weights[*i]).collect();
        }
        curve.knots = knots;
    }
    Ok(())
}

/// Removes knots of too high multiplicity, with their rows and columns, where both sides of the break coincide.
pub(super) fn drop_net_breaks(net: &mut NurbsSurface, tolerance: f64, id: u64) -> Read<()> {
    let (count_u, count_v) = (net.count_u(), net.count_v());
    let near = |a: usize, b: usize| net.points[a].distance(net.points[b]) <= tolerance;
    let rows = |a: usize, b: usize| (0..count_v).all(|j| near(a * count_v + j, b * count_v + j));
    let columns = |a: usize, b: usize| (0..count_u).all(|i| near(i * count_v + a, i * count_v + b));
    let jump = |knot| Trouble::new(id, SplineError::Jump { knot });
    let u = spline::without_breaks(&net.knots_u, net.degree_u, rows).map_err(jump)?;
    let v = spline::without_breaks(&net.knots_v, net.degree_v, columns).map_err(jump)?;
    if u.is_none() && v.is_none() {
        return Ok(());
    }
    let (rows, knots_u) = u.unwrap_or_else(|| ((0..count_u).collect(), net.knots_u.clone()));
    let (columns, knots_v) = v.unwrap_or_else(|| ((0..count_v).collect(), net.knots_v.clone()));
    let kept = || rows.iter().flat_map(|i| columns.iter().map(move |j| i * count_v + j));
    net.points = kept().map(|k| net.points[k]).collect();
    if !net.weights.is_empty() {
        net.weights = kept().map(|k| net.weights[k]).collect();
    }
    (net.knots_u, net.knots_v) = (knots_u, knots_v);
    Ok(())
}
