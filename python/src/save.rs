//! A mesh -> a file, with the program's limits on rounding. The file appears whole or not at all.

use crate::errors;
use crate::job::Job;
use pyo3::prelude::*;
use std::path::Path;
use std::sync::Arc;
use trimtess::glam::DVec3;
use trimtess::mesh::{FrameView, PackedFrame};
use trimtess::out::{self, Format, Outputs, Rounding};
use trimtess::prepare::Prepared;

/// What was written.
#[pyclass(frozen, get_all, module = "trimtess")]
pub(crate) struct Saved {
    /// The file.
    path: String,
    /// Triangles in the file.
    triangles: u64,
    /// Triangles left out, because corners of them round to one position in the file's numbers.
    collapsed_triangles: u64,
    /// Faces that lost all triangles that way, numbered across all instances.
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

/// Writes a frame that was made within `chord`. `status` is that of the mesh.
pub(crate) fn save(
    job: &Job<'_>,
    (frame, prepared): (&Arc<PackedFrame>, &Prepared),
    path: &Path,
    (chord, recenter, glb): (f64, bool, &[String]),
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
    let most = Rounding::SHARE * chord;
    let centre = prepared.centre();
    let offset = if recenter { centre } else { DVec3::ZERO };
    let saved = job.run(|control| {
        let mut scene = frame.scene.clone();
        scene.translate(-offset);
        let whole = FrameView::from(&**frame);
        let moved = FrameView { scene: if recenter { &scene } else { &frame.scene }, ..whole };
        let mut outputs = Outputs::default();
        let (rounding, _) = out::save_pending(&moved, path, format, most, &mut outputs)?;
        // Dropped outputs leave nothing.
        if !control.is_cancelled() {
            outputs.publish()?;
        }
        Ok(rounding)
    })?;
    let text = path.display().to_string();
    let fits = |by, format| Rounding::fits_moved(&**frame, by, format, most);
    let helps = || [!recenter && centre != DVec3::ZERO && fits(-centre, format), fits(-offset, Format::Ply)];
    let rounding = saved.map_err(|failure| errors::unsaved(job.py, &failure, &text, helps))?;
    Ok(Saved {
        path: text,
        triangles: rounding.triangles,
        collapsed_triangles: rounding.collapsed,
        status: if rounding.collapsed_faces.is_empty() { status } else { 3 },
        collapsed_faces: rounding.collapsed_faces,
        rounding_mm: rounding.moved,
        offset_mm: offset.into(),
    })
}
