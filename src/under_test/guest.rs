//! A WebAssembly module that decides: it is called with the frames of the protocol, and can do nothing else.
//!
//! It is given no imports: no clock, no files, no random numbers. What it may take is counted in instructions and memory, so that the
//! same frames have the same answers everywhere, and in how many instances it runs changes nothing.

use wasmi::{
    Config, Engine, Error, Instance, Memory, Module, Store, StoreLimits, StoreLimitsBuilder, TrapCode,
    TypedFunc,
};

use super::lookup;
use super::quote::one_line;
use super::start::{StartError, StartProblem};
use super::wire;
use scenario::DeclaredProgram;
use scenario::{FaultKind, ProgramFault};

/// Instructions that it may take for the answer to each run of a request, as the interpreter counts them.
pub const FUEL: u64 = 100_000_000;

/// Memory that it may have, bytes.
pub const MEMORY: usize = 64 << 20;

/// More than a module's file may have, bytes.
const LARGEST_MODULE: u64 = 64 << 20;

/// An instance of a module.
pub struct Guest {
    store: Store<StoreLimits>,
    memory: Memory,
    /// Gives a place for a frame of so many bytes.
    buffer: TypedFunc<i32, i32>,
    /// Takes the frame that stands there; gives the place of its answer.
    frame: TypedFunc<i32, i32>,
}

impl Guest {
    /// Reads the module and begins an instance of it.
    ///
    /// # Errors
    /// If it cannot be read, is no module, wants something from outside, or lacks what is called.
    pub fn start(program: &DeclaredProgram, file: &str) -> Result<Self, StartError> {
        let path = lookup::beside(program).join(file);
        let cannot = |message: String, hint: &str| {
            StartError::new(StartProblem::CannotStart, program, format!("`{file}`: {message}"), hint)
        };
        let bytes = files::read_bytes(&path, LARGEST_MODULE).map_err(|error| {
            let hint = "`wasm` is relative to the file that says it";
            cannot(format!("{} cannot be read: {error}", path.display()), hint)
        })?;
        let mut config = Config::default();
        config.consume_fuel(true);
        let engine = Engine::new(&config);
        if is_text(&bytes) {
            let message = format!("{} is the text of a WebAssembly module, not its binary", path.display());
            let hint = format!("convert it: `wasm-tools parse {file} -o module.wasm`, or `wat2wasm`");
            return Err(cannot(message, &hint));
        }
        let module = Module::new(&engine, &bytes).map_err(|error| {
            let error = one_line(&error.to_string());
            let message = format!("{} is not a WebAssembly module: {error}", path.display());
            cannot(message, "`wasm` names a core module as compilers write it, a `.wasm` file")
        })?;
        if let Some(import) = module.imports().next() {
            let message = format!("it imports `{}.{}`, and nothing is given", import.module(), import.name());
            let hint = "build it for a target without a system, such as wasm32-unknown-unknown";
            return Err(cannot(message, hint));
        }
        let limits =
            StoreLimitsBuilder::new().memory_size(MEMORY).table_elements(100_000).memories(1).build();
        let mut store = Store::new(&engine, limits);
        store.limiter(|limits| limits);
        let begun = store.set_fuel(FUEL).and_then(|()| Instance::new(&mut store, &module, &[]));
        let instance = begun.map_err(|error| {
            cannot(
                format!("it does not begin: {}", what_happened(&error, 1).message),
                "see docs/under_test.md",
            )
        })?;
        let lacks = |what: &str| {
            let hint = "it exports `memory`, `buffer(bytes: i32) -> i32` and `frame(length: i32) -> i32`: see docs/under_test.md";
            cannot(format!("it exports no {what}"), hint)
        };
        let memory = instance.get_memory(&store, "memory").ok_or_else(|| lacks("`memory`"))?;
        let function = |name: &str| {
            instance
                .get_typed_func::<i32, i32>(&store, name)
                .map_err(|_| lacks(&format!("`{name}` from i32 to i32")))
        };
        let (buffer, frame) = (function("buffer")?, function("frame")?);
        Ok(Self { store, memory, buffer, frame })
    }

    /// Has it take a frame, and puts its answer, without the length, into `answer`. It may take [`FUEL`] for each of `runs`.
    ///
    /// # Errors
    /// If it traps, takes too much, or answers with no frame. The instance is then not called again.
    pub fn exchange(
        &mut self,
        request: &[u8],
        runs: usize,
        answer: &mut Vec<u8>,
    ) -> Result<(), ProgramFault> {
        let place = self.call(request, runs)?;
        let garbage = |message: String| ProgramFault::new(FaultKind::Garbage, message);
        let memory = self.memory.data(&self.store);
        let outside = || garbage(format!("its answer is at {place}, where it has no memory"));
        let length = memory.get(place..).and_then(|rest| rest.first_chunk::<4>()).ok_or_else(outside)?;
        let size = u32::from_le_bytes(*length) as usize;
        if !(4..=wire::LONGEST).contains(&size) {
            return Err(garbage(format!("it answered with a frame of {size} bytes")));
        }
        let frame = memory.get(place + 4..place + 4 + size).ok_or_else(outside)?;
        answer.clear();
        answer.extend_from_slice(frame);
        Ok(())
    }

    /// Has it take a frame that is not answered.
    ///
    /// # Errors
    /// If it traps or takes too much.
    pub fn tell(&mut self, request: &[u8], runs: usize) -> Result<(), ProgramFault> {
        self.call(request, runs).map(drop)
    }

    /// Has it take a frame; gives the place of its answer.
    fn call(&mut self, request: &[u8], runs: usize) -> Result<usize, ProgramFault> {
        let failed = |error: Error| what_happened(&error, runs);
        let length = i32::try_from(request.len()).map_err(|_| {
            ProgramFault::new(
                FaultKind::Garbage,
                format!("a request of {} bytes has no place in it", request.len()),
            )
        })?;
        self.store.set_fuel(FUEL.saturating_mul(runs.max(1) as u64)).map_err(failed)?;
        let place = self.buffer.call(&mut self.store, length).map_err(failed)?;
        // Places are unsigned; WebAssembly's numbers have no sign of their own.
        let place = place as u32 as usize;
        self.memory.write(&mut self.store, place, request).map_err(|_| {
            let message =
                format!("its buffer of {length} bytes is at {place}, where it has not that much memory");
            ProgramFault::new(FaultKind::Garbage, message)
        })?;
        let answer = self.frame.call(&mut self.store, length).map_err(failed)?;
        Ok(answer as u32 as usize)
    }
}

/// Whether a file is a module in the text format: its first line that is not a comment opens a bracket.
fn is_text(bytes: &[u8]) -> bool {
    let is_code = |line: &&str| !line.is_empty() && !line.starts_with(";;");
    let first = |text: &str| {
        text.lines().map(str::trim_start).find(is_code).is_some_and(|line| line.starts_with('('))
    };
    std::str::from_utf8(bytes).is_ok_and(first)
}

/// What kept it from ending.
fn what_happened(error: &Error, runs: usize) -> ProgramFault {
    match error.as_trap_code() {
        Some(TrapCode::OutOfFuel) => {
            let most = FUEL / 1_000_000 * runs.max(1) as u64;
            ProgramFault::new(FaultKind::Timeout, format!("no answer within {most} million instructions"))
        }
        _ => ProgramFault::new(FaultKind::Exited, format!("it trapped: {}", one_line(&error.to_string()))),
    }
}
