//! Tone: how much ink a place of the surface asks for, 0…1. It never sees pixels.
//!
//! The terms are summed, not multiplied: a product of the papers' factors is near 0 everywhere and needs a gain set
//! by hand. What one summand darkens, another cannot undo.

mod papers;

use crate::params::{Inked, Style};
pub use papers::{
    ElementTone, FACTORS, FactorHistogram, HISTOGRAM_BINS, PapersTone, Sight, Viewing, boundary, count,
    distance, factor_histograms, few, front_limit, interior, lighting, random_of, resolution, silhouette,
    small,
};

/// What the tone of a place depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lit {
    /// Cosine between the smooth normal and the light.
    pub n_dot_l: f32,
    /// Cosine between the smooth normal and the eye, absolute value.
    pub n_dot_e: f32,
    /// Depth within the bounding sphere: 0 at its near, 1 at its far end.
    pub z: f32,
    /// Depth over the depth of the sphere's centre; 1 in parallel projection.
    pub relative_depth: f32,
    /// The place is seen from behind.
    pub back: bool,
    /// The ink of the surface's own colour, if it has one.
    pub own: Option<f32>,
}

/// How far a place belongs to the toon silhouette, 0…1: 1 where the cosine between its normal and the eye is at most
/// `threshold`, 0 from a tenth more on (Lu et al. 2003, section 5.6, the second approach). Nothing does at `threshold` 0.
#[inline(always)]
pub fn toon(n_dot_e: f32, threshold: f32) -> f32 {
    if threshold > 0.0 {
        ((1.1 * threshold - n_dot_e.abs()) / (0.1 * threshold)).clamp(0.0, 1.0)
    } else {
        0.0
    }
}

/// The tone of one style, with its powers tabulated.
#[derive(Clone, Debug)]
pub struct Tone {
    /// `tone · base`
    base: f32,
    /// The light term against `n·L` from −1 to 1.
    light: Table,
    /// The silhouette term against `|n·E|` from 0 to 1.
    silhouette: Table,
    distance: f32,
    depth_exponent: f32,
    highlight: f32,
    max: f32,
    back: f32,
    texture: f32,
    /// Factor on the surface's own tone.
    tone: f32,
    toon: f32,
}

impl Tone {
    /// The tone of a style.
    pub fn new(style: &Style) -> Tone {
        let light = |n_dot_l: f32| {
            let lit = ((n_dot_l + style.wrap) / (1.0 + style.wrap)).clamp(0.0, 1.0);
            let side = match style.inked {
                Inked::Shade => 1.0 - lit,
                Inked::Light => lit,
            };
            style.tone * style.light * side.powf(style.gamma)
        };
        let silhouette =
            |n_dot_e: f32| style.tone * style.silhouette * (1.0 - n_dot_e).powf(style.silhouette_power);
        Tone {
            base: style.tone * style.base,
            light: Table::new(|u| light(2.0 * u - 1.0)),
            silhouette: Table::new(silhouette),
            distance: style.distance,
            depth_exponent: 2.0 * (1.0 - style.resolution),
            highlight: style.highlight,
            max: if style.solid { 1.0 } else { style.shadow },
            back: style.back,
            texture: style.texture,
            tone: style.tone,
            toon: style.toon,
        }
    }

    /// The ink that a place asks for, 0…1.
    #[inline(always)]
    pub fn ink(&self, lit: &Lit) -> f32 {
        let mut ink = self.base + self.light.at(0.5 * lit.n_dot_l + 0.5) + self.silhouette.at(lit.n_dot_e);
        if lit.back {
            ink += self.back;
        }
        if let Some(own) = lit.own {
            ink += self.texture * (self.tone * own - ink);
        }
        if self.distance != 0.0 {
            ink *= 1.0 - self.distance * if self.distance > 0.0 { lit.z } else { lit.z - 1.0 };
        }
        if self.depth_exponent != 0.0 {
            ink *= lit.relative_depth.powf(self.depth_exponent);
        }
        if self.highlight > 0.0 {
            ink = (ink - self.highlight) / (1.0 - self.highlight);
        }
        let ink = ink.clamp(0.0, self.max);
        ink + (1.0 - ink) * toon(lit.n_dot_e, self.toon)
    }
}

/// A function on [0, 1] as 256 linear pieces.
#[derive(Clone, Debug)]
pub(crate) struct Table(Vec<f32>);

impl Table {
    const PIECES: usize = 256;

    fn new(f: impl Fn(f32) -> f32) -> Table {
        Table((0..=Self::PIECES + 1).map(|i| f((i as f32 / Self::PIECES as f32).min(1.0))).collect())
    }

    #[inline(always)]
    fn at(&self, u: f32) -> f32 {
        let x = u.clamp(0.0, 1.0) * Self::PIECES as f32;
        let i = x as usize;
        let t = x - i as f32;
        self.0[i] + (self.0[i + 1] - self.0[i]) * t
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::presets::preset;

    fn lit(n_dot_l: f32, n_dot_e: f32) -> Lit {
        Lit { n_dot_l, n_dot_e, z: 0.5, relative_depth: 1.0, back: false, own: None }
    }

    #[test]
    fn flat_is_flat_and_lambert_is_lambert() {
        let mut style = preset("flat").unwrap();
        style.tone = 0.3;
        let tone = Tone::new(&style);
        for (l, e) in [(-1.0, 0.1), (0.0, 0.5), (1.0, 1.0)] {
            assert!((tone.ink(&lit(l, e)) - 0.3).abs() < 1e-6);
        }
        let mut style = preset("lambert").unwrap();
        style.tone = 0.8;
        let tone = Tone::new(&style);
        for (l, ink) in [(-0.5, 0.8), (0.0, 0.8), (0.25, 0.6), (1.0, 0.0)] {
            assert!((tone.ink(&lit(l, 0.3)) - ink).abs() < 1e-5, "{l}");
        }
    }

    #[test]
    fn distance_and_resolution_act_on_depth() {
        let mut style = preset("flat").unwrap();
        style.tone = 0.4;
        style.distance = 0.5;
        let at = |style: &Style, z: f32, depth: f32| {
            Tone::new(style).ink(&Lit {
                n_dot_l: 0.0,
                n_dot_e: 1.0,
                z,
                relative_depth: depth,
                back: false,
                own: None,
            })
        };
        assert!((at(&style, 0.0, 1.0) - 0.4).abs() < 1e-6 && (at(&style, 1.0, 1.0) - 0.2).abs() < 1e-6);
        style.distance = -0.5;
        assert!((at(&style, 1.0, 1.0) - 0.4).abs() < 1e-6 && (at(&style, 0.0, 1.0) - 0.2).abs() < 1e-6);
        style.distance = 0.0;
        style.resolution = 0.0;
        assert!((at(&style, 0.5, 1.2) - 0.4 * 1.44).abs() < 1e-4);
    }

    #[test]
    fn a_surface_s_own_colour_takes_over() {
        let mut style = Style { tone: 0.5, ..preset("flat").unwrap() };
        let at = |style: &Style, own| Tone::new(style).ink(&Lit { own, ..lit(0.3, 0.8) });
        assert_eq!(at(&style, Some(1.0)), 0.5);
        style.texture = 1.0;
        assert_eq!((at(&style, Some(0.0)), at(&style, Some(0.5)), at(&style, None)), (0.0, 0.25, 0.5));
        style.texture = 0.5;
        assert_eq!(at(&style, Some(0.5)), 0.375);
    }

    #[test]
    fn the_toon_silhouette_is_black_up_to_its_threshold_and_not_beyond() {
        let style = Style { tone: 0.3, toon: 0.2, ..preset("flat").unwrap() };
        let tone = Tone::new(&style);
        let inks = [0.0, 0.1, 0.2, 0.21, 0.22, 0.5].map(|c| tone.ink(&lit(0.0, c)));
        for (ink, expected) in inks.into_iter().zip([1.0, 1.0, 1.0, 0.65, 0.3, 0.3]) {
            assert!((ink - expected).abs() < 1e-4, "{inks:?}");
        }
        assert_eq!((toon(0.0, 0.0), toon(-0.1, 0.2)), (0.0, 1.0));
    }

    #[test]
    fn ink_stays_in_range() {
        let mut style = Style { base: 1.0, light: 1.0, silhouette: 1.0, ..Style::default() };
        assert_eq!(Tone::new(&style).ink(&lit(-1.0, 0.0)), 0.95);
        style.solid = true;
        assert_eq!(Tone::new(&style).ink(&lit(-1.0, 0.0)), 1.0);
        style.highlight = 0.5;
        style.base = 0.0;
        assert_eq!(Tone::new(&style).ink(&lit(1.0, 1.0)), 0.0);
    }
}
