//! Names that files define and where they are used: what editors ask to find references, to rename and to colour.

mod classes;
mod families;
mod references;
mod rename;
mod resolve;

pub use families::ScenarioFamilies;
pub use references::{NamedPlace, WorkspaceSymbol, references, workspace_symbols};
pub use rename::{FileEdit, Rename, rename, rename_place};
pub use resolve::Symbols;

pub use classes::SymbolKind;
