//! The test functions of the optimisation goals. `benches/gp_minimize.py` states the same ones for the reference.

use optimise::{SearchDimension, Space};
use std::f64::consts::PI;

/// A noisy test problem with known truth.
pub struct Problem {
    pub name: &'static str,
    /// Bounds of each dimension.
    pub bounds: &'static [(f64, f64)],
    /// Number of constraint margins.
    pub constraints: usize,
    /// Noise-free objective and margins (≥ 0 is feasible).
    pub truth: fn(&[f64]) -> (f64, Vec<f64>),
    /// Standard deviation of the objective's noise.
    pub objective_noise: fn(&[f64]) -> f64,
    /// Standard deviation of each margin's noise.
    pub margin_noise: f64,
    /// The least feasible noise-free objective.
    pub optimum: f64,
}

impl Problem {
    pub fn space(&self) -> Space {
        let dimension =
            |(i, &(low, high)): (usize, &(f64, f64))| SearchDimension::real(&format!("x{i}"), low, high);
        Space::new(self.bounds.iter().enumerate().map(dimension).collect()).expect("the bounds are sound")
    }
}

const UNIT: (f64, f64) = (0.0, 1.0);

pub const PROBLEMS: [Problem; 8] = [
    Problem {
        name: "gramacy",
        bounds: &[(6.0, 18.0)],
        constraints: 0,
        truth: |x| (gramacy(x[0]), vec![]),
        objective_noise: |_| 0.1,
        margin_noise: 0.0,
        optimum: -0.869_011_134_989_499_7,
    },
    Problem {
        name: "step",
        bounds: &[(6.0, 18.0)],
        constraints: 0,
        truth: |x| (step(x[0]), vec![]),
        objective_noise: |x| {
            let q = logistic((x[0] - 9.5) / 0.4);
            0.1 + 2.0 * q * (1.0 - q)
        },
        margin_noise: 0.0,
        optimum: 1.555_041_941_655_896_7,
    },
    Problem {
        name: "well",
        bounds: &[(6.0, 18.0)],
        constraints: 0,
        truth: |x| (well(x[0]), vec![]),
        objective_noise: |_| 0.15,
        margin_noise: 0.0,
        optimum: 0.766_873_268_825_863_7,
    },
    Problem {
        name: "branin",
        bounds: &[(-5.0, 10.0), (0.0, 15.0)],
        constraints: 0,
        truth: |x| (branin(x), vec![]),
        objective_noise: |_| 2.0,
        margin_noise: 0.0,
        optimum: 0.397_887_357_729_738,
    },
    Problem {
        name: "hartmann6",
        bounds: &[UNIT; 6],
        constraints: 0,
        truth: |x| (hartmann6(x), vec![]),
        objective_noise: |_| 0.1,
        margin_noise: 0.0,
        optimum: -3.322_368_011_415_513,
    },
    // Time lost over a braking distance x in metres, interior optimum at √500: braking late costs a full stop, early a crawl.
    // Margins: post-encroachment time over 1.5 s and deceleration under 2.5 m/s², both in the form of the paper's tuning.
    Problem {
        name: "braking",
        bounds: &[(5.0, 60.0)],
        constraints: 2,
        truth: |x| (20.0 / x[0] + 0.04 * x[0], vec![0.1 * x[0] - 1.4, 2.5 - 50.0 / x[0]]),
        objective_noise: |_| 0.05,
        margin_noise: 0.1,
        optimum: 1.788_854_381_999_831_7,
    },
    // Gramacy et al. (2016), "Modeling an augmented Lagrangian for blackbox constrained optimization", eq. 2.
    Problem {
        name: "toy2",
        bounds: &[UNIT; 2],
        constraints: 2,
        truth: |x| {
            let wave = 0.5 * (2.0 * PI * (x[0] * x[0] - 2.0 * x[1])).sin();
            (x[0] + x[1], vec![x[0] + 2.0 * x[1] + wave - 1.5, 1.5 - x[0] * x[0] - x[1] * x[1]])
        },
        objective_noise: |_| 0.05,
        margin_noise: 0.05,
        optimum: 0.599_788_052_010_044_3,
    },
    Problem {
        name: "hartmann6_sum",
        bounds: &[UNIT; 6],
        constraints: 1,
        truth: |x| (hartmann6(x), vec![3.0 - x.iter().sum::<f64>()]),
        objective_noise: |_| 0.1,
        margin_noise: 0.1,
        optimum: -3.322_368_011_415_513,
    },
];

fn logistic(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}

fn gramacy(x: f64) -> f64 {
    let z = 0.5 + (x - 6.0) / 6.0;
    (10.0 * PI * z).sin() / (2.0 * z) + (z - 1.0).powi(4)
}

fn step(x: f64) -> f64 {
    let p = logistic((x - 9.5) / 0.15);
    (1.0 - p) * (3.6 + 0.05 * (x - 6.0)) + p * (1.2 + 0.55 * (x - 9.5).max(0.0))
}

fn well(x: f64) -> f64 {
    let u = (x - 6.0) / 12.0;
    3.0 + 0.4 * (4.0 * PI * u).sin() - 2.5 * (-(x - 14.3).powi(2) / 0.08).exp()
}

fn branin(x: &[f64]) -> f64 {
    let a = x[1] - 5.1 / (4.0 * PI * PI) * x[0] * x[0] + 5.0 / PI * x[0] - 6.0;
    a * a + 10.0 * (1.0 - 1.0 / (8.0 * PI)) * x[0].cos() + 10.0
}

fn hartmann6(x: &[f64]) -> f64 {
    const ALPHA: [f64; 4] = [1.0, 1.2, 3.0, 3.2];
    const A: [[f64; 6]; 4] = [
        [10.0, 3.0, 17.0, 3.5, 1.7, 8.0],
        [0.05, 10.0, 17.0, 0.1, 8.0, 14.0],
        [3.0, 3.5, 1.7, 10.0, 17.0, 8.0],
        [17.0, 8.0, 0.05, 10.0, 0.1, 14.0],
    ];
    const P: [[f64; 6]; 4] = [
        [0.1312, 0.1696, 0.5569, 0.0124, 0.8283, 0.5886],
        [0.2329, 0.4135, 0.8307, 0.3736, 0.1004, 0.9991],
        [0.2348, 0.1451, 0.3522, 0.2883, 0.3047, 0.6650],
        [0.4047, 0.8828, 0.8732, 0.5743, 0.1091, 0.0381],
    ];
    let term = |i: usize| {
        let exponent: f64 = (0..6).map(|j| A[i][j] * (x[j] - P[i][j]).powi(2)).sum();
        ALPHA[i] * (-exponent).exp()
    };
    -(0..4).map(term).sum::<f64>()
}
