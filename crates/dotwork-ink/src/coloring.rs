//! Colour: what a dot's place makes of its ink.
//!
//! Lu et al. 2003, section 5.7, blend warm and cool colours by the orientation towards the light (tone shading after
//! Gooch et al. 1998) and by the distance from the viewer, in HLS through a palette that is worked out before. Here too a
//! frame looks colours up: a [`ColorTable`] holds at most 64, each of which is a layer of the drawing and a pen of a
//! plotter.
//!
//! ```text
//! light: u = (1 + n.L) / 2       depth: u = 1 - z
//! color = palette(u)             both:  mix(palette((1 + n.L) / 2), far, z)
//! ```

use dotwork_drawing::palette::mix;
use dotwork_drawing::{Color, Palette};

mod own;

use crate::params::{Coloring, PaletteChoice, Style};

/// Default of the style key `warm`.
pub(crate) const WARM: Color = Color { r: 0xd9, g: 0x5f, b: 0x02 };
/// Default of the style key `cool`.
pub(crate) const COOL: Color = Color { r: 0x2b, g: 0x4c, b: 0x9b };
/// Default of the style key `far`.
pub(crate) const FAR: Color = Color { r: 0xb8, g: 0xc4, b: 0xd6 };

/// The palettes that have a name, from shade or far to light or near.
///
/// `blue-orange` passes through dull colours and not round the hue, so that form is read before colour; `aerial` is for
/// depth, pale where it is far; `viridis` (van der Walt and Smith 2015) is even to the eye and to readers who see fewer colours.
pub const PALETTES: &[(&str, &[Color])] = &[
    ("blue-orange", &[rgb(0x1f3f96), rgb(0x4b4a86), rgb(0x8a4f58), rgb(0xcc5a17), rgb(0xe8760a)]),
    ("aerial", &[rgb(0xc4daf6), rgb(0x6d97d0), rgb(0x2f4f8f), rgb(0x3a2430), rgb(0x6b2208)]),
    ("sunset", &[rgb(0x1d2a6b), rgb(0x6a2c91), rgb(0xc2305f), rgb(0xf06b3c), rgb(0xf9b24a)]),
    ("ocean", &[rgb(0x0b1f4b), rgb(0x155a8a), rgb(0x1f9aa6), rgb(0x8fd0b0)]),
    ("earth", &[rgb(0x33261d), rgb(0x7a4a2b), rgb(0xc07f3f), rgb(0xd9b77e)]),
    (
        "viridis",
        &[
            rgb(0x440154),
            rgb(0x46327e),
            rgb(0x365c8d),
            rgb(0x277f8e),
            rgb(0x1fa187),
            rgb(0x4ac16d),
            rgb(0xa0da39),
            rgb(0xfde725),
        ],
    ),
];

const fn rgb(hex: u32) -> Color {
    Color { r: (hex >> 16) as u8, g: (hex >> 8) as u8, b: hex as u8 }
}

/// The colours of one style, and which of them a place has.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorTable {
    by: Coloring,
    /// Steps along the light (or what stands in its place), and along the depth.
    steps: [usize; 2],
    /// Entry of `colors` for each step of the light of each step of the depth, the farthest first.
    entry: Vec<u8>,
    /// All different, from far and cool to near and warm.
    colors: Vec<Color>,
    /// With own colours: the nearest of `colors` for each step of red, green and blue.
    nearest: Vec<u8>,
}

impl ColorTable {
    /// Most colours of a table.
    pub const MOST: usize = Palette::MOST;

    /// The colours that a style asks for by light or depth; `None` if it does not.
    pub fn new(style: &Style) -> Option<ColorTable> {
        let most = (style.color_steps.round() as usize).clamp(2, ColorTable::MOST);
        let steps = match style.coloring {
            Coloring::None | Coloring::Own => return None,
            Coloring::Light | Coloring::Depth => [most, 1],
            // As many of each as there is room for; the light, which is seen more, gets what is left over.
            Coloring::Both => {
                let depth = most.isqrt().max(1);
                [most / depth, depth]
            }
        };
        let palette = match &style.palette {
            PaletteChoice::List(palette) => Some(palette.clone()),
            PaletteChoice::None => None,
            PaletteChoice::Named(name) => {
                let named = PALETTES.iter().find(|(n, _)| n == name);
                named.and_then(|(_, colors)| Palette::new(colors.to_vec()).ok())
            }
        };
        let space = style.color_space;
        let along = |u: f64| match &palette {
            Some(palette) => palette.at(u, space),
            None => mix(style.cool, style.warm, u, space),
        };
        let share = |k: usize, of: usize| if of < 2 { 0.0 } else { k as f64 / (of - 1) as f64 };
        let mut table = ColorTable {
            by: style.coloring,
            steps,
            entry: Vec::new(),
            colors: Vec::new(),
            nearest: Vec::new(),
        };
        for depth in 0..steps[1] {
            let z = if steps[1] < 2 { 0.0 } else { 1.0 - share(depth, steps[1]) };
            for light in 0..steps[0] {
                let color = mix(along(share(light, steps[0])), style.far, z, space);
                let known = table.colors.iter().position(|c| *c == color);
                table.entry.push(known.unwrap_or(table.colors.len()) as u8);
                if known.is_none() {
                    table.colors.push(color);
                }
            }
        }
        Some(table)
    }

    /// The colours of dots that have those of their surface, `tint`; `None` if the style does not ask for them or the
    /// surface has none.
    pub fn of_surface(style: &Style, tint: &[[u8; 3]]) -> Option<ColorTable> {
        if style.coloring != Coloring::Own || tint.is_empty() {
            return None;
        }
        let most = (style.color_steps.round() as usize).clamp(2, ColorTable::MOST);
        let colors = own::cut(&tint[..tint.len().min(own::SAMPLE)], most);
        let nearest = own::nearest(&colors);
        Some(ColorTable { by: Coloring::Own, steps: [1, 1], entry: vec![0], colors, nearest })
    }

    /// Whether colours follow the surface's own.
    pub fn is_own(&self) -> bool {
        !self.nearest.is_empty()
    }

    /// Which of the colours is nearest to one of the surface.
    ///
    /// # Panics
    /// If [`ColorTable::is_own`] is not true.
    #[inline(always)]
    pub fn nearest(&self, tint: [u8; 3]) -> u8 {
        self.nearest[own::step(tint)]
    }

    /// The colours, at most 64 and all different: layers from bottom to top, from far and cool to near and warm.
    pub fn colors(&self) -> &[Color] {
        &self.colors
    }

    /// Which of the colours a place has, from the cosine between its normal and the light, and its depth `z`, 0 at the
    /// near and 1 at the far end of the bounding sphere. What lies outside counts as the end.
    #[inline(always)]
    pub fn index(&self, n_dot_l: f32, z: f32) -> u8 {
        // To the nearest step; a cast of what is no number gives 0.
        let step = |u: f32, of: usize| ((u * (of - 1) as f32 + 0.5) as usize).min(of - 1);
        let [along, depth] = match self.by {
            Coloring::Depth => [1.0 - z, 0.0],
            _ => [0.5 + 0.5 * n_dot_l, 1.0 - z],
        };
        self.entry[step(depth, self.steps[1]) * self.steps[0] + step(along, self.steps[0])]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::{PARAMS, find_param};

    fn table(keys: &[(&str, &str)]) -> ColorTable {
        let mut style = Style::default();
        for (key, value) in keys {
            style.set(key, value).unwrap();
        }
        ColorTable::new(&style).unwrap()
    }

    fn at(table: &ColorTable, n_dot_l: f32, z: f32) -> Color {
        table.colors()[table.index(n_dot_l, z) as usize]
    }

    #[test]
    fn one_colour_needs_no_table() {
        assert_eq!(ColorTable::new(&Style::default()), None);
        for p in crate::PRESETS.iter().filter(|p| p.style().coloring == Coloring::None) {
            assert_eq!(ColorTable::new(&p.style()), None);
        }
    }

    #[test]
    fn the_ends_are_what_the_style_says() {
        let light = table(&[("coloring", "light")]);
        assert_eq!((at(&light, 1.0, 0.9), at(&light, -1.0, 0.1)), (WARM, COOL));
        let depth = table(&[("coloring", "depth")]);
        assert_eq!((at(&depth, -1.0, 0.0), at(&depth, 1.0, 1.0)), (WARM, COOL));
        let both = table(&[("coloring", "both")]);
        assert_eq!((at(&both, 1.0, 0.0), at(&both, -1.0, 0.0)), (WARM, COOL));
        assert_eq!((at(&both, 1.0, 1.0), at(&both, -1.0, 1.0)), (FAR, FAR));
    }

    #[test]
    fn colours_lie_between_their_neighbours() {
        for space in ["hls", "oklch"] {
            let light = table(&[("coloring", "light"), ("color_space", space), ("palette", "viridis")]);
            assert!(light.colors().len() > 60 && light.colors().len() <= ColorTable::MOST);
            let style = Style { color_space: space.parse().unwrap(), ..Style::default() };
            for k in 0..=400 {
                let n_dot_l = k as f32 / 200.0 - 1.0;
                let palette = Palette::new(PALETTES[5].1.to_vec()).unwrap();
                let exact = palette.at(f64::from(0.5 + 0.5 * n_dot_l), style.color_space);
                let drawn = at(&light, n_dot_l, 0.5);
                let off = |a: u8, b: u8| a.abs_diff(b);
                // Half a step of 63 over at most 140 levels between entries, of which there are seven.
                let worst = off(exact.r, drawn.r).max(off(exact.g, drawn.g)).max(off(exact.b, drawn.b));
                assert!(worst <= 9, "{space} {n_dot_l}: {exact} {drawn}");
            }
        }
    }

    #[test]
    fn order_is_from_cool_and_far_to_warm_and_near() {
        for by in ["light", "depth"] {
            let table = table(&[("coloring", by)]);
            let indices: Vec<u8> =
                (0..=100)
                    .map(|k| k as f32 / 100.0)
                    .map(|u| {
                        if by == "light" {
                            table.index(2.0 * u - 1.0, 0.5)
                        } else {
                            table.index(0.3, 1.0 - u)
                        }
                    })
                    .collect();
            assert!(indices.is_sorted() && indices[0] == 0, "{by}: {indices:?}");
            assert_eq!(indices[100] as usize + 1, table.colors().len());
        }
        let both = table(&[("coloring", "both")]);
        assert_eq!((both.index(0.0, 1.0), both.index(1.0, 0.0)), (0, both.colors().len() as u8 - 1));
    }

    #[test]
    fn numbers_that_lie_outside_count_as_the_ends() {
        for by in ["light", "depth", "both"] {
            let table = table(&[("coloring", by)]);
            for (n_dot_l, z) in
                [(5.0, -3.0), (-5.0, 3.0), (f32::NAN, f32::NAN), (f32::INFINITY, f32::NEG_INFINITY)]
            {
                assert!((table.index(n_dot_l, z) as usize) < table.colors().len());
            }
            assert_eq!(table.index(1.0001, -0.2), table.index(1.0, 0.0));
            assert_eq!(table.index(-1.0001, 1.2), table.index(-1.0, 1.0));
        }
    }

    #[test]
    fn steps_bound_the_colours() {
        for steps in 2..=64 {
            for by in ["light", "depth", "both"] {
                let table = table(&[("coloring", by), ("color_steps", &steps.to_string())]);
                let n = table.colors().len();
                assert!(n >= 2 && n <= steps, "{by} {steps}: {n}");
            }
        }
        // A palette in as many steps as it has entries is drawn in them.
        let four = table(&[("coloring", "light"), ("palette", "ocean"), ("color_steps", "4")]);
        assert_eq!(four.colors(), PALETTES[3].1);
        let same = table(&[("coloring", "light"), ("palette", "#123456,#123456")]);
        assert_eq!(same.colors().len(), 1);
    }

    #[test]
    fn palettes_read_back_and_are_refused_by_name() {
        let form = find_param("palette").unwrap().kind.to_string();
        let mut style = Style::default();
        for (name, colors) in PALETTES {
            assert!(form.contains(name) && Palette::new(colors.to_vec()).is_ok());
            style.set("palette", name).unwrap();
            assert_eq!(find_param("palette").unwrap().get(&style), *name);
        }
        style.set("palette", " #102030, fff ").unwrap();
        assert_eq!(find_param("palette").unwrap().get(&style), "#102030,#ffffff");
        let many = vec!["#000000"; 65].join(",");
        let endless = "#000000,".repeat(100_000);
        for bad in ["", "oceann", "#102030", "#102030,", "#102030,red", &many, &endless, "warm.gpl"] {
            let error = style.set("palette", bad).unwrap_err();
            assert!(error.contains("palette") && error.len() < 300, "{error}");
        }
        for bad in ["", "#12345", "none"] {
            assert!(style.set("outline_color", bad).unwrap_err().contains("outline_color"));
        }
        assert!(PARAMS.iter().filter(|p| p.group == "Colour").count() >= 10);
    }
}
