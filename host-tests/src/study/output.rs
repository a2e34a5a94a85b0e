//! Findings to files and to the screen.

use super::findings::{Findings, Plan, Problem, Table, Target};
use super::{ALL, Study};
use crate::plot;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// Writes everything under `folder`: a CSV file for each table, SVG and PNG for each chart, `<name>.md`, and
/// `summary.md` with all studies that have been done there.
///
/// # Errors
/// What could not be made or written.
pub fn save(study: &Study, plan: &Plan, findings: &Findings, folder: &Path) -> Result<(), Problem> {
    fs::create_dir_all(folder).map_err(|error| Problem::Writing(folder.to_path_buf(), error))?;
    for table in &findings.tables {
        write(folder.join(format!("{}.csv", table.name)), &csv(table))?;
    }
    for (name, figure) in &findings.figures {
        plot::save(figure.as_ref(), &folder.join(name))?;
    }
    write(folder.join(format!("{}.md", study.name)), &markdown(study, plan, findings))?;
    let done = ALL.iter().filter_map(|study| fs::read_to_string(folder.join(format!("{}.md", study.name))).ok());
    write(folder.join("summary.md"), &done.collect::<Vec<_>>().join("\n"))
}

fn write(path: PathBuf, text: &str) -> Result<(), Problem> {
    fs::write(&path, text).map_err(|error| Problem::Writing(path, error))
}

/// The findings as a person reads them on a screen.
pub fn text(findings: &Findings) -> String {
    let mut text = String::new();
    for table in findings.tables.iter().filter(|table| table.printed) {
        let _ = writeln!(text, "\n{}\n{}", table.title, aligned(table));
    }
    for remark in &findings.remarks {
        let _ = writeln!(text, "{remark}");
    }
    for Target { what, limit, measured, holds } in &findings.targets {
        let verdict = if *holds { "holds" } else { "MISSES" };
        let _ = writeln!(text, "target {what}: {limit}; measured {measured}: {verdict}");
    }
    text
}

/// Columns padded to their widest cell, all but the first flush right.
fn aligned(table: &Table) -> String {
    let header: Vec<String> = table.columns.iter().map(ToString::to_string).collect();
    let lines = || std::iter::once(&header).chain(&table.rows);
    let wide = |column: usize| lines().filter_map(|row| row.get(column)).map(|c| c.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..header.len()).map(wide).collect();
    let mut text = String::new();
    for line in lines() {
        for (column, (cell, width)) in line.iter().zip(&widths).enumerate() {
            let _ = if column == 0 { write!(text, "  {cell:<width$}") } else { write!(text, "  {cell:>width$}") };
        }
        text.truncate(text.trim_end().len());
        text.push('\n');
    }
    text.pop();
    text
}

fn csv(table: &Table) -> String {
    let mut text = String::new();
    let header: Vec<String> = table.columns.iter().map(ToString::to_string).collect();
    for row in std::iter::once(&header).chain(&table.rows) {
        let cells: Vec<_> = row.iter().map(|cell| quoted(cell)).collect();
        let _ = writeln!(text, "{}", cells.join(","));
    }
    text
}

/// A cell as RFC 4180 wants it.
fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n']) { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell.to_string() }
}

fn markdown(study: &Study, plan: &Plan, findings: &Findings) -> String {
    let mut text = format!("## {}: {}\n\n", study.name, study.about);
    let _ = writeln!(text, "{}\n\n`--seed {} --trials {}`", findings.method, plan.seed, plan.trials);
    for table in findings.tables.iter().filter(|table| table.printed) {
        let _ = writeln!(text, "\n{}:\n", table.title);
        let _ = writeln!(text, "| {} |", table.columns.join(" | "));
        let _ = writeln!(text, "|{}", " --- |".repeat(table.columns.len()));
        for row in &table.rows {
            let _ = writeln!(text, "| {} |", row.join(" | "));
        }
    }
    if !findings.remarks.is_empty() {
        text.push('\n');
    }
    for remark in &findings.remarks {
        let _ = writeln!(text, "- {remark}");
    }
    for (name, _) in &findings.figures {
        let _ = writeln!(text, "\n![{name}]({name}.svg)");
    }
    if !findings.targets.is_empty() {
        let _ = writeln!(text, "\n| target | limit | measured | |\n| --- | --- | --- | --- |");
        for Target { what, limit, measured, holds } in &findings.targets {
            let verdict = if *holds { "holds" } else { "**misses**" };
            let _ = writeln!(text, "| {what} | {limit} | {measured} | {verdict} |");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let mut table = Table::new("t", "T", &["name", "count"]);
        table.push(["a, \"b\"".to_string(), "7".to_string()]);
        table
    }

    #[test]
    fn a_cell_with_commas_and_quotes_survives_csv() {
        assert_eq!(csv(&table()), "name,count\n\"a, \"\"b\"\"\",7\n");
    }

    #[test]
    fn columns_are_aligned() {
        assert_eq!(aligned(&table()), "  name    count\n  a, \"b\"      7");
    }
}
