//! Instances of all pieces of a text -> a table by number, with typed access to their attributes.

use super::budget::ReadBudget;
use super::values::{Attribute, COMPLEX, List, Map, Row, Types, Values};
use crate::model::{StepCause, StepTrouble};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// The instance that could not be read, and why.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Trouble {
    pub(super) entity: u64,
    /// Boxed, so that results stay small.
    pub(super) what: Box<StepTrouble>,
}

impl Trouble {
    pub(super) fn new(entity: u64, what: impl Into<StepTrouble>) -> Self {
        Self { entity, what: Box::new(what.into()) }
    }

    /// The cause in a diagnostic of instance `id`.
    pub(super) fn seen_from(&self, id: u64) -> StepCause {
        StepCause { entity: (self.entity != id).then_some(self.entity), trouble: self.what.clone() }
    }
}

pub(super) type Read<T> = Result<T, Trouble>;

/// The trouble that `what` has no `part`.
pub(super) fn missing(what: impl Into<Cow<'static, str>>, part: &'static str) -> StepTrouble {
    StepTrouble::Missing { what: what.into(), part }
}

/// The trouble that the `value` of `what` is out of range.
pub(super) fn measure(what: impl Into<Cow<'static, str>>, value: f64, unit: &'static str) -> StepTrouble {
    StepTrouble::Measure { what: what.into(), value, unit }
}

/// Maximum nesting of references of one kind (curves in curves, surfaces in surfaces, shells in shells). Deeper files
/// are treated as cyclic. Real files stay below 6.
pub(super) const MAX_DEPTH: usize = 24;

/// All instances of a file, ordered by number.
pub(super) struct Table {
    rows: Vec<Row>,
    /// Names of types.
    types: Vec<String>,
    /// Values of the pieces of the text.
    values: Vec<Values>,
    /// Row + 1 by instance number. Empty if the numbers are too sparse; then rows are searched.
    dense: Vec<u32>,
    /// Rows of the instances of each type; then those of each combination of types that complex instances have.
    of_type: Vec<Vec<u32>>,
    /// Places of instances that are defined in other files.
    elsewhere: BTreeMap<u64, String>,
    pub(super) budget: ReadBudget,
}

impl Table {
    /// The instances of pieces of a text, no two of which may have the same number. `elsewhere`: places of instances
    /// defined in other files. Some of them once reading is cancelled.
    pub(super) fn new(
        pieces: Vec<(Vec<Row>, Types, Values)>,
        elsewhere: BTreeMap<u64, String>,
        budget: ReadBudget,
    ) -> Self {
        let goes_on = || !budget.is_cancelled();
        let count: usize = pieces.iter().map(|(rows, ..)| rows.len()).sum();
        let mut pieces = pieces.into_iter();
        // Types keep the indices that they have in the first piece, which is the only one of a small file.
        let (mut rows, mut types, values) = pieces.next().unwrap_or_default();
        rows.reserve_exact(count - rows.len());
        let mut values = vec![values];
        for (of_piece, named, mut of_rows) in pieces.take_while(|_| goes_on()) {
            let indices: Vec<u32> = named.names.iter().map(|name| types.index(name.as_bytes())).collect();
            let kind = |kind: u32| indices.get(kind as usize).copied().unwrap_or(COMPLEX);
            of_piece.iter().filter(|row| row.kind == COMPLEX).for_each(|row| of_rows.rename(row.attributes, kind));
            rows.extend(of_piece.into_iter().map(|row| Row { kind: kind(row.kind), ..row }));
            values.push(of_rows);
        }
        // Nearly all files are in order.
        if !rows.is_sorted_by_key(|row| row.id) {
            rows.sort_unstable_by_key(|row| row.id);
        }
        let mut dense = Vec::new();
        let last = rows.last().map_or(0, |row| row.id);
        // Four bytes per number: worth it while the largest number is at most eight times the number of instances.
        if let Ok(last) = usize::try_from(last)
            && last <= rows.len().saturating_mul(8).saturating_add(1024)
            && u32::try_from(rows.len()).is_ok_and(|n| n < u32::MAX)
        {
            dense.resize(last + 1, 0);
            for (row, number) in rows.iter().take_while(|_| goes_on()).zip(1u32..) {
                if let Some(slot) = usize::try_from(row.id).ok().and_then(|id| dense.get_mut(id)) {
                    *slot = number;
                }
            }
        }
        let mut of_type = vec![Vec::new(); types.names.len()];
        let mut combinations: Map<Vec<u32>, usize> = Map::default();
        for (row, number) in rows.iter().take_while(|_| goes_on()).zip(0u32..) {
            let kind = if row.kind == COMPLEX {
                let parts = List::new(&values[row.piece as usize], row.attributes).parts();
                *combinations.entry(parts.map(|(kind, _)| kind).collect()).or_insert_with(|| {
                    of_type.push(Vec::new());
                    of_type.len() - 1
                })
            } else {
                row.kind as usize
            };
            of_type[kind].push(number);
        }
        Self { rows, types: types.names, values, dense, of_type, elsewhere, budget }
    }

    pub(super) fn len(&self) -> usize {
        self.rows.len()
    }

    pub(super) fn find(&self, id: u64) -> Option<Entity<'_>> {
        let row = if self.dense.is_empty() {
            self.rows.binary_search_by_key(&id, |row| row.id).ok()?
        } else {
            let slot = *usize::try_from(id).ok().and_then(|id| self.dense.get(id))?;
            (slot as usize).checked_sub(1)?
        };
        self.rows.get(row).map(|row| self.entity(row))
    }

    fn entity<'a>(&'a self, row: &Row) -> Entity<'a> {
        let attributes = List::new(&self.values[row.piece as usize], row.attributes);
        Entity {
            id: row.id,
            kind: self.types.get(row.kind as usize).map(String::as_str),
            attributes,
            types: &self.types,
        }
    }

    /// Instance `id`, else the trouble that it is missing.
    pub(super) fn get(&self, id: u64) -> Read<Entity<'_>> {
        self.find(id).ok_or_else(|| match self.elsewhere.get(&id) {
            Some(place) => Trouble::new(id, StepTrouble::Elsewhere { entity: id, place: place.clone() }),
            None => Trouble::new(id, StepTrouble::NotInFile { entity: id }),
        })
    }

    /// The instances that satisfy `wanted`, ordered by number. `wanted` must depend on types only: it is called once
    /// per type or combination of types, since a file has 10 to 100 of them and up to millions of instances. Ends once
    /// reading is cancelled.
    pub(super) fn of_types(&self, wanted: impl Fn(Entity<'_>) -> bool) -> impl Iterator<Item = Entity<'_>> {
        let instance = |row: u32| self.entity(&self.rows[row as usize]);
        let of_types = self.of_type.iter().filter(|rows| rows.first().is_some_and(|first| wanted(instance(*first))));
        let mut rows: Vec<u32> = of_types.flatten().copied().collect();
        rows.sort_unstable();
        rows.into_iter().take_while(|_| !self.budget.is_cancelled()).map(instance)
    }
}

/// One instance of the file.
#[derive(Clone, Copy)]
pub(super) struct Entity<'a> {
    pub(super) id: u64,
    /// The name of its type, unless it is complex.
    kind: Option<&'a str>,
    /// Its attributes; if it is complex, those of each type.
    attributes: List<'a>,
    /// Names of all types.
    types: &'a [String],
}

impl<'a> Entity<'a> {
    /// Whether its type is `name`, or one of its types if it is complex.
    pub(super) fn is(&self, name: &str) -> bool {
        self.kind.map_or_else(|| self.types().any(|of| of == name), |kind| kind == name)
    }

    /// Its type name; all names joined by `+` if it is complex.
    pub(super) fn keyword(&self) -> String {
        self.types().collect::<Vec<_>>().join("+")
    }

    /// Names of its types.
    pub(super) fn types(&self) -> impl Iterator<Item = &'a str> + use<'a> {
        let parts = self.kind.is_none().then(|| self.parts().map(|(name, _)| name));
        self.kind.into_iter().chain(parts.into_iter().flatten())
    }

    /// The types of a complex instance: name and attributes of each.
    fn parts(&self) -> impl Iterator<Item = (&'a str, List<'a>)> + use<'a> {
        let types = self.types;
        self.attributes.parts().map(|(kind, list)| (types.get(kind as usize).map_or("", String::as_str), list))
    }

    /// The attributes of one of the types of a complex instance.
    fn part(&self, is: impl Fn(&str) -> bool) -> List<'a> {
        self.parts().find(|(name, _)| is(name)).map_or(self.attributes.skip(usize::MAX), |(_, list)| list)
    }

    /// The attributes that the type `name` itself declares.
    ///
    /// A simple instance lists its `inherited` attributes of supertypes first; a complex one lists each type's own. The
    /// type of a simple instance is not checked: it may be a subtype of `name`.
    pub(super) fn fields(&self, name: &'static str, inherited: usize) -> Fields<'a> {
        let attributes = match self.kind {
            Some(_) => self.attributes.skip(inherited),
            None => self.part(|of| of == name),
        };
        Fields { entity: self.id, name, attributes }
    }

    /// The name of a `REPRESENTATION_ITEM`, or of any instance whose first attribute is its name.
    pub(super) fn label(&self) -> &'a str {
        let attributes = match self.kind {
            Some(_) => self.attributes,
            None => self.part(|of| of == "REPRESENTATION_ITEM" || of == "REPRESENTATION"),
        };
        attributes.get(0).and_then(Attribute::text).unwrap_or_default()
    }

    /// Calls `visit` for every instance number in its attributes.
    pub(super) fn references(&self, visit: &mut impl FnMut(u64)) {
        self.attributes.references(visit);
    }
}

/// The attributes that one type declares in one instance.
#[derive(Clone, Copy)]
pub(super) struct Fields<'a> {
    entity: u64,
    name: &'static str,
    attributes: List<'a>,
}

impl<'a> Fields<'a> {
    fn wrong(&self, index: usize, wanted: &'static str) -> Trouble {
        Trouble::new(self.entity, StepTrouble::Attribute { keyword: self.name, number: index + 1, wanted })
    }

    pub(super) fn len(&self) -> usize {
        self.attributes.len()
    }

    pub(super) fn any(&self, index: usize) -> Option<Attribute<'a>> {
        self.attributes.get(index)
    }

    pub(super) fn real(&self, index: usize) -> Read<f64> {
        self.any(index).and_then(Attribute::number).ok_or_else(|| self.wrong(index, "a finite number"))
    }

    /// A non-negative whole number.
    pub(super) fn count(&self, index: usize) -> Read<usize> {
        self.any(index).and_then(Attribute::whole).ok_or_else(|| self.wrong(index, "a whole number"))
    }

    pub(super) fn reference(&self, index: usize) -> Read<u64> {
        self.optional(index).ok_or_else(|| self.wrong(index, "a reference"))
    }

    pub(super) fn optional(&self, index: usize) -> Option<u64> {
        self.any(index).and_then(Attribute::link)
    }

    pub(super) fn list(&self, index: usize) -> Read<List<'a>> {
        self.any(index).and_then(Attribute::list).ok_or_else(|| self.wrong(index, "a list"))
    }

    /// The references in a list; other items are skipped.
    pub(super) fn links(&self, index: usize) -> Read<impl Iterator<Item = u64> + use<'a>> {
        Ok(self.list(index)?.iter().filter_map(Attribute::link))
    }

    pub(super) fn reals(&self, index: usize) -> Read<Vec<f64>> {
        let items = self.list(index)?;
        items.iter().map(|item| item.number().ok_or_else(|| self.wrong(index, "a list of finite numbers"))).collect()
    }

    pub(super) fn counts(&self, index: usize) -> Read<Vec<usize>> {
        let items = self.list(index)?;
        items.iter().map(|item| item.whole().ok_or_else(|| self.wrong(index, "a list of whole numbers"))).collect()
    }

    /// `.T.` or `.F.`; anything else reads as `default`.
    pub(super) fn flag(&self, index: usize, default: bool) -> bool {
        match self.keyword(index) {
            "T" | "TRUE" => true,
            "F" | "FALSE" => false,
            _ => default,
        }
    }

    pub(super) fn keyword(&self, index: usize) -> &'a str {
        self.any(index).and_then(Attribute::word).unwrap_or_default()
    }

    pub(super) fn text(&self, index: usize) -> &'a str {
        self.any(index).and_then(Attribute::text).unwrap_or_default()
    }
}
