//! The elementary functions with the same bits on every platform.
//!
//! Those of the standard library are the operating system's, which differ in the last bits: glibc's from those of
//! WebAssembly. IEEE 754 defines only sums, products, quotients and roots. These are of the crate `libm`, a port of
//! musl's, which uses nothing else.

/// Elementary functions of a number. Each is named after the one of [`f64`] that it stands for.
pub(crate) trait Elementary: Sized {
    /// `sin`.
    fn sine(self) -> Self;
    /// `cos`.
    fn cosine(self) -> Self;
    /// `sin_cos`.
    fn sine_cosine(self) -> (Self, Self);
    /// `tan`.
    fn tangent(self) -> Self;
    /// `asin`.
    fn arc_sine(self) -> Self;
    /// `acos`.
    fn arc_cosine(self) -> Self;
    /// `atan`.
    fn arc_tangent(self) -> Self;
    /// `atan2`: the angle of the point at `x` and `self`.
    fn arc_tangent_to(self, x: Self) -> Self;
    /// `sinh`.
    #[cfg(feature = "step")]
    fn hyperbolic_sine(self) -> Self;
    /// `cosh`.
    #[cfg(feature = "step")]
    fn hyperbolic_cosine(self) -> Self;
    /// `asinh`.
    #[cfg(feature = "step")]
    fn inverse_hyperbolic_sine(self) -> Self;
    /// `hypot`.
    fn hypotenuse(self, other: Self) -> Self;
    /// `cbrt`.
    fn cube_root(self) -> Self;
    /// `log2`.
    fn binary_logarithm(self) -> Self;
    /// `exp2`.
    fn binary_power(self) -> Self;
    /// `powf`.
    fn power(self, exponent: Self) -> Self;
}

impl Elementary for f64 {
    fn sine(self) -> Self {
        libm::sin(self)
    }

    fn cosine(self) -> Self {
        libm::cos(self)
    }

    fn sine_cosine(self) -> (Self, Self) {
        libm::sincos(self)
    }

    fn tangent(self) -> Self {
        libm::tan(self)
    }

    fn arc_sine(self) -> Self {
        libm::asin(self)
    }

    fn arc_cosine(self) -> Self {
        libm::acos(self)
    }

    fn arc_tangent(self) -> Self {
        libm::atan(self)
    }

    fn arc_tangent_to(self, x: Self) -> Self {
        libm::atan2(self, x)
    }

    #[cfg(feature = "step")]
    fn hyperbolic_sine(self) -> Self {
        libm::sinh(self)
    }

    #[cfg(feature = "step")]
    fn hyperbolic_cosine(self) -> Self {
        libm::cosh(self)
    }

    #[cfg(feature = "step")]
    fn inverse_hyperbolic_sine(self) -> Self {
        libm::asinh(self)
    }

    fn hypotenuse(self, other: Self) -> Self {
        libm::hypot(self, other)
    }

    fn cube_root(self) -> Self {
        libm::cbrt(self)
    }

    fn binary_logarithm(self) -> Self {
        libm::log2(self)
    }

    fn binary_power(self) -> Self {
        libm::exp2(self)
    }

    fn power(self, exponent: Self) -> Self {
        libm::pow(self, exponent)
    }
}
