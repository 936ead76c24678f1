//! Values of the attributes of instances, as the parser stores them, and access to them.
//!
//! The values of a piece of text are one list, in which each list of the text is a range. So a file of a million
//! instances takes a few hundred allocations, and none is left to be freed one by one.

use foldhash::fast::RandomState;
use std::collections::{HashMap, HashSet};

/// A hash map for small keys, such as instance numbers. The standard hasher is slow for millions of look-ups.
pub(super) type Map<K, V> = HashMap<K, V, RandomState>;

/// A hash set for small keys, such as instance numbers.
pub(super) type Set<K> = HashSet<K, RandomState>;

/// A range of a list, from `start` on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Stretch {
    start: u32,
    length: u32,
}

impl Stretch {
    /// `None` if `start` or `length` does not fit into 32 bits.
    pub(super) fn new(start: usize, length: usize) -> Option<Self> {
        Some(Self { start: u32::try_from(start).ok()?, length: u32::try_from(length).ok()? })
    }

    fn range(self) -> std::ops::Range<usize> {
        let start = self.start as usize;
        start..start + self.length as usize
    }
}

/// A value: 16 bytes.
#[derive(Clone, Copy, Debug)]
pub(super) enum Value {
    Unset,
    Derived,
    Integer(i64),
    Real(f64),
    /// The number of an instance.
    Reference(u64),
    /// In [`Values::text`].
    Text(Stretch),
    /// In [`Values::text`], without its dots.
    Enumeration(Stretch),
    /// Bits, which no geometry has.
    Binary,
    /// In [`Values::list`].
    List(Stretch),
    /// The value of a typed parameter, such as `LENGTH_MEASURE(2.5)`: one, in [`Values::list`].
    Typed(Stretch),
    /// One type of a complex instance, by its index, and the values it declares, in [`Values::list`].
    Part(u32, Stretch),
}

/// The values of a piece of text.
#[derive(Default)]
pub(super) struct Values {
    pub(super) list: Vec<Value>,
    pub(super) text: String,
}

impl Values {
    /// Gives the types of a complex instance other indices. `list`: its attributes.
    pub(super) fn rename(&mut self, list: Stretch, kind: impl Fn(u32) -> u32) {
        for value in self.list.get_mut(list.range()).unwrap_or_default() {
            if let Value::Part(of, _) = value {
                *of = kind(*of);
            }
        }
    }
}

/// Most files have fewer types.
const USUAL_TYPES: usize = 100;

/// Names of types in capitals, and the index of each.
#[derive(Default)]
pub(super) struct Types {
    indices: Map<Box<[u8]>, u32>,
    pub(super) names: Vec<String>,
    /// The type that was named last, for each length of names up to a multiple.
    recent: [u32; 32],
}

impl Types {
    /// The index of a type, by its name in capitals or small letters.
    pub(super) fn index(&mut self, name: &[u8]) -> u32 {
        // Instances of few types take turns: most names need no hash.
        let place = name.len() % self.recent.len();
        let recent = self.recent[place];
        if self.names.get(recent as usize).is_some_and(|known| known.as_bytes() == name) {
            return recent;
        }
        self.recent[place] = self.find(name);
        self.recent[place]
    }

    fn find(&mut self, name: &[u8]) -> u32 {
        if let Some(index) = self.indices.get(name) {
            return *index;
        }
        // Keeping names as written would take twice the memory.
        let capitals = name.to_ascii_uppercase();
        if capitals != name
            && let Some(index) = self.indices.get(&*capitals)
        {
            return *index;
        }
        if self.names.is_empty() {
            self.indices.reserve(USUAL_TYPES);
        }
        let index = u32::try_from(self.names.len()).unwrap_or(COMPLEX - 1);
        self.names.push(String::from_utf8_lossy(&capitals).into_owned());
        self.indices.insert(capitals.into(), index);
        index
    }
}

/// An instance.
#[derive(Clone, Copy)]
pub(super) struct Row {
    pub(super) id: u64,
    /// Where it starts, from the start of its piece of text, bytes.
    pub(super) at: u32,
    /// Index of its type; [`COMPLEX`] if it has several.
    pub(super) kind: u32,
    /// Its attributes; [`Value::Part`]s if it has several types.
    pub(super) attributes: Stretch,
}

/// Stands for the type of instances of several types.
pub(super) const COMPLEX: u32 = u32::MAX;

/// A list of values, with what they refer to.
#[derive(Clone, Copy)]
pub(super) struct List<'a> {
    values: &'a Values,
    list: &'a [Value],
}

impl<'a> List<'a> {
    pub(super) fn new(values: &'a Values, list: Stretch) -> Self {
        Self { values, list: values.list.get(list.range()).unwrap_or_default() }
    }

    pub(super) fn len(self) -> usize {
        self.list.len()
    }

    pub(super) fn get(self, index: usize) -> Option<Attribute<'a>> {
        self.list.get(index).map(|value| Attribute { values: self.values, value: *value })
    }

    /// Without the first `count`.
    pub(super) fn skip(self, count: usize) -> Self {
        Self { list: self.list.get(count..).unwrap_or_default(), ..self }
    }

    pub(super) fn iter(self) -> impl Iterator<Item = Attribute<'a>> {
        self.list.iter().map(move |value| Attribute { values: self.values, value: *value })
    }

    /// The types of a complex instance: index and attributes of each.
    pub(super) fn parts(self) -> impl Iterator<Item = (u32, Self)> {
        self.list.iter().filter_map(move |value| match value {
            Value::Part(kind, list) => Some((*kind, List::new(self.values, *list))),
            _ => None,
        })
    }

    /// Calls `visit` for every instance number in it.
    pub(super) fn references(self, visit: &mut impl FnMut(u64)) {
        for value in self.list {
            match value {
                Value::Reference(id) => visit(*id),
                // The parser bounds the nesting.
                Value::List(list) | Value::Typed(list) | Value::Part(_, list) => {
                    List::new(self.values, *list).references(visit);
                }
                _ => {}
            }
        }
    }

    /// Appends all values but texts, bits and names of typed parameters; for a reference, its content.
    pub(super) fn write_content(self, out: &mut Vec<u8>, of: &impl Fn(u64) -> [u8; 32]) {
        for value in self.list {
            let (kind, number) = match value {
                Value::Unset => (0, 0),
                Value::Derived => (1, 0),
                Value::Integer(value) => (2, value.cast_unsigned()),
                Value::Real(value) => (3, value.to_bits()),
                Value::Reference(_) => (4, 0),
                Value::Text(_) => (5, 0),
                Value::Enumeration(word) => (6, u64::from(word.length)),
                Value::Binary => (7, 0),
                Value::List(list) => (8, u64::from(list.length)),
                Value::Typed(list) => (9, u64::from(list.length)),
                Value::Part(kind, list) => (10, u64::from(*kind) << 32 | u64::from(list.length)),
            };
            // Kinds and lengths come before what they describe, so that different values never have the same bytes.
            out.push(kind);
            out.extend(number.to_le_bytes());
            match value {
                Value::Reference(id) => out.extend(of(*id)),
                Value::Enumeration(word) => {
                    out.extend(self.values.text.get(word.range()).unwrap_or_default().bytes());
                }
                Value::List(list) | Value::Typed(list) | Value::Part(_, list) => {
                    List::new(self.values, *list).write_content(out, of);
                }
                _ => {}
            }
        }
    }
}

/// A value, with what it refers to.
#[derive(Clone, Copy)]
pub(super) struct Attribute<'a> {
    values: &'a Values,
    value: Value,
}

impl<'a> Attribute<'a> {
    /// Whether it is `$` or `*`.
    pub(super) fn is_implied(self) -> bool {
        matches!(self.value, Value::Unset | Value::Derived)
    }

    /// A finite number, bare or typed (`LENGTH_MEASURE(2.5)`).
    pub(super) fn number(self) -> Option<f64> {
        match self.value {
            Value::Typed(inner) => plain(*self.values.list.get(inner.range())?.first()?),
            value => plain(value),
        }
    }

    /// A whole number that is not negative.
    pub(super) fn whole(self) -> Option<usize> {
        match self.value {
            Value::Integer(value) => usize::try_from(value).ok(),
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "checked to be a small whole number"
            )]
            Value::Real(value) if value.fract() == 0.0 && (0.0..1e9).contains(&value) => Some(value as usize),
            _ => None,
        }
    }

    /// The instance number of a reference.
    pub(super) fn link(self) -> Option<u64> {
        if let Value::Reference(id) = self.value { Some(id) } else { None }
    }

    pub(super) fn list(self) -> Option<List<'a>> {
        if let Value::List(list) = self.value { Some(List::new(self.values, list)) } else { None }
    }

    pub(super) fn text(self) -> Option<&'a str> {
        if let Value::Text(text) = self.value { self.values.text.get(text.range()) } else { None }
    }

    /// The word of an enumeration, without its dots.
    pub(super) fn word(self) -> Option<&'a str> {
        if let Value::Enumeration(word) = self.value { self.values.text.get(word.range()) } else { None }
    }
}

fn plain(value: Value) -> Option<f64> {
    match value {
        Value::Real(value) => value.is_finite().then_some(value),
        #[allow(clippy::cast_precision_loss, reason = "a coordinate beyond 2^53 has no exact meaning anyway")]
        Value::Integer(value) => Some(value as f64),
        _ => None,
    }
}
