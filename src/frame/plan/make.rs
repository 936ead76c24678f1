//! The tolerance of each part -> a plan within limits.

use super::budget::{Budget, cells};
use super::lattice::{DensityMet, LatticeRequest, Lattices, places};
use super::limits::{PlanLimits, Shortfall};
use super::output::{EdgePolyline, PartPlan, Plan, TileLattice};
use super::tessellants::{Tessellants, bare};
use crate::control::{Alone, Jobs, map};
use crate::frame::tolerance::box_tolerance::{BoxTolerances, PartTolerance};
use crate::frame::tolerance::object_tolerance::Tolerance;
use crate::mesh::{DrawnTiles, ScenePart};
use crate::model::{PartId, RowId, TileId};
use crate::prepare::Prepared;
use crate::prepare::internals::PreparedPart;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Plans lattice lines and tessellants for a tolerance in the placed model, within [`PlanLimits::DEFAULT`].
///
/// A part is planned for the largest scale of its instances, so that its triangles meet the tolerance in all of them.
/// There are at most 4096 lines between two creases of a tile, and 4096 segments between two breaks of an edge. If the
/// tolerance requires more, or has unusable values (see [`Tolerance`]), the plan is coarser and reports it in
/// [`Plan::shortfall`]; [`Plan::require_full`] turns that into an error.
///
/// Cost: about 1 µs per tile and per edge.
#[must_use]
pub fn plan(prepared: &Prepared, tolerance: &Tolerance) -> Plan {
    plan_within(prepared, tolerance, &PlanLimits::DEFAULT)
}

/// As [`plan`], within the limits of the caller.
#[must_use]
pub fn plan_within(prepared: &Prepared, tolerance: &Tolerance, limits: &PlanLimits) -> Plan {
    plan_on(&Alone, prepared, tolerance, limits)
}

/// As [`plan_within`], on the threads of `jobs`. The plan does not depend on their number.
#[must_use]
pub fn plan_on(jobs: &dyn Jobs, prepared: &Prepared, tolerance: &Tolerance, limits: &PlanLimits) -> Plan {
    let scales = prepared.scene.largest_scales();
    let of_part =
        |(part, &scale): (&ScenePart, &f64)| PartTolerance::everywhere(&tolerance.within_part(scale), part.radius);
    let asked: Vec<PartTolerance> = prepared.scene.parts.iter().zip(&scales).map(of_part).collect();
    let held_mib = u32::try_from(prepared.memory().total().div_ceil(1 << 20)).unwrap_or(u32::MAX);
    plan_parts(jobs, prepared, asked, limits, held_mib)
}

/// Plans all parts, each for its own tolerance in part coordinates.
///
/// If the whole does not fit the limits, all densities are lowered by the same factor: no face is favoured. `held_mib`:
/// memory of the prepared model that counts towards the limits, MiB.
pub(crate) fn plan_parts(
    jobs: &dyn Jobs,
    prepared: &Prepared,
    asked: Vec<PartTolerance>,
    limits: &PlanLimits,
    held_mib: u32,
) -> Plan {
    /// Factor on all densities per round. It about halves the number of cells.
    const LOWER: f64 = 0.75;
    /// Rounds until every tile has one cell and no plan is smaller: a factor of 1e-12.
    const LOWEST: i32 = 96;
    let mut shortfall = Shortfall { held_mib, ..Shortfall::none(limits) };
    // A part without tiles meets any tolerance.
    let unusable = |(part, asked): (&Arc<PreparedPart>, &PartTolerance)| asked.unusable && !part.tiles.is_empty();
    shortfall.unusable = prepared.parts.iter().zip(&asked).any(unusable);
    let wanted = Arc::new(Wanted { parts: prepared.parts.clone(), asked });
    let mut round = 0;
    loop {
        shortfall.density = LOWER.powi(round);
        let mut budget = Budget::of(limits, held_mib);
        if round == LOWEST {
            budget.left = u64::MAX;
        }
        let asked =
            PlanRequest { jobs, wanted: &wanted, density: shortfall.density, cells_per_tile: budget.cells_per_tile };
        if let Some(parts) = asked.plan(0..prepared.parts.len(), &mut budget, &mut shortfall) {
            return Plan { parts, drawn: DrawnTiles::default(), shortfall: shortfall.if_any() };
        }
        if round == 0 {
            shortfall.needed = asked.triangles();
        }
        round += 1;
    }
}

/// Parts, and the tolerance of each.
struct Wanted {
    parts: Vec<Arc<PreparedPart>>,
    asked: Vec<PartTolerance>,
}

/// What to plan, and where.
#[derive(Clone, Copy)]
struct PlanRequest<'a> {
    jobs: &'a dyn Jobs,
    wanted: &'a Arc<Wanted>,
    density: f64,
    cells_per_tile: u64,
}

/// Fewest tiles or edges that are planned at a time.
const CHUNK: usize = 64;

impl PlanRequest<'_> {
    /// Upper bound on the triangles, each tile within its limit.
    fn triangles(&self) -> u64 {
        let mut budget = Budget { left: u64::MAX, cells_per_tile: self.cells_per_tile };
        for part in 0..self.wanted.parts.len() {
            // Keeps the plan of one part at a time in memory. The budget does not run out.
            let _ = self.plan(part..part + 1, &mut budget, &mut Shortfall::none(&PlanLimits::DEFAULT));
        }
        2 * (u64::MAX - budget.left)
    }

    /// Plans some parts; `None` if the budget does not suffice.
    fn plan(&self, parts: Range<usize>, budget: &mut Budget, shortfall: &mut Shortfall) -> Option<Vec<PartPlan>> {
        let Self { jobs, wanted, density, cells_per_tile } = *self;
        let (spent, wanted) = (SharedBudget { cells: AtomicU64::new(0), left: budget.left }, Arc::clone(wanted));
        let round = Arc::new(Round { wanted, density, cells_per_tile, spent });
        let counts =
            |of: fn(&PreparedPart) -> usize| parts.clone().map(|k| (k, of(&self.wanted.parts[k]))).collect::<Vec<_>>();
        let (tiles, edges) = (counts(|part| part.tiles.len()), counts(|part| part.edges.len()));

        let step = tracing::trace_span!("lattices").entered();
        let shared = Arc::clone(&round);
        let made = map(jobs, stretches(jobs, &tiles), move |rows| shared.lattices(rows));
        (shortfall.tiles, shortfall.lines, shortfall.edges) = Default::default();
        let mut lattices: Vec<_> = tiles.iter().map(|(_, count)| Vec::with_capacity(*count)).collect();
        for made in made {
            for Planned { part, rows, short } in made? {
                for (tile, kept) in short {
                    let id = (PartId::new(part), TileId(tile as u32));
                    shortfall.tiles.extend((!kept.cells).then_some(id));
                    shortfall.lines.extend((!kept.lines).then_some(id));
                }
                lattices[part - parts.start].extend(rows);
            }
        }
        drop(step);

        let _step = tracing::trace_span!("tessellants").entered();
        let (shared, first, lattices) = (Arc::clone(&round), parts.start, Arc::new(lattices));
        let beside = Arc::clone(&lattices);
        let made = map(jobs, stretches(jobs, &edges), move |rows| shared.polylines(rows, |part| &beside[part - first]));
        let lattices = Arc::into_inner(lattices)?.into_iter();
        let plan =
            |(tiles, (_, count)): (Vec<_>, &(usize, usize))| PartPlan { tiles, edges: Vec::with_capacity(*count) };
        let mut plans: Vec<PartPlan> = lattices.zip(&edges).map(plan).collect();
        for made in made {
            for Planned { part, rows, short } in made? {
                shortfall.edges.extend(short.iter().map(|(edge, ())| (PartId::new(part), RowId(*edge as u32))));
                plans[part - first].edges.extend(rows);
            }
        }
        budget.spend(round.spent.cells.load(Ordering::Relaxed))?;
        Some(plans)
    }
}

/// What the jobs of a plan share.
struct Round {
    wanted: Arc<Wanted>,
    density: f64,
    cells_per_tile: u64,
    spent: SharedBudget,
}

/// A part, and some of its tiles or edges.
type Stretch = (usize, Range<usize>);

/// The tiles or edges of parts, in lists that become shorter, down to [`CHUNK`]: few lists, and threads that end at about
/// the same time. All in one list if there is one thread.
fn stretches(jobs: &dyn Jobs, counts: &[(usize, usize)]) -> Vec<Vec<Stretch>> {
    /// Part of a thread's share of what is left that the next list is.
    const SHARE: usize = 4;
    let size = |left: usize| if jobs.width() == 1 { usize::MAX } else { CHUNK.max(left / (SHARE * jobs.width())) };
    let mut left = counts.iter().map(|(_, count)| count).sum();
    let (mut lists, mut list, mut room) = (Vec::new(), Vec::new(), size(left));
    for &(part, count) in counts {
        let mut from = 0;
        while from < count {
            let to = count.min(from.saturating_add(room));
            list.push((part, from..to));
            (room, left) = (room - (to - from), left - (to - from));
            from = to;
            if room == 0 {
                lists.push(std::mem::take(&mut list));
                room = size(left);
            }
        }
    }
    lists.extend((!list.is_empty()).then_some(list));
    lists
}

/// A plan for a stretch.
struct Planned<T, K> {
    part: usize,
    rows: Vec<Arc<T>>,
    /// The rows that limits made coarser than asked.
    short: Vec<(usize, K)>,
}

impl Round {
    /// The lattices of some tiles.
    fn lattices(&self, stretches: Vec<Stretch>) -> Option<Vec<Planned<TileLattice, DensityMet>>> {
        let (mut need, mut lattices) = (BoxTolerances::default(), Lattices::default());
        let of_stretch = |(part, range): Stretch| {
            let mut planned = Planned { part, rows: Vec::with_capacity(range.len()), short: Vec::new() };
            let (asked, part) = (&self.wanted.asked[part], &self.wanted.parts[part]);
            for row in range {
                let tile = &part.tiles[row];
                let face = &part.faces[part.face_of(tile)];
                asked.over(places(face, tile), &mut need);
                let (factor, most_cells) = (self.density, self.cells_per_tile);
                let request = LatticeRequest { face, tile, need: &need, factor, most_cells, before: None };
                let (lattice, kept) = lattices.lattice(&request);
                self.spent.add(cells(&lattice))?;
                planned.rows.push(Arc::new(lattice));
                planned.short.extend((!kept.cells || !kept.lines).then_some((row, kept)));
            }
            Some(planned)
        };
        stretches.into_iter().map(of_stretch).collect()
    }

    /// The tessellants of some edges, beside the lattices of their parts.
    fn polylines<'a>(
        &self,
        stretches: Vec<Stretch>,
        lattices: impl Fn(usize) -> &'a [Arc<TileLattice>],
    ) -> Option<Vec<Planned<EdgePolyline, ()>>> {
        let (mut need, mut tessellants) = (BoxTolerances::default(), Tessellants::default());
        let mut of_stretch = |(part, range): Stretch| {
            let mut planned = Planned { part, rows: Vec::with_capacity(range.len()), short: Vec::new() };
            let (asked, tiles) = (&self.wanted.asked[part], lattices(part));
            for row in range {
                let edge = &self.wanted.parts[part].edges[row];
                let bare = if asked.limits_length() { None } else { bare(edge, tiles) };
                let (line, kept) = bare.map(|line| (line, true)).unwrap_or_else(|| {
                    asked.over(edge.bounds.places.iter(), &mut need);
                    tessellants.polyline(edge, tiles, &need, self.density, None)
                });
                self.spent.add(line.ts.len() as u64)?;
                planned.rows.push(Arc::new(line));
                planned.short.extend((!kept).then_some((row, ())));
            }
            Some(planned)
        };
        stretches.into_iter().map(&mut of_stretch).collect()
    }
}

/// Cells and tessellants planned so far by all threads, and how many there may be.
struct SharedBudget {
    cells: AtomicU64,
    left: u64,
}

impl SharedBudget {
    /// `None` once there are too many. The sum decides, so it does not matter who notices.
    fn add(&self, cells: u64) -> Option<()> {
        let before = self.cells.fetch_add(cells, Ordering::Relaxed);
        (before.checked_add(cells)? <= self.left).then_some(())
    }
}
