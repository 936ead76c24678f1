//! Patterns of an enum's variants -> `code()` of each, and the list of all codes, so that neither can lack one.

/// Gives an enum a stable code for each variant. Variants that hold another such enum pass its code on:
/// they come after the semicolon, with the enum that they hold.
macro_rules! codes {
    ($of:ident { $($pattern:pat => $code:literal),* $(; $($inner:ident in $outer:pat => $held:expr),*)? }) => {
        impl $of {
            /// Its stable code, as reports and `docs/diagnostics.md` have it.
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
