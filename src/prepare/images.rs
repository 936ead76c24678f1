//! Edges and the curves in (u,v) that they are in their tiles -> places along those curves, which every plan holds against its
//! lattices: they are the same in every frame.

use super::{CurveBounds, PreparedEdge, Tile, UvCurve};
use rayon::prelude::*;

/// Steps per strip: enough that a lattice denser at one end of the strip is seen.
const STEPS: usize = 4;

/// Where an edge's images run in the tiles that use it.
#[derive(Clone, Debug, Default)]
pub struct EdgeImages {
    /// Borders of strips, where these are not the bounds' own.
    cuts: Vec<f64>,
    /// One per use of the edge.
    spans: Vec<Span>,
    places: Vec<[f32; 2]>,
}

/// The part of an edge that a use runs along.
#[derive(Clone, Copy, Debug)]
struct Span {
    ends: [f64; 2],
    /// Its first strip, and its first place.
    strip: u32,
    place: u32,
}

/// An image of an edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Image<'a> {
    /// First and last parameter.
    pub(crate) ends: [f64; 2],
    /// The first strip that it runs through.
    pub(crate) strip: usize,
    /// Places as shares of the tile in u and in v, strip by strip at even steps between its borders or `ends`; both are among
    /// them, borders once.
    places: &'a [[f32; 2]],
}

impl<'a> Image<'a> {
    /// Where it begins, and the steps of each strip; `None` where it is no longer than a point.
    pub(crate) fn steps(&self) -> Option<([f32; 2], &'a [[[f32; 2]; STEPS]])> {
        let (first, rest) = self.places.split_first()?;
        Some((*first, rest.as_chunks().0)).filter(|(_, strips)| !strips.is_empty())
    }
}

impl EdgeImages {
    /// Looks at all uses of an edge.
    fn of(edge: &PreparedEdge, tiles: &[Tile]) -> Self {
        let mut out = Self { cuts: dense(edge, tiles), spans: Vec::with_capacity(edge.uses.len()), places: Vec::new() };
        for &(tile, l, u) in &edge.uses {
            let tile = &tiles[tile.0 as usize];
            let used = &tile.loops[l as usize][u as usize];
            let (from, to) = (edge.breaks[used.from as usize].t, edge.breaks[used.to as usize].t);
            let ends = [from.min(to), from.max(to)];
            let mut hint = 0;
            let mut place = |t: f64| {
                let share = (used.uv.point(t, &mut hint) - tile.min) / (tile.max - tile.min);
                share.as_vec2().to_array()
            };
            let breaks = if out.cuts.is_empty() { &edge.bounds.breaks } else { &out.cuts };
            let mut span = Span { ends, strip: 0, place: out.places.len() as u32 };
            for (k, strip) in breaks.windows(2).enumerate() {
                let (a, b) = (strip[0].max(ends[0]), strip[1].min(ends[1]));
                if a >= b {
                    continue;
                }
                if out.places.len() == span.place as usize {
                    span.strip = k as u32;
                    out.places.push(place(a));
                }
                let step = (b - a) / STEPS as f64;
                out.places.extend((1..=STEPS).map(|i| place(a + step * i as f64)));
            }
            out.spans.push(span);
        }
        out.places.shrink_to_fit();
        out
    }

    /// Borders of the strips that images are looked at by: those of the edge's bounds among others.
    pub(crate) fn strips<'a>(&'a self, bounds: &'a CurveBounds) -> &'a [f64] {
        if self.cuts.is_empty() { &bounds.breaks } else { &self.cuts }
    }

    /// The image in the edge's use number `k`.
    pub(crate) fn image(&self, k: usize) -> Image<'_> {
        let Span { ends, strip, place } = self.spans[k];
        let end = self.spans.get(k + 1).map_or(self.places.len(), |next| next.place as usize);
        Image { ends, strip: strip as usize, places: &self.places[place as usize..end] }
    }
}

/// Samples the images of all edges.
pub(super) fn sample(edges: &mut [PreparedEdge], tiles: &[Tile]) {
    edges.par_iter_mut().for_each(|edge| edge.images = EdgeImages::of(edge, tiles));
}

/// Borders of an edge's strips, cut further where one of its images turns within a strip: beside a pole it runs over half a
/// lattice in a thousandth of the edge, and only there segments have to be short. Empty where none does.
fn dense(edge: &PreparedEdge, tiles: &[Tile]) -> Vec<f64> {
    /// Samples of an image within a strip from which on it is cut at each of them. Ordinary edges have two to eight.
    const MANY: usize = 16;
    let breaks = &edge.bounds.breaks;
    let mut cuts: Vec<f64> = Vec::new();
    for &(tile, l, u) in &edge.uses {
        let UvCurve::Hermite(samples) = &tiles[tile.0 as usize].loops[l as usize][u as usize].uv else { continue };
        if samples.len() < MANY {
            continue;
        }
        for w in breaks.windows(2) {
            let first = samples.partition_point(|s| s.t <= w[0]);
            let last = samples.partition_point(|s| s.t < w[1]);
            if last >= first + MANY {
                cuts.extend(samples[first..last].iter().map(|s| s.t));
            }
        }
    }
    if cuts.is_empty() {
        return cuts;
    }
    cuts.extend_from_slice(breaks);
    // A stretch of the edge ends at a break, and is sampled up to there.
    cuts.extend(edge.breaks.iter().map(|b| b.t).filter(|&t| t > breaks[0] && t < breaks[breaks.len() - 1]));
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    cuts
}
