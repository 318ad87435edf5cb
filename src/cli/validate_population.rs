//! Populations beside people whom no calibration has seen: other noise, and one population for two laboratories.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::Exit;
use files::{Disk, Files};
use models::pedestrian::commotions::encounter::{EncounterCondition, EncounteredShares};
use models::pedestrian::commotions::held_back::HikerPersons;
use models::pedestrian::commotions::hiker::HikerReference;
use models::pedestrian::commotions::laboratories::{Laboratory, LaboratoryFit, LaboratoryStudy};
use models::pedestrian::commotions::model::commotions;
use models::pedestrian::commotions::{Parameters, Variant};
use report::console::{stderr, stdout};
use scenario::population::Population;
use scenario::{Observations, ObservedRow};

type Failure = Box<dyn std::error::Error>;

/// Some of a population, evenly spaced in it.
pub struct SomeMembers {
    pub variant: Variant,
    pub people: Vec<Parameters>,
    /// Where each stands among the others: logarithms of the parameters.
    pub coordinates: Vec<Vec<f64>>,
    pub digest: String,
}

impl SomeMembers {
    pub fn read(population: &str, members: usize) -> Result<Self, Failure> {
        let declaration = commotions().declaration;
        let text = Disk.read_text(Path::new(population), &["csv", "json"]).map_err(|error| error.to_string());
        let text = Some(text.as_deref().map_err(String::as_str));
        let known = Population::parse(population, text, &declaration, None)?;
        let members = members.min(known.len());
        let number = |index: usize| index * known.len() / members + known.len() / members / 2 + 1;
        let drawn = (0..members).filter_map(|index| known.individual(number(index).min(known.len())));
        let drawn: Vec<_> = drawn.collect();
        let place = |name: &String, settings: &scenario::Settings| {
            let value = settings.number(name);
            if value > 0.0 { libm::log(value) } else { value }
        };
        Ok(Self {
            variant: known.variant.as_deref().map_or(Ok(Variant::STANDARD), str::parse)?,
            coordinates: drawn
                .iter()
                .map(|one| known.parameters.iter().map(|name| place(name, one)).collect())
                .collect(),
            people: drawn.iter().map(Parameters::from_settings).collect(),
            digest: known.digest(),
        })
    }
}

/// The conditions of the encounter that the rows of a file are about.
fn conditions(rows: &[ObservedRow]) -> Result<Vec<(EncounterCondition, &ObservedRow)>, Failure> {
    let of = |row| {
        let row: &ObservedRow = row;
        if row.by_count.is_empty() {
            let reason = "says no persons by their counts, `persons_0` and so on, which are needed here";
            return Err(format!("row {} {reason}", row.row).into());
        }
        let gap = row.values.iter().find(|(name, _)| name == "gap");
        let condition = gap.and_then(|(_, gap)| EncounterCondition::of_row(&row.scenario, gap));
        condition.map(|condition| (condition, row)).ok_or_else(|| {
            format!(
                "row {} is about {}; rows of the encounter are about `crossing_plain` or `crossing_zebra` and a `gap` such as `4 s`",
                row.row,
                row.in_words()
            )
            .into()
        })
    };
    rows.iter().map(of).collect()
}

fn observed(file: &Path) -> Result<Observations, Failure> {
    let text = Disk.read_text(file, &["csv"])?;
    let name = file.display().to_string();
    let read = Observations::parse(&name, &text);
    Ok(read.map_err(|error| format!("{name}: {error}; {}", error.hint()))?)
}

/// A population in the conditions of the encounter, once for each seed.
pub fn encounter(
    file: &Path,
    population: &str,
    members: usize,
    repetitions: u32,
    seeds: &[u64],
) -> Result<Exit, Failure> {
    let observations = observed(file)?;
    let conditions = conditions(&observations.rows)?;
    let SomeMembers { variant, people, digest, .. } = SomeMembers::read(population, members)?;
    writeln!(
        stdout(),
        "{} of {population}, digest {digest}, {repetitions} times each; %, share and spread of each seed",
        people.len()
    );
    let seeded = seeds.iter().map(|seed| format!("      seed {seed:<8}")).collect::<String>();
    writeln!(stdout(), "condition   people  spread |{seeded} | median start, crossing (s)");
    let mut apart = vec![Vec::new(); seeds.len()];
    for (condition, row) in &conditions {
        let most = row.by_count.len() - 1;
        let pairs = |count: usize| (count * count.saturating_sub(1)) as f64 / (most * (most - 1)) as f64;
        let each = row.by_count.iter().enumerate().map(|(count, persons)| pairs(count) * f64::from(*persons));
        let spread = each.sum::<f64>() / f64::from(row.persons);
        let found: Vec<EncounteredShares> =
            seeds.iter().map(|seed| condition.shares(&variant, &people, repetitions, *seed)).collect();
        for (apart, one) in apart.iter_mut().zip(&found) {
            apart.push(100.0 * (one.share - row.share));
        }
        let shown =
            |one: &EncounteredShares| format!("   {:7.1} {:7.1}   ", 100.0 * one.share, 100.0 * one.spread);
        let second =
            |value: Option<f64>| value.map_or_else(|| "–".to_string(), |value| format!("{value:.2}"));
        let first = found.first();
        writeln!(
            stdout(),
            "{:10} {:7.1} {:7.1} |{} | {:>6} {:>6}",
            condition.name(),
            100.0 * row.share,
            100.0 * spread,
            found.iter().map(shown).collect::<String>(),
            second(first.and_then(|one| one.start)),
            second(first.and_then(|one| one.crossing)),
        );
    }
    for (seed, apart) in seeds.iter().zip(&apart) {
        let squares: f64 = apart.iter().map(|one| one * one).sum();
        let farthest = apart.iter().map(|one| one.abs()).fold(0.0, f64::max);
        writeln!(
            stdout(),
            "seed {seed}: root mean square {:.1} points, farthest {farthest:.1} points",
            (squares / apart.len() as f64).sqrt()
        );
    }
    Ok(Exit::Success)
}

/// Weights for one laboratory, for the other, and for both.
pub fn laboratories(
    reference: &Path,
    persons: &Path,
    file: &Path,
    (candidates, count): (&str, usize),
    (runs, seed): (u32, u64),
) -> Result<Exit, Failure> {
    let (hiker, persons) = (HikerReference::read(reference)?, HikerPersons::read(persons)?);
    let observations = observed(file)?;
    let conditions = conditions(&observations.rows)?;
    let SomeMembers { variant, people, coordinates, digest } = SomeMembers::read(candidates, count)?;
    let study = LaboratoryStudy {
        encounter: &conditions,
        hiker: &hiker,
        persons: &persons,
        variant: &variant,
        candidates: &people,
        coordinates: &coordinates,
        runs,
        seed,
    };
    let done = AtomicUsize::new(0);
    let found = study.run(|| {
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        if done.is_multiple_of(100) {
            writeln!(stderr(), "{done} of {} candidates", people.len());
        }
    });
    writeln!(
        stdout(),
        "{} of {candidates}, digest {digest}, {runs} runs of each in every condition",
        people.len()
    );
    writeln!(
        stdout(),
        "weights know         effective |  encounter: shares  farthest  spread |  HIKER: shares  farthest  spread"
    );
    let both = [Laboratory::Encounter, Laboratory::Hiker];
    let fits = [found.equal(), found.fit(&both[..1]), found.fit(&both[1..]), found.fit(&both)];
    for LaboratoryFit { knows, effective_size, missed } in &fits {
        let known = match knows.as_slice() {
            [] => "nothing (all equal)",
            [Laboratory::Encounter] => "the encounter",
            [Laboratory::Hiker] => "HIKER",
            _ => "both",
        };
        let points = |at: usize| {
            let one = &missed[at];
            format!("{:8.1} {:9.1} {:7.1}", 100.0 * one.share, 100.0 * one.farthest, 100.0 * one.spread)
        };
        writeln!(stdout(), "{known:20} {effective_size:9.0} | {:>36} | {:>32}", points(0), points(1));
    }
    writeln!(
        stdout(),
        "root mean square and largest error in points, under noise that no weight has seen; shares and spreads are matched within their errors"
    );
    Ok(Exit::Success)
}
