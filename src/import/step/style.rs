//! Styled items -> colours by instance.

use super::kinds::{OCCURRENCE, is_body, is_face, is_shell, shapes};
use super::table::{Entity, Table};
use super::values::{Map, Set};
use crate::model::Colour;

/// Colours by the number of the styled instance.
#[derive(Default)]
pub(super) struct Styles {
    colours: Map<u64, Colour>,
    /// Colours of single occurrences, by the occurrence or its relationship.
    pub(super) by_occurrence: Map<u64, Colour>,
    /// Number of overrides for a path of several occurrences, which an instance table cannot express.
    pub(super) along_paths: usize,
}

impl Styles {
    pub(super) fn read(table: &Table) -> Self {
        let mut styles = Self::default();
        let mut known = Map::default();
        let mut overridden = Set::default();
        let occurrences = occurrences(table);
        for styled in table.of_types(|i| i.types().any(|name| name.ends_with("STYLED_ITEM"))) {
            let fields = styled.fields("STYLED_ITEM", 1);
            let (Ok(list), Some(item)) = (fields.links(0), fields.optional(1)) else { continue };
            let is_whole = table.find(item).is_some_and(|i| !is_face(i));
            let mut colour = None;
            for style in list.into_iter().filter_map(|style| table.find(style)) {
                let Some(found) = surface_colour(table, style, 0, &mut known) else { continue };
                let context = style.fields("PRESENTATION_STYLE_BY_CONTEXT", 1).optional(0);
                match context.and_then(|context| occurrences.get(&context)) {
                    Some(occurrence) if is_whole => styles.paint(*occurrence, found),
                    // Faces have one colour in all occurrences.
                    _ => colour = colour.or(Some(found)),
                }
            }
            let Some(colour) = colour else { continue };
            if styled.is("CONTEXT_DEPENDENT_OVER_RIDING_STYLED_ITEM") {
                let own = styled.fields("CONTEXT_DEPENDENT_OVER_RIDING_STYLED_ITEM", 4);
                let contexts: Vec<u64> = own.links(0).map(Iterator::collect).unwrap_or_default();
                match contexts[..] {
                    [context] if is_whole => styles.paint(context, colour),
                    _ => styles.along_paths += 1,
                }
            } else if styled.is("OVER_RIDING_STYLED_ITEM") {
                styles.colours.insert(item, colour);
                overridden.insert(item);
            } else if !overridden.contains(&item) {
                styles.colours.insert(item, colour);
            }
        }
        styles
    }

    /// Colours an occurrence. An instance table has one colour for all of it.
    fn paint(&mut self, occurrence: u64, colour: Colour) {
        if *self.by_occurrence.entry(occurrence).or_insert(colour) != colour {
            self.along_paths += 1;
        }
    }

    pub(super) fn of(&self, id: u64) -> Option<Colour> {
        self.colours.get(&id).copied()
    }
}

/// The occurrences whose shape a representation defines, by the representation: what styles name as their context.
fn occurrences(table: &Table) -> Map<u64, u64> {
    let mut found = Map::default();
    if table.of_types(|i| i.is("PRESENTATION_STYLE_BY_CONTEXT")).next().is_none() {
        return found;
    }
    let is_occurrence = |id: u64| table.find(id).is_some_and(|i| i.is(OCCURRENCE));
    found.extend(shapes(table).filter(|(defined, _)| is_occurrence(*defined)).map(|(defined, shape)| (shape, defined)));
    found
}

/// Number of bodies, shells and faces that the file hides: by themselves, their layer or their representation.
pub(super) fn hidden(table: &Table) -> usize {
    let lists = table.of_types(|i| i.is("INVISIBILITY")).filter_map(|i| i.fields("INVISIBILITY", 0).links(0).ok());
    let mut open: Vec<u64> = lists.flatten().collect();
    let (mut seen, mut count) = (Set::default(), 0);
    while let Some(id) = open.pop() {
        let Some(item) = table.find(id).filter(|_| seen.insert(id)) else { continue };
        if is_body(item) || is_shell(item) || is_face(item) {
            count += 1;
        } else if item.is("PRESENTATION_LAYER_ASSIGNMENT") {
            open.extend(item.fields("PRESENTATION_LAYER_ASSIGNMENT", 0).links(2).into_iter().flatten());
        } else if item.is("MAPPED_ITEM") {
            let map = item.fields("MAPPED_ITEM", 1).optional(0).and_then(|map| table.find(map));
            open.extend(map.and_then(|map| map.fields("REPRESENTATION_MAP", 0).optional(1)));
        } else if item.types().any(|name| name.ends_with("STYLED_ITEM")) {
            open.extend(item.fields("STYLED_ITEM", 1).optional(1));
        } else if item.types().any(|name| name.ends_with("REPRESENTATION")) {
            open.extend(item.fields("REPRESENTATION", 0).links(1).into_iter().flatten());
        }
    }
    count
}

/// Maximum length of the chain from a style assignment to a surface's colour.
const MAX_CHAIN: usize = 10;

/// The surface colour to which a presentation style leads. Ignores styles of curves and points.
///
/// `known` caches results: styles share references, which may fan out without bound.
fn surface_colour(
    table: &Table,
    instance: Entity<'_>,
    depth: usize,
    known: &mut Map<u64, Option<Colour>>,
) -> Option<Colour> {
    if let Some(found) = known.get(&instance.id) {
        return *found;
    }
    // References back to this instance find nothing until it is known.
    known.insert(instance.id, None);
    let found = follow(table, instance, depth, known);
    known.insert(instance.id, found);
    found
}

fn follow(table: &Table, instance: Entity<'_>, depth: usize, known: &mut Map<u64, Option<Colour>>) -> Option<Colour> {
    const SKIPPED: [&str; 5] =
        ["CURVE_STYLE", "POINT_STYLE", "TEXT_STYLE", "SURFACE_STYLE_BOUNDARY", "SURFACE_STYLE_PARAMETER_LINE"];
    if depth > MAX_CHAIN || instance.is_any(SKIPPED) {
        return None;
    }
    if instance.is("COLOUR_RGB") {
        let own = instance.fields("COLOUR_RGB", 1);
        #[allow(clippy::cast_possible_truncation, reason = "colours are single precision")]
        let channel = |i| own.real(i).ok().map(|value: f64| value.clamp(0.0, 1.0) as f32);
        return Some([channel(0)?, channel(1)?, channel(2)?, 1.0]);
    }
    if instance.is("DRAUGHTING_PRE_DEFINED_COLOUR") || instance.is("PRE_DEFINED_COLOUR") {
        return named(instance.label());
    }
    let mut colour: Option<Colour> = None;
    let mut opacity = None;
    // A face has one colour: that of its positive side, if the file states one.
    let is_behind = |next: Entity<'_>| next.fields("SURFACE_STYLE_USAGE", 0).keyword(0) == "NEGATIVE";
    let mut next: Vec<Entity<'_>> = Vec::new();
    instance.references(&mut |id| next.extend(table.find(id)));
    next.sort_by_key(|next| next.is("SURFACE_STYLE_USAGE") && is_behind(*next));
    for next in next {
        if next.is("SURFACE_STYLE_TRANSPARENT") {
            let transparency = next.fields("SURFACE_STYLE_TRANSPARENT", 0).real(0).unwrap_or(0.0);
            #[allow(clippy::cast_possible_truncation, reason = "colours are single precision")]
            let value = (1.0 - transparency.clamp(0.0, 1.0)) as f32;
            opacity = Some(value);
        } else if colour.is_none() || next.is("SURFACE_STYLE_RENDERING_WITH_PROPERTIES") {
            let found = surface_colour(table, next, depth + 1, known);
            if let (Some(new), Some([.., old])) = (found, colour) {
                // A rendering style next to a fill style adds its opacity.
                opacity = Some(new[3].min(old));
            }
            colour = colour.or(found);
        }
    }
    colour.map(|[r, g, b, a]: Colour| [r, g, b, opacity.unwrap_or(a)])
}

/// Named colours of ISO 10303-46.
fn named(name: &str) -> Option<Colour> {
    Some(match name.to_ascii_lowercase().as_str() {
        "red" => [1.0, 0.0, 0.0, 1.0],
        "green" => [0.0, 1.0, 0.0, 1.0],
        "blue" => [0.0, 0.0, 1.0, 1.0],
        "yellow" => [1.0, 1.0, 0.0, 1.0],
        "magenta" => [1.0, 0.0, 1.0, 1.0],
        "cyan" => [0.0, 1.0, 1.0, 1.0],
        "black" => [0.0, 0.0, 0.0, 1.0],
        "white" => [1.0, 1.0, 1.0, 1.0],
        _ => return None,
    })
}
