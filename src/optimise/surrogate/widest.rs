//! The widest vector lanes that the processor at hand has.

/// A function that is compiled twice where the target is x86-64, once with the lanes of AVX2, which are taken where there are any. The same
/// bits either way: the operations are the same in the same order, and a multiplication and an addition are never fused.
macro_rules! widest {
    ($(#[$attribute:meta])* $visibility:vis fn $name:ident($($argument:ident: $type:ty),* $(,)?) $(-> $result:ty)? $body:block) => {
        $(#[$attribute])*
        $visibility fn $name($($argument: $type),*) $(-> $result)? {
            #[inline(always)]
            fn body($($argument: $type),*) $(-> $result)? $body
            #[cfg(target_arch = "x86_64")]
            if std::arch::is_x86_feature_detected!("avx2") {
                #[target_feature(enable = "avx2")]
                fn with_avx2($($argument: $type),*) $(-> $result)? {
                    body($($argument),*)
                }
                #[expect(unsafe_code, reason = "the processor was asked whether it has what this is compiled for")]
                let result = unsafe { with_avx2($($argument),*) };
                return result;
            }
            body($($argument),*)
        }
    };
}

pub(super) use widest;
