//! The instruction set of a loop, chosen at run time.

#[cfg(target_arch = "x86_64")]
use super::{avx512::Avx512, x86::Avx2};
use super::{portable::Portable, vector::Vectorised};

/// Instruction set of the neighbour loops.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum InstructionSet {
    /// Plain Rust, vectorised by the compiler. Multiply-add is fused only if the build target has it.
    Portable,
    /// AVX2 with FMA.
    Avx2,
    /// AVX2 with FMA for arithmetic, AVX-512 (F, VL) for the search.
    Avx512,
}

impl InstructionSet {
    /// Every set that this machine can run, the best last.
    pub fn available() -> Vec<Self> {
        #[allow(unused_mut, reason = "only x86-64 adds to it")]
        let mut sets = vec![Self::Portable];
        #[cfg(target_arch = "x86_64")]
        {
            if Avx2::detect().is_some() {
                sets.push(Self::Avx2);
            }
            if Avx512::detect().is_some() {
                sets.push(Self::Avx512);
            }
        }
        sets
    }

    /// The best set that this machine can run.
    pub fn detect() -> Self {
        Self::available().pop().unwrap_or(Self::Portable)
    }

    /// Name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            Self::Avx2 => "avx2+fma",
            Self::Avx512 => "avx512",
        }
    }

    /// The set used for arithmetic. With AVX-512 enabled the compiler uses slower 512-bit code in loops of eight lanes.
    pub fn arithmetic(self) -> Self {
        self.min(Self::Avx2)
    }

    /// Runs `body` compiled for this set, or the portable version if the machine lacks it.
    #[inline]
    pub fn dispatch<V: Vectorised>(self, body: V) -> V::Output {
        #[cfg(target_arch = "x86_64")]
        match self {
            Self::Avx512 => {
                if let Some(token) = Avx512::detect() {
                    return token.dispatch(body);
                }
            }
            Self::Avx2 => {
                if let Some(token) = Avx2::detect() {
                    return token.dispatch(body);
                }
            }
            Self::Portable => {}
        }
        body.run(Portable)
    }
}
