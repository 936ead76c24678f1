//! STEP files (ISO 10303-21 text of AP203, AP214, AP242, …) to a [`Model`]; syntax by the crate `step-io`.
//!
//! The steps are the files of this folder: `sections` passes over sections without data, `text` parses (and cuts out what
//! breaks the syntax), `table` gives typed access to instances, `units` and `place` turn numbers into millimetres and frames,
//! `curve` and `surface` read geometry, `loops`, `shells` and `part` topology, `carried` the surface of each face, `style`
//! colours, `product` the assembly.
//!
//! Rare forms, and what comes of them. What is refused is told with its number; a face keeps its number and is `lost`.
//!
//! | form | read as |
//! |---|---|
//! | `FACE`; `FACE_SURFACE` without a surface (`$`) | face in the plane of its bounds, with a warning where these are not flat; refused where they enclose no area |
//! | `SUBFACE`, `EDGE` without a curve, `VERTEX` without a point | refused |
//! | `SEAM_EDGE` | its oriented edge; which parameter curve it names does not matter |
//! | `SUBEDGE` | an edge of its own on its parent's curve; it is not joined to faces that use the parent |
//! | `POINT_ON_CURVE`, `POINT_ON_SURFACE`, `DEGENERATE_PCURVE`, `POINT_REPLICA` | points; refused beyond the ends of what they are on, and on composite curves |
//! | `CONSTRUCTIVE_GEOMETRY_REPRESENTATION`, surfaces next to shapes | left out with a note; see [`StepOptions::supplemental`] |
//! | sections `ANCHOR`, `REFERENCE`, `SIGNATURE` | passed over with a note; an instance of another file costs what uses it |
//! | several `DATA` sections | one |
//! | values `@n`, `#NAME`, `<resource>` | unset, with a warning |

mod body;
mod boundary;
mod carried;
mod conic;
mod corners;
mod csg;
mod curve;
mod derived;
mod draft;
mod loops;
mod offset;
mod part;
mod place;
mod product;
mod replica;
mod sections;
mod shells;
mod spline;
mod style;
mod surface;
mod sweep;
mod table;
mod tessellated;
mod text;
mod trimmed;
mod turned;
mod units;

use crate::model::{Colour, Diagnostic, Instance, Model, Part, PartId, Severity};
use glam::{DAffine3, DVec3};
use part::Reader;
use place::Geometry;
use product::{Builder, Doubt, Group, MAX_ASSEMBLY_DEPTH, Structure, is_supplemental};
use rayon::prelude::*;
use shells::{Gather, Gathered, is_endless, is_shapeless};
use std::collections::{BTreeMap, HashSet};
use std::fmt;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use style::Styles;
use table::Table;
use units::Contexts;

/// Limits and tolerances of reading.
#[derive(Clone, Debug, PartialEq)]
pub struct StepOptions {
    /// How far the B-spline that stands for a curve or surface without an exact form may be from it, millimetres: offsets of
    /// B-splines, curves given in the parameters of a bent surface. Default 0.001.
    pub fit_tolerance: f64,
    /// Files longer than this are refused, bytes. Default 2 GiB.
    pub max_bytes: u64,
    /// How many instances that break the syntax may be cut out before the file is given up. Each costs another pass over
    /// the text. Default 16.
    pub max_syntax_repairs: usize,
    /// Files with more instances (`#n=…`) are refused. Default 50 million.
    pub max_entities: u64,
    /// How many placed parts and assemblies an assembly tree may expand to. Default 1 million.
    pub max_instances: u64,
    /// Files that would take more memory than this are refused, bytes, at [`BYTES_PER_BYTE`] per byte of the file. Default
    /// 16 GiB.
    pub max_memory: u64,
    /// Read supplemental geometry too: the items of `CONSTRUCTIVE_GEOMETRY_REPRESENTATION`s, and surfaces that stand next to
    /// shapes. It is construction help, not part of the shape. `false` (the default) leaves it out with a note per
    /// representation. `true` reads what has bounds into the part that it belongs to; a surface without bounds gets a warning.
    pub supplemental: bool,
}

/// Memory that reading takes at the peak for each byte of the file, about.
pub const BYTES_PER_BYTE: u64 = 10;

impl StepOptions {
    /// What the fields say.
    pub const DEFAULT: Self = Self {
        fit_tolerance: 1e-3,
        max_bytes: 2 << 30,
        max_syntax_repairs: 16,
        max_entities: 50_000_000,
        max_instances: 1_000_000,
        max_memory: 16 << 30,
        supplemental: false,
    };
}

impl Default for StepOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Why a file gives no model at all.
#[derive(Debug)]
pub enum StepError {
    /// The file cannot be opened or read.
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system says.
        error: std::io::Error,
    },
    /// The file is longer than [`StepOptions::max_bytes`].
    TooLarge {
        /// Its length; of a device or pipe only what was read of it.
        bytes: u64,
        /// The limit.
        limit: u64,
    },
    /// Reading would take more memory than [`StepOptions::max_memory`].
    TooMuchMemory {
        /// About what it would take, bytes; of a device or pipe only for what was read of it.
        needed: u64,
        /// The limit, bytes.
        limit: u64,
    },
    /// The file has more instances than [`StepOptions::max_entities`].
    TooManyEntities {
        /// How many it has, to its end.
        entities: u64,
        /// The limit.
        limit: u64,
    },
    /// The assembly has more occurrences than [`StepOptions::max_instances`]; how many it has nobody counted.
    TooManyInstances {
        /// The limit.
        limit: u64,
    },
    /// The bytes are not Part 21 text.
    NotStep {
        /// What they look like, and what to do about it.
        looks_like: &'static str,
    },
    /// The syntax is broken in more places than [`StepOptions::max_syntax_repairs`], or where nothing can be cut out.
    Syntax {
        /// The parser's message, with line and column.
        message: String,
        /// How many instances had been cut out before.
        repairs: usize,
    },
}

impl fmt::Display for StepError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io { path, error } => write!(f, "cannot read {}: {error}", path.display()),
            Self::TooLarge { bytes, limit } => {
                write!(f, "the file has {bytes} bytes or more, the limit is {limit} (StepOptions::max_bytes)")
            }
            Self::TooMuchMemory { needed, limit } => write!(
                f,
                "reading the file takes about {needed} bytes of memory, the limit is {limit} (StepOptions::max_memory)"
            ),
            Self::TooManyEntities { entities, limit } => {
                write!(f, "the file has {entities} instances, the limit is {limit} (StepOptions::max_entities)")
            }
            Self::TooManyInstances { limit } => write!(
                f,
                "the assembly places more than {limit} parts and assemblies, which is the limit \
                 (StepOptions::max_instances)"
            ),
            Self::NotStep { looks_like } => write!(f, "not a STEP file but {looks_like}"),
            Self::Syntax { message, repairs } => write!(
                f,
                "{message} ({repairs} broken instances left out before it); export the file again or correct that line"
            ),
        }
    }
}

impl std::error::Error for StepError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Io { error, .. } => Some(error),
            _ => None,
        }
    }
}

/// Reads a STEP file. The model's name is the file's, without extension.
///
/// # Errors
/// As [`read`], and [`StepError::Io`] if the file cannot be read.
pub fn read_file(path: &Path, options: &StepOptions) -> Result<Model, StepError> {
    let io = |error| StepError::Io { path: path.to_owned(), error };
    let file = std::fs::File::open(path).map_err(io)?;
    let bytes = file.metadata().map_err(io)?.len();
    check_size(bytes, options)?;
    let mut text = Vec::with_capacity(usize::try_from(bytes).unwrap_or(0));
    // Devices and pipes tell no length beforehand, and may have no end.
    let most = options.max_bytes.min(options.max_memory / BYTES_PER_BYTE);
    file.take(most.saturating_add(1)).read_to_end(&mut text).map_err(io)?;
    let mut model = read(&text, options)?;
    model.name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    Ok(model)
}

fn check_size(bytes: u64, options: &StepOptions) -> Result<(), StepError> {
    if bytes > options.max_bytes {
        return Err(StepError::TooLarge { bytes, limit: options.max_bytes });
    }
    let needed = bytes.saturating_mul(BYTES_PER_BYTE);
    if needed > options.max_memory {
        return Err(StepError::TooMuchMemory { needed, limit: options.max_memory });
    }
    Ok(())
}

/// Reads the text of a STEP file.
///
/// Each product definition with geometry is one part, placed as often as the assembly says; geometry that no product owns
/// makes parts of its own, placed once. What is not understood is named in [`Model::diagnostics`] and costs nothing else: a
/// file without any face gives an empty model. Runs on the threads of the current rayon pool.
///
/// # Errors
/// If the bytes are no STEP text, break the syntax beyond repair, or exceed one of the limits of `options`.
pub fn read(bytes: &[u8], options: &StepOptions) -> Result<Model, StepError> {
    check_size(bytes.len() as u64, options)?;
    let mut diagnostics = Vec::new();
    let table = text::parse(bytes, options, &mut diagnostics)?;
    let contexts = Contexts::read(&table);
    let styles = Styles::read(&table);
    let structure = Builder::build(&table, &contexts, &styles, options);
    let mut tree = Tree::new(&table, &contexts, &styles, options, structure);
    tree.expand();
    if tree.visits > options.max_instances {
        return Err(StepError::TooManyInstances { limit: options.max_instances });
    }
    let reader = Reader { table: &table, styles: &styles, options };
    // A file may mix units; the first part's are named.
    let first = tree.planned.first().and_then(|plan| plan.gathered.units());
    let millimetres_per_unit = first.unwrap_or(contexts.first).length;
    let read: Vec<(Part, Vec<Diagnostic>)> = std::mem::take(&mut tree.planned)
        .into_par_iter()
        .map(|plan| reader.part(plan.name, &plan.gathered, plan.colour))
        .collect();
    let mut model = Model { millimetres_per_unit, ..Model::default() };
    for (part, found) in read {
        let id = Some(PartId::new(model.parts.len()));
        diagnostics.extend(found.into_iter().map(|d| Diagnostic { part: id, ..d }));
        model.parts.push(part);
    }
    model.instances = tree.instances;
    diagnostics.extend(tree.diagnostics);
    if !contexts.stated && !model.parts.is_empty() {
        let reason = "the file names no length unit; millimetres assumed".to_owned();
        diagnostics.push(of_file(reason));
    }
    if styles.along_paths > 0 {
        let reason = format!("{} colours that hold along paths of occurrences are not applied", styles.along_paths);
        diagnostics.push(of_file(reason));
    }
    let lost = diagnostics.iter().any(|d| d.severity == Severity::Error);
    if !lost && model.parts.iter().all(|part| part.faces.is_empty()) {
        let reason = format!("no faces among the file's {} instances", table.len());
        diagnostics.push(of_file(reason));
    }
    model.diagnostics = diagnostics;
    Ok(model)
}

/// A warning that concerns the file as a whole.
fn of_file(reason: String) -> Diagnostic {
    Diagnostic { severity: Severity::Warning, part: None, face: None, entity: 0, place: None, reason }
}

/// A part that will be read.
struct Plan {
    name: String,
    gathered: Gathered,
    colour: Option<Colour>,
}

/// The assembly tree while it is expanded into instances.
struct Tree<'a> {
    table: &'a Table,
    contexts: &'a Contexts,
    options: &'a StepOptions,
    groups: Vec<Group>,
    gather: Gather<'a>,
    /// For each group: not looked at yet, without geometry, or the part it makes.
    parts: Vec<Option<Option<PartId>>>,
    planned: Vec<Plan>,
    instances: Vec<Instance>,
    /// Occurrences walked through, assemblies included.
    visits: u64,
    /// Groups from the root to here.
    path: Vec<usize>,
    /// Groups that have been reached.
    reached: HashSet<usize>,
    /// Occurrences left out because they would never end, each reported once.
    cyclic: HashSet<(usize, usize)>,
    diagnostics: Vec<Diagnostic>,
}

impl<'a> Tree<'a> {
    fn new(
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
            path: Vec::new(),
            reached: HashSet::new(),
            cyclic: HashSet::new(),
            diagnostics: Vec::new(),
        };
        for Doubt { severity, trouble, group } in structure.doubts {
            let place = group.and_then(|group| tree.somewhere(group));
            tree.say(severity, trouble.entity, place, trouble.reason);
        }
        tree
    }

    /// Takes what could not be placed, with all that is placed in it, so that it does not come out as something left over.
    fn withhold(&mut self) {
        let mut queue: Vec<usize> = (0..self.groups.len()).filter(|g| self.groups[*g].misplaced).collect();
        while let Some(group) = queue.pop() {
            if self.reached.insert(group) {
                let mut withheld = Gathered::default();
                self.gather_group(group, &mut withheld);
                queue.extend(self.groups[group].children.iter().map(|child| child.group));
            }
        }
    }

    fn say(&mut self, severity: Severity, entity: u64, place: Option<DVec3>, reason: String) {
        self.diagnostics.push(Diagnostic { severity, part: None, face: None, entity, place, reason });
    }

    /// A point of a group, in its own coordinates.
    fn somewhere(&self, group: usize) -> Option<DVec3> {
        self.groups[group].somewhere(self.table, self.contexts, self.options.fit_tolerance)
    }

    fn expand(&mut self) {
        // Products nobody uses are the roots; then representations outside products; then what is left in cycles.
        let count = self.groups.len();
        let roots = (0..count).filter(|g| self.groups[*g].product && !self.groups[*g].placed).collect::<Vec<_>>();
        let bare = (0..count).filter(|g| !self.groups[*g].product && !self.groups[*g].placed).collect::<Vec<_>>();
        self.walk_roots(roots.into_iter().chain(bare));
        self.withhold();
        self.walk_roots(0..count);
        self.leave_out_supplemental();
        let left = self.gather.leftovers(self.contexts.first);
        if !left.is_empty() {
            let part = PartId::new(self.planned.len());
            self.planned.push(Plan { name: String::new(), gathered: left, colour: None });
            let transform = DAffine3::IDENTITY;
            self.instances.push(Instance { part, transform, colour: None, name: String::new() });
        }
        for (trouble, units) in std::mem::take(&mut self.gather.unread) {
            let place = Geometry::new(self.table, units, self.options.fit_tolerance).place_near(trouble.entity);
            self.say(Severity::Error, trouble.entity, place, trouble.reason);
        }
        self.tell_aside();
    }

    /// Takes the items of supplemental representations that are not asked for, so that they do not come out as leftovers.
    fn leave_out_supplemental(&mut self) {
        if self.options.supplemental {
            return;
        }
        for supplemental in self.table.of_types(is_supplemental) {
            let Some((items, _)) = product::representation(self.table, supplemental.id) else { continue };
            self.gather.leave_out(supplemental.id, items);
        }
    }

    /// Tells what is no part of a shape: counts per representation, or each surface that was asked for and cannot be meshed.
    fn tell_aside(&mut self) {
        for (representation, items) in std::mem::take(&mut self.gather.aside) {
            let mut counts: BTreeMap<String, usize> = BTreeMap::new();
            for (item, keyword) in items {
                if self.options.supplemental && self.table.find(item).is_some_and(is_endless) {
                    let reason = format!("a {keyword} without bounds cannot be meshed and was left out");
                    self.say(Severity::Warning, item, None, reason);
                } else {
                    *counts.entry(keyword).or_default() += 1;
                }
            }
            if counts.is_empty() {
                continue;
            }
            let counts: Vec<String> = counts.into_iter().map(|(keyword, count)| format!("{count} {keyword}")).collect();
            let why = if self.options.supplemental { "has no faces" } else { "was left out (see --supplemental)" };
            let reason = format!("supplemental geometry {why}: {}", counts.join(", "));
            self.say(Severity::Note, representation, None, reason);
        }
    }

    fn walk_roots(&mut self, groups: impl Iterator<Item = usize>) {
        for group in groups {
            if !self.reached.contains(&group) {
                let name = self.groups[group].name.clone();
                self.walk(group, DAffine3::IDENTITY, name, None);
            }
        }
    }

    fn walk(&mut self, group: usize, transform: DAffine3, name: String, colour: Option<Colour>) {
        self.visits += 1;
        if self.visits > self.options.max_instances {
            return;
        }
        self.reached.insert(group);
        if let Some(part) = self.part(group) {
            self.instances.push(Instance { part, transform, colour, name });
        }
        self.path.push(group);
        for child in 0..self.groups[group].children.len() {
            let child = self.groups[group].children[child].clone();
            if self.path.contains(&child.group) || self.path.len() >= MAX_ASSEMBLY_DEPTH {
                if self.cyclic.insert((group, child.group)) {
                    let name = &self.groups[group].name;
                    let reason = format!("assembly '{name}' contains itself; that occurrence was left out");
                    self.say(Severity::Error, child.entity, self.somewhere(child.group), reason);
                }
                continue;
            }
            let name = if child.name.is_empty() { self.groups[child.group].name.clone() } else { child.name };
            self.walk(child.group, transform * child.transform, name, colour.or(child.colour));
        }
        self.path.pop();
    }

    /// The part that a group's own items make; the same for all its occurrences.
    fn part(&mut self, group: usize) -> Option<PartId> {
        if let Some(known) = self.parts[group] {
            return known;
        }
        let mut gathered = Gathered::default();
        let colour = self.gather_group(group, &mut gathered);
        let repeated = self.gather.repeated(&mut gathered);
        if repeated > 0 {
            let name = &self.groups[group].name;
            let reason =
                format!("{repeated} tessellated items of '{name}' repeat its exact geometry and were left out");
            let entity = self.groups[group].representations.first().copied().unwrap_or(0);
            self.say(Severity::Note, entity, self.somewhere(group), reason);
        }
        let part = (!gathered.is_empty()).then(|| PartId::new(self.planned.len()));
        if part.is_some() {
            self.planned.push(Plan { name: self.groups[group].name.clone(), gathered, colour });
        }
        self.parts[group] = Some(part);
        part
    }

    /// Adds the items of a group; its colour, if it has one as a whole.
    fn gather_group(&mut self, group: usize, gathered: &mut Gathered) -> Option<Colour> {
        let mut colour = None;
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
                // A representation that no product owns may only repeat what a product has.
                if self.groups[group].product || !self.gather.taken.contains(&item) {
                    self.gather.item(item, units, gathered);
                }
            }
        }
        for (item, representation) in &self.groups[group].solids {
            let context = product::representation(self.table, *representation).and_then(|(_, context)| context);
            self.gather.within = *representation;
            self.gather.item(*item, self.contexts.of(context), gathered);
        }
        colour
    }
}
