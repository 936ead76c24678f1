//! Loops that run counter-clockwise in (u,v) to faces that all look outwards.
//!
//! Neighbours that run along their common edge in opposite directions are turned alike; that fixes connected groups up
//! to one sign. For groups that bound a solid the volume decides it, for others the file's word.

use super::UvCurve;
use super::face::{DraftAlong, DraftTile, FaceDraft};
use super::region::winding_about;
use crate::model::{Part, ShellKind};
use glam::{DVec2, DVec3};

/// A group of faces that was turned over against the file's word.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turned {
    /// One of its faces.
    pub(super) face: usize,
    /// How many faces it has.
    pub(super) faces: usize,
    /// Its volume as stated, mm³, with the sign that was wrong.
    pub(super) volume: f64,
}

/// For each face whether its outward normal is opposite to `S_u × S_v`.
///
/// Loops run counter-clockwise in (u,v) by now, so two faces are turned the same way exactly when they run along their
/// common edge in opposite directions once turned.
pub(super) fn orient(part: &Part, drafts: &[Option<FaceDraft>], told: &mut Vec<Turned>) -> Vec<bool> {
    let mut reversed: Vec<bool> = part.faces.iter().map(|f| f.reversed).collect();
    let mut uses: Vec<Vec<(usize, bool)>> = vec![Vec::new(); part.edges.len()];
    for (k, draft) in drafts.iter().enumerate() {
        let Some(draft) = draft else { continue };
        // Each direction once, however many pieces the edge was cut into.
        for u in draft.tiles.iter().flat_map(|t| &t.loops).flatten() {
            if let DraftAlong::Edge(e) = u.along {
                let entry = (k, u.from < u.to);
                if !uses[e as usize].contains(&entry) {
                    uses[e as usize].push(entry);
                }
            }
        }
    }
    // (neighbour, whether both must be turned alike)
    let mut neighbours: Vec<Vec<(usize, bool)>> = vec![Vec::new(); part.faces.len()];
    for pair in &uses {
        if let [(a, forward_a), (b, forward_b)] = pair[..]
            && a != b
            && part.faces[a].shell == part.faces[b].shell
        {
            neighbours[a].push((b, forward_a != forward_b));
            neighbours[b].push((a, forward_a != forward_b));
        }
    }
    let mut whole: Vec<bool> = drafts.iter().map(Option::is_some).collect();
    for pair in &uses {
        if let [(only, _)] = pair[..] {
            whole[only] = false;
        }
    }
    let mut seen = vec![false; part.faces.len()];
    for start in 0..part.faces.len() {
        if seen[start] {
            continue;
        }
        seen[start] = true;
        let mut group = vec![(start, reversed[start])];
        let mut next = 0;
        while next < group.len() {
            let (face, turned) = group[next];
            next += 1;
            for &(other, alike) in &neighbours[face] {
                if !seen[other] {
                    seen[other] = true;
                    group.push((other, turned == alike));
                }
            }
        }
        let disagree = group.iter().filter(|(face, turned)| *turned != part.faces[*face].reversed).count();
        let flip = 2 * disagree > group.len();
        for (face, turned) in &group {
            reversed[*face] = *turned != flip;
        }
        let wanted = match part.shells.get(part.faces[start].shell as usize).map(|s| s.kind) {
            Some(ShellKind::Outer) => 1.0,
            Some(ShellKind::Void) => -1.0,
            _ => continue,
        };
        // Only a group without free edges has a volume.
        let closed = group.iter().all(|(face, _)| whole[*face]);
        if closed && let Some(volume) = wrong_volume(drafts, &group, &reversed, wanted) {
            told.push(Turned { face: start, faces: group.len(), volume });
            for (face, _) in &group {
                reversed[*face] = !reversed[*face];
            }
        }
    }
    reversed
}

/// Share of what the faces contribute, sign apart, that a volume must have for its sign to be believed. Samples are good
/// to a few per cent of that; a thin shell is the small difference of two large contributions, and keeps the file's word.
const DECISIVE: f64 = 0.3;

/// The volume of a closed group if its sign is not `wanted`.
///
/// First the volume of the cone over each boundary, which costs next to nothing and has the right sign for all but
/// strongly curved shapes; where it does not confirm the sign, the surfaces themselves are summed up.
fn wrong_volume(drafts: &[Option<FaceDraft>], group: &[(usize, bool)], reversed: &[bool], wanted: f64) -> Option<f64> {
    let faces = || group.iter().filter_map(|(face, _)| Some((drafts[*face].as_ref()?, reversed[*face])));
    let sign = |reversed: bool| if reversed { -1.0 } else { 1.0 };
    let polygons: Vec<(Vec<DVec3>, f64)> = faces()
        .flat_map(|(draft, reversed)| draft.tiles.iter().flat_map(|t| &t.loops).map(move |l| (draft, l, reversed)))
        .map(|(draft, l, reversed)| (space_polygon(draft, l, 8), sign(reversed)))
        .collect();
    let points = || polygons.iter().flat_map(|p| &p.0);
    let origin = points().sum::<DVec3>() / points().count().max(1) as f64;
    let (mut cones, mut parts) = (0.0, 0.0);
    for (polygon, sign) in &polygons {
        let first = polygon[0] - origin;
        let fan = |w: &[DVec3]| first.dot((w[0] - origin).cross(w[1] - origin)) / 6.0;
        let cone: f64 = polygon.windows(2).map(fan).sum();
        cones += sign * cone;
        parts += cone.abs();
    }
    if cones * wanted > DECISIVE * parts {
        return None;
    }
    let (volume, parts) = faces().fold((0.0, 0.0), |(volume, parts), (draft, reversed)| {
        let v = sign(reversed) * flux(draft, origin) / 3.0;
        (volume + v, parts + v.abs())
    });
    (volume * wanted < -DECISIVE * parts).then_some(volume)
}

/// Points along a loop, on the surface.
fn space_polygon(draft: &FaceDraft, uses: &[super::face::DraftUse], most: usize) -> Vec<DVec3> {
    plane_polygon(uses, most).into_iter().map(|p| draft.patches.derivatives(p.x, p.y).point).collect()
}

/// Points along a loop in (u,v), at most `most` per use; one per straight use.
fn plane_polygon(uses: &[super::face::DraftUse], most: usize) -> Vec<DVec2> {
    let mut out = Vec::new();
    for u in uses {
        let n = match &u.uv {
            UvCurve::Hermite(samples) => (samples.len() - 1).min(most),
            UvCurve::Iso { .. } => most.min(4),
        };
        let mut hint = 0;
        out.extend((0..n).map(|k| u.uv.point(u.from + (u.to - u.from) * k as f64 / n as f64, &mut hint)));
    }
    out
}

/// The integral of (x - origin)·n over a face, by samples: good to a few per cent, which is enough for a sign.
fn flux(draft: &FaceDraft, origin: DVec3) -> f64 {
    draft.tiles.iter().map(|tile| tile_flux(draft, tile, origin)).sum()
}

fn tile_flux(draft: &FaceDraft, tile: &DraftTile, origin: DVec3) -> f64 {
    /// Samples per Bézier piece and direction.
    const SAMPLES: usize = 8;
    let polygons: Vec<Vec<DVec2>> = tile.loops.iter().map(|l| plane_polygon(l, usize::MAX)).collect();
    let count = |breaks: &[f64], a: f64, b: f64| {
        SAMPLES * breaks.windows(2).filter(|w| w[1] > a && w[0] < b).count().clamp(1, 16)
    };
    let patches = &draft.patches;
    let (nu, nv) = (count(&patches.breaks_u, tile.min.x, tile.max.x), count(&patches.breaks_v, tile.min.y, tile.max.y));
    let step = (tile.max - tile.min) / DVec2::new(nu as f64, nv as f64);
    let mut sum = 0.0;
    for i in 0..nu {
        for j in 0..nv {
            let uv = tile.min + step * DVec2::new(i as f64 + 0.5, j as f64 + 0.5);
            if polygons.iter().map(|p| winding_about(p, uv)).sum::<i32>() > 0 {
                let d = patches.derivatives(uv.x, uv.y);
                sum += (d.point - origin).dot(d.du.cross(d.dv)) * step.x * step.y;
            }
        }
    }
    sum
}
