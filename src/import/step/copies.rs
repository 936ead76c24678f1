//! Faces that belong to no shape -> those among them that copy a face of a shape, instance by instance.
//!
//! Some writers colour a copy of a face instead of the face itself. Only a styled item refers to the copy, and meshed
//! with the rest it would lie on the original.

use super::style::Styles;
use super::table::Table;
use super::values::{Map, Set};
use crate::model::Colour;
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
