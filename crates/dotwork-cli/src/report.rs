//! What the user is told: errors and their exit codes, warnings, progress, a summary.

use std::collections::HashSet;
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use dotwork::{FileError, Warnings};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Work shorter than this shows no progress.
const PATIENCE: Duration = Duration::from_secs(1);

/// Why the command ends without success.
#[derive(Debug)]
pub enum Failure {
    /// The command was not understood: exit code 2.
    Usage(String),
    /// The run failed: exit code 1.
    Run(String),
    /// Whoever read the output has gone: no error.
    Closed,
}

impl Failure {
    /// Says why, in one line, and gives the exit code.
    pub fn exit(self) -> ExitCode {
        let (code, message) = match self {
            Failure::Usage(message) => (2, message),
            Failure::Run(message) => (1, message),
            Failure::Closed => return ExitCode::SUCCESS,
        };
        line(&message);
        ExitCode::from(code)
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Failure {
        match error {
            FileError::UnknownDemo { .. } => Failure::Usage(error.to_string()),
            FileError::Write(e) if e.kind() == io::ErrorKind::BrokenPipe => Failure::Closed,
            _ => Failure::Run(error.to_string()),
        }
    }
}

impl From<clap::Error> for Failure {
    /// The error in one line: clap's own message spreads over several, with usage and hints after it.
    fn from(error: clap::Error) -> Failure {
        let text = error.render().to_string();
        let text = text.strip_prefix("error: ").unwrap_or(&text);
        let message = text
            .lines()
            .take_while(|l| !l.starts_with("Usage:") && !l.starts_with("For more information"))
            .map(|l| l.trim().trim_start_matches("tip: "))
            .filter(|l| !l.is_empty())
            .collect::<Vec<_>>()
            .join("; ");
        if error.kind() == clap::error::ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
            return Failure::Usage("no command given; try dotwork --help".into());
        }
        Failure::Usage(format!("{}; try --help", message.replace(":;", ":")))
    }
}

/// Says what happens while the command runs.
pub struct Report {
    quiet: bool,
    terminal: bool,
    said: HashSet<String>,
}

impl Report {
    /// A report to standard error; `quiet` leaves out everything but errors.
    pub fn new(quiet: bool) -> Report {
        Report { quiet, terminal: io::stderr().is_terminal(), said: HashSet::new() }
    }

    /// Prints warnings about an input.
    pub fn warn(&mut self, input: Option<&Path>, warnings: &Warnings) {
        for warning in warnings.iter() {
            match input {
                Some(input) => self.warning(&format!("{}: {warning}", input.display())),
                None => self.warning(&warning.to_string()),
            }
        }
    }

    /// Prints a warning, unless it has been printed before.
    pub fn warning(&mut self, text: &str) {
        if !self.quiet && self.said.insert(text.to_string()) {
            line(&format!("warning: {text}"));
        }
    }

    /// Prints a result on standard output.
    pub fn say(&self, text: &str) -> Result<(), Failure> {
        if self.quiet { Ok(()) } else { print(&format!("{text}\n")) }
    }

    /// Prints a last line about what was done, for a person at a terminal.
    pub fn summary(&self, text: &str) {
        if !self.quiet && self.terminal {
            line(text);
        }
    }

    /// Runs `work`, which calls back with a share 0…1; shows a bar on a terminal once it has taken a second.
    pub fn progress<T>(&self, what: &'static str, work: impl FnOnce(&mut dyn FnMut(f32)) -> T) -> T {
        let start = Instant::now();
        let mut bar: Option<ProgressBar> = None;
        let result = work(&mut |share| {
            if self.quiet || !self.terminal || start.elapsed() < PATIENCE {
                return;
            }
            let bar = bar.get_or_insert_with(|| new_bar(what));
            bar.set_position((1000.0 * share) as u64);
        });
        if let Some(bar) = bar {
            bar.finish_and_clear();
        }
        result
    }
}

fn new_bar(what: &'static str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(1000), ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template("{msg} [{bar:40}] {percent:>3} %") {
        bar.set_style(style.progress_chars("=> "));
    }
    bar.with_message(what)
}

/// Prints text on standard output. A reader that has gone is no error.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(|e| match e.kind() {
        io::ErrorKind::BrokenPipe => Failure::Closed,
        _ => Failure::Run(format!("standard output: {e}")),
    })
}

/// One line on standard error, under the program's name. If even that cannot be written there is no one to tell.
fn line(text: &str) {
    // File names may hold line breaks.
    let text: String = text
        .chars()
        .flat_map(|c| if c.is_control() { c.escape_default().collect() } else { vec![c] })
        .collect();
    let _ = writeln!(io::stderr(), "dotwork: {text}");
}
