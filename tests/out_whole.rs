//! Files appear complete or not at all, whatever fails and when.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod folders;
mod out_fixture;

use folders::{folder, names};
use glam::{DAffine3, DVec3};
use out_fixture::box_frame;
use std::fs;
use std::io::{self, Write};
use std::path::Path;
#[cfg(feature = "glb")]
use trimtess::out::GlbOptions;
use trimtess::out::{Format, SaveError, save, write_whole};

#[test]
fn an_error_halfway_leaves_the_previous_file() {
    let folder = folder("half");
    let path = folder.join("mesh.obj");
    let fails = |file: &mut dyn Write| {
        file.write_all(&vec![b'x'; 3 << 20])?;
        Err(io::Error::other("no more"))
    };
    let error = write_whole(&path, fails).unwrap_err();
    assert!(error.to_string().contains("mesh.obj"), "{error}");
    assert_eq!(names(&folder), [""; 0]);
    fs::write(&path, "before").unwrap();
    assert!(write_whole(&path, fails).is_err());
    assert_eq!((names(&folder), fs::read_to_string(&path).unwrap().as_str()), (vec!["mesh.obj".to_owned()], "before"));
    write_whole(&path, |file| file.write_all(b"after")).unwrap();
    assert_eq!((names(&folder).len(), fs::read_to_string(&path).unwrap().as_str()), (1, "after"));
}

#[test]
fn a_panic_halfway_leaves_nothing() {
    let folder = folder("panic");
    let path = folder.join("mesh.obj");
    let panics = std::panic::catch_unwind(|| write_whole(&path, |_| panic!("on purpose")));
    assert!(panics.is_err());
    assert_eq!(names(&folder), [""; 0]);
}

#[test]
fn a_folder_is_not_overwritten_by_a_file() {
    let folder = folder("folders");
    for path in [folder.as_path(), Path::new("/"), &folder.join("missing").join("mesh.obj")] {
        assert!(write_whole(path, |file| file.write_all(b"x")).is_err(), "{}", path.display());
    }
    assert_eq!(names(&folder), [""; 0]);
}

#[test]
fn leftovers_of_a_killed_process_are_no_obstacle() {
    let folder = folder("leftovers");
    for serial in 0..100 {
        fs::write(folder.join(format!(".mesh.obj.{}-{serial}.part", std::process::id())), "left").unwrap();
    }
    write_whole(&folder.join("mesh.obj"), |file| file.write_all(b"new")).unwrap();
    assert_eq!(fs::read_to_string(folder.join("mesh.obj")).unwrap(), "new");
    assert_eq!(names(&folder).len(), 101);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_for_every_format() {
    let folder = folder("full");
    for &(extension, format) in Format::ALL {
        let path = folder.join(format!("mesh.{extension}"));
        std::os::unix::fs::symlink("/dev/full", &path).unwrap();
        let error = save(&out_fixture::box_frame(DVec3::ONE, &[DAffine3::IDENTITY]), &path, format).unwrap_err();
        let SaveError::File(error) = error else { panic!("{error}") };
        assert_eq!(error.cause.kind(), io::ErrorKind::StorageFull, "{error}");
        assert!(path.symlink_metadata().unwrap().is_symlink(), "the device was not replaced");
    }
    assert_eq!(names(&folder).len(), Format::ALL.len());
}

#[cfg(unix)]
#[test]
fn a_link_stays_a_link_and_its_target_is_replaced_whole() {
    let folder = folder("links");
    let (target, link) = (folder.join("target.obj"), folder.join("link.obj"));
    fs::write(&target, "before").unwrap();
    std::os::unix::fs::symlink(&target, &link).unwrap();
    write_whole(&link, |file| file.write_all(b"after")).unwrap();
    assert_eq!(fs::read_to_string(&target).unwrap(), "after");
    assert!(link.symlink_metadata().unwrap().is_symlink());
}

#[test]
fn positions_beyond_single_precision_are_reported_and_nothing_is_written() {
    let folder = folder("beyond");
    let far = DVec3::new(0.0, -1e39, 2.0);
    let formats = [
        (Format::Stl, far),
        #[cfg(feature = "glb")]
        (Format::Glb(GlbOptions::PLAIN), 1e3 * far),
    ];
    for (format, place) in formats {
        let frames = [box_frame(DVec3::ONE, &[DAffine3::from_translation(place)]), box_frame(1e45 * DVec3::ONE, &[])];
        // An STL contains instances only, a GLB parts as well.
        for frame in &frames[..if format == Format::Stl { 1 } else { 2 }] {
            let path = folder.join("mesh");
            fs::write(&path, "before").unwrap();
            let error = save(frame, &path, format).unwrap_err();
            let SaveError::BeyondSingle(told) = &error else { panic!("{error}") };
            assert!(told.position.abs().max_element() >= 1e39, "{told}");
            assert!(error.to_string().contains("3.4028235e38"), "{error}");
            assert_eq!(
                (names(&folder), fs::read_to_string(&path).unwrap().as_str()),
                (vec!["mesh".to_owned()], "before")
            );
        }
    }
    // Double precision has room, and so has the largest single-precision number.
    let frame = box_frame(DVec3::ONE, &[DAffine3::from_translation(far)]);
    for (format, frame) in [
        (Format::Ply, &frame),
        (Format::Obj, &frame),
        #[cfg(feature = "glb")]
        (Format::Glb(GlbOptions::PLAIN), &frame),
        (Format::Stl, &box_frame(DVec3::ONE, &[DAffine3::from_translation(0.3 * far)])),
    ] {
        save(frame, &folder.join("mesh"), format).unwrap();
    }
}
