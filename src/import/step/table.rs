//! Part 21 syntax trees -> a table of instances by number, with typed access to their attributes.

use super::budget::ReadBudget;
use crate::control::Call;
use crate::model::{StepCause, StepTrouble};
use foldhash::fast::RandomState;
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap, HashSet};
use step_io::parser::{Attribute, RawEntity, RawEntityPart, Span};

/// A hash map for small keys, such as instance numbers. The standard hasher is slow for millions of look-ups.
pub(super) type Map<K, V> = HashMap<K, V, RandomState>;

/// A hash set for small keys, such as instance numbers.
pub(super) type Set<K> = HashSet<K, RandomState>;

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

/// An instance: what the parser makes of it, without the name of its type and the end, line and column of its number.
pub(super) struct Row {
    pub(super) id: u64,
    /// Where it starts, from the start of the piece of text that was parsed, bytes.
    pub(super) at: u32,
    body: Body,
}

enum Body {
    /// Type index and attributes.
    Simple(u32, Vec<Attribute>),
    Complex(Vec<RawEntityPart>),
}

/// Instances ordered by number, and the names of the types of the simple ones.
#[derive(Default)]
pub(super) struct Rows {
    pub(super) list: Vec<Row>,
    types: Vec<String>,
}

impl Rows {
    pub(super) fn new(entities: BTreeMap<u64, RawEntity>) -> Self {
        let mut types = Types::default();
        let row = |entity| match entity {
            RawEntity::Simple { id, name, attributes, span } => {
                Row { id, at: offset(span), body: Body::Simple(types.index(name), attributes) }
            }
            RawEntity::Complex { id, parts, span } => Row { id, at: offset(span), body: Body::Complex(parts) },
        };
        Self { list: entities.into_values().map(row).collect(), types: types.names }
    }

    /// All instances of pieces of a text. No two of them may have the same number.
    pub(super) fn joined(pieces: impl Iterator<Item = Self>, count: usize) -> Self {
        let mut types = Types::default();
        let mut list = Vec::with_capacity(count);
        for piece in pieces {
            let indices: Vec<u32> = piece.types.into_iter().map(|name| types.index(name)).collect();
            list.extend(piece.list.into_iter().map(|mut row| {
                if let Body::Simple(of, _) = &mut row.body {
                    *of = indices[*of as usize];
                }
                row
            }));
        }
        // Nearly all files are in order.
        if !list.is_sorted_by_key(|row| row.id) {
            list.sort_unstable_by_key(|row| row.id);
        }
        Self { list, types: types.names }
    }
}

fn offset(span: Span) -> u32 {
    u32::try_from(span.start).unwrap_or(u32::MAX)
}

/// Names of types, and the index of each.
#[derive(Default)]
struct Types {
    indices: Map<String, u32>,
    names: Vec<String>,
}

impl Types {
    fn index(&mut self, name: String) -> u32 {
        if let Some(index) = self.indices.get(&name) {
            return *index;
        }
        let index = u32::try_from(self.names.len()).unwrap_or(u32::MAX);
        self.indices.insert(name.clone(), index);
        self.names.push(name);
        index
    }
}

/// All instances of a file, ordered by number.
pub(super) struct Table {
    rows: Rows,
    /// Row + 1 by instance number. Empty if the numbers are too sparse; then rows are searched.
    dense: Vec<u32>,
    /// Rows of the simple instances of each type.
    of_type: Vec<Vec<u32>>,
    /// Rows of complex instances.
    complex: Vec<u32>,
    /// Places of instances that are defined in other files.
    elsewhere: BTreeMap<u64, String>,
    pub(super) budget: ReadBudget,
}

/// Instances that a thread frees at a time.
const FREED: usize = 1 << 12;

impl Table {
    /// `elsewhere`: places of instances defined in other files.
    pub(super) fn new(rows: Rows, elsewhere: BTreeMap<u64, String>, budget: ReadBudget) -> Self {
        let list = &rows.list;
        let mut dense = Vec::new();
        let last = list.last().map_or(0, |row| row.id);
        // Four bytes per number: worth it while the largest number is at most eight times the number of instances.
        if let Ok(last) = usize::try_from(last)
            && last <= list.len().saturating_mul(8).saturating_add(1024)
            && u32::try_from(list.len()).is_ok_and(|n| n < u32::MAX)
        {
            dense.resize(last + 1, 0);
            for (row, number) in list.iter().zip(1u32..) {
                if let Some(slot) = usize::try_from(row.id).ok().and_then(|id| dense.get_mut(id)) {
                    *slot = number;
                }
            }
        }
        let (mut of_type, mut complex) = (vec![Vec::new(); rows.types.len()], Vec::new());
        for (row, number) in list.iter().zip(0u32..) {
            match row.body {
                Body::Simple(of, _) => of_type[of as usize].push(number),
                Body::Complex(_) => complex.push(number),
            }
        }
        Self { rows, dense, of_type, complex, elsewhere, budget }
    }

    /// Frees the instances on all threads: on one, that takes a tenth of the time of a read.
    pub(super) fn discard(mut self, call: Call<'_>) {
        call.each(1, self.rows.list.chunks_mut(FREED), |rows| {
            rows.iter_mut().for_each(|row| row.body = Body::Complex(Vec::new()));
        });
    }

    pub(super) fn len(&self) -> usize {
        self.rows.list.len()
    }

    pub(super) fn find(&self, id: u64) -> Option<Entity<'_>> {
        let row = if self.dense.is_empty() {
            self.rows.list.binary_search_by_key(&id, |row| row.id).ok()?
        } else {
            let slot = *usize::try_from(id).ok().and_then(|id| self.dense.get(id))?;
            (slot as usize).checked_sub(1)?
        };
        self.rows.list.get(row).map(|row| self.entity(row))
    }

    fn entity<'a>(&'a self, row: &'a Row) -> Entity<'a> {
        Entity { id: row.id, body: &row.body, types: &self.rows.types }
    }

    /// Instance `id`, else the trouble that it is missing.
    pub(super) fn get(&self, id: u64) -> Read<Entity<'_>> {
        self.find(id).ok_or_else(|| match self.elsewhere.get(&id) {
            Some(place) => Trouble::new(id, StepTrouble::Elsewhere { entity: id, place: place.clone() }),
            None => Trouble::new(id, StepTrouble::NotInFile { entity: id }),
        })
    }

    /// The instances that satisfy `wanted`, ordered by number. `wanted` must depend on types only: it is called once
    /// per type of simple instances, since a file has 10 to 100 types and up to millions of instances. Ends once reading is
    /// cancelled.
    pub(super) fn of_types(&self, wanted: impl Fn(Entity<'_>) -> bool) -> impl Iterator<Item = Entity<'_>> {
        let instance = |row: u32| self.entity(&self.rows.list[row as usize]);
        let of_types = self.of_type.iter().filter(|rows| rows.first().is_some_and(|first| wanted(instance(*first))));
        let mut simple: Vec<u32> = of_types.flatten().copied().collect();
        simple.sort_unstable();
        let (mut simple, mut complex) = (simple.into_iter().peekable(), self.complex.iter().copied().peekable());
        let in_order = std::iter::from_fn(move || {
            while let Some(row) = complex.next_if(|row| simple.peek().is_none_or(|next| row < next)) {
                if wanted(instance(row)) {
                    return Some(row);
                }
            }
            simple.next()
        });
        in_order.take_while(|_| !self.budget.is_cancelled()).map(instance)
    }
}

/// One instance of the file.
#[derive(Clone, Copy)]
pub(super) struct Entity<'a> {
    pub(super) id: u64,
    body: &'a Body,
    /// Names of the types of simple instances.
    types: &'a [String],
}

impl<'a> Entity<'a> {
    /// Whether its type is `name`, or one of its types if it is complex.
    pub(super) fn is(&self, name: &str) -> bool {
        match self.body {
            Body::Simple(of, _) => self.types[*of as usize] == name,
            Body::Complex(parts) => parts.iter().any(|part| part.name == name),
        }
    }

    /// Its type name; all names joined by `+` if it is complex.
    pub(super) fn keyword(&self) -> String {
        match self.body {
            Body::Simple(of, _) => self.types[*of as usize].clone(),
            Body::Complex(parts) => parts.iter().map(|part| part.name.as_str()).collect::<Vec<_>>().join("+"),
        }
    }

    /// Names of its types.
    pub(super) fn types(&self) -> impl Iterator<Item = &'a str> + use<'a> {
        let (one, many): (Option<&'a str>, &'a [RawEntityPart]) = match self.body {
            Body::Simple(of, _) => (Some(self.types[*of as usize].as_str()), &[]),
            Body::Complex(parts) => (None, parts.as_slice()),
        };
        one.into_iter().chain(many.iter().map(|part| part.name.as_str()))
    }

    /// The attributes that the type `name` itself declares.
    ///
    /// A simple instance lists its `inherited` attributes of supertypes first; a complex one lists each type's own. The
    /// type of a simple instance is not checked: it may be a subtype of `name`.
    pub(super) fn fields(&self, name: &'static str, inherited: usize) -> Fields<'a> {
        let attributes: &'a [Attribute] = match self.body {
            Body::Simple(_, attributes) => attributes.get(inherited..).unwrap_or_default(),
            Body::Complex(parts) => {
                parts.iter().find(|part| part.name == name).map_or(&[][..], |part| part.attributes.as_slice())
            }
        };
        Fields { entity: self.id, name, attributes }
    }

    /// The name of a `REPRESENTATION_ITEM`, or of any instance whose first attribute is its name.
    pub(super) fn label(&self) -> &'a str {
        let attributes: &'a [Attribute] = match self.body {
            Body::Simple(_, attributes) => attributes,
            Body::Complex(parts) => parts
                .iter()
                .find(|part| part.name == "REPRESENTATION_ITEM" || part.name == "REPRESENTATION")
                .map_or(&[][..], |part| part.attributes.as_slice()),
        };
        match attributes.first() {
            Some(Attribute::String(text)) => text.as_str(),
            _ => "",
        }
    }

    /// Calls `visit` for every instance number in its attributes.
    pub(super) fn references(&self, visit: &mut impl FnMut(u64)) {
        match self.body {
            Body::Simple(_, attributes) => attributes.iter().for_each(|a| references(a, visit)),
            Body::Complex(parts) => {
                parts.iter().flat_map(|part| &part.attributes).for_each(|a| references(a, visit));
            }
        }
    }
}

fn references(attribute: &Attribute, visit: &mut impl FnMut(u64)) {
    match attribute {
        Attribute::EntityRef(id) => visit(*id),
        // The parser bounds the nesting.
        Attribute::List(items) => items.iter().for_each(|item| references(item, visit)),
        Attribute::Typed { value, .. } => references(value, visit),
        _ => {}
    }
}

/// The attributes that one type declares in one instance.
#[derive(Clone, Copy)]
pub(super) struct Fields<'a> {
    entity: u64,
    name: &'static str,
    attributes: &'a [Attribute],
}

impl<'a> Fields<'a> {
    fn wrong(&self, index: usize, wanted: &'static str) -> Trouble {
        Trouble::new(self.entity, StepTrouble::Attribute { keyword: self.name, number: index + 1, wanted })
    }

    pub(super) fn len(&self) -> usize {
        self.attributes.len()
    }

    pub(super) fn any(&self, index: usize) -> Option<&'a Attribute> {
        self.attributes.get(index)
    }

    pub(super) fn real(&self, index: usize) -> Read<f64> {
        self.any(index).and_then(number).ok_or_else(|| self.wrong(index, "a finite number"))
    }

    /// A non-negative whole number.
    pub(super) fn count(&self, index: usize) -> Read<usize> {
        self.any(index).and_then(whole).ok_or_else(|| self.wrong(index, "a whole number"))
    }

    pub(super) fn reference(&self, index: usize) -> Read<u64> {
        self.optional(index).ok_or_else(|| self.wrong(index, "a reference"))
    }

    pub(super) fn optional(&self, index: usize) -> Option<u64> {
        self.any(index).and_then(link)
    }

    pub(super) fn list(&self, index: usize) -> Read<&'a [Attribute]> {
        match self.any(index) {
            Some(Attribute::List(items)) => Ok(items),
            _ => Err(self.wrong(index, "a list")),
        }
    }

    /// The references in a list; other items are skipped.
    pub(super) fn links(&self, index: usize) -> Read<impl Iterator<Item = u64> + use<'a>> {
        Ok(self.list(index)?.iter().filter_map(link))
    }

    pub(super) fn reals(&self, index: usize) -> Read<Vec<f64>> {
        let items = self.list(index)?;
        items.iter().map(|item| number(item).ok_or_else(|| self.wrong(index, "a list of finite numbers"))).collect()
    }

    pub(super) fn counts(&self, index: usize) -> Read<Vec<usize>> {
        let items = self.list(index)?;
        items.iter().map(|item| whole(item).ok_or_else(|| self.wrong(index, "a list of whole numbers"))).collect()
    }

    /// `.T.` or `.F.`; anything else reads as `default`.
    pub(super) fn flag(&self, index: usize, default: bool) -> bool {
        match self.any(index) {
            Some(Attribute::Enum(value)) if value == "T" || value == "TRUE" => true,
            Some(Attribute::Enum(value)) if value == "F" || value == "FALSE" => false,
            _ => default,
        }
    }

    pub(super) fn keyword(&self, index: usize) -> &'a str {
        match self.any(index) {
            Some(Attribute::Enum(value)) => value,
            _ => "",
        }
    }

    pub(super) fn text(&self, index: usize) -> &'a str {
        match self.any(index) {
            Some(Attribute::String(text)) => text,
            _ => "",
        }
    }
}

/// The value of a number, bare or typed (`LENGTH_MEASURE(2.5)`).
pub(super) fn number(attribute: &Attribute) -> Option<f64> {
    match attribute {
        Attribute::Real(value) => value.is_finite().then_some(*value),
        #[allow(clippy::cast_precision_loss, reason = "a coordinate beyond 2^53 has no exact meaning anyway")]
        Attribute::Integer(value) => Some(*value as f64),
        Attribute::Typed { value, .. } => match value.as_ref() {
            Attribute::Typed { .. } => None,
            inner => number(inner),
        },
        _ => None,
    }
}

fn whole(attribute: &Attribute) -> Option<usize> {
    match attribute {
        Attribute::Integer(value) => usize::try_from(*value).ok(),
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "checked to be a small whole number"
        )]
        Attribute::Real(value) if value.fract() == 0.0 && (0.0..1e9).contains(value) => Some(*value as usize),
        _ => None,
    }
}

/// The instance number of a reference.
pub(super) fn link(attribute: &Attribute) -> Option<u64> {
    match attribute {
        Attribute::EntityRef(id) => Some(*id),
        _ => None,
    }
}
