//! What a block has to wait for: runs, and the results of other blocks.

use scenario::{
    Block, CaseSet, Measured, OutcomesOf, ParameterSet, Quantity, SampleSize, Statement, StatementClaim,
    StatementClaimKind,
};

/// What a block has to wait for.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Need {
    /// The result of the block of this name.
    Block(String),
    /// Every run of the scenario of this name.
    Scenario(String),
}

/// What it has to wait for, each once.
pub fn needs(block: &Block) -> Vec<Need> {
    let all = match block {
        Block::Search(_) | Block::Calibrate(_) | Block::Estimate(_) => Vec::new(),
        Block::Tune(tune) => case_set_needs(&tune.on),
        Block::Evaluate(evaluate) => {
            let mut needs = case_set_needs(&evaluate.on);
            needs.extend(evaluate.conditions.iter().filter_map(|one| match &one.parameters {
                ParameterSet::Tuned(tune) => Some(Need::Block(tune.clone())),
                _ => None,
            }));
            needs
        }
        Block::Statement(statement) => {
            let of = measured(statement).into_iter().map(|measured| match &measured.of {
                OutcomesOf::Scenario(name) => Need::Scenario(name.clone()),
                OutcomesOf::Search(name) | OutcomesOf::Condition { evaluate: name, .. } => {
                    Need::Block(name.clone())
                }
            });
            let chosen = tunes(statement).into_iter().map(|name| Need::Block(name.to_string()));
            of.chain(chosen).collect()
        }
    };
    let mut needs = Vec::new();
    for need in all {
        if !needs.contains(&need) {
            needs.push(need);
        }
    }
    needs
}

fn case_set_needs(set: &CaseSet) -> Vec<Need> {
    match set {
        CaseSet::Search(name) | CaseSet::Bests(name) => vec![Need::Block(name.clone())],
        CaseSet::Sample { count: SampleSize::AsManyAs(search), .. } => vec![Need::Block(search.clone())],
        CaseSet::Sample { .. } | CaseSet::Scenario(_) | CaseSet::Saved(_) => Vec::new(),
    }
}

/// Every aggregate that a statement asks for.
pub(super) fn measured(statement: &Statement) -> Vec<&Measured> {
    statement.claims.iter().flat_map(measured_by).collect()
}

/// Every aggregate that a claim asks for.
pub(super) fn measured_by(claim: &StatementClaim) -> Vec<&Measured> {
    match &claim.kind {
        StatementClaimKind::Trend { measured, .. } => vec![measured],
        StatementClaimKind::Compares { left, right, .. } => {
            let leaves = leaves(left).into_iter().chain(leaves(right));
            let measured = leaves.filter_map(|quantity| match quantity {
                Quantity::Measured(measured) => Some(measured),
                _ => None,
            });
            measured.collect()
        }
    }
}

/// Every tune whose choice a statement asks for.
pub(super) fn tunes(statement: &Statement) -> Vec<&str> {
    let mut found = Vec::new();
    for claim in &statement.claims {
        if let StatementClaimKind::Compares { left, right, .. } = &claim.kind {
            for quantity in leaves(left).into_iter().chain(leaves(right)) {
                if let Quantity::Chosen { tune, .. } = quantity {
                    found.push(tune.as_str());
                }
            }
        }
    }
    found
}

fn leaves(quantity: &Quantity) -> Vec<&Quantity> {
    match quantity {
        Quantity::Binary { left, right, .. } => [leaves(left), leaves(right)].concat(),
        leaf => vec![leaf],
    }
}
