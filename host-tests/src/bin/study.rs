//! `cargo study`: the simulations, as tables on the screen and as CSV, SVG and PNG under `target/study/`.

use clap::Parser;
use host_tests::command_line;
use host_tests::study::{ALL, Plan, Problem, Study, output};
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

/// Do the simulations. Exit code: 0 all targets hold, 2 one misses, 1 a study could not be done.
#[derive(Parser)]
#[command(name = "cargo study", bin_name = "cargo study")]
struct Arguments {
    /// Which studies (see --list); all of them when none is named
    #[arg(value_name = "NAME")]
    names: Vec<String>,
    /// Trials of each study instead of its own number
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=100_000_000))]
    trials: Option<u64>,
    /// Seed of every random number
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Name the studies and end
    #[arg(long)]
    list: bool,
}

/// Where the files go: the workspace's target folder.
const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../target/study");

fn main() -> ExitCode {
    let arguments = command_line::parse::<Arguments>();
    if arguments.list {
        for study in ALL {
            println!("{:<12} {:>8}  {}", study.name, study.trials, study.about);
        }
        return ExitCode::SUCCESS;
    }
    if let Some(unknown) = arguments.names.iter().find(|name| ALL.iter().all(|study| study.name != **name)) {
        eprintln!("cargo study: no study is named {unknown}; --list names them");
        return ExitCode::FAILURE;
    }
    let mut all_hold = true;
    for study in
        ALL.iter().filter(|study| arguments.names.is_empty() || arguments.names.iter().any(|n| n == study.name))
    {
        match one(study, &arguments) {
            Ok(holds) => all_hold &= holds,
            Err(error) => {
                eprintln!("cargo study: {}: {error}", study.name);
                return ExitCode::FAILURE;
            }
        }
    }
    println!("files: target/study/");
    if all_hold { ExitCode::SUCCESS } else { ExitCode::from(2) }
}

/// Does one study; whether its targets hold.
fn one(study: &Study, arguments: &Arguments) -> Result<bool, Problem> {
    let plan = Plan { seed: arguments.seed, trials: arguments.trials.unwrap_or(study.trials) };
    println!("== {}: {} (seed {}, {} trials)", study.name, study.about, plan.seed, plan.trials);
    let begin = Instant::now();
    let findings = (study.run)(&plan)?;
    output::save(study, &plan, &findings, Path::new(FOLDER))?;
    println!("{}", output::text(&findings));
    // The time is no finding: it goes where it does not disturb a comparison.
    eprintln!("{} took {:.1} s", study.name, begin.elapsed().as_secs_f64());
    Ok(findings.targets.iter().all(|target| target.holds))
}
