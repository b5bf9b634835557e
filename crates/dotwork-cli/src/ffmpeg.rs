//! Films in MP4 and WebM, packed by ffmpeg where it is installed.

use std::io::{self, Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use dotwork::FilmFormat;

use crate::output;
use crate::report::Failure;

/// The program.
const PROGRAM: &str = "ffmpeg";

/// ffmpeg, found.
pub struct Ffmpeg(());

impl Ffmpeg {
    /// Looks for ffmpeg before the long work.
    pub fn find() -> Result<Ffmpeg, Failure> {
        let found =
            Command::new(PROGRAM).arg("-version").stdout(Stdio::null()).stderr(Stdio::null()).status();
        match found {
            Ok(status) if status.success() => Ok(Ffmpeg(())),
            _ => Err(Failure::Run(
                "ffmpeg, which packs .mp4 and .webm, is not installed; write a .gif or .png, or frames \
                 (f-%04d.png) for another program"
                    .into(),
            )),
        }
    }

    /// Writes a film through `encode`, which gives its pixels: all of it or nothing.
    pub fn write(
        self,
        path: &Path,
        format: FilmFormat,
        [width, height]: [u32; 2],
        fps: f64,
        clear: bool,
        encode: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        let failed = |reason: String| Failure::Run(format!("{}: {reason}", path.display()));
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        // ffmpeg goes back in its file, so that it writes one of its own beside the target.
        let suffix = if format == FilmFormat::Mp4 { ".mp4" } else { ".webm" };
        let temporary = tempfile::Builder::new().prefix(".dotwork-").suffix(suffix).tempfile_in(folder);
        let temporary = temporary.map_err(|e| failed(e.to_string()))?;
        let mut command = Command::new(PROGRAM);
        command.args(["-hide_banner", "-loglevel", "error", "-y", "-f", "rawvideo", "-pixel_format"]);
        command.arg(if clear { "rgba" } else { "rgb24" });
        command.args([
            "-video_size",
            &format!("{width}x{height}"),
            "-framerate",
            &fps.to_string(),
            "-i",
            "-",
        ]);
        if format == FilmFormat::Mp4 {
            // Its colours are sampled at every other pixel: odd sides get one more.
            let even = "pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white";
            command.args(["-vf", even, "-c:v", "libx264", "-preset", "medium", "-crf", "16"]);
            command.args(["-pix_fmt", "yuv420p", "-movflags", "+faststart"]);
        } else {
            command.args(["-c:v", "libvpx-vp9", "-crf", "24", "-b:v", "0", "-row-mt", "1", "-pix_fmt"]);
            command.arg(if clear { "yuva420p" } else { "yuv420p" });
        }
        // The same film gives the same file.
        command.args(["-fflags", "+bitexact", "-flags:v", "+bitexact"]);
        command.arg(temporary.path());
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut child = command.spawn().map_err(|e| failed(format!("ffmpeg does not start: {e}")))?;
        let written = output::interruptible(|signal| match child.stdin.take() {
            Some(mut pipe) => encode(&mut signal.watch(&mut pipe)),
            None => Ok(()),
        });
        if let Err(e) = &written
            && e.kind() != io::ErrorKind::BrokenPipe
        {
            // Stopped, or a frame failed: what ffmpeg has is no film.
            let _ = child.kill();
        }
        let said = last_words(&mut child);
        let status = child.wait().map_err(|e| failed(format!("ffmpeg: {e}")))?;
        match written {
            Err(e) if e.kind() != io::ErrorKind::BrokenPipe => return Err(failed(e.to_string())),
            Ok(()) if status.success() => {}
            _ => return Err(failed(format!("ffmpeg failed: {said}"))),
        }
        temporary.persist(path).map(|_| ()).map_err(|e| failed(e.error.to_string()))
    }
}

/// The last line that ffmpeg had to say.
fn last_words(child: &mut Child) -> String {
    let mut said = Vec::new();
    if let Some(pipe) = child.stderr.take() {
        // It says little; what it does not stop saying is not waited for.
        let _ = pipe.take(1 << 16).read_to_end(&mut said);
    }
    let said = String::from_utf8_lossy(&said);
    said.lines().rfind(|l| !l.trim().is_empty()).unwrap_or("without a word").trim().to_string()
}
