//! Trimming curves -> chains of spans; across the seams of a periodic surface, copies shifted by whole periods, which
//! clipped to the domain are the curve on the surface together; places on a chain -> the stretches in between, and
//! their share of the area by Green's theorem.

use super::spans::{Span, UvDomain, spans};
use crate::math::boxes::around;
use crate::model::TrimCurve;
use crate::prepare::uv::uv_curve::step_along;
use glam::{DVec2, DVec3};

/// Distance in the unit square below which points are one. Curves are stated with twelve digits or more, and a sliver
/// of a billionth of a domain has no triangles.
pub(crate) const TOUCH: f64 = 1e-9;

/// Spans end to end.
#[derive(Clone, Debug)]
pub(crate) struct SpanChain {
    pub(crate) spans: Vec<Span>,
    pub(crate) closed: bool,
}

impl SpanChain {
    pub(crate) fn of(curve: &TrimCurve, domain: &UvDomain) -> Self {
        let mut spans = spans(curve, domain);
        let closed = spans.len() > 1 && curve.is_closed();
        if closed {
            let start = spans[0].ends[0];
            if let Some(last) = spans.last_mut() {
                last.ends[1] = start;
            }
        }
        Self { spans, closed }
    }

    /// The ends that two spans of the chain share because one follows the other.
    pub(super) fn joint(&self, a: usize, b: usize) -> impl Iterator<Item = DVec2> + use<'_> {
        let follows = |a: usize, b: usize| a + 1 == b || (self.closed && a + 1 == self.spans.len() && b == 0);
        let of_pair = [(a, b), (b, a)];
        of_pair.into_iter().filter(move |&(a, b)| follows(a, b)).map(|(a, _)| self.spans[a].ends[1])
    }
}

/// A place on a chain.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SpanPlace {
    pub(crate) chain: usize,
    pub(crate) span: usize,
    pub(crate) s: f64,
}

/// Most periods that a curve may extend from the domain, in each direction. Curves that go further are clipped.
const MAX_COPIES: i32 = 16;

/// The copies of a chain that reach into the unit square, at least one, and the directions in which they are complete.
/// In the other directions a chain that leaves the square is clipped.
///
/// A closed chain has a copy for each shift whose box meets the square. An open chain that ends one period from its
/// start is closed on the surface: it has one copy, repeated end to end until it crosses the square from side to side.
/// Other open chains stay as they are.
pub(crate) fn copies(chain: SpanChain, periodic: [bool; 2]) -> (Vec<SpanChain>, [bool; 2]) {
    if let Some(axis) = (0..2).find(|&axis| periodic[axis] && goes_round(&chain, axis)) {
        let mut complete = [false; 2];
        complete[axis] = true;
        return (vec![extended(chain, axis)], complete);
    }
    if !chain.closed || periodic == [false; 2] {
        return (vec![chain], [false; 2]);
    }
    let [low, high] = around(chain.spans.iter().flat_map(|s| s.ends));
    let shifts = [0, 1].map(|axis| {
        let from = (TOUCH - high[axis]).ceil();
        let to = (1.0 - TOUCH - low[axis]).floor();
        let few = from.abs().max(to.abs()) <= f64::from(MAX_COPIES);
        if periodic[axis] && few && from <= to { from as i32..=to as i32 } else { 0..=0 }
    });
    let complete = [0, 1].map(|axis| periodic[axis] && low[axis].abs().max(high[axis].abs()) <= f64::from(MAX_COPIES));
    let shifts = shifts[0].clone().flat_map(|u| shifts[1].clone().map(move |v| DVec2::new(f64::from(u), f64::from(v))));
    (shifts.map(|by| shifted(&chain, by)).collect(), complete)
}

/// Whether an open chain ends one period from where it starts.
fn goes_round(chain: &SpanChain, axis: usize) -> bool {
    let (false, Some(first), Some(last)) = (chain.closed, chain.spans.first(), chain.spans.last()) else {
        return false;
    };
    let way = last.ends[1] - first.ends[0];
    (way[axis].abs() - 1.0).abs() <= TOUCH
        && way[1 - axis].abs() <= TOUCH
        && first.ends[0][axis].abs() <= f64::from(MAX_COPIES)
}

/// Repeats a chain that goes round, end to end, until it crosses the unit square.
fn extended(chain: SpanChain, axis: usize) -> SpanChain {
    let (start, end) = (chain.spans[0].ends[0][axis], chain.spans[chain.spans.len() - 1].ends[1][axis]);
    let (low, high) = (start.min(end), start.max(end));
    let before = (low - TOUCH).ceil().max(0.0) as i32;
    let after = (1.0 - TOUCH - high).ceil().max(0.0) as i32;
    let steps: Vec<i32> = if start < end { (-before..=after).collect() } else { (-before..=after).rev().collect() };
    let mut spans = Vec::new();
    for step in steps {
        spans.extend(shifted(&chain, step_along(axis, f64::from(step))).spans);
    }
    for k in 1..spans.len() {
        // Neighbours share their ends bit for bit.
        spans[k].ends[0] = spans[k - 1].ends[1];
    }
    SpanChain { spans, closed: false }
}

fn shifted(chain: &SpanChain, by: DVec2) -> SpanChain {
    let mut chain = chain.clone();
    if by == DVec2::ZERO {
        return chain;
    }
    for span in &mut chain.spans {
        span.ends = span.ends.map(|p| p + by);
        for c in &mut span.control {
            *c += DVec3::new(by.x, by.y, 0.0) * c.z;
        }
    }
    chain
}

/// A part of a span.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StretchPart {
    pub(crate) span: usize,
    pub(crate) from: f64,
    pub(crate) to: f64,
}

/// The parts that make up a whole chain.
pub(crate) fn whole(chain: &SpanChain) -> Vec<StretchPart> {
    (0..chain.spans.len()).map(|span| StretchPart { span, from: 0.0, to: 1.0 }).collect()
}

/// The parts of a chain from one place to another. `round`: passes the start of the chain.
pub(crate) fn stretch(chain: &SpanChain, from: SpanPlace, to: SpanPlace, round: bool) -> Vec<StretchPart> {
    let count = chain.spans.len();
    let mut out = Vec::new();
    let (mut span, mut s) = (from.span, from.s);
    let last = to.span + if round { count } else { 0 };
    let mut at = from.span;
    loop {
        let end = if at == last { to.s } else { 1.0 };
        if end > s {
            out.push(StretchPart { span, from: s, to: end });
        }
        if at >= last {
            break;
        }
        at += 1;
        (span, s) = (at % count, 0.0);
    }
    out
}

/// The integral of x dy along a part of a span, by Gauss–Legendre quadrature: exact for polynomial spans up to degree
/// 15, and to rounding for arcs of conics.
pub(crate) fn green(span: &Span, part: &StretchPart) -> f64 {
    const NODES: [(f64, f64); 8] = [
        (0.095_012_509_837_637_44, 0.189_450_610_455_068_5),
        (0.281_603_550_779_258_9, 0.182_603_415_044_923_6),
        (0.458_016_777_657_227_4, 0.169_156_519_395_002_54),
        (0.617_876_244_402_643_7, 0.149_595_988_816_576_73),
        (0.755_404_408_355_003, 0.124_628_971_255_533_87),
        (0.865_631_202_387_831_7, 0.095_158_511_682_492_78),
        (0.944_575_023_073_232_6, 0.062_253_523_938_647_89),
        (0.989_400_934_991_649_9, 0.027_152_459_411_754_095),
    ];
    if span.control.len() == 2 {
        let (a, b) = (span.point(part.from), span.point(part.to));
        return 0.5 * (a.x + b.x) * (b.y - a.y);
    }
    // Arcs of high degree need more than one interval.
    let intervals = span.control.len().div_ceil(4);
    let width = (part.to - part.from) / intervals as f64;
    (0..intervals)
        .flat_map(|k| NODES.iter().flat_map(move |&(x, w)| [(k, x, w), (k, -x, w)]))
        .map(|(k, x, w)| {
            let [p, d, _] = span.derivatives(part.from + width * (k as f64 + 0.5 + 0.5 * x));
            0.5 * width * w * p.x * d.y
        })
        .sum()
}
