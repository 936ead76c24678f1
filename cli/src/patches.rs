//! A prepared model -> statistics per face: patches, tiles, trimming curves, critical parameters, bounds.

use serde::Serialize;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use trimtess::model::{Face, Model, Part};
use trimtess::prepare::Prepared;
use trimtess::prepare::internals::{BoxBounds, PreparedFace, PreparedPart};

/// Statistics of preparing. Each part counts once, however often it is placed.
#[derive(Serialize)]
pub(crate) struct Patches {
    /// One row per face, in the model's order.
    faces: Vec<FaceRow>,
    /// One per part.
    parts: Vec<Sums>,
    sum: Sums,
}

/// A face. If it is not usable, counts are 0 and bounds absent.
#[derive(Default, Serialize)]
struct FaceRow {
    part: usize,
    face: usize,
    entity: u64,
    kind: &'static str,
    #[serde(flatten)]
    counts: Counts,
    /// Degree in u and in v.
    degree: [usize; 2],
    rational: bool,
    /// Bézier spans in u and in v.
    spans: [usize; 2],
    bounds: Option<Bounds>,
    /// Distance between surface and edges in the file, millimetres.
    gap: f64,
}

/// Counts that add up over faces.
#[derive(Clone, Copy, Default, Serialize)]
struct Counts {
    /// Bézier patches.
    patches: usize,
    tiles: usize,
    /// Trimming curves in the model: edges of loops, and free curves.
    trims: usize,
    /// Edges that bound the trimmed region, after all intersections.
    edges: usize,
    /// Stretches of these edges between tile borders.
    stretches: usize,
    /// Points where the boundary meets itself, other than common ends of edges.
    meetings: usize,
    /// Critical parameters.
    critical: usize,
}

/// Counts of several faces. An edge counts once per face that it bounds.
#[derive(Clone, Copy, Default, Serialize)]
struct Sums {
    faces: usize,
    #[serde(flatten)]
    counts: Counts,
}

/// Maximum derivative bounds over all sub-boxes, in NURBS parameters. They determine the density of lattices.
#[derive(Serialize)]
struct Bounds {
    #[serde(flatten)]
    worst: BoxBounds,
    /// Number of sub-boxes.
    boxes: usize,
}

impl Counts {
    fn add(&mut self, other: &Self) {
        self.patches += other.patches;
        self.tiles += other.tiles;
        self.trims += other.trims;
        self.edges += other.edges;
        self.stretches += other.stretches;
        self.meetings += other.meetings;
        self.critical += other.critical;
    }
}

/// Number of trimming curves of each face of each part. Preparing consumes the model, so count before.
pub(crate) fn stated_trims(model: &Model) -> Vec<Vec<usize>> {
    let of_face = |face: &Face| {
        let free = face.trims.as_ref().map_or(0, |trims| trims.curves.len());
        face.wires().map(<[_]>::len).sum::<usize>() + free
    };
    model.parts.iter().map(|part: &Part| part.faces.iter().map(of_face).collect()).collect()
}

impl Patches {
    /// Collects the statistics. `stated` is the result of [`stated_trims`].
    pub(crate) fn of(prepared: &Prepared, stated: &[Vec<usize>]) -> Self {
        let mut out = Self { faces: Vec::new(), parts: Vec::new(), sum: Sums::default() };
        for (number, (part, stated)) in prepared.parts.iter().zip(stated).enumerate() {
            let mut sums = Sums::default();
            for (face, (row, &trims)) in part.face_rows.iter().zip(stated).enumerate() {
                let row = FaceRow::of(number, face, row.map(|row| &part.faces[row as usize]), part, trims);
                sums.faces += 1;
                sums.counts.add(&row.counts);
                out.faces.push(row);
            }
            out.sum.faces += sums.faces;
            out.sum.counts.add(&sums.counts);
            out.parts.push(sums);
        }
        out
    }

    /// A table with a row per face, then the sums.
    pub(crate) fn text(&self) -> String {
        const HEAD: &str = "part face kind degree spans patches tiles trims edges stretches meetings critical \
                            |Su| |Sv| |Suu| |Suv| |Svv|";
        let mut rows: Vec<Vec<String>> = vec![HEAD.split_whitespace().map(String::from).collect()];
        for row in &self.faces {
            let by = |[a, b]: [usize; 2]| format!("{a}×{b}");
            let degree = format!("{}{}", by(row.degree), if row.rational { "r" } else { "" });
            let mut line = vec![row.part.to_string(), row.face.to_string(), row.kind.to_owned(), degree, by(row.spans)];
            line.extend(row.counts.cells());
            match &row.bounds {
                Some(Bounds { worst: b, .. }) => {
                    line.extend([b.u, b.v, b.uu.norm, b.uv.norm, b.vv.norm].map(|x| format!("{x:.3e}")))
                }
                None => line.push("lost".into()),
            }
            rows.push(line);
        }
        let blank = || vec![String::new(); 3];
        if self.parts.len() > 1 {
            for (part, sums) in self.parts.iter().enumerate() {
                let head = [part.to_string(), format!("{} faces", sums.faces)];
                rows.push(head.into_iter().chain(blank()).chain(sums.counts.cells()).collect());
            }
        }
        let head = ["all".into(), format!("{} faces", self.sum.faces)];
        rows.push(head.into_iter().chain(blank()).chain(self.sum.counts.cells()).collect());
        let width = |column: usize| rows.iter().filter_map(|r| r.get(column)).map(|c| c.chars().count()).max();
        let widths: Vec<usize> = (0..rows[0].len()).filter_map(width).collect();
        let mut text = String::new();
        for row in &rows {
            let cells = row.iter().zip(&widths).map(|(cell, &width)| format!("{cell:>width$}"));
            let _ = writeln!(text, "{}", cells.collect::<Vec<_>>().join("  ").trim_end());
        }
        text
    }
}

impl Counts {
    fn cells(&self) -> impl Iterator<Item = String> + use<> {
        let Self { patches, tiles, trims, edges, stretches, meetings, critical } = *self;
        [patches, tiles, trims, edges, stretches, meetings, critical].into_iter().map(|count| count.to_string())
    }
}

impl FaceRow {
    fn of(part: usize, face: usize, row: Option<&PreparedFace>, of: &PreparedPart, trims: usize) -> Self {
        let Some(row) = row else {
            let counts = Counts { trims, ..Counts::default() };
            return Self { part, face, kind: "unusable", counts, ..Self::default() };
        };
        let tiles = &of.tiles[row.tiles.start as usize..row.tiles.end as usize];
        let uses = || tiles.iter().flat_map(|t| &t.loops).flatten().filter(|u| u.edge.index() < of.brep_edges);
        let (nu, nv) = row.patches.counts();
        let counts = Counts {
            patches: nu * nv,
            tiles: tiles.len(),
            trims,
            edges: uses().map(|u| u.edge).collect::<BTreeSet<_>>().len(),
            stretches: uses().count(),
            meetings: row.meetings as usize,
            critical: row.critical as usize,
        };
        Self {
            part,
            face,
            entity: row.entity,
            kind: row.kind.name(),
            counts,
            degree: [row.patches.degree_u, row.patches.degree_v],
            rational: row.patches.rational,
            spans: [nu, nv],
            bounds: Some(Bounds::of(&row.bounds.cells)),
            gap: row.gap,
        }
    }
}

impl Bounds {
    fn of(boxes: &[BoxBounds]) -> Self {
        let worst = boxes.iter().fold(BoxBounds::default(), |m, b| BoxBounds {
            uu: m.uu.max(b.uu),
            uv: m.uv.max(b.uv),
            vv: m.vv.max(b.vv),
            u: m.u.max(b.u),
            v: m.v.max(b.v),
            turn_u: m.turn_u.max(b.turn_u),
            turn_v: m.turn_v.max(b.turn_v),
        });
        Self { worst, boxes: boxes.len() }
    }
}
