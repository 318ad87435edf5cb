//! The units of suites: what is selected, run and reported, and what each needs.

use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::sync::Arc;

use crate::experiment::{Need, needs as needs_of};
use crate::plan::{PlannedTrial, ScenarioPlan};
use crate::project::PlannedSuite;
use results::Recorded;
use scenario::Block;

/// One trial or block, or a run that failed before.
#[derive(Debug, Clone)]
pub struct Unit<'a> {
    /// Index of its suite.
    pub suite: usize,
    /// Its name in every report.
    pub key: String,
    /// What is to be done.
    pub work: Work<'a>,
    /// Indices of the units whose results it reads; all of them come before it.
    pub needs: Vec<usize>,
}

/// What a unit consists of.
#[derive(Debug, Clone)]
pub enum Work<'a> {
    /// A run that failed in an earlier session.
    Recorded(&'a Recorded),
    /// A trial with its runs.
    Trial(PlannedTrial),
    /// A search, a tune, an evaluation or a statement.
    Block(Arc<Block>),
}

impl Unit<'_> {
    /// The trial that it is, if it is one.
    pub(crate) fn trial(self) -> Option<PlannedTrial> {
        match self.work {
            Work::Trial(trial) => Some(trial),
            Work::Recorded(_) | Work::Block(_) => None,
        }
    }
}

/// The units of suites by their indices, suite after suite: what failed before, the trials, the blocks. There may be millions of
/// trials, so each is planned when somebody asks for it.
#[derive(Debug)]
pub struct Units<'a> {
    /// Units that follow each other, by the first of them.
    spans: Vec<Span<'a>>,
    len: usize,
}

#[derive(Debug)]
struct Span<'a> {
    first: usize,
    suite: usize,
    of: SpanOf<'a>,
}

#[derive(Debug)]
enum SpanOf<'a> {
    Recorded {
        recorded: &'a Recorded,
        key: String,
    },
    /// All of a scenario; `place` of the suite's trials come before.
    Trials {
        scenario: &'a ScenarioPlan,
        place: usize,
    },
    Block {
        block: Arc<Block>,
        key: String,
        needs: Vec<usize>,
    },
}

/// Of which kind a unit is.
#[derive(Debug, Clone, Copy)]
pub enum UnitKind<'u> {
    /// A run that failed in an earlier session.
    Recorded,
    /// A trial, which is not worked out.
    Trial {
        /// What its scenario plans.
        scenario: &'u ScenarioPlan,
        /// Among the trials of its suite, counted from 0.
        place: usize,
    },
    /// A search, a tune, an evaluation or a statement.
    Block(&'u Arc<Block>),
}

impl<'a> Units<'a> {
    fn push(&mut self, suite: usize, count: usize, of: SpanOf<'a>) {
        if count > 0 {
            self.spans.push(Span { first: self.len, suite, of });
            self.len += count;
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is nothing to be done.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    fn span(&self, index: usize) -> &Span<'a> {
        assert!(index < self.len, "there is no unit {index} of {}", self.len);
        &self.spans[self.spans.partition_point(|span| span.first <= index) - 1]
    }

    /// The unit with this index below [`Self::len`].
    pub fn get(&self, index: usize) -> Unit<'a> {
        let Span { first, suite, of } = self.span(index);
        let (key, work, needs) = match of {
            SpanOf::Recorded { recorded, key } => (key.clone(), Work::Recorded(recorded), Vec::new()),
            SpanOf::Trials { scenario, .. } => {
                let trial = scenario.trial(index - first);
                (trial.key.clone(), Work::Trial(trial), Vec::new())
            }
            SpanOf::Block { block, key, needs } => (key.clone(), Work::Block(block.clone()), needs.clone()),
        };
        Unit { suite: *suite, key, work, needs }
    }

    /// All of them in order, each worked out when it is asked for.
    pub fn iter(&self) -> impl Iterator<Item = Unit<'a>> {
        (0..self.len).map(|index| self.get(index))
    }

    /// What [`Self::get`] has as `key`.
    pub fn key(&self, index: usize) -> String {
        let Span { first, of, .. } = self.span(index);
        match of {
            SpanOf::Recorded { key, .. } | SpanOf::Block { key, .. } => key.clone(),
            SpanOf::Trials { scenario, .. } => scenario.trial_key(index - first),
        }
    }

    /// All of them in order.
    pub fn keys(&self) -> impl Iterator<Item = String> {
        (0..self.len).map(|index| self.key(index))
    }

    /// The index of the unit's suite.
    pub fn suite(&self, index: usize) -> usize {
        self.span(index).suite
    }

    /// Of which kind the unit with this index is, without working it out.
    pub fn kind(&self, index: usize) -> UnitKind<'_> {
        let Span { first, of, .. } = self.span(index);
        match of {
            SpanOf::Recorded { .. } => UnitKind::Recorded,
            SpanOf::Trials { scenario, place } => {
                UnitKind::Trial { scenario, place: place + (index - first) }
            }
            SpanOf::Block { block, .. } => UnitKind::Block(block),
        }
    }

    /// The indices of those that are no trials.
    pub fn others(&self) -> impl Iterator<Item = usize> {
        let is_other = |span: &&Span| !matches!(span.of, SpanOf::Trials { .. });
        self.spans.iter().filter(is_other).map(|span| span.first)
    }

    /// The index of the trial with this place in the suite with this index.
    pub fn of_trial(&self, suite: usize, place: usize) -> usize {
        let before = |span: &Span| match &span.of {
            _ if span.suite != suite => span.suite < suite,
            SpanOf::Recorded { .. } => true,
            SpanOf::Trials { place: first, .. } => *first <= place,
            SpanOf::Block { .. } => false,
        };
        let span = &self.spans[self.spans.partition_point(before) - 1];
        let SpanOf::Trials { place: first, .. } = span.of else {
            panic!("suite {suite} has no trial {place}")
        };
        span.first + (place - first)
    }

    /// Whether it is not made of runs that are known beforehand.
    pub fn is_block(&self, index: usize) -> bool {
        matches!(self.kind(index), UnitKind::Block(_))
    }

    /// What [`Self::get`] has as `needs`.
    pub fn needs(&self, index: usize) -> &[usize] {
        match &self.span(index).of {
            SpanOf::Recorded { .. } | SpanOf::Trials { .. } => &[],
            SpanOf::Block { needs, .. } => needs,
        }
    }

    /// How many runs it is; those of a block cannot be counted beforehand.
    pub fn runs(&self, index: usize) -> usize {
        match self.kind(index) {
            UnitKind::Recorded => 1,
            UnitKind::Trial { scenario, .. } => scenario.runs(),
            UnitKind::Block(_) => 0,
        }
    }
}

/// Every unit of the suites.
pub fn units(suites: &[PlannedSuite]) -> Units<'_> {
    let mut units = Units { spans: Vec::new(), len: 0 };
    for (suite, prepared) in suites.iter().enumerate() {
        let mut known = HashSet::new();
        for recorded in &prepared.recorded {
            let mut key = format!("{}{}", prepared.suite.apart, recorded.unit_key());
            if !known.insert(key.clone()) {
                // The same run of the suite failed under another seed, too.
                key += &format!("/seed={}", recorded.seed);
            }
            units.push(suite, 1, SpanOf::Recorded { recorded, key });
        }
        let mut scenarios: HashMap<&str, Vec<Range<usize>>> = HashMap::new();
        let mut place = 0;
        for scenario in prepared.plan.scenarios() {
            let (first, count) = (units.len, scenario.len());
            scenarios.entry(&scenario.scenario().name).or_default().push(first..first + count);
            units.push(suite, count, SpanOf::Trials { scenario, place });
            place += count;
        }
        let mut blocks: HashMap<String, usize> = HashMap::new();
        for block in Block::all(&prepared.suite) {
            let mut needs = Vec::new();
            for need in needs_of(&block) {
                // What is not there was reported by the checker, or is by the block itself.
                match need {
                    Need::Block(name) => needs.extend(blocks.get(name.as_str())),
                    Need::Scenario(name) => {
                        needs.extend(scenarios.get(name.as_str()).into_iter().flatten().cloned().flatten());
                    }
                }
            }
            blocks.insert(block.name().to_string(), units.len);
            let key = block.key(&prepared.suite.key_name());
            units.push(suite, 1, SpanOf::Block { block: block.clone(), key, needs });
        }
    }
    units
}

/// Whether each unit is to run: those that are wanted, and all that they need.
pub fn with_needs(units: &Units, mut wanted: Vec<bool>) -> Vec<bool> {
    // Needs come before those who need them.
    for index in (0..wanted.len()).rev() {
        if wanted[index] {
            units.needs(index).iter().for_each(|need| wanted[*need] = true);
        }
    }
    wanted
}
