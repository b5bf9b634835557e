//! A cursor over the lines and tokens of a text file.

use std::borrow::Cow;

use crate::error::{ReadErrorKind, quote};
use crate::number;

/// Text with `\n` at the end of its lines, given text that may end them with a lone `\r` (old Macintosh files).
/// `\r\n` stays: a `\r` before the `\n` is white space.
pub(crate) fn with_newlines(bytes: &[u8]) -> Cow<'_, [u8]> {
    if bytes.contains(&b'\n') || !bytes.contains(&b'\r') {
        return Cow::Borrowed(bytes);
    }
    Cow::Owned(bytes.iter().map(|&b| if b == b'\r' { b'\n' } else { b }).collect())
}

/// Where reading stands in a text.
pub(crate) struct Text<'a> {
    bytes: &'a [u8],
    at: usize,
    /// The line at the cursor, counted from 1.
    pub(crate) line: u64,
}

impl<'a> Text<'a> {
    /// A cursor at the start of `bytes`, whose first line is number `line`.
    pub(crate) fn new(bytes: &'a [u8], line: u64) -> Self {
        Text { bytes, at: 0, line }
    }

    /// What lies ahead.
    #[inline]
    pub(crate) fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    #[inline]
    fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    /// Moves over `length` bytes of the current token.
    #[inline]
    pub(crate) fn advance(&mut self, length: usize) {
        self.at += length;
    }

    /// Skips blanks, and a backslash that continues the line on the next one. True if a token follows on this line.
    #[inline]
    pub(crate) fn next_in_line(&mut self) -> bool {
        loop {
            match self.peek() {
                None | Some(b'\n') => return false,
                Some(b' ' | b'\t' | b'\r' | 0x0b | 0x0c) => self.at += 1,
                Some(b'\\') => match self.rest() {
                    [_, b'\n', ..] => {
                        self.at += 2;
                        self.line += 1;
                    }
                    [_, b'\r', b'\n', ..] => {
                        self.at += 3;
                        self.line += 1;
                    }
                    _ => return true,
                },
                Some(_) => return true,
            }
        }
    }

    /// Moves to the next line that holds a token. False at the end of the text.
    #[inline]
    pub(crate) fn next_line_with_token(&mut self) -> bool {
        while !self.next_in_line() {
            if self.peek().is_none() {
                return false;
            }
            self.at += 1;
            self.line += 1;
        }
        true
    }

    /// Drops the rest of the line, its end excluded; a backslash does not continue it.
    #[inline]
    pub(crate) fn skip_line(&mut self) {
        let rest = self.rest();
        self.at += rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
    }

    /// The token at the cursor, which moves past it. A lone backslash is a token.
    #[inline]
    pub(crate) fn token(&mut self) -> &'a [u8] {
        let rest = self.rest();
        let length = number::token(rest).len().max(usize::from(!rest.is_empty()));
        self.at += length;
        &rest[..length]
    }

    /// The number at the cursor, which moves past it.
    #[inline]
    pub(crate) fn float(&mut self) -> Result<f64, ReadErrorKind> {
        match number::float(self.rest()) {
            Some((value, length)) => {
                self.at += length;
                Ok(value)
            }
            None => Err(self.wrong_token("a number")),
        }
    }

    /// The integer that fills the token at the cursor, which moves past it.
    #[inline]
    pub(crate) fn integer(&mut self) -> Result<i64, ReadErrorKind> {
        match number::integer(self.rest()) {
            Some((value, length)) if self.rest().get(length).is_none_or(|&b| number::ends_token(b)) => {
                self.at += length;
                Ok(value)
            }
            _ => Err(self.wrong_token("an integer")),
        }
    }

    #[cold]
    fn wrong_token(&mut self, expected: &str) -> ReadErrorKind {
        let token = quote(self.token());
        self.error(format!("{token} is not {expected}"))
    }

    /// An error on the current line.
    #[cold]
    pub(crate) fn error(&self, reason: impl Into<String>) -> ReadErrorKind {
        ReadErrorKind::at_line(self.line, reason)
    }

    /// The error of a coordinate that is not finite.
    #[cold]
    pub(crate) fn not_finite(&self, vertex: u64, axis: usize, value: f64) -> ReadErrorKind {
        self.error(format!("vertex {vertex}: {} is {value}", crate::gather::AXES[axis]))
    }
}
