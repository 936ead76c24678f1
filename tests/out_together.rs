//! Files of one run appear together or not at all.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod folders;

use folders::{folder, names};
use std::fs;
use std::io;
use trimtess::out::{Outputs, target_of, write_whole};

#[test]
fn nothing_appears_before_all_is_written_and_nothing_after_a_failure() {
    let folder = folder("whole");
    let (a, b) = (folder.join("a.ply"), folder.join("b.json"));
    let mut outputs = Outputs::default();
    outputs.write(&a, |file| file.write_all(b"a")).unwrap();
    assert!(!a.exists());
    assert!(outputs.write(&b, |_| Err(io::Error::other("no more"))).is_err());
    drop(outputs);
    assert_eq!(names(&folder), [""; 0]);
    let mut outputs = Outputs::default();
    outputs.write(&a, |file| file.write_all(b"a")).unwrap();
    outputs.write(&b, |file| file.write_all(b"b")).unwrap();
    outputs.publish().unwrap();
    assert_eq!(names(&folder), ["a.ply", "b.json"]);
}

#[test]
fn what_was_replaced_comes_back_if_a_later_file_cannot_have_its_name() {
    let folder = folder("back");
    let (old, new, blocked) = (folder.join("old"), folder.join("new"), folder.join("blocked"));
    fs::write(&old, "before").unwrap();
    let mut outputs = Outputs::default();
    for path in [&old, &new, &blocked] {
        outputs.write(path, |file| file.write_all(b"after")).unwrap();
    }
    // A folder takes the last name in the meantime.
    fs::create_dir(&blocked).unwrap();
    let error = outputs.publish().unwrap_err();
    assert!(error.to_string().contains("blocked"), "{error}");
    assert_eq!(names(&folder), ["blocked", "old"]);
    assert_eq!(fs::read_to_string(&old).unwrap(), "before");
}

#[cfg(unix)]
#[test]
fn a_replaced_file_keeps_its_mode() {
    use std::os::unix::fs::PermissionsExt;
    let path = folder("mode").join("mesh.obj");
    for mode in [0o600, 0o640, 0o755] {
        fs::write(&path, "before").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
        write_whole(&path, |file| file.write_all(b"after")).unwrap();
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o7777, mode);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn temporary_names_fit_wherever_the_name_fits() {
    let folder = folder("names");
    for length in [1, 2, 5, 200, 250, 255] {
        let path = folder.join("x".repeat(length));
        write_whole(&path, |file| file.write_all(b"x")).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "x", "{length}");
    }
    assert_eq!(names(&folder).len(), 6);
    // Deep folders leave few characters for the whole path.
    let mut deep = folder.clone();
    while deep.as_os_str().len() + 202 < 4090 {
        deep.push("y".repeat(200));
        fs::create_dir(&deep).unwrap();
    }
    let room = 4095 - deep.as_os_str().len() - 1;
    for length in [room, room - 10, 9] {
        let path = deep.join("z".repeat(length.min(255)));
        write_whole(&path, |file| file.write_all(b"z")).unwrap_or_else(|error| panic!("{length} {error:?}"));
    }
}

#[cfg(unix)]
#[test]
fn links_are_followed_even_to_files_that_do_not_exist_yet() {
    let folder = folder("links");
    fs::create_dir(folder.join("there")).unwrap();
    let (target, link, second) = (folder.join("there/mesh.obj"), folder.join("link.obj"), folder.join("second.obj"));
    std::os::unix::fs::symlink("there/mesh.obj", &link).unwrap();
    std::os::unix::fs::symlink(&link, &second).unwrap();
    assert_eq!(target_of(&second), fs::canonicalize(&folder).unwrap().join("there/mesh.obj"));
    write_whole(&second, |file| file.write_all(b"new")).unwrap();
    assert_eq!(fs::read_to_string(&target).unwrap(), "new");
    assert!(link.symlink_metadata().unwrap().is_symlink() && second.symlink_metadata().unwrap().is_symlink());
}
