//! The C interface of units: the functions of co-simulation that their libraries export, as FMI 2.0 and 3.0 declare them.
//!
//! All that is `unsafe` stands in this file. What a library does in its functions nobody can vouch for: it runs in a process of its own,
//! which the runner watches. What is held here is that they are called with the types, in the life time and from the one thread that
//! the standard demands.

#![allow(unsafe_code, reason = "functions of a foreign library")]

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::Path;
use std::ptr;
use std::rc::Rc;
use std::sync::{Mutex, PoisonError};

use libloading::Library;

use super::description::{FmiVersion, Kind};

/// What functions return: 0 and 1 are well (1 is a warning), 2 discard, 3 error, 4 fatal, 5 pending.
pub type Status = c_int;

type Log = Mutex<Vec<String>>;
type Component = *mut c_void;
type Reference = u32;

/// A variadic function in C: whatever follows the message is not looked at, and the message is taken as it is. On every platform that
/// this is built for, arguments that are named are passed to a variadic function as to any other.
type Logger2 = unsafe extern "C" fn(Component, *const c_char, Status, *const c_char, *const c_char);
type Logger3 = unsafe extern "C" fn(Component, Status, *const c_char, *const c_char);

/// `fmi2CallbackFunctions`
#[repr(C)]
struct Callbacks2 {
    logger: Logger2,
    allocate: unsafe extern "C" fn(usize, usize) -> *mut c_void,
    free: unsafe extern "C" fn(*mut c_void),
    step_finished: Option<unsafe extern "C" fn(Component, Status)>,
    environment: Component,
}

unsafe extern "C" {
    fn calloc(count: usize, size: usize) -> *mut c_void;
    fn free(memory: *mut c_void);
}

/// Declares the functions of an edition, each with the name under which a library exports it.
macro_rules! functions {
    ($edition:ident { $($field:ident = $symbol:literal ($($argument:ty),*) $(-> $result:ty)?;)* }) => {
        struct $edition { $($field: unsafe extern "C" fn($($argument),*) $(-> $result)?),* }

        impl $edition {
            fn of(library: &Library) -> Result<Self, String> {
                Ok(Self {
                    $($field: {
                        // SAFETY: the standard gives the function of this name this type.
                        let found = unsafe { library.get(concat!($symbol, "\0").as_bytes()) };
                        *found.map_err(|_| format!("it exports no `{}`", $symbol))?
                    }),*
                })
            }
        }
    };
}

functions! { Two {
    instantiate = "fmi2Instantiate"
        (*const c_char, c_int, *const c_char, *const c_char, *const Callbacks2, c_int, c_int) -> Component;
    terminate = "fmi2Terminate" (Component) -> Status;
    free = "fmi2FreeInstance" (Component);
    setup = "fmi2SetupExperiment" (Component, c_int, f64, f64, c_int, f64) -> Status;
    enter = "fmi2EnterInitializationMode" (Component) -> Status;
    exit = "fmi2ExitInitializationMode" (Component) -> Status;
    step = "fmi2DoStep" (Component, f64, f64, c_int) -> Status;
    set_real = "fmi2SetReal" (Component, *const Reference, usize, *const f64) -> Status;
    set_integer = "fmi2SetInteger" (Component, *const Reference, usize, *const c_int) -> Status;
    set_boolean = "fmi2SetBoolean" (Component, *const Reference, usize, *const c_int) -> Status;
    set_string = "fmi2SetString" (Component, *const Reference, usize, *const *const c_char) -> Status;
    get_real = "fmi2GetReal" (Component, *const Reference, usize, *mut f64) -> Status;
    get_integer = "fmi2GetInteger" (Component, *const Reference, usize, *mut c_int) -> Status;
    get_boolean = "fmi2GetBoolean" (Component, *const Reference, usize, *mut c_int) -> Status;
} }

/// Functions of 3.0 that set and get the values of a type.
macro_rules! three {
    ($($set:ident $get:ident $set_symbol:literal $get_symbol:literal $of:ty;)*) => {
        functions! { Three {
            instantiate = "fmi3InstantiateCoSimulation"
                (*const c_char, *const c_char, *const c_char, bool, bool, bool, bool, *const Reference, usize, Component, Logger3,
                 Option<unsafe extern "C" fn()>) -> Component;
            terminate = "fmi3Terminate" (Component) -> Status;
            free = "fmi3FreeInstance" (Component);
            enter = "fmi3EnterInitializationMode" (Component, bool, f64, f64, bool, f64) -> Status;
            exit = "fmi3ExitInitializationMode" (Component) -> Status;
            step = "fmi3DoStep" (Component, f64, f64, bool, *mut u8, *mut u8, *mut u8, *mut f64) -> Status;
            set_string = "fmi3SetString" (Component, *const Reference, usize, *const *const c_char, usize) -> Status;
            $(
                $set = $set_symbol (Component, *const Reference, usize, *const $of, usize) -> Status;
                $get = $get_symbol (Component, *const Reference, usize, *mut $of, usize) -> Status;
            )*
        } }
    };
}

three! {
    set_float64 get_float64 "fmi3SetFloat64" "fmi3GetFloat64" f64;
    set_float32 get_float32 "fmi3SetFloat32" "fmi3GetFloat32" f32;
    set_int8 get_int8 "fmi3SetInt8" "fmi3GetInt8" i8;
    set_uint8 get_uint8 "fmi3SetUInt8" "fmi3GetUInt8" u8;
    set_int16 get_int16 "fmi3SetInt16" "fmi3GetInt16" i16;
    set_uint16 get_uint16 "fmi3SetUInt16" "fmi3GetUInt16" u16;
    set_int32 get_int32 "fmi3SetInt32" "fmi3GetInt32" i32;
    set_uint32 get_uint32 "fmi3SetUInt32" "fmi3GetUInt32" u32;
    set_int64 get_int64 "fmi3SetInt64" "fmi3GetInt64" i64;
    set_uint64 get_uint64 "fmi3SetUInt64" "fmi3GetUInt64" u64;
    set_boolean get_boolean "fmi3SetBoolean" "fmi3GetBoolean" bool;
}

enum Functions {
    Two(Two),
    Three(Box<Three>),
}

/// A library that is loaded, until nobody needs it any more.
pub struct LoadedLibrary {
    functions: Functions,
    /// Dropped after what was found in it.
    _library: Library,
}

impl LoadedLibrary {
    /// # Errors
    /// Why the system does not load it, or what it does not export.
    pub fn load(path: &Path, version: FmiVersion) -> Result<Self, String> {
        // SAFETY: what the library does when it is loaded is its own; its user has allowed it to run.
        #[cfg(windows)]
        let library = unsafe {
            use libloading::os::windows::{LOAD_WITH_ALTERED_SEARCH_PATH, Library};
            // Libraries that lie beside it are found.
            Library::load_with_flags(path, LOAD_WITH_ALTERED_SEARCH_PATH).map(Into::into)
        };
        // SAFETY: as above.
        #[cfg(not(windows))]
        let library = unsafe { Library::new(path) };
        let library: Library = library.map_err(|error| error.to_string())?;
        let functions = match version {
            FmiVersion::Two => Functions::Two(Two::of(&library)?),
            FmiVersion::Three => Functions::Three(Box::new(Three::of(&library)?)),
        };
        Ok(Self { functions, _library: library })
    }
}

/// What an instance is told of itself.
pub struct InstanceNames {
    pub instance: CString,
    pub token: CString,
    /// A URI in 2.0, a path in 3.0.
    pub resources: CString,
}

/// An instance: made, used and freed by the thread that made it.
pub struct Foreign {
    component: Component,
    /// What it has logged; it has the address.
    log: Box<Log>,
    /// It has the address.
    _callbacks: Option<Box<Callbacks2>>,
    loaded: Rc<LoadedLibrary>,
    /// After a fatal error not even this is allowed.
    is_freed: bool,
    /// It is initialised, and no function has ended in an error: it has to be told that the simulation is over before it is freed.
    is_running: bool,
}

/// What came of a step besides its status.
#[derive(Debug, Default, Clone, Copy)]
pub struct Stepped {
    /// It wants the simulation to end.
    pub terminates: bool,
    /// It came back before the step was over.
    pub is_early: bool,
}

impl Foreign {
    /// A new instance, and what it has logged; none if it could not be made.
    pub fn new(loaded: &Rc<LoadedLibrary>, names: &InstanceNames) -> Result<Self, Vec<String>> {
        let log: Box<Log> = Box::default();
        let environment = ptr::from_ref::<Log>(&log).cast_mut().cast::<c_void>();
        let (instance, token, resources) =
            (names.instance.as_ptr(), names.token.as_ptr(), names.resources.as_ptr());
        let (component, callbacks) = match &loaded.functions {
            Functions::Two(two) => {
                let callbacks = Box::new(Callbacks2 {
                    logger: log_two,
                    allocate: calloc,
                    free,
                    step_finished: None,
                    environment,
                });
                const CO_SIMULATION: c_int = 1;
                // SAFETY: texts, callbacks and log outlive the instance, as they stand beside it.
                let component = unsafe {
                    (two.instantiate)(instance, CO_SIMULATION, token, resources, &*callbacks, 0, 0)
                };
                (component, Some(callbacks))
            }
            Functions::Three(three) => {
                // SAFETY: as above; no intermediate variables are asked for, so there is no function for them.
                let component = unsafe {
                    (three.instantiate)(
                        instance,
                        token,
                        resources,
                        false,
                        false,
                        false,
                        false,
                        ptr::null(),
                        0,
                        environment,
                        log_three,
                        None,
                    )
                };
                (component, None)
            }
        };
        let made = Self {
            component,
            log,
            _callbacks: callbacks,
            loaded: loaded.clone(),
            is_freed: component.is_null(),
            is_running: false,
        };
        if component.is_null() { Err(made.logged()) } else { Ok(made) }
    }

    /// What it has logged since this was asked last.
    pub fn logged(&self) -> Vec<String> {
        std::mem::take(&mut *self.log.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Never touches it again, not even to free it.
    pub fn abandon(&mut self) {
        self.is_freed = true;
    }

    /// Begins to initialise it at time 0.
    pub fn enter(&mut self) -> Status {
        // SAFETY: the instance is there. No tolerance and no end are said.
        unsafe {
            match &self.loaded.functions {
                Functions::Two(two) => match (two.setup)(self.component, 0, 0.0, 0.0, 0, 0.0) {
                    0 | 1 => (two.enter)(self.component),
                    other => other,
                },
                Functions::Three(three) => (three.enter)(self.component, false, 0.0, 0.0, false, 0.0),
            }
        }
    }

    /// Ends its initialisation.
    pub fn exit(&mut self) -> Status {
        // SAFETY: the instance is there.
        let status = unsafe {
            match &self.loaded.functions {
                Functions::Two(two) => (two.exit)(self.component),
                Functions::Three(three) => (three.exit)(self.component),
            }
        };
        self.is_running = is_fine(status);
        status
    }

    /// Takes note of what a function ended in. After an error an instance may be freed, and nothing else; a step that it discards is none.
    fn seen(&mut self, status: Status) -> Status {
        const DISCARD: Status = 2;
        self.is_running &= is_fine(status) || status == DISCARD;
        status
    }

    /// Has it go on from `time` by `step`, both in s.
    pub fn step(&mut self, time: f64, step: f64) -> (Status, Stepped) {
        let mut stepped = Stepped::default();
        // SAFETY: the instance is there; what is said comes back into places that outlive the call.
        let status = unsafe {
            match &self.loaded.functions {
                Functions::Two(two) => (two.step)(self.component, time, step, 1),
                Functions::Three(three) => {
                    // Bytes, since a foreign library may put anything there.
                    let (mut has_event, mut terminates, mut early, mut last) = (0, 0, 0, time);
                    let (event, ends, is_early) = (&raw mut has_event, &raw mut terminates, &raw mut early);
                    let status =
                        (three.step)(self.component, time, step, true, event, ends, is_early, &raw mut last);
                    stepped = Stepped { terminates: terminates != 0, is_early: early != 0 };
                    status
                }
            }
        };
        (self.seen(status), stepped)
    }

    /// Sets variables of that kind; `references` and `values` are as many.
    pub fn set(&mut self, kind: Kind, references: &[Reference], values: &[f64]) -> Status {
        assert_eq!(references.len(), values.len(), "a value for each variable");
        let (component, at, count) = (self.component, references.as_ptr(), references.len());
        // SAFETY: the instance is there, and there are as many references as values, of the type that the function takes.
        macro_rules! as_two {
            ($function:expr, $of:ty) => {{
                let values: Vec<$of> = values.iter().map(|value| *value as $of).collect();
                unsafe { $function(component, at, count, values.as_ptr()) }
            }};
        }
        macro_rules! as_three {
            ($function:expr, $convert:expr) => {{
                let values: Vec<_> = values.iter().map($convert).collect();
                unsafe { $function(component, at, count, values.as_ptr(), count) }
            }};
        }
        let status = match &self.loaded.functions {
            Functions::Two(two) => match kind {
                // SAFETY: as above.
                Kind::Float64 => unsafe { (two.set_real)(component, at, count, values.as_ptr()) },
                Kind::Boolean => as_two!((two.set_boolean), c_int),
                _ => as_two!((two.set_integer), c_int),
            },
            Functions::Three(three) => match kind {
                // SAFETY: as above.
                Kind::Float64 => unsafe { (three.set_float64)(component, at, count, values.as_ptr(), count) },
                Kind::Float32 => as_three!((three.set_float32), |value| *value as f32),
                Kind::Int8 => as_three!((three.set_int8), |value| *value as i8),
                Kind::UInt8 => as_three!((three.set_uint8), |value| *value as u8),
                Kind::Int16 => as_three!((three.set_int16), |value| *value as i16),
                Kind::UInt16 => as_three!((three.set_uint16), |value| *value as u16),
                Kind::Int32 => as_three!((three.set_int32), |value| *value as i32),
                Kind::UInt32 => as_three!((three.set_uint32), |value| *value as u32),
                Kind::Int64 | Kind::Text => as_three!((three.set_int64), |value| *value as i64),
                Kind::UInt64 => as_three!((three.set_uint64), |value| *value as u64),
                Kind::Boolean => as_three!((three.set_boolean), |value| *value != 0.0),
            },
        };
        self.seen(status)
    }

    /// Sets a variable that is a text.
    pub fn set_text(&mut self, reference: Reference, text: &CStr) -> Status {
        let texts = [text.as_ptr()];
        // SAFETY: the instance is there; it copies the text, of which there is one for the one reference.
        let status = unsafe {
            match &self.loaded.functions {
                Functions::Two(two) => {
                    (two.set_string)(self.component, &raw const reference, 1, texts.as_ptr())
                }
                Functions::Three(three) => {
                    (three.set_string)(self.component, &raw const reference, 1, texts.as_ptr(), 1)
                }
            }
        };
        self.seen(status)
    }

    /// The value of a variable of that kind.
    pub fn get(&mut self, kind: Kind, reference: Reference) -> (Status, f64) {
        let (component, at) = (self.component, &raw const reference);
        // SAFETY: the instance is there, and there is one place for one value, of the type that the function gives. A boolean of 3.0 is
        // given as a byte, whatever it is.
        macro_rules! as_two {
            ($function:expr, $of:ty) => {{
                let mut value = <$of>::default();
                let status = unsafe { $function(component, at, 1, &raw mut value) };
                (status, f64::from(value))
            }};
        }
        macro_rules! as_three {
            ($function:expr, $of:ty, $convert:expr) => {{
                let mut value = <$of>::default();
                let status = unsafe { $function(component, at, 1, (&raw mut value).cast(), 1) };
                (status, $convert(value))
            }};
        }
        let (status, value) = match &self.loaded.functions {
            Functions::Two(two) => match kind {
                Kind::Float64 => as_two!((two.get_real), f64),
                Kind::Boolean => as_two!((two.get_boolean), c_int),
                _ => as_two!((two.get_integer), c_int),
            },
            Functions::Three(three) => match kind {
                Kind::Float64 => as_three!((three.get_float64), f64, f64::from),
                Kind::Float32 => as_three!((three.get_float32), f32, f64::from),
                Kind::Int8 => as_three!((three.get_int8), i8, f64::from),
                Kind::UInt8 => as_three!((three.get_uint8), u8, f64::from),
                Kind::Int16 => as_three!((three.get_int16), i16, f64::from),
                Kind::UInt16 => as_three!((three.get_uint16), u16, f64::from),
                Kind::Int32 => as_three!((three.get_int32), i32, f64::from),
                Kind::UInt32 => as_three!((three.get_uint32), u32, f64::from),
                Kind::Int64 | Kind::Text => as_three!((three.get_int64), i64, |value| value as f64),
                Kind::UInt64 => as_three!((three.get_uint64), u64, |value| value as f64),
                Kind::Boolean => as_three!((three.get_boolean), u8, |value| f64::from(u8::from(value != 0))),
            },
        };
        (self.seen(status), value)
    }
}

/// OK, or a warning.
fn is_fine(status: Status) -> bool {
    matches!(status, 0 | 1)
}

impl Drop for Foreign {
    fn drop(&mut self) {
        const FATAL: Status = 4;
        if !self.is_freed && self.is_running {
            // SAFETY: the instance is there, and in a state in which it may be told so.
            let status = unsafe {
                match &self.loaded.functions {
                    Functions::Two(two) => (two.terminate)(self.component),
                    Functions::Three(three) => (three.terminate)(self.component),
                }
            };
            self.is_freed = status == FATAL;
        }
        if !self.is_freed {
            // SAFETY: the instance is there, and nothing of it is used after this.
            unsafe {
                match &self.loaded.functions {
                    Functions::Two(two) => (two.free)(self.component),
                    Functions::Three(three) => (three.free)(self.component),
                }
            }
        }
    }
}

/// Messages of an instance that are kept until somebody asks.
const MOST_MESSAGES: usize = 1000;

/// # Safety
/// `environment` is the log of an instance that is there, and `message` null or a text.
unsafe fn note(environment: Component, message: *const c_char) {
    if environment.is_null() || message.is_null() {
        return;
    }
    // SAFETY: as above: the caller is the instance, which was given both.
    let (log, message) = unsafe { (&*environment.cast::<Log>(), CStr::from_ptr(message)) };
    let mut log = log.lock().unwrap_or_else(PoisonError::into_inner);
    if log.len() < MOST_MESSAGES {
        log.push(message.to_string_lossy().into_owned());
    }
}

unsafe extern "C" fn log_two(
    environment: Component,
    _instance: *const c_char,
    _status: Status,
    _category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the standard promises it.
    unsafe { note(environment, message) }
}

unsafe extern "C" fn log_three(
    environment: Component,
    _status: Status,
    _category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the standard promises it.
    unsafe { note(environment, message) }
}
