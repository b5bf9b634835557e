//! The timeline: where camera and light are at which time, between keys.

use dotwork_drawing::{Camera, Light};

/// Values at rising times, with a smooth curve between them that never leaves the values of its neighbours: a cubic
/// Hermite spline with monotone slopes (Fritsch & Butland 1984). Before the first key and after the last it stands still.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Track {
    times: Vec<f64>,
    values: Vec<f64>,
}

impl Track {
    /// The track through keys of time (seconds) and value.
    ///
    /// # Errors
    /// Times that do not rise.
    pub fn new(keys: impl IntoIterator<Item = (f64, f64)>) -> Result<Track, String> {
        let (times, values): (Vec<f64>, Vec<f64>) = keys.into_iter().unzip();
        match times.windows(2).find(|w| w[0] >= w[1]) {
            Some(w) => Err(format!("keys have rising times, but {} comes after {}", w[1], w[0])),
            None => Ok(Track { times, values }),
        }
    }

    /// The value at a time; `None` if there are no keys.
    pub fn at(&self, time: f64) -> Option<f64> {
        let last = self.times.len().checked_sub(1)?;
        let after = self.times.partition_point(|&t| t <= time);
        if after == 0 || after > last {
            return Some(self.values[after.min(last)]);
        }
        let k = after - 1;
        let h = self.times[after] - self.times[k];
        let t = (time - self.times[k]) / h;
        let (t2, t3) = (t * t, t * t * t);
        let (a, b) = (self.values[k], self.values[after]);
        let (m, n) = (h * self.slope(k), h * self.slope(after));
        Some(
            (2.0 * t3 - 3.0 * t2 + 1.0) * a
                + (t3 - 2.0 * t2 + t) * m
                + (3.0 * t2 - 2.0 * t3) * b
                + (t3 - t2) * n,
        )
    }

    /// The same with `f` of each value.
    pub fn map(self, f: impl Fn(f64) -> f64) -> Track {
        Track { values: self.values.into_iter().map(f).collect(), ..self }
    }

    /// The last time of any key; 0 if there are none.
    pub fn end(&self) -> f64 {
        self.times.last().copied().unwrap_or(0.0)
    }

    /// The slope at key `k`: the harmonic mean of those on both sides, 0 at a turn; at the ends that of the one side.
    fn slope(&self, k: usize) -> f64 {
        let between = |i: usize| (self.values[i + 1] - self.values[i]) / (self.times[i + 1] - self.times[i]);
        if k == 0 {
            return between(0);
        }
        if k + 1 == self.times.len() {
            return between(k - 1);
        }
        let (before, after) = (between(k - 1), between(k));
        if before * after <= 0.0 {
            return 0.0;
        }
        let (h, g) = (self.times[k] - self.times[k - 1], self.times[k + 1] - self.times[k]);
        let (v, w) = (2.0 * g + h, g + 2.0 * h);
        (v + w) / (v / before + w / after)
    }
}

/// How camera and light move over time; what has no keys stays as the scene has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Timeline {
    /// Azimuth of the camera, degrees; beyond 360 it turns more than once.
    pub azimuth: Track,
    /// Elevation of the camera, degrees.
    pub elevation: Track,
    /// Logarithm of the camera's distance in bounding radii.
    pub log_distance: Track,
    /// Logarithm of its zoom.
    pub log_zoom: Track,
    /// Azimuth of the light, degrees.
    pub light_azimuth: Track,
    /// Elevation of the light, degrees.
    pub light_elevation: Track,
}

impl Timeline {
    /// Whether nothing has keys.
    pub fn is_empty(&self) -> bool {
        *self == Timeline::default()
    }

    /// The last time of any key, seconds.
    pub fn end(&self) -> f64 {
        let Timeline { azimuth, elevation, log_distance, log_zoom, light_azimuth, light_elevation } = self;
        [azimuth, elevation, log_distance, log_zoom, light_azimuth, light_elevation]
            .iter()
            .fold(0.0, |end, track| end.max(track.end()))
    }

    /// Puts camera and light where they are at a time.
    pub fn apply(&self, time: f64, camera: &mut Camera, light: &mut Light) {
        let put = |track: &Track, value: &mut f32| {
            if let Some(there) = track.at(time) {
                *value = there as f32;
            }
        };
        put(&self.azimuth, &mut camera.azimuth);
        put(&self.elevation, &mut camera.elevation);
        if let Some(distance) = self.log_distance.at(time) {
            camera.distance = Some(distance.exp() as f32);
        }
        if let Some(zoom) = self.log_zoom.at(time) {
            camera.zoom = zoom.exp() as f32;
        }
        put(&self.light_azimuth, &mut light.azimuth);
        put(&self.light_elevation, &mut light.elevation);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tracks_pass_through_their_keys_and_stay_between_them() {
        let track = Track::new([(0.0, 1.0), (1.0, 3.0), (1.5, 3.1), (4.0, -2.0), (5.0, -2.0)]).unwrap();
        for (time, value) in [(-1.0, 1.0), (0.0, 1.0), (1.0, 3.0), (1.5, 3.1), (4.0, -2.0), (9.0, -2.0)] {
            assert_eq!(track.at(time), Some(value));
        }
        for k in 0..500 {
            let t = f64::from(k) / 100.0;
            let here = track.at(t).unwrap();
            let (low, high) = match t {
                ..1.0 => (1.0, 3.0),
                ..1.5 => (3.0, 3.1),
                ..4.0 => (-2.0, 3.1),
                _ => (-2.0, -2.0),
            };
            assert!((low - 1e-9..=high + 1e-9).contains(&here), "{t}: {here}");
            // No corners.
            let next = track.at(t + 1e-6).unwrap();
            assert!((next - here).abs() < 1e-4);
        }
        let line = Track::new([(0.0, 0.0), (2.0, 6.0)]).unwrap();
        assert_eq!(line.at(0.5), Some(1.5));
        assert_eq!(Track::default().at(1.0), None);
        assert!(Track::new([(0.0, 0.0), (0.0, 1.0)]).is_err());
    }

    #[test]
    fn a_zoom_grows_by_equal_shares() {
        let log_zoom = Track::new([(0.0, 0.0), (6.0, 64f64.ln())]).unwrap();
        let timeline = Timeline { log_zoom, ..Timeline::default() };
        let zoom = |t: f64| {
            let mut camera = Camera::default();
            timeline.apply(t, &mut camera, &mut Light::default());
            camera.zoom
        };
        for t in 0..=6 {
            assert!((zoom(f64::from(t)) / 2f32.powi(t) - 1.0).abs() < 1e-5);
        }
        assert_eq!(timeline.end(), 6.0);
    }
}
