//! Films as one file: animated GIF and APNG.
//!
//! Both work in two halves: a picture becomes the packed bytes of a frame ([`gif_frame`], [`apng_frame`]), which needs
//! nothing but the picture and can be done for many frames side by side; a writer puts frames into the file one after
//! the other. The times of frames add up: each is shown until the next one's time, rounded to what the format counts in,
//! so that no error grows.

mod apng;
mod gif_film;

pub use apng::{ApngFrame, ApngWriter, apng_frame};
pub use gif_film::{GifFrame, GifWriter, gif_frame};

/// How long a frame from `start` to `end` seconds is shown in units of `1 / rate` seconds, at least 1: what is left
/// between its rounded times.
fn ticks(start: f64, end: f64, rate: f64) -> u16 {
    let ticks = (end * rate).round() - (start * rate).round();
    ticks.clamp(1.0, f64::from(u16::MAX)) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_add_up() {
        let total: u32 =
            (0..240).map(|n| u32::from(ticks(f64::from(n) / 24.0, f64::from(n + 1) / 24.0, 100.0))).sum();
        assert_eq!(total, 1000);
        assert_eq!(ticks(0.0, 1e9, 100.0), u16::MAX);
    }
}
