//! Faces that belong to no shape -> those among them that copy a face of a shape, instance by instance.
//!
//! Some writers colour a copy of a face instead of the face itself. Only a styled item refers to the copy, and meshed
//! with the rest it would lie on the original.

use super::table::Table;
use super::values::Map;
use std::hash::{DefaultHasher, Hash, Hasher};

/// Most instances that are visited, as a multiple of those of the file. Faces share few instances, of which each visits
/// its own.
const VISITS: usize = 8;

/// The pairs of a face of `of` and a face of `left` that copies it. None where faces share nearly all of the file.
pub(super) fn copies(table: &Table, left: &[u64], of: impl Iterator<Item = u64>) -> Vec<(u64, u64)> {
    let mut forms = Forms { table, left: VISITS * table.len() };
    pairs(&mut forms, left, of).unwrap_or_default()
}

fn pairs(forms: &mut Forms<'_>, left: &[u64], of: impl Iterator<Item = u64>) -> Option<Vec<(u64, u64)>> {
    let hash = |form: &[u64]| {
        let mut hasher = DefaultHasher::new();
        form.hash(&mut hasher);
        hasher.finish()
    };
    let mut by_hash: Map<u64, Vec<u64>> = Map::default();
    for &face in left {
        by_hash.entry(hash(&forms.of(face)?)).or_default().push(face);
    }
    let mut out = Vec::new();
    for face in of {
        let form = forms.of(face)?;
        for &copy in by_hash.get(&hash(&form)).into_iter().flatten() {
            if forms.of(copy)? == form {
                out.push((face, copy));
            }
        }
    }
    Some(out)
}

struct Forms<'a> {
    table: &'a Table,
    /// Instances that may still be visited.
    left: usize,
}

impl Forms<'_> {
    /// All values of an instance and of those that it refers to, except texts. References are numbered in order, so
    /// that copies have the same form. `None` if too many instances were visited.
    fn of(&mut self, id: u64) -> Option<Vec<u64>> {
        let mut numbers = Map::from_iter([(id, 0)]);
        let mut queue = vec![id];
        let mut out = Vec::new();
        let mut at = 0;
        while let Some(&id) = queue.get(at) {
            at += 1;
            self.left = self.left.checked_sub(1)?;
            // An instance that is missing is like no other.
            let Some(entity) = self.table.find(id) else {
                out.push(id);
                continue;
            };
            entity.form(&mut out, &mut |id| {
                *numbers.entry(id).or_insert_with(|| {
                    queue.push(id);
                    queue.len() as u64 - 1
                })
            });
        }
        Some(out)
    }
}
