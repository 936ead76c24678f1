//! Seconds of an update after one hole has moved, against seconds of preparing the whole model: by the number of faces
//! of the part with the hole. Also the first frame of a session that goes on, against that of a new session.
//!
//! ```sh
//! cargo bench --bench reload -- FILE [ROUNDS]
//! ```
//!
//! Prints a table; the least of all rounds counts. Only parts with a hole are listed, and of those with the same number
//! of faces the first. `nothing` is an update by the same model. *by faces*: with `PrepareOptions::keep_faces`.

use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};
use trimtess::control::{Control, Rayon};
use trimtess::import::step::{StepOptions, read_file};
use trimtess::mesh::MemorySink;
use trimtess::model::{Loop, Model, Part, Surface};
use trimtess::parallel::{Session, SessionOptions};
use trimtess::prepare::{PrepareOptions, Prepared, prepare_on};
use trimtess::view::{CameraPath, Picture, View};

const PICTURE: Picture = Picture { size: (1920, 1080), deviation_px: 0.5, size_px: None, angle: 0.5 };
const OPTIONS: [PrepareOptions; 2] = [PrepareOptions::DEFAULT, PrepareOptions::DEFAULT.with_keep_faces(true)];

/// Moves the first hole of a part by a thousandth of its radius along the axis, with its edges and vertices. Returns
/// whether there is one.
fn move_hole(part: &mut Part) -> bool {
    let hole = part.faces.iter_mut().find_map(|face| match &mut face.surface {
        Surface::Cylinder { frame, radius } => Some((frame, 1e-3 * *radius, &face.loops)),
        _ => None,
    });
    let Some((frame, by, loops)) = hole else { return false };
    let by = by * frame.x;
    frame.origin += by;
    let edges = loops.iter().filter_map(|of| if let Loop::Edges(uses) = of { Some(uses) } else { None }).flatten();
    let mut vertices = Vec::new();
    let mut edges: Vec<_> = edges.map(|used| used.edge).collect();
    edges.sort_unstable();
    edges.dedup();
    for edge in edges {
        let edge = &mut part.edges[edge.index()];
        edge.curve.points.iter_mut().for_each(|point| *point += by);
        vertices.extend([edge.start, edge.end]);
    }
    vertices.sort_unstable();
    vertices.dedup();
    vertices.into_iter().for_each(|vertex| part.vertices[vertex.index()] += by);
    true
}

/// The least time of some rounds.
fn least<T>(rounds: usize, mut work: impl FnMut() -> T) -> Duration {
    let round = |_| {
        let start = Instant::now();
        let made = black_box(work());
        let took = start.elapsed();
        drop(made);
        took
    };
    (0..rounds.max(1)).map(round).min().unwrap_or_default()
}

fn row(name: &str, faces: usize, took: &[Duration], of: Duration) {
    let of = of.as_secs_f64();
    let times = took.iter().map(|took| format!("{:.2} | {:.4}", 1e3 * took.as_secs_f64(), took.as_secs_f64() / of));
    println!("| {name} | {faces} | {} |", times.collect::<Vec<_>>().join(" | "));
}

/// First frame of a session that goes on with `next`, against that of a new one.
fn first_frames(prepared: &Arc<Prepared>, next: &Arc<Prepared>, view: View, rounds: usize) -> (Duration, Duration) {
    let mut sink = MemorySink::default();
    let start = |prepared| Session::start(Arc::clone(prepared), &SessionOptions::DEFAULT).expect("threads");
    let mut session = start(prepared);
    session.view(&[view], &mut sink).expect("a frame");
    let mut models = [next, prepared].into_iter().cycle();
    let update = least(2 * rounds, || {
        session.update(Arc::clone(models.next().expect("a cycle"))).expect("a session");
        session.view(&[view], &mut sink).expect("a frame")
    });
    let new = least(rounds, || start(next).view(&[view], &mut MemorySink::default()).expect("a frame"));
    (update, new)
}

fn main() {
    let mut words = std::env::args().skip(1).filter(|word| word != "--bench");
    let Some(file) = words.next() else {
        println!("usage: cargo bench --bench reload -- FILE [ROUNDS]");
        return;
    };
    let rounds = words.next().and_then(|word| word.parse().ok()).unwrap_or(10);
    let model: Model = read_file(Path::new(&file), &StepOptions::DEFAULT).expect("a STEP file");
    let (jobs, control) = (&Rayon, &Control::default());
    let kept = OPTIONS.map(|options| Arc::new(prepare_on(jobs, &model, &options, control).expect("within the limits")));
    let faces: usize = model.parts.iter().map(|part| part.faces.len()).sum();
    println!("{file}: {} parts, {faces} faces", model.parts.len());
    kept.iter().for_each(|prepared| println!("{:?}", prepared.memory()));
    let [all, with] = OPTIONS
        .map(|options| least(rounds, || prepare_on(jobs, &model, &options, control).expect("within the limits")));
    println!("prepare: {:.1} ms, faces kept: {:.1} ms", 1e3 * all.as_secs_f64(), 1e3 * with.as_secs_f64());
    println!("| part | faces | by parts, ms | share | by faces, ms | share |\n|---|---|---|---|---|---|");
    let update = |model: &Model| {
        [0, 1].map(|way: usize| {
            least(rounds, || kept[way].update_on(jobs, model, &OPTIONS[way], control).expect("within the limits"))
        })
    };
    row("nothing", 0, &update(&model), all);
    let mut parts: Vec<usize> = (0..model.parts.len()).collect();
    parts.sort_by_key(|&part| model.parts[part].faces.len());
    parts.dedup_by_key(|&mut part| model.parts[part].faces.len());
    let mut edited = Vec::new();
    for part in parts {
        let mut other = model.clone();
        if move_hole(&mut other.parts[part]) {
            row(&part.to_string(), other.parts[part].faces.len(), &update(&other), all);
            edited.push(other);
        }
    }
    let [prepared, _] = kept;
    println!("| first frame | faces | update, ms | share |\n|---|---|---|---|");
    let bounds = prepared.bounds.expect("a placed model");
    let view = CameraPath::Orbit.views(bounds, 8, &PICTURE)[0];
    for other in [edited.get(edited.len() / 2), edited.last()].into_iter().flatten() {
        let next = Arc::new(prepared.update_on(jobs, other, &OPTIONS[0], control).expect("within"));
        let changed = (0..next.parts.len()).find(|&k| !Arc::ptr_eq(&next.parts[k], &prepared.parts[k])).unwrap_or(0);
        let (update, new) = first_frames(&prepared, &next, view, rounds);
        row(&changed.to_string(), other.parts[changed].faces.len(), &[update], new);
    }
}
