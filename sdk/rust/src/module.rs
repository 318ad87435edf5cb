//! A controller as a WebAssembly module: the same conversation, in memory that the runner reads and writes.

use serde_json::Value;

use crate::{wire, About, Controller, Conversation};

/// What [`module!`](crate::module!) keeps. A request that is none of the protocol is a panic, which is a trap in a module.
#[doc(hidden)]
pub struct Module<C> {
    about: About,
    request: Vec<u8>,
    /// From the runner's hello on.
    conversation: Option<Conversation<C>>,
}

impl<C: Controller> Module<C> {
    /// Before the hello.
    pub fn new(about: About) -> Self {
        Self { about, request: Vec::new(), conversation: None }
    }

    /// A place for a frame of so many bytes.
    pub fn buffer(&mut self, bytes: usize) -> &mut [u8] {
        self.request.resize(bytes, 0);
        &mut self.request
    }

    /// The answer to the frame that stands in that place, with its length; the answer before it where there is none.
    pub fn frame(&mut self, length: usize) -> &[u8] {
        let frame = &self.request[4..length];
        match &mut self.conversation {
            Some(conversation) => {
                conversation.reply(frame).expect("a request of the protocol");
            }
            none => {
                let greeting: Value = serde_json::from_slice(&frame[4..]).expect("a hello");
                let (mut conversation, hello) = Conversation::begin(&self.about, &greeting);
                wire::text(&hello, &mut conversation.answer);
                *none = Some(conversation);
            }
        }
        self.conversation.as_ref().map_or(&[], |conversation| &conversation.answer)
    }
}

/// Exports a [`Controller`] from a WebAssembly module, with what the runner is told of it: `module!(Brake, about())`. Nothing where
/// it is built for something else. The module is a `cdylib`, built for `wasm32-unknown-unknown`.
#[macro_export]
macro_rules! module {
    ($controller:ty, $about:expr) => {
        #[cfg(target_family = "wasm")]
        const _: () = {
            thread_local! {
                static MODULE: std::cell::RefCell<$crate::Module<$controller>> =
                    std::cell::RefCell::new($crate::Module::new($about));
            }

            #[no_mangle]
            extern "C" fn buffer(bytes: i32) -> i32 {
                MODULE.with(|module| module.borrow_mut().buffer(bytes as usize).as_mut_ptr() as i32)
            }

            #[no_mangle]
            extern "C" fn frame(length: i32) -> i32 {
                MODULE.with(|module| module.borrow_mut().frame(length as usize).as_ptr() as i32)
            }
        };
    };
}
