//! The oracle itself: exact facts of closed solids; each kind of damage is found and located.

mod out_fixture;

use glam::{DAffine3, DQuat, DVec3, Vec3};
use out_fixture::{box_batches, box_frame};
use trimtess::mesh::{Batch, Cause, EdgeLine, MeshFacts, TileMesh, check_part, check_scene};
use trimtess::model::{EdgeId, FaceId, PartId, TileId};

fn cube() -> Vec<Batch> {
    box_batches(DVec3::ONE)
}

fn mesh(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Batch {
    let positions: Vec<_> = positions.iter().map(|&p| DVec3::from_array(p)).collect();
    let normals = vec![Vec3::Z; positions.len()];
    let mesh = TileMesh { positions, normals, triangles: triangles.to_vec(), ..TileMesh::default() };
    Batch { part: PartId(0), face: FaceId(0), tile: TileId(0), worker: 0, mesh }
}

#[test]
fn a_closed_cube_is_exact() {
    let expected =
        MeshFacts { triangles: 12, vertices: 8, components: 1, area: 6.0, volume: 1.0, ..MeshFacts::default() };
    let facts = check_part(&cube());
    assert_eq!(facts, expected);
    assert!(facts.is_closed());
}

#[test]
fn a_closed_tetrahedron_is_exact() {
    let corners = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 3.0]];
    let solid = mesh(&corners, &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]);
    let facts = check_part([&solid]);
    assert_eq!((facts.triangles, facts.vertices, facts.components), (4, 4, 1));
    assert_eq!(facts.volume, 4.5);
    assert!((facts.area - (13.5 + 4.5 * 3.0_f64.sqrt())).abs() < 1e-14);
    assert!(facts.is_closed());
}

#[test]
fn a_missing_triangle_leaves_three_open_edges() {
    let mut batches = cube();
    batches[1].mesh.triangles.remove(0); // corners 4, 5, 7
    let facts = check_part(&batches);
    assert_eq!((facts.open_edges, facts.unbalanced_edges, facts.nonmanifold_edges), (3, 3, 0));
    assert_eq!(facts.unbalanced_length, 2.0 + 2.0_f64.sqrt());
    let longest = &facts.examples[0];
    assert_eq!((longest.balance, longest.uses), (1, 1));
    assert_eq!(longest.faces, [FaceId(1)]);
    // The remaining triangle runs 4 → 7.
    assert_eq!((longest.from, longest.to), (DVec3::new(0.0, 0.0, 1.0), DVec3::ONE));
    assert!(!facts.is_closed() && facts.is_well_formed());
}

#[test]
fn a_flipped_triangle_unbalances_edges_that_are_not_open() {
    let mut batches = cube();
    batches[1].mesh.triangles[0].swap(0, 1);
    let facts = check_part(&batches);
    assert_eq!((facts.open_edges, facts.unbalanced_edges), (0, 3));
    assert!(facts.examples.iter().all(|edge| edge.balance == 2 && edge.uses == 2));
    let faces: Vec<_> = facts.examples.iter().map(|edge| edge.faces.len()).collect();
    assert_eq!(faces, [1, 2, 2], "the diagonal lies inside one face");
}

#[test]
fn a_vertex_that_misses_by_one_bit_opens_the_mesh() {
    let mut batches = cube();
    batches[1].mesh.positions[2].x = f64::from_bits(1.0_f64.to_bits() + 1);
    let facts = check_part(&batches);
    assert_eq!(facts.vertices, 9);
    assert_eq!(facts.open_edges, 4);
}

#[test]
fn zero_has_no_sign() {
    let mut batches = cube();
    for point in &mut batches[1].mesh.positions {
        if point.x == 0.0 {
            point.x = -0.0;
        }
    }
    assert!(check_part(&batches).is_closed());
}

#[test]
fn degenerate_triangles_are_distinguished() {
    let points = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0; 3]];
    let facts = check_part([&mesh(&points, &[[0, 1, 2], [0, 1, 3], [0, 1, 9]])]);
    assert_eq!((facts.zero_area, facts.collapsed, facts.bad_indices), (1, 1, 1));
    assert_eq!(facts.open_edges, 3, "collapsed and broken triangles use no edges");
}

#[test]
fn vertices_that_are_not_finite_are_counted_once() {
    let mut batches = cube();
    batches[0].mesh.positions[0].x = f64::NAN;
    batches[0].mesh.normals[0].x = f32::NAN;
    batches[3].mesh.normals[1].z = f32::INFINITY;
    assert_eq!(check_part(&batches).non_finite, 2);
}

#[test]
fn solids_that_share_an_edge_stay_balanced() {
    let mut batches = cube();
    for mut batch in cube() {
        for point in &mut batch.mesh.positions {
            *point += DVec3::new(1.0, 1.0, 0.0);
        }
        batches.push(batch);
    }
    let facts = check_part(&batches);
    assert_eq!((facts.nonmanifold_edges, facts.unbalanced_edges, facts.components), (1, 0, 1));
    assert_eq!(facts.volume, 2.0);
}

#[test]
fn an_inside_out_piece_is_found() {
    let mut batches = cube();
    for mut batch in cube() {
        for point in &mut batch.mesh.positions {
            *point = 0.5 * *point + DVec3::splat(0.25);
        }
        batch.mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(0, 1));
        batches.push(batch);
    }
    let facts = check_part(&batches);
    assert_eq!((facts.components, facts.negative_components), (2, 1));
    assert!((facts.volume - 0.875).abs() < 1e-14);
}

/// A square in a slanted plane and its other side, split along the other diagonal, as a part thinner than the
/// tolerance.
#[test]
fn a_piece_without_thickness_is_not_inside_out() {
    for turn in (0..100).map(|k| DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.1 * f64::from(k))) {
        let corners = [[0.0, 0.0], [7.0, 0.0], [7.0, 9.0], [0.0, 9.0]];
        let corners = corners.map(|[x, y]| (turn * DVec3::new(x, y, 0.1) + DVec3::splat(0.3)).to_array());
        let facts = check_part([&mesh(&corners, &[[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])]);
        assert_eq!((facts.components, facts.negative_components), (1, 0), "volume {:e}", facts.volume);
        assert!(facts.is_closed());
    }
}

#[test]
fn a_scene_counts_placed_parts() {
    let turned = DAffine3::from_scale_rotation_translation(
        DVec3::splat(2.0),
        DQuat::from_rotation_z(1.0),
        DVec3::new(5.0, 6.0, 7.0),
    );
    let mirrored = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let mut frame = box_frame(DVec3::ONE, &[DAffine3::IDENTITY, turned, mirrored]);
    frame.batches.remove(4);
    let facts = check_scene(&frame);
    assert_eq!(facts.parts.len(), 1);
    assert_eq!(facts.total.triangles, 30);
    assert_eq!(facts.total.open_edges, 12);
    assert!((facts.total.area - (5.0 + 20.0 + 5.0)).abs() < 1e-12, "{}", facts.total.area);
    assert_eq!(facts.faces_without_triangles, [(PartId(0), FaceId(4))]);
    assert_eq!(facts.placed_faces_without_triangles, 3);
}

#[test]
fn unbalanced_edges_are_counted_by_cause() {
    let mut frame = box_frame(DVec3::ONE, &[DAffine3::IDENTITY]);
    // Face 5, at x = 1, is missing in the file. Its sides are edges 1 and 3 along z, and 4 and 5 along y.
    frame.batches.remove(5);
    let side = |edge: u32, z: f64| EdgeLine {
        part: PartId(0),
        edge: EdgeId(edge),
        points: [0.0, 0.0, 1.0].map(|y| DVec3::new(1.0, y, z)).to_vec(),
    };
    frame.edge_lines.extend([side(4, 0.0), side(5, 1.0)]);
    frame.scene.parts[0].free_edges = [1, 3, 4, 5].map(EdgeId).to_vec();
    let facts = check_scene(&frame).total;
    assert_eq!((facts.unbalanced_edges, facts.free_edges, facts.defects), (4, 4, 0), "{facts}");

    // An edge that is not free is a defect of the faces along it, and comes first.
    frame.scene.parts[0].free_edges.remove(2);
    let part = &check_scene(&frame).parts[0];
    assert_eq!((part.free_edges, part.defects, &part.defect_faces[..]), (3, 1, &[FaceId(0)][..]));
    assert_eq!((part.defect_length, part.examples[0].cause), (1.0, Cause::Defect));
    assert!(part.examples[1..].iter().all(|edge| matches!(edge.cause, Cause::FreeEdge(_))));

    // A reversed face unbalances its edges, except those of the opening.
    frame.batches[2].mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(0, 1));
    let part = &mut frame.scene.parts[0];
    (part.free_edges, part.not_orientable) = ([1, 3, 4, 5].map(EdgeId).to_vec(), vec![EdgeId(0)]);
    let facts = check_scene(&frame).total;
    assert_eq!((facts.free_edges, facts.not_orientable, facts.defects), (4, 1, 2), "{facts}");
}

#[test]
fn without_polylines_of_edges_every_unbalanced_edge_is_a_defect() {
    let mut frame = box_frame(DVec3::ONE, &[DAffine3::IDENTITY]);
    frame.batches.remove(5);
    frame.scene.parts[0].free_edges = vec![EdgeId(1), EdgeId(3)];
    assert_eq!(check_scene(&frame).total.defects, 2);
    frame.edge_lines.clear();
    assert_eq!(check_scene(&frame).total.defects, 4);
    assert_eq!(check_part(&frame.batches).defects, 4);
}

#[test]
fn a_torus_of_two_million_triangles_is_closed_and_has_its_volume() {
    const N: u32 = 1000;
    let angle = |k: u32| f64::from(k % N) * std::f64::consts::TAU / f64::from(N);
    let rows = 40;
    let batches: Vec<_> = (0..N / rows)
        .map(|strip| {
            let mut points = Vec::new();
            for i in strip * rows..=(strip + 1) * rows {
                for j in 0..=N {
                    let ring = 3.0 + angle(j).cos();
                    points.push([ring * angle(i).cos(), ring * angle(i).sin(), angle(j).sin()]);
                }
            }
            let quads = (0..rows).flat_map(|i| (0..N).map(move |j| i * (N + 1) + j));
            let triangles: Vec<_> = quads.flat_map(|a| [[a, a + N + 1, a + N + 2], [a, a + N + 2, a + 1]]).collect();
            mesh(&points, &triangles)
        })
        .collect();
    let facts = check_part(&batches);
    assert!(facts.is_closed(), "{facts}");
    assert_eq!(facts.vertices, u64::from(N * N));
    let exact = 2.0 * std::f64::consts::PI.powi(2) * 3.0;
    assert!((facts.volume / exact - 1.0).abs() < 1e-4);
}
