//! Outputs that exist whole or not at all.
//!
//! The bytes go to a temporary file in the target's own folder (a rename is atomic only within one file system); the
//! data is synced and the file renamed over the target. Whatever fails before the rename leaves the old target as it
//! was and removes the temporary file. A symbolic link stays a link: the file it points to is replaced.
//!
//! Pipes, terminals and other targets that are no regular files cannot be renamed over; they are written straight.
//!
//! Limits: a kill by signal leaves the temporary file (`.dotwork-*.tmp`); hard links to the old file keep the old
//! content.

use std::fs::{self, File, OpenOptions, Permissions};
use std::io::{self, BufWriter, Write};
use std::path::{MAIN_SEPARATOR, Path, PathBuf};

use tempfile::NamedTempFile;

use crate::error::ExportError;

/// Encoders write numbers and chunks of some bytes; the system should see large blocks.
const BUFFER_BYTES: usize = 1 << 17;

/// As many symbolic links in a row as Linux follows.
const MAX_LINKS: usize = 40;

/// Names of standard output.
const STDOUT: [&str; 3] = ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"];

/// Names of other open files.
const DESCRIPTORS: [&str; 3] = ["/dev/stderr", "/dev/fd", "/proc/self/fd"];

/// Writes a file through `write`, all of it or nothing.
///
/// A new file gets the permissions that any new file gets (0666 without the umask's bits); an old one keeps its mode.
/// An existing target that is no regular file (a pipe, a terminal, `/dev/stdout`) is written straight.
///
/// # Errors
/// [`ExportError`] if the target is a folder, its folder does not exist, the system refuses (no permission, disk full)
/// or `write` fails. The old target is then intact and no temporary file is left; only what is written straight may
/// have been written in part.
pub fn write_atomic(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), ExportError> {
    let io_error = |source| ExportError::Io { path: path.to_owned(), source };
    match Target::find(path)? {
        Target::Straight(Stream::Stdout) => buffered(io::stdout().lock(), write).map_err(io_error),
        Target::Straight(Stream::Existing) => {
            // Appending suits streams, and keeps what a redirected shell has already written.
            let file = OpenOptions::new().append(true).open(path).map_err(io_error)?;
            buffered(file, write).map_err(io_error)
        }
        Target::File { file, folder, old } => {
            let mut temporary = temporary_in(&folder).map_err(io_error)?;
            buffered(temporary.as_file_mut(), write).map_err(io_error)?;
            if let Some(old) = old {
                keep_mode(temporary.as_file(), old).map_err(io_error)?;
            }
            temporary.as_file().sync_data().map_err(io_error)?;
            temporary.persist(file).map_err(|e| io_error(e.error))?;
            Ok(())
        }
    }
}

/// Fails where [`write_atomic`] would fail before its first byte; to be called before long work. Nothing changes.
///
/// # Errors
/// [`ExportError`] if the target is a folder or cannot be written, or if no file can be created in its folder.
pub fn check_writable(path: &Path) -> Result<(), ExportError> {
    match Target::find(path)? {
        // Opening a pipe may wait for its reader: that is left to the writing.
        Target::Straight(_) => Ok(()),
        Target::File { folder, .. } => match temporary_in(&folder) {
            Ok(_removed_on_drop) => Ok(()),
            Err(source) => Err(ExportError::Io { path: path.to_owned(), source }),
        },
    }
}

/// Where the bytes go.
enum Target {
    /// A regular file, present (then with its permissions) or to be made; its folder exists.
    File { file: PathBuf, folder: PathBuf, old: Option<Permissions> },
    /// Something that cannot be replaced.
    Straight(Stream),
}

enum Stream {
    /// Standard output by name: the descriptor itself, since a socket cannot be opened again and a redirected file
    /// opened twice has two positions.
    Stdout,
    /// Any other existing target that is no regular file.
    Existing,
}

impl Target {
    /// Resolves links and classes the target.
    fn find(path: &Path) -> Result<Target, ExportError> {
        let io_error = |source| ExportError::Io { path: path.to_owned(), source };
        let is_folder = || ExportError::IsFolder { path: path.to_owned() };
        if cfg!(unix) && STDOUT.iter().any(|name| path == Path::new(name)) {
            return Ok(Target::Straight(Stream::Stdout));
        }
        let old = match fs::metadata(path) {
            Ok(old) if old.is_dir() => return Err(is_folder()),
            Ok(old) if !old.is_file() => return Ok(Target::Straight(Stream::Existing)),
            // Behind a descriptor's name may lie a regular file, but its name is not ours to replace.
            Ok(_) if cfg!(unix) && DESCRIPTORS.iter().any(|name| path.starts_with(name)) => {
                return Ok(Target::Straight(Stream::Existing));
            }
            Ok(old) => {
                // A rename would replace a file that forbids writing.
                OpenOptions::new().write(true).open(path).map_err(io_error)?;
                Some(old.permissions())
            }
            Err(e) if e.kind() == io::ErrorKind::NotFound => None,
            Err(e) => return Err(io_error(e)),
        };
        let file = follow_links(path).map_err(io_error)?;
        if file.as_os_str().is_empty() {
            return Err(io_error(io::Error::new(io::ErrorKind::InvalidInput, "the path is empty")));
        }
        let ends_like_folder = path
            .as_os_str()
            .as_encoded_bytes()
            .last()
            .is_some_and(|&b| b == b'/' || b == MAIN_SEPARATOR as u8);
        if ends_like_folder || file.file_name().is_none() {
            return Err(is_folder());
        }
        let folder = match file.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
            _ => PathBuf::from("."),
        };
        match fs::metadata(&folder) {
            Ok(_) => Ok(Target::File { file, folder, old }),
            Err(e) if e.kind() == io::ErrorKind::NotFound => {
                Err(ExportError::NoFolder { path: path.to_owned(), folder })
            }
            Err(e) => Err(io_error(e)),
        }
    }
}

/// The path behind a chain of symbolic links, the last of which may point to a file that does not exist yet.
fn follow_links(path: &Path) -> io::Result<PathBuf> {
    let mut file = path.to_owned();
    for _ in 0..MAX_LINKS {
        match fs::symlink_metadata(&file) {
            Ok(metadata) if metadata.is_symlink() => {
                let target = fs::read_link(&file)?;
                // Links are relative to the folder that holds them; an absolute target replaces the whole path.
                file.pop();
                file.push(target);
            }
            _ => return Ok(file),
        }
    }
    Err(io::Error::other("too many symbolic links"))
}

fn temporary_in(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".dotwork-").suffix(".tmp");
    // The default 0600 hides temporary files from others, but this one becomes an ordinary file. The umask applies.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder).map_err(|e| match e.raw_os_error() {
        // The crate adds the temporary path to the message, which would name a file that nobody asked for.
        None => io::Error::new(e.kind(), system_message(&e)),
        Some(_) => e,
    })
}

/// The message of the innermost error.
fn system_message(e: &io::Error) -> String {
    let mut inner: &dyn std::error::Error = e;
    while let Some(source) = inner.source() {
        inner = source;
    }
    inner.to_string()
}

/// Gives `file` the permission bits of `old`; elsewhere than on Unix nothing is to be kept, since the target was
/// writable.
#[cfg_attr(not(unix), allow(unused_variables, reason = "modes are a Unix notion"))]
fn keep_mode(file: &File, old: Permissions) -> io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = old.mode() & 0o777;
        if file.metadata()?.permissions().mode() & 0o777 != mode {
            file.set_permissions(Permissions::from_mode(mode))?;
        }
    }
    Ok(())
}

fn buffered<W: Write>(inner: W, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut writer = BufWriter::with_capacity(BUFFER_BYTES, inner);
    let result = write(&mut writer).and_then(|()| writer.flush());
    // What a failed write left in the buffer is not written by the buffer's drop.
    drop(writer.into_parts());
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names_in(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn writes_and_replaces_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.txt");
        for text in ["first", "second, longer", "3"] {
            check_writable(&path).unwrap();
            write_atomic(&path, |w| w.write_all(text.as_bytes())).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
            assert_eq!(names_in(folder.path()), ["out.txt"]);
        }
    }

    #[test]
    fn a_failure_half_way_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.txt");
        let fail = |w: &mut dyn Write| {
            w.write_all(&vec![b'x'; 3 * BUFFER_BYTES])?;
            Err(io::Error::new(io::ErrorKind::InvalidData, "half way"))
        };
        let error = write_atomic(&path, fail).unwrap_err();
        assert_eq!(error.to_string(), format!("{}: half way", path.display()));
        assert!(names_in(folder.path()).is_empty());
        fs::write(&path, "old").unwrap();
        write_atomic(&path, fail).unwrap_err();
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names_in(folder.path()), ["out.txt"]);
    }

    #[test]
    fn a_panic_half_way_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.txt");
        let caught = std::panic::catch_unwind(|| write_atomic(&path, |_| panic!("expected by the test")));
        assert!(caught.is_err());
        assert!(names_in(folder.path()).is_empty());
    }

    #[test]
    fn checking_changes_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.txt");
        check_writable(&path).unwrap();
        assert!(names_in(folder.path()).is_empty());
        fs::write(&path, "old").unwrap();
        check_writable(&path).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    }

    /// Both functions must refuse `path`, and the closure must not run.
    fn refused(path: &Path) -> ExportError {
        let early = check_writable(path).unwrap_err();
        let late = write_atomic(path, |_| panic!("nothing may be written")).unwrap_err();
        assert_eq!(early.to_string(), late.to_string());
        assert!(early.to_string().starts_with(&format!("{}: ", path.display())), "{early}");
        assert_eq!(early.to_string().lines().count(), 1, "{early}");
        early
    }

    #[test]
    fn folders_and_missing_folders_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let dir = folder.path();
        assert!(matches!(refused(dir), ExportError::IsFolder { .. }));
        assert!(matches!(refused(&dir.join("new/")), ExportError::IsFolder { .. }));
        assert!(matches!(refused(&dir.join("..")), ExportError::IsFolder { .. }));
        match refused(&dir.join("no/such/out.png")) {
            ExportError::NoFolder { folder, .. } => assert_eq!(folder, dir.join("no/such")),
            other => panic!("{other:?}"),
        }
        assert_eq!(refused(Path::new("")).to_string(), ": the path is empty");
        assert_eq!(refused(&dir.join("n".repeat(5000))).kind(), io::ErrorKind::InvalidFilename);
        fs::write(dir.join("file"), "").unwrap();
        assert!(matches!(refused(&dir.join("file/out.png")), ExportError::Io { .. }));
        assert_eq!(names_in(dir), ["file"]);
    }

    #[cfg(unix)]
    mod unix {
        use super::*;
        use std::os::unix::fs::{PermissionsExt, symlink};

        fn mode(path: &Path) -> u32 {
            fs::metadata(path).unwrap().permissions().mode() & 0o777
        }

        #[test]
        fn modes_are_ordinary_and_kept() {
            let folder = tempfile::tempdir().unwrap();
            let (ours, plain) = (folder.path().join("ours"), folder.path().join("plain"));
            File::create(&plain).unwrap();
            write_atomic(&ours, |_| Ok(())).unwrap();
            assert_eq!(mode(&ours), mode(&plain));
            for kept in [0o600, 0o640, 0o666, 0o755] {
                fs::set_permissions(&ours, Permissions::from_mode(kept)).unwrap();
                write_atomic(&ours, |w| w.write_all(b"new")).unwrap();
                assert_eq!(mode(&ours), kept);
            }
        }

        #[test]
        fn an_unwritable_folder_is_refused() {
            let folder = tempfile::tempdir().unwrap();
            let closed = folder.path().join("closed");
            fs::create_dir(&closed).unwrap();
            fs::set_permissions(&closed, Permissions::from_mode(0o555)).unwrap();
            // The superuser may write to any ordinary folder, but not to the kernel's.
            let superuser = File::create(closed.join("probe")).is_ok();
            let closed = if superuser { PathBuf::from("/sys") } else { closed };
            let error = refused(&closed.join("out.png"));
            assert_eq!(error.kind(), io::ErrorKind::PermissionDenied);
            assert!(error.to_string().ends_with(": no permission to write here"), "{error}");
        }

        #[test]
        fn links_stay_links() {
            let folder = tempfile::tempdir().unwrap();
            let dir = folder.path();
            fs::create_dir(dir.join("sub")).unwrap();
            let link = dir.join("link");
            symlink("sub/hop", &link).unwrap();
            symlink("real", dir.join("sub/hop")).unwrap();
            // First the chain dangles, then it ends at a file.
            for text in ["one", "two"] {
                check_writable(&link).unwrap();
                write_atomic(&link, |w| w.write_all(text.as_bytes())).unwrap();
                assert_eq!(fs::read_to_string(dir.join("sub/real")).unwrap(), text);
                assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
                assert_eq!(names_in(&dir.join("sub")), ["hop", "real"]);
            }
            symlink("round", dir.join("round")).unwrap();
            refused(&dir.join("round"));
        }

        #[test]
        fn devices_are_written_straight() {
            check_writable(Path::new("/dev/null")).unwrap();
            write_atomic(Path::new("/dev/null"), |w| w.write_all(b"gone")).unwrap();
            assert!(!fs::metadata("/dev/null").unwrap().is_file());
        }

        /// Runs the test `name` of this binary again under a shell line, with `path` as its order to act.
        fn again(shell: &str, name: &str, path: &Path) -> std::process::Output {
            let output = std::process::Command::new("sh")
                .args(["-c", shell])
                .arg(std::env::current_exe().unwrap())
                .args(["--exact", &format!("atomic::tests::unix::{name}"), "--nocapture"])
                .env("DOTWORK_EXPORT_TEST_PATH", path)
                .output()
                .unwrap();
            assert!(output.status.success(), "{output:?}");
            assert!(String::from_utf8_lossy(&output.stdout).contains("1 passed"), "{output:?}");
            output
        }

        /// The order, in the inner run.
        fn order() -> Option<PathBuf> {
            std::env::var_os("DOTWORK_EXPORT_TEST_PATH").map(PathBuf::from)
        }

        #[test]
        fn a_file_size_limit_is_an_error() {
            if let Some(path) = order() {
                let error = write_atomic(&path, |w| w.write_all(&vec![0; 1 << 20])).unwrap_err();
                assert_eq!(error.kind(), io::ErrorKind::FileTooLarge);
                return;
            }
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("out.txt");
            fs::write(&path, "old").unwrap();
            // An ignored signal stays ignored in the program that takes the shell's place.
            let shell = "trap '' XFSZ; ulimit -f 16; exec \"$0\" \"$@\"";
            again(shell, "a_file_size_limit_is_an_error", &path);
            assert_eq!(fs::read_to_string(&path).unwrap(), "old");
            assert_eq!(names_in(folder.path()), ["out.txt"]);
        }

        #[test]
        fn standard_output_is_written_straight() {
            if let Some(path) = order() {
                check_writable(&path).unwrap();
                return write_atomic(&path, |w| w.write_all(b"<drawing>")).unwrap();
            }
            // Into a file that already holds something: it may be neither replaced nor cut.
            let shell =
                r#"f=$(mktemp); printf before >"$f"; "$0" "$@" >>"$f"; s=$?; cat "$f"; rm "$f"; exit $s"#;
            let output = again(shell, "standard_output_is_written_straight", Path::new("/dev/stdout"));
            let text = String::from_utf8(output.stdout).unwrap();
            assert!(text.starts_with("before") && text.contains("<drawing>"), "{text}");
        }

        #[cfg(target_os = "linux")]
        #[test]
        fn a_full_disk_is_an_error() {
            let error = write_atomic(Path::new("/dev/full"), |w| w.write_all(b"x")).unwrap_err();
            assert_eq!(error.to_string(), "/dev/full: the disk is full");
        }
    }
}
