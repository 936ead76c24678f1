//! Items of a representation to shells: lists of faces with the way each is used.

use super::gathered::{BodyUse, Gathered, ShellUse, Source};
use super::kinds::{
    BodyKind, has_parts, is_body, is_bounded, is_endless, is_face, is_shapeless, is_shell, is_solid, is_surface,
    parts_of, profile, refused, stands_for,
};
use super::style::Styles;
use super::table::{Entity, MAX_DEPTH, Read, Set, Table, Trouble};
use super::units::Units;
use crate::model::{Colour, ShellKind, StepTrouble};
use std::collections::BTreeMap;

/// Gathers shells and remembers what is taken, so that leftovers can be found.
pub(super) struct Gather<'a> {
    pub(super) table: &'a Table,
    pub(super) styles: &'a Styles,
    /// Items, shells and faces that some part has taken, of the whole file.
    pub(super) taken: Set<u64>,
    /// Items that annotations draw: texts and arrows, not shapes.
    pub(super) annotations: Set<u64>,
    /// Representation items that hold geometry of a kind that is not read.
    pub(super) unread: Vec<(Trouble, Units)>,
    /// The representation whose items are being gathered, 0 for none.
    pub(super) within: u64,
    /// Whether supplemental geometry is asked for.
    supplemental: bool,
    /// Items that are no part of a shape, by representation and number: of what type.
    pub(super) aside: BTreeMap<u64, BTreeMap<u64, String>>,
}

/// What annotations draw.
fn annotated(table: &Table) -> Set<u64> {
    let occurrences = table.of_types(|i| i.types().any(|name| name.ends_with("ANNOTATION_OCCURRENCE")));
    occurrences.filter_map(|i| i.fields("STYLED_ITEM", 1).optional(1)).collect()
}

impl<'a> Gather<'a> {
    pub(super) fn new(table: &'a Table, styles: &'a Styles, supplemental: bool) -> Self {
        let (taken, unread, aside) = Default::default();
        Self { table, styles, taken, annotations: annotated(table), unread, within: 0, supplemental, aside }
    }

    /// Counts an item as no part of the shape.
    pub(super) fn put_aside(&mut self, item: u64) {
        let keyword = self.table.find(item).map_or_else(|| "missing".to_owned(), |item| item.keyword());
        self.aside.entry(self.within).or_default().insert(item, keyword);
    }

    /// Marks the items of a representation as taken without reading them, with all that they hold, and counts them.
    pub(super) fn leave_out(&mut self, representation: u64, items: impl Iterator<Item = u64>) {
        let mut withheld = Gathered::default();
        let (told, aside) = (self.unread.len(), std::mem::take(&mut self.aside));
        let items: Vec<u64> = items.collect();
        items.iter().for_each(|item| self.item(*item, Units::DEFAULT, &mut withheld));
        // What these told and counted is of what is not read.
        self.unread.truncate(told);
        self.aside = aside;
        self.within = representation;
        items.into_iter().for_each(|item| self.put_aside(item));
    }

    /// Adds the shells of a representation item.
    pub(super) fn item(&mut self, id: u64, units: Units, into: &mut Gathered) {
        let read = self.table.get(id).and_then(|item| self.try_item(item, units, into));
        if let Err(trouble) = read {
            self.unread.push((trouble, units));
        }
    }

    fn try_item(&mut self, item: Entity<'_>, units: Units, into: &mut Gathered) -> Read<()> {
        let colour = self.styles.of(item.id);
        if item.is("MANIFOLD_SOLID_BREP") || item.is("BREP_WITH_VOIDS") || item.is("FACETED_BREP") {
            if !self.take(item.id, into) {
                return Ok(());
            }
            let outer = item.fields("MANIFOLD_SOLID_BREP", 1).reference(0)?;
            self.shell(outer, ShellKind::Outer, colour, units, into)?;
            if item.is("BREP_WITH_VOIDS") {
                for void in item.fields("BREP_WITH_VOIDS", 2).links(0)? {
                    self.shell(void, ShellKind::Void, colour, units, into)?;
                }
            }
        } else if item.is("SHELL_BASED_SURFACE_MODEL") || item.is("FACE_BASED_SURFACE_MODEL") {
            if !self.take(item.id, into) {
                return Ok(());
            }
            // Both list their shells or face sets behind the name.
            let name = if item.is("SHELL_BASED_SURFACE_MODEL") {
                "SHELL_BASED_SURFACE_MODEL"
            } else {
                "FACE_BASED_SURFACE_MODEL"
            };
            for shell in item.fields(name, 1).links(0)? {
                self.shell(shell, ShellKind::Open, colour, units, into)?;
            }
        } else if is_shell(item) {
            // A shell listed beside the body it bounds is that body's.
            if !into.held.contains(&item.id) {
                self.shell(item.id, ShellKind::Open, colour, units, into)?;
            }
        } else if is_face(item) {
            if self.take(item.id, into) {
                let faces = vec![(Source::Face(item.id), false)];
                into.shells.push(ShellUse { kind: ShellKind::Open, entity: item.id, faces, colour: None, units });
            }
        } else if item.is("GEOMETRIC_SET") {
            self.set(item, colour, units, into)?;
        } else if item.is("CSG_SOLID") {
            // One primitive is a solid; what several make is refused there.
            let root = self.table.get(item.fields("CSG_SOLID", 1).reference(0)?)?;
            if root.is("CSG_SOLID") {
                return Err(Trouble::new(item.id, StepTrouble::RefersToItself { what: "a CSG_SOLID" }));
            }
            if self.take(item.id, into) {
                let known = into.bodies.len();
                self.try_item(root, units, into)?;
                into.bodies[known..].iter_mut().for_each(|body| body.colour = body.colour.or(colour));
            }
        } else if item.is("SOLID_REPLICA") {
            // The product structure places it, like an occurrence of its parent.
            self.taken.insert(item.id);
        } else if let Some(why) = refused(item) {
            self.operands(item, 0);
            let operator = item.fields("BOOLEAN_RESULT", 1).keyword(0).to_owned();
            return Err(Trouble::new(item.id, StepTrouble::BodyNotRead { keyword: item.keyword(), operator, why }));
        } else if let Some(kind) = BodyKind::of(item) {
            if kind == BodyKind::Tessellated && self.annotations.contains(&item.id) {
                self.taken.insert(item.id);
            } else if self.take(item.id, into) {
                // The face that is swept is no face of its own.
                self.taken.extend(profile(item));
                into.bodies.push(BodyUse { kind, entity: item.id, colour, units });
            }
        } else if is_surface(item) {
            // A construction that is asked for is read as far as it has ends; a face tells that it has none.
            if !(is_bounded(item) || self.supplemental && !is_endless(item)) {
                self.put_aside(item.id);
            } else if self.take(item.id, into) {
                let faces = vec![(Source::Surface(item.id), false)];
                into.shells.push(ShellUse { kind: ShellKind::Open, entity: item.id, faces, colour, units });
            }
        } else if !is_shapeless(item) && !self.annotations.contains(&item.id) && self.take(item.id, into) {
            return Err(Trouble::new(item.id, StepTrouble::NotRead { what: "items", keyword: item.keyword() }));
        }
        Ok(())
    }

    /// Marks a body and what it is made of as taken: with the body refused, its operands are no bodies of their own.
    fn operands(&mut self, body: Entity<'_>, depth: usize) {
        if !self.taken.insert(body.id) || depth >= MAX_DEPTH {
            return;
        }
        for operand in parts_of(body) {
            if let Some(operand) = self.table.find(operand) {
                self.operands(operand, depth + 1);
            }
        }
    }

    /// Leaves out tessellated bodies of a part that has exact ones: they repeat those. Says how many.
    pub(super) fn repeated(&self, gathered: &mut Gathered) -> usize {
        let before = gathered.bodies.len();
        let exact = !gathered.shells.is_empty() || gathered.bodies.iter().any(|b| b.kind != BodyKind::Tessellated);
        gathered.bodies.retain(|body| {
            let stands_for = self.table.find(body.entity).and_then(stands_for);
            let linked =
                stands_for.is_some_and(|id| self.taken.contains(&id) || self.table.find(id).is_some_and(is_body));
            body.kind != BodyKind::Tessellated || !(exact || linked)
        });
        before - gathered.bodies.len()
    }

    /// Whether `id` is new to the part; marks it as taken.
    fn take(&mut self, id: u64, into: &mut Gathered) -> bool {
        self.taken.insert(id);
        into.held.insert(id)
    }

    fn shell(
        &mut self,
        id: u64,
        kind: ShellKind,
        colour: Option<Colour>,
        units: Units,
        into: &mut Gathered,
    ) -> Read<()> {
        let (mut shell, mut turned) = (self.table.get(id)?, false);
        let mut colour = self.styles.of(id).or(colour);
        for _ in 0..MAX_DEPTH {
            let oriented = ["ORIENTED_CLOSED_SHELL", "ORIENTED_OPEN_SHELL"].into_iter().find(|name| shell.is(name));
            let Some(oriented) = oriented else { break };
            // name, (the faces, derived), shell, orientation
            let own = shell.fields(oriented, 2);
            turned ^= !own.flag(1, true);
            self.taken.insert(shell.id);
            shell = self.table.get(own.reference(0)?)?;
            colour = self.styles.of(shell.id).or(colour);
        }
        if !is_shell(shell) {
            return Err(Trouble::new(id, StepTrouble::WrongType { keyword: shell.keyword(), wanted: "a shell" }));
        }
        // Two bodies may be bounded by one shell; each gets its faces.
        self.take(shell.id, into);
        let mut faces = Vec::new();
        for face in shell.fields("CONNECTED_FACE_SET", 1).links(0)? {
            // What is no face fails when it is read, and is counted then.
            let (face, over) = self.face(face);
            self.taken.insert(face);
            into.held.insert(face);
            faces.push((Source::Face(face), turned != over));
        }
        into.shells.push(ShellUse { kind, entity: shell.id, faces, colour, units });
        Ok(())
    }

    /// Follows `ORIENTED_FACE`s as far as they lead; whether they turn the face over.
    fn face(&self, id: u64) -> (u64, bool) {
        let (mut at, mut over) = (id, false);
        for _ in 0..MAX_DEPTH {
            let Some(face) = self.table.find(at).filter(|face| face.is("ORIENTED_FACE")) else { break };
            let own = face.fields("ORIENTED_FACE", 2);
            let Ok(next) = own.reference(0) else { break };
            over ^= !own.flag(1, true);
            at = next;
        }
        (at, over)
    }

    fn set(&mut self, set: Entity<'_>, colour: Option<Colour>, units: Units, into: &mut Gathered) -> Read<()> {
        let mut faces = Vec::new();
        for element in set.fields("GEOMETRIC_SET", 1).links(0)? {
            match self.table.get(element) {
                Ok(item) if is_endless(item) => self.put_aside(element),
                Ok(item) if is_surface(item) => {
                    if self.take(element, into) {
                        faces.push((Source::Surface(element), false));
                    }
                }
                Ok(item) if is_shapeless(item) => {}
                Ok(item) => {
                    let what = StepTrouble::NotRead { what: "elements of geometric sets", keyword: item.keyword() };
                    self.unread.push((Trouble::new(element, what), units));
                }
                Err(trouble) => self.unread.push((trouble, units)),
            }
        }
        if !faces.is_empty() {
            into.shells.push(ShellUse { kind: ShellKind::Open, entity: set.id, faces, colour, units });
        }
        Ok(())
    }

    /// Bodies, then shells, then faces that nothing has taken.
    pub(super) fn leftovers(&mut self, units: Units) -> Gathered {
        let mut found = Gathered::default();
        let of_kind = |wanted: fn(Entity<'_>) -> bool| self.table.of_types(wanted).map(|i| i.id);
        let is_tessellated = |i: Entity<'_>| BodyKind::of(i) == Some(BodyKind::Tessellated);
        let inner: Set<u64> = self.table.of_types(has_parts).flat_map(parts_of).collect();
        let bodies: Vec<u64> = of_kind(is_solid).filter(|id| !inner.contains(id)).collect();
        let tessellated: Vec<u64> = of_kind(is_tessellated).filter(|id| !inner.contains(id)).collect();
        let shells = of_kind(is_shell);
        let faces = of_kind(is_face);
        for id in bodies.into_iter().chain(shells).chain(faces) {
            if !self.taken.contains(&id) {
                self.item(id, units, &mut found);
            }
        }
        // What no product owns beside exact geometry is a picture of it.
        if self.table.of_types(|i| BodyKind::of(i) != Some(BodyKind::Tessellated) && is_body(i)).next().is_none() {
            for id in tessellated {
                if !self.taken.contains(&id) {
                    self.item(id, units, &mut found);
                }
            }
        }
        found
    }
}
