//! Every code that a diagnostic may carry, with its title and what `explain` says.

use std::borrow::Cow;
use std::fmt;

use super::units;

/// How much a finding matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// Nothing can be run until it is gone.
    Error,
    /// It can be run, though it may not be what was meant.
    Warning,
}

macro_rules! codes {
    ($($name:ident = $code:literal, $title:literal, $explanation:expr;)*) => {
        /// What a diagnostic is about. Codes beginning with `W` are warnings.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Code { $(#[doc = $title] $name),* }

        impl Code {
            /// Every code there is, in order.
            pub const ALL: &[Code] = &[$(Code::$name),*];

            /// Such as `E0101`.
            pub fn name(self) -> &'static str {
                match self { $(Self::$name => $code),* }
            }

            /// What it is, in a few words.
            pub fn title(self) -> &'static str {
                match self { $(Self::$name => $title),* }
            }

            /// What it means, why it is an error and how to get rid of it.
            pub fn explanation(self) -> Cow<'static, str> {
                match self { $(Self::$name => Cow::from($explanation)),* }
            }
        }
    };
}

impl Code {
    /// Whether it keeps a suite from running; the name says it.
    pub fn severity(self) -> Severity {
        if self.name().starts_with('W') { Severity::Warning } else { Severity::Error }
    }

    /// The code of that name, such as `E0101` or `e0101`.
    pub fn find(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|code| code.name().eq_ignore_ascii_case(name))
    }
}

impl fmt::Display for Code {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.name())
    }
}

codes! {
    // Syntax
    UnclosedBracket = "E0101", "a bracket is never closed",
        "Every `{`, `[` and `(` needs its partner. Where a brace is missing, indentation tells which block it belongs to, and the \
         rest of the file is checked as if it stood there; otherwise nothing else in the file is checked until brackets match, \
         because every later message could be wrong.";
    MismatchedBracket = "E0102", "a bracket is closed by another kind",
        "`{` is closed by `}`, `[` by `]` and `(` by `)`, the one opened last first.";
    UnopenedBracket = "E0103", "a closing bracket without an opening one",
        "There is one closing bracket more than was opened. Often the real mistake is one `}` too many further up.";
    UnclosedString = "E0104", "a text has no closing quote",
        "Texts stand between two `\"` in one line. Inside, `\\\"` is a quote and `\\\\` a backslash.";
    NestedTooDeeply = "E0105", "brackets are nested too deeply",
        "Brackets may be nested 64 deep. No scenario needs that many; give parts of a long expression a name with \
         `let`.";
    UnexpectedText = "E0106", "a statement does not read as expected",
        "The statement begins with a known word, but then something else follows than the language knows. The message \
         lists what could stand at that place. A statement ends with its line or with `;`; lists and brackets may \
         span lines.";
    UnknownStatement = "E0107", "no statement begins like this",
        "Every statement of a block begins with one of the words that the block knows, such as `speed` in a `vehicle`.";
    MisplacedStatement = "E0108", "a statement stands in the wrong block",
        "The word is known, but belongs into another block: `speed` into a `vehicle`, `start … from kerb` into a \
         `pedestrian`, `pet >= 1.5 s` into `expect`.";
    BadSetting = "E0109", "a setting does not read as `name: value`",
        "Settings stand in braces after the name of what they set: `controller carla_behavior { profile: normal, \
         braking_distance: 5 m }`. Between them stand commas or line ends.";
    BadYaml = "E0110", "a YAML file cannot be read",
        "The file is not YAML, or uses what scenario files do without: anchors, aliases, tags, several documents, \
         the same key twice.";
    WrongShape = "E0111", "a YAML value has the wrong shape",
        "Quantities, criteria and conditions are written as in a scenario file, as one text: `speed: 30 km/h`. Road users \
         and settings are made of keys, several values are a list.";
    UnknownKey = "E0112", "a YAML key is not known here",
        "Keys are the words that begin statements in a scenario file; what may stand several times has a plural, such as \
         `vehicles`.";
    // Files
    UnreadableFile = "E0201", "a file cannot be read",
        "The file does not exist, is a folder, or may not be read. Paths in `use` and `scenarios` are relative to the \
         file they stand in.";
    NotUtf8 = "E0202", "a file is not UTF-8 text",
        "Scenario files are UTF-8. The message says at which byte the text stops being UTF-8. Save the file with that \
         encoding.";
    CircularUse = "E0203", "files use each other in a circle",
        "A file that is used may not, directly or over others, use the file that uses it. Put what both need into a \
         third file.";
    FileTooLarge = "E0204", "a file is too large",
        "Files may have 16 MiB. Split the file; a suite collects scenarios from many files by a pattern.";
    UnknownFileKind = "E0205", "a file's name does not say what it is",
        "Scenario files end in `.scn` or `.yaml`, suites in `.suite`. No other file is opened by `use` or `scenarios`, and \
         none that a link under such a name leads to: a project from somebody else is not to read whatever it likes.";
    NothingMatches = "E0206", "a pattern matches no file",
        "A pattern under `scenarios` must match at least one file, otherwise a suite would silently test nothing. \
         Patterns are relative to the suite's file; `*` matches within a folder, `**` over folders.";
    BadPattern = "E0207", "a file pattern is malformed",
        "Patterns know `*`, `**`, `?` and `[abc]`.";
    TooManyFiles = "E0208", "a suite is made of too many files",
        "A suite may be made of 20,000 files. A pattern such as `/**/*` that matches more is taken for a mistake.";
    Backslash = "E0209", "a backslash in the name of a file, or in a command",
        "Folders are separated by `/` everywhere, and by backslashes on Windows alone, where they are taken as they are. On other systems \
         a backslash is part of a name, or changes the letter behind it. In the words of a \
         command behind the first, `\\\\` is a backslash.";
    // Names
    DuplicateName = "E0301", "a name is defined twice",
        "Within a file and everything it uses, a name may be defined once for each kind of thing; within a scenario, \
         road users, variations and `let` names must differ.";
    UnknownName = "E0302", "a name is not defined",
        "Names in values come from `let`, from the variations of the scenario, or from a template's parameters. A \
         `let` only knows names above it.";
    UnknownRoad = "E0303", "a road is not defined",
        "`road NAME` in a scenario refers to a `road NAME { … }` of the same file or of one it uses.";
    UnknownController = "E0304", "there is no such controller",
        "`scenario-runner models` lists every controller.";
    UnknownDynamics = "E0305", "there are no such vehicle dynamics",
        "`scenario-runner models` lists all vehicle dynamics.";
    UnknownModel = "E0306", "there is no such pedestrian model",
        "`scenario-runner models` lists every pedestrian model.";
    UnknownParameter = "E0307", "there is no such parameter",
        "`scenario-runner models NAME` lists the parameters of a model, controller or metric with units, ranges and \
         defaults.";
    UnknownOption = "E0308", "a parameter has no such option",
        "The parameter takes one of a few words. `scenario-runner models NAME` says what each means.";
    UnknownVehicle = "E0309", "the scenario has no such vehicle",
        "A vehicle is referred to by the name after `vehicle`.";
    UnknownPedestrian = "E0310", "the scenario has no such pedestrian",
        "A pedestrian is referred to by the name after `pedestrian`.";
    UnknownMetric = "E0311", "there is no such metric",
        "`scenario-runner models` lists every metric. A criterion over a metric that does not exist would never be \
         checked, so it is an error.";
    UnknownSolid = "E0530", "there is nothing of this name that a vehicle could touch",
        "`collision(av, walker)` is about one vehicle and one pedestrian, one other vehicle or one box of the road, by the \
         names after `pedestrian`, `vehicle`, `box` or `parked`. `collision(av)` is about whatever it touches.";
    TouchesItself = "E0531", "a vehicle is asked to touch itself",
        "A collision is between a vehicle and something else: a pedestrian, another vehicle or a box of the road.";
    UnknownVariation = "E0312", "the scenario does not vary this",
        "`when` restricts a criterion to some values of a variation, which must be declared by `vary`. A scenario that varies \
         a name anew replaces the whole `vary together` that it stood in, so that the other names need values again.";
    DuplicateScenario = "E0313", "two scenarios of a suite have one name",
        "A scenario's name is part of the key that names its runs in every report and seeds them, so it must be unique \
         in a suite, over all its files.";
    UnknownTemplate = "E0314", "there is no such scenario or template to build on",
        "`scenario late : base { … }` builds on a `scenario base` or `define base(…)` of the same file or of one it \
         uses.";
    // Values
    UnknownUnit = "E0401", "a unit is not known",
        format!("Units are {}. To divide by a name, put spaces around `/`.", units::listed());
    WrongDimension = "E0402", "a quantity has the wrong dimension",
        "Each place wants a certain kind of quantity, such as a length. Another unit of the same kind is converted: \
         `30 km/h` and `8.333 m/s` are the same. A unit of another kind is an error.";
    MissingUnit = "E0403", "a number needs a unit",
        "A number without unit could mean km/h or m/s, so the unit is never guessed.";
    WrongType = "E0404", "a value is of the wrong type",
        "A number, a truth value (`true`, `false`) and a word are different things; each place takes one of them.";
    OutOfRange = "E0405", "a value is out of its range",
        "The range is declared together with the parameter; outside of it the model makes no sense or was never \
         tested.";
    NotWhole = "E0406", "a whole number is needed",
        "Counts are whole numbers without unit.";
    MixedDimensions = "E0407", "quantities of different kinds are added",
        "Only quantities of the same kind can be added, subtracted and compared: a length to a length.";
    NotConstant = "E0408", "a value may not vary here",
        "This place needs one value for all runs, so it may use `let` names but no variations.";
    NotFinite = "E0409", "the result of a calculation is not a number",
        "A division by zero or an overflow.";
    TooLong = "E0410", "a calculation is too long",
        "A calculation over variations may have 1000 parts, names replaced by what they stand for.";
    NumberTooLarge = "E0411", "a number is too large",
        "Counts have at most 32 bits, seeds at most 64.";
    // Scenarios
    MissingStatement = "E0501", "something is missing",
        "Some things have no sensible default and must be said: a scenario's road, a vehicle's controller and speed, a \
         pedestrian's model and start.";
    RepeatedStatement = "E0502", "something is said twice",
        "A statement that may stand only once in its block stands there again. In a scenario that builds on another, \
         saying something again replaces it, but each scenario may still say it only once.";
    EmptyList = "E0503", "a list has no values",
        "A variation over no values would mean no run at all.";
    StartContradiction = "E0504", "two statements about a start contradict each other",
        "`start 4 m from lane centre, 2 m from kerb` says the same place twice and is checked against the road: the \
         distance between lane centre and kerb is half the lane width.";
    NoSuchLane = "E0505", "the road has no such lane",
        "Lanes are counted from 0, beginning at the near side.";
    NoStart = "E0506", "nothing says where a vehicle starts",
        "A vehicle starts at `start 80 m before crossing`, `start 6 s before crossing`, or as far out as a pedestrian \
         that `appears when time_to_arrival(vehicle) = …` needs it.";
    NobodyThere = "E0507", "a scenario has nobody in it",
        "A scenario needs at least one vehicle and one pedestrian, or two vehicles of which one says `on` which other road it drives.";
    UnequalLists = "E0508", "lists that belong together differ in length",
        "`vary together` takes the first value of each list together, then the second, and so on.";
    RepeatedValue = "E0509", "a variation lists a value twice",
        "Every run has a name made of the values of its variations, so each value may be listed once. More runs of the \
         same are made by `repeat`.";
    DoesNotFit = "E0510", "controller and dynamics do not fit",
        "Some controllers give pedals, others an acceleration, and dynamics take one or the other.";
    NoIndividuals = "E0511", "a model knows no individuals",
        "Only models that were fitted to single people have a population to take individuals from.";
    StartBeyondGoal = "E0512", "a pedestrian starts beyond its goal",
        "A pedestrian from the near side starts on the near side of its goal.";
    TooManyValues = "E0513", "a variation has too many values",
        "A variation may have 1,000,000 values.";
    BadDistribution = "E0514", "a distribution cannot be drawn from",
        "`uniform(low, high)` needs low < high, `normal(mean, sd)` sd > 0, `truncated_normal(mean, sd, low, high)` \
         both, `choice(a, b, …)` at least one value. All arguments are constants of one dimension.";
    BadArgument = "E0515", "a template is called with wrong arguments",
        "Every parameter without default needs an argument, by name: `scenario a : base(delay: 2 s)`.";
    CircularTemplate = "E0516", "scenarios build on each other in a circle",
        "A scenario cannot build on itself, directly or over others.";
    BadText = "E0517", "a model does not understand a text",
        "Some parameters are texts in a small language of the model: the steps of `timeline`, the variant of \
         `commotions`. `scenario-runner models NAME` says what the text is made of.";
    CannotBePlanned = "E0518", "a scenario cannot be planned",
        "What single statements say is fine, but the runs that they ask for together cannot be made: a population does not \
         have the individuals, a value that is calculated from several variations leaves its range, there are more runs than \
         anybody would wait for.";
    CannotBeBuilt = "E0519", "a model cannot be what a scenario asks of it",
        "Every setting by itself is fine, but the model refuses them together or does not fit the scenario: a time step that \
         is no multiple of the simulation's, a lower limit above the upper one, a controller for one lane on a road with two.";
    BadEach = "E0526", "`each(…)` does not fit its group",
        "`pedestrian walkers times 3 { along each(0 m, 0.7 m, 1.4 m) }` gives the first of the three the first value, and so \
         on: there are as many values as members, and `each` stands nowhere else.";
    BadGroup = "E0527", "a group of pedestrians is not one",
        "`pedestrian walkers times 5 { … }` describes 2 to 100 people, called `walkers_1` to `walkers_5`: nobody else in \
         the scenario is called like that.";
    WrongWay = "E0528", "what is said of a way does not go together",
        "Somebody walks across the road, to `goal 2 m beyond kerb`, or along the lane that is outermost on its side, `walks with traffic` \
         or `walks against traffic`, to `goal 40 m further`. Across the road `meets` finds its own place; along it, `after` says which, \
         and how far beside the lane's centre it walks follows from the share of the vehicle's width.";
    BadMedian = "E0529", "a median cannot lie there",
        "`median 2 m after lane 0` is a strip between lane 0 and lane 1, at most as wide as all lanes together; between two lanes \
         there is one. `with refuge` lets people wait on it who say `waits on refuge`.";
    UnknownCrossing = "E0532", "the road has no such crossing",
        "`crosses school` names a crossing that the road calls so: `crossing school zebra { at: 40 m }`. The first crossing of a road has \
         no name: who says nothing uses that.";
    NoRefuge = "E0533", "somebody is to wait on a refuge and cannot",
        "`waits on refuge` needs a refuge on the way, `median 2 m after lane 0 with refuge`, and a model that walks leg by leg: on \
         each it minds only whom it meets before the next refuge.";
    BadJunction = "E0534", "a road cannot lie over another like that",
        "`over main { at: 20 m, angle: 90 deg }` lays a road over the road `main`, which a scenario chooses; its vehicles drive there \
         with `on side` and `start 40 m before junction`. Crossings, boxes and people are said of the road below, which may not lie \
         over another itself.";
    WrongRoad = "E0535", "a vehicle cannot drive on that road",
        "A vehicle drives on the road of its scenario, or says `on side` where the road `side` lies `over` that one. On the first places \
         are counted `before crossing`, on the other `before junction`, which is where the two roads meet.";
    NoSingleOrder = "E0537", "who of a stream and a pedestrian goes first has no answer",
        "Of many vehicles some pass before a pedestrian and some after: `gap_accepted` of all of them is never true, and the smallest `pet` is \
         that of a vehicle that nobody named. In a scenario with a stream say which gap is meant, `gap_taken(cars, walker) >= 3 s`, or which \
         vehicle, `pet(cars_3, walker) >= 1.5 s`. The smallest time of all may be asked for by the name of the stream: `pet(cars, walker)`.";
    BadDraw = "E0540", "a file cannot be drawn from",
        "`draw together from \"exposure.csv\"` draws a row in every run. The header names the columns, with units in square brackets: `tta \
         [s],speed [km/h],weight`. A row is as likely as its weight is of the sum of all weights, all equally without that column; weights \
         are at least 0 and not all of them 0. `without id, date` leaves columns out, whose cells may be anything. `draw tta from \
         \"gaps.csv\"` takes one column.";
    IdleDraw = "E0541", "a draw that changes nothing",
        "What is drawn in every run and used nowhere makes no run another one, though it looks as if chance were at work, and claims with a \
         confidence rest on that. Use it in a value of a road user, or leave it out. A column of `draw together` that nothing uses may be \
         another name than was meant, such as `Weight` for `weight`: `draw together from \"x.csv\" without id, date` names those that are \
         meant to be left out.";
    NoRoomToWait = "E0536", "a pedestrian starts where it cannot wait",
        "`commotions` waits no nearer than `D_s` to where its body and that of a vehicle can meet: half of both bodies and `D_s` from the \
         centre of the lane, 2.15 m for a disc of 0.25 m, a car 1.8 m wide and 1 m. Nearer it has only one option, to go first, and is hit \
         where that fails: a car that is 1 s away hits 281 of 300 `humans` that start 2 m from the centre of its lane. Let it start farther away, \
         declare a smaller `D_s`, or say `may start inside` if that is what the scenario is about.";
    BadStream = "E0538", "a stream of vehicles is not one",
        "`stream cars { lane 0; speed 30 km/h; controller constant_speed; first 2 s before crossing; gaps 3 s, 4 s, then 2.5 s }` is vehicles \
         that come one after the other, called `cars_1`, `cars_2` and so on: nobody else in the scenario is called like that. A gap is the \
         time from front to front, longer than a vehicle takes to drive its own length. Up to the horizon there are at most 200. \
         `stream far { repeats cars, 1.5 s later; lane 1 }` is another one with the same gaps.";
    UnmeantModel = "E0525", "a number with one published value is varied",
        "Some numbers of a model are no free choice. The noise and the filters of `commotions` are per time step, so that with \
         another `dt` than the published one (25 ms for variants with noise, 100 ms for those without) it is another model, \
         which nobody fitted to people: collisions were seen to go from 0 % to 29 % in one scenario. A variation, search, tune \
         or condition over it is refused, unless the settings of the model say `another_model: true`.";
    UnknownSetting = "E0550", "nothing has the name that is to be set",
        "`--set NAME=VALUE` sets what files give a name: a variation (`tta=4s`), a `let`, a template's parameter, a statement \
         about a road user (`av.speed=40km/h`, `walker.along=1m`), a parameter of what drives or walks \
         (`av.controller.braking_distance=5m`), or `step`, `horizon`, `finish`, `seed` and `repeat` of scenarios.";
    // Criteria
    NoNumber = "E0601", "an aggregate needs a quantity",
        "Means and quantiles exist of quantities. Of truth values and words, take the `rate(…)` or `count(…)`.";
    MissingComparison = "E0602", "a criterion compares nothing",
        "A quantity must be compared to a bound: `pet >= 1.5 s`. Only truth values stand alone: `gap_accepted`, \
         `no collision`.";
    BadNo = "E0603", "`no` before something that is not true or false",
        "`no` takes a metric that is true or false, such as `collision`.";
    BadShare = "E0604", "a share is not between 0 and 1",
        "Shares and quantile levels lie between 0 % and 100 %, confidences above 50 %: at 50 % a claim that is false passes as \
         often as not.";
    RepeatedModifier = "E0605", "a criterion says something twice",
        "`in … of runs`, `undefined …`, `with … confidence`, `of … people` and `when` may each stand once.";
    BadModifier = "E0606", "a part of a criterion has no meaning here",
        "`in 80 % of runs` belongs to a comparison of every single run, not to an aggregate over runs; a confidence \
         needs a share or an aggregate, because a claim about every run is either true or false. Counts and \
         extremes are of the runs that were done, no number of runs shows that two numbers are equal, and no bounds on a \
         spread hold whatever the metric: they take no confidence either.";
    UnknownWord = "E0607", "a metric never has this value",
        "A metric with words as values can only be compared to one of them.";
    NoOrder = "E0608", "words and truth values have no order",
        "Compare them with `=` or `!=`.";
    BadPair = "E0609", "a metric is not measured for these",
        "Write `pet(av, walker)` for one vehicle and one pedestrian; metrics of one vehicle or pedestrian take that one \
         name.";
    NeverApplies = "E0610", "a criterion never applies",
        "The condition after `when` holds for no run, so the criterion would pass without being checked.";
    TooFewRuns = "E0611", "a criterion that its runs can never show",
        "A criterion with stated confidence passes only if luck would seldom let it pass if it were false. Even if every run \
         goes well, that takes a number of runs: 95 % of runs at 95 % confidence need 59, 99 % need 299, 99.9 % need 2995, \
         and the 95 % quantile needs 59 for an upper bound. A mean needs the more, the closer its bound is to an end of what its \
         metric can be: one run in a thousand that takes a minute moves the mean by 60 ms. With fewer the criterion could only be inconclusive or fail. \
         Say `repeat` (or a larger second number after `runs`) for more runs, or claim less. Where runs are added until \
         the criteria are decided it takes more, because one looks often: 88, 449 and 4512 for those shares. That all runs hold, or that a share is exactly so large, no number of \
         runs shows.";
    NotSequential = "E0612", "a mean without limits cannot be decided while runs are added",
        "With `runs 50 .. 2000` the runs are looked at again and again until the criteria are decided. An ordinary \
         interval looked at often enough is wrong sooner or later, so bounds are used that hold however often one looks. \
         For shares, rates, medians and quantiles there are such bounds, and for means of metrics with limits, such as times \
         within the run (`scenario-runner models NAME` says which); for means of others and for spreads there are none. Fix \
         the number of runs with `repeat`, or claim something of a median or quantile.";
    WithoutChance = "E0613", "a confidence where nothing is left to chance",
        "A confidence says how seldom chance alone would let a claim pass that is false. Where no model, controller or \
         perception draws anything, every run of a trial is the same bit for bit, and a thousand of them say no more than \
         one. Leave out the confidence (and `repeat`), or vary what may differ between runs: a model of a pedestrian who \
         decides by chance, noise in `sees`, or people taken from a population.";
    BadPeople = "E0614", "a criterion speaks of people who are not there",
        "`of these people` says that a confidence is about the people who walk in the runs, `of all people` that it is about \
         everybody in the population whom they were taken from: then each person counts once, however many runs it has. Both \
         need `individuals` in the scenario and a confidence; `of all people` needs several people and their number to be \
         fixed: runs that are added (`runs 50 .. 2000`) are of the same people.";
    NeverHolds = "E0615", "a criterion that can never pass",
        "No value that its metric can have is what the criterion claims, such as `drac > 30 m/s^2` with the ceiling of 20 m/s^2, \
         `stopped_time > 90 s` in runs of 60 s, or a count of more runs than there are. `scenario-runner models NAME` says between \
         which limits a metric lies.";
    // Suites
    EmptySuite = "E0701", "a suite has no scenarios",
        "A suite without scenarios would pass without testing anything.";
    MisplacedSuite = "E0702", "a suite in a scenario file",
        "Suites stand in files ending in `.suite`.";
    MissingSuite = "E0703", "a suite file without suite",
        "A `.suite` file holds exactly one `suite NAME { … }`.";
    SeveralSuites = "E0704", "a suite file with several suites",
        "A `.suite` file holds exactly one `suite NAME { … }`.";
    NoScenario = "E0705", "a file without scenarios",
        "A file that is run, or matched by a suite's pattern, must hold at least one scenario. Files with only roads \
         and templates are for `use`.";
    // Search, tune and gates
    UnknownScenario = "E0801", "a block is about a scenario that is not there",
        "`in NAME`, `on NAME` and `of NAME` refer to a scenario of the same suite, or of the same file when a scenario file is \
         run by itself; `on` and `of` may also name a search of it.";
    BadTarget = "E0802", "there is nothing to search over",
        "`over` takes a variation of the scenario, such as `tta`, or a parameter of a road user, such as \
         `av.controller.braking_distance` or `walker.model.speed`.";
    BadRange = "E0803", "a range cannot be searched",
        "Numbers are searched between two bounds, `4 m .. 25 m`, the lower one first; with `logarithmic` both are positive. \
         Words are listed: `[cautious, normal]`.";
    BadBudget = "E0804", "a budget makes no sense",
        "The evaluations that come first are part of all evaluations, so there are at most as many.";
    BadObjective = "E0805", "nothing to minimise or maximise",
        "An objective is an aggregate over runs, such as `minimise min(pet)`; a metric alone means its mean, and one that is \
         true or false its rate. A search has one objective, a tune one or two.";
    BadGate = "E0806", "a gate compares nothing",
        "A gate names a baseline file and says at least once what may not get worse: \
         `gate braking { baseline \"zebra.json\"; no metric worse by more than 5 % with 95 % confidence }`. A metric whose \
         values are words, such as `passed_first`, has no better or worse.";
    UnknownBlock = "E0807", "there is no such search, tune or evaluate",
        "Blocks refer to each other by name: a tune to the search whose cases it takes, an evaluate to the tunes that it \
         compares, a statement to what it measures.";
    UnknownCondition = "E0808", "an evaluate has no such condition",
        "The conditions of an evaluate are named after `with`: `default`, the name of a tune, or what `as` says. A statement \
         measures one of them: `mean(pet) of final.default`.";
    BadCondition = "E0809", "a condition cannot be evaluated",
        "Conditions have names of their own. A file and parameters in place need one: `{ av.controller.braking_distance: \
         10 m } as ten`. Every parameter that a condition sets must be there in the scenario whose cases are run.";
    BadReported = "E0810", "reported numbers do not fit the table",
        "A reported row has a value for each measure, in the same order and of the same dimension: `measure mean(pet), \
         rate(collision)` and `reported default: 2.5 s, 3 %`.";
    BadClaim = "E0811", "a claim cannot be held against results",
        "A claim compares what is measured: `mean(pet) of low_pet < 1.5 s`. What is true of a value in every run is no claim \
         until it is summed up over named runs. Where a `when` stands in a calculation, brackets say what belongs to it.";
    BadStatement = "E0812", "it is not clear what is known about a statement",
        "A statement is expected to be reproduced, `differs \"why\"` if it is known not to be, or is `not comparable \"why\"`; \
         not two of them. Only the last may go without a `claim`.";
    BadFallback = "E0813", "there are no violations to count",
        "`otherwise fewest violations` takes, where no candidate keeps every constraint, the one that breaks them in the \
         fewest runs. That takes constraints (`subject to`), and every run of every candidate (no `stop early`).";
    BadRating = "E0814", "a rating cannot be worked out",
        "A rating says what is measured, what values are worth and which tags earn points: `rating r { measure impact_speed; \
         weights { 0 km/h: 1, below 10 km/h: 0.5 }; points crossing 2 }`. A tag earns points once and a scenario has one such \
         tag, so that no cell counts twice. The worst run of a cell counts, so cells have a fixed number of runs. A bound on \
         points must be one that some points keep and others do not.";
    BadWeights = "E0815", "a rating's weights leave something open",
        "Of every cell exactly one table of weights speaks: a cell without one would have no points, one with two would have \
         either. `when` is about what scenarios vary, by lists of values. In a table a value falls to the first line that it \
         satisfies, so a line behind one with all of its values never counts. Bounds are `below`, `at most`, `above` and `at \
         least`; a value alone is 0, which a run without contact has.";
    NoSuchTag = "E0816", "a rating earns points by a tag that nothing has",
        "Points are earned by the cells of scenarios with a tag: `tags cpna` in the scenario, `points cpna 1` in the rating. \
         Without a scenario that has it there would be nothing to earn them.";
    BadObservations = "E0817", "what people did cannot be matched",
        "A `calibrate` block reads a CSV of what people did, a condition a row: `scenario`, what the scenario varies, `share`, `trials`, \
         `persons`, and how many persons did so in 0, 1, … of their trials, or `error`, `pair_share` and `pair_error` where persons had different \
         numbers of trials. Every row is about a condition of one of its scenarios, shares are between 0 and 1 and those of the counts. \
         docs/populations.md has an example.";
    BadCandidates = "E0818", "nobody can be weighed",
        "A `calibrate` block weighs candidates: there are more of them than targets, of a model that takes individuals, and every scenario \
         has one pedestrian who they can be. Every condition is a value that a variation lists. `match mean of` and `match deviation of` take a \
         quantity among the parameters of that pedestrian's model, such as `walker.model.ped_free_speed`.";
    BadExpectation = "E0819", "a search expects what no single run can fulfil",
        "`expect { pet >= 1.5 s }` of a search judges each run that it keeps by itself, since a run was found because it is bad: a share, a mean or a \
         confidence over such runs says nothing of any others. How often it happens with other seeds stands beside it.";
    BadTry = "E0820", "a tune cannot try this",
        "`try { braking_distance: 8 m }` sets parameters that the tune is `over`, to values in their ranges. What it leaves out is as declared. \
         Where parameters of several road users have one name, write the whole: `av.controller.braking_distance`.";
    BadEstimate = "E0830", "a probability cannot be estimated",
        "An `estimate` block is of a scenario that draws what differs from run to run, as one trial: without `vary`, and with people who are \
         `drawn from` a population or one of it. Its score is a quantity that gets worse towards the event, such as `score pet`. \
         What it is compared with draws the same from the same, and has the same `seed`, as a scenario that builds on it and says a controller anew; \
         only then claims may be about a `difference` or a `ratio`. docs/chance.md says what its numbers mean.";
    BudgetTooSmall = "E0831", "a claim or method needs more runs than the budget has",
        "Without assumptions nothing is shown by fewer runs than about 3 / p, whatever comes of them: `claim guaranteed <= 1e-5` at 95 % needs \
         299,572 runs that are drawn as they are, of which `by importance` makes one in ten. A plain `claim` is decided by the estimate, \
         which needs fewer and says on what assumption.";
    BadExposure = "E0833", "nothing says how many encounters there are",
        "`exposure 3 .. 12 encounters per 1000 km source \"…\"` turns a probability per encounter into events per 1,000 km. How many encounters \
         there are depends on where and when the system drives: nobody else knows it, there is no default, and a number without its source \
         cannot be checked by anybody. A range says how uncertain it is. docs/chance.md has an example.";
    NothingDeclared = "E0832", "nothing says how usual an encounter is",
        "`keep plausibility >= 5 %` keeps encounters that are no rarer than 1 in 20, as the scenario draws them. So the scenario says how all \
         that the search chooses of them is distributed: by `draw x from DISTRIBUTION`, and of people by a population. What a variation \
         lists has no distribution. docs/chance.md says what a plausibility means.";
    // Filter expressions
    UnknownPredicate = "E1001", "a filter has no such predicate",
        "`scenario-runner help filter` lists the predicates of filter expressions.";
    BadFilter = "E1002", "a filter does not read as expected",
        "A filter is made of predicates such as `scenario(zebra)`, joined by `&` (both), `|` (either) and `-` (the first \
         without the second), each perhaps after `!` (not), with round brackets where needed. The shell wants the whole \
         in single quotes: `-E 'tag(paper) & !model(jaywalker)'`.";
    BadFilterPattern = "E1003", "what stands in the brackets of a predicate is malformed",
        "A pattern is text, or text after a mark: `=` the whole name, `~` a part of it, `#` a glob with `*` and `?`; or a \
         regular expression between two `/`. `variation` takes a name with a value: `variation(tta >= 10 s)`.";
    // Controllers of one's own
    NoProgram = "E1101", "a controller has no program that could be started",
        "`controller NAME { … }` of a file declares a program that decides: `command \"python3\", \"my_av.py\"` says which, each \
         word in quotes of its own and read by no shell, `wasm \"brakes.wasm\"` a WebAssembly module, or `fmu \"aeb.fmu\"` a functional \
         mock-up unit, and `environment \"NAME=VALUE\"` what it finds there.";
    TwoPrograms = "E1102", "a controller has two programs",
        "A controller is decided for by one program: a `command`, which is a process, a `wasm` module or an `fmu`. Declare two controllers \
         to compare two programs.";
    BuiltInName = "E1103", "a controller is called like one that ships",
        "The name of a controller is how scenarios, reports and baselines tell it. `scenario-runner models` lists those that \
         ship; a declared one needs another name.";
    WrongParameter = "E1104", "a parameter of a controller is declared wrongly",
        "A parameter has a default, and with it a kind: a number with unit and range (`= 5 m in 1 m .. 30 m`, `= 20 in whole \
         5 .. 80`), a word with its options (`= normal in [cautious, normal]`), `true` or `false`, or a text in quotes. The \
         default lies in the range, which `check` holds settings against and `tune` searches.";
    NotAllowed = "E1105", "a program may not be run yet",
        "Scenario files may name programs, but none is run before its user has allowed that: files from others must not \
         execute anything by being run. Read what would run, then `scenario-runner allow FILE`, once for each declaration and \
         again when its command, folder or environment changes; or `--allow-run=NAME` for this time, or \
         `SCENARIO_RUNNER_ALLOW_RUN=NAME` where nobody is asked. Allowing a program allows everything that it does.";
    CannotStart = "E1106", "a program cannot be started",
        "The first word of `command` is looked up on PATH, or relative to `folder` if it contains a separator. It must be a file \
         that may be executed, and the folder must be there.";
    NoHello = "E1107", "a program does not say hello",
        "A program reads a line of JSON that begins with `{\"hello\"` and answers with one, in the time that `starts within` says; \
         what it prints before is taken for log. docs/under_test.md describes the protocol, and `scenario-runner try` tells \
         step by step what a program does.";
    Disagreement = "E1108", "file and program disagree",
        "A program may say in its hello what it gives and which parameters it has. Then every parameter that the file declares \
         must be among them, of the same kind and dimension, with a range that the program's own contains.";
    NotWired = "E1110", "an FMU's variable cannot be wired",
        "`input SIGNAL = \"VARIABLE\" in UNIT` and `output …` of a controller with `fmu` say which of its variables are told what the \
         vehicle sees, and which say what it is to do; `as \"VARIABLE\" in UNIT` of a parameter which one it sets. The variable must be \
         there, of that causality, and in a unit that file or FMU names: where both do, it must be the same. Every input of the FMU \
         needs a signal, or a start value of its own. docs/under_test.md lists the signals.";
    NotTested = "E1111", "a controller cannot be put in the place of another",
        "`test my_av as av` in a suite, and `--controller av=my_av`, put a controller in the place of that of every vehicle \
         called `av`. There must be such a vehicle, or nothing would be tested: in each scenario of a suite, unless that says \
         `test my_av as av where present`, and in one of those that the command line names. It is said once for each name; settings stand \
         with the new controller and not in `--set`; and no variation may choose the controller that is replaced, whose values \
         stand in the names of trials.";
    // Warnings
    PartlyTested = "W1103", "a scenario is run without the controller under test",
        "`--controller av=my_av` is about vehicles called `av`. A scenario without one is run with the controllers that it names \
         itself, and what comes of it says nothing of `my_av`. In a suite `test my_av as av` is refused there (E1111), and \
         `test my_av as av where present` says that it is known. Every report says in how many scenarios it is tested.";
    KnowsMore = "W1101", "a program knows more than the file",
        "The program says that it has parameters that the file does not declare. They keep whatever value the program gives \
         them; declare them to set, vary or tune them.";
    Undeterministic = "W1102", "a controller is not deterministic",
        "The same run, asked of another process of the same program, came out differently. Then a failing run may not be seen \
         again, and a difference between two versions may be chance. Usual causes: the time of day, an unseeded random number, \
         an order of threads or of a hash table. Seed by the `seed` of each run and read `time` from the request; \
         `nondeterministic` in the declaration says that it is known.";
    IdlePredicate = "W1001", "a part of a filter matches nothing",
        "No trial of what is loaded is what this predicate asks for. Perhaps a name is misspelt, or a file is missing on \
         the command line.";
    UnusedName = "W0901", "a name is never used",
        "A `let` inside a scenario or a variation that no value refers to has no effect, except that a variation \
         repeats the runs. Perhaps another name was meant.";
    BlockedLane = "W0925", "a box stands in a vehicle's lane",
        "The vehicle cannot pass: it stops, or runs into the box. Where that is what the scenario is about, say so with a \
         criterion that names the box, such as `no collision(av, van)`, or with `tags blocked_lane`.";
    BlindController = "W0926", "a controller does not look at what is there",
        "Each controller declares what it looks at: people who cross, people who walk along its lane, vehicles ahead in it, signals, and vehicles \
         of other roads. Where something of that is in its way and it looks elsewhere, the run says nothing of a driver who \
         looks. Take a controller that looks at it, or say `ignores vehicles` in the vehicle's block if that is what the scenario is about. \
         Vehicles of other roads are warned of once a suite. Programs of one's own, and controllers that follow a speed or a script, are never \
         warned of.";
    SometimesNoRoom = "W0927", "some values let a pedestrian start where it cannot wait",
        "`commotions` waits no nearer than `D_s` to where its body and that of a vehicle can meet: half of both bodies and `D_s` from the \
         centre of the lane, 2.15 m for a disc of 0.25 m, a car 1.8 m wide and 1 m. Nearer it has only one option, to go first, and is hit \
         where that fails, whatever it has seen. Let every value be farther away, declare a smaller `D_s`, or say `may start inside` if \
         that is what the scenario is about.";
    FirstSight = "W0928", "people decide at first sight, and a number depends on it",
        "A pedestrian exists from the moment on at which it appears. Of `humans` more than half set off within two decisions, on one noisy \
         look, and nearly all who are hit are of those. Where people stood and looked before, say for how long: `looks for 1 s`; `humans` \
         were fitted without a look, so that the new number is uncalibrated. The check leaves out \
         pedestrians behind a box, suites that hold results against a `source`, and scenarios with the tag `published`.";
    LongLook = "W0929", "a look outlasts all vehicles",
        "The pedestrian may go only when every vehicle has passed it, if none brakes. It then meets no vehicle, so that a pass shows nothing. A look \
         begins when the pedestrian appears: let a vehicle that is to be 3 s away when the pedestrian may go be 3 s plus the look away then.";
    NoCriteria = "W0902", "a scenario expects nothing",
        "Without `expect` a scenario is run but not judged: nothing is claimed of it. Add criteria to it or to the suite; where a search, tune, \
         evaluate or statement is about its runs, it needs none.";
    NeverSampled = "W0903", "a criterion applies to none of the values drawn",
        "The condition after `when` holds for none of the values that a sampled variation has with this seed, so the \
         criterion is never checked.";
    NothingToDecide = "W0904", "runs are added until nothing is decided",
        "`runs 50 .. 2000` adds runs until every criterion with stated confidence is decided. Here no criterion states \
         one, so there are always as many runs as the first number says: `repeat` says that more plainly.";
    DecimalComma = "W0905", "a comma may have been meant as a decimal point",
        "Numbers have decimal points: `0.5 %`. A comma separates values, so that `[0,5 %, 1,25 %]` has four. The warning tells both readings; \
         write points, or a space behind each comma that separates.";
    AnotherModel = "W0913", "a model is another one than was published",
        "A number of a model is not the one that was published beside its other settings, such as a `dt` of `commotions` that \
         is not 25 ms with noise or 100 ms without. Noise and filters are per time step, so nobody fitted what comes of it to \
         people. Every report and baseline names it. `another_model: true` lets it be varied and searched, and changes \
         nothing about this.";
    CollisionsUnguarded = "W0935", "a gate says nothing of collisions",
        "`no metric worse by more than 5 %` is about quantities: 5 % of what is true or false would be 5 points of its rate. \
         Collisions need a rule of their own, `collision not worse` or `no new collision`. Without one only those are \
         noticed that happen in a scenario in which the baseline has none, on the same seeds.";
    CannotFail = "W0936", "a criterion that cannot fail",
        "It holds whatever happens: a share is never below 0 % nor above 100 %, a time never negative. A pass of it is evidence of \
         nothing. `scenario-runner models NAME` says between which limits a metric lies. Perhaps the relation points the other \
         way, or a unit is missing a factor.";
    OneRunEach = "W0937", "a claim about many runs is asked of one at a time",
        "`vary x in normal(…) 500 times` makes 500 trials, each with a verdict of its own. Where each has one run, a share of its \
         runs is 0 % or 100 %, a mean or quantile is the value of that run, and `rate(…) <= 5 %` says that it may not happen at \
         all. Say what has to hold in every run, or let every trial have many runs with `repeat`. What is to be true of all \
         draws together is a criterion of a scenario in which every run draws its own, `draw x from normal(…)` and `repeat 500`.";
    OnlyTheseRuns = "W0950", "a claim about drawn runs says nothing of those that were not drawn",
        "Where runs draw what differs between them, a share or a mean without a confidence is that of the runs that were made: with another \
         seed it is another one. `with 95 % confidence` makes it a claim about all that may be drawn.";
    CutOff = "W0951", "what is drawn is cut off",
        "A distribution reaches beyond what can be run, by less than one in ten million draws at each end: those are drawn again. More would \
         be an error. `truncated_normal(mean, standard deviation, low, high)` says where it ends.";
    NothingClaimed = "W0938", "no criterion applies to some trials",
        "Every criterion of the scenario has a `when` that does not hold there, so that nothing is claimed of these trials: they \
         are run, counted as not judged in every report, and are evidence of nothing. Add a criterion without `when`, or leave \
         the values out.";
    FlatScore = "W0953", "a score does not lead to the event",
        "Where most runs have the same score nothing shows where the event lies, and what is not found counts as if it were not there. \
         `min_distance` is such a metric: it is as large as it is at the start in every run in which nobody comes near. Times such as `pet` \
         or `min_ttc` slope.";
    NoSignal = "W0961", "a criterion is about red lights, and the road has no signal",
        "`ran_red` exists where a vehicle came to a signal that was not green. On a road without one, or with one that never shows red, \
         nothing is at stake, and the criterion passes untested. `crossing signalised { … }` declares a signal.";
    SetAside = "W0955", "a criterion applies to no run with the values that were set",
        "With `--set tta=4s`, a criterion `when tta >= 14 s` has nothing to say. It is left out; a run to which no criterion \
         applies is refused.";
}
