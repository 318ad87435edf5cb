//! What lies in the repository beside the program: pages, examples, colours, the house itself, texts that are right and wrong.

mod circles;
mod data;
mod doc_examples;
mod examples;
mod fuzz;
#[path = "../support/generated.rs"]
mod generated;
mod highlighting;
mod house;
mod language;
mod metrics_page;
mod model_pages;
#[path = "../../fuzz/properties.rs"]
mod properties;
mod reference_pages;
