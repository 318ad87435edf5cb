//! Which individuals of a population a scenario is run with.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::Path;

use sha2::{Digest, Sha256};

use super::error::PlanError;
use files::hexadecimal;
use numbers::random::{Stream, derive_seed};
use scenario::population;
use scenario::population::{Plausibility, Population as People};
use scenario::{
    DeclaredPedestrian, Expression, Individual, Individuals, Membership, PopulationShare, Scenario, Settings,
    Suite, Value,
};

/// The groups of people that the scenario is run with; one empty group when nobody is an individual.
///
/// Where several pedestrians are individuals they are taken side by side: the first of each, the second of each. One
/// with a single individual is in every group. Of a group of pedestrians every member is somebody else: `individuals 20 of` are
/// then 20 for each of five members, 100 people who all are different, so that no two groups share anybody. The draw depends on the suite's seed, the pedestrian's name and the
/// population, so that every scenario of a suite meets the same people.
pub fn select(seed: u64, scenario: &Scenario) -> Result<Vec<Vec<Individual>>, PlanError> {
    let mut chosen: Vec<(&DeclaredPedestrian, &Individuals, Vec<Individual>)> = Vec::new();
    for pedestrian in &scenario.pedestrians {
        let taken = pedestrian.individuals.as_ref().filter(|one| one.selection != PopulationShare::Drawn);
        if let Some(individuals) = taken {
            chosen.push((pedestrian, individuals, choose(seed, pedestrian, individuals)?));
        }
    }
    if let Some((pedestrian, individuals, _)) = chosen.iter().find(|(_, _, people)| people.len() > 1)
        && scenario.draws_people()
    {
        let message = format!(
            "`{}` is one of several people again and again, but others are drawn anew in every run",
            pedestrian.name
        );
        return Err(PlanError::new(&individuals.origin, message).with_hint(format!(
            "draw this one too: `individuals drawn from {}`, or take one person: `individual 17 of …`",
            individuals.population
        )));
    }
    let groups = chosen.iter().map(|(_, _, people)| people.len()).max().unwrap_or(1);
    for (pedestrian, individuals, people) in &chosen {
        if people.len() != 1 && people.len() != groups {
            let message = format!(
                "`{}` is {} individuals, but another pedestrian of the scenario is {groups}",
                pedestrian.name,
                people.len()
            );
            return Err(PlanError::new(&individuals.origin, message)
                .with_hint("take the same number of individuals for every pedestrian, or only one"));
        }
    }
    let member = |people: &Vec<Individual>, group: usize| people[group % people.len()].clone();
    Ok((0..groups).map(|group| chosen.iter().map(|(_, _, people)| member(people, group)).collect()).collect())
}

/// The people that one pedestrian is.
fn choose(
    seed: u64,
    pedestrian: &DeclaredPedestrian,
    individuals: &Individuals,
) -> Result<Vec<Individual>, PlanError> {
    let origin = &individuals.origin;
    let people = read(pedestrian, individuals)?;
    let key =
        |who: &str| derive_seed(seed, &format!("individuals/{who}/{}", file_name(&individuals.population)));
    let numbers: Vec<usize> = match (individuals.selection.clone(), &pedestrian.group) {
        // Nobody is chosen before the runs.
        (PopulationShare::Drawn, _) => return Ok(Vec::new()),
        (PopulationShare::All, None) => (1..=people.len()).collect(),
        (PopulationShare::Number(number), None) => vec![number as usize],
        (PopulationShare::Count(count), None) => draw(count as usize, people.len(), key(&pedestrian.name)),
        (selection, Some(Membership { group, index, size })) => {
            let (index, size) = (*index as usize, *size as usize);
            let each = match selection {
                PopulationShare::Count(count) => count as usize,
                PopulationShare::All if people.len().is_multiple_of(size) => people.len() / size,
                PopulationShare::All => 0,
                PopulationShare::Number(_) | PopulationShare::Drawn => usize::from(size == 1),
            };
            if each == 0 || each * size > people.len() {
                return Err(too_few(group, size, each, individuals, people.len()));
            }
            match selection {
                PopulationShare::Number(number) => vec![number as usize],
                // Not by their numbers: who stand beside each other in a file may be alike.
                _ => {
                    let drawn = in_order_of_draws(each * size, people.len(), key(group));
                    drawn.into_iter().skip(index).step_by(size).collect()
                }
            }
        }
    };
    let individual = |number: usize| {
        let parameters = people.individual(number)?;
        Some(Individual {
            pedestrian: pedestrian.name.clone(),
            population: file_name(&individuals.population),
            number: u32::try_from(number).ok()?,
            parameters,
        })
    };
    let chosen: Option<Vec<Individual>> = numbers.into_iter().map(individual).collect();
    chosen.filter(|chosen| !chosen.is_empty()).ok_or_else(|| {
        let asked = match individuals.selection {
            PopulationShare::Number(number) => format!("no individual {number}"),
            PopulationShare::Count(count) => format!("not {count} individuals"),
            PopulationShare::All | PopulationShare::Drawn => "nobody".to_string(),
        };
        let message = format!(
            "the population `{}` has {asked}: there are {}, numbered from 1",
            individuals.population,
            people.len()
        );
        PlanError::new(origin, message)
            .with_hint(format!("take at most {}, or `individuals all of …`", people.len()))
    })
}

/// That the members of a group cannot all be different people.
fn too_few(group: &str, size: usize, each: usize, individuals: &Individuals, known: usize) -> PlanError {
    let population = file_name(&individuals.population);
    let message = match individuals.selection {
        PopulationShare::Number(number) => {
            format!("individual {number} is one person, and the group `{group}` is {size}")
        }
        PopulationShare::All | PopulationShare::Drawn => {
            format!(
                "the {known} people of `{population}` cannot be shared out in groups of {size}, as `{group}` is: {} are left over",
                known % size
            )
        }
        PopulationShare::Count(_) => format!(
            "{each} for each of the {size} members of `{group}` are {} people, and the population `{population}` has {known}",
            each.saturating_mul(size)
        ),
    };
    PlanError::new(&individuals.origin, message).with_hint(format!(
        "every member is somebody else: take `individuals {} of …`, or fewer",
        known / size
    ))
}

/// Everybody in the population of a pedestrian.
pub(super) fn read(pedestrian: &DeclaredPedestrian, individuals: &Individuals) -> Result<People, PlanError> {
    let origin = &individuals.origin;
    let name = &pedestrian.model.first;
    let model = name.entry().ok_or_else(|| {
        PlanError::new(&pedestrian.model.origin, format!("there is no pedestrian model called `{name}`"))
    })?;
    if !model.takes_individuals {
        let message = format!("the model `{name}` has no individuals");
        return Err(PlanError::new(origin, message).with_hint("leave out `individuals`"));
    }
    let text = individuals.text.as_ref().map(|text| text.as_deref().map_err(String::as_str));
    People::parse(&individuals.population, text, &model.declaration, variant(pedestrian)).map_err(|error| {
        PlanError::new(origin, error.to_string()).with_hint(
            "take `standard` or `humans`, which ship, or a file as docs/populations.md describes it",
        )
    })
}

/// How usual people are among those whom a pedestrian is drawn from; `None` where these are too few or too much alike for that.
///
/// # Errors
/// If the population cannot be read.
pub fn plausibility_of(
    pedestrian: &DeclaredPedestrian,
    individuals: &Individuals,
) -> Result<Option<Plausibility>, PlanError> {
    let shipped = pedestrian.model.first.entry();
    let shipped =
        shipped.and_then(|model| Plausibility::of_shipped(&individuals.population, &model.declaration));
    Ok(match shipped {
        Some(known) => Some(known.clone()),
        None => Plausibility::of(&read(pedestrian, individuals)?),
    })
}

/// The populations of a suite by the names of their files, each with a digest (16 hexadecimal digits) of everybody in
/// it, drawn or not. How the file is laid out does not matter.
pub fn populations(suite: &Suite) -> Result<BTreeMap<String, String>, PlanError> {
    let pedestrians = suite.scenarios.iter().flat_map(|scenario| &scenario.pedestrians);
    let mut known: BTreeMap<(&str, &str, Option<&str>), Everybody> = BTreeMap::new();
    for pedestrian in pedestrians {
        let Some(individuals) = &pedestrian.individuals else { continue };
        let key = (individuals.population.as_str(), pedestrian.model.first.name(), variant(pedestrian));
        if let Entry::Vacant(place) = known.entry(key) {
            place.insert(Everybody::of(&read(pedestrian, individuals)?));
        }
    }
    let mut digests: BTreeMap<String, Vec<Everybody>> = BTreeMap::new();
    for ((population, ..), everybody) in known {
        digests.entry(file_name(population)).or_default().push(everybody);
    }
    Ok(digests.into_iter().map(|(name, several)| (name, digest(&several))).collect())
}

/// Who is in a population, as a digest is made of it.
enum Everybody {
    /// One after the other.
    Each(Vec<u8>),
    /// Rows and weights, by the digest that a calibration tells of its population.
    Weighted(String),
}

impl Everybody {
    fn of(people: &People) -> Self {
        if !people.weights.is_empty() {
            return Self::Weighted(people.digest());
        }
        let everybody: Vec<Settings> =
            (1..=people.len()).filter_map(|number| people.individual(number)).collect();
        Self::Each(serde_json::to_vec(&everybody).expect("plain data serialises"))
    }

    fn bytes(&self) -> &[u8] {
        match self {
            Self::Each(bytes) => bytes,
            Self::Weighted(digest) => digest.as_bytes(),
        }
    }
}

fn digest(several: &[Everybody]) -> String {
    if let [Everybody::Weighted(digest)] = several {
        return digest.clone();
    }
    let mut digest = Sha256::default();
    several.iter().for_each(|one| digest.update(one.bytes()));
    hexadecimal(&digest.finalize()[..8])
}

/// The variant that the scenario asks of the pedestrian's model, if it says so outright.
fn variant(pedestrian: &DeclaredPedestrian) -> Option<&str> {
    pedestrian.model.settings.iter().find_map(|(name, expression)| match expression {
        Expression::Constant(Value::Word(word)) if name == population::VARIANT => Some(word.as_str()),
        _ => None,
    })
}

/// `count` different numbers of 1..=`size`, in rising order; more than there are if `count` is above `size`.
///
/// A smaller draw with the same seed is part of a larger one.
fn draw(count: usize, size: usize, seed: u64) -> Vec<usize> {
    if count > size {
        return vec![size + 1];
    }
    let mut numbers = in_order_of_draws(count, size, seed);
    numbers.sort_unstable();
    numbers
}

fn in_order_of_draws(count: usize, size: usize, seed: u64) -> Vec<usize> {
    let mut stream = Stream::seeded(seed);
    let mut numbers: Vec<usize> = (1..=size).collect();
    stream.draw(&mut numbers, count);
    numbers
}

/// A population by the name of its file, which is the same wherever the project lies.
pub(super) fn file_name(population: &str) -> String {
    let name = Path::new(population).file_name();
    name.map_or_else(|| population.to_string(), |name| name.to_string_lossy().into_owned())
}

/// The part of a case's key that names its people: empty without, `/individual=17` with one.
pub fn label(people: &[Individual]) -> String {
    match people {
        [] => String::new(),
        [only] => format!("/individual={}", only.number),
        several => {
            let names: Vec<_> = several.iter().map(|p| format!("{}={}", p.pedestrian, p.number)).collect();
            format!("/{}", names.join("+"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use models::standard;
    use scenario::{DeclaredAppearance, DeclaredMayGo, Direction, Model, Origin, Road, Side};

    fn pedestrian(
        name: &str,
        model: &str,
        variant: Option<&str>,
        selection: PopulationShare,
    ) -> DeclaredPedestrian {
        let number = |x| Expression::Constant(Value::Number(x));
        let settings =
            variant.map(|word| ("variant".to_string(), Expression::Constant(Value::Word(word.to_string()))));
        DeclaredPedestrian {
            name: name.to_string(),
            kind: Default::default(),
            model: Model {
                first: standard().pedestrians().get(model).unwrap().into(),
                varied_by: None,
                varied: Vec::new(),
                others: Vec::new(),
                settings: settings.into_iter().collect(),
                origin: Origin::default(),
            },
            shape: None,
            side: Side::Near,
            start_from_lane_centre: number(4.0),
            crosses: None,
            waits_on_refuges: false,
            along: number(0.0),
            goal_beyond_kerb: number(2.0),
            turned: number(0.0),
            walks: None,
            appears: DeclaredAppearance::At(number(0.0)),
            may_go: DeclaredMayGo::AtOnce,
            may_start_inside: false,
            reference: number(0.0),
            obeys_signals: None,
            individuals: Some(Individuals {
                selection,
                population: "standard".to_string(),
                text: None,
                origin: Origin::default(),
            }),
            group: None,
            origin: Origin::default(),
        }
    }

    fn scenario(pedestrians: Vec<DeclaredPedestrian>) -> Scenario {
        Scenario {
            name: "zebra".to_string(),
            doc: None,
            tags: Vec::new(),
            road: Road::zebra(&[Direction::Forward], 10.0),
            bend: None,
            ground: None,
            other_crossings: Vec::new(),
            other_roads: Vec::new(),
            signal: None,
            vehicles: Vec::new(),
            pedestrians,
            variations: Vec::new(),
            repeat: 1,
            runs: None,
            seed: None,
            criteria: Vec::new(),
            step: 0.025,
            horizon: 60.0,
            finish: 20.0,
            end_on_collision: true,
            written: Default::default(),
            draws: Vec::new(),
            origin: Origin::default(),
        }
    }

    fn numbers(groups: &[Vec<Individual>]) -> Vec<u32> {
        groups.iter().map(|group| group[0].number).collect()
    }

    #[test]
    fn draws_are_without_replacement_seeded_and_nested() {
        let select = |seed, count| {
            let walker = pedestrian("walker", "commotions", None, PopulationShare::Count(count));
            numbers(&select(seed, &scenario(vec![walker])).unwrap())
        };
        let (five, fifty) = (select(1, 5), select(1, 50));
        assert_eq!((five.len(), fifty.len()), (5, 50));
        assert!(fifty.windows(2).all(|pair| pair[0] < pair[1]));
        assert!(five.iter().all(|number| fifty.contains(number)));
        assert_eq!(five, select(1, 5));
        assert_ne!(five, select(2, 5));
    }

    #[test]
    fn individuals_bring_their_parameters() {
        let walker = pedestrian("walker", "commotions", None, PopulationShare::Number(17));
        let groups = select(1, &scenario(vec![walker])).unwrap();
        let person = &groups[0][0];
        assert_eq!((groups.len(), person.number), (1, 17));
        assert!(person.parameters.number("T_delta") >= 10.0);
        assert_eq!(person.parameters.word("variant"), "oVAoBEvoAIoEAoSNvoPF");
    }

    #[test]
    fn several_pedestrians_go_side_by_side() {
        let one = pedestrian("one", "commotions", None, PopulationShare::Count(3));
        let two = pedestrian("two", "commotions", None, PopulationShare::Number(17));
        let groups = select(1, &scenario(vec![one, two])).unwrap();
        assert_eq!(groups.len(), 3);
        assert!(groups.iter().all(|group| group.len() == 2 && group[1].number == 17));
        assert!(label(&groups[0]).ends_with("+two=17"));
    }

    #[test]
    fn what_cannot_be_says_why() {
        let say = |pedestrians: Vec<DeclaredPedestrian>| {
            let error = select(1, &scenario(pedestrians)).unwrap_err();
            format!("{} ({})", error.message, error.hint.unwrap_or_default())
        };
        let walker = |selection| pedestrian("walker", "commotions", None, selection);
        let said = [
            say(vec![walker(PopulationShare::Number(1_000_000))]),
            say(vec![walker(PopulationShare::Number(0))]),
            say(vec![walker(PopulationShare::Count(1_000_000))]),
            say(vec![pedestrian("walker", "carla_walker", None, PopulationShare::All)]),
            say(vec![pedestrian("walker", "commotions", Some("oVAoAI"), PopulationShare::All)]),
            say(vec![
                walker(PopulationShare::Count(2)),
                pedestrian("other", "commotions", None, PopulationShare::Count(3)),
            ]),
        ];
        let there_are = People::parse(
            "standard",
            None,
            &standard().pedestrians().get("commotions").unwrap().declaration,
            None,
        );
        let there_are = format!("there are {}", there_are.unwrap().len());
        insta::assert_snapshot!(said.join("\n").replace(&there_are, "there are N"));
    }
}
