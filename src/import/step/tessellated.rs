//! Tessellated solids, shells and faces of AP242 -> planar triangles that share their edges.
//!
//! Every triangle becomes a planar face, because a model has only surfaces and edges. Triangles with common corners
//! share edges, so that the mesh is as closed as the file's, at any tolerance. Corners with equal coordinates are
//! merged, since each tessellated face may list its own.

use super::csg::facet;
use super::kinds::{HOLDERS, TRIANGULATED, is_shapeless};
use super::place::Geometry;
use super::table::{Entity, Fields, Read, Trouble, check_depth, missing};
use super::values::{Attribute, Map, Set};
use crate::math::bits;
use crate::model::{Part, PartBuilder, PartError, ShellKind, SolidTrouble, StepTrouble, VertexId};
use glam::{DAffine3, DVec3};
use std::collections::hash_map::Entry;

/// Something left out of a body: why, and a point of it, if readable.
pub(super) type Loss = (Trouble, Option<DVec3>);

/// Makes a part of a body's triangles. Also returns what was left out.
pub(super) fn triangles(geometry: &Geometry<'_>, item: Entity<'_>) -> Read<(Part, Vec<Loss>)> {
    let mut mesh = Mesh::default();
    mesh.holder(geometry, item, &DAffine3::IDENTITY, 0)?;
    if mesh.triangles.is_empty() {
        let first = mesh.lost.into_iter().next();
        let part = if mesh.splits > 0 { "triangles that have an area" } else { "triangles" };
        let none = || Trouble::new(item.id, missing(item.keyword(), part));
        return Err(first.map_or_else(none, |(trouble, _)| trouble));
    }
    let kind = if item.is("TESSELLATED_SOLID") { ShellKind::Outer } else { ShellKind::Open };
    let lost = std::mem::take(&mut mesh.lost);
    let part = mesh.part(kind).map_err(|error| Trouble::new(item.id, error))?;
    Ok((part, lost))
}

/// Maximum number of splits of sides at collinear corners.
const MAX_SPLITS: usize = 1_000_000;

/// Memory of a triangle, bytes: its corners here, and a face with its edges in the model.
const BYTES_PER_TRIANGLE: usize = 1600;

/// A triangle lower than this share of its longest side has collinear corners.
const FLAT: f64 = 1e-9;

#[derive(Default)]
struct Mesh {
    points: Vec<DVec3>,
    /// Corners, and the number of the face that lists them.
    triangles: Vec<([usize; 3], u64)>,
    corners: Map<[u64; 3], usize>,
    /// Coordinate lists by number; faces share them.
    lists: Map<u64, Vec<DVec3>>,
    /// The corner that splits the side between two corners.
    between: Map<[usize; 2], usize>,
    /// Number of steps taken to split sides.
    splits: usize,
    /// Items already added, each with the place that it has in the body.
    added: Set<(u64, [u64; 12])>,
    /// Items and triangles added so far.
    visits: usize,
    lost: Vec<Loss>,
}

impl Mesh {
    /// Adds the faces of a holder, or a single face.
    fn holder(&mut self, geometry: &Geometry<'_>, item: Entity<'_>, place: &DAffine3, depth: usize) -> Read<()> {
        check_depth(depth, item.id, "tessellated items")?;
        // An item is one item however often lists name it at the same place.
        if !self.added.insert((item.id, place.to_cols_array().map(f64::to_bits))) {
            return Ok(());
        }
        self.visit(1, geometry, item)?;
        if !item.is("REPOSITIONED_TESSELLATED_ITEM") {
            return self.held(geometry, item, place, depth);
        }
        let location = item.fields("REPOSITIONED_TESSELLATED_ITEM", 1).reference(0)?;
        let place = *place * geometry.motion(location)?;
        // A repositioned list has other coordinates: cache it separately.
        let outer = std::mem::take(&mut self.lists);
        let read = self.held(geometry, item, &place, depth);
        self.lists = outer;
        read
    }

    /// Adds what a holder lists, or the triangles of a single face.
    fn held(&mut self, geometry: &Geometry<'_>, item: Entity<'_>, place: &DAffine3, depth: usize) -> Read<()> {
        let Some(name) = item.first_of(HOLDERS) else { return self.face(geometry, item, place) };
        for id in item.fields(name, 1).links(0)? {
            let read = geometry.get(id).and_then(|face| {
                if face.is_any(TRIANGULATED) || face.is_any(HOLDERS) {
                    self.holder(geometry, face, place, depth + 1)
                } else if is_shapeless(face) {
                    // Holders may list curves and points, too.
                    Ok(())
                } else {
                    Err(face.not_read("tessellated faces"))
                }
            });
            if let Err(trouble) = read {
                self.lost.push((trouble, None));
            }
            if self.visits > geometry.table.budget.max_visits() {
                break;
            }
        }
        Ok(())
    }

    /// Counts `more` visits for `item`.
    fn visit(&mut self, more: usize, geometry: &Geometry<'_>, item: Entity<'_>) -> Read<()> {
        let limit = geometry.table.budget.max_visits();
        self.visits = self.visits.saturating_add(more);
        if self.visits > limit {
            return Err(Trouble::new(item.id, StepTrouble::TooManyVisits { what: "tessellated items", limit }));
        }
        Ok(())
    }

    fn face(&mut self, geometry: &Geometry<'_>, face: Entity<'_>, place: &DAffine3) -> Read<()> {
        let set = face.is_any(["TRIANGULATED_SURFACE_SET", "COMPLEX_TRIANGULATED_SURFACE_SET"]);
        let (base, inherited) = if set { ("TESSELLATED_SURFACE_SET", 4) } else { ("TESSELLATED_FACE", 5) };
        let list = face.fields(base, 1).reference(0)?;
        if let Entry::Vacant(fresh) = self.lists.entry(list) {
            fresh.insert(coordinates(geometry, list, place)?);
        }
        let name = face.first_of(TRIANGULATED).unwrap_or_default();
        let own = face.fields(name, inherited);
        // Corners are indices into the face's list of points, or into the coordinates if it has none.
        let used = own.counts(0)?;
        // Rows that are not triangles become empty ones, which are counted below.
        let mut corners: Vec<[usize; 3]> = Vec::new();
        if name.starts_with("COMPLEX") {
            for strip in lists_of(own, 1, face.id)? {
                for (k, w) in strip.windows(3).enumerate() {
                    corners.push(if k % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] });
                }
            }
            for fan in lists_of(own, 2, face.id)? {
                corners.extend(fan.windows(2).skip(1).map(|w| [fan[0], w[0], w[1]]));
            }
        } else {
            let rows = lists_of(own, 1, face.id)?;
            corners.extend(rows.iter().map(|row| <[usize; 3]>::try_from(row.as_slice()).unwrap_or_default()));
        }
        self.visit(corners.len(), geometry, face)?;
        if !geometry.table.budget.spend(corners.len().saturating_mul(BYTES_PER_TRIANGLE)) {
            // The whole result will be discarded.
            return Ok(());
        }
        let points = self.lists.get(&list).map(Vec::as_slice).unwrap_or_default();
        let corner = |index: usize| -> Option<DVec3> {
            let index = if used.is_empty() { index } else { *used.get(index.checked_sub(1)?)? };
            points.get(index.checked_sub(1)?).copied()
        };
        let (mut good, mut bad, mut at) = (Vec::with_capacity(corners.len()), 0, None);
        for triangle in corners {
            match triangle.map(corner) {
                [Some(a), Some(b), Some(c)] => good.push([a, b, c]),
                some => {
                    bad += 1;
                    at = at.or(some.into_iter().flatten().next());
                }
            }
        }
        if bad > 0 {
            self.lost.push((Trouble::new(face.id, SolidTrouble::Triangles { count: bad }), at));
        }
        good.into_iter().for_each(|triangle| self.triangle(triangle, face.id));
        Ok(())
    }

    /// Adds a triangle of a face. Skips triangles with coincident corners. A triangle with collinear corners is
    /// skipped, too, but splits the longest side for its neighbour, which would otherwise have a T-junction.
    fn triangle(&mut self, corners: [DVec3; 3], face: u64) {
        let ids = corners.map(|corner| self.corner(corner));
        if ids[0] == ids[1] || ids[1] == ids[2] || ids[2] == ids[0] {
            return;
        }
        let [a, b, c] = corners;
        let sides = [b.distance(c), c.distance(a), a.distance(b)];
        let (apex, longest) =
            sides.into_iter().enumerate().fold((0, 0.0), |m, (k, s)| if s > m.1 { (k, s) } else { m });
        if (b - a).cross(c - a).length() > FLAT * longest * longest {
            self.triangles.push((ids, face));
            return;
        }
        self.split(ids[(apex + 1) % 3], ids[(apex + 2) % 3], ids[apex]);
    }

    /// Inserts corner `m` into the side from `p` to `q`, ordered with the corners already there.
    fn split(&mut self, p: usize, q: usize, m: usize) {
        let mut open = vec![(p, q, m)];
        // Corners at equal distances may split each other's sides in turn.
        let most = MAX_SPLITS.min(self.splits + 2 * self.points.len());
        while let Some((p, q, m)) = open.pop().filter(|_| self.splits < most) {
            self.splits += 1;
            if m == p || m == q {
                continue;
            }
            match self.between.entry([p.min(q), p.max(q)]) {
                Entry::Vacant(fresh) => drop(fresh.insert(m)),
                Entry::Occupied(known) => {
                    let other = *known.get();
                    let from = self.points[p];
                    let first = from.distance(self.points[m]) < from.distance(self.points[other]);
                    let (near, far) = if first { (m, other) } else { (other, m) };
                    if near != far {
                        // The side up to the farther corner contains the nearer one, and the side from the nearer one
                        // the farther.
                        open.extend([(near, q, far), (p, far, near)]);
                    }
                }
            }
        }
    }

    fn corner(&mut self, corner: DVec3) -> usize {
        *self.corners.entry(bits::of_point(corner)).or_insert_with(|| {
            self.points.push(corner);
            self.points.len() - 1
        })
    }

    /// Appends all corners on the side from `p` to `q`, without `q`. Ends even if corners at equal distances split each
    /// other's sides: no side has more corners than there are.
    fn side(&self, p: usize, q: usize, out: &mut Vec<usize>) {
        let (mut open, most) = (vec![(p, q)], out.len() + self.points.len());
        while let Some((p, q)) = open.pop() {
            match self.between.get(&[p.min(q), p.max(q)]) {
                Some(&m) if open.len() + out.len() < most => open.extend([(m, q), (p, m)]),
                _ => out.push(p),
            }
        }
    }

    fn part(self, kind: ShellKind) -> Result<Part, PartError> {
        let mut part = PartBuilder::new(String::new());
        part.plain_shell(kind);
        let vertices: Vec<VertexId> = self.points.iter().map(|p| part.vertex(*p)).collect();
        let (mut edges, mut chain, mut entities) = (Map::default(), Vec::new(), Vec::new());
        for ([a, b, c], entity) in &self.triangles {
            let corners = [*a, *b, *c].map(|k| self.points[k]);
            chain.clear();
            [[a, b], [b, c], [c, a]].into_iter().for_each(|[from, to]| self.side(*from, *to, &mut chain));
            facet(&mut part, &mut edges, &vertices, corners, &chain);
            // Without a face for a degenerate triangle.
            entities.resize(part.part().faces.len(), *entity);
        }
        let mut part = part.finish()?;
        part.faces.iter_mut().zip(entities).for_each(|(face, entity)| face.entity = entity);
        Ok(part)
    }
}

/// The points of a `COORDINATES_LIST`, in millimetres, moved by `place`.
fn coordinates(geometry: &Geometry<'_>, id: u64, place: &DAffine3) -> Read<Vec<DVec3>> {
    let rows = geometry.get(id)?.fields("COORDINATES_LIST", 2).rows(0, "coordinates", "lists")?;
    rows.map(|row| Ok(place.transform_point3(geometry.millimetres(geometry.triple(row?, id)?, id)?))).collect()
}

/// A list of lists of whole numbers.
fn lists_of(own: Fields<'_>, index: usize, id: u64) -> Read<Vec<Vec<usize>>> {
    let numbers = |row: Attribute<'_>| -> Option<Vec<usize>> { row.list()?.iter().map(Attribute::whole).collect() };
    let rows: Option<Vec<_>> = own.list(index)?.iter().map(numbers).collect();
    rows.ok_or_else(|| Trouble::new(id, StepTrouble::Layout { what: "triangles", wanted: "lists of whole numbers" }))
}
