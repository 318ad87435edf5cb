//! Distributions: normal (also in logarithms), beta, binomial and Student's.

mod beta;
mod kernel_density;
pub mod normal;
pub mod normal_tail;

pub use beta::{
    beta_quantile, binomial_at_least, binomial_at_most, ln_beta, regularised_beta, student_above,
    student_quantile,
};
pub use kernel_density::KernelDensity;
