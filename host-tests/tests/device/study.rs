//! The studies: the same findings on any number of cores, and the claims that a few hundred trials can check.

use host_tests::study::{ALL, Findings, Plan, Study, adversarial, output};

/// Everything that would be written or printed.
fn bytes(findings: &Findings) -> String {
    let charts: Vec<_> =
        findings.figures.iter().map(|(_, figure)| host_tests::plot::to_svg(figure.as_ref()).unwrap()).collect();
    let tables: Vec<_> = findings.tables.iter().map(|table| format!("{table:?}")).collect();
    format!("{}{}{}", output::text(findings), tables.join("\n"), charts.join("\n"))
}

fn study(name: &str) -> &'static Study {
    ALL.iter().find(|study| study.name == name).unwrap()
}

fn on_cores(cores: usize, study: &Study, plan: Plan) -> Findings {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(cores).build().unwrap();
    pool.install(|| (study.run)(&plan)).unwrap()
}

/// A few trials of each study: more would take minutes.
#[test]
fn every_study_finds_the_same_on_one_core_and_on_three() {
    let mut names: Vec<_> = ALL.iter().map(|study| study.name).collect();
    let mut files = Vec::new();
    for study in ALL {
        let trials = match study.name {
            "arm-boards" | "free-motion" | "arm-poses" => 2,
            _ => 4,
        };
        let plan = Plan { seed: 11, trials };
        let (one, three) = (on_cores(1, study, plan), on_cores(3, study, plan));
        assert!(bytes(&one) == bytes(&three), "{}", study.name);
        assert!(one.tables.iter().all(|table| !table.rows.is_empty()), "{}", study.name);
        for table in &one.tables {
            assert!(table.rows.iter().all(|row| row.len() == table.columns.len()), "{}", table.name);
            files.push(table.name);
        }
    }
    // No two studies and no two files have one name.
    for list in [&mut names, &mut files] {
        let all = list.len();
        list.sort_unstable();
        list.dedup();
        assert_eq!(list.len(), all);
    }
}

#[test]
fn another_seed_draws_other_sets() {
    let with = |seed| bytes(&on_cores(2, study("precision"), Plan { seed, trials: 60 }));
    assert_ne!(with(1), with(2));
}

/// A case can be looked into again by its seed and number alone.
#[test]
fn an_adversarial_case_is_the_same_every_time() {
    let (first, second) = (adversarial::case(3, 17).unwrap(), adversarial::case(3, 17).unwrap());
    assert_eq!(first.poses_mm, second.poses_mm);
    assert_eq!(first.description, second.description);
    assert_ne!(first.poses_mm, adversarial::case(3, 18).unwrap().poses_mm);
}

/// The targets that so few trials can tell; the rest belongs to `cargo study`.
#[test]
fn a_few_hundred_trials_meet_the_exact_targets() {
    for (name, trials) in [("million", 400), ("extremes", 400), ("degenerate", 60), ("adversarial", 200)] {
        let findings = on_cores(2, study(name), Plan { seed: 1, trials });
        let missed: Vec<_> = findings.targets.iter().filter(|target| !target.holds).collect();
        assert!(missed.is_empty(), "{name}: {missed:?}");
        assert!(!findings.targets.is_empty(), "{name}");
    }
}

#[test]
fn files_are_written_and_summed_up() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("study");
    let plan = Plan { seed: 1, trials: 30 };
    for name in ["success", "bound"] {
        output::save(study(name), &plan, &on_cores(2, study(name), plan), &folder).unwrap();
    }
    let read = |file: &str| std::fs::read_to_string(folder.join(file)).unwrap();
    assert!(read("success-3.csv").starts_with("base radius (mm),±5,"));
    assert_eq!(read("bound.csv").lines().count(), 1 + 8);
    assert!(read("success-plain-3.svg").starts_with("<svg"));
    assert!(folder.join("success-plain-3.png").exists());
    let summary = read("summary.md");
    let place = |name: &str| summary.find(&format!("## {name}")).unwrap();
    assert!(place("success") < place("bound"), "in the order of the list");
    assert!(summary.contains("`--seed 1 --trials 30`"));
}
