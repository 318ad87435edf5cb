//! Distributions: normal (also in logarithms), log-normal, triangular, exponential, beta, binomial and Student's.

mod beta;
mod combined_tails;
mod exponential;
mod kernel_density;
mod log_normal;
pub mod normal;
pub mod normal_tail;
mod triangular;

pub use beta::{
    beta_quantile, beta_tail, binomial_at_least, binomial_at_most, ln_beta, regularised_beta, student_above,
    student_quantile,
};
pub use combined_tails::{Tail, combined_tail};
pub use exponential::{exponential_quantile, exponential_tail};
pub use kernel_density::KernelDensity;
pub use log_normal::LogNormal;
pub use triangular::Triangular;
