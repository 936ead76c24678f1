//! Patterns of an enum's variants -> `code()` of each and the list of all codes. Generated together, so that neither
//! can miss one.

/// Implements `code` and `codes`: a stable code for each variant. Variants that wrap another such enum pass on its
/// code; they follow the semicolon, with the type that they wrap.
macro_rules! codes {
    ($of:ident { $($pattern:pat => $code:literal),* $(; $($inner:ident in $outer:pat => $held:expr),*)? }) => {
        impl $of {
            /// The stable code, as in reports and `docs/diagnostics.md`.
            #[must_use]
            pub fn code(&self) -> &'static str {
                match self {
                    $($pattern => $code,)*
                    $($($outer => $held.code(),)*)?
                }
            }

            /// All codes, in the order of the variants.
            #[must_use]
            pub fn codes() -> Vec<&'static str> {
                let own: &[&'static str] = &[$($code),*];
                let inner: Vec<Vec<&'static str>> = vec![$($($inner::codes()),*)?];
                [own, &inner.concat()].concat()
            }
        }
    };
}
