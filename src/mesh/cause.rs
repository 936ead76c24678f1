//! Unbalanced mesh edges -> why they are: the file ends there, faces cannot be oriented alike, or the mesh is at fault.

use super::{EdgeLine, ScenePart};
use crate::math::BitMix;
use crate::model::EdgeId;
use glam::DVec3;
use std::collections::HashMap;
use std::hash::BuildHasherDefault;

/// Why the directed uses of a mesh edge do not cancel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Cause {
    /// The mesh is at fault: the file does not end here.
    Defect,
    /// It lies on an edge whose faces cannot be oriented alike ([`ScenePart::not_orientable`]).
    NotOrientable(EdgeId),
    /// It lies on an edge where a sheet ends in the file ([`ScenePart::free_edges`]).
    FreeEdge(EdgeId),
}

/// A position's bits, -0.0 as 0.0.
pub(super) fn bits(point: DVec3) -> [u64; 3] {
    (point + DVec3::ZERO).to_array().map(f64::to_bits) // -0.0 + 0.0 = 0.0
}

/// The segments of those edges of a part that need not be balanced, by the bits of their ends.
///
/// Taken from the edges' polylines and not from the vertices' origins: a vertex at a corner names only one of its edges.
#[derive(Default)]
pub(super) struct Excused(HashMap<[[u64; 3]; 2], Cause, BuildHasherDefault<BitMix>>);

impl Excused {
    /// `lines` are those of the part, ascending by edge. An edge without a line excuses nothing.
    pub(super) fn of(part: &ScenePart, lines: &[EdgeLine]) -> Self {
        let mut segments = HashMap::default();
        let free = part.free_edges.iter().map(|&edge| Cause::FreeEdge(edge));
        for cause in free.chain(part.not_orientable.iter().map(|&edge| Cause::NotOrientable(edge))) {
            let (Cause::FreeEdge(edge) | Cause::NotOrientable(edge)) = cause else { continue };
            let Ok(line) = lines.binary_search_by_key(&edge, |line| line.edge) else { continue };
            let mut points: Vec<_> = lines[line].points.iter().map(|&point| bits(point)).collect();
            points.dedup();
            segments.extend(points.windows(2).map(|ends| (sorted([ends[0], ends[1]]), cause)));
        }
        Self(segments)
    }

    pub(super) fn cause(&self, from: DVec3, to: DVec3) -> Cause {
        if self.0.is_empty() {
            return Cause::Defect;
        }
        self.0.get(&sorted([bits(from), bits(to)])).copied().unwrap_or(Cause::Defect)
    }
}

fn sorted(mut ends: [[u64; 3]; 2]) -> [[u64; 3]; 2] {
    ends.sort_unstable();
    ends
}
