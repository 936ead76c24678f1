//! A mesh -> a file, with the program's limits on rounding. The file appears whole or not at all.

use crate::errors;
use crate::job::Job;
use pyo3::prelude::*;
use std::iter;
use std::path::Path;
use std::sync::Arc;
use trimtess::control::Rayon;
use trimtess::glam::DVec3;
use trimtess::mesh::{FrameView, PackedFrame, Scene};
use trimtess::out::{Format, MeshLevel, Outputs, Rounding, SaveOptions};
use trimtess::prepare::Prepared;

/// What was written.
#[pyclass(frozen, get_all, module = "trimtess")]
pub(crate) struct Saved {
    /// The file.
    path: String,
    /// Triangles in the file, coarser levels of detail not counted.
    triangles: u64,
    /// Triangles left out, because corners of them round to one position in the file's numbers.
    collapsed_triangles: u64,
    /// Faces that lost all triangles that way, numbered across all instances; those of coarser levels, too.
    collapsed_faces: Vec<u64>,
    /// Upper bound on the distance that the file's numbers move a vertex, millimetres.
    rounding_mm: f64,
    /// Add this to positions in the file to get those of the model, millimetres. Zero without `recenter`.
    offset_mm: (f64, f64, f64),
    /// What the exit status of the program would be: 0, or 3 if the mesh has faults or faces were rounded away.
    status: u8,
}

#[pymethods]
impl Saved {
    fn __repr__(&self) -> String {
        format!("<Saved {:?}: {} triangles, status {}>", self.path, self.triangles, self.status)
    }
}

/// How a file is written.
pub(crate) struct How<'a> {
    /// Chord tolerance of the mesh, millimetres.
    pub(crate) chord: f64,
    pub(crate) recenter: bool,
    /// What a GLB asks of its readers.
    pub(crate) glb: &'a [String],
    /// Coarser meshes and their chord tolerances.
    pub(crate) levels: Vec<(Arc<PackedFrame>, f64)>,
}

/// A mesh in a scene that may be moved.
fn level<'a>(frame: &'a PackedFrame, scene: &'a Scene, chord: f64) -> MeshLevel<'a> {
    MeshLevel { frame: FrameView { scene, ..FrameView::from(frame) }, chord }
}

/// Writes a frame. `status` is the worst of the meshes.
pub(crate) fn save(
    job: &Job<'_>,
    (frame, prepared): (&Arc<PackedFrame>, &Prepared),
    path: &Path,
    How { chord, recenter, glb, levels }: How<'_>,
    status: u8,
) -> PyResult<Saved> {
    let mut format = Format::of_path(path).map_err(|failure| errors::unknown_format(job.py, &failure))?;
    for word in glb {
        let Format::Glb(options) = format else {
            return Err(errors::out_of_range(job.py, "glb", word, "for files that end in .glb"));
        };
        format = Format::Glb(match word.as_str() {
            "instanced" => options.with_instanced(true),
            "quantized" => options.with_quantized(true),
            "compressed" => options.with_compressed(true),
            _ => return Err(errors::out_of_range(job.py, "glb", word, "instanced, quantized or compressed")),
        });
    }
    if !levels.is_empty() && !matches!(format, Format::Glb(_)) {
        let expected = "[] for files that do not end in .glb";
        return Err(errors::out_of_range(job.py, "levels", format!("{} meshes", levels.len()), expected));
    }
    let options = SaveOptions::new(format).with_max_rounding(Rounding::SHARE * chord);
    let centre = prepared.centre();
    let offset = if recenter { centre } else { DVec3::ZERO };
    let saved = job.run(|control| {
        let moved = |scene: &Scene| {
            let mut scene = scene.clone();
            if recenter {
                scene.translate(-offset);
            }
            scene
        };
        let finest = moved(&frame.scene);
        let scenes: Vec<Scene> = levels.iter().map(|(frame, _)| moved(&frame.scene)).collect();
        let coarser = levels.iter().zip(&scenes).map(|((frame, chord), scene)| level(frame, scene, *chord));
        let all: Vec<MeshLevel<'_>> = iter::once(level(frame, &finest, chord)).chain(coarser).collect();
        let mut outputs = Outputs::default();
        let saved = outputs.save_on(&Rayon, &all, path, &options, control)?;
        outputs.publish()?;
        Ok(saved.roundings)
    })?;
    let text = path.display().to_string();
    let fits = |by, format| Rounding::fits_moved(&frame.scene, by, &options.with_format(format));
    let helps = || [!recenter && centre != DVec3::ZERO && fits(-centre, format), fits(-offset, Format::Ply)];
    let mut roundings = saved.map_err(|failure| errors::unsaved(job.py, &failure, &text, helps))?;
    let mut collapsed_faces: Vec<u64> =
        roundings.iter().flat_map(|rounding| rounding.collapsed_faces.iter().copied()).collect();
    collapsed_faces.sort_unstable();
    collapsed_faces.dedup();
    let rounding = roundings.swap_remove(0);
    Ok(Saved {
        path: text,
        triangles: rounding.triangles,
        collapsed_triangles: rounding.collapsed,
        status: if collapsed_faces.is_empty() { status } else { 3 },
        collapsed_faces,
        rounding_mm: rounding.moved,
        offset_mm: offset.into(),
    })
}
