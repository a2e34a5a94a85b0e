//! `cargo power-cut`: cuts the power in the middle of every flash operation of a store, over and over.

use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;
use host_tests::command_line;
use host_tests::flash::TornWord;
use host_tests::power_cut::{
    Entries, OnePage, ParameterPages, Scheme, Tally, TwoPages, WithoutCommit, cut_everywhere, random_life,
};
use rayon::prelude::*;

/// Cut the power in the middle of every word write and page erase of a store, and again in the recovery.
#[derive(Parser)]
#[command(name = "cargo power-cut", bin_name = "cargo power-cut")]
struct Arguments {
    /// Histories, each cut everywhere, for each of the four ways in which torn words may read
    #[arg(long, value_name = "N", default_value_t = 60)]
    histories: u64,
    /// Long random lives of 1000 stores, likewise
    #[arg(long, value_name = "N", default_value_t = 8)]
    lives: u64,
    /// Seed of the first history
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Stores in a long life.
const STORES: u32 = 1_000;

fn main() -> ExitCode {
    let arguments = command_line::parse::<Arguments>();
    let began = Instant::now();
    println!("torn words read as\n");
    let record = run::<TwoPages>("the record: two pages and a commit word", &arguments);
    let parameters = run::<ParameterPages>("the parameters: likewise, of five times the length", &arguments);
    let journal = run::<Entries>("the journal: entries appended in two pages", &arguments);
    let one_page = run::<OnePage>("control: one page, erased and written in place", &arguments);
    let without = run::<WithoutCommit>("control: two pages without a commit word", &arguments);
    for (name, tally) in [("the record", record), ("the parameters", parameters), ("the journal", journal)] {
        println!("{} cuts while storing {name}, {} failures", tally.cuts(), tally.failures());
    }
    println!("{:.1} s", began.elapsed().as_secs_f32());
    if one_page.failures() == 0 || without.failures() == 0 {
        eprintln!("cargo power-cut: a control did not fail: the experiment proves nothing");
        return ExitCode::FAILURE;
    }
    let failures = record.failures() + parameters.failures() + journal.failures();
    if failures == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn run<S: Scheme>(name: &str, arguments: &Arguments) -> Tally {
    println!("{name}");
    let sum = |parts: Vec<Tally>| {
        parts.into_iter().fold(Tally::default(), |mut sum, part| {
            sum += part;
            sum
        })
    };
    let seeds = |count| (arguments.seed..arguments.seed.saturating_add(count)).into_par_iter();
    let mut all = Tally::default();
    for torn in TornWord::ALL {
        let mut tally = sum(seeds(arguments.histories).map(|seed| cut_everywhere::<S>(torn, seed)).collect());
        tally += sum(seeds(arguments.lives).map(|seed| random_life::<S>(torn, seed, STORES)).collect());
        println!("  {:<12} {tally}", format!("{torn:?}"));
        all += tally;
    }
    println!();
    all
}
