//! Prepared tiles -> their expected cost: cells and tessellants of a mesh as fine as pictures need, counted without
//! making a plan, times their measured costs (`trimtess bench tile-costs` and docs/benchmarks.md).

use crate::control::Call;
use crate::prepare::join::prepared::{Break, EdgeUse, PreparedEdge, PreparedFace, PreparedPart, Tile};
use crate::prepare::surface::tables::CurveBounds;
use crate::prepare::uv::uv_curve::UvCurve;
use glam::DVec2;
use smallvec::{SmallVec, smallvec};
use std::f64::consts::FRAC_PI_6;

/// Chordal tolerance of the mesh that is counted, as a share of the model's diagonal: of the order of a pixel where the
/// model fills a screen.
const CHORD: f64 = 1e-3;
/// Angle by which normals turn over one of its cells.
const ANGLE: f64 = FRAC_PI_6;
/// Upper limit of lines and segments: more come from noisy bounds.
const MOST_LINES: f64 = 4096.0;

/// Nanoseconds per tile.
const TILE: f64 = 300.0;
/// Nanoseconds per lattice cell.
const CELL: f64 = 55.0;
/// Nanoseconds per tessellant on the boundary.
const TESSELLANT: f64 = 150.0;

/// Edges or tiles that a thread takes at a time: less than a microsecond each.
const SHARE: usize = 256;

/// Sets the weights of a part's tiles. `diagonal` is the model's, in the part's own millimetres.
pub(crate) fn weigh(call: Call<'_>, part: &mut PreparedPart, diagonal: f64) {
    let chord = CHORD * diagonal;
    let of_edge: Vec<Counts> = call.each(SHARE, &part.edges, |edge| segments(edge, chord));
    let of_tile = |tile: &Tile| {
        let lines = lines(part.face_of(tile), tile, chord);
        let along = |u: &EdgeUse| tessellants(u, &part.edges[u.edge.index()], &of_edge[u.edge.index()], tile, lines);
        let tessellants: f64 = tile.loops.iter().flatten().map(along).sum();
        let cells = lines.x * lines.y;
        nanoseconds(cells, tessellants)
    };
    let weights: Vec<f64> = call.each(SHARE, &part.tiles, of_tile);
    part.tiles.iter_mut().zip(weights).for_each(|(tile, weight)| tile.weight = weight);
}

/// Numbers of segments or lines, by stretch or strip: mostly a few.
type Counts = SmallVec<[f64; 4]>;

/// Strips, each with a width.
type Strips = SmallVec<[(usize, f64); 4]>;

/// Expected nanoseconds for a tile with so many lattice cells and boundary tessellants.
pub(crate) fn nanoseconds(cells: f64, tessellants: f64) -> f64 {
    TILE + CELL * cells + TESSELLANT * tessellants
}

/// Equal steps over `width` that keep the deviation of chords within `chord`, given the second derivative's bound.
fn bends(second: f64, width: f64, chord: f64) -> f64 {
    if second > 0.0 { width * (second / (8.0 * chord)).sqrt() } else { 0.0 }
}

/// Strips that overlap a range, each with the width of the overlap. The outer strips extend beyond the table.
fn overlaps(breaks: &[f64], from: f64, to: f64) -> impl Iterator<Item = (usize, f64)> {
    let strips = breaks.len().saturating_sub(1);
    let first = breaks.partition_point(|&x| x <= from).saturating_sub(1).min(strips);
    let wide = move |k: usize| {
        let low = if k == 0 { from } else { breaks[k].max(from) };
        let high = if k + 1 == strips { to } else { breaks[k + 1].min(to) };
        (k, high - low)
    };
    (first..strips).map(wide).take_while(|(_, width)| *width > 0.0)
}

/// Cells in u and in v.
fn lines(face: &PreparedFace, tile: &Tile, chord: f64) -> DVec2 {
    let table = &face.bounds;
    let rows = table.breaks_v.len().saturating_sub(1);
    let (us, vs): (Strips, Strips) = (
        overlaps(&table.breaks_u, tile.min.x, tile.max.x).collect(),
        overlaps(&table.breaks_v, tile.min.y, tile.max.y).collect(),
    );
    let (mut of_u, mut of_v): (Counts, Counts) = (smallvec![0.0; us.len()], smallvec![0.0; vs.len()]);
    for (a, &(i, wide)) in us.iter().enumerate() {
        for (b, &(j, high)) in vs.iter().enumerate() {
            let bounds = &table.cells[i * rows + j];
            // A cell that bends in both directions shares the tolerance between them.
            let both = if bounds.uu.lift > 0.0 && bounds.vv.lift > 0.0 { 0.5 * chord } else { chord };
            of_u[a] = of_u[a].max(bends(bounds.uu.lift, wide, both)).max(bounds.turn_u / ANGLE);
            of_v[b] = of_v[b].max(bends(bounds.vv.lift, high, both)).max(bounds.turn_v / ANGLE);
        }
    }
    let whole = |lines: Counts| lines.into_iter().sum::<f64>().ceil().clamp(1.0, MOST_LINES);
    DVec2::new(whole(of_u), whole(of_v))
}

/// Segments between consecutive breaks of an edge, by the edge's own derivative bounds.
fn segments(edge: &PreparedEdge, chord: f64) -> Counts {
    let CurveBounds { breaks, strips, .. } = &edge.bounds;
    let between = |ends: &[Break]| {
        if edge.straight {
            return 1.0;
        }
        let strip = |(k, width): (usize, f64)| {
            let turn = strips[k].turn / ANGLE * (width / (breaks[k + 1] - breaks[k])).min(1.0);
            bends(strips[k].second, width, chord).max(turn)
        };
        overlaps(breaks, ends[0].t, ends[1].t).map(strip).sum::<f64>().ceil().clamp(1.0, MOST_LINES)
    };
    edge.breaks.windows(2).map(between).collect()
}

/// Tessellants of a stretch: as many as the edge itself needs, but at least one per lattice cell that it crosses.
fn tessellants(u: &EdgeUse, edge: &PreparedEdge, segments: &[f64], tile: &Tile, lines: DVec2) -> f64 {
    let stretch = u.from.min(u.to) as usize..u.from.max(u.to) as usize;
    let own: f64 = segments[stretch.clone()].iter().sum();
    let ends = [edge.breaks[stretch.start].t, edge.breaks[stretch.end].t];
    let way = match &u.uv {
        UvCurve::Iso { axis: 0, .. } => DVec2::Y * (ends[1] - ends[0]),
        UvCurve::Iso { .. } => DVec2::X * (ends[1] - ends[0]),
        UvCurve::Hermite(samples) => {
            // The samples may cover the whole edge.
            let first = samples.partition_point(|s| s.t <= ends[0]).saturating_sub(1);
            let last = samples.partition_point(|s| s.t < ends[1]).min(samples.len() - 1);
            samples[first..=last.max(first)].windows(2).map(|w| (w[1].uv - w[0].uv).abs()).sum()
        }
    };
    let crossed = way / (tile.max - tile.min) * lines;
    own.max(crossed.max_element().min(MOST_LINES))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::shapes;
    use crate::prepare::{PrepareOptions, prepare};
    use glam::{DAffine3, DVec3};

    fn weights(name: &str, scale: f64) -> Vec<f64> {
        let mut model = shapes::by_name(name).unwrap();
        for instance in &mut model.instances {
            instance.transform = DAffine3::from_scale(DVec3::splat(scale)) * instance.transform;
        }
        let prepared = prepare(model, &PrepareOptions::DEFAULT).unwrap();
        prepared.tiles().map(|(_, _, tile)| tile.weight).collect()
    }

    #[test]
    fn weights_are_finite_and_independent_of_scale() {
        for name in shapes::NAMES {
            let (plain, large) = (weights(name, 1.0), weights(name, 1000.0));
            assert!(plain.iter().all(|weight| *weight > TILE && weight.is_finite()), "{name}: {plain:?}");
            for (a, b) in plain.iter().zip(&large) {
                assert!((a / b - 1.0).abs() < 1e-6, "{name}: {a} {b}");
            }
        }
    }

    #[test]
    fn a_square_counts_four_tessellants_and_curves_cost_more() {
        let square = weights("box", 1.0);
        assert_eq!(square, [TILE + CELL + 4.0 * TESSELLANT; 6]);
        assert!(weights("wave", 1.0)[0] > 3.0 * square[0]);
        // So does a round hole in a square.
        assert!(weights("square", 1.0)[0] > 5.0 * square[0]);
    }
}
