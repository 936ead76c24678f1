//! Two edges of a face that coincide within the tolerance -> whether they may merge: not if the face is a sliver.
//!
//! The two edges of a seam coincide as well. But then the face extends far from the seam, and parts of its boundary
//! have no other edge as near.

use super::candidate::is_sound;
use super::overlap::CurveQuery;
use crate::model::Part;
use crate::prepare::trims::free_faces::FreeFaces;
use std::collections::BTreeMap;

/// Distance, in tolerances, that a face must extend from two of its edges to be more than a sliver between them.
const FAR: f64 = 8.0;

/// Two edges within this share of their length have nothing between them.
const ROUNDING: f64 = 1e-9;

/// Decides for the faces of a part. The boundary of a face is sampled on first use.
pub(crate) struct SliverCheck<'a> {
    part: &'a Part,
    free: &'a FreeFaces,
    rims: BTreeMap<usize, Rim>,
    /// Faces whose edges stay apart, with the tolerance.
    pub(crate) kept: BTreeMap<usize, f64>,
}

/// A face's boundary.
struct Rim {
    edges: Vec<(u32, CurveQuery)>,
    /// Whether another edge is near everywhere along it.
    thin: bool,
}

impl<'a> SliverCheck<'a> {
    pub(crate) fn new(part: &'a Part, free: &'a FreeFaces) -> Self {
        Self { part, free, rims: BTreeMap::new(), kept: BTreeMap::new() }
    }

    /// Whether two edges of a face, at most `width` apart, may merge.
    ///
    /// Cost: feet of one edge's points on all others; for thin faces, of all edges' points.
    pub(crate) fn may_join(&mut self, face: usize, pair: [u32; 2], width: f64, tolerance: f64) -> bool {
        let reach = FAR * tolerance;
        let (part, free) = (self.part, self.free);
        let rim = self.rims.entry(face).or_insert_with(|| Rim::new(part, free, face, reach));
        let of_pair = || rim.edges.iter().filter(|e| pair.contains(&e.0)).map(|e| &e.1);
        let coincide = of_pair().all(|course| width <= ROUNDING * course.length());
        let goes_away = || {
            let others = rim.edges.iter().filter(|e| !pair.contains(&e.0));
            others.flat_map(|e| e.1.samples()).any(|p| of_pair().all(|course| course.foot(p).1 > reach))
        };
        let may = coincide || !rim.thin && goes_away();
        if !may {
            self.kept.insert(face, tolerance);
        }
        may
    }
}

impl Rim {
    fn new(part: &Part, free: &FreeFaces, face: usize, reach: f64) -> Self {
        let untold = free.get(face).and_then(|f| f.as_ref()?.as_ref().ok());
        let pieces = untold.iter().flat_map(|f| &f.region.loops).flat_map(|l| &l.pieces);
        let of_pieces = pieces.filter_map(|piece| piece.along.edge());
        let mut numbers: Vec<u32> = part.faces[face].wires().flatten().map(|c| c.edge.0).chain(of_pieces).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let course = |number: u32| {
            let edge = part.edges.get(number as usize).filter(|e| is_sound(part, e))?;
            Some((number, CurveQuery::new(edge)))
        };
        let edges: Vec<(u32, CurveQuery)> = numbers.into_iter().filter_map(course).collect();
        // Try the edge that was near the previous point first.
        let mut last = 0;
        let mut near = |k: usize, p| {
            let beside = |j: usize| j != k && edges[j].1.foot(p).1 <= reach;
            if !beside(last) {
                let Some(found) = (0..edges.len()).find(|&j| beside(j)) else { return false };
                last = found;
            }
            true
        };
        let thin = (0..edges.len()).all(|k| edges[k].1.samples().all(|p| near(k, p)));
        Self { edges, thin }
    }
}
