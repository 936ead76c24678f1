//! A frame to Wavefront OBJ: text, millimetres, world coordinates at full f64 precision.

use super::making::{Making, Pieces};
use super::placed::instance_name;
use super::plain::{pieces, to_double};
use super::rounding::Rounding;
use super::save_error::SaveError;
use crate::mesh::{FrameView, Scene, SceneInstance};
use std::fmt::Write as _;

/// Makes the file.
pub(super) fn obj(making: &Making<'_>, frame: &FrameView<'_>) -> Result<(Pieces, Rounding), SaveError> {
    let (mut pieces, rounding) = pieces(making, frame, |run| {
        let mut text = String::new();
        if run.before.is_none() {
            line(&mut text, format_args!("o {}", object_name(frame.scene, run.instance)));
        }
        // Numbers begin with 1.
        let (mut face, mut first) = (run.before, run.first + 1);
        let count = run.round(to_double, |batch, world, triangles| {
            if face.replace(batch.face) != Some(batch.face) {
                let number = run.instance.face_number(batch.face);
                line(&mut text, format_args!("g face_{number}"));
            }
            for p in making.call.while_wanted(world.iter()) {
                line(&mut text, format_args!("v {:?} {:?} {:?}", p.x, p.y, p.z));
            }
            for index in making.call.while_wanted(0..world.len()) {
                let normal = batch.mesh.normals.get(index).copied().unwrap_or_default();
                let n = run.placement.normal(normal).as_vec3();
                line(&mut text, format_args!("vn {:?} {:?} {:?}", n.x, n.y, n.z));
            }
            for corners in triangles {
                let [a, b, c] = corners.map(|corner| first + u64::from(corner));
                line(&mut text, format_args!("f {a}//{a} {b}//{b} {c}//{c}"));
            }
            first += world.len() as u64;
        })?;
        Ok((text.into_bytes(), count))
    })?;
    let head = format!("# {}: millimetres, written by trimtess\n", word(&frame.scene.name));
    pieces.insert(0, head.into_bytes());
    Ok((pieces, rounding))
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
