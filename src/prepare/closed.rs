//! A part and what was made of it -> what its scene says of its edges. A stand-in by parity, until the shells say it.

use super::free_edges::FreeFaces;
use super::prepared::{EdgeShape, PreparedEdge, PreparedPart};
use super::shells::{Shells, uses};
use crate::mesh::ScenePart;
use crate::model::{EdgeId, Part};
use std::collections::HashSet;

/// Free are edges that tiles use an odd number of times, but for those that the file uses evenly: a face beside them is lost.
pub(super) fn state(out: &mut ScenePart, stated: &Part, made: &PreparedPart) {
    let even: HashSet<u32> = {
        let uses = uses(stated, &FreeFaces::new());
        uses.into_iter().filter(|edge| edge.count % 2 == 0).map(|edge| edge.edge).collect()
    };
    let edges = made.edges.iter().take(made.brep_edges).enumerate();
    let odd: Vec<usize> = edges.filter(|(_, edge)| is_odd(made, edge)).map(|(number, _)| number).collect();
    out.closed = Shells::of(stated).open == 0 || odd.is_empty();
    let free = odd.into_iter().filter(|&edge| !out.closed && !even.contains(&(edge as u32)));
    out.free_edges = free.map(EdgeId::new).collect();
}

/// Whether tiles use some stretch of an edge an odd number of times.
fn is_odd(part: &PreparedPart, edge: &PreparedEdge) -> bool {
    let mut odd = vec![false; edge.breaks.len().saturating_sub(1)];
    for &(tile, l, u) in &edge.uses {
        let used = &part.tiles[tile.0 as usize].loops[l as usize][u as usize];
        let (from, to) = (used.from.min(used.to), used.from.max(used.to));
        odd[from as usize..to as usize].iter_mut().for_each(|odd| *odd = !*odd);
    }
    matches!(edge.shape, EdgeShape::Curve(_)) && odd.contains(&true)
}
