//! Unit contexts of representations -> millimetres per length unit, radians per angle unit, and tolerances; within
//! these, whether the two vertices of an edge are one.

use super::table::{Entity, MAX_DEPTH, Table};
use super::values::Map;
use glam::DVec3;

/// Units and tolerance of one representation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Units {
    /// Millimetres per length unit.
    pub(super) length: f64,
    /// Radians per plane angle unit.
    pub(super) angle: f64,
    /// The stated uncertainty, else 1e-5; within 1e-7 to 0.01. Millimetres.
    pub(super) tolerance: f64,
}

impl Units {
    /// Millimetres and radians, for files that state no units.
    pub(super) const DEFAULT: Self = Self { length: 1.0, angle: 1.0, tolerance: 1e-5 };

    /// Ends of neighbours in a loop within this distance are one corner, millimetres.
    pub(super) fn corner(&self) -> f64 {
        10.0 * self.tolerance
    }
}

/// Units of every context of the file.
pub(super) struct Contexts {
    known: Map<u64, Units>,
    /// Units of the first context that has any, for geometry without a representation.
    pub(super) first: Units,
    /// Whether any context states a length unit.
    pub(super) stated: bool,
    /// The first context whose length unit is out of range, and the unit in millimetres.
    pub(super) out_of_range: Option<(u64, f64)>,
    /// The first unit of lengths or angles that cannot be read, of those that are needed.
    pub(super) unread: Option<u64>,
}

/// Length units that are read, in millimetres: powers of coordinates in them are far from the ends of `f64`.
const LENGTHS: std::ops::RangeInclusive<f64> = 1e-24..=1e24;

impl Contexts {
    pub(super) fn read(table: &Table) -> Self {
        let mut known = Map::default();
        let (mut first, mut out_of_range, mut unread) = (None, None, None);
        for context in table.of_types(|i| i.is("GLOBAL_UNIT_ASSIGNED_CONTEXT")) {
            let mut units = units_of(table, context, &mut unread);
            if let Some(units) = units.as_mut().filter(|units| !LENGTHS.contains(&units.length)) {
                out_of_range.get_or_insert((context.id, units.length));
                units.length = Units::DEFAULT.length;
            }
            if let Some(units) = units {
                first.get_or_insert(units);
            }
            known.insert(context.id, units.unwrap_or(Units::DEFAULT));
        }
        Self { known, first: first.unwrap_or(Units::DEFAULT), stated: first.is_some(), out_of_range, unread }
    }

    /// Units of a representation's context, else the file's first.
    pub(super) fn of(&self, context: Option<u64>) -> Units {
        context.and_then(|id| self.known.get(&id).copied()).unwrap_or(self.first)
    }
}

/// Units of a context; `None` if it states no length unit. Sets `unread` to the first unit that is needed and cannot be
/// read: that of [`Units::DEFAULT`] is assumed.
fn units_of(table: &Table, context: Entity<'_>, unread: &mut Option<u64>) -> Option<Units> {
    let mut units = Units::DEFAULT;
    let mut length = None;
    let is = |unit: u64, name: &str| table.find(unit).is_some_and(|i| i.is(name));
    for unit in context.fields("GLOBAL_UNIT_ASSIGNED_CONTEXT", 2).links(0).ok()? {
        match factor(table, unit, 0) {
            Some((UnitKind::Length, metres)) => _ = length.get_or_insert(1e3 * metres),
            Some((UnitKind::Angle, radians)) if radians.is_normal() => units.angle = radians,
            _ if length.is_none() && is(unit, "LENGTH_UNIT") => {
                length = Some(units.length);
                unread.get_or_insert(unit);
            }
            _ if is(unit, "PLANE_ANGLE_UNIT") => _ = unread.get_or_insert(unit),
            _ => {}
        }
    }
    units.length = length?;
    let stated = context.fields("GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT", usize::MAX).links(0).ok();
    let uncertainty = stated.and_then(|mut list| {
        list.find_map(|id| {
            let (value, unit) = measure(table, id)?;
            let (kind, metres) = factor(table, unit, 0)?;
            (kind == UnitKind::Length).then_some(1e3 * metres * value)
        })
    });
    // Writers state anything from 1e-9 to a tenth of the part. Values outside these bounds say nothing about the
    // geometry.
    units.tolerance = uncertainty.unwrap_or(Units::DEFAULT.tolerance).clamp(1e-7, 0.01);
    Some(units)
}

/// Value and unit of a measure with unit, simple or complex.
fn measure(table: &Table, id: u64) -> Option<(f64, u64)> {
    let fields = table.find(id)?.fields("MEASURE_WITH_UNIT", 0);
    let value = fields.real(0).ok().filter(|value| *value > 0.0)?;
    Some((value, fields.optional(1)?))
}

#[derive(Clone, Copy, PartialEq)]
enum UnitKind {
    Length,
    Angle,
}

/// Kind of a unit, and its size in metres or radians.
fn factor(table: &Table, id: u64, depth: usize) -> Option<(UnitKind, f64)> {
    if depth > MAX_DEPTH {
        return None;
    }
    let unit = table.find(id)?;
    if unit.is("CONVERSION_BASED_UNIT") {
        // A simple instance states its dimensions first; a complex one states them in NAMED_UNIT.
        let conversion = unit.fields("CONVERSION_BASED_UNIT", 1).reference(1).ok()?;
        let (value, base) = measure(table, conversion)?;
        let (kind, base) = factor(table, base, depth + 1)?;
        return Some((kind, value * base));
    }
    if unit.is("SI_UNIT") {
        let si = unit.fields("SI_UNIT", 1);
        let kind = match si.keyword(1) {
            "METRE" => UnitKind::Length,
            "RADIAN" => UnitKind::Angle,
            _ => return None,
        };
        return Some((kind, prefix(si.keyword(0))?));
    }
    None
}

/// The factor of an SI prefix; 1 for none.
fn prefix(name: &str) -> Option<f64> {
    Some(match name {
        "EXA" => 1e18,
        "PETA" => 1e15,
        "TERA" => 1e12,
        "GIGA" => 1e9,
        "MEGA" => 1e6,
        "KILO" => 1e3,
        "HECTO" => 1e2,
        "DECA" => 1e1,
        "DECI" => 1e-1,
        "CENTI" => 1e-2,
        "MILLI" => 1e-3,
        "MICRO" => 1e-6,
        "NANO" => 1e-9,
        "PICO" => 1e-12,
        "FEMTO" => 1e-15,
        "ATTO" => 1e-18,
        "" => 1.0,
        _ => return None,
    })
}

/// Rounding error of a coordinate, as a share of the numbers from which it is computed.
pub(super) const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Ends of an `EDGE_CURVE`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ends {
    pub(super) start: DVec3,
    pub(super) end: DVec3,
    pub(super) whole: Whole,
}

/// When an edge on a closed curve covers the whole curve, rather than the short arc between its ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Whole {
    /// Never: two different vertices bound an arc, however short.
    Never,
    /// If its two vertices coincide up to rounding. The loop runs along a seam and back, so the edge between must be a
    /// full turn.
    BesideSeam,
    /// If its two vertices are within the file's tolerance. A line between them is the rest of the loop.
    BesideLine,
    /// If its two vertices are one corner, or as close as ends of closed curves of its size. The edge is the whole
    /// loop, and a short arc encloses nothing.
    Alone,
    /// Always: start and end are one vertex.
    OneVertex,
}

impl Whole {
    /// Whether an edge with this chord covers a whole curve. Ends of closed curves of its size are one within `near`.
    pub(super) fn holds(self, chord: f64, near: f64, rounding: f64, units: Units) -> bool {
        match self {
            Self::Never => false,
            Self::BesideSeam => chord <= rounding,
            Self::BesideLine => chord <= units.tolerance.max(rounding),
            Self::Alone => chord <= units.corner().max(near).max(rounding),
            Self::OneVertex => true,
        }
    }
}

/// Distance up to which rounding may move two points apart, if they are computed from numbers up to `size`.
pub(super) fn rounding([a, b]: [DVec3; 2], size: f64) -> f64 {
    ROUNDING * (a.abs().max(b.abs()).max_element() + size)
}
