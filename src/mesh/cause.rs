//! Unbalanced mesh edges -> their cause: a free edge of the file, a non-orientable edge, or a defect of the mesh.

use super::{EdgeLine, ScenePart};
use crate::math::{Seeded, bits};
use crate::model::EdgeId;
use glam::DVec3;
use std::collections::HashMap;

/// Why the directed uses of a mesh edge do not cancel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Cause {
    /// A crack in the mesh: the file's shell continues here.
    Defect,
    /// On an edge whose faces cannot be oriented consistently ([`ScenePart::not_orientable`]).
    NotOrientable(EdgeId),
    /// On a free edge of the file, where a sheet ends ([`ScenePart::free_edges`]).
    FreeEdge(EdgeId),
}

/// Segments of a part's free and non-orientable edges, keyed by the bits of their ends. They need not be balanced.
///
/// Taken from the edges' polylines, not from vertex origins: a vertex at a corner names only one of its edges.
#[derive(Default)]
pub(super) struct ExpectedUnbalanced(HashMap<[[u64; 3]; 2], Cause, Seeded>);

impl ExpectedUnbalanced {
    /// `lines` are the part's edge lines, ascending by edge. An edge without a line excuses nothing.
    pub(super) fn of(part: &ScenePart, lines: &[EdgeLine]) -> Self {
        let mut segments = HashMap::default();
        let free = part.free_edges.iter().map(|&edge| Cause::FreeEdge(edge));
        for cause in free.chain(part.not_orientable.iter().map(|&edge| Cause::NotOrientable(edge))) {
            let (Cause::FreeEdge(edge) | Cause::NotOrientable(edge)) = cause else { continue };
            let Ok(line) = lines.binary_search_by_key(&edge, |line| line.edge) else { continue };
            let mut points: Vec<_> = lines[line].points.iter().map(|&point| bits::of_point(point)).collect();
            points.dedup();
            segments.extend(points.windows(2).map(|ends| (sorted([ends[0], ends[1]]), cause)));
        }
        Self(segments)
    }

    pub(super) fn cause(&self, from: DVec3, to: DVec3) -> Cause {
        if self.0.is_empty() {
            return Cause::Defect;
        }
        self.0.get(&sorted([bits::of_point(from), bits::of_point(to)])).copied().unwrap_or(Cause::Defect)
    }
}

fn sorted(mut ends: [[u64; 3]; 2]) -> [[u64; 3]; 2] {
    ends.sort_unstable();
    ends
}
