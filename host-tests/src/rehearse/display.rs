//! Progress for the person who waits: bars on a terminal, plain lines elsewhere, nothing for a program.
//!
//! All of it goes to stderr; stdout is for the result.

use indicatif::{MultiProgress, ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::time::Duration;

/// How progress is shown.
#[derive(Debug, Clone)]
pub enum Display {
    /// Moving bars, on a terminal.
    Bars(MultiProgress),
    /// A line when a stage begins and when it ends.
    Lines,
    /// Nothing.
    Silent,
}

/// Width of the stage's title.
const TITLE: usize = 22;

impl Display {
    /// Bars when stderr is a terminal, lines when it is not, silence there when the output is for a program.
    pub fn choose(for_program: bool) -> Self {
        match (std::io::stderr().is_terminal(), for_program) {
            (true, _) => Self::Bars(MultiProgress::new()),
            (false, false) => Self::Lines,
            (false, true) => Self::Silent,
        }
    }

    /// Begins a stage without a measure of its length.
    pub fn stage(&self, title: &str) -> Stage {
        let bar = self.add(ProgressBar::new_spinner(), "  {spinner} {prefix} {wide_msg}", title);
        if let Some(bar) = &bar {
            bar.enable_steady_tick(Duration::from_millis(100));
        }
        self.begin(title, None, bar)
    }

    /// Begins a stage of `length` steps.
    pub fn counted(&self, title: &str, length: u64) -> Stage {
        let bar = self.add(ProgressBar::new(length), "  {spinner} {prefix} [{bar:30}] {pos}/{len} {wide_msg}", title);
        self.begin(title, Some(length), bar)
    }

    fn add(&self, bar: ProgressBar, template: &str, title: &str) -> Option<ProgressBar> {
        let Self::Bars(all) = self else { return None };
        let bar = all.add(bar);
        let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_spinner());
        bar.set_style(style.progress_chars("=> "));
        bar.set_prefix(format!("{title:TITLE$}"));
        Some(bar)
    }

    fn begin(&self, title: &str, length: Option<u64>, bar: Option<ProgressBar>) -> Stage {
        let lines = matches!(self, Self::Lines);
        if lines {
            match length {
                Some(length) => eprintln!("  {title:TITLE$} {length} to do"),
                None => eprintln!("  {title:TITLE$} ..."),
            }
        }
        // A quarter of the way is worth a line.
        let stride = length.map_or(u64::MAX, |length| length.div_ceil(4).max(1));
        Stage { title: title.to_string(), lines, stride, bar }
    }
}

/// One stage under way. Dropped without [`done`](Self::done), it is shown as broken off.
#[derive(Debug)]
pub struct Stage {
    title: String,
    lines: bool,
    stride: u64,
    bar: Option<ProgressBar>,
}

impl Stage {
    /// So many steps are done; `text` says what is worth knowing about them.
    pub fn reached(&self, steps: u64, text: &str) {
        if let Some(bar) = &self.bar {
            bar.set_position(steps);
            bar.set_message(text.to_string());
        } else if self.lines && steps.is_multiple_of(self.stride) {
            eprintln!("  {:TITLE$} {steps} {text}", self.title);
        }
    }

    /// The stage is over and well; `text` sums it up.
    pub fn done(mut self, text: &str) {
        self.end("✓", text);
    }

    fn end(&mut self, sign: &str, text: &str) {
        if let Some(bar) = self.bar.take() {
            // The finished stage keeps its line, without bar or spinner.
            if let Ok(style) = ProgressStyle::with_template(&format!("  {sign} {{prefix}} {{wide_msg}}")) {
                bar.set_style(style);
            }
            bar.finish_with_message(text.to_string());
        } else if self.lines {
            self.lines = false;
            eprintln!("  {:TITLE$} {sign} {text}", self.title);
        }
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        self.end("✗", "not finished");
    }
}
