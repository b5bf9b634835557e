//! Output files: checked before the long work, written whole or not at all, whatever signal comes.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use dotwork::export::{check_writable, write_atomic};
use dotwork::{FileError, Format};

use crate::report::Failure;

/// Refuses an output that cannot be written, or that is one of the inputs.
pub fn check(output: &Path, inputs: &[PathBuf]) -> Result<(), Failure> {
    keep(inputs, output)?;
    check_writable(output).map_err(|e| Failure::from(FileError::from(e)))
}

/// Refuses an output that is one of the inputs, or a page of one that is a folder of TIFF files.
pub fn keep(inputs: &[PathBuf], output: &Path) -> Result<(), Failure> {
    let is = |a: &Path, b: &Path| a.canonicalize().is_ok_and(|a| b.canonicalize().is_ok_and(|b| a == b));
    let out = output.display();
    if let Some(input) = inputs.iter().find(|i| is(i, output)) {
        let input = input.display();
        return Err(Failure::Usage(format!("{out}: the output would overwrite the input {input}")));
    }
    let folder = match output.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    let page = |i: &&PathBuf| Format::of(output) == Some(Format::Tiff) && i.is_dir() && is(i, folder);
    if let Some(input) = inputs.iter().find(page) {
        let input = input.display();
        return Err(Failure::Usage(format!("{out}: the output would be a page of the input {input}")));
    }
    Ok(())
}

/// Writes a file through `write`. A signal that asks the program to end takes effect once nothing half-written can be
/// left behind.
pub fn write(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Failure> {
    let signal = signals::Pending::new();
    let result = write_atomic(path, |w| write(&mut Interruptible { inner: w, signal: &signal }));
    signal.obey();
    result.map_err(|e| Failure::from(FileError::from(e)))
}

/// Makes a write beyond the file-size limit (`ulimit -f`) an error instead of the end of the program.
pub fn survive_size_limits() {
    signals::survive_size_limits();
}

/// Does work that writes through what [`Signal::watch`] gives: a signal that asks the program to end takes effect once
/// it has come back.
pub fn interruptible<T>(work: impl FnOnce(&Signal) -> T) -> T {
    let signal = Signal(signals::Pending::new());
    let result = work(&signal);
    signal.0.obey();
    result
}

/// Knows whether the program has been asked to end.
pub struct Signal(signals::Pending);

impl Signal {
    /// A writer that refuses to go on once it has.
    pub fn watch<'a>(&'a self, inner: &'a mut dyn Write) -> impl Write + 'a {
        Interruptible { inner, signal: &self.0 }
    }
}

/// A writer that refuses to go on once a signal is pending.
struct Interruptible<'a> {
    inner: &'a mut dyn Write,
    signal: &'a signals::Pending,
}

impl Write for Interruptible<'_> {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        if self.signal.is_pending() {
            // Not ErrorKind::Interrupted, after which writers try again.
            return Err(io::Error::other("stopped by a signal"));
        }
        self.inner.write(buffer)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

#[cfg(unix)]
mod signals {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

    use signal_hook::consts::signal::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    use signal_hook::{flag, low_level};

    /// From its creation on, the signals that end a program are noted instead.
    pub struct Pending(Arc<AtomicUsize>);

    impl Pending {
        pub fn new() -> Pending {
            let number = Arc::new(AtomicUsize::new(0));
            for signal in [SIGHUP, SIGINT, SIGTERM] {
                // Without a handler the signal ends the program at once, as it did before.
                let _ = flag::register_usize(signal, number.clone(), signal as usize);
            }
            Pending(number)
        }

        pub fn is_pending(&self) -> bool {
            self.0.load(Ordering::Relaxed) != 0
        }

        /// Ends the program as the noted signal would have.
        pub fn obey(&self) {
            let signal = self.0.load(Ordering::Relaxed);
            if signal != 0 {
                let _ = low_level::emulate_default_handler(signal as i32);
            }
        }
    }

    pub fn survive_size_limits() {
        // With any handler in place the write returns an error, which is reported like every other.
        let _ = flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)));
    }
}

#[cfg(not(unix))]
mod signals {
    /// Nothing is noted here.
    pub struct Pending;

    impl Pending {
        pub fn new() -> Pending {
            Pending
        }

        pub fn is_pending(&self) -> bool {
            false
        }

        pub fn obey(&self) {}
    }

    pub fn survive_size_limits() {}
}
