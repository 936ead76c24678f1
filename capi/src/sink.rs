//! Callbacks of C as the sink of frames.

use crate::border::{Caller, User, versioned, zeros};
use crate::memory::{refused, tt_tile, written};
use crate::mesh::{as_line, tt_line};
use crate::prepared::{instance, tt_instance};
use crate::status::Failure;
use crate::version::TT_NONE;
use std::ffi::c_void;
use std::ptr::null;
use std::slice::Iter;
use trimtess::mesh::{
    Batch, DrawnTiles, EdgeLine, InstanceKey, MeshLists, MeshSink, Scene, SceneChanges, SinkError, WrittenTile,
};
use trimtess::model::PartId;

/// What a frame shows, as `tt_sink.begin` gets it. Pointers are valid until the callback returns.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_scene {
    /// `sizeof(tt_scene)` of the library.
    pub size: u32,
    /// 1 if the frame replaces everything sent before; 0 if it equals the last frame except for what is sent now.
    pub whole: u32,
    /// Number of parts: those of the prepared model, then further levels of detail. They stay, and others may follow,
    /// until `tt_session_update`.
    pub parts: u32,
    /// Number of instances.
    pub instances: u32,
    /// For each part the part of the prepared model of which it is another level of detail; TT_NONE for those
    /// themselves. Levels have the tiles, the centre and the faces of their part.
    pub mesh_of: *const u32,
    /// The instances. Each names the level of detail that it draws.
    pub placed: *const tt_instance,
    /// In the first frame after `tt_session_update`, if it is not a whole one: for each part the part of the last frame
    /// whose tiles and lines it starts with, TT_NONE if it starts with none. None is named twice; tiles and lines of
    /// parts that are not named go. Null in other frames.
    pub from: *const u32,
    /// The keys of the instances, which the session's functions take; 0 in frames by a tolerance.
    pub keys: *const u64,
    /// The first part that is new. All later ones are. 0 in a whole frame, and where `from` tells.
    pub first_part: u32,
    /// The first instance that is new. All later ones are. Those before it were in the last frame, in the same order.
    pub first_instance: u32,
    /// Number of `removed`.
    pub removed_count: u32,
    /// Number of `changed`.
    pub changed_count: u32,
    /// Keys of instances of the last frame that are gone, each once.
    pub removed: *const u64,
    /// Indices of instances of the last frame whose level of detail, transform, colour or `hidden` may differ,
    /// ascending. `first_face` differs after removed ones, too; these are not listed.
    pub changed: *const u32,
}

/// The tiles to draw, as `tt_sink.drawn` gets them. Pointers are valid until the callback returns.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_drawn {
    /// `sizeof(tt_drawn)` of the library.
    pub size: u32,
    /// 1 if every instance draws all of its tiles in every view; there are no rows then.
    pub everything: u32,
    /// Number of views.
    pub views: u32,
    /// Number of `rows`.
    pub count: u32,
    /// What each instance draws that draws anything, by view, then by instance.
    pub rows: *const tt_drawn_row,
    /// Bits of tiles: tile t of an instance is bit `t % 64` of word `t / 64` of its row, the lowest bit first.
    pub words: *const u64,
    /// Number of `appeared`.
    pub appeared_count: u32,
    /// Number of `disappeared`.
    pub disappeared_count: u32,
    /// The tiles among these that the last frame did not draw, as `rows`. Their bits are in `words`, too.
    pub appeared: *const tt_drawn_row,
    /// The tiles that the last frame drew and this one does not, as `rows`: those of instances that there still are, by
    /// their indices now. An instance with another level of detail draws the tiles of that, also those that are in
    /// neither list.
    pub disappeared: *const tt_drawn_row,
}

/// The tiles that an instance draws in a view.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_drawn_row {
    pub view: u32,
    /// One of those of `tt_scene`.
    pub instance: u32,
    /// Where its words start.
    pub start: u32,
    /// Number of its words, at least 1. Tiles beyond them are not drawn.
    pub count: u32,
}

/// Who receives frames. Calls come on the thread that called the session, before that call returns, in this order:
/// `begin`, `tile`, `line` by (part, edge), `drawn`, then `end` or `abort`. Tiles come by (part, tile); in sessions
/// with a layout first those that are evicted, then those of each worker, of which some may be gone, too. A frame in
/// which nothing changes has no calls.
///
/// A function that returns another number than 0 refuses the frame: `abort` is called, the session's call returns
/// TT_ERROR_CALLBACK, and the next frame is a whole one. All but `tile` may be null.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct tt_sink {
    /// `sizeof(tt_sink)`.
    pub size: u32,
    /// 0.
    pub reserved: u32,
    /// Passed to the functions.
    pub user: *mut c_void,
    /// Starts a frame.
    pub begin: Option<extern "C" fn(user: *mut c_void, scene: *const tt_scene) -> i32>,
    /// Receives a tile, which replaces the one of the same part and number. One without triangles is gone. In sessions
    /// with a layout its room is the sink's from now on, also if this refuses it.
    pub tile: Option<extern "C" fn(user: *mut c_void, tile: *const tt_tile) -> i32>,
    /// Receives the polyline of an edge, which replaces the one of the same part and edge.
    pub line: Option<extern "C" fn(user: *mut c_void, line: *const tt_line) -> i32>,
    /// Receives the tiles to draw, once per frame of views. There are no cracks between them; tiles that are not drawn
    /// may be several frames old. Frames by a tolerance draw everything and skip this.
    pub drawn: Option<extern "C" fn(user: *mut c_void, drawn: *const tt_drawn) -> i32>,
    /// Completes the frame.
    pub end: Option<extern "C" fn(user: *mut c_void) -> i32>,
    /// Discards the frame, and all before it.
    pub abort: Option<extern "C" fn(user: *mut c_void)>,
}
versioned!(tt_sink, reserved);

type On<T> = extern "C" fn(*mut c_void, *const T) -> i32;

/// Lists that live as long as the session, so that a frame allocates none.
#[derive(Default)]
pub(crate) struct Lists {
    mesh_of: Vec<u32>,
    from: Vec<u32>,
    placed: Vec<tt_instance>,
    keys: Vec<u64>,
    changed: Vec<u32>,
    removed: Vec<u64>,
    rows: Vec<tt_drawn_row>,
    words: Vec<u64>,
    difference: DrawnTiles,
}

impl Lists {
    /// Appends the rows of a set of tiles. Returns their number.
    fn list(&mut self, tiles: &DrawnTiles) -> usize {
        let before = self.rows.len();
        for (view, instance, of_row) in tiles.rows() {
            let (start, count) = (self.words.len() as u32, of_row.len() as u32);
            self.rows.push(tt_drawn_row { view: view as u32, instance: instance as u32, start, count });
            self.words.extend(of_row);
        }
        self.rows.len() - before
    }

    /// As [`list`](Self::list), of the tiles of `all` that `others` do not have.
    fn list_difference(&mut self, all: &DrawnTiles, others: &DrawnTiles) -> usize {
        let mut difference = std::mem::take(&mut self.difference);
        difference.set_difference(all, others);
        let count = self.list(&difference);
        self.difference = difference;
        count
    }
}

/// A [`tt_sink`] in use.
pub(crate) struct Sink<'a> {
    user: User,
    begin: Option<On<tt_scene>>,
    tile: On<tt_tile>,
    line: Option<On<tt_line>>,
    drawn: Option<On<tt_drawn>>,
    end: Option<extern "C" fn(*mut c_void) -> i32>,
    abort: Option<extern "C" fn(*mut c_void)>,
    lists: &'a mut Lists,
}

fn took(name: &str, number: i32) -> Result<(), SinkError> {
    if number == 0 { Ok(()) } else { Err(refused(name, number)) }
}

impl<'a> Sink<'a> {
    pub(crate) fn of(c: &Caller, from: *const tt_sink, lists: &'a mut Lists) -> Result<Self, Failure> {
        let tt_sink { user, begin, tile, line, drawn, end, abort, .. } = c.read("sink", from)?;
        let tile = tile.ok_or_else(|| Failure::argument("sink.tile must be a function"))?;
        Ok(Self { user: User::of(user), begin, tile, line, drawn, end, abort, lists })
    }

    fn start(
        &mut self,
        scene: &Scene,
        changes: Option<&SceneChanges<'_>>,
        kept: Option<&[Option<PartId>]>,
    ) -> Result<(), SinkError> {
        let Lists { mesh_of, from, placed, keys, changed, removed, .. } = self.lists;
        let (whole, changes) = (changes.is_none(), changes.copied().unwrap_or_default());
        from.clear();
        from.extend(kept.into_iter().flatten().map(|part| part.map_or(TT_NONE, |part| part.0)));
        mesh_of.truncate(changes.first_part);
        mesh_of.extend(scene.parts[changes.first_part..].iter().map(|part| part.mesh_of.map_or(TT_NONE, |of| of.0)));
        changes.apply(scene, placed, instance);
        changes.apply(scene, keys, |instance| instance.key.map_or(0, InstanceKey::to_bits));
        changed.clear();
        changed.extend(changes.changed.iter().map(|row| *row as u32));
        removed.clear();
        removed.extend(changes.removed.iter().map(|key| key.to_bits()));
        let Some(begin) = self.begin else { return Ok(()) };
        let scene = tt_scene {
            size: size_of::<tt_scene>() as u32,
            whole: whole.into(),
            parts: mesh_of.len() as u32,
            instances: placed.len() as u32,
            mesh_of: mesh_of.as_ptr(),
            placed: placed.as_ptr(),
            from: if kept.is_some() { from.as_ptr() } else { null() },
            keys: keys.as_ptr(),
            first_part: changes.first_part as u32,
            first_instance: changes.first_instance as u32,
            removed_count: removed.len() as u32,
            changed_count: changed.len() as u32,
            removed: removed.as_ptr(),
            changed: changed.as_ptr(),
        };
        took("tt_sink.begin", begin(self.user.get(), &scene))
    }
}

impl MeshSink for Sink<'_> {
    /// What a `tt_tile` has.
    fn reads(&self) -> MeshLists {
        MeshLists { uvs: true, ..MeshLists::NONE }
    }

    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        self.start(scene, None, None)
    }

    fn begin_changes(&mut self, scene: &Scene, changes: &SceneChanges<'_>) -> Result<(), SinkError> {
        self.start(scene, Some(changes), None)
    }

    fn begin_update(
        &mut self,
        scene: &Scene,
        changes: &SceneChanges<'_>,
        from: &[Option<PartId>],
    ) -> Result<(), SinkError> {
        self.start(scene, Some(changes), Some(from))
    }

    fn batch(&mut self, batch: &mut Batch) -> Result<(), SinkError> {
        let mesh = &batch.mesh;
        let tile = tt_tile {
            size: size_of::<tt_tile>() as u32,
            part: batch.part.0,
            face: batch.face.0,
            tile: batch.tile.0,
            worker: batch.worker,
            vertices: mesh.positions.len() as u32,
            triangles: mesh.triangles.len() as u32,
            index_bytes: 4,
            positions: mesh.positions.as_ptr().cast(),
            normals: mesh.normals.as_ptr().cast(),
            uvs: mesh.uvs.as_ptr().cast(),
            indices: mesh.triangles.as_ptr().cast(),
            ..zeros()
        };
        took("tt_sink.tile", (self.tile)(self.user.get(), &tile))
    }

    fn written(&mut self, tiles: &mut Iter<'_, WrittenTile>) -> Result<(), SinkError> {
        tiles.try_for_each(|tile| took("tt_sink.tile", (self.tile)(self.user.get(), &written(tile))))
    }

    fn edge_line(&mut self, line: EdgeLine) -> Result<(), SinkError> {
        let Some(to) = self.line else { return Ok(()) };
        took("tt_sink.line", to(self.user.get(), &as_line(&line)))
    }

    fn drawn(&mut self, drawn: &DrawnTiles, before: &DrawnTiles) -> Result<(), SinkError> {
        let Some(to) = self.drawn else { return Ok(()) };
        let lists = &mut *self.lists;
        lists.rows.clear();
        lists.words.clear();
        let count = lists.list(drawn);
        let appeared = lists.list_difference(drawn, before);
        let disappeared = lists.list_difference(before, drawn);
        let Lists { rows, words, .. } = lists;
        let given = tt_drawn {
            size: size_of::<tt_drawn>() as u32,
            everything: drawn.is_everything().into(),
            views: drawn.views() as u32,
            count: count as u32,
            rows: rows.as_ptr(),
            words: words.as_ptr(),
            appeared_count: appeared as u32,
            disappeared_count: disappeared as u32,
            appeared: rows[count..].as_ptr(),
            disappeared: rows[count + appeared..].as_ptr(),
        };
        took("tt_sink.drawn", to(self.user.get(), &given))
    }

    fn end(&mut self) -> Result<(), SinkError> {
        self.end.map_or(Ok(()), |end| took("tt_sink.end", end(self.user.get())))
    }

    fn abort(&mut self) {
        if let Some(abort) = self.abort {
            abort(self.user.get());
        }
    }
}
