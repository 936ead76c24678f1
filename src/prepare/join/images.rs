//! Edges and the curves in (u,v) that they are in their tiles -> places along those curves, which every plan holds against its
//! lattices: they are the same in every frame.

use crate::prepare::surface::tables::CurveBounds;

/// Where an edge's images run in the tiles that use it.
#[derive(Clone, Debug, Default)]
pub struct EdgeImages {
    /// Borders of strips, where these are not the bounds' own.
    pub(crate) cuts: Vec<f64>,
    /// One per use of the edge.
    pub(crate) spans: Vec<ImageSpan>,
    pub(crate) places: Vec<[f32; 2]>,
}

/// The part of an edge that a use runs along.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ImageSpan {
    pub(crate) ends: [f64; 2],
    /// Its first strip, and its first place.
    pub(crate) strip: u32,
    pub(crate) place: u32,
    /// Steps per strip.
    pub(crate) steps: u32,
}

/// An image of an edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeImage<'a> {
    /// First and last parameter.
    pub(crate) ends: [f64; 2],
    /// The first strip that it runs through.
    pub(crate) strip: usize,
    /// Places as shares of the tile in u and in v, strip by strip at even steps between its borders or `ends`; both are among
    /// them, borders once.
    pub(crate) places: &'a [[f32; 2]],
    pub(crate) steps: usize,
}

impl<'a> EdgeImage<'a> {
    /// Where it begins, and the steps of each strip; `None` where it is no longer than a point.
    pub(crate) fn steps(&self) -> Option<([f32; 2], std::slice::ChunksExact<'a, [f32; 2]>)> {
        let (first, rest) = self.places.split_first()?;
        Some((*first, rest.chunks_exact(self.steps))).filter(|(_, strips)| strips.len() > 0)
    }
}

impl EdgeImages {
    /// Borders of the strips that images are looked at by: those of the edge's bounds among others.
    pub(crate) fn strips<'a>(&'a self, bounds: &'a CurveBounds) -> &'a [f64] {
        if self.cuts.is_empty() { &bounds.breaks } else { &self.cuts }
    }

    /// The image in the edge's use number `k`.
    pub(crate) fn image(&self, k: usize) -> EdgeImage<'_> {
        let ImageSpan { ends, strip, place, steps } = self.spans[k];
        let end = self.spans.get(k + 1).map_or(self.places.len(), |next| next.place as usize);
        EdgeImage { ends, strip: strip as usize, places: &self.places[place as usize..end], steps: steps as usize }
    }
}
