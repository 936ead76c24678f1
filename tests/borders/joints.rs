//! Borders along parts of others: T-junctions, and whole models without topology.

use crate::patches::{
    ends_where_it_is_open, left, mesh, open, part, prepared, reversed_v, right, shared, strip, transposed,
};
use glam::DVec3;
use trimtess::model::{NurbsSurface, Part};

/// Strips of a patch between these parameters, each in another orientation.
fn strips(s: &NurbsSurface, at: &[f64]) -> Vec<NurbsSurface> {
    let turned = |(k, w): (usize, &[f64])| {
        let s = strip(s, w[0], w[1]);
        match k % 3 {
            0 => s,
            1 => transposed(&s),
            _ => reversed_v(&s),
        }
    };
    at.windows(2).enumerate().map(turned).collect()
}

#[test]
fn one_border_along_two() {
    let surfaces = [vec![left()], strips(&right(), &[0.0, 0.4, 1.0])].concat();
    let prepared = prepared(part(surfaces));
    // Two along the left patch and one between the strips; three open sides of the left patch, and two of each strip.
    assert_eq!((shared(&prepared), open(&prepared).count), (3, 7));
    ends_where_it_is_open(&prepared);
}

#[test]
fn two_borders_along_three_and_more() {
    for (a, b, pieces) in [
        (vec![0.0, 0.5, 1.0], vec![0.0, 0.3, 0.7, 1.0], 4),
        (vec![0.0, 0.5, 1.0], vec![0.0, 0.2, 0.5, 1.0], 3),
        (vec![0.0, 0.1, 0.2, 0.9, 1.0], vec![0.0, 0.3, 0.31, 0.8, 1.0], 7),
    ] {
        let surfaces = [strips(&left(), &a), strips(&right(), &b)].concat();
        let count = surfaces.len();
        let prepared = prepared(part(surfaces));
        let between = count - 2;
        assert_eq!(shared(&prepared), pieces + between, "{a:?}, {b:?}");
        assert_eq!(open(&prepared).count, count + 4, "{a:?}, {b:?}");
        ends_where_it_is_open(&prepared);
    }
}

#[test]
fn borders_that_overlap_in_part_share_that_part() {
    let prepared = prepared(part([strip(&left(), 0.0, 0.7), strip(&right(), 0.2, 1.0)]));
    // Each has a piece of its own next to the common one.
    assert_eq!((shared(&prepared), open(&prepared).count), (1, 8));
    ends_where_it_is_open(&prepared);
}

#[test]
fn three_faces_along_one_border_are_cut_alike() {
    let mut third = right();
    third.points[4..].iter_mut().for_each(|p| *p = DVec3::new(3.0, p.y, p.z + p.x - 3.0));
    let surfaces =
        [strips(&left(), &[0.0, 0.5, 1.0]), strips(&right(), &[0.0, 0.3, 1.0]), strips(&third, &[0.0, 0.8, 1.0])];
    let prepared = prepared(part(surfaces.concat()));
    // Four pieces used by three faces each, and one edge within each pair of strips.
    assert_eq!(shared(&prepared), 4 + 3);
    let part = &prepared.parts[0];
    let thrice = part.edges[..part.brep_edges].iter().filter(|e| e.uses.len() == 3).count();
    assert_eq!(thrice, 4);
    ends_where_it_is_open(&prepared);
}

/// The shape, reduced to the surfaces of its faces.
fn untold(name: &str) -> Part {
    let mut part = trimtess_models::by_name(name).unwrap().parts.remove(0);
    part.faces.iter_mut().for_each(|f| f.loops.clear());
    part.edges.clear();
    part.vertices.clear();
    part
}

#[test]
fn the_teapot_without_topology_is_the_teapot() {
    let prepared = prepared(untold("teapot"));
    let open = open(&prepared);
    // Rim and lid do not touch, spout and handle pass through the body, the spout ends: four quarters of two circles,
    // two halves of four sections. Poles of lid and bottom are not edges.
    assert_eq!(open.count, 8 + 8, "{open:?}");
    ends_where_it_is_open(&prepared);
    let mut stated = trimtess_models::by_name("teapot").unwrap();
    let stated = crate::patches::prepared(stated.parts.remove(0));
    assert_eq!(shared(&prepared), shared(&stated));
    let told = stated.parts[0].open_edges();
    assert!((told.length - open.length).abs() <= 1e-6 * open.length && told.count == open.count, "{told:?}, {open:?}");
    for chord in [1e-2, 1e-3, 1e-4] {
        let [a, b] = [&prepared, &stated].map(|p| mesh(p, chord).1);
        assert_eq!((a.unbalanced_edges, a.open_edges), (b.unbalanced_edges, b.open_edges));
        // Sewn edges may run in the other direction, and rounding may count one gap as two.
        assert!(a.triangles.abs_diff(b.triangles) <= b.triangles / 1000, "{} {}", a.triangles, b.triangles);
    }
}

#[test]
fn faces_with_edges_and_faces_without_share_them() {
    // The wave's sheet, bounded by edges, and an adjacent patch without edges.
    let mut part = trimtess_models::by_name("wave").unwrap().parts.remove(0);
    let mut beside = part.faces[0].clone();
    beside.loops.clear();
    if let trimtess::model::Surface::Nurbs(s) = &mut beside.surface {
        s.points.iter_mut().for_each(|p| p.x = 12.0 - p.x);
    }
    part.faces.push(beside);
    let prepared = prepared(part);
    assert_eq!((shared(&prepared), open(&prepared).count), (1, 6));
    ends_where_it_is_open(&prepared);
}
