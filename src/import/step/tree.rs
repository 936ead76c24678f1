//! The assembly tree -> parts to read, and instances of them.

use super::contents::PartContents;
use super::kinds::{is_endless, is_shapeless};
use super::options::StepOptions;
use super::place::Geometry;
use super::product::{self, Child, Group, MAX_ASSEMBLY_DEPTH, PlacementDiagnostic, Structure, is_supplemental};
use super::shells::Gather;
use super::style::Styles;
use super::table::Table;
use super::units::Contexts;
use super::values::Map;
use crate::model::{Assembly, Colour, Diagnostic, Instance, PartId, Severity, StepOutcome};
use glam::{DAffine3, DVec3};
use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;

/// A part to read.
pub(super) struct PlannedPart {
    pub(super) name: String,
    pub(super) gathered: PartContents,
    pub(super) colour: Option<Colour>,
}

/// Memory of an occurrence, bytes: its instance or assembly here, and its instance in the scene that prepare makes.
const BYTES_PER_INSTANCE: usize = 2 * size_of::<Instance>() + 64;

/// The assembly tree while it is expanded into instances.
pub(super) struct Tree<'a> {
    table: &'a Table,
    contexts: &'a Contexts,
    options: &'a StepOptions,
    groups: Vec<Group>,
    pub(super) gather: Gather<'a>,
    /// For each group: `None` if not yet visited, `Some(None)` without geometry, else its part.
    parts: Vec<Option<Option<PartId>>>,
    pub(super) planned: Vec<PlannedPart>,
    pub(super) instances: Vec<Instance>,
    /// Number of visited occurrences, assemblies included.
    pub(super) visits: u64,
    /// The instance that places the first occurrence beyond the limit for a file of its length.
    pub(super) beyond: Option<u64>,
    /// Groups from the root to the current one.
    path: Vec<usize>,
    /// Visited groups.
    reached: HashSet<usize>,
    /// Points of the groups that diagnostics name, each found once.
    somewhere: Map<usize, Option<DVec3>>,
    /// Occurrences left out as cyclic, each reported once.
    cyclic: HashSet<(usize, usize)>,
    /// Whether a product has neither a shape nor components.
    pub(super) has_bare: bool,
    pub(super) diagnostics: Vec<Diagnostic>,
}

impl<'a> Tree<'a> {
    pub(super) fn new(
        table: &'a Table,
        contexts: &'a Contexts,
        styles: &'a Styles,
        options: &'a StepOptions,
        structure: Structure,
    ) -> Self {
        let mut tree = Self {
            table,
            contexts,
            options,
            parts: vec![None; structure.groups.len()],
            groups: structure.groups,
            gather: Gather::new(table, styles, options.supplemental),
            planned: Vec::new(),
            instances: Vec::new(),
            visits: 0,
            beyond: None,
            path: Vec::new(),
            reached: HashSet::new(),
            somewhere: Map::default(),
            cyclic: HashSet::new(),
            has_bare: false,
            diagnostics: Vec::new(),
        };
        for PlacementDiagnostic { severity, entity, what, group } in structure.doubts {
            let place = group.and_then(|group| tree.somewhere(group));
            tree.say(severity, entity, place, what);
        }
        tree
    }

    /// Takes groups that could not be placed, with their children, so that they do not become leftovers.
    fn withhold(&mut self) {
        let mut queue: Vec<usize> = (0..self.groups.len()).filter(|g| self.groups[*g].misplaced).collect();
        while let Some(group) = queue.pop() {
            if self.reached.insert(group) {
                let mut withheld = PartContents::default();
                self.gather_group(group, &mut withheld);
                queue.extend(self.groups[group].children.iter().map(|child| child.group));
            }
        }
    }

    fn say(&mut self, severity: Severity, entity: u64, place: Option<DVec3>, what: StepOutcome) {
        self.diagnostics.push(Diagnostic { entity, place, ..Diagnostic::new(severity, what) });
    }

    /// A point of a group, in its own coordinates.
    fn somewhere(&mut self, group: usize) -> Option<DVec3> {
        let find = || self.groups[group].somewhere(self.table, self.contexts, self.options.fit_tolerance);
        *self.somewhere.entry(group).or_insert_with(find)
    }

    pub(super) fn expand(&mut self) {
        // Roots are unused products, then representations without a product. The rest is in cycles.
        let mut roots: Vec<usize> = (0..self.groups.len()).filter(|g| !self.groups[*g].placed).collect();
        roots.sort_by_key(|g| !self.groups[*g].product);
        self.walk_roots(roots.into_iter());
        self.withhold();
        self.walk_roots(0..self.groups.len());
        self.gather.take_repeats();
        self.leave_out_supplemental();
        let shown = self.planned.iter().flat_map(|plan| plan.gathered.faces());
        let left = self.gather.leftovers(self.contexts.first, shown);
        if !left.is_empty() {
            let part = PartId::new(self.planned.len());
            self.planned.push(PlannedPart { name: String::new(), gathered: left, colour: None });
            self.instances.push(Instance::new(part, DAffine3::IDENTITY));
        }
        for (trouble, units) in std::mem::take(&mut self.gather.unread) {
            let place = Geometry::new(self.table, units, self.options.fit_tolerance).place_near(trouble.entity);
            self.say(Severity::Error, trouble.entity, place, StepOutcome::LeftOut(*trouble.what));
        }
        if let Some((shell, faces)) = self.gather.again {
            self.say(Severity::Note, shell, None, StepOutcome::FacesAgain { faces });
        }
        if let Some(first) = self.gather.copies.first {
            let faces = self.gather.copies.faces.len();
            self.say(Severity::Note, first, None, StepOutcome::FacesCopied { faces });
        }
        self.tell_aside();
    }

    /// Takes the items of skipped supplemental representations, so that they do not become leftovers.
    fn leave_out_supplemental(&mut self) {
        if self.options.supplemental {
            return;
        }
        for supplemental in self.table.of_types(is_supplemental) {
            let Some((items, _)) = product::representation(self.table, supplemental.id) else { continue };
            self.gather.leave_out(supplemental.id, items);
        }
    }

    /// Reports items that do not belong to a shape: counts per representation, and each supplemental surface that
    /// cannot be meshed.
    fn tell_aside(&mut self) {
        for (representation, items) in std::mem::take(&mut self.gather.aside) {
            let mut counts: BTreeMap<String, usize> = BTreeMap::new();
            for (item, keyword) in items {
                if self.options.supplemental && self.table.find(item).is_some_and(is_endless) {
                    self.say(Severity::Warning, item, None, StepOutcome::Endless { keyword });
                } else {
                    *counts.entry(keyword).or_default() += 1;
                }
            }
            if counts.is_empty() {
                continue;
            }
            let what = StepOutcome::Supplemental { left_out: !self.options.supplemental, counts };
            self.say(Severity::Note, representation, None, what);
        }
    }

    fn walk_roots(&mut self, groups: impl Iterator<Item = usize>) {
        for group in groups {
            if !self.reached.contains(&group) {
                let name = self.groups[group].name.clone();
                let root = Child { group, entity: 0, transform: DAffine3::IDENTITY, name, colour: None };
                self.walk(root, None);
            }
        }
    }

    /// Visits an occurrence, placed in the world, and all in it. `within` is the assembly that it stands in.
    fn walk(&mut self, occurrence: Child, within: Option<&Arc<Assembly>>) {
        if self.beyond.is_some() {
            return;
        }
        let Child { group, entity, transform, name, colour } = occurrence;
        self.visits += 1;
        let budget = &self.table.budget;
        self.beyond = (self.visits > budget.max_occurrences()).then_some(entity);
        if self.visits > budget.max_occurrences().min(self.options.max_instances) || !budget.spend(BYTES_PER_INSTANCE) {
            return;
        }
        self.reached.insert(group);
        let is_assembly = !self.groups[group].children.is_empty();
        let own = is_assembly.then(|| Arc::new(Assembly { name: name.clone(), parent: within.cloned() }));
        let within = own.as_ref().or(within);
        match self.part(group) {
            Some(part) => self.instances.push(Instance { part, transform, colour, name, assembly: within.cloned() }),
            None => self.has_bare |= self.groups[group].product && !is_assembly,
        }
        self.path.push(group);
        for child in 0..self.groups[group].children.len() {
            let child = self.groups[group].children[child].clone();
            if self.path.contains(&child.group) || self.path.len() >= MAX_ASSEMBLY_DEPTH {
                if self.cyclic.insert((group, child.group)) {
                    let what = StepOutcome::AssemblyCycle { assembly: self.groups[group].name.to_string() };
                    let place = self.somewhere(child.group);
                    self.say(Severity::Error, child.entity, place, what);
                }
                continue;
            }
            let name = if child.name.is_empty() { self.groups[child.group].name.clone() } else { child.name };
            let (transform, colour) = (transform * child.transform, colour.or(child.colour));
            self.walk(Child { transform, name, colour, ..child }, within);
        }
        self.path.pop();
    }

    /// The part of a group's own items, shared by all its occurrences.
    fn part(&mut self, group: usize) -> Option<PartId> {
        if let Some(known) = self.parts[group] {
            return known;
        }
        let mut gathered = PartContents::default();
        let colour = self.gather_group(group, &mut gathered);
        self.gather.drop_sheets(&mut gathered);
        let repeated = self.gather.repeated(&mut gathered);
        if repeated > 0 {
            let what = StepOutcome::Repeated { items: repeated, name: self.groups[group].name.to_string() };
            let entity = self.groups[group].representations.first().copied().unwrap_or(0);
            let place = self.somewhere(group);
            self.say(Severity::Note, entity, place, what);
        }
        let part = (!gathered.is_empty()).then(|| PartId::new(self.planned.len()));
        if part.is_some() {
            self.table.budget.spend(self.groups[group].name.len());
            self.planned.push(PlannedPart { name: self.groups[group].name.to_string(), gathered, colour });
        }
        self.parts[group] = Some(part);
        part
    }

    /// Adds the items of a group. Returns the group's colour, if it has one.
    fn gather_group(&mut self, group: usize, gathered: &mut PartContents) -> Option<Colour> {
        let mut colour = None;
        let root = self.path.first().copied().unwrap_or(group);
        let is_shown = self.groups[group].product || self.groups[root].product;
        for id in &self.groups[group].representations {
            let Some((items, context)) = product::representation(self.table, *id) else { continue };
            let units = self.contexts.of(context);
            colour = colour.or(self.gather.styles.of(*id));
            let supplemental = self.table.find(*id).is_some_and(is_supplemental);
            self.gather.within = *id;
            for item in items {
                if supplemental && self.table.find(item).is_some_and(is_shapeless) {
                    self.gather.put_aside(item);
                    continue;
                }
                // A representation that has no product, and is not placed in one, may only repeat items of a product.
                if is_shown || !self.gather.take_if_repeated(item) {
                    self.gather.item(item, units, gathered);
                }
            }
        }
        for (item, representation) in &self.groups[group].solids {
            self.gather.within = *representation;
            let units = product::units_of(self.table, self.contexts, *representation);
            self.gather.item(*item, units, gathered);
        }
        colour
    }
}
