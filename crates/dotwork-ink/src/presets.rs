//! The presets: styles with a name and a one-line reason.

use dotwork_drawing::{Color, Length};

use crate::params::{
    BakeMethod, Clip, Coloring, Factors, Fade, FeatureChoice, Fraction, Inked, OutlineColor, PaletteChoice,
    SizeMax, Style, SurfaceChoice, Visibility,
};

/// A named style.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    /// Name, as in `--style NAME`.
    pub name: &'static str,
    /// What it is for, in one line.
    pub summary: &'static str,
    make: fn() -> Style,
}

impl Preset {
    /// The style.
    pub fn style(&self) -> Style {
        (self.make)()
    }
}

/// All presets, the default first.
pub const PRESETS: &[Preset] = &[
    Preset {
        name: "soft",
        summary: "Even shading from a soft light: the scientific plate. The default.",
        make: Style::default,
    },
    Preset { name: "hard", summary: "Strong light and deep shadow: relief, texture, stone.", make: hard },
    Preset {
        name: "high-key",
        summary: "Mostly bare paper, fine dots: delicate forms and labels drawn over them.",
        make: high_key,
    },
    Preset { name: "night", summary: "White dots on black, with a lit rim.", make: night },
    Preset {
        name: "engraving",
        summary: "Very fine dots and full tones: close to a mezzotint.",
        make: engraving,
    },
    Preset { name: "sepia", summary: "Warm brown ink on cream paper, a looser hand.", make: sepia },
    Preset {
        name: "warm-cool",
        summary: "Colours by the light: orange where it falls, blue in the shade.",
        make: warm_cool,
    },
    Preset {
        name: "aerial",
        summary: "Colours by depth: near parts dark and warm, far ones blue and pale.",
        make: aerial,
    },
    Preset {
        name: "bone",
        summary: "The densest feature of a volume in a hard light: skulls, skeletons.",
        make: bone,
    },
    Preset { name: "skin", summary: "A soft surface without hard shadows: faces, soft tissue.", make: skin },
    Preset {
        name: "ghost",
        summary: "A translucent body: its form, and faintly what lies within.",
        make: ghost,
    },
    Preset {
        name: "xray",
        summary: "Every surface that turns away from the eye, through everything before it.",
        make: xray,
    },
    Preset {
        name: "brain-cutaway",
        summary: "A quarter cut away, its values on the cut: an MR brain reads only so.",
        make: brain_cutaway,
    },
    Preset {
        name: "industrial",
        summary: "Even tones and firm outlines: cast and machined parts.",
        make: industrial,
    },
    Preset {
        name: "microscopy",
        summary: "Noise smoothed away, specks dropped, fine dots: confocal stacks and the like.",
        make: microscopy,
    },
    Preset {
        name: "outline",
        summary: "Lines alone: outlines, borders and sharp edges; --set dots=true adds the dots.",
        make: outline,
    },
    Preset {
        name: "flat",
        summary: "For measuring: one uniform tone (--set tone=0.3), every other factor off.",
        make: flat,
    },
    Preset {
        name: "lambert",
        summary: "For measuring: tone * (1 - max(0, n.L)) and nothing else.",
        make: lambert,
    },
    Preset {
        name: "papers",
        summary: "Lu et al. 2002 and 2003: lists of dots in voxels, thinned by a product of factors; nothing hides.",
        make: papers,
    },
    Preset {
        name: "papers-plain",
        summary: "The papers' default rendering: every boundary alike (2002, figure 1 a).",
        make: papers_plain,
    },
    Preset {
        name: "papers-boundary",
        summary: "Boundary and silhouette enhancement with silhouette curves (2002, figure 1 b; 2003, 5 and 10 a).",
        make: papers_boundary,
    },
    Preset {
        name: "papers-distance",
        summary: "Distance attenuation: near parts dark, far ones pale (2002, figure 5; 2003, 10 b).",
        make: papers_distance,
    },
    Preset {
        name: "papers-interior",
        summary: "Interior enhancement: weak gradients let one look through (2002, figure 6; 2003, 11).",
        make: papers_interior,
    },
    Preset {
        name: "papers-lighting",
        summary: "Lighting: dots in the shade, bare paper in the light (2002, figure 7).",
        make: papers_lighting,
    },
    Preset {
        name: "papers-curves",
        summary: "Light stippling held together by silhouette curves (2002, figure 8; 2003, 13).",
        make: papers_curves,
    },
    Preset {
        name: "papers-all",
        summary: "Silhouette, boundary, distance and curves together (2002, figure 9; 2003, 17).",
        make: papers_all,
    },
    Preset {
        name: "papers-surface",
        summary: "Surfaces: lists of dots in faces, thinned by resolution and light (2003, figures 7 to 9, 12, 15, 16).",
        make: papers_surface,
    },
];

/// The style of a preset.
pub fn preset(name: &str) -> Option<Style> {
    PRESETS.iter().find(|p| p.name == name).map(Preset::style)
}

fn hard() -> Style {
    Style {
        base: 0.0,
        wrap: 0.0,
        gamma: 2.0,
        silhouette: 0.2,
        silhouette_power: 8.0,
        highlight: 0.05,
        shadow: 0.98,
        dot_size: Length::percent(0.26),
        ..Style::default()
    }
}

fn high_key() -> Style {
    Style {
        base: 0.0,
        light: 0.7,
        wrap: 0.35,
        gamma: 1.8,
        silhouette: 0.45,
        silhouette_power: 4.0,
        highlight: 0.015,
        dot_size: Length::percent(0.18),
        ..Style::default()
    }
}

fn night() -> Style {
    Style {
        inked: Inked::Light,
        base: 0.01,
        light: 0.9,
        wrap: 0.1,
        gamma: 1.6,
        silhouette: 0.5,
        silhouette_power: 4.0,
        color: Color::WHITE,
        paper: Color { r: 0x0b, g: 0x0c, b: 0x10 },
        ..Style::default()
    }
}

fn engraving() -> Style {
    Style { base: 0.05, gamma: 1.3, dot_size: Length::percent(0.15), ..Style::default() }
}

fn warm_cool() -> Style {
    Style {
        // Light parts need dots to show their colour.
        base: 0.2,
        light: 0.72,
        gamma: 1.3,
        coloring: Coloring::Light,
        palette: PaletteChoice::Named("blue-orange"),
        outline_color: OutlineColor(Some(Color { r: 0x1c, g: 0x2f, b: 0x66 })),
        ..Style::default()
    }
}

fn aerial() -> Style {
    Style {
        base: 0.06,
        coloring: Coloring::Depth,
        palette: PaletteChoice::Named("aerial"),
        outline_color: OutlineColor(Some(Color { r: 0x3a, g: 0x4a, b: 0x6e })),
        ..Style::default()
    }
}

fn sepia() -> Style {
    Style {
        regularity: 0.3,
        dot_size: Length::percent(0.28),
        color: Color { r: 0x4a, g: 0x2c, b: 0x17 },
        paper: Color { r: 0xf7, g: 0xf0, b: 0xe1 },
        ..Style::default()
    }
}

fn bone() -> Style {
    Style {
        feature: FeatureChoice::Dense,
        base: 0.0,
        wrap: 0.15,
        gamma: 1.8,
        shadow: 0.97,
        ..Style::default()
    }
}

fn skin() -> Style {
    Style { smooth: 0.8, wrap: 0.45, gamma: 1.5, dot_size: Length::percent(0.2), ..Style::default() }
}

fn ghost() -> Style {
    Style {
        occlusion: 0.12,
        base: 0.0,
        light: 0.5,
        silhouette: 0.5,
        silhouette_power: 3.0,
        ..Style::default()
    }
}

fn xray() -> Style {
    Style {
        occlusion: 0.05,
        base: 0.0,
        light: 0.0,
        silhouette: 1.0,
        silhouette_power: 3.0,
        // Lines tell what is nearer and where a form ends; dots alone blur where many overlap.
        outline: Length::percent(0.12),
        dot_size: Length::percent(0.18),
        // Seen through each other, surfaces must lie on their boundaries, not merely near them.
        surface: SurfaceChoice::Ridge,
        ..Style::default()
    }
}

fn brain_cutaway() -> Style {
    Style { clip: Clip::Planes("x>0.53;z>0.44".into()), dot_size: Length::percent(0.2), ..Style::default() }
}

fn industrial() -> Style {
    Style {
        base: 0.03,
        wrap: 0.1,
        gamma: 1.4,
        silhouette: 0.15,
        outline: Length::percent(0.26),
        creases: true,
        ..Style::default()
    }
}

fn microscopy() -> Style {
    Style { smooth: 1.5, dot_size: Length::percent(0.18), silhouette: 0.4, ..Style::default() }
}

fn outline() -> Style {
    Style { dots: false, creases: true, ..Style::default() }
}

fn flat() -> Style {
    Style {
        tone: 0.5,
        base: 1.0,
        light: 0.0,
        silhouette: 0.0,
        back: 0.0,
        outlines: false,
        ..Style::default()
    }
}

fn lambert() -> Style {
    Style {
        tone: 0.8,
        base: 0.0,
        light: 1.0,
        wrap: 0.0,
        gamma: 1.0,
        silhouette: 0.0,
        back: 0.0,
        outlines: false,
        ..Style::default()
    }
}

/// The papers print values for few of their factors; these give 10 to 20 % of ink on the phantoms.
fn papers() -> Style {
    Style {
        factors: Factors::Papers,
        bake: BakeMethod::Voxel,
        k_max: 0.2,
        boundary: true,
        k_gc: 0.4,
        k_gs: 1.4,
        silhouette: 1.0,
        k_sc: 0.35,
        k_ss: 2.0,
        k_se: 2.0,
        resolution: 1.0,
        lighting: true,
        distance: 1.0,
        interior: false,
        front_angle: 90.0,
        visibility: Visibility::Through,
        size_max: SizeMax(Some(Length::percent(0.3))),
        foreshorten: 0.0,
        fade: Fade::Ink,
        grow: 0.0,
        back: 0.0,
        outlines: false,
        ..Style::default()
    }
}

/// The papers' way without any of their factors.
fn bare_papers() -> Style {
    Style {
        boundary: false,
        silhouette: 0.0,
        resolution: 0.0,
        lighting: false,
        distance: 0.0,
        interior: false,
        ..papers()
    }
}

fn papers_plain() -> Style {
    // Less than a dot a voxel: all boundaries would be black.
    Style { tone: 0.012, fraction: Fraction::Ink, size_max: SizeMax(None), ..bare_papers() }
}

/// With the values under the figure: k_gc 0.39, k_gs 0.51, k_ge 1, k_sc 0.279, k_ss 0.45, k_se 1.11.
fn papers_boundary() -> Style {
    let plain = Style::default();
    Style {
        boundary: true,
        silhouette: 1.0,
        k_gc: plain.k_gc,
        k_gs: plain.k_gs,
        k_sc: plain.k_sc,
        k_ss: plain.k_ss,
        k_se: plain.k_se,
        curves: true,
        ..bare_papers()
    }
}

fn papers_distance() -> Style {
    Style { distance: 1.0, k_de: 1.2, lighting: false, resolution: 0.0, ..papers() }
}

fn papers_interior() -> Style {
    Style {
        interior: true,
        k_ie: 1.5,
        tone: 0.7,
        distance: 0.0,
        lighting: false,
        resolution: 0.0,
        ..papers()
    }
}

fn papers_lighting() -> Style {
    Style { lighting: true, k_le: 1.0, boundary: true, silhouette: 1.0, ..bare_papers() }
}

fn papers_curves() -> Style {
    Style { lighting: true, k_le: 0.6, curves: true, ..papers_boundary() }
}

/// With the values under the figure: k_gc 0.4, k_gs 0, k_ge 10, k_sc 0.5, k_ss 5, k_se 1, k_de 0.9.
fn papers_all() -> Style {
    Style {
        boundary: true,
        k_gc: 0.4,
        k_gs: 0.0,
        k_ge: 10.0,
        silhouette: 1.0,
        k_sc: 0.5,
        k_ss: 5.0,
        k_se: 1.0,
        distance: 1.0,
        k_de: 0.9,
        curves: true,
        ..bare_papers()
    }
}

/// All the factors that surfaces have but distance, which is told by what hides what.
fn papers_surface() -> Style {
    Style {
        bake: BakeMethod::Face,
        visibility: Visibility::Solid,
        resolution: 1.0,
        lighting: true,
        size_max: SizeMax(None),
        outlines: true,
        ..bare_papers()
    }
}
