//! Names of a session's instances and parts. Rows shift; keys do not.

use slotmap::{DefaultKey, Key, KeyData};
use std::fmt;
use std::num::NonZeroU64;

/// Names an instance of a session. Stays the same when other instances come and go. Once the instance is removed, its
/// key names none, also after others were added; a key is given again only after 2³¹ instances had its place.
///
/// Means nothing to other sessions.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct InstanceKey(pub(crate) DefaultKey);

impl InstanceKey {
    /// The key as a number, for other languages. Never 0.
    #[must_use]
    pub fn to_bits(self) -> u64 {
        self.0.data().as_ffi()
    }

    /// The key that this number stands for. Any number is allowed: most name no instance.
    #[must_use]
    pub fn from_bits(bits: u64) -> Self {
        let key = KeyData::from_ffi(bits);
        Self(if key.as_ffi() == bits { key.into() } else { DefaultKey::null() })
    }
}

/// Place and generation.
impl fmt::Debug for InstanceKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.data().fmt(f)
    }
}

/// Names a part of a session's scene, or one of its LODs: the same as long as the session has the part's content, also
/// after an [update](crate::parallel::Session::update) that gives it another row. It is not given twice.
///
/// Means nothing to other sessions.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub struct PartKey(pub(crate) NonZeroU64);

impl PartKey {
    /// The key as a number, for other languages. Never 0.
    #[must_use]
    pub fn to_bits(self) -> u64 {
        self.0.get()
    }

    /// The key that this number stands for; `None` for 0. Most others name no part.
    #[must_use]
    pub fn from_bits(bits: u64) -> Option<Self> {
        NonZeroU64::new(bits).map(Self)
    }
}
