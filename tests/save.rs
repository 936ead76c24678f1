//! Saving on threads of the caller's: progress, and a cancelled save that leaves what was there.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod folders;

use folders::{folder, names};
use glam::DAffine3;
use std::fs;
use std::path::Path;
use std::sync::{Arc, Mutex};
use trimtess::control::{Alone, Control, Jobs, Progress, Stage, Threads};
use trimtess::frame::{Tolerance, plan};
use trimtess::mesh::MemorySink;
use trimtess::model::{Instance, Model, PartId, shapes};
use trimtess::out::{Format, MeshLevel, Outputs, SaveError, SaveOptions, save_on, write_on};
use trimtess::parallel::serial;
use trimtess::prepare::{PrepareOptions, prepare};

/// Some shapes, one of them twice more.
fn frame(chord: f64) -> MemorySink {
    let parts = [shapes::washer(), shapes::torus(), shapes::flower(), shapes::wave()];
    let places = [0, 1, 2, 3, 1, 1].map(|part| Instance::new(PartId(part), DAffine3::IDENTITY));
    let model = Model { parts: parts.to_vec(), instances: places.to_vec(), ..Model::default() };
    let prepared = Arc::new(prepare(model, &PrepareOptions::DEFAULT).unwrap());
    let plan = Arc::new(plan(&prepared, &Tolerance { chord, angle: 0.5, max_edge: None }));
    let mut frame = MemorySink::default();
    serial(&prepared, &plan, true, &mut frame).unwrap();
    frame
}

/// A control that is cancelled once `after` units are done, and what its observer hears.
fn stopped(after: u64) -> (Control, Arc<Mutex<Vec<Progress>>>) {
    let (own, heard) = (Arc::<Mutex<Option<Control>>>::default(), Arc::<Mutex<Vec<Progress>>>::default());
    let (reader, writer) = (Arc::clone(&own), Arc::clone(&heard));
    let control = Control::observed_by(move |progress| {
        writer.lock().unwrap().push(progress);
        if progress.done >= after {
            reader.lock().unwrap().iter().for_each(Control::cancel);
        }
    });
    *own.lock().unwrap() = Some(control.clone());
    (control, heard)
}

fn assert_grows(heard: &[Progress]) {
    assert!(heard.is_sorted_by(|a, b| a.done < b.done), "{heard:?}");
    let first = heard[0];
    assert!(heard.iter().all(|told| (told.stage, told.total) == (Stage::Write, first.total)) && first.done == 0);
}

#[test]
fn tiles_are_counted_when_their_bytes_are_made_and_when_they_are_written() {
    let (frame, path) = (frame(0.05), folder("progress").join("mesh"));
    let of_part = |part| frame.batches.iter().filter(|batch| batch.part == part).count();
    let placed: usize = frame.scene.instances.iter().map(|instance| of_part(instance.part)).sum();
    for &(extension, format) in Format::ALL {
        let tiles = if extension == "glb" { frame.batches.len() } else { placed };
        let mut files = Vec::new();
        for jobs in [&Alone as &dyn Jobs, &Threads::start(3).unwrap()] {
            let (control, heard) = stopped(u64::MAX);
            save_on(jobs, &frame, &path, &SaveOptions::new(format), &control).unwrap();
            files.push(fs::read(&path).unwrap());
            let heard = heard.lock().unwrap();
            assert_grows(&heard);
            let last = heard.last().unwrap();
            assert_eq!((last.done, last.total), (2 * tiles as u64, 2 * tiles as u64), "{extension}");
            let mut bytes = Vec::new();
            write_on(jobs, &frame, &mut bytes, &SaveOptions::new(format), &Control::default()).unwrap();
            files.push(bytes);
        }
        assert!(files.windows(2).all(|pair| pair[0] == pair[1]), "{extension}");
    }
}

#[test]
fn a_cancelled_save_leaves_the_file_that_was_there_and_no_other() {
    let (frame, folder) = (frame(0.05), folder("cancelled"));
    let path = folder.join("mesh");
    for (extension, format) in Format::ALL {
        let options = SaveOptions::new(*format);
        for jobs in [&Alone as &dyn Jobs, &Threads::start(3).unwrap()] {
            let (control, heard) = stopped(u64::MAX);
            write_on(jobs, &frame, &mut Vec::new(), &options, &control).unwrap();
            let counts: Vec<u64> = heard.lock().unwrap().iter().map(|told| told.done).collect();
            for after in counts.into_iter().step_by(3).chain([u64::MAX]) {
                fs::write(&path, "before").unwrap();
                let (control, heard) = stopped(after);
                let saved = save_on(jobs, &frame, &path, &options, &control);
                assert_grows(&heard.lock().unwrap());
                if after < u64::MAX {
                    assert!(matches!(saved, Err(SaveError::Cancelled)), "{extension} after {after}: {saved:?}");
                    assert_eq!(fs::read(&path).unwrap(), b"before");
                } else {
                    assert!(fs::metadata(&path).unwrap().len() > 1000);
                }
                assert_eq!(names(&folder), ["mesh"], "{extension} after {after}");
            }
        }
    }
}

#[test]
fn a_cancelled_save_leaves_the_other_outputs_alone() {
    let (frame, folder) = (frame(0.5), folder("others"));
    let level = [MeshLevel { frame: (&frame).into(), chord: 0.5 }];
    let mut outputs = Outputs::default();
    let mut save = |name: &str, control: &Control| {
        outputs.save_on(&Alone, &level, &folder.join(name), &SaveOptions::new(Format::Stl), control)
    };
    save("one", &Control::default()).unwrap();
    let (control, _) = stopped(level[0].frame.batches.len() as u64 + 1);
    assert!(matches!(save("two", &control), Err(SaveError::Cancelled)));
    save("three", &Control::default()).unwrap();
    outputs.publish().unwrap();
    assert_eq!(names(&folder), ["one", "three"]);
}

#[test]
fn a_writer_that_refuses_ends_the_save() {
    struct Full(usize);
    impl std::io::Write for Full {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0 = self.0.checked_sub(bytes.len()).ok_or(std::io::ErrorKind::StorageFull)?;
            Ok(bytes.len())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    let frame = frame(0.5);
    for (_, format) in Format::ALL {
        let written = write_on(&Alone, &frame, &mut Full(5000), &SaveOptions::new(*format), &Control::default());
        let Err(SaveError::Io(error)) = written else { panic!("{written:?}") };
        assert_eq!(error.kind(), std::io::ErrorKind::StorageFull);
    }
    let missing = Path::new(env!("CARGO_TARGET_TMPDIR")).join("no such folder").join("mesh");
    let saved = save_on(&Alone, &frame, &missing, &SaveOptions::new(Format::Stl), &Control::default());
    assert!(matches!(&saved, Err(SaveError::File(error)) if error.to_string().contains("no such folder")), "{saved:?}");
}
