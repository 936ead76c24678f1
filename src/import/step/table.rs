//! Instances of all pieces of a text -> a table by number, with typed access to their attributes.

use super::budget::ReadBudget;
use super::values::{Attribute, COMPLEX, List, Map, Row, Types, Values};
use crate::control::Call;
use crate::model::{CurveTrouble, StepCause, StepTrouble};
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

    /// Whether a curve is a single point, which an edge without length may be.
    pub(super) fn is_point(&self) -> bool {
        matches!(*self.what, StepTrouble::Curve(CurveTrouble::OnePoint))
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
pub(super) fn out_of_range(what: impl Into<Cow<'static, str>>, value: f64, unit: &'static str) -> StepTrouble {
    StepTrouble::Measure { what: what.into(), value, unit }
}

/// Maximum nesting of references of one kind (curves in curves, surfaces in surfaces, shells in shells). Deeper files
/// are treated as cyclic. Real files stay below 6.
pub(super) const MAX_DEPTH: usize = 24;

/// Fails at [`MAX_DEPTH`] and beyond.
pub(super) fn check_depth(depth: usize, id: u64, what: &'static str) -> Read<()> {
    if depth < MAX_DEPTH { Ok(()) } else { Err(Trouble::new(id, StepTrouble::TooDeep { what })) }
}

/// All instances of a file, by number.
pub(super) struct Table {
    pieces: Vec<Instances>,
    /// Whether numbers ascend through all pieces.
    is_in_order: bool,
    /// Names of types.
    types: Vec<String>,
    /// Code of the place of each instance, by number. Empty if the numbers are too sparse.
    dense: Vec<u64>,
    /// Numbers and places, ascending, if the numbers are too sparse.
    sparse: Vec<(u64, Place)>,
    /// Place of one instance of each type, if there is any; then of each combination of types that complex instances
    /// have.
    samples: Vec<Option<Place>>,
    /// Places of instances that are defined in other files.
    elsewhere: BTreeMap<u64, String>,
    pub(super) budget: ReadBudget,
}

/// The instances of a piece of text, in its order.
#[derive(Default)]
struct Instances {
    rows: Vec<Row>,
    values: Values,
    /// Rows by type or combination of types, as an index in [`Table::samples`].
    of_type: Vec<(usize, Vec<u32>)>,
}

/// A row of a piece.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    piece: u32,
    row: u32,
}

impl Place {
    /// A number of the place that is not 0.
    fn code(self) -> u64 {
        (u64::from(self.piece) << 32 | u64::from(self.row)) + 1
    }

    fn of_code(code: u64) -> Option<Self> {
        let code = code.checked_sub(1)?;
        Some(Self { piece: (code >> 32) as u32, row: code as u32 })
    }
}

/// Rows of a piece by the combination of types that its complex instances have.
type ByCombination = Map<Vec<u32>, Vec<u32>>;

/// A piece that becomes part of the table.
struct Entry<'a> {
    piece: u32,
    of_piece: Instances,
    /// The index of each of its types in the table.
    kinds: Vec<u32>,
    /// The codes of the numbers from that of its first instance on, up to the next piece.
    slots: &'a mut [u64],
}

impl Entry<'_> {
    /// Gives types their indices, and instances their codes.
    fn enter(self) -> (Instances, ByCombination) {
        let Self { piece, of_piece: Instances { mut rows, mut values, .. }, kinds, slots } = self;
        let kind = |kind: u32| kinds.get(kind as usize).copied().unwrap_or(COMPLEX);
        let mut by_kind = vec![Vec::new(); kinds.len()];
        let mut by_combination = ByCombination::default();
        let first = rows.first().map_or(0, |row| row.id);
        for (row, number) in rows.iter_mut().zip(0..) {
            let slot = row.id.checked_sub(first).and_then(|k| slots.get_mut(usize::try_from(k).ok()?));
            if let Some(slot) = slot {
                *slot = Place { piece, row: number }.code();
            }
            if row.kind == COMPLEX {
                values.rename(row.attributes, kind);
                let parts = List::new(&values, row.attributes).parts();
                by_combination.entry(parts.map(|(kind, _)| kind).collect()).or_default().push(number);
            } else {
                by_kind[row.kind as usize].push(number);
                row.kind = kind(row.kind);
            }
        }
        let by_kind = kinds.into_iter().map(|kind| kind as usize).zip(by_kind);
        let of_type = by_kind.filter(|(_, rows)| !rows.is_empty()).collect();
        (Instances { rows, values, of_type }, by_combination)
    }
}

impl Table {
    /// The instances of pieces of a text, no two of which may have the same number. `is_in_order`: whether numbers
    /// ascend. `elsewhere`: places of instances defined in other files. Some of them once reading is cancelled.
    pub(super) fn new(
        call: Call<'_>,
        (pieces, is_in_order): (Vec<(Vec<Row>, Types, Values)>, bool),
        elsewhere: BTreeMap<u64, String>,
        budget: ReadBudget,
    ) -> Self {
        let mut types = Types::default();
        let mut kinds_of = |named: Types| -> Vec<u32> {
            if types.names.is_empty() {
                types = named;
                return (0..types.names.len() as u32).collect();
            }
            named.names.iter().map(|name| types.index(name.as_bytes())).collect()
        };
        let pieces: Vec<(Instances, Vec<u32>)> = pieces
            .into_iter()
            .map(|(rows, named, values)| (Instances { rows, values, of_type: Vec::new() }, kinds_of(named)))
            .take_while(|_| !budget.is_cancelled())
            .collect();
        let all = || pieces.iter().flat_map(|(of_piece, _)| &of_piece.rows);
        let last = if is_in_order { all().next_back().map(|row| row.id) } else { all().map(|row| row.id).max() };
        let count = pieces.iter().map(|(of_piece, _)| of_piece.rows.len()).sum();
        let mut dense = vec![0; slots(last.unwrap_or(0), count)];
        // If all are in order, each piece has its own part of them: from its first number to that of the next one.
        let mut rest = if is_in_order { &mut dense[..] } else { &mut [] };
        let mut entries = Vec::with_capacity(pieces.len());
        for (piece, (of_piece, kinds)) in pieces.into_iter().enumerate().rev() {
            let first = of_piece.rows.first().and_then(|row| usize::try_from(row.id).ok());
            let from = first.map_or(rest.len(), |first| first.min(rest.len()));
            let (before, slots) = std::mem::take(&mut rest).split_at_mut(from);
            rest = before;
            entries.push(Entry { piece: piece as u32, of_piece, kinds, slots });
        }
        entries.reverse();
        let entered =
            call.each(1, entries, |entry| if call.is_cancelled() { Default::default() } else { entry.enter() });
        let mut table = Self {
            pieces: Vec::with_capacity(entered.len()),
            is_in_order,
            samples: vec![None; types.names.len()],
            types: types.names,
            dense,
            sparse: Vec::new(),
            elsewhere,
            budget,
        };
        let mut combinations: Map<Vec<u32>, usize> = Map::default();
        for (piece, (mut of_piece, by_combination)) in (0..).zip(entered) {
            of_piece.of_type.extend(by_combination.into_iter().map(|(combination, rows)| {
                let kind = *combinations.entry(combination).or_insert_with(|| {
                    table.samples.push(None);
                    table.samples.len() - 1
                });
                (kind, rows)
            }));
            for (kind, rows) in &of_piece.of_type {
                let sample = &mut table.samples[*kind];
                *sample = sample.or(rows.first().map(|&row| Place { piece, row }));
            }
            table.pieces.push(of_piece);
        }
        table.index();
        table
    }

    /// Finds instances whose numbers are not in order, or too sparse.
    fn index(&mut self) {
        if self.is_in_order && !self.dense.is_empty() {
            return;
        }
        if self.dense.is_empty() {
            self.sparse.reserve_exact(self.len());
        }
        for (of_piece, piece) in self.pieces.iter().zip(0..).take_while(|_| !self.budget.is_cancelled()) {
            for (&Row { id, .. }, row) in of_piece.rows.iter().zip(0..) {
                let place = Place { piece, row };
                match usize::try_from(id).ok().and_then(|id| self.dense.get_mut(id)) {
                    Some(slot) => *slot = place.code(),
                    None => self.sparse.push((id, place)),
                }
            }
        }
        self.sparse.sort_unstable();
    }

    pub(super) fn len(&self) -> usize {
        self.pieces.iter().map(|piece| piece.rows.len()).sum()
    }

    pub(super) fn find(&self, id: u64) -> Option<Entity<'_>> {
        let place = if self.dense.is_empty() {
            let at = self.sparse.binary_search_by_key(&id, |(id, _)| *id).ok()?;
            self.sparse.get(at)?.1
        } else {
            Place::of_code(*usize::try_from(id).ok().and_then(|id| self.dense.get(id))?)?
        };
        Some(self.entity(place))
    }

    fn entity(&self, Place { piece, row }: Place) -> Entity<'_> {
        let Instances { rows, values, .. } = &self.pieces[piece as usize];
        let Row { id, kind, attributes, .. } = rows[row as usize];
        Entity {
            id,
            kind: self.types.get(kind as usize).map(String::as_str),
            attributes: List::new(values, attributes),
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
        let is_wanted = |sample: &Option<Place>| sample.is_some_and(|place| wanted(self.entity(place)));
        let kinds: Vec<bool> = self.samples.iter().map(is_wanted).collect();
        let mut places: Vec<Place> = Vec::new();
        for (piece, of_piece) in (0..).zip(&self.pieces) {
            let rows = of_piece.of_type.iter().filter(|(kind, _)| kinds[*kind]).flat_map(|(_, rows)| rows);
            places.extend(rows.map(|&row| Place { piece, row }));
        }
        if self.is_in_order {
            places.sort_unstable();
        } else {
            places.sort_unstable_by_key(|place| self.entity(*place).id);
        }
        places.into_iter().take_while(|_| !self.budget.is_cancelled()).map(|place| self.entity(place))
    }
}

/// Length of a list by number, where it is worth it: eight bytes per number, and the largest number is at most eight
/// times the number of instances.
fn slots(last: u64, count: usize) -> usize {
    let most = count.saturating_mul(8).saturating_add(1024);
    usize::try_from(last).ok().filter(|last| *last <= most).map_or(0, |last| last + 1)
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

    /// The first of these names that [is](Self::is) its type, or one of its types.
    #[inline]
    pub(super) fn first_of<const N: usize>(&self, names: [&'static str; N]) -> Option<&'static str> {
        names.into_iter().find(|name| self.is(name))
    }

    /// Whether one of these names [is](Self::is) its type, or one of its types.
    #[inline]
    pub(super) fn is_any<const N: usize>(&self, names: [&'static str; N]) -> bool {
        self.first_of(names).is_some()
    }

    /// Its type name; all names joined by `+` if it is complex.
    pub(super) fn keyword(&self) -> String {
        self.types().collect::<Vec<_>>().join("+")
    }

    /// The trouble that instances of its type are not read as `what`.
    pub(super) fn not_read(&self, what: &'static str) -> Trouble {
        Trouble::new(self.id, StepTrouble::NotRead { what, keyword: self.keyword() })
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

    /// Appends its type and its values but texts and bits; for a reference, its content.
    pub(super) fn write_content(&self, out: &mut Vec<u8>, of: &impl Fn(u64) -> [u8; 32]) {
        let kind = self.kind.unwrap_or_default();
        out.extend([kind.len(), self.attributes.len()].into_iter().flat_map(usize::to_le_bytes));
        out.extend(kind.bytes());
        self.attributes.write_content(out, of);
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

    /// The lists in a list of `what`, which should be `wanted`.
    pub(super) fn rows(
        &self,
        index: usize,
        what: &'static str,
        wanted: &'static str,
    ) -> Read<impl Iterator<Item = Read<List<'a>>> + use<'a>> {
        let entity = self.entity;
        let trouble = move || Trouble::new(entity, StepTrouble::Layout { what, wanted });
        Ok(self.list(index)?.iter().map(move |row| row.list().ok_or_else(trouble)))
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
