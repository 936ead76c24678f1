//! Checks and audits of a mesh -> faults, in words.

use super::DeviationReport;
use crate::mesh::{MeshFacts, Scene, SceneFacts, ScenePart};
use crate::prepare::Shells;

/// Fraction of the chord tolerance that edge polylines may reach. Edges are refined by an upper bound on the deviation,
/// so only rounding needs an allowance.
const EDGE_LIMIT: f64 = 1.05;

/// What is wrong with a mesh, given its check and the shells of the file's parts: malformed triangles, cracks, parts that
/// are turned inside out. Empty for a sound mesh. One sentence per fault, those of parts with the part's number.
#[must_use]
pub fn mesh_faults(scene: &Scene, facts: &SceneFacts, shells: &[Shells]) -> Vec<String> {
    let malformed = (!facts.total.is_well_formed()).then(|| format!("the mesh is malformed: {}", facts.total));
    let parts = scene.parts.iter().zip(&facts.parts).zip(shells).enumerate();
    let of_parts = parts.flat_map(|(number, ((part, mesh), shells))| {
        part_faults(part, mesh, shells).map(move |fault| format!("part {number}: {fault}"))
    });
    malformed.into_iter().chain(of_parts).collect()
}

/// Faults of a part's mesh, given the edges and shells of the file.
fn part_faults(part: &ScenePart, mesh: &MeshFacts, shells: &Shells) -> impl Iterator<Item = String> {
    let cracked = (mesh.defects > 0).then(|| {
        let (count, length) = (mesh.defects, mesh.defect_length);
        let file = if part.closed { "closed in the file" } else { "open elsewhere in the file" };
        format!("{file}, but its mesh has {count} unbalanced edges ({length:.3e} mm)")
    });
    let solid = shells.open == 0;
    let expected = (shells.voids + shells.undirected) as u64;
    let inverted = (solid && mesh.negative_components > expected).then(|| {
        let (count, voids) = (mesh.negative_components, shells.voids);
        format!("{count} components of its mesh have negative volume, but the file has {voids} voids: inside out")
    });
    cracked.into_iter().chain(inverted)
}

impl DeviationReport {
    /// Violations of the tolerance: more than one sample in a thousand over it, or an edge by more than 5 %. One
    /// sentence each.
    pub fn faults(&self) -> impl Iterator<Item = String> + use<> {
        let (surfaces, edges) = (self.beyond_gap, self.edges);
        let off = (surfaces.p999 > 1.0).then(|| {
            let (over, samples, worst) = (surfaces.over, surfaces.samples, surfaces.worst);
            format!("{over} of {samples} mesh samples exceed the chord tolerance, the worst by a factor of {worst:.3}")
        });
        let edges_off = (edges.worst > EDGE_LIMIT).then(|| {
            let (over, samples, worst) = (edges.over, edges.samples, edges.worst);
            format!(
                "{over} of {samples} samples of edges exceed the chord tolerance, the worst by a factor of {worst:.3}"
            )
        });
        off.into_iter().chain(edges_off)
    }
}
