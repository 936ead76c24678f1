//! Trimming curves across the seams of a periodic surface -> copies shifted by whole periods. Clipped to the domain,
//! the copies together are the curve on the surface.

use super::intersect::{SpanChain, TOUCH};
use crate::prepare::uv::uv_curve::step_along;
use glam::{DVec2, DVec3};

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
    let low = chain.spans.iter().fold(DVec2::INFINITY, |low, s| low.min(s.low()));
    let high = chain.spans.iter().fold(DVec2::NEG_INFINITY, |high, s| high.max(s.high()));
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
