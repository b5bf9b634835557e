//! What the user is told: errors and their exit codes, warnings, progress, a summary.

use std::collections::HashSet;
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::process::ExitCode;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use dotwork::{FileError, Warnings, Watch};
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
    bar: Bar,
}

impl Report {
    /// A report to standard error; `quiet` leaves out everything but errors.
    pub fn new(quiet: bool) -> Report {
        let terminal = io::stderr().is_terminal();
        Report { quiet, terminal, said: HashSet::new(), bar: Bar::new(!quiet && terminal) }
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
            self.bar.wipe();
            line(&format!("warning: {text}"));
        }
    }

    /// Prints a result on standard output.
    pub fn say(&self, text: &str) -> Result<(), Failure> {
        self.bar.wipe();
        if self.quiet { Ok(()) } else { print(&format!("{text}\n")) }
    }

    /// Prints a last line about what was done, for a person at a terminal.
    pub fn summary(&self, text: &str) {
        if !self.quiet && self.terminal {
            self.bar.wipe();
            line(text);
        }
    }

    /// Runs `work`, which calls back with a share 0…1; shows a bar on a terminal once it has taken a second.
    pub fn progress<T>(&self, what: &'static str, work: impl FnOnce(&mut dyn FnMut(f32)) -> T) -> T {
        self.bar.show(what, 0.0);
        let result = work(&mut |share| self.bar.show(what, share));
        self.bar.rest();
        result
    }

    /// Shows how far reading is as [`Report::progress`] does, until [`Report::rest`].
    pub fn watch(&self) -> Watch {
        let bar = self.bar.clone();
        Watch::new(move |stage, share| bar.show(stage.name(), share))
    }

    /// Nothing takes time any more.
    pub fn rest(&self) {
        self.bar.rest();
    }
}

/// An error is told where no bar stands.
impl Drop for Report {
    fn drop(&mut self) {
        self.bar.rest();
    }
}

/// How often a bar looks whether the time has come to be shown.
const LOOK: Duration = Duration::from_millis(100);

/// A bar on standard error that shows itself once work has taken a second, whether or not the work calls back.
#[derive(Clone)]
struct Bar(Option<Arc<Mutex<Work>>>);

/// What is at work.
struct Work {
    /// Since when; `None`: nothing is.
    since: Option<Instant>,
    /// The stage and the share of it that is done; 0 where that is not known.
    at: (&'static str, f32),
    shown: Option<ProgressBar>,
}

impl Bar {
    /// A bar, or none.
    fn new(wanted: bool) -> Bar {
        Bar(wanted.then(|| {
            let work = Arc::new(Mutex::new(Work { since: None, at: ("", 0.0), shown: None }));
            let watched = Arc::downgrade(&work);
            // A file is read in one go, without a word.
            std::thread::spawn(move || {
                while let Some(work) = watched.upgrade() {
                    lock(&work).update();
                    drop(work);
                    std::thread::sleep(LOOK);
                }
            });
            work
        }))
    }

    fn show(&self, stage: &'static str, share: f32) {
        if let Some(mut work) = self.0.as_deref().map(lock) {
            work.since.get_or_insert_with(Instant::now);
            work.at = (stage, share);
            // What has just begun is shown by the thread: most stages are over in no time.
            if work.shown.is_some() && share > 0.0 {
                work.update();
            }
        }
    }

    /// Makes room for a line.
    fn wipe(&self) {
        if let Some(bar) = self.0.as_deref().and_then(|work| lock(work).shown.take()) {
            bar.finish_and_clear();
        }
    }

    fn rest(&self) {
        self.wipe();
        if let Some(mut work) = self.0.as_deref().map(lock) {
            work.since = None;
        }
    }
}

impl Work {
    fn update(&mut self) {
        if self.since.is_none_or(|since| since.elapsed() < PATIENCE) {
            return;
        }
        let (stage, share) = self.at;
        let bar = self
            .shown
            .get_or_insert_with(|| ProgressBar::with_draw_target(Some(1000), ProgressDrawTarget::stderr()));
        if bar.message() != stage || (bar.position() == 0) != (share <= 0.0) {
            let template = if share > 0.0 { "{msg:9} [{bar:40}] {percent:>3} %" } else { "{msg:9} …" };
            if let Ok(style) = ProgressStyle::with_template(template) {
                bar.set_style(style.progress_chars("=> "));
            }
            bar.set_message(stage);
        }
        bar.set_position((1000.0 * share).ceil() as u64);
    }
}

/// A state that a panic left behind is still one to show.
fn lock(work: &Mutex<Work>) -> MutexGuard<'_, Work> {
    work.lock().unwrap_or_else(PoisonError::into_inner)
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
