//! Hands -> the order in which a commit takes their tiles.

use super::handoff::Hand;
use crate::mesh::Scene;
use crate::model::{FaceId, PartId};

/// Where a tile of a frame is made, and then found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Seat {
    pub(super) worker: u32,
    /// In the worker's hand, and in its delivery.
    pub(super) row: u32,
}

/// All tiles that workers own. Known when they are dealt, so that no frame has to sort what it made.
#[derive(Debug, Default)]
pub(super) struct Seats {
    /// Ascending by (part, tile).
    seats: Vec<Seat>,
    /// By part: the number of its tiles, and of the tiles of each face.
    parts: Vec<(usize, Vec<u32>)>,
}

impl Seats {
    pub(super) fn of(hands: &[Hand]) -> Self {
        let tiles = || {
            (0..).zip(hands).flat_map(|(worker, hand): (u32, &Hand)| {
                let rows = (0..).zip(&hand.tiles);
                rows.map(move |(row, tile)| (Seat { worker, row }, *tile))
            })
        };
        let mut parts: Vec<(usize, Vec<u32>)> = Vec::new();
        // One more than the highest tile of each part.
        let mut ends: Vec<usize> = Vec::new();
        for (_, (part, tile, face)) in tiles() {
            let (part, face) = (part.index(), face.index());
            if parts.len() <= part {
                parts.resize_with(part + 1, Default::default);
                ends.resize(part + 1, 0);
            }
            let (count, of_face) = &mut parts[part];
            of_face.resize(of_face.len().max(face + 1), 0);
            of_face[face] += 1;
            *count += 1;
            ends[part] = ends[part].max(tile.index() + 1);
        }
        let mut all = 0;
        for end in &mut ends {
            all += std::mem::replace(end, all);
        }
        let (starts, mut seats) = (ends, vec![None; all]);
        for (seat, (part, tile, _)) in tiles() {
            seats[starts[part.index()] + tile.index()] = Some(seat);
        }
        Self { seats: seats.into_iter().flatten().collect(), parts }
    }

    /// The seats of the first `parts` parts.
    pub(super) fn of_first(&self, parts: usize) -> &[Seat] {
        let tiles = self.parts.iter().take(parts).map(|(count, _)| count).sum();
        &self.seats[..tiles]
    }

    /// The faces of `scene` without triangles, if these are the faces of all tiles that have none.
    pub(super) fn without_triangles(&self, scene: &Scene, mut of_bare: Vec<(PartId, FaceId)>) -> Vec<(PartId, FaceId)> {
        of_bare.sort_unstable();
        let tiles = |(part, face): (PartId, FaceId)| -> usize {
            let of_part = self.parts.get(part.index()).and_then(|(_, of_face)| of_face.get(face.index()));
            of_part.map_or(0, |&count| count as usize)
        };
        let bare = of_bare.chunk_by(|a, b| a == b).filter(|of_face| of_face.len() == tiles(of_face[0]));
        let mut faces: Vec<_> = bare.map(|of_face| of_face[0]).collect();
        for (part, of_scene) in scene.parts.iter().enumerate() {
            let known = self.parts.get(part).map_or(&[][..], |(_, of_face)| of_face);
            let none = known.iter().enumerate().filter(|(_, count)| **count == 0).map(|(face, _)| face);
            let others = none.chain(known.len()..of_scene.face_colours.len());
            faces.extend(others.map(|face| (PartId::new(part), FaceId::new(face))));
        }
        faces
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::ScenePart;
    use crate::model::TileId;

    #[test]
    fn seats_are_in_the_order_of_tiles_and_count_those_of_faces() {
        let row = |part, tile, face| (PartId(part), TileId(tile), FaceId(face));
        let tiles = [
            vec![row(0, 1, 0), row(1, 5, 2)],
            vec![row(0, 0, 0), row(0, 2, 2), row(1, 3, 0)],
            vec![],
            vec![row(1, 4, 2)],
        ];
        let hands = tiles.clone().map(|tiles| Hand { tiles, edges: Vec::new() });
        let seats = Seats::of(&hands);
        let found = |parts| {
            let of = |seat: &Seat| tiles[seat.worker as usize][seat.row as usize];
            seats.of_first(parts).iter().map(of).collect::<Vec<_>>()
        };
        let mut all = tiles.concat();
        all.sort_unstable();
        assert_eq!(found(9), all);
        assert_eq!(found(1), all[..3]);
        assert_eq!(found(0), []);

        let part = |faces| ScenePart { face_colours: vec![None; faces], ..ScenePart::default() };
        let scene = Scene { parts: vec![part(3), part(4)], ..Scene::default() };
        let face = |part, face| (PartId(part), FaceId(face));
        let never = [face(0, 1), face(1, 1), face(1, 3)];
        let mut bare = seats.without_triangles(&scene, vec![face(1, 2), face(0, 2), face(0, 0)]);
        bare.sort_unstable();
        assert_eq!(bare, [vec![never[0], face(0, 2)], never[1..].to_vec()].concat());
        assert_eq!(seats.without_triangles(&scene, vec![face(1, 2); 2]), [&[face(1, 2)][..], &never].concat());
    }
}
