//! Loops over numbers, compiled for the registers that the processor has (on x86-64 with AVX2 or without), chosen at
//! run time.

#[cfg(target_arch = "x86_64")]
use std::arch::x86_64;
use std::ops::{Add, Div, Mul, Sub};
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
/// with sums. The call costs a few nanoseconds. WebAssembly has the registers that it is compiled for, and needs no
/// choice.
#[inline(always)]
pub(crate) fn widest<R>(work: impl FnOnce() -> R) -> R {
    #[cfg(not(target_arch = "wasm32"))]
    return ARCH.dispatch(work);
    #[cfg(target_arch = "wasm32")]
    work()
}

/// `a` if it is larger than `b`, else `b`. So NaN as `a` is ignored.
///
/// One instruction; [`f64::max`] takes four, for the sake of NaN.
#[inline(always)]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// `a` if it is smaller than `b`, else `b`. So NaN as `a` is ignored.
#[inline(always)]
pub(crate) fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// `L` numbers. Each gets the bits that it would get alone, in every type: no operation is fused or approximate.
pub(crate) trait Lanes<const L: usize>:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// `x` in each lane. `self` only says in which registers.
    fn splat(self, x: f64) -> Self;
    /// The numbers of an array. `self` only says in which registers.
    fn load(self, x: &[f64; L]) -> Self;
    fn to_array(self) -> [f64; L];
    fn sqrt(self) -> Self;
    /// [`larger`] of each lane.
    fn larger(self, other: Self) -> Self;
    /// The lanes that are less than those of `other`, a bit each.
    fn below(self, other: Self) -> u32;
}

/// Lanes in plain Rust.
#[derive(Clone, Copy)]
pub(crate) struct Plain<const L: usize>(pub(crate) [f64; L]);

impl<const L: usize> Plain<L> {
    #[inline(always)]
    fn with(mut self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        for l in 0..L {
            self.0[l] = f(self.0[l], other.0[l]);
        }
        self
    }
}

impl<const L: usize> Lanes<L> for Plain<L> {
    #[inline(always)]
    fn splat(self, x: f64) -> Self {
        Self([x; L])
    }

    #[inline(always)]
    fn load(self, x: &[f64; L]) -> Self {
        Self(*x)
    }

    #[inline(always)]
    fn to_array(self) -> [f64; L] {
        self.0
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f64::sqrt))
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        self.with(other, larger)
    }

    #[inline(always)]
    fn below(self, other: Self) -> u32 {
        (0..L).fold(0, |bits, l| bits | u32::from(self.0[l] < other.0[l]) << l)
    }
}

/// Four lanes in one register of AVX2, with the proof that the processor has it.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy)]
pub(crate) struct Wide(pulp::x86::V3, x86_64::__m256d);

#[cfg(target_arch = "x86_64")]
impl Lanes<4> for Wide {
    #[inline(always)]
    fn splat(self, x: f64) -> Self {
        Self(self.0, self.0.avx._mm256_set1_pd(x))
    }

    #[inline(always)]
    fn load(self, x: &[f64; 4]) -> Self {
        Self(self.0, pulp::cast(*x))
    }

    #[inline(always)]
    fn to_array(self) -> [f64; 4] {
        pulp::cast(self.1)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0, self.0.avx._mm256_sqrt_pd(self.1))
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        // The second operand where either is NaN.
        Self(self.0, self.0.avx._mm256_max_pd(self.1, other.1))
    }

    #[inline(always)]
    fn below(self, other: Self) -> u32 {
        let less = self.0.avx._mm256_cmp_pd::<{ x86_64::_CMP_LT_OQ }>(self.1, other.1);
        self.0.avx._mm256_movemask_pd(less).cast_unsigned()
    }
}

macro_rules! operator {
    ($name:ident, $method:ident, $of_four:ident) => {
        impl<const L: usize> $name for Plain<L> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.with(other, f64::$method)
            }
        }

        #[cfg(target_arch = "x86_64")]
        impl $name for Wide {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0, self.0.avx.$of_four(self.1, other.1))
            }
        }
    };
}
operator!(Add, add, _mm256_add_pd);
operator!(Sub, sub, _mm256_sub_pd);
operator!(Mul, mul, _mm256_mul_pd);
operator!(Div, div, _mm256_div_pd);

/// Work on four lanes. A closure cannot be generic over their type.
pub(crate) trait Work {
    type Output;
    /// Does the work in lanes of the type of `zero`.
    fn run<F: Lanes<4>>(self, zero: F) -> Self::Output;
}

/// Does `work` like [`widest`], in registers by name where they are AVX2's.
///
/// The compiler finds lanes in plain loops too, but not always those that are meant: it may compute the components of a
/// point together, and exchange them for lanes afterwards.
#[inline(always)]
pub(crate) fn in_fours<W: Work>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    return match *ARCH {
        pulp::Arch::V3(simd) => simd.vectorize(
            #[inline(always)]
            || work.run(Wide(simd, simd.avx._mm256_setzero_pd())),
        ),
        _ => work.run(Plain([0.0; 4])),
    };
    #[cfg(not(target_arch = "x86_64"))]
    widest(
        #[inline(always)]
        || work.run(Plain([0.0; 4])),
    )
}
