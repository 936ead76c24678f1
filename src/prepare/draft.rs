//! What a face comes to by itself, before its borders and breaks are numbered in the part.

use super::chains::Chain;
use super::mend::Tangle;
use super::{BezierPatches, BezierSpline3, SurfaceBounds, UvCurve};
use crate::model::AxisMap;
use glam::{DVec2, DVec3};

/// A stretch of a tile's loop before breaks are numbered.
#[derive(Clone, Debug)]
pub(super) struct DraftUse {
    /// What it runs along.
    pub(super) along: DraftAlong,
    /// Parameters where it starts and ends, in loop direction.
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) uv: UvCurve,
}

/// What a stretch runs along.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DraftAlong {
    /// B-rep edge of the part.
    Edge(u32),
    /// Border of the face.
    Border(u32),
}

/// A border of a face before it is numbered in the part.
#[derive(Clone, Debug)]
pub(super) struct DraftBorder {
    pub(super) shape: DraftShape,
    pub(super) range: (f64, f64),
    pub(super) ends: [DraftEnd; 2],
    /// Parameters inside the range where the surface, and so the border, has a crease.
    pub(super) creases: Vec<f64>,
}

/// What a border's points are.
#[derive(Clone, Debug)]
pub(super) enum DraftShape {
    /// A curve in space.
    Curve(BezierSpline3),
    /// One point.
    Pole(DraftEnd),
}

/// Where a border ends.
#[derive(Clone, Copy, Debug)]
pub(super) enum DraftEnd {
    /// At a point of the face's own.
    Point(DVec3),
    /// On a B-rep edge, at the break nearest to the parameter.
    OnEdge(u32, f64),
}

/// A tile in patch parameters.
#[derive(Clone, Debug)]
pub(super) struct DraftTile {
    pub(super) min: DVec2,
    pub(super) max: DVec2,
    pub(super) loops: Vec<Vec<DraftUse>>,
    /// See [`Tile::entangled`](super::Tile::entangled).
    pub(super) entangled: bool,
}

/// A face on its own.
#[derive(Clone, Debug)]
pub(super) struct FaceDraft {
    pub(super) patches: BezierPatches,
    pub(super) bounds: SurfaceBounds,
    pub(super) maps: [AxisMap; 2],
    pub(super) creases: [Vec<f64>; 2],
    pub(super) gap: f64,
    /// How many critical parameters and meetings there are among `breaks`.
    pub(super) critical: u32,
    pub(super) meetings: u32,
    pub(super) tiles: Vec<DraftTile>,
    pub(super) borders: Vec<DraftBorder>,
    /// What its loops use of the part's edges, as its tiles have them.
    pub(super) chain: Chain,
    /// Parameters of B-rep edges where tile borders cross them, and critical ones.
    pub(super) breaks: Vec<(u32, f64)>,
    /// Those of them at which two edges meet within the face, and the point that both have there.
    pub(super) joints: Vec<(u32, f64, DVec3)>,
    /// What there is to tell, though the face is usable.
    pub(super) notes: Vec<String>,
    /// What had to be repaired: the face is not as stated.
    pub(super) repairs: Vec<Told>,
    /// Whether one of these is that the boundary crosses or overlaps itself.
    pub(super) crosses: bool,
    /// Whether it is filled in space: the surface is a plane that the file does not state.
    pub(super) filled: bool,
    /// Edges of loops of which lobes were turned, ascending: they have no other face.
    pub(super) lobed: Vec<u32>,
    /// Whether it ends where its surface does, because no loop bounds it there.
    pub(super) ends_with_surface: bool,
    /// Where edges meet within the face, other than at common ends.
    pub(super) tangles: Vec<Tangle>,
}

/// Something told of a face, and where.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Told {
    pub(super) place: Option<DVec3>,
    pub(super) what: String,
}
