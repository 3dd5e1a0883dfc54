//! Pages of HTML that show a run, or several beside each other: verdicts, pictures, curves, settings and provenance.
//!
//! A page is one file. It is made from what `run.json` holds and from pictures. No script runs in it, so that it opens
//! anywhere, prints, and can be mailed. Colours follow the reader's light or dark preference.

mod averages;
pub mod chart;
mod compare;
mod curves;
mod elements;
mod facts;
mod next_steps;
mod poses;
mod run;
mod words;

pub use self::{
    compare::{ComparedRun, average, best, columns, compare},
    elements::Image,
    run::{Pictures, page},
};
