//! The making of a file: its levels of detail, its bytes in pieces, progress and requests to stop, and why it is not
//! written.

use super::placed::BeyondSingle;
use super::rounding::RoundedTooFar;
use crate::control::{Call, Counter, Stage};
use crate::mesh::{FrameView, Scene, SinkError};
use std::io::{self, Write};

/// A mesh of a scene, and its tolerance, for [`Outputs::save_on`](super::Outputs::save_on).
#[derive(Clone, Debug)]
pub struct MeshLevel<'a> {
    /// The mesh. That of a coarser level has the same parts and instances.
    pub frame: FrameView<'a>,
    /// The chord tolerance of the mesh, millimetres. Larger than that of the level before. Decides when the level is
    /// drawn; means nothing where there is one level.
    pub chord: f64,
}

/// Meshes that are not levels of detail of one scene.
#[derive(Clone, Copy, PartialEq, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum UnfitLevel {
    /// There is no level.
    #[error("there is no level of detail to write")]
    Missing,
    /// The format stores one level. GLB stores more.
    #[error("there are {levels} levels of detail; only a GLB has more than one")]
    Format {
        /// Number of levels.
        levels: usize,
    },
    /// It has other parts or instances.
    #[error("level {level} has other parts or instances than level 0")]
    OtherScene {
        /// Its number. The finest level is 0.
        level: usize,
    },
    /// Its chord tolerance is not finite, or not larger than that of the level before.
    #[error("level {level} has a chord tolerance of {chord} mm, which is not larger than {before} mm")]
    Chord {
        /// Its number. The finest level is 0.
        level: usize,
        /// Its chord tolerance, millimetres.
        chord: f64,
        /// That of the level before, millimetres.
        before: f64,
    },
}

/// The levels, if they are of one scene, finest first.
pub(super) fn checked<'a, 'b>(levels: &'b [MeshLevel<'a>]) -> Result<&'b [MeshLevel<'a>], UnfitLevel> {
    let [finest, coarser @ ..] = levels else { return Err(UnfitLevel::Missing) };
    let (scene, mut before): (&Scene, f64) = (finest.frame.scene, finest.chord);
    for (level, MeshLevel { frame, chord }) in (1..).zip(coarser) {
        let parts = frame.scene.parts.iter().zip(&scene.parts);
        let instances = frame.scene.instances.iter().zip(&scene.instances);
        let is_same = (frame.scene.parts.len(), frame.scene.instances.len())
            == (scene.parts.len(), scene.instances.len())
            && parts.clone().all(|(a, b)| (&a.name, &a.face_colours) == (&b.name, &b.face_colours))
            && parts.clone().all(|(a, b)| (a.centre, a.radius) == (b.centre, b.radius))
            && instances.clone().all(|(a, b)| (a.part, a.first_face) == (b.part, b.first_face))
            && instances.clone().all(|(a, b)| (a.transform, a.colour) == (b.transform, b.colour));
        if !is_same {
            return Err(UnfitLevel::OtherScene { level });
        }
        if !(chord.is_finite() && *chord > before) {
            return Err(UnfitLevel::Chord { level, chord: *chord, before });
        }
        before = *chord;
    }
    Ok(levels)
}

/// Why a mesh was not written. A path then has the file that it had before.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SaveError {
    /// The work was [cancelled](crate::control::Control::cancel).
    #[error("writing was cancelled")]
    Cancelled,
    /// Rounding to the format's numbers moves a vertex too far. Nothing was written.
    #[error(transparent)]
    RoundedTooFar(#[from] RoundedTooFar),
    /// A position overflows the format's single precision. Nothing was written.
    #[error(transparent)]
    BeyondSingle(#[from] BeyondSingle),
    /// The levels of detail are not of one scene, or the format has no levels. Nothing was written.
    #[error(transparent)]
    UnfitLevel(#[from] UnfitLevel),
    /// The format cannot count as many. Nothing was written.
    #[error("{count} {of} exceed the limit of the format, {most}")]
    TooMany {
        /// Number of them.
        count: u64,
        /// What the format counts: "vertices", "triangles" or "bytes".
        of: &'static str,
        /// Maximum number.
        most: u64,
    },
    /// A file cannot be created, written or renamed.
    #[error(transparent)]
    File(#[from] SinkError),
    /// The caller's [`Write`] refused.
    #[error("cannot write: {0}")]
    Io(io::Error),
}

impl From<io::Error> for SaveError {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

/// Checks that the format can count as many.
pub(super) fn counted(count: u64, of: &'static str) -> Result<u32, SaveError> {
    u32::try_from(count).map_err(|_| SaveError::TooMany { count, of, most: u32::MAX.into() })
}

/// The bytes of a file, in pieces.
pub(super) type Pieces = Vec<Vec<u8>>;

/// Bytes between two looks whether the caller asks to stop. Disks take a few milliseconds for them.
const WRITTEN_AT_ONCE: usize = 1 << 20;

/// A call that makes a file and writes it. Progress counts the tiles of the file twice: when their bytes are made, and
/// when they are written.
pub(super) struct Making<'a> {
    pub(super) call: Call<'a>,
    tiles: u64,
    counter: Counter,
}

impl<'a> Making<'a> {
    /// Starts a file that has so many tiles.
    pub(super) fn start(call: Call<'a>, tiles: usize) -> Self {
        let tiles = tiles as u64;
        Self { call, tiles, counter: Counter::start(call.control, Stage::Write, 2 * tiles) }
    }

    /// An error once the caller asked to stop.
    pub(super) fn goes_on(&self) -> Result<(), SaveError> {
        self.call.goes_on().ok_or(SaveError::Cancelled)
    }

    /// Counts tiles whose bytes are made.
    pub(super) fn made(&self, tiles: usize) {
        self.counter.advance_by(tiles as u64);
    }

    /// Writes the pieces, which are all, unless cancelled, and frees them on all threads.
    pub(super) fn write(&self, pieces: Pieces, file: &mut (impl Write + ?Sized)) -> io::Result<()> {
        let all: u64 = pieces.iter().map(|piece| piece.len() as u64).sum();
        let (mut bytes, mut tiles) = (0, 0);
        let mut write = |some: &[u8]| {
            file.write_all(some)?;
            bytes += some.len() as u64;
            let share = u128::from(self.tiles) * u128::from(bytes) / u128::from(all);
            self.counter.advance_by(share as u64 - tiles);
            tiles = share as u64;
            Ok(())
        };
        let chunks = pieces.iter().flat_map(|piece| piece.chunks(WRITTEN_AT_ONCE));
        let written = chunks.take_while(|_| !self.call.is_cancelled()).try_for_each(&mut write);
        self.call.discard(pieces);
        written
    }
}
