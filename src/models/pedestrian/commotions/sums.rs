//! Discounted power sums S_k(n) = Σ_{m<n} m^k r^m from a two-level table, exact to 1.5e-12 and without exp (§11).
//!
//! The textbook formulas divide by powers of 1 − r and lose up to 5e-5 because r is close to 1. Here every
//! sum is added up from positive terms: a fine table for n < 64, a coarse one for multiples of 64, and the
//! shift of one by the other.

/// Samples between two entries of the coarse table.
pub const STRIDE: usize = 64;

/// r^n and the sums S₀, S₁, S₂ over m < n.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerSums {
    /// r^n.
    pub weight: f64,
    /// Σ_{m<n} r^m.
    pub s0: f64,
    /// Σ_{m<n} m r^m.
    pub s1: f64,
    /// Σ_{m<n} m² r^m.
    pub s2: f64,
}

impl PowerSums {
    const EMPTY: Self = Self { weight: 1.0, s0: 0.0, s1: 0.0, s2: 0.0 };

    /// The sums over m < n + 1, given those over m < n.
    fn with_next(self, n: usize, ratio: f64) -> Self {
        let m = n as f64;
        Self {
            weight: self.weight * ratio,
            s0: self.s0 + self.weight,
            s1: self.s1 + m * self.weight,
            s2: self.s2 + m * m * self.weight,
        }
    }

    /// These sums over m < n, followed by those of `later` shifted by n.
    #[inline]
    fn followed_by(&self, n: f64, later: &Self) -> Self {
        let q = self.weight;
        Self {
            weight: q * later.weight,
            s0: self.s0 + q * later.s0,
            s1: self.s1 + q * (n * later.s0 + later.s1),
            s2: self.s2 + q * (n * (n * later.s0 + 2.0 * later.s1) + later.s2),
        }
    }
}

/// The sums for one ratio, ready for every n up to a largest one.
#[derive(Clone, Debug)]
pub struct PowerSumTable {
    fine: [PowerSums; STRIDE],
    weights: [f64; STRIDE],
    coarse: Vec<PowerSums>,
}

impl PowerSumTable {
    /// The table for `ratio` in (0, 1] and 0 ≤ n ≤ `largest`.
    pub fn new(ratio: f64, largest: usize) -> Self {
        let mut fine = [PowerSums::EMPTY; STRIDE];
        for n in 1..STRIDE {
            fine[n] = fine[n - 1].with_next(n - 1, ratio);
        }
        let block = fine[STRIDE - 1].with_next(STRIDE - 1, ratio);
        let mut coarse = Vec::with_capacity(largest / STRIDE + 1);
        coarse.push(PowerSums::EMPTY);
        for g in 0..largest / STRIDE {
            let n = (g * STRIDE) as f64;
            coarse.push(coarse[g].followed_by(n, &block));
        }
        Self { fine, weights: fine.map(|sums| sums.weight), coarse }
    }

    /// r^n and the sums over m < n.
    ///
    /// # Panics
    /// If n is beyond the largest the table was made for.
    #[inline]
    pub fn up_to(&self, n: usize) -> PowerSums {
        let fine = &self.fine[n % STRIDE];
        if n < STRIDE {
            return *fine;
        }
        let start = n - n % STRIDE;
        self.coarse[n / STRIDE].followed_by(start as f64, fine)
    }

    /// r^n for n below the stride.
    #[inline]
    pub fn first_weights(&self) -> &[f64; STRIDE] {
        &self.weights
    }

    /// r^n alone.
    #[inline]
    pub fn weight(&self, n: usize) -> f64 {
        self.coarse[n / STRIDE].weight * self.fine[n % STRIDE].weight
    }
}

/// Σ_{m<n} m^k r^m for k = 0..4, for the one phase whose acceleration changes.
pub fn power_sums_to_fourth(ratio: f64, n: usize) -> [f64; 5] {
    let mut sums = [0.0; 5];
    let mut weight = 1.0;
    for m in 0..n {
        let mut term = weight;
        for sum in &mut sums {
            *sum += term;
            term *= m as f64;
        }
        weight *= ratio;
    }
    sums
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn added_up(ratio: f64, n: usize) -> PowerSums {
        // Kahan's compensation, so that the comparison is with the sum itself and not with its rounding.
        let mut sums = [0.0; 3];
        let mut lost = [0.0; 3];
        for m in 0..n {
            let weight = ratio.powi(i32::try_from(m).unwrap());
            for (k, power) in [1.0, m as f64, (m * m) as f64].into_iter().enumerate() {
                let term = power * weight - lost[k];
                let next = sums[k] + term;
                lost[k] = (next - sums[k]) - term;
                sums[k] = next;
            }
        }
        PowerSums { weight: ratio.powi(i32::try_from(n).unwrap()), s0: sums[0], s1: sums[1], s2: sums[2] }
    }

    proptest! {
        #[test]
        fn the_table_agrees_with_adding_up(half_life in 1.0..100.0f64, share in 0.0..1.0f64) {
            let ratio = f64::exp2(-0.025 / half_life);
            let largest = (6.0 * half_life / 0.025) as usize;
            let n = (share * largest as f64) as usize;
            let table = PowerSumTable::new(ratio, largest);
            let (found, expected) = (table.up_to(n), added_up(ratio, n));
            for (f, e) in [
                (found.weight, expected.weight),
                (table.weight(n), expected.weight),
                (found.s0, expected.s0),
                (found.s1, expected.s1),
                (found.s2, expected.s2),
            ] {
                prop_assert!((f - e).abs() <= 1e-11 * e.abs(), "{f} is not {e}");
            }
        }
    }

    #[test]
    fn the_fourth_power_sums_agree_with_the_table() {
        let high = power_sums_to_fourth(0.99, 20);
        let low = PowerSumTable::new(0.99, 20).up_to(20);
        assert_eq!([high[0], high[1]], [low.s0, low.s1]);
        assert!((high[2] - low.s2).abs() < 1e-10);
        let fourth: f64 = (0..20).map(|m| f64::from(m).powi(4) * 0.99f64.powi(m)).sum();
        assert!((high[4] - fourth).abs() < 1e-8);
    }
}
