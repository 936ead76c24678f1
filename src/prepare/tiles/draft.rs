//! The draft of a face: its own tiles, before its borders and breaks are numbered in the part. Tiles and borders of an
//! arrangement, in natural parameters -> the same in the parameters of the patches.

use super::arrangement::{ArrangedTile, Arrangement, Border, GridNode, LoopStretch};
use super::extent::Patched;
use super::grid::{Grid, LineCrossing};
use super::traced::Traced;
use crate::math::solve::bisected;
use crate::model::{AxisMap, FaceTrouble};
use crate::prepare::regions::mend::Tangle;
use crate::prepare::report::Finding;
use crate::prepare::surface::decompose::BezierSpline3;
use crate::prepare::uv::uv_curve::{UvCurve, UvSample};
use crate::prepare::uv::uv_loop::Along;
use crate::prepare::wires::boundary::Chain;
use glam::{DVec2, DVec3};
use std::sync::Arc;

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
    /// The B-rep edges along its tiles, use by use.
    pub(crate) fn edges(&self) -> impl Iterator<Item = u32> {
        let uses = self.tiles.iter().flat_map(|tile| &tile.loops).flatten();
        uses.filter_map(|u| if let DraftAlong::Edge(edge) = u.along { Some(edge) } else { None })
    }

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

/// The tiles of an arrangement. Frees each stretch once it is copied.
pub(super) fn tiles(arranged: Arrangement, maps: &[AxisMap; 2]) -> Vec<DraftTile> {
    let Arrangement { tiles, borders, .. } = arranged;
    let to_patch = |p: DVec2| DVec2::new(maps[0].to_nurbs(p.x), maps[1].to_nurbs(p.y));
    let tile = |t: ArrangedTile| DraftTile {
        min: to_patch(t.min),
        max: to_patch(t.max),
        loops: t.loops.into_iter().map(|l| l.into_iter().map(|s| stretch(&s, &borders, maps)).collect()).collect(),
        entangled: t.layered,
    };
    tiles.into_iter().map(tile).collect()
}

fn stretch(s: &LoopStretch, borders: &[Border], maps: &[AxisMap; 2]) -> DraftUse {
    match s {
        LoopStretch::Edge { edge, from, to, samples } => {
            // The stretch ends exactly on its cuts. Between samples, images in natural and in NURBS parameters differ
            // by their interpolation errors, so a break close to a cut could lie beyond it.
            let (low, high, last) = (from.min(*to), from.max(*to), samples.len() - 1);
            let ends = |k: usize| match k {
                0 if samples[0].t < low => UvSample::at(&samples[0], &samples[1], low),
                _ if k == last && samples[last].t > high => UvSample::at(&samples[last - 1], &samples[last], high),
                _ => samples[k],
            };
            let [map_u, map_v] = maps.map(AxisMap::with_rates);
            let mut all: Vec<UvSample> = Vec::with_capacity(samples.len());
            for next in (0..=last).map(ends) {
                if let Some(before) = all.last().copied() {
                    all.extend(at_parts_of_spans(&before, &next, maps));
                }
                all.push(next);
            }
            let samples: Arc<[UvSample]> = all
                .into_iter()
                .map(|s| {
                    let ((u, rate_u), (v, rate_v)) = (map_u(s.uv.x), map_v(s.uv.y));
                    UvSample { t: s.t, uv: DVec2::new(u, v), d: DVec2::new(s.d.x * rate_u, s.d.y * rate_v) }
                })
                .collect();
            DraftUse { along: DraftAlong::Edge(*edge), from: *from, to: *to, uv: UvCurve::Hermite(samples) }
        }
        LoopStretch::Border { border, reversed, at } => {
            let b = &borders[*border];
            let run = &maps[1 - b.axis];
            let (lo, hi) = (run.to_nurbs(b.range.0), run.to_nurbs(b.range.1));
            let (from, to) = if *reversed { (hi, lo) } else { (lo, hi) };
            let uv = UvCurve::Iso { axis: u8::from(b.axis == 1), at: maps[b.axis].to_nurbs(*at) };
            #[allow(clippy::cast_possible_truncation, reason = "a face has far fewer borders")]
            DraftUse { along: DraftAlong::Border(*border as u32), from, to, uv }
        }
    }
}

/// Samples between two, so that an image that is oblique to the parameter lines is as exact in the parameters of
/// patches: where it crosses an end of the maps' spans, and, if the two are further apart, the quarters of a span. The
/// parameters of a span are no cubic of the angle, and bend where the next one begins. An image along a parameter line
/// stays on it.
fn at_parts_of_spans(a: &UvSample, b: &UvSample, maps: &[AxisMap; 2]) -> Vec<UvSample> {
    /// The longest piece without quarters, radians: a cubic is exact to 5e-5.
    const MOST: f64 = 0.4;
    /// An image that deviates less from a parameter line, as a share of its way, is along it.
    const ALONG: f64 = 1e-6;
    /// Samples nearer to one of the two, as a share of the way, would make a piece without length.
    const NEAR: f64 = 1e-3;
    let way = (b.uv - a.uv).abs();
    if way.min_element() <= ALONG * way.max_element() {
        return Vec::new();
    }
    let mut shares = Vec::new();
    for (axis, map) in maps.iter().enumerate() {
        let (from, to) = (a.uv[axis], b.uv[axis]);
        let parts = if way[axis] <= MOST { 1 } else { 4 };
        let at = |share: f64| UvSample::at(a, b, a.t + share * (b.t - a.t)).uv[axis];
        let crossed = map.parts_of_spans(parts, from.min(to), from.max(to));
        shares.extend(crossed.map(|level| bisected([0.0, 1.0], 30, |share| (at(share) < level) == (from < level))[0]));
    }
    shares.sort_by(f64::total_cmp);
    shares.dedup_by(|next, last| *next - *last < NEAR);
    shares.retain(|share| (NEAR..1.0 - NEAR).contains(share));
    shares.into_iter().map(|share| UvSample::at(a, b, a.t + share * (b.t - a.t))).collect()
}

/// The borders of an arrangement, with their curves on the patches.
pub(super) fn borders(traced: &Traced<'_>, surface: &Patched, grid: &Grid, arranged: &Arrangement) -> Vec<DraftBorder> {
    let Patched { patches, maps, creases, .. } = surface;
    let pole_end = |pole: usize| {
        let point = traced.projector.poles[pole].point;
        // If an edge runs through the pole, all faces use its tessellant there as the pole.
        let passing = traced.passages.iter().find_map(|(&edge, stops)| {
            stops.iter().find(|stop| stop.1 == point).map(|stop| DraftEnd::OnEdge(edge, stop.0))
        });
        passing.unwrap_or(DraftEnd::Point(point))
    };
    let crossed_end = |crossing: usize| {
        let LineCrossing { along, t, .. } = arranged.crossings[crossing];
        match along {
            Along::Edge(edge) => DraftEnd::OnEdge(edge, t),
            Along::Pole(pole) => pole_end(pole),
        }
    };
    let corner_end = |(i, j): (usize, usize)| {
        if let Some(&pole) = arranged.pole_corners.get(&(i, j)) {
            return pole_end(pole);
        }
        if let Some(&crossing) = arranged.crossed_corners.get(&(i, j)) {
            return crossed_end(crossing);
        }
        let (u, v) = (maps[0].to_nurbs(grid.lines[0][i]), maps[1].to_nurbs(grid.lines[1][j]));
        DraftEnd::Point(patches.point(u, v))
    };
    let border = |b: &Border| {
        let run = &maps[1 - b.axis];
        let range = (run.to_nurbs(b.range.0), run.to_nurbs(b.range.1));
        let shape = match b.pole {
            Some(pole) => DraftShape::Pole(pole_end(pole)),
            None => DraftShape::Curve(patches.iso_curve(b.axis, maps[b.axis].to_nurbs(b.at), range)),
        };
        let ends = b.nodes.map(|node| match node {
            GridNode::Pole(pole) => pole_end(pole),
            GridNode::LineCrossing(crossing) => crossed_end(crossing),
            GridNode::Corner(corner) => corner_end(corner),
        });
        let creases = creases[1 - b.axis].iter().copied().filter(|&t| t > range.0 && t < range.1).collect();
        DraftBorder { shape, range, ends, creases }
    };
    arranged.borders.iter().map(border).collect()
}
