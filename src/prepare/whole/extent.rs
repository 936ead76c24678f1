//! Prepared parts and instances -> the placed model's box, from points of the trimmed surfaces, not control points.

use crate::control::Call;
use crate::math::boxes::around;
use crate::math::lanes::widest;
use crate::mesh::SceneInstance;
use crate::prepare::join::prepared::{EdgeShape, EdgeUse, PreparedEdge, PreparedFace, PreparedPart, Tile};
use crate::prepare::surface::tables::BoxBounds;
use crate::prepare::uv::polygon::{TileRegion, points_along};
use glam::{DVec2, DVec3, DVec4};
use std::cell::LazyCell;
use std::sync::Arc;

/// An edge has as many samples per border of its strips, evenly spaced.
const SAMPLES: usize = 4;

/// A tile has as many samples per Bézier piece and direction: on a quarter turn they find its extreme point to 0.1 % of
/// the radius. At least the first, for pieces that are small.
const OF_PIECE: [usize; 2] = [2, 16];

/// Edges or faces that a thread takes at a time: about a microsecond each.
const SHARE: usize = 64;

/// Centre and half diagonal of the box of a part's [`cloud`]; `None` if that is empty.
pub(crate) fn centre(cloud: &[DVec3]) -> Option<(DVec3, f64)> {
    let low = cloud.iter().copied().reduce(DVec3::min)?;
    let high = cloud.iter().copied().reduce(DVec3::max)?;
    Some((0.5 * (low + high), 0.5 * (high - low).length()))
}

/// Corners of all instances' box, by each part's [`cloud`]. Accurate to about 0.1 %. `None` for an empty model.
pub(crate) fn placed_box(parts: &[Arc<PreparedPart>], instances: &[SceneInstance]) -> Option<[DVec3; 2]> {
    let boxes: Vec<[DVec3; 2]> = parts.iter().map(|part| around(part.facts.cloud.iter().copied())).collect();
    let [mut low, mut high] = around([]);
    for SceneInstance { part, transform, .. } in instances {
        // Most instances lie within the box of those before.
        let corner = |k: usize| DVec3::from_array([0, 1, 2].map(|axis| boxes[part.index()][k >> axis & 1][axis]));
        let mut corners = (0..8).map(|k| transform.transform_point3(corner(k)));
        if !corners.all(|p| p.cmpge(low).all() && p.cmple(high).all()) {
            let placed = around(parts[part.index()].facts.cloud.iter().map(|p| transform.transform_point3(*p)));
            (low, high) = (low.min(placed[0]), high.max(placed[1]));
        }
    }
    (high - low).is_finite().then_some([low, high])
}

/// Axes, face diagonals and corner diagonals of a cube: instances may be rotated, so the axes alone do not suffice. By
/// coordinate; filled up with directions that are there already.
const DIRECTIONS: [[f64; 16]; 3] = [
    [1.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0, -1.0, 1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, -1.0, 1.0, 0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, 1.0, 0.0, 0.0, 1.0],
];

/// Coordinates of a point along [`DIRECTIONS`].
#[inline(always)]
fn along(p: DVec3) -> [f64; 16] {
    std::array::from_fn(|k| DIRECTIONS[0][k] * p.x + DIRECTIONS[1][k] * p.y + DIRECTIONS[2][k] * p.z)
}

/// Extents of a set of points along [`DIRECTIONS`]: a discrete oriented polytope.
struct Hull {
    low: [f64; 16],
    high: [f64; 16],
}

impl Hull {
    fn of(call: Call<'_>, points: &[DVec3]) -> Self {
        /// Points that a thread takes at a time: a few microseconds.
        const POINTS: usize = 512;
        let nothing = || Self { low: [f64::INFINITY; 16], high: [f64::NEG_INFINITY; 16] };
        let pieces = call.each(1, points.chunks(POINTS), |some| {
            let mut hull = nothing();
            widest(
                #[inline(always)]
                || some.iter().for_each(|p| hull.add(*p)),
            );
            hull
        });
        let mut hull = nothing();
        pieces.iter().for_each(|Self { low, high }| hull.extend(low, high));
        hull
    }

    #[inline(always)]
    fn add(&mut self, p: DVec3) {
        let along = along(p);
        self.extend(&along, &along);
    }

    /// Widens it to these extents.
    #[inline(always)]
    fn extend(&mut self, low: &[f64; 16], high: &[f64; 16]) {
        self.low = std::array::from_fn(|k| if low[k] < self.low[k] { low[k] } else { self.low[k] });
        self.high = std::array::from_fn(|k| if high[k] > self.high[k] { high[k] } else { self.high[k] });
    }

    /// The longest side of the box; negative for no points.
    fn size(&self) -> f64 {
        (0..3).map(|k| self.high[k] - self.low[k]).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Whether it holds all the points, up to rounding.
    fn holds(&self, points: impl IntoIterator<Item = DVec3>) -> bool {
        let slack = 1e-9 * self.size();
        widest(
            #[inline(always)]
            || {
                let (low, high) = (self.low.map(|x| x - slack), self.high.map(|x| x + slack));
                points.into_iter().all(|p| {
                    let along = along(p);
                    (0..16).fold(true, |all, k| all & (low[k] <= along[k]) & (along[k] <= high[k]))
                })
            },
        )
    }
}

/// Points of a part's edges and trimmed surfaces that span its box.
pub(crate) fn cloud(call: Call<'_>, part: &PreparedPart) -> Vec<DVec3> {
    let used = part.edges.iter().filter(|e| !e.uses.is_empty());
    let mut out = call.each(SHARE, used, points_of).concat();
    let mut bounds = Hull::of(call, &out);
    let faces = part.tiles.chunk_by(|a, b| a.face == b.face).map(|tiles| (part.face_of(&tiles[0]), tiles));
    // Most faces are within the hull of the edges, and no face leaves it once it is wider.
    let beyond = call.each(SHARE, faces, |(face, tiles)| {
        // A straight line has its extremes at its ends, which lie on edges.
        let straight = |second: fn(&BoxBounds) -> f64| face.bounds.cells.iter().all(|b| second(b) == 0.0);
        let reaches = || face.patches.nets().any(|net| reaches(net, &bounds));
        (!straight(|b| b.uu.norm) && !straight(|b| b.vv.norm) && reaches()).then_some((face, tiles))
    });
    for (face, tiles) in beyond.into_iter().flatten() {
        let reaching: Vec<bool> = face.patches.nets().map(|net| reaches(net, &bounds)).collect();
        if reaching.contains(&true) {
            let cells = per_piece(face, &reaching, &bounds);
            tiles.iter().for_each(|tile| out.extend(interior(part, (face, tile), &reaching, cells, &mut bounds)));
        }
    }
    out
}

/// Breaks of an edge, and points between them if it bends.
fn points_of(edge: &PreparedEdge) -> Vec<DVec3> {
    let breaks = edge.breaks.iter().map(|b| b.point);
    let (EdgeShape::Curve(curve), false) = (&edge.shape, edge.straight) else { return breaks.collect() };
    let (a, b) = curve.range();
    let n = SAMPLES * edge.bounds.breaks.len();
    let ts: Vec<f64> = (1..n).map(|k| a + (b - a) * k as f64 / n as f64).collect();
    let mut out = Vec::with_capacity(edge.breaks.len() + ts.len());
    out.extend(breaks);
    widest(
        #[inline(always)]
        || curve.points(&ts, &mut out),
    );
    out
}

/// Whether a piece with this control net may extend a hull: the net reaches beyond it.
fn reaches(net: &[DVec4], bounds: &Hull) -> bool {
    !bounds.holds(net.iter().map(|c| c.truncate() / c.w))
}

/// Samples per piece and direction that find the extreme points of a face to the same share of the hull as [`OF_PIECE`]
/// where pieces are as large as it is: the height of a piece between samples grows with its size and falls with the
/// square of their number.
fn per_piece(face: &PreparedFace, reaching: &[bool], bounds: &Hull) -> usize {
    let size_of = |net: &[DVec4]| {
        let [low, high] = around(net.iter().map(|c| c.truncate() / c.w));
        (high - low).max_element()
    };
    let nets = face.patches.nets().zip(reaching).filter(|(_, reaches)| **reaches);
    let largest = nets.map(|(net, _)| size_of(net)).fold(0.0, f64::max);
    let share = largest / bounds.size().max(largest);
    let [least, most] = OF_PIECE;
    ((most as f64 * share.sqrt()).ceil() as usize).clamp(least, most)
}

/// Samples inside a tile's loops and outside `bounds`, which they widen, `per_piece` in each direction. Skips pieces
/// that are not `reaching`, and lines of samples that `bounds` hold.
fn interior(
    part: &PreparedPart,
    (face, tile): (&PreparedFace, &Tile),
    reaching: &[bool],
    per_piece: usize,
    bounds: &mut Hull,
) -> Vec<DVec3> {
    let region = |loops| TileRegion { patches: &face.patches, min: tile.min, max: tile.max, loops };
    // Most tiles have no sample outside the hull.
    let inside = LazyCell::new(|| region(tile.loops.iter().map(|l| polygon(part, l)).collect()));
    let mut out = Vec::new();
    // The line of the last sample, by its piece and parameter, and whether the hull holds its control points. To find
    // out costs as much as a point or two.
    let (mut line, mut is_held) = ((usize::MAX, f64::NAN), false);
    for uv in region(Vec::new()).lattice(per_piece).1 {
        let piece = face.patches.piece(uv.x, uv.y);
        if !reaching[piece] {
            continue;
        }
        if line != (piece, uv.x) {
            (line, is_held) = ((piece, uv.x), bounds.holds(face.patches.line_at(uv.x, piece)));
        }
        if is_held {
            continue;
        }
        let p = face.patches.point(uv.x, uv.y);
        if !bounds.holds([p]) && inside.winding(uv) != 0 {
            bounds.add(p);
            out.push(p);
        }
    }
    out
}

/// A loop as a polygon through points of its pcurves.
fn polygon(part: &PreparedPart, uses: &[EdgeUse]) -> Vec<DVec2> {
    let mut out = Vec::new();
    for u in uses {
        let breaks = &part.edges[u.edge.index()].breaks;
        let range = (breaks[u.from as usize].t, breaks[u.to as usize].t);
        points_along(&u.uv, range, usize::MAX, true, &mut out);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::{Alone, Control, Jobs, Threads};
    use crate::model::shapes;
    use crate::prepare::{PrepareOptions, prepare};

    #[test]
    fn boxes_reach_what_bulges_between_the_corners() {
        // Half the diagonal of the box.
        for (name, half) in [("sphere", 5.0 * 3.0_f64.sqrt()), ("torus", 251.0_f64.sqrt())] {
            let model = shapes::by_name(name).expect("a shape");
            let prepared = prepare(model, &PrepareOptions::DEFAULT).expect("within the limits");
            let control = Control::default();
            let (_, radius) = centre(&cloud(Call::new(&Alone, &control), &prepared.parts[0])).expect("points");
            assert!((radius / half - 1.0).abs() < 2e-3, "{name}: {radius} instead of {half}");
        }
    }

    #[test]
    fn hulls_of_pieces_hold_all_points_and_no_more() {
        let points: Vec<DVec3> = (0..2000).map(|k| DVec3::new(1.0, 0.3, -0.7) * f64::from(k)).collect();
        let control = Control::default();
        for jobs in [&Alone as &dyn Jobs, &Threads::start(3).expect("threads")] {
            let call = Call::new(jobs, &control);
            let hull = Hull::of(call, &points);
            assert!(hull.holds(points.iter().copied()));
            assert!(!hull.holds([DVec3::new(1999.1, 599.7, -1399.3)]) && !hull.holds([DVec3::NEG_X]));
            assert_eq!(hull.size(), 1999.0);
            assert_eq!(Hull::of(call, &[]).size(), f64::NEG_INFINITY);
        }
    }

    #[test]
    fn lobes_of_negative_winding_belong_to_the_box() {
        let model = shapes::by_name("sphere").expect("a shape");
        let prepared = prepare(model, &PrepareOptions::DEFAULT).expect("within the limits");
        let mut reversed = PreparedPart::clone(&prepared.parts[0]);
        for l in reversed.tiles.iter_mut().flat_map(|tile| &mut tile.loops) {
            l.reverse();
            l.iter_mut().for_each(|u| std::mem::swap(&mut u.from, &mut u.to));
        }
        let control = Control::default();
        let cloud = |part: &PreparedPart| cloud(Call::new(&Alone, &control), part);
        let radius = |part: &PreparedPart| centre(&cloud(part)).map(|(_, radius)| radius);
        assert_eq!(radius(&reversed), radius(&prepared.parts[0]));
    }
}
