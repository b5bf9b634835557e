//! Bytes out of packed data, read straight into the memory where they stay.

use std::io::{self, Read};

use flate2::bufread::{GzDecoder, ZlibDecoder};

use crate::error::ReadErrorKind;
use crate::gzip::{DEFLATE_RATIO, is_gzip};

/// What a deflate stream may hold beyond [`DEFLATE_RATIO`] times its size: the last, partly used bytes.
const DEFLATE_SLACK: u64 = 1024;

/// How often bzip2 data are believed to hold their size, beyond [`BZIP2_BELIEVED`]. The method can do a million
/// times; a label map reaches thousands.
#[cfg(feature = "bzip2")]
const BZIP2_RATIO: u64 = 10_000;

/// What bzip2 data of any size are believed to hold.
#[cfg(feature = "bzip2")]
const BZIP2_BELIEVED: u64 = 128 << 20;

/// Streams of fewer bytes than this are allowed by the thousand: each costs megabytes of tables to begin.
#[cfg(feature = "bzip2")]
const BZIP2_STREAM: u64 = 1024;

/// How data are packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Packing {
    None,
    Gzip,
    Zlib,
    #[cfg(feature = "bzip2")]
    Bzip2,
}

impl Packing {
    /// Its name for messages.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Packing::None => "raw",
            Packing::Gzip => "gzip",
            Packing::Zlib => "zlib",
            #[cfg(feature = "bzip2")]
            Packing::Bzip2 => "bzip2",
        }
    }

    /// How many bytes `packed` bytes can unpack to at most, where the method has a limit worth the name.
    pub(crate) fn most(self, packed: usize) -> Option<u64> {
        let packed = packed as u64;
        match self {
            Packing::None => Some(packed),
            Packing::Gzip | Packing::Zlib => Some(packed.saturating_mul(DEFLATE_RATIO) + DEFLATE_SLACK),
            #[cfg(feature = "bzip2")]
            Packing::Bzip2 => None,
        }
    }
}

impl Packing {
    /// How many bytes `packed` bytes are believed to unpack to: [`Packing::most`], or less than a hostile file could.
    fn believed(self, packed: usize) -> u64 {
        match self {
            #[cfg(feature = "bzip2")]
            Packing::Bzip2 => (packed as u64).saturating_mul(BZIP2_RATIO).max(BZIP2_BELIEVED),
            packing => packing.most(packed).unwrap_or(u64::MAX),
        }
    }
}

enum Inner<'a> {
    Plain(&'a [u8]),
    Gzip(Box<GzDecoder<&'a [u8]>>),
    Zlib(Box<ZlibDecoder<&'a [u8]>>),
    #[cfg(feature = "bzip2")]
    Bzip2(Box<Bzip2<'a>>),
    Ended,
}

/// One stream of bzip2 data after the other.
#[cfg(feature = "bzip2")]
struct Bzip2<'a> {
    decoder: bzip2::bufread::BzDecoder<&'a [u8]>,
    /// Streams that ended.
    streams: u64,
    /// Bytes given so far.
    given: u64,
}

#[cfg(feature = "bzip2")]
impl Bzip2<'_> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        loop {
            let n = self.decoder.read(into)?;
            self.given += n as u64;
            let rest = *self.decoder.get_ref();
            if n > 0 || !rest.starts_with(b"BZh") {
                return Ok(n);
            }
            self.streams += 1;
            if self.streams > 1000 + self.given / BZIP2_STREAM {
                return Err(io::Error::other("it has thousands of streams with next to nothing in them"));
            }
            self.decoder = bzip2::bufread::BzDecoder::new(rest);
        }
    }
}

/// A reader of packed or plain bytes.
pub(crate) struct Stream<'a> {
    inner: Inner<'a>,
    packed: &'a [u8],
    pub(crate) packing: Packing,
    /// Bytes given so far.
    pub(crate) given: u64,
}

impl<'a> Stream<'a> {
    pub(crate) fn new(packed: &'a [u8], packing: Packing) -> Self {
        let inner = match packing {
            Packing::None => Inner::Plain(packed),
            Packing::Gzip => Inner::Gzip(Box::new(GzDecoder::new(packed))),
            Packing::Zlib => Inner::Zlib(Box::new(ZlibDecoder::new(packed))),
            #[cfg(feature = "bzip2")]
            Packing::Bzip2 => Inner::Bzip2(Box::new(Bzip2 {
                decoder: bzip2::bufread::BzDecoder::new(packed),
                streams: 0,
                given: 0,
            })),
        };
        Stream { inner, packed, packing, given: 0 }
    }

    /// The bytes ahead, if they are not packed.
    pub(crate) fn plain(&self) -> Option<&'a [u8]> {
        match self.inner {
            Inner::Plain(rest) => Some(rest),
            _ => None,
        }
    }

    /// How many bytes can come at most, from here; `None` if nobody knows.
    pub(crate) fn most(&self) -> Option<u64> {
        Some(self.packing.most(self.packed.len())?.saturating_sub(self.given))
    }

    /// How many bytes are believed to come, from here.
    pub(crate) fn believed(&self) -> u64 {
        self.packing.believed(self.packed.len()).saturating_sub(self.given)
    }

    /// The same data from the beginning.
    pub(crate) fn again(&self) -> Stream<'a> {
        Stream::new(self.packed, self.packing)
    }

    /// Fills `into`, as far as the data reach; fewer bytes than asked for mean that they ended.
    pub(crate) fn read(&mut self, into: &mut [u8]) -> Result<usize, ReadErrorKind> {
        let mut filled = 0;
        while filled < into.len() {
            match self.once(&mut into[filled..]) {
                Ok(0) => break,
                Ok(n) => filled += n,
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) if e.kind() == io::ErrorKind::UnexpectedEof => {
                    self.inner = Inner::Ended;
                    break;
                }
                Err(e) => {
                    let name = self.packing.name();
                    let given = self.given + filled as u64;
                    return Err(ReadErrorKind::Refused(format!(
                        "{name} data: damaged after {given} unpacked bytes ({e})"
                    )));
                }
            }
        }
        self.given += filled as u64;
        Ok(filled)
    }

    fn once(&mut self, into: &mut [u8]) -> io::Result<usize> {
        match &mut self.inner {
            Inner::Plain(rest) => rest.read(into),
            Inner::Zlib(decoder) => decoder.read(into),
            #[cfg(feature = "bzip2")]
            Inner::Bzip2(decoder) => decoder.read(into),
            Inner::Ended => Ok(0),
            Inner::Gzip(decoder) => loop {
                let n = decoder.read(into)?;
                if n > 0 {
                    return Ok(n);
                }
                let rest: &'a [u8] = decoder.get_ref();
                // Another member may follow; anything else behind the data is no part of them.
                if !is_gzip(rest) {
                    self.inner = Inner::Ended;
                    return Ok(0);
                }
                **decoder = GzDecoder::new(rest);
            },
        }
    }

    /// Passes over `count` bytes, or fewer if the data end; returns how many.
    pub(crate) fn skip(&mut self, count: u64) -> Result<u64, ReadErrorKind> {
        if let Inner::Plain(rest) = &mut self.inner {
            let n = usize::try_from(count).unwrap_or(usize::MAX).min(rest.len());
            *rest = &rest[n..];
            self.given += n as u64;
            return Ok(n as u64);
        }
        let mut scratch = [0; 32 * 1024];
        let mut skipped = 0;
        while skipped < count {
            let n = (count - skipped).min(scratch.len() as u64) as usize;
            let got = self.read(&mut scratch[..n])?;
            skipped += got as u64;
            if got < n {
                break;
            }
        }
        Ok(skipped)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::Compression;
    use flate2::write::{GzEncoder, ZlibEncoder};
    use std::io::Write;

    fn gzip(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    #[test]
    fn members_follow_each_other_and_the_rest_is_left() {
        let packed = [gzip(b"one "), gzip(b""), gzip(b"two"), b"tail".to_vec()].concat();
        let mut stream = Stream::new(&packed, Packing::Gzip);
        let mut out = [0; 16];
        assert_eq!(stream.read(&mut out).unwrap(), 7);
        assert_eq!(&out[..7], b"one two");
        assert_eq!(stream.read(&mut out).unwrap(), 0);
        assert_eq!(stream.given, 7);
    }

    #[test]
    fn truncation_ends_and_damage_is_said() {
        let numbers: Vec<u8> = (0..9999u32).flat_map(|i| (i * i).to_le_bytes()).collect();
        let packed = gzip(&numbers);
        let mut out = vec![0; numbers.len()];
        let got = Stream::new(&packed[..packed.len() / 2], Packing::Gzip).read(&mut out).unwrap();
        assert!(got < numbers.len() && out[..got] == numbers[..got]);

        let mut wrong = packed.clone();
        let crc = wrong.len() - 6;
        wrong[crc] ^= 1;
        let mut stream = Stream::new(&wrong, Packing::Gzip);
        assert_eq!(stream.read(&mut out).unwrap(), numbers.len());
        let error = stream.read(&mut [0]).unwrap_err().to_string();
        assert!(error.starts_with("gzip data: damaged after 39996 unpacked bytes"), "{error}");

        let mut zlib = ZlibEncoder::new(Vec::new(), Compression::default());
        zlib.write_all(&numbers).unwrap();
        let zlib = zlib.finish().unwrap();
        let mut stream = Stream::new(&zlib, Packing::Zlib);
        assert_eq!(stream.skip(4).unwrap(), 4);
        assert_eq!(stream.read(&mut out).unwrap(), numbers.len() - 4);
        assert_eq!(stream.again().skip(u64::MAX).unwrap(), numbers.len() as u64);
    }
}
