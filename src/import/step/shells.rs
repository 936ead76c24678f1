//! Items of representations -> shells (lists of faces and their orientations) and bodies without explicit faces.
//!
//! Faces that belong to no shape may copy a face of a shape, instance by instance: some writers colour a copy of a face
//! instead of the face itself. Only a styled item refers to the copy, and meshed with the rest it would lie on the
//! original.

use super::contents::{BodyUse, PartContents, ShellUse, Source};
use super::kinds::{
    BodyKind, has_parts, is_body, is_bounded, is_endless, is_face, is_shapeless, is_shell, is_solid, is_surface,
    parts_of, profile, refused, shell_model, stands_for,
};
use super::style::Styles;
use super::table::{Entity, MAX_DEPTH, Read, Table, Trouble};
use super::units::Units;
use super::values::{Map, Set};
use crate::model::{Colour, ShellKind, StepTrouble};
use std::collections::BTreeMap;
use std::collections::hash_map::Entry;

/// Faces that belong to no shape and copy faces of shapes.
#[derive(Default)]
pub(super) struct Copies {
    pub(super) faces: Set<u64>,
    /// The first of them in the file.
    pub(super) first: Option<u64>,
    /// Their colours, by the face that they copy.
    pub(super) colours: Map<u64, Colour>,
}

/// Faces of equal content.
#[derive(Default)]
struct Alike {
    /// The colours of those that belong to no shape, in the order of the file.
    colours: Vec<Option<Colour>>,
    /// How many belong to shapes.
    shown: usize,
}

impl Copies {
    /// Those of the faces `left` that copy one of the faces `of` shapes: all types and values are the same, but for
    /// texts and bits. Where several are alike, the first gives its colour to the first, and so on; the last one to the
    /// rest.
    ///
    /// Cost: less than a microsecond and about 60 bytes for each instance that these faces lead to.
    pub(super) fn find(table: &Table, styles: &Styles, left: &[u64], of: impl Iterator<Item = u64>) -> Self {
        let mut contents = Contents { table, known: Map::default(), buffer: Vec::new() };
        let mut groups: Map<Hash, Alike> = Map::default();
        for &face in left.iter().take_while(|_| !table.budget.is_cancelled()) {
            groups.entry(contents.of(face)).or_default().colours.push(styles.of(face));
        }
        let mut found = Self::default();
        for face in of.take_while(|_| !table.budget.is_cancelled()) {
            let Some(alike) = groups.get_mut(&contents.of(face)) else { continue };
            let colour = alike.colours.get(alike.shown).or(alike.colours.last());
            alike.shown += 1;
            if let Some(colour) = colour.copied().flatten() {
                found.colours.entry(face).or_insert(colour);
            }
        }
        let is_copy = |face: &u64| groups.get(&contents.of(*face)).is_some_and(|alike| alike.shown > 0);
        let copies: Vec<u64> = left.iter().copied().filter(is_copy).collect();
        found.first = copies.first().copied();
        found.faces = copies.into_iter().collect();
        found
    }
}

type Hash = [u8; 32];

/// Hashes of instances with all that they refer to. Copies have equal ones, whether or not they share instances.
struct Contents<'a> {
    table: &'a Table,
    known: Map<u64, Hash>,
    buffer: Vec<u8>,
}

impl Contents<'_> {
    fn of(&mut self, id: u64) -> Hash {
        let mut stack = vec![(id, false)];
        while let Some((id, has_parts)) = stack.pop() {
            if has_parts {
                let hash = self.hash(id);
                self.known.insert(id, hash);
            } else if let Entry::Vacant(new) = self.known.entry(id) {
                // What is missing, or refers back to itself, is like nothing else.
                new.insert(*blake3::hash(&id.to_le_bytes()).as_bytes());
                let Some(entity) = self.table.find(id) else { continue };
                stack.push((id, true));
                entity.references(&mut |part| stack.push((part, false)));
            }
        }
        self.known.get(&id).copied().unwrap_or_default()
    }

    /// The hash of an instance, from those of its parts.
    fn hash(&mut self, id: u64) -> Hash {
        let Self { table, known, buffer } = self;
        buffer.clear();
        if let Some(entity) = table.find(id) {
            entity.write_content(buffer, &|part| known.get(&part).copied().unwrap_or_default());
        }
        *blake3::hash(buffer).as_bytes()
    }
}

/// Gathers shells and bodies, and marks what is taken, to find leftovers.
pub(super) struct Gather<'a> {
    pub(super) table: &'a Table,
    pub(super) styles: &'a Styles,
    /// Items, shells and faces in any part of the file.
    pub(super) taken: Set<u64>,
    /// Items of annotations: texts and arrows, not shapes.
    annotations: Set<u64>,
    /// Representation items whose geometry is not read.
    pub(super) unread: Vec<(Trouble, Units)>,
    /// The representation whose items are being gathered; 0 for none.
    pub(super) within: u64,
    /// Whether to read supplemental geometry.
    supplemental: bool,
    /// Items, and faces of shells, gathered so far.
    visits: usize,
    /// The first shell that lists faces again, and how many uses of faces all shells list again.
    pub(super) again: Option<(u64, usize)>,
    /// Faces that belong to no shape and copy faces of shapes.
    pub(super) copies: Copies,
    /// Types of items that do not belong to a shape, by representation and number.
    pub(super) aside: BTreeMap<u64, BTreeMap<u64, String>>,
}

/// Items of annotations.
fn annotated(table: &Table) -> Set<u64> {
    let occurrences = table.of_types(|i| i.types().any(|name| name.ends_with("ANNOTATION_OCCURRENCE")));
    occurrences.filter_map(|i| i.fields("STYLED_ITEM", 1).optional(1)).collect()
}

impl<'a> Gather<'a> {
    pub(super) fn new(table: &'a Table, styles: &'a Styles, supplemental: bool) -> Self {
        let (taken, unread, again, copies, aside) = Default::default();
        let annotations = annotated(table);
        Self { table, styles, taken, annotations, unread, within: 0, supplemental, visits: 0, again, copies, aside }
    }

    /// Counts an item that does not belong to a shape.
    pub(super) fn put_aside(&mut self, item: u64) {
        let keyword = self.table.find(item).map_or_else(|| "missing".to_owned(), |item| item.keyword());
        self.aside.entry(self.within).or_default().insert(item, keyword);
    }

    /// Marks the items of a representation and their contents as taken, without reading them, and counts the items.
    pub(super) fn leave_out(&mut self, representation: u64, items: impl Iterator<Item = u64>) {
        let mut withheld = PartContents::default();
        let (told, again, aside) = (self.unread.len(), self.again, std::mem::take(&mut self.aside));
        let items: Vec<u64> = items.collect();
        items.iter().for_each(|item| self.item(*item, Units::DEFAULT, &mut withheld));
        // Drop what these items reported and counted: they are not read.
        self.unread.truncate(told);
        (self.again, self.aside) = (again, aside);
        self.within = representation;
        items.into_iter().for_each(|item| self.put_aside(item));
    }

    /// Adds the shells of a representation item. Beyond the limit of visits, the first item is reported and no other is
    /// looked at.
    pub(super) fn item(&mut self, id: u64, units: Units, into: &mut PartContents) {
        if self.visits > self.table.budget.max_visits() {
            return;
        }
        let read = self.visit(id, "items").and_then(|()| self.try_item(self.table.get(id)?, units, into));
        if let Err(trouble) = read {
            self.unread.push((trouble, units));
        }
    }

    /// Counts a visit of what instance `id` lists.
    fn visit(&mut self, id: u64, what: &'static str) -> Read<()> {
        self.visits += 1;
        let limit = self.table.budget.max_visits();
        if self.visits > limit { Err(Trouble::new(id, StepTrouble::TooManyVisits { what, limit })) } else { Ok(()) }
    }

    fn try_item(&mut self, item: Entity<'_>, units: Units, into: &mut PartContents) -> Read<()> {
        let colour = self.styles.of(item.id);
        if item.is_any(["MANIFOLD_SOLID_BREP", "BREP_WITH_VOIDS", "FACETED_BREP"]) {
            if !self.take(item.id, into) {
                return Ok(());
            }
            let outer = item.fields("MANIFOLD_SOLID_BREP", 1).reference(0)?;
            let read = self.shell(outer, ShellKind::Outer, colour, units, into);
            self.beside_others(read, units)?;
            if item.is("BREP_WITH_VOIDS") {
                for void in item.fields("BREP_WITH_VOIDS", 2).links(0)? {
                    let read = self.shell(void, ShellKind::Void, colour, units, into);
                    self.beside_others(read, units)?;
                }
            }
        } else if let Some(model) = shell_model(item) {
            if !self.take(item.id, into) {
                return Ok(());
            }
            // Both list their shells or face sets after the name.
            for shell in item.fields(model, 1).links(0)? {
                let read = self.shell(shell, ShellKind::Open, colour, units, into);
                self.beside_others(read, units)?;
            }
        } else if is_shell(item) {
            // A shell that is also listed by itself belongs to the body that it bounds.
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
            // A single primitive is a solid; boolean results are refused below.
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
            // The product structure places it, like an occurrence.
            self.taken.insert(item.id);
        } else if let Some(why) = refused(item) {
            self.operands(item, 0);
            let operator = item.fields("BOOLEAN_RESULT", 1).keyword(0).to_owned();
            return Err(Trouble::new(item.id, StepTrouble::BodyNotRead { keyword: item.keyword(), operator, why }));
        } else if let Some(kind) = BodyKind::of(item) {
            if kind == BodyKind::Tessellated && self.annotations.contains(&item.id) {
                self.taken.insert(item.id);
            } else if self.take(item.id, into) {
                // The swept face is not a face of the part.
                self.taken.extend(profile(item));
                into.bodies.push(BodyUse { kind, entity: item.id, colour, units });
            }
        } else if is_surface(item) {
            // Supplemental surfaces are read if bounded; the face reports a lack of bounds.
            if !(is_bounded(item) || self.supplemental && !is_endless(item)) {
                self.put_aside(item.id);
            } else if self.take(item.id, into) {
                let faces = vec![(Source::Surface(item.id), false)];
                into.shells.push(ShellUse { kind: ShellKind::Open, entity: item.id, faces, colour, units });
            }
        } else if !is_shapeless(item) && !self.annotations.contains(&item.id) && self.take(item.id, into) {
            return Err(item.not_read("items"));
        }
        Ok(())
    }

    /// Marks a refused body and its operands as taken: the operands are not bodies of the part.
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

    /// Removes tessellated bodies that repeat exact ones, and returns their number.
    pub(super) fn repeated(&self, gathered: &mut PartContents) -> usize {
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

    /// Marks `id` as taken. Returns whether it is new to the part.
    fn take(&mut self, id: u64, into: &mut PartContents) -> bool {
        self.taken.insert(id);
        into.held.insert(id)
    }

    /// What becomes of a body with one shell of several. One that cannot be read is reported and costs the others
    /// nothing. Fails at the limit of visits.
    fn beside_others(&mut self, shell: Read<()>, units: Units) -> Read<()> {
        match shell {
            Err(trouble) if self.visits <= self.table.budget.max_visits() => {
                self.unread.push((trouble, units));
                Ok(())
            }
            read => read,
        }
    }

    fn shell(
        &mut self,
        id: u64,
        kind: ShellKind,
        colour: Option<Colour>,
        units: Units,
        into: &mut PartContents,
    ) -> Read<()> {
        let (mut shell, mut turned) = (self.table.get(id)?, false);
        let mut colour = self.styles.of(id).or(colour);
        for _ in 0..MAX_DEPTH {
            let Some(oriented) = shell.first_of(["ORIENTED_CLOSED_SHELL", "ORIENTED_OPEN_SHELL"]) else { break };
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
        // Two bodies may share a shell; each gets its faces. An open shell has nothing new to a part that has it.
        self.take(shell.id, into);
        if let Some(faces) = into.open_shells.get(&(shell.id, turned)) {
            self.visit(id, "shells")?;
            self.again.get_or_insert((shell.id, 0)).1 += faces;
            return Ok(());
        }
        let faces = self.faces(shell, turned, into)?;
        if !faces.is_empty() {
            into.shells.push(ShellUse { kind, entity: shell.id, faces, colour, units });
        }
        Ok(())
    }

    /// The faces of a shell, each once per side, and those of an open shell once per part.
    fn faces(&mut self, shell: Entity<'_>, turned: bool, into: &mut PartContents) -> Read<Vec<(Source, bool)>> {
        // A closed shell would not be closed without a face that it shares.
        let open = !shell.is("CLOSED_SHELL");
        let mut listed = Set::default();
        let (mut faces, mut count) = (Vec::new(), 0);
        for face in shell.fields("CONNECTED_FACE_SET", 1).links(0)? {
            // Anything but a face fails when it is read, and is counted then.
            let (face, over) = self.face(face);
            self.taken.insert(face);
            into.held.insert(face);
            let side = (face, turned != over);
            self.visit(shell.id, "faces of shells")?;
            count += 1;
            if !listed.insert(side) || open && !into.open_sides.insert(side) {
                self.again.get_or_insert((shell.id, 0)).1 += 1;
                continue;
            }
            faces.push((Source::Face(face), side.1));
        }
        if open {
            into.open_shells.insert((shell.id, turned), count);
        }
        Ok(faces)
    }

    /// Follows `ORIENTED_FACE`s to the face. Also returns whether they flip it.
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

    fn set(&mut self, set: Entity<'_>, colour: Option<Colour>, units: Units, into: &mut PartContents) -> Read<()> {
        let mut faces = Vec::new();
        for element in set.fields("GEOMETRIC_SET", 1).links(0)? {
            self.visit(set.id, "elements of geometric sets")?;
            match self.table.get(element) {
                Ok(item) if is_endless(item) => self.put_aside(element),
                Ok(item) if is_surface(item) => {
                    if self.take(element, into) {
                        faces.push((Source::Surface(element), false));
                    }
                }
                Ok(item) if is_shapeless(item) => {}
                Ok(item) => self.unread.push((item.not_read("elements of geometric sets"), units)),
                Err(trouble) => self.unread.push((trouble, units)),
            }
        }
        if !faces.is_empty() {
            into.shells.push(ShellUse { kind: ShellKind::Open, entity: set.id, faces, colour, units });
        }
        Ok(())
    }

    /// Takes all shells, and models of shells, that only list taken faces: files list faces again to annotate them, or
    /// by layer.
    pub(super) fn take_repeats(&mut self) {
        // A model follows from its shells.
        for kind in [is_shell, |item: Entity<'_>| shell_model(item).is_some()] {
            for item in self.table.of_types(kind) {
                self.take_if_repeated(item.id);
            }
        }
    }

    /// Whether an item is taken, or is a shell or a model of shells that only lists taken faces. Takes it then. Counts
    /// the faces of shells that were not taken before.
    pub(super) fn take_if_repeated(&mut self, id: u64) -> bool {
        if self.taken.contains(&id) {
            return true;
        }
        let Some(item) = self.table.find(id) else { return false };
        let shells: Set<u64> = match shell_model(item) {
            Some(model) => item.fields(model, 1).links(0).map(Iterator::collect).unwrap_or_default(),
            None => Set::from_iter([id]),
        };
        let count = shells.iter().map(|&shell| self.faces_again(shell)).sum::<Option<usize>>();
        let Some(count) = count.filter(|_| !shells.is_empty()) else { return false };
        self.taken.extend(shells);
        self.taken.insert(id);
        if count > 0 {
            self.again.get_or_insert((id, 0)).1 += count;
        }
        true
    }

    /// Number of faces that a shell lists, if all are taken; 0 for a shell that is taken. `None` for others, for what
    /// is no shell, and after too many visits.
    fn faces_again(&mut self, shell: u64) -> Option<usize> {
        if self.taken.contains(&shell) {
            return Some(0);
        }
        let own = self.table.find(shell).filter(|item| is_shell(*item))?.fields("CONNECTED_FACE_SET", 1);
        let mut count = 0;
        for face in own.links(0).ok()? {
            self.visit(shell, "faces of shells").ok()?;
            if !self.taken.contains(&self.face(face).0) {
                return None;
            }
            count += 1;
        }
        (count > 0).then_some(count)
    }

    /// Removes the sheets of a part that list only faces of its solids.
    pub(super) fn drop_sheets(&mut self, of: &mut PartContents) {
        let is_sheet = |shell: &ShellUse| shell.kind == ShellKind::Open;
        if !of.shells.iter().any(is_sheet) {
            return;
        }
        let solid: Set<u64> =
            of.shells.iter().filter(|s| !is_sheet(s)).flat_map(|s| &s.faces).map(|(face, _)| face.id()).collect();
        of.shells.retain(|shell| {
            let again = is_sheet(shell) && shell.faces.iter().all(|(face, _)| solid.contains(&face.id()));
            if again {
                self.again.get_or_insert((shell.entity, 0)).1 += shell.faces.len();
            }
            !again
        });
    }

    /// Gathers bodies, then shells, then faces that are not taken, without those that copy faces of shapes: `shown`,
    /// and those gathered.
    pub(super) fn leftovers(&mut self, units: Units, shown: impl Iterator<Item = u64>) -> PartContents {
        let mut found = PartContents::default();
        let of_kind = |wanted: fn(Entity<'_>) -> bool| self.table.of_types(wanted).map(|i| i.id);
        let is_tessellated = |i: Entity<'_>| BodyKind::of(i) == Some(BodyKind::Tessellated);
        let inner: Set<u64> = self.table.of_types(has_parts).flat_map(parts_of).collect();
        let bodies: Vec<u64> = of_kind(is_solid).filter(|id| !inner.contains(id)).collect();
        let tessellated: Vec<u64> = of_kind(is_tessellated).filter(|id| !inner.contains(id)).collect();
        for id in bodies.into_iter().chain(of_kind(is_shell)) {
            if !self.taken.contains(&id) {
                self.item(id, units, &mut found);
            }
        }
        let left: Vec<u64> = of_kind(is_face).filter(|face| !self.taken.contains(face)).collect();
        if !left.is_empty() {
            let own: Vec<u64> = found.faces().collect();
            self.copies = Copies::find(self.table, self.styles, &left, shown.chain(own));
        }
        for face in left {
            if !self.copies.faces.contains(&face) {
                self.item(face, units, &mut found);
            }
        }
        // In a file with exact geometry, tessellated bodies without a product only picture it.
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
