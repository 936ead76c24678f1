//! The draft of a face: its own tiles, before its borders and breaks are numbered in the part.

use super::extent::Patched;
use crate::model::FaceTrouble;
use crate::prepare::regions::mend::Tangle;
use crate::prepare::report::finding::Finding;
use crate::prepare::surface::decompose::BezierSpline3;
use crate::prepare::uv::uv_curve::UvCurve;
use crate::prepare::wires::chain::Chain;
use glam::{DVec2, DVec3};

/// A stretch of a tile's loop before breaks are numbered.
#[derive(Clone, Debug)]
pub(crate) struct DraftUse {
    /// What it runs along.
    pub(crate) along: DraftAlong,
    /// Parameters where it starts and ends, in loop direction.
    pub(crate) from: f64,
    pub(crate) to: f64,
    pub(crate) uv: UvCurve,
}

/// What a stretch runs along.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DraftAlong {
    /// B-rep edge of the part.
    Edge(u32),
    /// Border of the face.
    Border(u32),
}

/// A border of a face before it is numbered in the part.
#[derive(Clone, Debug)]
pub(crate) struct DraftBorder {
    pub(crate) shape: DraftShape,
    pub(crate) range: (f64, f64),
    pub(crate) ends: [DraftEnd; 2],
    /// Parameters inside the range where the surface, and so the border, has a crease.
    pub(crate) creases: Vec<f64>,
}

/// Geometry of a border.
#[derive(Clone, Debug)]
pub(crate) enum DraftShape {
    /// A curve in space.
    Curve(BezierSpline3),
    /// One point.
    Pole(DraftEnd),
}

/// Where a border ends.
#[derive(Clone, Copy, Debug)]
pub(crate) enum DraftEnd {
    /// At a point of the face's own.
    Point(DVec3),
    /// On a B-rep edge, at the break nearest to the parameter.
    OnEdge(u32, f64),
}

/// A tile in patch parameters.
#[derive(Clone, Debug)]
pub(crate) struct DraftTile {
    pub(crate) min: DVec2,
    pub(crate) max: DVec2,
    pub(crate) loops: Vec<Vec<DraftUse>>,
    /// See [`Tile::entangled`](crate::prepare::join::prepared::Tile::entangled).
    pub(crate) entangled: bool,
}

/// A face on its own.
#[derive(Clone, Debug)]
pub(crate) struct FaceDraft {
    pub(crate) surface: Patched,
    pub(crate) gap: f64,
    /// Number of critical parameters, and of meetings, among `breaks`.
    pub(crate) critical: u32,
    pub(crate) meetings: u32,
    pub(crate) tiles: Vec<DraftTile>,
    pub(crate) borders: Vec<DraftBorder>,
    /// The chain of its loops on the part's edges, as its tiles use them.
    pub(crate) chain: Chain,
    /// Parameters of B-rep edges where tile borders cross them, and critical ones.
    pub(crate) breaks: Vec<(u32, f64)>,
    /// Those breaks at which two edges meet within the face, and their common point.
    pub(crate) joints: Vec<(u32, f64, DVec3)>,
    /// Remarks on a usable face.
    pub(crate) notes: Vec<FaceTrouble>,
    /// Repairs: with any, the face is not as stated.
    pub(crate) repairs: Vec<Finding>,
    /// Whether a repair reports that the boundary crosses or overlaps itself.
    pub(crate) crosses: bool,
    /// Whether it is filled in space: the surface is a plane that the file does not state.
    pub(crate) filled: bool,
    /// Edges of loops with reversed lobes, ascending. No other face uses them.
    pub(crate) lobed: Vec<u32>,
    /// Whether it ends where its surface does, because no loop bounds it there.
    pub(crate) ends_with_surface: bool,
    /// Places where edges meet within the face, other than at common ends.
    pub(crate) tangles: Vec<Tangle>,
}

impl FaceDraft {
    /// A copy whose edges have other numbers, in the same order, and without tangles, which only drafting reads. `None`
    /// if an edge has no other number.
    pub(crate) fn renumbered(&self, number: impl Fn(u32) -> Option<u32>) -> Option<Self> {
        let mut out = self.clone();
        let mut complete = true;
        let mut renumber = |edge: &mut u32| match number(*edge) {
            Some(other) => *edge = other,
            None => complete = false,
        };
        let Self {
            surface: _,
            gap: _,
            critical: _,
            meetings: _,
            tiles,
            borders,
            chain,
            breaks,
            joints,
            notes: _,
            repairs,
            crosses: _,
            filled: _,
            lobed,
            ends_with_surface: _,
            tangles,
        } = &mut out;
        for used in tiles.iter_mut().flat_map(|tile| &mut tile.loops).flatten() {
            if let DraftAlong::Edge(edge) = &mut used.along {
                renumber(edge);
            }
        }
        for DraftBorder { shape, ends, range: _, creases: _ } in borders {
            let pole = if let DraftShape::Pole(end) = shape { Some(end) } else { None };
            for end in ends.iter_mut().chain(pole) {
                if let DraftEnd::OnEdge(edge, _) = end {
                    renumber(edge);
                }
            }
        }
        chain.iter_mut().for_each(|used| renumber(&mut used.0));
        breaks.iter_mut().for_each(|at| renumber(&mut at.0));
        joints.iter_mut().for_each(|at| renumber(&mut at.0));
        repairs.iter_mut().filter_map(|told| told.edge.as_mut()).for_each(|edge| renumber(&mut edge.0));
        lobed.iter_mut().for_each(&mut renumber);
        tangles.clear();
        complete.then_some(out)
    }
}
