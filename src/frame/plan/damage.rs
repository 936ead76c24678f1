//! Whether a plan that was stored and read is one of a model.

use super::output::{EdgePolyline, PartPlan, Plan, TileLattice};
use crate::model::{PartId, RowId, TileId};
use crate::prepare::internals::{PreparedEdge, PreparedPart, Tile};
use std::sync::Arc;

/// A plan that was changed or damaged after it was made: the first row that cannot be right.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DamagedPlan {
    /// It has no rows of the part, or those of another: it is one of another model, perhaps.
    #[error(
        "the plan is one of another model: part {} has {} tiles and {} edges instead of {} and {}",
        .part.0, .planned[0], .planned[1], .stated[0], .stated[1]
    )]
    Rows {
        /// The part.
        part: PartId,
        /// Its tiles and edges in the plan; 0 of each if there are none.
        planned: [usize; 2],
        /// Its tiles and edges in the model.
        stated: [usize; 2],
    },
    /// The lines of a tile do not increase, or do not begin and end with it.
    #[error(
        "the plan is damaged: of {count} lines of tile {} of part {} in {}, number {line} is at {at}; they increase from {} \
         to {}",
        .tile.0, .part.0, ["u", "v"][usize::from(*.in_v)], .ends[0], .ends[1]
    )]
    Lines {
        /// The part.
        part: PartId,
        /// The tile.
        tile: TileId,
        /// Whether these are v-lines.
        in_v: bool,
        /// Number of lines.
        count: usize,
        /// The first line that is wrong.
        line: usize,
        /// Its parameter; NaN if there is no such line.
        at: f64,
        /// Where the tile begins and ends.
        ends: [f64; 2],
    },
    /// The chord tolerance of a tile is not above 0.
    #[error("the plan is damaged: the chord tolerance of tile {} of part {} is {chord} mm", .tile.0, .part.0)]
    Chord {
        /// The part.
        part: PartId,
        /// The tile.
        tile: TileId,
        /// Its strictest tolerance, millimetres.
        chord: f64,
    },
    /// The tessellants of an edge do not increase, or leave out a break.
    #[error(
        "the plan is damaged: of {count} tessellants of edge {} of part {}, number {tessellant} is at {at}; they increase \
         and have all {breaks} breaks",
        .edge.0, .part.0
    )]
    Tessellants {
        /// The part.
        part: PartId,
        /// The edge's row in the prepared part.
        edge: RowId,
        /// Number of tessellants.
        count: usize,
        /// The first one that is wrong.
        tessellant: usize,
        /// Its parameter; NaN if there is no such tessellant.
        at: f64,
        /// Number of breaks.
        breaks: usize,
    },
}

impl Plan {
    /// Checks that the plan is one of these parts, and the rows of one that the planner did not make. Cost: nothing for
    /// those that it made, else some nanoseconds per line and tessellant.
    pub(crate) fn check(&self, parts: &[Arc<PreparedPart>]) -> Result<(), DamagedPlan> {
        let bare = PartPlan::default();
        for (row, part) in parts.iter().enumerate() {
            let (id, plan) = (PartId::new(row), self.parts.get(row).unwrap_or(&bare));
            let planned = [plan.tiles.len(), plan.edges.len()];
            let stated = [part.tiles.len(), part.edges.len()];
            if planned != stated {
                return Err(DamagedPlan::Rows { part: id, planned, stated });
            }
            if !self.made.0 {
                let tiles = (0..).zip(plan.tiles.iter().zip(&part.tiles));
                tiles.into_iter().try_for_each(|(k, (lattice, tile))| check_tile((id, TileId(k)), lattice, tile))?;
                let edges = (0..).zip(plan.edges.iter().zip(&part.edges));
                edges.into_iter().try_for_each(|(k, (line, edge))| check_edge((id, RowId(k)), line, edge))?;
            }
        }
        Ok(())
    }
}

/// The first row that is not after the one before. NaN is after nothing.
fn unordered(rows: &[f64]) -> Option<usize> {
    let is_after = |k: &usize| if *k == 0 { !rows[0].is_nan() } else { rows[*k] > rows[k - 1] };
    (0..rows.len()).find(|k| !is_after(k))
}

fn check_tile((part, tile): (PartId, TileId), lattice: &TileLattice, of: &Tile) -> Result<(), DamagedPlan> {
    for (in_v, lines) in [(false, &lattice.us[..]), (true, &lattice.vs[..])] {
        let ends = [of.min, of.max].map(|end| end[usize::from(in_v)]);
        let count = lines.len();
        let wrong_end = || match (lines.first(), lines.last()) {
            (Some(&first), _) if first != ends[0] => Some(0),
            (_, Some(&last)) if last == ends[1] && count > 1 => None,
            _ => Some(count.saturating_sub(1)),
        };
        if let Some(line) = unordered(lines).or_else(wrong_end) {
            let at = lines.get(line).copied().unwrap_or(f64::NAN);
            return Err(DamagedPlan::Lines { part, tile, in_v, count, line, at, ends });
        }
    }
    let chord = lattice.chord;
    // NaN is not above 0.
    if chord > 0.0 { Ok(()) } else { Err(DamagedPlan::Chord { part, tile, chord }) }
}

fn check_edge((part, edge): (PartId, RowId), line: &EdgePolyline, of: &PreparedEdge) -> Result<(), DamagedPlan> {
    let EdgePolyline { ts, breaks } = line;
    let stated = if of.uses.is_empty() { &[][..] } else { &of.breaks[..] };
    let is_at = |(k, end): (&u32, f64)| ts.get(*k as usize) == Some(&end);
    let wrong_break = || {
        let wrong = breaks.iter().zip(stated).find(|(k, end)| !is_at((k, end.t))).map(|(k, _)| *k as usize);
        let inner = || match (breaks.first(), breaks.last()) {
            _ if breaks.len() != stated.len() => Some(ts.len()),
            (Some(0), Some(last)) if *last as usize + 1 == ts.len() => None,
            (None, None) if ts.is_empty() => None,
            _ => Some(0),
        };
        wrong.or_else(inner)
    };
    let Some(tessellant) = unordered(ts).or_else(wrong_break) else { return Ok(()) };
    let (at, count) = (ts.get(tessellant).copied().unwrap_or(f64::NAN), ts.len());
    Err(DamagedPlan::Tessellants { part, edge, count, tessellant, at, breaks: stated.len() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::plan::make::plan;
    use crate::frame::tolerance::Tolerance;
    use crate::model::shapes;
    use crate::prepare::{PrepareOptions, prepare};

    #[test]
    fn a_changed_row_is_found_unless_the_planner_made_the_plan() {
        let prepared = prepare(shapes::all(), &PrepareOptions::DEFAULT).expect("within the limits");
        let mut plan = plan(&prepared, &Tolerance { chord: 0.01, angle: 0.5, max_edge: None });
        let part = plan.parts.iter().position(|part| part.tiles[0].us.len() > 2).expect("lines");
        let id = PartId::new(part);
        let changed = |change: fn(&mut PartPlan)| {
            let mut changed = plan.clone();
            change(&mut changed.parts[part]);
            assert_eq!(changed.check(&prepared.parts), Ok(()), "it says that the planner made it");
            changed.made.0 = false;
            changed.check(&prepared.parts)
        };
        fn tile(part: &mut PartPlan) -> &mut TileLattice {
            Arc::make_mut(&mut part.tiles[0])
        }
        fn edge(part: &mut PartPlan) -> &mut EdgePolyline {
            let used = part.edges.iter().position(|edge| !edge.ts.is_empty()).expect("an edge");
            Arc::make_mut(&mut part.edges[used])
        }
        let lines: [fn(&mut PartPlan); 5] = [
            |part| tile(part).us[1] = f64::NAN,
            |part| tile(part).us.swap(0, 1),
            |part| tile(part).us[0] -= 1.0,
            |part| _ = tile(part).us.pop(),
            |part| tile(part).us.clear(),
        ];
        for change in lines {
            let told = changed(change);
            assert!(matches!(told, Err(DamagedPlan::Lines { part, in_v: false, .. }) if part == id), "{told:?}");
        }
        assert!(matches!(changed(|part| tile(part).chord = -1.0), Err(DamagedPlan::Chord { chord: -1.0, .. })));
        let tessellants: [fn(&mut PartPlan); 6] = [
            |part| edge(part).ts[0] = f64::NAN,
            |part| edge(part).ts[0] -= 1.0,
            |part| edge(part).ts.clear(),
            |part| edge(part).ts.push(1e9),
            |part| edge(part).breaks[0] = 1_000_000,
            |part| _ = edge(part).breaks.pop(),
        ];
        for change in tessellants {
            let told = changed(change);
            assert!(matches!(told, Err(DamagedPlan::Tessellants { part, .. }) if part == id), "{told:?}");
        }
        plan.made.0 = false;
        assert_eq!(plan.check(&prepared.parts), Ok(()));
    }
}
