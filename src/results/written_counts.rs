//! Counts that are not written down where there is nothing to count.

// The signature is serde's.
#[allow(clippy::trivially_copy_pass_by_ref)]
pub fn is_zero(count: &usize) -> bool {
    *count == 0
}
