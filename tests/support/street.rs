//! A street of two lanes in the same direction, with any number of vehicles and pedestrians, and what came of a run on it.

use std::sync::{Arc, LazyLock};

use models::standard;
use runner::run::road_users;
use scenario::population::Population;
use scenario::registry::Registry;
use scenario::{
    Appearance, ControllerModel, Direction, DynamicsModel, MayGo, ModelSetup, PedestrianModel,
    PedestrianSetup, Position, Road, RoadUserKind, Settings, Shape, Side, VehicleSetup, VehicleStart, World,
};
use sim::{
    Command, Controller, ControllerError, Driver, Observation, Observer, RoadUsers, Schedule, Solid, Step,
    simulate,
};

/// The registry, made once: every road user of every run is from it.
static REGISTRY: LazyLock<Registry> = LazyLock::new(standard);

/// A zebra over two lanes of 4 m, both along +x, kerbs at -2 m and 6 m; runs go on after a contact.
pub fn street(speed: f64, vehicles: Vec<VehicleSetup>, pedestrians: Vec<PedestrianSetup>) -> World {
    World {
        road: Road::zebra(&[Direction::Forward, Direction::Forward], speed),
        other_roads: Vec::new(),
        vehicles,
        pedestrians,
        streams: Vec::new(),
        step: 0.025,
        horizon: 25.0,
        finish: 20.0,
        end_on_collision: false,
    }
}

/// A vehicle at constant speed.
pub fn car(name: &str, lane: usize, speed: f64, start: VehicleStart) -> VehicleSetup {
    VehicleSetup {
        name: name.into(),
        controller: controller("constant_speed", &Settings::default()),
        dynamics: dynamics_of("constant_speed"),
        length: 4.2,
        width: 1.8,
        road: 0,
        lane,
        speed,
        initial_speed: None,
        start,
        behind: 0.0,
        sees: None,
        obeys_signals: false,
    }
}

pub fn controller(name: &str, settings: &Settings) -> ModelSetup<ControllerModel> {
    let model = REGISTRY.controllers().get(name).expect("a controller").clone();
    ModelSetup::resolved(&model, settings).expect("good settings")
}

/// The dynamics that a controller drives by default.
pub fn dynamics_of(controller: &str) -> ModelSetup<DynamicsModel> {
    let model = REGISTRY.controllers().get(controller).expect("a controller").clone();
    let dynamics = model.default_dynamics.entry().expect("a registry resolved them");
    ModelSetup::resolved(dynamics, &Settings::default()).expect("defaults")
}

pub fn model(name: &str, settings: &Settings) -> ModelSetup<PedestrianModel> {
    let model = REGISTRY.pedestrians().get(name).expect("a model").clone();
    ModelSetup::resolved(&model, settings).expect("good settings")
}

/// A pedestrian at x = 0 who walks from one y to another.
pub fn walker(name: &str, model: ModelSetup<PedestrianModel>, from: f64, to: f64) -> PedestrianSetup {
    let rides = model.model.name() == "yielding_cyclist";
    PedestrianSetup {
        kind: if rides { RoadUserKind::Cyclist } else { RoadUserKind::Pedestrian },
        name: name.into(),
        model,
        shape: Shape::Rectangle { length: 0.8, width: 0.8 },
        side: if to > from { Side::Near } else { Side::Far },
        start: Position { x: 0.0, y: from },
        goal: Position { x: 0.0, y: to },
        follows: None,
        stops: Vec::new(),
        crossing: 0,
        appears: Appearance::At(0.0),
        may_go: MayGo::AtOnce,
        reference: 0.0,
        obeys_signals: false,
    }
}

/// The individual of this number, from 1, of the population that ships.
pub fn person(number: usize) -> Settings {
    static PEOPLE: LazyLock<Population> = LazyLock::new(|| {
        let model = REGISTRY.pedestrians().get("commotions").expect("a model").clone();
        Population::parse("standard", None, &model.declaration, None).expect("the population that ships")
    });
    PEOPLE.individual(1 + (number - 1) * PEOPLE.len() / 1000).expect("an individual")
}

/// How a run went.
pub struct Course {
    names: Vec<String>,
    /// Where everybody was after each step, in the order of the names.
    paths: Vec<Vec<[f64; 2]>>,
    /// Whether the first pedestrian entered lane 0 before the first vehicle came to the crossing.
    pub first: bool,
    /// When the first pedestrian's centre was 1.4 m past the middle of lane 0, out of a vehicle's way, s.
    pub across: Option<f64>,
    /// When the first vehicle came to the crossing, s.
    pub passed: Option<f64>,
    /// Contacts of vehicles and pedestrians, in the order in which they began.
    pub hits: Vec<Hit>,
    /// Whether two vehicles touched.
    pub crash: bool,
    entered: Option<f64>,
}

/// The beginning of a contact of a vehicle and a pedestrian, by their places in the world's lists.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    pub vehicle: usize,
    pub pedestrian: usize,
    /// s
    pub time: f64,
    /// Of the vehicle, m/s.
    pub speed: f64,
}

impl Course {
    /// Whether a vehicle and a pedestrian touched.
    pub fn hit(&self) -> bool {
        !self.hits.is_empty()
    }

    /// Where somebody was after each step.
    pub fn points(&self, who: &str) -> impl Iterator<Item = [f64; 2]> {
        let index = self.names.iter().position(|name| name == who).expect("a road user");
        self.paths.iter().map(move |places| places[index])
    }
}

impl Observer for Course {
    fn observe(&mut self, step: &Step) {
        let (cars, people) = (&step.after.vehicles, &step.after.pedestrians);
        let end = step.time + step.duration;
        let places = cars.iter().map(|car| car.position()).chain(people.iter().map(|person| person.position));
        self.paths.push(places.map(|place| [place.x, place.y]).collect());
        if people[0].position.y >= -2.0 {
            self.entered.get_or_insert(end);
        }
        if people[0].position.y >= 1.4 {
            self.across.get_or_insert(end);
        }
        if cars[0].motion.travelled >= -cars[0].length / 2.0 {
            self.passed.get_or_insert(end);
        }
        self.first = self.entered.is_some_and(|entered| self.passed.is_none_or(|passed| entered < passed));
        for touch in step.contacts.iter().filter(|touch| touch.begins) {
            match (touch.first, touch.second) {
                (Solid::Vehicle(vehicle), Solid::Pedestrian(pedestrian)) => {
                    let speeds = [step.before, step.after].map(|state| state.vehicles[vehicle].motion.speed);
                    let speed = speeds[0] + (speeds[1] - speeds[0]) * touch.moment / step.duration;
                    self.hits.push(Hit { vehicle, pedestrian, time: step.time + touch.moment, speed });
                }
                (Solid::Vehicle(_), Solid::Vehicle(_)) => self.crash = true,
                _ => {}
            }
        }
    }
}

/// Runs `world` with its own road users.
pub fn run(world: &World, seed: u64) -> Course {
    run_with(world, road_users(world, seed).expect("road users"))
}

/// Runs `world` with vehicles that give way to the pedestrian, each at its own place in the queue.
pub fn run_before_giving_way(world: &World, seed: u64) -> Course {
    let mut users = road_users(world, seed).expect("road users");
    for (place, driven) in users.vehicles.iter_mut().enumerate() {
        driven.driver = Driver::Inside(Box::new(GivesWay { stops_at: 6.0 + 7.0 * place as f64 }));
        driven.perception = None;
    }
    run_with(world, users)
}

fn run_with(world: &World, users: RoadUsers) -> Course {
    let names = world.vehicles.iter().map(|car| car.name.clone());
    let mut course = Course {
        names: names.chain(world.pedestrians.iter().map(|person| person.name.clone())).collect(),
        paths: Vec::new(),
        first: false,
        across: None,
        passed: None,
        hits: Vec::new(),
        crash: false,
        entered: None,
    };
    simulate(&Arc::new(world.clone()), users, &mut course).expect("controllers that can decide");
    course
}

/// Stops so many metres before the crossing while anybody has yet to leave its lane, and then goes on.
struct GivesWay {
    stops_at: f64,
}

impl Controller for GivesWay {
    fn schedule(&self) -> Schedule {
        Schedule::every(0.025)
    }

    fn act(&mut self, seen: &Observation) -> Result<Command, ControllerError> {
        let waits = seen.pedestrians.iter().any(|person| person.position.y < 2.0);
        let left = seen.ego.distance_to_crossing - self.stops_at;
        let needed = if left > 0.0 { seen.ego.speed * seen.ego.speed / (2.0 * left) } else { 5.0 };
        Ok(Command::Acceleration(if waits && needed >= 2.0 {
            -needed.min(5.0)
        } else if !waits && seen.ego.speed < seen.cruise_speed {
            1.5
        } else {
            0.0
        }))
    }
}
