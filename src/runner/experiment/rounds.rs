//! Optimisers side by side, a round of their proposals after the other: what the evaluations of one came to decides about
//! the next.

use std::collections::VecDeque;
use std::ops::ControlFlow;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use rayon::prelude::*;
use serde::Serialize;

use super::context::Context;
use super::error::ExperimentError;
use super::journal::Record;
use crate::run::{Done, Job, JobFailure, JobPlace, RunError, Sequence, Sequences, run_sequences};
use optimise::{Definition, Evaluation, Optimiser, Proposal};
use results::Outcome;
use scenario::Case;

/// An optimiser under way, with what it remembers.
pub struct Optimisation {
    pub optimiser: Optimiser,
    record: Record,
    batch: usize,
}

impl Optimisation {
    /// `inputs` is everything besides the definition that decides the evaluations.
    pub fn begin(
        context: &Context,
        name: &str,
        inputs: &impl Serialize,
        definition: Definition,
        batch: usize,
    ) -> Result<Self, ExperimentError> {
        let record = Record::open(context, name, inputs, &definition, batch)?;
        context.tell(record.notice());
        Ok(Self { optimiser: Optimiser::new(definition)?, record, batch })
    }

    /// The next proposals, each with its evaluation where a run that was cut off has left it.
    fn ask(&mut self) -> Result<Vec<(Proposal, Option<Evaluation>)>, ExperimentError> {
        let journal = self.record.journal();
        let recall = |proposal: Proposal| {
            let known = journal.as_ref().map(|journal| journal.recorded(&proposal)).transpose()?.flatten();
            let known = known.cloned();
            Ok((proposal, known))
        };
        self.optimiser.ask(self.batch.max(1)).into_iter().map(recall).collect()
    }

    /// What is only kept in case it is cut off.
    pub fn into_record(self) -> Record {
        self.record
    }
}

/// What proposals are evaluated by.
pub trait EvaluateRound: Sync {
    /// The runs that a proposal of the optimisation with this index takes.
    fn cases(&self, optimisation: usize, proposal: &Proposal) -> Result<Vec<Case>, ExperimentError>;

    /// What a proposal tries, in words; empty where nobody says.
    fn values(&self, proposal: &Proposal) -> String {
        let _ = proposal;
        String::new()
    }

    /// Whether these first outcomes say enough, so that the rest of the runs is not needed.
    fn is_enough(&self, outcomes: &[Outcome]) -> bool {
        let _ = outcomes;
        false
    }

    /// How many runs may be made that turn out not to be needed.
    fn ahead(&self) -> usize {
        usize::MAX
    }

    /// Whether a run that fails like this is left out of its evaluation, which is then of the others.
    fn leaves_out(&self, _error: &RunError) -> bool {
        false
    }

    /// What the outcomes of these cases come to, which are not all where they were enough before.
    fn evaluation(&self, cases: &[Case], outcomes: &[Outcome], abandoned: bool) -> Evaluation;

    /// Told after every evaluation.
    fn evaluated(&self, evaluation: &Evaluation);
}

/// Runs all optimisers to their ends.
///
/// One half goes a round after the other beside the other half: while the last run of a round keeps its own half waiting, there is
/// work of the other.
///
/// # Errors
/// The first in their order of the first round in which there is one, and that of their proposals: a later run tries it again.
///
/// # Panics
/// As a run that did.
pub fn optimise(
    context: &Context,
    all: &mut [Optimisation],
    evaluate: &dyn EvaluateRound,
) -> Result<(), ExperimentError> {
    let middle = all.len().div_ceil(2);
    let (first, second) = all.split_at_mut(middle);
    let failed = AtomicUsize::new(usize::MAX);
    let rounds = |half: &mut [Optimisation], offset: usize| {
        let mut number = 0;
        loop {
            // What fails in an earlier round comes first, whichever half is there sooner.
            if number > failed.load(Ordering::Relaxed) {
                return Ok(());
            }
            match round(context, half, offset, evaluate) {
                Ok(true) => number += 1,
                Ok(false) => return Ok(()),
                Err(error) => {
                    failed.fetch_min(number, Ordering::Relaxed);
                    return Err((number, Box::new(error)));
                }
            }
        }
    };
    let (first, second) = if second.is_empty() {
        (rounds(first, 0), Ok(()))
    } else {
        thread::scope(|scope| {
            let beside = scope.spawn(|| rounds(second, middle));
            let first = rounds(first, 0);
            (first, beside.join().unwrap_or_else(|panicked| resume_unwind(panicked)))
        })
    };
    match (first, second) {
        (Err((one, error)), Err((other, _))) if one <= other => Err(*error),
        (_, Err((_, error))) | (Err((_, error)), Ok(())) => Err(*error),
        (Ok(()), Ok(())) => Ok(()),
    }
}

/// Makes the next round of some optimisers, the first of which has the index `offset`; whether there was one.
fn round(
    context: &Context,
    some: &mut [Optimisation],
    offset: usize,
    evaluate: &dyn EvaluateRound,
) -> Result<bool, ExperimentError> {
    let plan = |(place, one): (usize, &mut Optimisation)| -> Result<Vec<_>, ExperimentError> {
        let planned = |(proposal, known): (Proposal, Option<Evaluation>)| {
            let cases =
                if known.is_some() { Vec::new() } else { evaluate.cases(offset + place, &proposal)? };
            let evaluated = known.map(Ok);
            // The first of a block is made twice, whatever people it is of.
            let number = proposal.id as usize * cases.len() + usize::from(offset + place > 0);
            let (outcomes, left_out) = (Vec::new(), 0);
            Ok(Proposed { place, proposal, cases, outcomes, left_out, number, evaluated, evaluate, context })
        };
        one.ask()?.into_iter().map(planned).collect()
    };
    let proposed = context.executor.think(|| {
        some.par_iter_mut().enumerate().map(plan).collect::<Vec<Result<Vec<Proposed>, ExperimentError>>>()
    });
    let proposed = proposed.into_iter().collect::<Result<Vec<_>, _>>()?;
    let mut round = Round { waiting: proposed.into_iter().flatten().collect(), some, evaluated: Vec::new() };
    if round.waiting.is_empty() {
        return Ok(false);
    }
    run_sequences(context.executor, &mut round, &context.stop);
    let Round { waiting, mut evaluated, .. } = round;
    evaluated.extend(waiting);
    evaluated.sort_by_key(|one| (one.place, one.proposal.id));
    for one in evaluated {
        let evaluation = one.evaluated.unwrap_or(Err(ExperimentError::Stopped))?;
        some[one.place].optimiser.tell(one.proposal.id, evaluation)?;
    }
    Ok(true)
}

/// A proposal under evaluation.
struct Proposed<'r> {
    /// Of its optimisation among those of the round.
    place: usize,
    proposal: Proposal,
    cases: Vec<Case>,
    outcomes: Vec<Outcome>,
    /// How many runs were left out.
    left_out: u32,
    /// Of its first run among those of the block.
    number: usize,
    evaluated: Option<Result<Evaluation, ExperimentError>>,
    evaluate: &'r dyn EvaluateRound,
    context: &'r Context<'r>,
}

impl Sequence for Proposed<'_> {
    fn runs(&self) -> usize {
        self.cases.len()
    }

    fn job(&mut self, place: JobPlace) -> Job {
        let (case, measured) = (self.cases[place.run].clone(), self.context.measured.clone());
        let wanted = self.context.first_runs.wanted(self.number + place.run, &case);
        Job { place, case, measured, wanted, alone: false, change: None }
    }

    fn take(&mut self, done: Done) -> ControlFlow<()> {
        let made = self.outcomes.len() + self.left_out as usize;
        match done.result {
            Ok(mut ran) => {
                if self.context.first_runs.takes(self.number + made, &done.case) {
                    self.context.first_runs.keep(&done.case, &mut ran);
                }
                self.outcomes.push(ran.outcome);
            }
            Err(JobFailure::Error(error)) if self.evaluate.leaves_out(&error) => self.left_out += 1,
            Err(JobFailure::Error(error)) => {
                let (values, key) = (self.evaluate.values(&self.proposal), done.case.key);
                self.evaluated = Some(Err(ExperimentError::Run { values, key, error: Box::new(error) }));
                return ControlFlow::Break(());
            }
            Err(JobFailure::Panicked(panicked)) => resume_unwind(Box::new(panicked)),
        }
        if self.evaluate.is_enough(&self.outcomes) || made + 1 == self.cases.len() {
            let abandoned = made + 1 < self.cases.len();
            let evaluation = self.evaluate.evaluation(&self.cases, &self.outcomes, abandoned);
            self.evaluated = Some(Ok(Evaluation { left_out: self.left_out, ..evaluation }));
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }

    fn ahead(&self) -> usize {
        self.evaluate.ahead()
    }
}

struct Round<'r, 'o> {
    waiting: VecDeque<Proposed<'r>>,
    some: &'o mut [Optimisation],
    evaluated: Vec<Proposed<'r>>,
}

impl<'r> Sequences for Round<'r, '_> {
    type One = Proposed<'r>;

    fn open(&mut self) -> Option<Proposed<'r>> {
        self.waiting.pop_front()
    }

    fn close(&mut self, mut one: Proposed<'r>, _: usize) {
        // What was recalled is neither recorded nor told again, nor is what was given up.
        if let (Some(Ok(evaluation)), false) = (&one.evaluated, one.cases.is_empty()) {
            let Optimisation { optimiser, record, .. } = &mut self.some[one.place];
            // NaN has no JSON: what is recorded is what will be told, so that a resumed run is told the same.
            let checked = evaluation.clone().checked(optimiser.definition()).and_then(|evaluation| {
                let journal = record.journal();
                journal.map_or(Ok(()), |journal| journal.record(&one.proposal, &evaluation))?;
                Ok(evaluation)
            });
            if let Ok(evaluation) = &checked {
                one.evaluate.evaluated(evaluation);
            }
            one.evaluated = Some(checked.map_err(ExperimentError::from));
        }
        one.cases = Vec::new();
        one.outcomes = Vec::new();
        self.evaluated.push(one);
    }
}
