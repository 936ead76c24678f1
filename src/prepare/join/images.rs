//! Samples of an edge's pcurves in its tiles. Every plan compares them with its lattices; they never change.

use crate::prepare::surface::tables::CurveBounds;

/// Samples of an edge's images: its pcurves in the tiles that use it.
#[derive(Clone, Debug, Default)]
pub struct EdgeImages {
    /// Ends of the strips; empty if they are those of the edge's bounds.
    pub(crate) cuts: Vec<f64>,
    /// One per use of the edge.
    pub(crate) spans: Vec<ImageSpan>,
    pub(crate) places: Vec<[f32; 2]>,
}

/// The stretch of an edge that a use covers, and where its samples are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ImageSpan {
    pub(crate) ends: [f64; 2],
    /// Indices of its first strip and its first place.
    pub(crate) strip: u32,
    pub(crate) place: u32,
    /// Steps per strip.
    pub(crate) steps: u32,
}

/// An image of an edge: the sampled pcurve of one use.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeImage<'a> {
    /// First and last parameter.
    pub(crate) ends: [f64; 2],
    /// Index of the first strip that it runs through.
    pub(crate) strip: usize,
    /// Places as shares of the tile in u and in v, at even steps within each strip, which `ends` may shorten. Includes
    /// the ends of strips, once each.
    pub(crate) places: &'a [[f32; 2]],
    pub(crate) steps: usize,
}

impl<'a> EdgeImage<'a> {
    /// The first place, and the following places strip by strip; `None` if the image has no strips.
    pub(crate) fn steps(&self) -> Option<([f32; 2], std::slice::ChunksExact<'a, [f32; 2]>)> {
        let (first, rest) = self.places.split_first()?;
        Some((*first, rest.chunks_exact(self.steps))).filter(|(_, strips)| strips.len() > 0)
    }
}

impl EdgeImages {
    /// Ends of the strips. They include those of the edge's bounds.
    pub(crate) fn strips<'a>(&'a self, bounds: &'a CurveBounds) -> &'a [f64] {
        if self.cuts.is_empty() { &bounds.breaks } else { &self.cuts }
    }

    /// The image of the edge's use `k`.
    pub(crate) fn image(&self, k: usize) -> EdgeImage<'_> {
        let ImageSpan { ends, strip, place, steps } = self.spans[k];
        let end = self.spans.get(k + 1).map_or(self.places.len(), |next| next.place as usize);
        EdgeImage { ends, strip: strip as usize, places: &self.places[place as usize..end], steps: steps as usize }
    }
}
