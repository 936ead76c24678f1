//! A picked face to lines of text.

use trimtess::mesh::Scene;
use trimtess::out::wgpu::PickHit;
use trimtess::prepare::Prepared;

/// Facts of a face for the panel, as names and values.
pub(super) fn facts(picked: &PickHit, scene: &Scene, prepared: &Prepared) -> Vec<(&'static str, String)> {
    let mut rows = Vec::new();
    let named = |name: Option<&str>, number: usize| match name {
        Some(name) if !name.is_empty() => format!("{number} {name:?}"),
        _ => number.to_string(),
    };
    let part = picked.part.index();
    let instance = picked.instance.index();
    rows.push(("part", named(scene.parts.get(part).map(|part| part.name.as_str()), part)));
    rows.push(("instance", named(scene.instances.get(instance).map(|placed| &*placed.name), instance)));
    rows.push(("face", picked.face.index().to_string()));
    rows.extend(prepared.face_facts(picked.part, picked.face));
    rows.push(("tile", picked.tile.0.to_string()));
    rows.push(("triangles", format!("{} in the tile", picked.triangles)));
    let [x, y, z] = picked.point.to_array();
    rows.push(("point", format!("{x:.3}, {y:.3}, {z:.3}")));
    rows
}
