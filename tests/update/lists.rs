//! A sink that builds its picture from lists of changes alone has the whole scene and all drawn tiles after each frame,
//! whatever was edited, cancelled and refused before. A sink that leaves out an entry does not.

use crate::edits::Edit;
use crate::random::SplitMix;
use crate::{built, common, pool};
use glam::{DAffine3, DVec3};
use std::collections::BTreeSet;
use std::sync::Arc;
use trimtess::control::Alone;
use trimtess::frame::{Attributes, Tolerance};
use trimtess::mesh::{
    Batch, DrawnTiles, InstanceKey, MeshSink, PartKey, Scene, SceneChanges, SceneInstance, SinkError,
};
use trimtess::model::{Colour, Model, PartId, TileId};
use trimtess::parallel::{Session, SessionOptions};
use trimtess::prepare::{PrepareOptions, Prepared};
use trimtess::view::{CameraPath, Picture, View};

/// What a sink keeps of an instance.
#[derive(Clone, Debug, PartialEq)]
struct Row {
    key: Option<InstanceKey>,
    part: PartId,
    transform: DAffine3,
    colour: Option<Colour>,
    visible: bool,
}

impl Row {
    fn of(instance: &SceneInstance) -> Self {
        let SceneInstance { key, part, transform, colour, visible, .. } = *instance;
        Self { key, part, transform, colour, visible }
    }
}

/// A list of changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Listed {
    Removed,
    Changed,
    Added,
    Parts,
    Appeared,
    Disappeared,
}

const ALL: [Listed; 6] =
    [Listed::Removed, Listed::Changed, Listed::Added, Listed::Parts, Listed::Appeared, Listed::Disappeared];

/// View, instance, tile.
type Drawn = BTreeSet<(usize, InstanceKey, TileId)>;

/// The tiles of a set, by keys instead of rows.
fn by_key(drawn: &DrawnTiles, scene: &Scene) -> Drawn {
    let tiles = |(view, row)| drawn.tiles(view, row).map(move |tile| (view, scene.instances[row].key.unwrap(), tile));
    drawn.rows().map(|(view, row, _)| (view, row)).flat_map(tiles).collect()
}

/// Keeps what it is told by lists, and what it ought to have.
#[derive(Default)]
struct ByLists {
    rows: Vec<Row>,
    parts: Vec<Option<PartKey>>,
    drawn: Drawn,
    /// The scene of the last frame, and its drawn tiles, as a whole.
    scene: Scene,
    all_drawn: DrawnTiles,
    /// The list of which it leaves out an entry of each frame.
    leaves_out: Option<Listed>,
    /// Frames of which it left one out, and those after which it had something else than it ought to.
    left_out: usize,
    differed: usize,
    is_left_out: bool,
    /// Entries of all lists.
    entries: [usize; 6],
    /// Refuses the call after so many.
    refuse: Option<u64>,
    whole: usize,
}

impl ByLists {
    fn call(&mut self) -> Result<(), SinkError> {
        let now = self.refuse == Some(0);
        self.refuse = self.refuse.and_then(|left| left.checked_sub(1));
        if now { Err(SinkError::new("lists", std::io::Error::other("full"))) } else { Ok(()) }
    }

    /// Counts the entries of a list. Returns how many of them to take.
    fn taken(&mut self, list: Listed, count: usize) -> usize {
        self.entries[list as usize] += count;
        let less = self.leaves_out == Some(list) && count > 0;
        self.is_left_out |= less;
        count - usize::from(less)
    }

    fn place(&mut self, scene: &Scene, changes: &SceneChanges<'_>) {
        let gone: BTreeSet<InstanceKey> = changes.removed.iter().copied().collect();
        assert_eq!(gone.len(), changes.removed.len(), "a key goes twice");
        let known = |key: &InstanceKey| self.rows.iter().any(|row| row.key == Some(*key));
        assert!(gone.iter().all(known), "one goes that never came");
        assert_eq!(self.rows.len() - gone.len(), changes.first_instance);
        let removed = &changes.removed[..self.taken(Listed::Removed, gone.len())];
        self.rows.retain(|row| row.key.is_none_or(|key| !removed.contains(&key)));
        self.drawn.retain(|(_, key, _)| !removed.contains(key));
        assert!(changes.changed.is_sorted_by(|a, b| a < b));
        assert!(changes.changed.iter().all(|row| *row < changes.first_instance));
        for &row in &changes.changed[..self.taken(Listed::Changed, changes.changed.len())] {
            self.rows[row] = Row::of(&scene.instances[row]);
        }
        let new = &scene.instances[changes.first_instance..];
        let new = &new[..self.taken(Listed::Added, new.len())];
        self.rows.extend(new.iter().map(Row::of));
        self.scene = scene.clone();
    }
}

impl MeshSink for ByLists {
    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        self.whole += 1;
        self.rows = scene.instances.iter().map(Row::of).collect();
        self.parts = scene.parts.iter().map(|part| part.key).collect();
        self.drawn.clear();
        (self.scene, self.all_drawn) = (scene.clone(), DrawnTiles::default());
        self.call()
    }

    fn begin_changes(&mut self, scene: &Scene, changes: &SceneChanges<'_>) -> Result<(), SinkError> {
        assert_eq!(self.parts.len(), changes.first_part);
        let new = &scene.parts[changes.first_part..];
        let taken = self.taken(Listed::Parts, new.len());
        self.parts.extend(new[..taken].iter().map(|part| part.key));
        self.place(scene, changes);
        self.call()
    }

    fn begin_update(
        &mut self,
        scene: &Scene,
        changes: &SceneChanges<'_>,
        from: &[Option<PartId>],
    ) -> Result<(), SinkError> {
        assert_eq!((changes.first_part, changes.first_instance), (0, 0));
        let goes_on = |(from, part): (&Option<PartId>, PartId)| match from {
            Some(from) => self.parts[from.index()],
            None => {
                let key = scene.parts[part.index()].key;
                assert!(!self.parts.contains(&key), "a key that was given before");
                key
            }
        };
        self.parts = from.iter().zip((0..).map(PartId)).map(goes_on).collect();
        self.place(scene, changes);
        self.call()
    }

    fn batch(&mut self, _: &mut Batch) -> Result<(), SinkError> {
        self.call()
    }

    fn drawn(&mut self, drawn: &DrawnTiles, before: &DrawnTiles) -> Result<(), SinkError> {
        let mut difference = DrawnTiles::default();
        difference.set_difference(before, drawn);
        let gone = by_key(&difference, &self.scene);
        assert!(self.leaves_out.is_some() || gone.is_subset(&self.drawn));
        let taken = self.taken(Listed::Disappeared, gone.len());
        gone.iter().take(taken).for_each(|tile| _ = self.drawn.remove(tile));
        difference.set_difference(drawn, before);
        let new = by_key(&difference, &self.scene);
        assert!(self.leaves_out.is_some() || new.is_disjoint(&self.drawn));
        let taken = self.taken(Listed::Appeared, new.len());
        self.drawn.extend(new.into_iter().take(taken));
        self.all_drawn = drawn.clone();
        self.call()
    }

    fn end(&mut self) -> Result<(), SinkError> {
        self.call()?;
        let rows: Vec<Row> = self.scene.instances.iter().map(Row::of).collect();
        let parts: Vec<_> = self.scene.parts.iter().map(|part| part.key).collect();
        let drawn = by_key(&self.all_drawn, &self.scene);
        if !self.is_left_out {
            assert_eq!(self.rows, rows);
            assert_eq!(self.parts, parts);
            assert!(self.drawn == drawn, "{:?}", self.drawn.symmetric_difference(&drawn).next());
        }
        self.left_out += usize::from(std::mem::take(&mut self.is_left_out));
        self.differed += usize::from((&self.rows, &self.parts, &self.drawn) != (&rows, &parts, &drawn));
        (self.rows, self.parts, self.drawn) = (rows, parts, drawn);
        Ok(())
    }

    fn abort(&mut self) {
        (self.rows, self.parts, self.drawn) = Default::default();
        self.is_left_out = false;
    }
}

fn anywhere(draw: &mut SplitMix) -> DAffine3 {
    DAffine3::from_translation(DVec3::from([0; 3].map(|_| draw.range(-40.0, 40.0))))
}

fn attributes(draw: &mut SplitMix) -> Attributes {
    let colours = [None, Some([1.0, 0.0, 0.0, 1.0]), Some([0.0, 0.0, 1.0, 1.0])];
    Attributes::DEFAULT.with_visible(draw.below(3) > 0).with_colour(colours[draw.below(3) as usize])
}

/// Edits the instances of a session.
fn edit(session: &mut Session, draw: &mut SplitMix) {
    let count = session.scene().instances.len();
    let any = |draw: &mut SplitMix| session.instance_key(draw.below(count as u64) as usize);
    let Some(key) = any(draw).filter(|key| session.instance_row(*key).is_some()) else { return };
    match draw.below(6) {
        0 => {
            let part = PartId(draw.below(3) as u32);
            let new = SceneInstance { visible: draw.below(4) > 0, ..SceneInstance::new(part, anywhere(draw)) };
            let new = session.add_instance(new).unwrap();
            assert_eq!(session.instance_row(new), Some(count));
        }
        1 if count > 6 => {
            let keys: BTreeSet<InstanceKey> = (0..1 + draw.below(3)).filter_map(|_| any(draw)).collect();
            let keys: Vec<InstanceKey> = keys.into_iter().collect();
            let gone = session.remove_instances(&keys).unwrap();
            assert!(gone.iter().all(|gone| gone.key.is_none()));
        }
        2 => session.set_instance(key, &attributes(draw)).unwrap(),
        3 => session.set_part(PartId(draw.below(3) as u32), &attributes(draw)).unwrap(),
        _ => session.move_instance(key, anywhere(draw)).unwrap(),
    }
}

/// Flies over a model that is edited all the time.
struct Flight {
    session: Session,
    model: Model,
    prepared: Arc<Prepared>,
    views: Vec<View>,
}

impl Flight {
    fn start() -> Self {
        let model = built();
        let prepared = common::prepared(model.clone());
        let picture = Picture { size: (300, 200), deviation_px: 2.0, size_px: None, angle: 0.9 };
        let views = CameraPath::Zoom.views(prepared.bounds.unwrap(), 40, &picture);
        let options = SessionOptions::DEFAULT.with_workers(2).with_edge_lines(false);
        let session = Session::start_on(Arc::new(Alone), Arc::clone(&prepared), &options);
        Self { session, model, prepared, views }
    }

    /// Edits, and makes a frame.
    fn frame(&mut self, draw: &mut SplitMix, sink: &mut ByLists) {
        let Self { session, model, prepared, views } = self;
        let view = |draw: &mut SplitMix| views[draw.below(views.len() as u64) as usize];
        for _ in 0..draw.below(4) {
            edit(session, draw);
            if draw.below(4) == 0 {
                session.begin(&[view(draw)]).unwrap();
                match draw.below(16) {
                    0 => session.forget(),
                    1..8 => session.cancel(),
                    _ => {}
                }
            }
        }
        if draw.below(6) == 0 {
            Edit::ALL[draw.below(Edit::ALL.len() as u64) as usize].apply(model, &pool(), draw);
            *prepared = Arc::new(prepared.update(model.clone(), &PrepareOptions::DEFAULT).unwrap());
            let before = keys(session);
            session.update(Arc::clone(prepared)).unwrap();
            assert!(!before.is_disjoint(&keys(session)), "one edit leaves most parts");
        }
        sink.refuse = (draw.below(8) == 0).then(|| draw.below(12));
        if draw.below(24) == 0 {
            let plan = session.plan_within(&Tolerance { chord: 0.5, angle: 0.9, max_edge: None }, &Default::default());
            _ = session.frame(plan, sink);
        }
        let views = [view(draw), view(draw)];
        let count = 1 + usize::from(draw.below(4) == 0);
        let made = session.view(&views[..count], sink);
        assert!(made.is_ok() || sink.rows.is_empty());
        sink.refuse = None;
        assert_eq!(keys(session).len(), session.scene().parts.len(), "each part has its own key");
    }
}

/// The keys of all parts.
fn keys(session: &Session) -> BTreeSet<PartKey> {
    session.scene().parts.iter().map(|part| part.key.unwrap()).collect()
}

#[test]
fn lists_of_changes_are_all_that_a_sink_needs() {
    let (mut sink, mut draw) = (ByLists::default(), SplitMix(79));
    for _ in 0..5 {
        let mut flight = Flight::start();
        (0..60).for_each(|_| flight.frame(&mut draw, &mut sink));
    }
    println!("{} whole frames of 300; entries of {ALL:?}: {:?}", sink.whole, sink.entries);
    assert!(sink.whole < 150 && sink.entries.iter().all(|count| *count > 20), "{} {:?}", sink.whole, sink.entries);
}

#[test]
fn an_entry_that_is_left_out_is_missed() {
    for list in ALL {
        let (mut sink, mut draw) = (ByLists { leaves_out: Some(list), ..ByLists::default() }, SplitMix(80));
        let mut flight = Flight::start();
        (0..240).for_each(|_| flight.frame(&mut draw, &mut sink));
        let ByLists { left_out, differed, .. } = sink;
        println!("{list:?}: left out in {left_out} frames, missed in {differed}");
        // An instance that has changed may look as before: moved and moved back.
        let all = if list == Listed::Changed { left_out / 2 } else { left_out };
        assert!(left_out > 3 && differed >= all, "{list:?}: {differed} of {left_out}");
    }
}

#[test]
fn a_camera_that_moves_lists_only_other_levels_of_detail() {
    let mut flight = Flight::start();
    let Flight { session, views, .. } = &mut flight;
    let (mut sink, mut still, mut others) = (ByLists::default(), 0, 0);
    session.view(&views[..1], &mut sink).unwrap();
    for view in &views[1..] {
        let before = sink.rows.clone();
        sink.entries = [0; 6];
        let report = session.view(&[*view], &mut sink).unwrap();
        let differ = before.iter().zip(&sink.rows).filter(|(before, now)| before != now).count();
        assert_eq!((report.whole, &sink.entries[..4]), (false, &[0, differ, 0, 0][..]));
        others += differ;
        still += usize::from(report.tiles > 0 && differ == 0);
    }
    println!("{still} frames of {} with the same instances; {others} other levels of detail", views.len());
    assert!(still > 5 && others > 5, "{still} {others}");
}
