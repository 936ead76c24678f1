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
    /// One per use and strip, see [`EdgeImage::rates`].
    pub(crate) rates: Vec<[f32; 2]>,
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
    /// Index of the rates of its first strip.
    pub(crate) rate: u32,
    /// See [`EdgeImage::ways`].
    pub(crate) ways: [f32; 2],
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
    /// Strip by strip: how often the image would cross the tile in u and in v per unit of the edge's parameter if all
    /// steps were as long as the longest one. Outside the tile it does not move.
    pub(crate) rates: &'a [[f32; 2]],
    /// The sum of that over all strips: a number of crossings in u and in v.
    pub(crate) ways: [f32; 2],
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
        let ImageSpan { ends, strip, place, steps, rate, ways } = self.spans[k];
        let (places_end, rates_end) = match self.spans.get(k + 1) {
            Some(next) => (next.place as usize, next.rate as usize),
            None => (self.places.len(), self.rates.len()),
        };
        EdgeImage {
            ends,
            strip: strip as usize,
            places: &self.places[place as usize..places_end],
            steps: steps as usize,
            rates: &self.rates[rate as usize..rates_end],
            ways,
        }
    }
}
