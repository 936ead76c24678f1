//! Facts of a mesh -> rows of the report: whether each part is closed in the file and in the mesh, also as text;
//! slivers and rewound area of faces whose loops bound no simple region.

use crate::report::rows_of;
use serde::Serialize;
use std::fmt::Write as _;
use trimtess::mesh::{MeshFacts, Scene, ScenePart};
use trimtess::parallel::{FaceFill, FrameReport};

/// Maximum number of runs of faces or parts per line, and of lines. The rest is only counted.
const NAMED: usize = 12;

/// Closedness of one part in the file and in the mesh.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Closedness {
    pub(crate) part: u32,
    pub(crate) name: String,
    pub(crate) closed_in_file: bool,
    /// Edges of the file where a sheet ends.
    pub(crate) free_edges: usize,
    /// Edges of the file whose faces cannot be oriented consistently.
    pub(crate) not_orientable: usize,
    /// Whether the directed uses of every mesh edge cancel.
    pub(crate) closed_in_mesh: bool,
    /// Cracks: mesh edges whose uses do not cancel, where the file has no free edge.
    pub(crate) defects: u64,
    /// The part's faces along the cracks.
    pub(crate) defect_faces: Vec<u32>,
}

impl Closedness {
    pub(crate) fn of(number: u32, part: &ScenePart, facts: &MeshFacts) -> Self {
        Self {
            part: number,
            name: part.name.clone(),
            closed_in_file: part.closed,
            free_edges: part.free_edges.len(),
            not_orientable: part.not_orientable.len(),
            closed_in_mesh: facts.unbalanced_edges == 0,
            defects: facts.defects,
            defect_faces: facts.defect_faces.iter().map(|face| face.0).collect(),
        }
    }

    /// The text of the part. Parts with equal texts share a line.
    fn words(&self) -> String {
        let file = match (self.closed_in_file, self.free_edges, self.not_orientable) {
            (true, ..) => "closed in the file".to_owned(),
            (false, 0, 0) => "open in the file".to_owned(),
            (false, free, 0) => format!("open in the file ({free} free edges)"),
            (false, 0, turned) => format!("not orientable in the file ({turned} edges)"),
            (false, free, turned) => format!("open in the file ({free} free edges, {turned} not orientable)"),
        };
        match (self.defects, self.closed_in_mesh) {
            (0, true) => format!("{file}, closed in the mesh"),
            (0, false) if self.closed_in_file => format!("{file}, open in the mesh"),
            (0, false) => format!("{file}, no cracks in the mesh"),
            (edges, _) => {
                let faces = listed(&self.defect_faces);
                let place = if self.closed_in_file { "open in the mesh" } else { "cracks in the mesh" };
                format!("{file}, {place}: {edges} edges, faces {faces}")
            }
        }
    }
}

/// One line per group of parts with the same text, those with cracks first, then by the first part.
pub(crate) fn lines(parts: &[Closedness]) -> String {
    let mut groups: Vec<(String, Vec<u32>)> = Vec::new();
    let mut known = std::collections::HashMap::new();
    for part in parts {
        let words = part.words();
        let group = *known.entry(words.clone()).or_insert_with(|| {
            groups.push((words, Vec::new()));
            groups.len() - 1
        });
        groups[group].1.push(part.part);
    }
    // Cracks first: they are what the check is for.
    groups.sort_by_key(|(_, members)| parts[members[0] as usize].defects == 0);
    let mut text = String::new();
    for (words, members) in groups.iter().take(NAMED) {
        let of = if members.len() == 1 { "part" } else { "parts" };
        let _ = writeln!(text, "  {of} {}: {words}", listed(members));
    }
    if groups.len() > NAMED {
        let rest: usize = groups[NAMED..].iter().map(|(_, members)| members.len()).sum();
        let _ = writeln!(text, "  … and {rest} more parts (--report writes them)");
    }
    text
}

/// Lists ascending numbers with runs joined, as in "0–3, 7". Long lists are cut.
fn listed(numbers: &[u32]) -> String {
    let runs: Vec<&[u32]> = numbers.chunk_by(|a, b| a + 1 == *b).collect();
    let texts = runs.iter().take(NAMED).map(|run| match *run {
        [first, .., last] => format!("{first}–{last}"),
        _ => run[0].to_string(),
    });
    let mut text = texts.collect::<Vec<_>>().join(", ");
    if runs.len() > NAMED {
        let rest: usize = runs[NAMED..].iter().map(|run| run.len()).sum();
        let _ = write!(text, " and {rest} more");
    }
    text
}

/// A face with slivers or rewound area. `face_id` is numbered across all instances, as in a PLY file.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Fill {
    pub(crate) face_id: u64,
    /// Triangles that only close the face.
    pub(crate) slivers: u32,
    /// Area whose winding number is not 1, mm² of the part.
    pub(crate) rewound: f64,
}

/// Fills of all faces, instance by instance.
pub(crate) fn placed_fills(made: &FrameReport, scene: &Scene) -> Vec<Fill> {
    let placed = scene.instances.iter().flat_map(|instance| {
        rows_of(&made.fills, instance.part, |fill| fill.part).iter().map(
            |&FaceFill { face, slivers, rewound, .. }| Fill {
                face_id: instance.face_number(face).into(),
                slivers,
                rewound,
            },
        )
    });
    placed.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::made::meshed;
    use crate::report::Report;
    use trimtess::model::{EdgeId, FaceId, PartId, Severity, shapes};

    #[test]
    fn parts_with_the_same_text_share_a_line() {
        let part = |free: u32, turned: u32| ScenePart {
            free_edges: (0..free).map(EdgeId).collect(),
            not_orientable: (0..turned).map(EdgeId).collect(),
            closed: free + turned == 0,
            ..ScenePart::default()
        };
        let mesh = |unbalanced: u64, faces: &[u32]| MeshFacts {
            unbalanced_edges: unbalanced,
            defects: if faces.is_empty() { 0 } else { unbalanced },
            defect_faces: faces.iter().copied().map(FaceId).collect(),
            ..MeshFacts::default()
        };
        let rows = [
            (part(0, 0), mesh(0, &[])),
            (part(0, 0), mesh(0, &[])),
            (part(4, 0), mesh(8, &[])),
            (part(0, 0), mesh(3, &[1, 2, 3, 7])),
            (part(0, 2), mesh(5, &[])),
            (part(4, 1), mesh(9, &[5])),
            (part(0, 0), mesh(0, &[])),
        ];
        let of = |(number, (part, facts)): (u32, &(ScenePart, MeshFacts))| Closedness::of(number, part, facts);
        let parts: Vec<Closedness> = (0..).zip(&rows).map(of).collect();
        let text = lines(&parts);
        let rows: Vec<&str> = text.lines().map(str::trim).collect();
        let expected = [
            "part 3: closed in the file, open in the mesh: 3 edges, faces 1–3, 7",
            "part 5: open in the file (4 free edges, 1 not orientable), cracks in the mesh: 9 edges, faces 5",
            "parts 0–1, 6: closed in the file, closed in the mesh",
            "part 2: open in the file (4 free edges), no cracks in the mesh",
            "part 4: not orientable in the file (2 edges), no cracks in the mesh",
        ];
        assert_eq!(rows, expected);
    }

    #[test]
    fn slivers_are_counted_per_face_and_rewound_area_is_a_warning() {
        let model = shapes::by_name("box").expect("a shape");
        let (prepared, mut frame, mut made) = meshed(model, 0.1);
        let mut instance = frame.scene.instances[0].clone();
        instance.first_face = 6;
        frame.scene.instances.push(instance);
        let fill =
            |face: u32, slivers: u32, rewound: f64| FaceFill { part: PartId(0), face: FaceId(face), slivers, rewound };
        made.fills = vec![fill(1, 3, 0.0), fill(2, 0, 1e-9), fill(4, 2, 1e3)];
        let report = Report::of(&frame, &prepared, &made);
        assert_eq!(report.slivers, 10, "each instance counts");
        let text = report.summary();
        assert!(text.contains("10 slivers that only close 4 faces"), "{text}");
        let faces: Vec<(u64, u32)> = report.fills.iter().map(|fill| (fill.face_id, fill.slivers)).collect();
        assert_eq!(faces, [(1, 3), (2, 0), (4, 2), (7, 3), (8, 0), (10, 2)]);
        let told: Vec<_> = report.diagnostics.iter().map(|e| (e.severity, e.face_id, e.place.is_some())).collect();
        assert_eq!(
            told,
            [(Severity::Warning, Some(4), true), (Severity::Warning, Some(10), true)],
            "{:?}",
            report.diagnostics
        );
    }
}
