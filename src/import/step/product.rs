//! Product structure -> groups of representation items, and the tree that places them.
//!
//! A group becomes one part: a product definition with all its representations, or a representation without a product.
//! Occurrences come from NEXT_ASSEMBLY_USAGE_OCCURRENCE with its context-dependent representation, from relationships
//! with a transformation of their own, and from MAPPED_ITEM.

use super::kinds::{OCCURRENCE, defined, is_body, is_shapeless, shapes};
use super::options::StepOptions;
use super::place::Geometry;
use super::style::Styles;
use super::table::{Entity, MAX_DEPTH, Read, Table, Trouble, missing};
use super::units::{Contexts, Units};
use super::values::{List, Map, Set};
use crate::model::{Colour, PlacementTrouble, Severity, StepOutcome, StepTrouble};
use glam::{DAffine3, DVec3};
use std::cell::RefCell;
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

/// Contents of one part, and the groups placed in it.
#[derive(Debug, Default)]
pub(super) struct Group {
    pub(super) name: Arc<str>,
    pub(super) representations: Vec<u64>,
    /// Single solids that replicas repeat, and the representations with their units.
    pub(super) solids: Vec<(u64, u64)>,
    pub(super) children: Vec<Child>,
    /// Whether it is a product definition.
    pub(super) product: bool,
    /// Whether another group places it.
    pub(super) placed: bool,
    /// Whether a placement of it could not be read. It must not appear elsewhere instead.
    pub(super) misplaced: bool,
}

impl Group {
    /// A point of its contents, in its own coordinates.
    pub(super) fn somewhere(&self, table: &Table, contexts: &Contexts, fit: f64) -> Option<DVec3> {
        let near = |representation: u64, id: u64| {
            Geometry::new(table, units_of(table, contexts, representation), fit).place_near(id)
        };
        let mut solids = self.solids.iter().map(|&(solid, within)| near(within, solid));
        self.representations.iter().map(|&id| near(id, id)).find_map(|place| place).or_else(|| solids.find_map(|p| p))
    }
}

/// A placement of a group in another one.
#[derive(Clone, Debug)]
pub(super) struct Child {
    pub(super) group: usize,
    /// The instance that places it.
    pub(super) entity: u64,
    pub(super) transform: DAffine3,
    pub(super) name: Arc<str>,
    pub(super) colour: Option<Colour>,
}

/// A diagnostic of an occurrence that is doubtful or lost.
pub(super) struct PlacementDiagnostic {
    pub(super) severity: Severity,
    pub(super) entity: u64,
    pub(super) what: StepOutcome,
    /// The group to place.
    pub(super) group: Option<usize>,
}

/// All groups of a file, and diagnostics of their placements.
pub(super) struct Structure {
    pub(super) groups: Vec<Group>,
    pub(super) doubts: Vec<PlacementDiagnostic>,
}

pub(super) struct StructureBuilder<'a> {
    table: &'a Table,
    contexts: &'a Contexts,
    styles: &'a Styles,
    options: &'a StepOptions,
    groups: Vec<Group>,
    /// The group of each representation.
    owner: Map<u64, usize>,
    /// Groups, each with a representation that it has.
    owned: Set<(usize, u64)>,
    /// Representations of occurrences, each with the group that a relationship places already.
    repeated: Set<(u64, usize)>,
    /// Items of the representations of all groups. A representation may belong to several products.
    visits: usize,
    /// Cached items of representations, for look-up: assemblies list a placement per child.
    items: RefCell<Map<u64, Set<u64>>>,
    doubts: Vec<PlacementDiagnostic>,
}

/// Items and context of a representation.
pub(super) fn representation<'a>(
    table: &'a Table,
    id: u64,
) -> Option<(impl Iterator<Item = u64> + use<'a>, Option<u64>)> {
    let fields = table.find(id)?.fields("REPRESENTATION", 1);
    Some((fields.links(0).ok()?, fields.optional(1)))
}

/// Units of a representation.
pub(super) fn units_of(table: &Table, contexts: &Contexts, id: u64) -> Units {
    contexts.of(representation(table, id).and_then(|(_, context)| context))
}

impl<'a> StructureBuilder<'a> {
    pub(super) fn build(
        table: &'a Table,
        contexts: &'a Contexts,
        styles: &'a Styles,
        options: &'a StepOptions,
    ) -> Structure {
        let (groups, owner, owned, repeated, visits, items, doubts) = Default::default();
        let mut builder =
            Self { table, contexts, styles, options, groups, owner, owned, repeated, visits, items, doubts };
        let relations = Relations::read(table);
        let definitions = builder.definitions(&relations);
        let owned = builder.groups.iter().enumerate();
        let owned = owned.flat_map(|(g, group)| group.representations.iter().map(move |r| (*r, g))).collect();
        builder.own_related(owned, &relations);
        builder.bare_representations(&relations);
        builder.occurrences(&definitions, &relations);
        builder.mapped_items();
        builder.replicas();
        Structure { groups: builder.groups, doubts: builder.doubts }
    }

    /// Makes a group of each product definition, with the representations that define its shape.
    fn definitions(&mut self, relations: &Relations) -> Map<u64, usize> {
        let mut definitions = Map::default();
        let mut names: Map<&str, Arc<str>> = Map::default();
        for definition in self.table.of_types(|i| i.types().any(|name| DEFINITIONS.contains(&name))) {
            definitions.insert(definition.id, self.groups.len());
            let name = self.product_name(definition);
            let name = Arc::clone(names.entry(name).or_insert_with(|| name.into()));
            self.groups.push(Group { name, product: true, ..Group::default() });
        }
        let mut of_others = Vec::new();
        for (defined, shape) in shapes(self.table) {
            match definitions.get(&defined) {
                Some(&group) => self.own(shape, group),
                None => of_others.push((defined, shape)),
            }
        }
        for link in of_others {
            self.own_for_occurrence(link, (&definitions, relations));
        }
        definitions
    }

    /// Assigns a representation of an occurrence, which maps the component, to the assembly: it says where the
    /// component is. Where a relationship says that too, the item that maps the component repeats it.
    fn own_for_occurrence(
        &mut self,
        (occurrence, shape): (u64, u64),
        (definitions, relations): (&Map<u64, usize>, &Relations),
    ) {
        let usage = self.table.find(occurrence).filter(|i| i.is(OCCURRENCE));
        let related = |k| usage.and_then(|usage| definitions.get(&usage.fields(RELATED, 0).optional(k)?).copied());
        let is_body = |item: u64| self.table.find(item).is_some_and(is_body);
        let maps_only = || representation(self.table, shape).is_some_and(|(mut items, _)| !items.any(is_body));
        let Some(parent) = related(3).filter(|_| !self.owner.contains_key(&shape) && maps_only()) else { return };
        self.own(shape, parent);
        if let Some(child) = related(4).filter(|_| relations.placements.contains_key(&occurrence)) {
            self.repeated.insert((shape, child));
        }
    }

    fn product_name(&self, definition: Entity<'a>) -> &'a str {
        let product = || {
            let formation = definition.fields("PRODUCT_DEFINITION", 0).optional(2)?;
            let product = self.table.find(formation)?.fields("PRODUCT_DEFINITION_FORMATION", 0).optional(2)?;
            let fields = self.table.find(product)?.fields("PRODUCT", 0);
            Some(if fields.text(1).is_empty() { fields.text(0) } else { fields.text(1) })
        };
        product().unwrap_or_default()
    }

    /// Whether to skip a representation: supplemental geometry, unless the options include it.
    fn is_left_out(&self, representation: u64) -> bool {
        !self.options.supplemental && self.table.find(representation).is_some_and(is_supplemental)
    }

    fn own(&mut self, representation: u64, group: usize) {
        if self.is_left_out(representation) {
            return;
        }
        self.owner.entry(representation).or_insert(group);
        if !self.owned.insert((group, representation)) {
            return;
        }
        let shape = self.table.find(representation);
        let items = shape.map_or(0, |i| i.fields("REPRESENTATION", 1).list(0).map_or(0, List::len));
        let (before, limit) = (self.visits, self.table.budget.max_visits());
        self.visits = before.saturating_add(1 + items);
        if self.visits <= limit {
            self.groups[group].representations.push(representation);
        } else if before <= limit {
            let trouble = StepTrouble::TooManyVisits { what: "items of representations that products share", limit };
            let what = StepOutcome::LeftOut(trouble);
            let entity = representation;
            self.doubts.push(PlacementDiagnostic { severity: Severity::Error, entity, what, group: None });
        }
    }

    /// Assigns representations that are related to those of `queue` to the groups that own these.
    fn own_related(&mut self, mut queue: Vec<(u64, usize)>, relations: &Relations) {
        while let Some((from, group)) = queue.pop() {
            for to in relations.equal.get(&from).into_iter().flatten() {
                if !self.owner.contains_key(to) && !self.is_left_out(*to) {
                    self.own(*to, group);
                    queue.push((*to, group));
                }
            }
        }
    }

    /// Makes groups of representations without a product that have bodies or place others.
    fn bare_representations(&mut self, relations: &Relations) {
        let bare: Vec<u64> = self
            .table
            .of_types(|i| {
                i.types().any(|name| name.ends_with("REPRESENTATION"))
                    && !i.types().any(|name| WITHOUT_SHAPE.contains(&name))
            })
            .filter(|i| !self.owner.contains_key(&i.id) && !self.is_left_out(i.id) && self.holds_shape(i.id))
            .map(|i| i.id)
            .collect();
        for id in bare {
            if self.owner.contains_key(&id) {
                continue;
            }
            let group = self.groups.len();
            let name = self.table.find(id).map(|i| i.label().into()).unwrap_or_default();
            self.groups.push(Group { name, ..Group::default() });
            self.own(id, group);
            self.own_related(vec![(id, group)], relations);
        }
    }

    fn holds_shape(&self, id: u64) -> bool {
        let of_shape =
            self.table.find(id).is_some_and(|i| i.types().any(|name| name.ends_with("SHAPE_REPRESENTATION")));
        let holds = |item: u64| match self.table.find(item) {
            Some(i) if is_body(i) || i.is("MAPPED_ITEM") || i.is("SOLID_REPLICA") => true,
            // Unknown and missing items are reported when they are gathered.
            item => of_shape && item.is_none_or(|i| !is_shapeless(i)),
        };
        representation(self.table, id).is_some_and(|(mut items, _)| items.any(holds))
    }

    fn geometry(&self, representation_id: u64) -> Geometry<'a> {
        let units = units_of(self.table, self.contexts, representation_id);
        Geometry::new(self.table, units, self.options.fit_tolerance)
    }

    /// Places usage occurrences by their relationships.
    fn occurrences(&mut self, definitions: &Map<u64, usize>, relations: &Relations) {
        let mut used: Set<u64> = relations.placements.values().map(|&(relation, _)| relation).collect();
        let (mut mapped, mut unnamed) = (None, None);
        for usage in self.table.of_types(|i| i.is(OCCURRENCE)) {
            let own = usage.fields(RELATED, 0);
            let (Some(parent), Some(child)) = (own.optional(3), own.optional(4)) else { continue };
            let (Some(&parent), Some(&child)) = (definitions.get(&parent), definitions.get(&child)) else {
                self.lose(usage.id, None, &Trouble::new(usage.id, PlacementTrouble::NoDefinition));
                continue;
            };
            let placement = relations.placements.get(&usage.id).copied();
            let relation = match placement {
                Some((relation, _)) => Some(relation).filter(|id| relations.moved.contains_key(id)),
                // The assembly's shape places it.
                None if take(mapped.get_or_insert_with(|| self.mapped_pairs()), (parent, child)).is_some() => continue,
                // As below, a writer may swap the two.
                None => {
                    let unnamed = unnamed.get_or_insert_with(|| self.unnamed(relations, &used));
                    take(unnamed, (parent, child)).or_else(|| take(unnamed, (child, parent)))
                }
            };
            used.extend(relation);
            let transform = match relation.map(|relation| self.placed_by(relations, relation, parent, child)) {
                Some(Ok(transform)) => transform,
                Some(Err(trouble)) => {
                    self.lose(usage.id, Some(child), &trouble);
                    continue;
                }
                // No transformation is stated.
                None => {
                    let (severity, what) = (Severity::Warning, StepOutcome::AtOrigin);
                    self.doubts.push(PlacementDiagnostic { severity, entity: usage.id, what, group: Some(child) });
                    DAffine3::IDENTITY
                }
            };
            let name = [own.text(1), own.text(0)].into_iter().find(|text| !text.is_empty()).unwrap_or_default();
            let colour = placement.and_then(|(relation, shape)| {
                [relation, shape, usage.id].into_iter().find_map(|id| self.styles.by_occurrence.get(&id).copied())
            });
            self.place(parent, Child { group: child, entity: usage.id, transform, name: name.into(), colour });
        }
        // Relationships with a transformation that no occurrence uses place representations directly. Where occurrences
        // place the same group, they only repeat one.
        let pairs =
            self.groups.iter().enumerate().flat_map(|(g, group)| group.children.iter().map(move |c| (g, c.group)));
        let known: Set<(usize, usize)> = pairs.collect();
        let mut placed: Set<(usize, usize, [u64; 12])> = Set::default();
        for relation in relations.moved.keys().filter(|id| !used.contains(id)).copied().collect::<Vec<_>>() {
            let Some(&(first, second, _)) = relations.moved.get(&relation) else { continue };
            let (Some(&child), Some(&parent)) = (self.owner.get(&first), self.owner.get(&second)) else { continue };
            if child == parent || known.contains(&(parent, child)) {
                continue;
            }
            match self.placed_by(relations, relation, parent, child) {
                Ok(transform) => {
                    // The sum turns a negative zero into a positive one.
                    if placed.insert((parent, child, transform.to_cols_array().map(|value| (value + 0.0).to_bits()))) {
                        let name = Arc::default();
                        self.place(parent, Child { group: child, entity: relation, transform, name, colour: None });
                    }
                }
                Err(trouble) => self.lose(relation, Some(child), &trouble),
            }
        }
    }

    /// Leaves out the group that `entity` places: its place is unknown, and any other would be wrong.
    fn lose(&mut self, entity: u64, group: Option<usize>, trouble: &Trouble) {
        if let Some(group) = group {
            self.groups[group].placed = true;
            self.groups[group].misplaced = true;
        }
        let what = StepOutcome::OccurrenceLeftOut(trouble.seen_from(entity));
        self.doubts.push(PlacementDiagnostic { severity: Severity::Error, entity, what, group });
    }

    fn place(&mut self, parent: usize, child: Child) {
        self.groups[child.group].placed = true;
        self.groups[parent].children.push(child);
    }

    /// The motion of a relationship with a transformation, from the child's coordinates to the parent's.
    fn placed_by(&self, relations: &Relations, relation: u64, parent: usize, child: usize) -> Read<DAffine3> {
        let &(first, second, operator) = relations.moved.get(&relation).ok_or_else(|| {
            Trouble::new(relation, missing("an occurrence placed by a relationship", "transformation"))
        })?;
        // The component should come first and the assembly second, but some writers swap them.
        let has = |group: usize, id: u64| self.owned.contains(&(group, id));
        let swapped = has(parent, first) && has(child, second) && !(has(child, first) && has(parent, second));
        let transformation = self.table.get(operator)?;
        if !transformation.is("ITEM_DEFINED_TRANSFORMATION") {
            let motion = self.geometry(second).motion(operator)?;
            return if swapped { invert(motion, operator) } else { Ok(motion) };
        }
        let own = transformation.fields("ITEM_DEFINED_TRANSFORMATION", 2);
        let (mut from, mut to) = (own.reference(0)?, own.reference(1)?);
        let lists = |id: u64, item: u64| {
            let read = || representation(self.table, id).map(|(items, _)| items.collect()).unwrap_or_default();
            self.items.borrow_mut().entry(id).or_insert_with(read).contains(&item)
        };
        if lists(second, from) && lists(first, to) && !(lists(first, from) && lists(second, to)) {
            (from, to) = (to, from);
        }
        let (from, to) = (self.geometry(first).motion(from)?, self.geometry(second).motion(to)?);
        let motion = to * invert(from, operator)?;
        if swapped { invert(motion, operator) } else { Ok(motion) }
    }

    /// Items of a type in a group's representations, each with its representation.
    fn items_of(&self, group: usize, kind: &str) -> Vec<(u64, u64)> {
        let is_kind = |item: &u64| self.table.find(*item).is_some_and(|i| i.is(kind));
        let mut found = Vec::new();
        for &id in &self.groups[group].representations {
            let Some((items, _)) = representation(self.table, id) else { continue };
            found.extend(items.filter(is_kind).map(|item| (item, id)));
        }
        found
    }

    /// The mapped items of a group, and what they map. Leaves out those that repeat an occurrence.
    fn mapped_of(&self, parent: usize) -> Vec<(u64, Mapped)> {
        let mut found = Vec::new();
        for (item, id) in self.items_of(parent, "MAPPED_ITEM") {
            let mapped = self.mapped(item, id);
            if !mapped.as_ref().is_ok_and(|(child, _)| self.repeated.contains(&(id, *child))) {
                found.push((item, mapped));
            }
        }
        found
    }

    fn mapped_items(&mut self) {
        for parent in 0..self.groups.len() {
            for (item, mapped) in self.mapped_of(parent) {
                match mapped {
                    Ok((group, _)) if group == parent => {
                        let what = StepTrouble::RefersToItself { what: "a representation that it maps" };
                        self.lose(item, None, &Trouble::new(item, what));
                    }
                    Ok((_, Ok(child))) => self.place(parent, child),
                    Ok((group, Err(trouble))) => self.lose(item, Some(group), &trouble),
                    Err(_) if self.maps_supplemental(item) => {}
                    Err(trouble) => self.lose(item, None, &trouble),
                }
            }
        }
    }

    /// Items that map a group into another one.
    fn mapped_pairs(&self) -> Pairs {
        let mut pairs = Pairs::default();
        for parent in 0..self.groups.len() {
            for (item, mapped) in self.mapped_of(parent) {
                mapped.into_iter().for_each(|(child, _)| pairs.entry((parent, child)).or_default().push_back(item));
            }
        }
        pairs
    }

    /// Relationships with a transformation that no occurrence names.
    fn unnamed(&self, relations: &Relations, used: &Set<u64>) -> Pairs {
        let mut pairs = Pairs::default();
        for (&relation, (first, second, _)) in relations.moved.iter().filter(|(id, _)| !used.contains(id)) {
            if let (Some(&child), Some(&parent)) = (self.owner.get(first), self.owner.get(second)) {
                pairs.entry((parent, child)).or_default().push_back(relation);
            }
        }
        pairs
    }

    /// Whether a `MAPPED_ITEM` places a skipped representation, which is reported itself.
    fn maps_supplemental(&self, item: u64) -> bool {
        let source = || {
            let map = self.table.find(item)?.fields("MAPPED_ITEM", 1).optional(0)?;
            self.table.find(map)?.fields("REPRESENTATION_MAP", 0).optional(1)
        };
        source().is_some_and(|representation| self.is_left_out(representation))
    }

    /// Places replicas of solids: the solid becomes a part of its own.
    fn replicas(&mut self) {
        let mut of_solid: Map<u64, usize> = Map::default();
        for parent in 0..self.groups.len() {
            for (item, id) in self.items_of(parent, "SOLID_REPLICA") {
                let (solid, transform) = match self.replicated(item, id) {
                    Ok(found) => found,
                    Err(trouble) => {
                        self.lose(item, None, &trouble);
                        continue;
                    }
                };
                let group = *of_solid.entry(solid).or_insert_with(|| {
                    let name = self.table.find(solid).map(|i| i.label().into()).unwrap_or_default();
                    self.groups.push(Group { name, solids: vec![(solid, id)], ..Group::default() });
                    self.groups.len() - 1
                });
                match transform {
                    Ok(transform) => {
                        let name = self.table.find(item).map(|i| i.label().into()).unwrap_or_default();
                        let colour = self.styles.of(item);
                        self.place(parent, Child { group, entity: item, transform, name, colour });
                    }
                    Err(trouble) => self.lose(item, Some(group), &trouble),
                }
            }
        }
    }

    /// The solid that a replica (of a replica, …) repeats, and its transformation.
    fn replicated(&self, item: u64, within: u64) -> Read<(u64, Read<DAffine3>)> {
        let (mut at, mut transform) = (item, Ok(DAffine3::IDENTITY));
        for _ in 0..MAX_REPLICAS {
            let solid = self.table.get(at)?;
            if !solid.is("SOLID_REPLICA") {
                return Ok((at, transform));
            }
            let own = solid.fields("SOLID_REPLICA", 1);
            let own_motion = own.reference(1).and_then(|id| self.geometry(within).motion(id));
            transform = transform.and_then(|all| Ok(all * own_motion?));
            at = own.reference(0)?;
        }
        Err(Trouble::new(item, StepTrouble::TooDeep { what: "replicas of solids" }))
    }

    fn mapped(&self, item: u64, within: u64) -> Mapped {
        let instance = self.table.get(item)?;
        let own = instance.fields("MAPPED_ITEM", 1);
        let map = self.table.get(own.reference(0)?)?.fields("REPRESENTATION_MAP", 0);
        let (origin, source) = (map.reference(0)?, map.reference(1)?);
        let group = *self
            .owner
            .get(&source)
            .ok_or_else(|| Trouble::new(item, PlacementTrouble::NoBodies { representation: source }))?;
        let transform = || {
            let target = self.geometry(within).motion(own.reference(1)?)?;
            Ok(target * invert(self.geometry(source).motion(origin)?, item)?)
        };
        let colour = self.styles.by_occurrence.get(&item).copied().or(self.styles.of(item));
        let name = instance.label().into();
        Ok((group, transform().map(|transform| Child { group, entity: item, transform, name, colour })))
    }
}

/// The group that an item maps, and its placement.
type Mapped = Read<(usize, Read<Child>)>;

/// Instances that place a group, second, in another one, in order of their numbers.
type Pairs = Map<(usize, usize), VecDeque<u64>>;

/// Takes the first instance of a pair.
fn take(pairs: &mut Pairs, pair: (usize, usize)) -> Option<u64> {
    pairs.get_mut(&pair)?.pop_front()
}

/// Has the assembly and the component of an occurrence.
const RELATED: &str = "PRODUCT_DEFINITION_RELATIONSHIP";
const DEFINITIONS: [&str; 2] = ["PRODUCT_DEFINITION", "PRODUCT_DEFINITION_WITH_ASSOCIATED_DOCUMENTS"];

/// Instances whose type ends like that of a representation but that define no shape: what presents shapes, the
/// parameters of curves on surfaces (a file has one per pcurve), and links between properties and representations.
const WITHOUT_SHAPE: [&str; 10] = [
    "DEFINITIONAL_REPRESENTATION",
    "SHAPE_DEFINITION_REPRESENTATION",
    "PROPERTY_DEFINITION_REPRESENTATION",
    "CONTEXT_DEPENDENT_SHAPE_REPRESENTATION",
    "MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION",
    "MECHANICAL_DESIGN_SHADED_PRESENTATION_REPRESENTATION",
    "MECHANICAL_DESIGN_PRESENTATION_REPRESENTATION_WITH_DRAUGHTING",
    "DRAUGHTING_MODEL",
    "PRESENTATION_REPRESENTATION",
    "PRESENTED_ITEM_REPRESENTATION",
];

fn invert(motion: DAffine3, id: u64) -> Read<DAffine3> {
    let inverse = motion.inverse();
    if inverse.is_finite() { Ok(inverse) } else { Err(Trouble::new(id, PlacementTrouble::NotInvertible)) }
}

/// Relationships between representations.
struct Relations {
    /// Pairs of representations of one thing in the same coordinates, in both directions.
    equal: Map<u64, Vec<u64>>,
    /// Relationships with a transformation, by number: first and second representation, transformation.
    moved: BTreeMap<u64, (u64, u64, u64)>,
    /// Occurrences, each with the relationship that places it and the instance that says so.
    placements: Map<u64, (u64, u64)>,
}

impl Relations {
    fn read(table: &Table) -> Self {
        let mut relations = Self { equal: Map::default(), moved: BTreeMap::new(), placements: Map::default() };
        for shape in table.of_types(|i| i.is("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION")) {
            let own = shape.fields("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION", 0);
            let (Some(relation), Some(property)) = (own.optional(0), own.optional(1)) else { continue };
            if let Some(occurrence) = defined(table, property) {
                relations.placements.insert(occurrence, (relation, shape.id));
            }
        }
        for relation in table.of_types(|i| i.is_any(["SHAPE_REPRESENTATION_RELATIONSHIP", MOVED, SUPPLEMENTS])) {
            let own = relation.fields("REPRESENTATION_RELATIONSHIP", 0);
            let (Some(first), Some(second)) = (own.optional(2), own.optional(3)) else { continue };
            if relation.is(MOVED) {
                if let Some(operator) = relation.fields(MOVED, 4).optional(0) {
                    relations.moved.insert(relation.id, (first, second, operator));
                }
            } else {
                relations.equal.entry(first).or_default().push(second);
                relations.equal.entry(second).or_default().push(first);
            }
        }
        relations
    }
}

/// Relates supplemental geometry to its shape.
const SUPPLEMENTS: &str = "CONSTRUCTIVE_GEOMETRY_REPRESENTATION_RELATIONSHIP";

/// Whether an instance is a representation of supplemental geometry: construction aids, not the shape.
pub(super) fn is_supplemental(instance: Entity<'_>) -> bool {
    instance.is("CONSTRUCTIVE_GEOMETRY_REPRESENTATION")
}

const MOVED: &str = "REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION";

/// Maximum length of a chain of replicas.
const MAX_REPLICAS: usize = 1000;

/// Maximum nesting of assemblies.
pub(super) const MAX_ASSEMBLY_DEPTH: usize = 4 * MAX_DEPTH;
