//! `trimtess info`: the content of a file, without tessellating it.

use crate::diagram::{DiagramArgs, Drawn};
use crate::input::{self, Input};
use crate::limits::unprepared;
use crate::logging::Progress;
use crate::outputs::{Named, Outputs};
use crate::patches::{Patches, stated_trims};
use crate::report::{by_name, counted, millimetres, subject};
use crate::{Common, Done, Failure};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use trimtess::model::{Model, Severity};
use trimtess::prepare::{Shells, prepare};

/// Print what is in a file: parts, instances, faces by kind, units, bounding box, closedness, diagnostics.
#[derive(clap::Args)]
pub(crate) struct InfoArgs {
    /// A STEP file, builtin:NAME, or builtin:list.
    #[arg(value_name = "FILE", value_parser = input::parser())]
    pub(crate) input: Input,
    /// Print what preparing made of each face: patches, tiles, trimming curves before and after intersection, critical
    /// parameters, maximum derivative bounds.
    #[arg(long)]
    patches: bool,
    #[command(flatten)]
    diagram: DiagramArgs,
    /// Print the result to standard output as JSON.
    #[arg(long)]
    json: bool,
}

impl InfoArgs {
    pub(crate) fn outputs(&self) -> Named<'_> {
        Named::default().output("diagram", self.diagram.svg.as_ref())
    }
}

/// Maximum number of parts, and of errors and warnings, listed without `-v`. The rest is only counted.
const LISTED: usize = 12;

/// The result. Counts are per part unless they say placed; lengths are in millimetres.
#[derive(Default, Serialize)]
struct Info {
    input: String,
    parts: usize,
    instances: usize,
    faces: usize,
    placed_faces: usize,
    /// One row per part, in the file's order.
    part_list: Vec<Row>,
    /// Faces by kind of surface. Faces that could not be read count as `unreadable`.
    surfaces: BTreeMap<&'static str, usize>,
    edges: usize,
    millimetres_per_unit: f64,
    /// Lower and upper corner of the tight bounding box of the trimmed, placed model.
    r#box: Option<[[f64; 3]; 2]>,
    diagonal: f64,
    shells: Shells,
    /// Edges where the prepared faces of parts end. Borders of faces without edges are sewn before.
    open_edges: usize,
    /// Total length of the open edges.
    open_length: f64,
    diagnostics: Vec<DiagnosticRow>,
    #[serde(skip_serializing_if = "Option::is_none")]
    patches: Option<Patches>,
    #[serde(skip_serializing_if = "Option::is_none")]
    drawn: Option<Drawn>,
}

/// A part.
#[derive(Serialize)]
struct Row {
    name: String,
    /// Number of instances.
    instances: usize,
    faces: usize,
    edges: usize,
    /// Whether all its shells are closed.
    closed: bool,
}

/// A diagnostic of the model.
#[derive(Serialize)]
struct DiagnosticRow {
    #[serde(serialize_with = "by_name")]
    severity: Severity,
    part: Option<u32>,
    face: Option<u32>,
    entity: Option<u64>,
    code: &'static str,
    reason: String,
}

pub(crate) fn run(args: &InfoArgs, common: &Common, outputs: &mut Outputs) -> Result<Done, Failure> {
    let progress = Progress::start(common);
    progress.stage(format!("reading {}", args.input.name()));
    let model = args.input.read(&common.limits.step())?;
    let mut info = Info::of(&model, args.input.name());
    let trims = args.patches.then(|| stated_trims(&model));
    progress.stage("preparing");
    let prepared = prepare(model, &common.prepare()).map_err(unprepared)?;
    info.r#box = prepared.bounds.map(|corners| corners.map(|corner| corner.to_array()));
    info.diagonal = prepared.diagonal;
    info.drawn = args.diagram.draw(&prepared, &info.input, common, outputs)?;
    info.patches = trims.map(|trims| Patches::of(&prepared, &trims));
    for open in prepared.parts.iter().map(|part| part.open_edges()) {
        info.open_edges += open.count;
        info.open_length += open.length;
    }
    info.diagnostics = prepared
        .diagnostics
        .iter()
        .map(|d| DiagnosticRow {
            severity: d.severity,
            part: d.part.map(|part| part.0),
            face: d.face.map(|face| face.0),
            entity: Some(d.entity).filter(|&entity| entity != 0),
            code: d.kind.code(),
            reason: d.kind.to_string(),
        })
        .collect();
    drop(progress);
    if args.json {
        outputs.tell_json(&info)?;
    } else {
        outputs.tell(&info.text(common.verbose > 0));
    }
    Ok(Done::of(&prepared))
}

impl Info {
    /// The facts from the model alone.
    fn of(model: &Model, input: String) -> Self {
        let mut surfaces = BTreeMap::new();
        let mut shells = Shells::default();
        let mut part_list = Vec::with_capacity(model.parts.len());
        for part in &model.parts {
            for face in &part.faces {
                let unread = face.lost || face.refused.is_some();
                let kind = if unread { "unreadable" } else { face.surface.kind().name() };
                *surfaces.entry(kind).or_insert(0) += 1;
            }
            let own = Shells::of(part);
            shells.join(&own);
            let (name, faces, edges, closed) = (part.name.clone(), part.faces.len(), part.edges.len(), own.open == 0);
            part_list.push(Row { name, instances: 0, faces, edges, closed });
        }
        for instance in &model.instances {
            if let Some(row) = part_list.get_mut(instance.part.index()) {
                row.instances += 1;
            }
        }
        let placed = model.instances.iter().filter_map(|i| model.parts.get(i.part.index()));
        Self {
            input,
            parts: model.parts.len(),
            instances: model.instances.len(),
            faces: model.parts.iter().map(|part| part.faces.len()).sum(),
            placed_faces: placed.map(|part| part.faces.len()).sum(),
            part_list,
            surfaces,
            edges: model.parts.iter().map(|part| part.edges.len()).sum(),
            millimetres_per_unit: model.millimetres_per_unit,
            shells,
            ..Self::default()
        }
    }

    /// The result as text, with `all` parts and diagnostics or only counts.
    fn text(&self, all: bool) -> String {
        let mut text = format!("{}\n", self.input);
        let mut line = |label: &str, what: String| {
            let _ = writeln!(text, "  {label:12}{what}");
        };
        line("parts", format!("{}, placed {} times", self.parts, self.instances));
        line("faces", format!("{}, placed {} times", self.faces, self.placed_faces));
        let kinds: Vec<String> = self.surfaces.iter().map(|(kind, count)| format!("{count} {kind}")).collect();
        line("surfaces", kinds.join(", "));
        line("edges", self.edges.to_string());
        line("unit", format!("{} mm", self.millimetres_per_unit));
        match &self.r#box {
            Some([low, high]) => {
                let [low_text, high_text] = [low, high].map(|corner| corner.map(millimetres).join(", "));
                let size = [0, 1, 2].map(|k| millimetres(high[k] - low[k])).join(" × ");
                line("box", format!("({low_text}) to ({high_text}) mm"));
                line("size", format!("{size} mm, diagonal {} mm", millimetres(self.diagonal)));
            }
            None => line("box", "empty".into()),
        }
        let Shells { closed, open, voids, free_edges, .. } = self.shells;
        let stated = format!("{free_edges} edges that one face uses, as the file states");
        line("shells", format!("{closed} closed, {voids} of them voids; {open} open, with {stated}"));
        line("open edges", format!("{} once sewn, {} mm long", self.open_edges, millimetres(self.open_length)));
        line("diagnostics", counted(self.diagnostics.iter().map(|d| d.severity)));
        let listed = if all { self.part_list.len() } else { LISTED };
        for (number, Row { name, instances, faces, edges, closed }) in self.part_list.iter().take(listed).enumerate() {
            let state = if *closed { "closed" } else { "open" };
            line(
                &format!("part {number}"),
                format!("{name:?}: {faces} faces, {edges} edges, {state}, placed {instances} times"),
            );
        }
        if self.part_list.len() > listed {
            line("…", format!("{} more parts (-v lists all)", self.part_list.len() - listed));
        }
        let least = if all { Severity::Note } else { Severity::Warning };
        let told: Vec<&DiagnosticRow> = self.diagnostics.iter().filter(|d| d.severity >= least).collect();
        let listed = if all { told.len() } else { LISTED };
        for DiagnosticRow { severity, part, face, entity, reason, .. } in told.iter().take(listed) {
            line(severity.name(), subject(*part, *face, *entity) + reason);
        }
        if told.len() > listed {
            line("…", format!("{} more errors and warnings (-v lists all)", told.len() - listed));
        }
        if let Some(drawn) = &self.drawn {
            let _ = writeln!(text, "  {:12}{}", "svg", drawn.text());
        }
        if let Some(patches) = &self.patches {
            text += "\n";
            text += &patches.text();
        }
        text
    }
}
