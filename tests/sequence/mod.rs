//! A judge of bytes -> its verdicts on one fixed sequence of random inputs. The sequence is the same in every run, so
//! that a test that passed on a change passes on its next run. `cargo bolero` brings its own inputs
//! (docs/decisions/017).
//!
//! `FUZZ_MS` runs for that many milliseconds instead of a number of inputs. `FUZZ_FIRST` starts at another input.

pub(crate) mod random;

use bolero::bolero_engine::driver::Options;
use bolero::bolero_engine::input::Bytes;
use bolero::bolero_engine::panic::{forward_panic, set_hook};
use bolero::{Engine, Test};
use random::{SplitMix, scrambled};
use std::fmt::Debug;
use std::time::{Duration, Instant};

/// Judges `$count` inputs of at most `$most_bytes`. A panic in the closure is a failure, and its input is shrunk.
macro_rules! judge {
    ($count:expr, $most_bytes:expr, $judge:expr) => {
        if cfg!(fuzzing) {
            bolero::check!().with_max_len($most_bytes).for_each($judge);
        } else {
            let sequence = $crate::sequence::Sequence { count: $count, most_bytes: $most_bytes };
            let target = bolero::TestTarget::new(sequence).with_shrink_time(std::time::Duration::from_secs(20));
            target.for_each($judge);
        }
    };
}
pub(crate) use judge;

/// Inputs 0 to `count` of the sequence.
pub(crate) struct Sequence {
    pub(crate) count: u64,
    pub(crate) most_bytes: usize,
}

impl<T: Test<Value: Debug>> Engine<T> for Sequence {
    type Output = ();

    fn run(self, mut test: T, options: Options) {
        let first = variable("FUZZ_FIRST").unwrap_or(0);
        let time = variable("FUZZ_MS").map(Duration::from_millis);
        let start = Instant::now();
        let mut tried = 0;
        set_hook();
        forward_panic(false);
        while time.map_or(tried < self.count, |time| start.elapsed() < time) {
            let input = first.wrapping_add(tried);
            let bytes = bytes(input, self.most_bytes);
            if let Err(error) = test.test(&mut Bytes::new(&bytes, &options)) {
                let error = test.shrink(bytes, None, &options).map_or(error, |shrunk| shrunk.error);
                forward_panic(true);
                panic!("input {input} of the sequence fails (again: FUZZ_FIRST={input})\n{error}");
            }
            tried += 1;
        }
        forward_panic(true);
        println!("{tried} inputs of the sequence from {first} on, in {:?}", start.elapsed());
    }
}

fn variable(name: &str) -> Option<u64> {
    let text = std::env::var(name).ok()?;
    Some(text.parse().unwrap_or_else(|_| panic!("{name}={text} is not a number")))
}

/// Input `number` of the sequence (SplitMix64). Its length is uniform in 0..=`most`.
fn bytes(number: u64, most: usize) -> Vec<u8> {
    // Without scrambling each input would be the previous one, shifted.
    let mut random = SplitMix(scrambled(number));
    let length = random.below(most as u64 + 1);
    let words = std::iter::repeat_with(|| random.bits().to_le_bytes());
    words.flatten().take(length as usize).collect()
}
