//! A frame to Wavefront OBJ: text, millimetres, world coordinates at full f64 precision.

use super::placed::{distinct, instance_name, placed};
use crate::mesh::{FrameView, Scene, SceneInstance};
use glam::DVec3;
use std::fmt::Write as _;
use std::io::{self, Write};

/// Writes every instance as an object `o` and every face as a group `g`.
///
/// Numbers are the shortest that parse to the same f64, so equal positions stay equal. Colours are not written: the
/// format keeps them in a second file.
///
/// # Errors
/// I/O errors of `file`.
pub fn write_obj<'a>(frame: impl Into<FrameView<'a>>, file: &mut impl Write) -> io::Result<()> {
    let frame = &frame.into();
    let by_part = frame.batches_by_part();
    writeln!(file, "# {}: millimetres, written by trimtess", word(&frame.scene.name))?;
    let mut text = String::new();
    let mut world: Vec<DVec3> = Vec::new();
    let mut first = 1_u64;
    for (instance, placement, batches) in placed(frame, &by_part) {
        writeln!(file, "o {}", object_name(frame.scene, instance))?;
        let mut face = None;
        for batch in batches {
            text.clear();
            if face != Some(batch.face) {
                face = Some(batch.face);
                line(&mut text, format_args!("g face_{}", u64::from(instance.first_face) + u64::from(batch.face.0)));
            }
            world.clear();
            world.extend(batch.mesh.positions.iter().map(|&point| placement.position(point)));
            for p in &world {
                line(&mut text, format_args!("v {:?} {:?} {:?}", p.x, p.y, p.z));
            }
            for index in 0..world.len() {
                let normal = batch.mesh.normals.get(index).copied().unwrap_or_default();
                let n = placement.normal(normal).as_vec3();
                line(&mut text, format_args!("vn {:?} {:?} {:?}", n.x, n.y, n.z));
            }
            for corners in distinct(&batch.mesh, &world) {
                let [a, b, c] = placement.winding(corners).map(|corner| first + u64::from(corner));
                line(&mut text, format_args!("f {a}//{a} {b}//{b} {c}//{c}"));
            }
            first += world.len() as u64;
            file.write_all(text.as_bytes())?;
        }
    }
    Ok(())
}

/// Formatting into a `String` cannot fail.
fn line(text: &mut String, arguments: std::fmt::Arguments<'_>) {
    let _ = writeln!(text, "{arguments}");
}

fn object_name(scene: &Scene, instance: &SceneInstance) -> String {
    let part = scene.parts.get(instance.part.index()).map_or("", |part| part.name.as_str());
    match word(instance_name(part, instance)) {
        name if name.is_empty() => format!("part_{}", instance.part.0),
        name => name,
    }
}

/// Replaces white space and control characters by `_`, because names end at blanks in OBJ.
fn word(name: &str) -> String {
    name.chars().map(|c| if c.is_whitespace() || c.is_control() { '_' } else { c }).collect()
}
