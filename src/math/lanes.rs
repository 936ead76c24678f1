//! Loops over numbers, compiled for the registers that the processor has (on x86-64 with AVX2 or without), chosen at run
//! time.

#[cfg(not(target_arch = "wasm32"))]
use std::sync::LazyLock;

/// The processor's, unless `TRIMTESS_LANES` is `scalar`.
#[cfg(not(target_arch = "wasm32"))]
static ARCH: LazyLock<pulp::Arch> = LazyLock::new(|| match std::env::var_os("TRIMTESS_LANES") {
    Some(lanes) if lanes == "scalar" => pulp::Arch::Scalar,
    _ => pulp::Arch::new(),
});

/// Runs `work`, with what is inlined into it compiled for the processor's registers.
///
/// The bits of results do not depend on them: each sum has the order that the code says, and products are not fused
/// with sums. The call costs a few nanoseconds. WebAssembly has the registers that it is compiled for, and needs no choice.
#[inline(always)]
pub(crate) fn widest<R>(work: impl FnOnce() -> R) -> R {
    #[cfg(not(target_arch = "wasm32"))]
    return ARCH.dispatch(work);
    #[cfg(target_arch = "wasm32")]
    work()
}
