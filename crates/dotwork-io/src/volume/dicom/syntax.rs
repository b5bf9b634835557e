//! Transfer syntaxes (PS3.6, annex A): how a data set and its pixels are written.

use crate::error::{ReadErrorKind, one_line};

/// How frames are packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Codec {
    /// Not at all.
    Native,
    /// Bytes of equal weight by PackBits (PS3.5, annex G).
    Rle,
    /// JPEG, lossy or lossless.
    Jpeg,
    /// JPEG-LS, lossless or nearly.
    JpegLs,
    /// JPEG 2000.
    Jpeg2000,
    /// JPEG 2000 with another coding of its blocks.
    HighThroughput,
    /// Something that is not read.
    Unread,
}

impl Codec {
    /// What decoding a frame takes for each of its samples besides the samples themselves, bytes.
    pub(super) fn bytes_per_sample(self) -> u64 {
        match self {
            // JPEG-LS keeps two lines.
            Codec::Native | Codec::JpegLs | Codec::Unread => 0,
            Codec::Rle => 1,
            // Coefficients of 16 bits, planes, samples side by side.
            Codec::Jpeg => 6,
            // Several planes in `f32`.
            Codec::Jpeg2000 | Codec::HighThroughput => 16,
        }
    }
}

/// A transfer syntax.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Syntax {
    /// Its name for messages.
    pub(super) name: &'static str,
    /// Elements name the type of their value.
    pub(super) explicit: bool,
    pub(super) big_endian: bool,
    /// The whole data set is deflated.
    pub(super) deflated: bool,
    pub(super) codec: Codec,
}

/// The ends of identifiers that begin with 1.2.840.10008.1.2, and their names.
const PACKED: [(&str, &str, Codec); 34] = [
    (".5", "RLE", Codec::Rle),
    (".4.50", "JPEG baseline", Codec::Jpeg),
    (".4.51", "JPEG extended", Codec::Jpeg),
    (".4.57", "JPEG lossless", Codec::Jpeg),
    (".4.70", "JPEG lossless", Codec::Jpeg),
    (".4.90", "JPEG 2000", Codec::Jpeg2000),
    (".4.91", "JPEG 2000", Codec::Jpeg2000),
    (".4.80", "JPEG-LS", Codec::JpegLs),
    (".4.81", "JPEG-LS near-lossless", Codec::JpegLs),
    (".4.92", "JPEG 2000 part 2", Codec::Unread),
    (".4.93", "JPEG 2000 part 2", Codec::Unread),
    (".4.94", "JPIP, pixels on a server", Codec::Unread),
    (".4.95", "JPIP, pixels on a server", Codec::Unread),
    (".4.204", "JPIP, pixels on a server", Codec::Unread),
    (".4.205", "JPIP, pixels on a server", Codec::Unread),
    (".4.100", "MPEG-2 video", Codec::Unread),
    (".4.100.1", "MPEG-2 video", Codec::Unread),
    (".4.101", "MPEG-2 video", Codec::Unread),
    (".4.101.1", "MPEG-2 video", Codec::Unread),
    (".4.102", "MPEG-4 video", Codec::Unread),
    (".4.102.1", "MPEG-4 video", Codec::Unread),
    (".4.103", "MPEG-4 video", Codec::Unread),
    (".4.104", "MPEG-4 video", Codec::Unread),
    (".4.105", "MPEG-4 video", Codec::Unread),
    (".4.106", "MPEG-4 video", Codec::Unread),
    (".4.107", "HEVC video", Codec::Unread),
    (".4.108", "HEVC video", Codec::Unread),
    (".4.110", "JPEG XL", Codec::Unread),
    (".4.111", "JPEG XL", Codec::Unread),
    (".4.112", "JPEG XL", Codec::Unread),
    (".4.201", "high-throughput JPEG 2000", Codec::HighThroughput),
    (".4.202", "high-throughput JPEG 2000", Codec::HighThroughput),
    (".4.203", "high-throughput JPEG 2000", Codec::HighThroughput),
    (".8.1", "deflated frames", Codec::Unread),
];

impl Syntax {
    /// The syntax with this identifier.
    pub(super) fn of(uid: &str) -> Syntax {
        let native = Syntax {
            name: "explicit little endian",
            explicit: true,
            big_endian: false,
            deflated: false,
            codec: Codec::Native,
        };
        let Some(end) = uid.strip_prefix("1.2.840.10008.1.2") else {
            return Syntax { name: "a private kind", codec: Codec::Unread, ..native };
        };
        match end {
            "" => Syntax { name: "implicit little endian", explicit: false, ..native },
            ".1" => native,
            ".1.99" => Syntax { name: "deflated", deflated: true, ..native },
            ".2" => Syntax { name: "explicit big endian", big_endian: true, ..native },
            _ => match PACKED.iter().find(|(e, ..)| *e == end) {
                Some(&(_, name, codec)) => Syntax { name, codec, ..native },
                // The retired ones (PS3.6, annex A) lie between these.
                None if end.starts_with(".4.5") || end.starts_with(".4.6") => {
                    Syntax { name: "a retired kind of JPEG", codec: Codec::Unread, ..native }
                }
                None => Syntax { name: "an unknown kind", codec: Codec::Unread, ..native },
            },
        }
    }

    /// Refuses by name what is not read.
    pub(super) fn check(&self, uid: &str) -> Result<(), ReadErrorKind> {
        if self.codec != Codec::Unread {
            return Ok(());
        }
        let uid: String = uid.chars().take(64).collect();
        let uid = if uid.is_empty() { String::new() } else { format!(" ({})", one_line(&uid)) };
        Err(ReadErrorKind::Refused(format!(
            "is DICOM whose pixels are packed as {}{uid}, which is not read; RLE, JPEG, JPEG-LS and JPEG 2000 are",
            self.name
        )))
    }
}
