//! Faces that belong to no shape -> those among them that copy a face of a shape, instance by instance.
//!
//! Some writers colour a copy of a face instead of the face itself. Only a styled item refers to the copy, and meshed
//! with the rest it would lie on the original.

use super::style::Styles;
use super::table::Table;
use super::values::{Map, Set};
use crate::model::Colour;

/// Faces that belong to no shape and copy faces of shapes.
#[derive(Default)]
pub(super) struct Copies {
    pub(super) faces: Set<u64>,
    /// The first of them in the file.
    pub(super) first: Option<u64>,
    /// Their colours, by the face that they copy.
    pub(super) colours: Map<u64, Colour>,
}

impl Copies {
    /// Those of the faces `left` that copy one of the faces `of` shapes: all types and values are the same, but for
    /// texts and bits. Of several colours for a face, the first in the file counts.
    ///
    /// Cost: less than a microsecond and about 60 bytes for each instance that these faces lead to.
    pub(super) fn find(table: &Table, styles: &Styles, left: &[u64], of: impl Iterator<Item = u64>) -> Self {
        let mut contents = Contents { table, known: Map::default(), buffer: Vec::new() };
        let mut alike: Map<Hash, Vec<u64>> = Map::default();
        for &face in left {
            alike.entry(contents.of(face)).or_default().push(face);
        }
        let mut found = Self::default();
        for face in of.take_while(|_| !table.budget.is_cancelled()) {
            for &copy in alike.get(&contents.of(face)).into_iter().flatten() {
                found.faces.insert(copy);
                if let Some(colour) = styles.of(copy) {
                    found.colours.entry(face).or_insert(colour);
                }
            }
        }
        found.first = left.iter().copied().find(|face| found.faces.contains(face));
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
            } else if !self.known.contains_key(&id) {
                // What is missing, or refers back to itself, is like nothing else.
                self.known.insert(id, *blake3::hash(&id.to_le_bytes()).as_bytes());
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
