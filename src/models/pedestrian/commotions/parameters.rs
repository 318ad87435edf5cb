//! The parameters of the model (§9): their published names, units, ranges and defaults, declared once.

use super::variant::{self, Accumulation, Sensing, Variant};
use scenario::{ANOTHER_MODEL, Dimension, Parameter, Settings, Text};

/// The setting that says how far from the conflict space a road user waits.
pub const SAFETY_DISTANCE: &str = "D_s";

/// One individual: everything about a road user that is a number, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters {
    /// `T_delta`: discount half-life, s.
    pub discount_half_life: f64,
    /// `beta_V`: weight of value in beliefs about the other's behaviour.
    pub value_belief_weight: f64,
    /// `beta_O`: weight of observation in beliefs about the other's behaviour.
    pub observation_belief_weight: f64,
    /// `thetaDot_0`: optical expansion rate above which looming costs, rad/s.
    pub looming_onset: f64,
    /// `thetaDot_1`: optical expansion rate whose cost cancels travelling freely, rad/s.
    pub looming_full: f64,
    /// `T_O1`: sampling time of observation evidence, s.
    pub observation_sampling_time: f64,
    /// `T_Of`: forgetting time of observation evidence, s.
    pub observation_forgetting_time: f64,
    /// `sigma_O`: expected deviation of the other from each behaviour, m.
    pub observation_deviation: f64,
    /// `T`: time constant of evidence accumulation, s.
    pub evidence_time: f64,
    /// `DeltaV_th_rel`: surplus of value at which evidence leads to action, relative.
    pub evidence_threshold: f64,
    /// `xi_th`: accumulated surplus at which a decision is made, s.
    pub decision_threshold: f64,
    /// `tau_theta`: angular noise of seeing, rad.
    pub angular_noise: f64,
    /// `tau_d`: distance noise of seeing, m.
    pub distance_noise: f64,
    /// `sigma_V`: noise on values, per √s.
    pub value_noise: f64,
    /// `c_tau`: scale of the sensory noise without perceptual filtering.
    pub unfiltered_noise_scale: f64,
    /// `sigma_xdot`: process noise of the perceptual filter per step, m/s.
    pub process_noise: f64,
    /// `h`: height of the eyes, m.
    pub eye_height: f64,
    /// `DeltaT`: duration of an action and prediction time, s.
    pub action_duration: f64,
    /// `D_s`: safety distance, m.
    pub safety_distance: f64,
    /// `T_s`: safety time, s.
    pub safety_time: f64,
    /// `V_0_rel`: scale on which values saturate, relative to travelling freely.
    pub value_scale: f64,
    /// `V_ny_rel`: value for a driver of not giving way to someone with priority, relative.
    pub not_yielding_value: f64,
    /// `k_da`: discomfort of acceleration, s⁴/m².
    pub acceleration_discomfort: f64,
    /// `ped_free_speed`: free speed of pedestrians, m/s.
    pub pedestrian_free_speed: f64,
    /// `veh_free_speed`: free speed of vehicles, m/s.
    pub vehicle_free_speed: f64,
}

const FITTED: &str =
    "Markkula et al. 2023, fitted per individual; default: median of the published individuals";
const FIXED: &str = "Markkula et al. 2023, fixed in the published fits";

/// The time step (s) with which the variant was published: coarse where nothing is drawn.
fn published_time_step(settings: &Settings) -> f64 {
    let stochastic = settings.word("variant").parse::<Variant>().is_ok_and(|variant| variant.is_stochastic());
    if stochastic { 0.025 } else { 0.1 }
}

/// Everything that a scenario may say about a COMMOTIONS road user: its variant, its time step, and the numbers
/// of [`Parameters`] under their published names.
pub fn parameters() -> Vec<Parameter> {
    vec![
    Parameter::text(
        "variant",
        "oVAoBEvoAIoEAoSNvoPF",
        variant::check,
        "Published name of the variant: its assumptions one after the other",
        "Markkula et al. 2023",
    ),
    Parameter::number(
        "dt",
        Dimension::TIME,
        0.025,
        (0.005, 0.1),
        "Time step of perception and decision, a multiple of the simulation step; noise and filters are per step, so that \
         another than the published one is another model",
        "Markkula et al. 2023: 0.025 s for stochastic, 0.1 s for deterministic variants",
    )
    .published_with(published_time_step),
    Parameter::flag(
        ANOTHER_MODEL,
        false,
        "Says that a `dt` beside the published one is meant, so that it may be varied, searched, tuned and compared",
        "scenario-runner",
    ),
    Parameter::number(
        "entry_inhibited_until",
        Dimension::TIME,
        0.0,
        (0.0, 1e6),
        "Time before which pedestrians may not enter, as while another car is passing",
        "HIKER experiment, Lee et al. 2022",
    ),
    Parameter::number(
        "T_delta",
        Dimension::TIME,
        27.825_594_02,
        (1.0, 300.0),
        "Half-life with which future value is discounted",
        FITTED,
    ),
    Parameter::number(
        "beta_V",
        Dimension::NUMBER,
        18.982_350_91,
        (0.0, 1e4),
        "Weight of the other's values in beliefs about what it will do",
        FITTED,
    ),
    Parameter::number(
        "beta_O",
        Dimension::NUMBER,
        1.0,
        (0.0, 1e4),
        "Weight of the other's movement in beliefs about what it will do",
        FIXED,
    ),
    Parameter::number(
        "thetaDot_0",
        Dimension::ANGULAR_SPEED,
        0.0,
        (0.0, 10.0),
        "Optical expansion rate at which looming begins to cost value",
        FIXED,
    ),
    Parameter::number(
        "thetaDot_1",
        Dimension::ANGULAR_SPEED,
        0.007_742_636_827,
        (1e-5, 10.0),
        "Optical expansion rate whose cost cancels the value of travelling freely",
        FITTED,
    ),
    Parameter::number(
        "T_O1",
        Dimension::TIME,
        0.05,
        (1e-3, 10.0),
        "Time over which one observation of the other counts once",
        FIXED,
    ),
    Parameter::number(
        "T_Of",
        Dimension::TIME,
        2.640_975_95,
        (0.1, 1e3),
        "Time after which observations of the other are forgotten",
        FITTED,
    ),
    Parameter::number(
        "sigma_O",
        Dimension::LENGTH,
        0.092_833_776_67,
        (1e-4, 100.0),
        "Standard deviation of the other's distance around each expected behaviour",
        FITTED,
    ),
    Parameter::number(
        "T",
        Dimension::TIME,
        0.170_997_594_7,
        (0.01, 10.0),
        "Time constant of evidence accumulation (oEA)",
        FITTED,
    ),
    Parameter::number(
        "DeltaV_th_rel",
        Dimension::NUMBER,
        0.002_782_559_402,
        (0.0, 1.0),
        "Surplus value that makes evidence an action, relative to travelling freely (oEA)",
        FITTED,
    ),
    Parameter::number(
        "xi_th",
        Dimension::TIME,
        0.001_077_217_345,
        (0.0, 1.0),
        "Accumulated surplus value that makes a decision (oDA)",
        FITTED,
    ),
    Parameter::number(
        "tau_theta",
        Dimension::ANGLE,
        0.232_079_441_7,
        (0.0, 10.0),
        "Noise of seeing as an angle below the horizon (oSNv)",
        FITTED,
    ),
    Parameter::number(
        "tau_d",
        Dimension::LENGTH,
        500.0,
        (0.0, 1e4),
        "Noise of seeing as a distance (oSNc)",
        FITTED,
    ),
    Parameter::number(
        "sigma_V",
        Dimension::NUMBER,
        0.031_622_776_6,
        (0.0, 10.0),
        "Noise on values (oAN)",
        "Markkula et al. 2023, fitted per individual; default: middle of the published grid",
    ),
    Parameter::number(
        "c_tau",
        Dimension::NUMBER,
        0.001,
        (0.0, 1.0),
        "Scale of the noise of seeing without perceptual filtering",
        FIXED,
    ),
    Parameter::number(
        "sigma_xdot",
        Dimension::SPEED,
        0.1,
        (0.0, 10.0),
        "Speed change per step that perceptual filtering expects (oPF)",
        FIXED,
    ),
    Parameter::number("h", Dimension::LENGTH, 1.5, (0.1, 5.0), "Height of the eyes", FIXED),
    Parameter::number(
        "DeltaT",
        Dimension::TIME,
        0.5,
        (0.1, 5.0),
        "Duration of an action, and how far ahead states are predicted",
        FIXED,
    ),
    Parameter::number(
        SAFETY_DISTANCE,
        Dimension::LENGTH,
        1.0,
        (0.0, 20.0),
        "Distance kept from the conflict space",
        FIXED,
    ),
    Parameter::number("T_s", Dimension::TIME, 1.0, (0.0, 20.0), "Time kept from the other", FIXED),
    Parameter::number(
        "V_0_rel",
        Dimension::NUMBER,
        4.0,
        (0.01, 1e3),
        "Scale on which values saturate, relative to travelling freely",
        FIXED,
    ),
    Parameter::number(
        "V_ny_rel",
        Dimension::NUMBER,
        -1.5,
        (-1e3, 0.0),
        "Value for a driver of not giving way where pedestrians have priority, relative to travelling freely",
        FIXED,
    ),
    Parameter::number(
        "k_da",
        Dimension::new(-2, 4, 0),
        0.5,
        (0.0, 100.0),
        "Discomfort of acceleration",
        FIXED,
    ),
    Parameter::number(
        "ped_free_speed",
        Dimension::SPEED,
        1.3,
        (0.1, 5.0),
        "Free speed of pedestrians",
        FIXED,
    ),
    Parameter::optional(
        "veh_free_speed",
        Dimension::SPEED,
        (0.5, 60.0),
        "Free speed of vehicles; without it 50 km/h, or on a slower road the speed limit",
        FIXED,
    ),
]
}

impl Default for Parameters {
    /// The declared defaults.
    fn default() -> Self {
        let mut own = Self {
            discount_half_life: 0.0,
            value_belief_weight: 0.0,
            observation_belief_weight: 0.0,
            looming_onset: 0.0,
            looming_full: 0.0,
            observation_sampling_time: 0.0,
            observation_forgetting_time: 0.0,
            observation_deviation: 0.0,
            evidence_time: 0.0,
            evidence_threshold: 0.0,
            decision_threshold: 0.0,
            angular_noise: 0.0,
            distance_noise: 0.0,
            value_noise: 0.0,
            unfiltered_noise_scale: 0.0,
            process_noise: 0.0,
            eye_height: 0.0,
            action_duration: 0.0,
            safety_distance: 0.0,
            safety_time: 0.0,
            value_scale: 0.0,
            not_yielding_value: 0.0,
            acceleration_discomfort: 0.0,
            pedestrian_free_speed: 0.0,
            vehicle_free_speed: 50.0 / 3.6,
        };
        for parameter in parameters() {
            let default = parameter.default_value().and_then(|value| value.as_number());
            if let (Some(field), Some(default)) = (own.get_mut(&parameter.name), default) {
                *field = default;
            }
        }
        own
    }
}

impl Parameters {
    /// The parameter of that published name, to be read or set; `None` if there is none.
    pub fn get_mut(&mut self, name: &str) -> Option<&mut f64> {
        Some(match name {
            "T_delta" => &mut self.discount_half_life,
            "beta_V" => &mut self.value_belief_weight,
            "beta_O" => &mut self.observation_belief_weight,
            "thetaDot_0" => &mut self.looming_onset,
            "thetaDot_1" => &mut self.looming_full,
            "T_O1" => &mut self.observation_sampling_time,
            "T_Of" => &mut self.observation_forgetting_time,
            "sigma_O" => &mut self.observation_deviation,
            "T" => &mut self.evidence_time,
            "DeltaV_th_rel" => &mut self.evidence_threshold,
            "xi_th" => &mut self.decision_threshold,
            "tau_theta" => &mut self.angular_noise,
            "tau_d" => &mut self.distance_noise,
            "sigma_V" => &mut self.value_noise,
            "c_tau" => &mut self.unfiltered_noise_scale,
            "sigma_xdot" => &mut self.process_noise,
            "h" => &mut self.eye_height,
            "DeltaT" => &mut self.action_duration,
            SAFETY_DISTANCE => &mut self.safety_distance,
            "T_s" => &mut self.safety_time,
            "V_0_rel" => &mut self.value_scale,
            "V_ny_rel" => &mut self.not_yielding_value,
            "k_da" => &mut self.acceleration_discomfort,
            "ped_free_speed" => &mut self.pedestrian_free_speed,
            "veh_free_speed" => &mut self.vehicle_free_speed,
            _ => return None,
        })
    }

    /// The parameters in `settings`, which were resolved against the model's declaration.
    pub fn from_settings(settings: &Settings) -> Self {
        let mut parameters = Self::default();
        for (name, value) in &settings.0 {
            if let (Some(field), Some(value)) = (parameters.get_mut(name), value.as_number()) {
                *field = value;
            }
        }
        parameters
    }
}

/// The published grid of a parameter that is fitted per individual (§9.1): its ends.
pub fn published_range(name: &str) -> (f64, f64) {
    match name {
        "T_delta" => (10.0, 100.0),
        "thetaDot_1" => (0.001, 0.1),
        "T" => (0.1, 0.5),
        "DeltaV_th_rel" => (0.001, 0.1),
        "xi_th" => (5e-6, 5e-3),
        "beta_V" => (1.0, 200.0),
        "T_Of" => (0.5, 10.0),
        "sigma_O" => (0.02, 2.0),
        "sigma_V" => (0.001, 1.0),
        "tau_d" => (0.5, 500.0),
        _ => (0.005, 5.0),
    }
}

/// Over which ranges the published individuals of a variant lie; of other variants than the default one the whole published grid.
pub fn individual_ranges(settings: &Settings) -> Vec<(Text, f64, f64)> {
    let Ok(variant) = settings.word("variant").parse::<Variant>() else { return Vec::new() };
    let range = |name: &'static str| {
        let (low, high) = match name {
            "beta_V" if variant == Variant::STANDARD => (5.848, 200.0),
            "DeltaV_th_rel" if variant == Variant::STANDARD => (0.001, 0.02154),
            _ => published_range(name),
        };
        (Text::from(name), low, high)
    };
    fitted_by(&variant).into_iter().map(range).collect()
}

/// The published names of the parameters that a variant fits per individual, in the order of the published files.
pub fn fitted_by(variant: &Variant) -> Vec<&'static str> {
    let listed = [
        (true, "T_delta"),
        (variant.looming, "thetaDot_1"),
        (variant.accumulation == Accumulation::Evidence, "T"),
        (variant.accumulation == Accumulation::Evidence, "DeltaV_th_rel"),
        (variant.accumulation == Accumulation::Decision, "xi_th"),
        (variant.value_beliefs, "beta_V"),
        (variant.observation_beliefs, "T_Of"),
        (variant.observation_beliefs, "sigma_O"),
        (variant.value_noise, "sigma_V"),
        (variant.sensing == Sensing::ConstantNoise, "tau_d"),
        (variant.sensing == Sensing::AngularNoise, "tau_theta"),
    ];
    listed.into_iter().filter_map(|(fits, name)| fits.then_some(name)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use scenario::Value;

    #[test]
    fn every_declared_number_has_its_field_and_a_default_in_range() {
        let mut own = Parameters::default();
        for parameter in parameters() {
            if ["variant", "dt", "entry_inhibited_until", "another_model"].contains(&&*parameter.name) {
                continue;
            }
            let value = *own.get_mut(&parameter.name).expect(&parameter.name);
            parameter.check("commotions", &Value::Number(value)).unwrap();
            let default = parameter.default_value().unwrap_or(Value::Number(50.0 / 3.6));
            assert_eq!(Value::Number(value), default, "{}", parameter.name);
        }
        assert_eq!(own.get_mut("T_d"), None);
    }

    #[test]
    fn settings_override_defaults() {
        let settings =
            Settings::from([("T_delta", Value::Number(33.0)), ("variant", Value::Word("oVA".into()))]);
        let parameters = Parameters::from_settings(&settings);
        assert_eq!(parameters, Parameters { discount_half_life: 33.0, ..Parameters::default() });
    }

    #[test]
    fn the_standard_variant_fits_five_parameters() {
        assert_eq!(fitted_by(&Variant::STANDARD), ["T_delta", "T", "DeltaV_th_rel", "beta_V", "tau_theta"]);
    }
}
