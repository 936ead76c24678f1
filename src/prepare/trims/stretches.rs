//! Chains of spans and places on them -> the stretches in between, and their share of the area by Green's theorem.

use super::intersect::{SpanChain, SpanPlace};
use super::spans::Span;

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
