//! What cannot be tested from C: panics, and the border's own rules.

use crate::border::handles::{Exclusive, Table};
use crate::border::{Versioned, entry, message, versioned};
use crate::status::{Failure, tt_last_error, tt_status};
use std::ffi::{CStr, c_char};
use std::panic::catch_unwind;
use std::sync::Mutex;

/// A body that ends otherwise than by a result.
type Ended = Result<(), Failure>;

/// The words of the last failure.
fn words() -> String {
    // SAFETY: valid until the next failure on this thread.
    unsafe { CStr::from_ptr(tt_last_error()) }.to_string_lossy().into_owned()
}

#[test]
fn a_panic_is_a_status_with_its_words() {
    let status = entry!(_c => { if 3 < 4 { panic!("number {} is not {}", 3, 4) } else { Ended::Ok(()) } });
    assert_eq!(status, tt_status::TT_ERROR_PANIC);
    assert_eq!(words(), "internal error: number 3 is not 4; please report it with the file that caused it");
    let status = entry!(_c => { if 3 < 4 { std::panic::panic_any(7_u8) } else { Ended::Ok(()) } });
    assert_eq!((status, message(&7_u8)), (tt_status::TT_ERROR_PANIC, String::new()));
}

#[test]
fn words_with_a_zero_byte_are_kept() {
    let status = entry!(_c => Ended::Err(Failure::argument("a\0b")));
    assert_eq!((status, words()), (tt_status::TT_ERROR_ARGUMENT, "a b".to_owned()));
}

#[test]
fn words_are_those_of_the_thread() {
    let fails = || entry!(_c => Ended::Err(Failure::argument("here")));
    assert_eq!(fails(), tt_status::TT_ERROR_ARGUMENT);
    std::thread::spawn(|| assert_eq!(words(), "")).join().expect("no panic");
    assert_eq!(words(), "here");
}

#[test]
fn texts_are_cut_between_characters() {
    for capacity in 0..9 {
        let (mut text, mut length) = ([b'x' as c_char; 9], 0);
        let status = entry!(c => c.give_text("aé€", text.as_mut_ptr(), capacity, &raw mut length));
        assert_eq!((status, length), (tt_status::TT_OK, 6));
        let kept = [0, 0, 1, 1, 3, 3, 3, 6, 6][capacity];
        let given: Vec<u8> = text.iter().map(|&byte| byte as u8).collect();
        assert_eq!(&given[..kept], &"aé€".as_bytes()[..kept], "{capacity}");
        assert!(given[kept..].iter().all(|&byte| byte == b'x' || capacity > 0), "{capacity}");
        assert_eq!(capacity > 0, given[kept] == 0);
    }
}

#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sample {
    size: u32,
    number: u32,
    more: u64,
}
versioned!(Sample);

/// As a later version of the interface has it.
#[repr(C)]
struct Longer(Sample, u64);

#[test]
fn structs_of_later_versions_are_read_and_written_as_far_as_they_are_known() {
    let size = size_of::<Longer>() as u32;
    let mut longer = Longer(Sample { size, number: 1, more: 2 }, 0);
    let from = (&raw const longer).cast::<Sample>();
    let mut read = None;
    assert_eq!(entry!(c => c.read("it", from).map(|it| read = Some(it))), tt_status::TT_OK);
    assert_eq!(read, Some(longer.0));
    longer.1 = 9;
    let to = (&raw mut longer).cast::<Sample>();
    let status = entry!(c => c.out_struct("it", to).map(|it| it.give(&Sample { size: 0, number: 5, more: 6 })));
    assert_eq!((status, longer.0, longer.1), (tt_status::TT_OK, Sample { size, number: 5, more: 6 }, 0));
    longer.1 = 9;
    let from = (&raw const longer).cast::<Sample>();
    assert_eq!(entry!(c => c.read("it", from).map(|_| ())), tt_status::TT_ERROR_ARGUMENT);
    for size in [0, 4, 15, 4097, u32::MAX] {
        let wrong = Sample { size, number: 1, more: 2 };
        assert_eq!(entry!(c => c.read("it", &raw const wrong).map(|_| ())), tt_status::TT_ERROR_ARGUMENT);
        assert_eq!(words(), format!("it.size is {size}; the struct of this version has 16 bytes"));
    }
}

#[test]
fn a_handle_ends_once_and_is_never_given_again() {
    let table: Table<&str> = Table::new(2);
    let (first, second) = (table.add("first"), table.add("second"));
    let held = table.get(first).expect("alive");
    assert!(table.free(first).is_ok() && table.free(first).is_err() && table.get(first).is_err());
    assert_eq!((*held, *table.take(second).expect("alive")), ("first", "second"));
    let third = table.add("third");
    assert!(![0, first, second].contains(&third) && table.free(third).is_ok() && table.free(0).is_ok());
}

#[test]
fn what_is_in_use_is_busy_and_a_panic_does_not_keep_it() {
    static SHARED: Table<Exclusive<u32>> = Table::new(3);
    let it = SHARED.add(Mutex::new(Some(1)));
    let within = SHARED.with(it, |_| Ok((SHARED.with(it, |_| Ok(())).is_err(), SHARED.end(it).is_err())));
    assert_eq!(within.expect("free"), (true, true));
    assert!(catch_unwind(move || SHARED.with(it, |_| -> Result<(), Failure> { panic!("within") })).is_err());
    assert_eq!(SHARED.with(it, |number| Ok(*number)).expect("free"), 1);
    assert!(SHARED.end(it).is_ok() && SHARED.with(it, |_| Ok(())).is_err() && SHARED.end(it).is_err());
    assert!(SHARED.end(0).is_ok());
}

#[test]
fn zeros_are_a_struct() {
    assert_eq!(Sample::FIRST, 16);
    let mut read = None;
    assert_eq!(entry!(c => c.read_or_zeros("it", std::ptr::null()).map(|it| read = Some(it))), tt_status::TT_OK);
    assert_eq!(read, Some(Sample { size: 0, number: 0, more: 0 }));
}
