//! The library of a functional mock-up unit, of FMI 2.0 and 3.0 in one: brakes for whoever is near, or does what a unit must not.
//!
//! Variables: 0 speed, 1 cruise speed, 2 x and 3 y of who is nearest (numbers), 4 whether somebody is (truth), 5 gap (number),
//! 6 acceleration (number, given), 7 what it is to do (text), 8 level (whole), 9 curvature (number, given).

#![allow(unsafe_code, reason = "functions for a foreign program")]
#![allow(clippy::missing_safety_doc, reason = "the standard says when they may be called")]
#![allow(missing_docs, reason = "the standard says what they do")]

use std::ffi::{CStr, c_char, c_int, c_void};
use std::ptr;
use std::sync::atomic::{AtomicU32, Ordering::SeqCst};

type Status = c_int;
type Unit = *mut Instance;

const OK: Status = 0;
const DISCARD: Status = 2;
const ERROR: Status = 3;
const FATAL: Status = 4;

/// Instances that were ever made since the library was loaded.
static MADE: AtomicU32 = AtomicU32::new(0);
/// Steps of all of them.
static STEPS: AtomicU32 = AtomicU32::new(0);

/// `fmi2CallbackFunctions`, as far as it is used.
#[repr(C)]
pub struct Callbacks {
    logger:
        Option<unsafe extern "C" fn(*mut c_void, *const c_char, Status, *const c_char, *const c_char, ...)>,
    _others: [*const c_void; 3],
    environment: *mut c_void,
}

type LogMessage = unsafe extern "C" fn(*mut c_void, Status, *const c_char, *const c_char);

enum Log {
    Two(*const Callbacks),
    Three(*mut c_void, LogMessage),
}

pub struct Instance {
    numbers: [f64; 10],
    kind: String,
    log: Log,
    steps: u32,
    sum: f64,
    is_initialised: bool,
    /// A function has ended in an error.
    has_failed: bool,
    is_terminated: bool,
}

impl Instance {
    fn make(token: *const c_char, log: Log) -> Unit {
        let token = unsafe { CStr::from_ptr(token) }.to_string_lossy();
        let before = MADE.fetch_add(1, SeqCst);
        if token == "refuses" || (token == "once" && before > 0) {
            return ptr::null_mut();
        }
        let (numbers, kind) = ([0.0; 10], "good".to_string());
        let new = Self {
            numbers,
            kind,
            log,
            steps: 0,
            sum: 0.0,
            is_initialised: false,
            has_failed: false,
            is_terminated: false,
        };
        Box::into_raw(Box::new(new))
    }

    /// Whoever says so too early, twice or after an error ends the process.
    fn terminate(&mut self) -> Status {
        if !self.is_initialised || self.has_failed || self.is_terminated {
            eprintln!("terminated where that is not allowed");
            std::process::abort();
        }
        self.is_terminated = true;
        OK
    }

    /// Whoever frees what is running ends the process.
    fn free(unit: Unit) {
        let unit = unsafe { Box::from_raw(unit) };
        if unit.is_initialised && !unit.has_failed && !unit.is_terminated {
            eprintln!("freed and not terminated");
            std::process::abort();
        }
    }

    fn say(&self, status: Status, text: &CStr) {
        let (name, category) = (c"unit".as_ptr(), c"logAll".as_ptr());
        unsafe {
            match self.log {
                Log::Two(callbacks) => {
                    if let Some(logger) = (*callbacks).logger {
                        // What a logger in C would put in place of %s.
                        logger((*callbacks).environment, name, status, category, text.as_ptr(), name);
                    }
                }
                Log::Three(environment, log) => log(environment, status, category, text.as_ptr()),
            }
        }
    }

    fn step(&mut self, time: f64, step: f64) -> Status {
        if !self.is_initialised || self.is_terminated || time != f64::from(self.steps) * step {
            self.has_failed = true;
            self.say(ERROR, c"not at this time");
            return ERROR;
        }
        self.steps += 1;
        let all = STEPS.fetch_add(1, SeqCst);
        let [speed, cruise, x, y, present, gap, ..] = self.numbers;
        self.sum += speed;
        let near = present != 0.0 && 0.0 < x && x < 25.0 && y.abs() < 4.0;
        self.numbers[6] = match (near, speed > 0.0) {
            (true, true) => -3.0 - gap / 100.0,
            (true, false) => 0.0,
            (false, _) => 0.5 * (cruise - speed),
        };
        // Some runs go wrong, and late.
        if gap == 8.0 && self.steps > 7 {
            match self.kind.as_str() {
                "error" => {
                    self.has_failed = true;
                    self.say(ERROR, c"lane is None");
                    return ERROR;
                }
                "discard" => return DISCARD,
                "fatal" => {
                    self.say(FATAL, c"out of %s");
                    return FATAL;
                }
                "nan" => self.numbers[6] = f64::NAN,
                "huge" => self.numbers[6] = 1e9,
                "aborts" => std::process::abort(),
                "hangs" => loop {
                    std::thread::sleep(std::time::Duration::from_secs(600));
                },
                _ => {}
            }
        }
        match self.kind.as_str() {
            // Where it gives no number, it does not steer.
            "steers" if !(0.3..1.5).contains(&time) => self.numbers[9] = f64::NAN,
            "steers" => self.numbers[9] = if time < 0.9 { 0.02 } else { -0.02 },
            "prints" => println!("step {time}"),
            "sums" => self.numbers[6] -= 1e-4 * self.sum,
            "carries" => self.numbers[6] -= 1e-6 * f64::from(all),
            "level" => self.numbers[6] -= 1e-3 * self.numbers[8],
            _ => {}
        }
        OK
    }

    fn set(&mut self, reference: u32, value: f64) -> Status {
        match self.numbers.get_mut(reference as usize) {
            Some(place) => *place = value,
            None => return ERROR,
        }
        OK
    }

    fn initialise(&mut self) -> Status {
        self.is_initialised = true;
        self.has_failed = self.kind == "uninitialised";
        if self.has_failed { ERROR } else { OK }
    }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    _name: *const c_char,
    _kind: c_int,
    token: *const c_char,
    resources: *const c_char,
    callbacks: *const Callbacks,
    _visible: c_int,
    _logging: c_int,
) -> Unit {
    let resources = unsafe { CStr::from_ptr(resources) }.to_string_lossy();
    assert!(resources.starts_with("file:///"), "{resources}");
    Instance::make(token, Log::Two(callbacks))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    _visible: bool,
    _logging: bool,
    _event_mode: bool,
    _early_return: bool,
    _intermediate: *const u32,
    _count: usize,
    environment: *mut c_void,
    log: LogMessage,
    _update: *const c_void,
) -> Unit {
    let resources = unsafe { CStr::from_ptr(resources) }.to_string_lossy();
    assert!(std::path::Path::new(&*resources).is_dir(), "{resources}");
    Instance::make(token, Log::Three(environment, log))
}

/// Functions that take an instance.
macro_rules! functions {
    ($($name:ident ($unit:ident $(, $argument:ident: $of:ty)*) $body:expr;)*) => { $(
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name($unit: Unit $(, $argument: $of)*) -> Status {
            let $unit = unsafe { &mut *$unit };
            $body
        }
    )* };
}

/// Functions that set or get numbers; those of 3.0 have a count more.
macro_rules! numbers {
    ($($set:ident $get:ident ($of:ty $(, $more:ident)?);)*) => { $(
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $set(unit: Unit, at: *const u32, count: usize, values: *const $of $(, $more: usize)?) -> Status {
            $(assert_eq!($more, count);)?
            for index in 0..count {
                let (reference, value) = unsafe { (*at.add(index), *values.add(index)) };
                let status = unsafe { &mut *unit }.set(reference, value as f64);
                if status != OK {
                    return status;
                }
            }
            OK
        }

        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $get(unit: Unit, at: *const u32, count: usize, values: *mut $of $(, $more: usize)?) -> Status {
            $(assert_eq!($more, count);)?
            for index in 0..count {
                unsafe { *values.add(index) = (&(*unit).numbers)[*at.add(index) as usize] as $of };
            }
            OK
        }
    )* };
}

numbers! {
    fmi2SetReal fmi2GetReal (f64);
    fmi2SetInteger fmi2GetInteger (c_int);
    fmi2SetBoolean fmi2GetBoolean (c_int);
    fmi3SetFloat64 fmi3GetFloat64 (f64, values_count);
    fmi3SetFloat32 fmi3GetFloat32 (f32, values_count);
    fmi3SetInt8 fmi3GetInt8 (i8, values_count);
    fmi3SetUInt8 fmi3GetUInt8 (u8, values_count);
    fmi3SetInt16 fmi3GetInt16 (i16, values_count);
    fmi3SetUInt16 fmi3GetUInt16 (u16, values_count);
    fmi3SetInt32 fmi3GetInt32 (i32, values_count);
    fmi3SetUInt32 fmi3GetUInt32 (u32, values_count);
    fmi3SetInt64 fmi3GetInt64 (i64, values_count);
    fmi3SetUInt64 fmi3GetUInt64 (u64, values_count);
    // A boolean of 3.0 is a byte.
    fmi3SetBoolean fmi3GetBoolean (u8, values_count);
}

functions! {
    fmi2SetupExperiment(_unit, _tolerance: c_int, _of: f64, start: f64, _ends: c_int, _stop: f64) {
        if start == 0.0 { OK } else { ERROR }
    };
    fmi2EnterInitializationMode(_unit) OK;
    fmi2ExitInitializationMode(unit) unit.initialise();
    fmi2Terminate(unit) unit.terminate();
    fmi3Terminate(unit) unit.terminate();
    fmi2DoStep(unit, time: f64, step: f64, _keeps: c_int) unit.step(time, step);
    fmi2SetString(unit, _at: *const u32, _count: usize, values: *const *const c_char) {
        unit.kind = unsafe { CStr::from_ptr(*values) }.to_string_lossy().into_owned();
        OK
    };
    fmi3EnterInitializationMode(_unit, _tolerance: bool, _of: f64, _start: f64, _ends: bool, _stop: f64) OK;
    fmi3ExitInitializationMode(unit) unit.initialise();
    fmi3SetString(unit, _at: *const u32, _count: usize, values: *const *const c_char, _length: usize) {
        unit.kind = unsafe { CStr::from_ptr(*values) }.to_string_lossy().into_owned();
        OK
    };
    fmi3DoStep(unit, time: f64, step: f64, _keeps: bool, _event: *mut u8, ends: *mut u8, early: *mut u8, _last: *mut f64) {
        let status = unit.step(time, step);
        unsafe {
            *ends = u8::from(unit.kind == "ends");
            *early = u8::from(unit.kind == "early");
        }
        status
    };
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(unit: Unit) {
    Instance::free(unit);
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(unit: Unit) {
    Instance::free(unit);
}
