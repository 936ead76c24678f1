//! A sink whose memory is one block of vertices and one of indices per tile. Blocks are used again.
#![allow(dead_code, reason = "not every test uses all of it")]

use glam::{DVec3, Vec2, Vec3};
use std::collections::BTreeMap;
use std::slice::Iter;
use std::sync::{Arc, Mutex};
use trimtess::mesh::{
    DrawnTiles, EdgeLine, MeshSink, NormalFormat, PositionFormat, Scene, SceneChanges, SceneInstance, SinkError,
    TileMemory, TileMesh, WrittenTile,
};
use trimtess::model::{PartId, TileId};

/// Vertices and indices of a tile.
#[derive(Clone, Debug, Default)]
pub(crate) struct Room {
    pub(crate) vertices: Vec<u8>,
    pub(crate) indices: Vec<u8>,
}

#[derive(Debug, Default)]
struct Rooms {
    all: Vec<Room>,
    free: Vec<usize>,
    /// Calls of `write` until one is refused.
    left: Option<u32>,
    bad: Refusal,
}

/// How a call of `write` is refused.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Refusal {
    #[default]
    Error,
    Panic,
    /// Room of the wrong size.
    Short,
    /// `fill` is not called.
    Nothing,
}

/// The memory.
#[derive(Debug, Default)]
pub(crate) struct Blocks(Mutex<Rooms>);

impl Blocks {
    /// Refuses the call after `left` more.
    pub(crate) fn refuse(&self, left: Option<u32>, bad: Refusal) {
        let mut rooms = self.0.lock().expect("no panic");
        (rooms.left, rooms.bad) = (left, bad);
    }

    /// Rooms in use.
    pub(crate) fn used(&self) -> usize {
        let rooms = self.0.lock().expect("no panic");
        rooms.all.len() - rooms.free.len()
    }

    pub(crate) fn room(&self, tile: &WrittenTile) -> Room {
        self.0.lock().expect("no panic").all[tile.place as usize].clone()
    }
}

fn refused() -> SinkError {
    SinkError::new("blocks", std::io::ErrorKind::OutOfMemory)
}

impl TileMemory for Blocks {
    fn write(&self, tile: &WrittenTile, fill: &mut dyn FnMut(&mut [u8], &mut [u8])) -> Result<u64, SinkError> {
        let (place, mut room, bad) = {
            let mut rooms = self.0.lock().expect("no panic");
            let bad = rooms.left == Some(0);
            rooms.left = rooms.left.map(|left| left.saturating_sub(1));
            let bad = bad.then_some(rooms.bad);
            if bad == Some(Refusal::Error) {
                return Err(refused());
            }
            if bad == Some(Refusal::Panic) {
                drop(rooms);
                panic!("no more room");
            }
            let place = rooms.free.pop().unwrap_or_else(|| {
                rooms.all.push(Room::default());
                rooms.all.len() - 1
            });
            (place, std::mem::take(&mut rooms.all[place]), bad)
        };
        let short = usize::from(bad == Some(Refusal::Short));
        room.vertices.resize(tile.vertex_bytes() - short, 0xee);
        room.indices.resize(tile.index_bytes(), 0xee);
        if bad != Some(Refusal::Nothing) {
            fill(&mut room.vertices, &mut room.indices);
        }
        self.0.lock().expect("no panic").all[place] = room;
        Ok(place as u64)
    }

    fn release(&self, tile: &WrittenTile) {
        self.0.lock().expect("no panic").free.push(tile.place as usize);
    }
}

/// The sink.
#[derive(Debug, Default)]
pub(crate) struct BlockSink {
    pub(crate) memory: Arc<Blocks>,
    pub(crate) scene: Scene,
    pub(crate) tiles: BTreeMap<(PartId, TileId), WrittenTile>,
    pub(crate) drawn: DrawnTiles,
    /// Calls of any kind, and of `abort`.
    pub(crate) calls: usize,
    pub(crate) aborts: usize,
    /// Refuses the call with this number, counted from now.
    pub(crate) refuse: Option<usize>,
    /// Takes so many written tiles of the next call, and then does this.
    pub(crate) takes: Option<(usize, Refusal)>,
    new: Vec<WrittenTile>,
    whole: bool,
}

impl BlockSink {
    fn call(&mut self) -> Result<(), SinkError> {
        self.calls += 1;
        let now = self.refuse == Some(0);
        self.refuse = self.refuse.and_then(|left| left.checked_sub(1));
        if now { Err(refused()) } else { Ok(()) }
    }

    fn start(&mut self, scene: &Scene, changes: &SceneChanges<'_>, whole: bool) -> Result<(), SinkError> {
        self.call()?;
        self.scene.parts.truncate(changes.first_part);
        self.scene.parts.extend_from_slice(&scene.parts[changes.first_part..]);
        changes.apply(scene, &mut self.scene.instances, SceneInstance::clone);
        self.whole = whole;
        Ok(())
    }
}

impl MeshSink for BlockSink {
    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        self.start(scene, &SceneChanges::default(), true)
    }

    fn begin_changes(&mut self, scene: &Scene, changes: &SceneChanges<'_>) -> Result<(), SinkError> {
        self.start(scene, changes, false)
    }

    fn begin_update(
        &mut self,
        scene: &Scene,
        changes: &SceneChanges<'_>,
        from: &[Option<PartId>],
    ) -> Result<(), SinkError> {
        self.start(scene, changes, false)?;
        let mut old = std::mem::take(&mut self.tiles);
        for (part, from) in (0..).map(PartId).zip(from) {
            let tiles = old.keys().copied().filter(|(part, _)| Some(*part) == *from).collect::<Vec<_>>();
            for key in tiles {
                let tile = old.remove(&key).expect("a key of it");
                self.tiles.insert((part, key.1), WrittenTile { part, ..tile });
            }
        }
        old.values().for_each(|tile| self.memory.release(tile));
        Ok(())
    }

    fn batch(&mut self, _: &mut trimtess::mesh::Batch) -> Result<(), SinkError> {
        panic!("tiles are written into memory")
    }

    fn written(&mut self, tiles: &mut Iter<'_, WrittenTile>) -> Result<(), SinkError> {
        if let Some((most, bad)) = self.takes.take() {
            self.new.extend(tiles.take(most));
            return match bad {
                Refusal::Error => Err(refused()),
                Refusal::Panic => panic!("no more tiles"),
                Refusal::Short | Refusal::Nothing => Ok(()),
            };
        }
        tiles.try_for_each(|tile| {
            self.new.push(*tile);
            self.call()
        })
    }

    fn edge_line(&mut self, _: EdgeLine) -> Result<(), SinkError> {
        self.call()
    }

    fn drawn(&mut self, drawn: &DrawnTiles, _: &DrawnTiles) -> Result<(), SinkError> {
        self.drawn.clone_from(drawn);
        self.call()
    }

    fn end(&mut self) -> Result<(), SinkError> {
        self.call()?;
        if self.whole {
            std::mem::take(&mut self.tiles).values().for_each(|tile| self.memory.release(tile));
        }
        for tile in self.new.drain(..) {
            let key = (tile.part, tile.tile);
            let old = if tile.triangles > 0 { self.tiles.insert(key, tile) } else { self.tiles.remove(&key) };
            old.iter().for_each(|old| self.memory.release(old));
        }
        Ok(())
    }

    fn abort(&mut self) {
        self.aborts += 1;
        self.new.drain(..).filter(|tile| tile.triangles > 0).for_each(|tile| self.memory.release(&tile));
    }
}

/// Reads attributes one after the other.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn next<const N: usize>(&mut self) -> [u8; N] {
        let (head, tail) = self.0.split_first_chunk().unwrap();
        self.0 = tail;
        *head
    }

    fn f32s<const N: usize>(&mut self) -> [f32; N] {
        std::array::from_fn(|_| f32::from_le_bytes(self.next()))
    }
}

/// The mesh that the bytes of a tile mean, without what the layout leaves out; tangents; and the words of the origins.
pub(crate) fn decoded(
    tile: &WrittenTile,
    Room { vertices, indices }: &Room,
    centre: DVec3,
) -> (TileMesh, Vec<Vec3>, Vec<[u32; 3]>) {
    let (mut mesh, mut tangents, mut origins) = (TileMesh::default(), Vec::new(), Vec::new());
    for vertex in vertices.chunks_exact(tile.layout.stride()) {
        let mut rest = Reader(vertex);
        mesh.positions.push(match tile.layout.position {
            PositionFormat::F64 => DVec3::from(std::array::from_fn(|_| f64::from_le_bytes(rest.next()))),
            PositionFormat::F32 => centre + Vec3::from(rest.f32s()).as_dvec3(),
            _ => {
                let grid = tile.grid.unwrap();
                let [x, y, z, zero] = std::array::from_fn(|_| u16::from_le_bytes(rest.next()));
                assert_eq!(zero, 0);
                let corner = DVec3::from(grid.corner.map(f64::from));
                centre + grid.step * (corner + DVec3::from([x, y, z].map(f64::from)))
            }
        });
        match tile.layout.normal {
            NormalFormat::F32 => mesh.normals.push(Vec3::from(rest.f32s())),
            NormalFormat::Octahedral => {
                let [x, y] = std::array::from_fn(|_| f32::from(i16::from_le_bytes(rest.next())) / 32_767.0);
                let z = 1.0 - x.abs() - y.abs();
                let below = (-z).max(0.0);
                mesh.normals.push(Vec3::new(x - below.copysign(x), y - below.copysign(y), z).normalize());
            }
            _ => {}
        }
        if tile.layout.uv {
            mesh.uvs.push(Vec2::from(rest.f32s()));
        }
        if tile.layout.tangent {
            tangents.push(Vec3::from(rest.f32s()));
        }
        if tile.layout.origin {
            origins.push(std::array::from_fn(|_| u32::from_le_bytes(rest.next())));
        }
        assert!(rest.0.is_empty());
    }
    let corners: Vec<u32> = if tile.wide {
        indices.chunks_exact(4).map(|bytes| u32::from_le_bytes(bytes.try_into().unwrap())).collect()
    } else {
        indices.chunks_exact(2).map(|bytes| u16::from_le_bytes(bytes.try_into().unwrap()).into()).collect()
    };
    mesh.triangles = corners.chunks_exact(3).map(|corners| corners.try_into().unwrap()).collect();
    (mesh, tangents, origins)
}
