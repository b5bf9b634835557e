//! What a style, a page and a stock have in common, worked out once and used by every frame.

use dotwork_drawing::Page;
use dotwork_ink::tone::{ElementTone, front_limit};
use dotwork_ink::{
    Arrival, ColorTable, Coverage, DensityTable, Factors, Fraction, PapersTone, Relevance, Stock, Style, Tone,
};
use rayon::prelude::*;

use crate::relevance::Edges;

/// The density at which each of the stipples with these radii is drawn first.
fn appearances(table: &DensityTable, arrival: Arrival, radii: &[f32]) -> Vec<f32> {
    let late = if arrival.fade == dotwork_ink::Fade::Off { 1.0 } else { 1.0 + arrival.width * arrival.min };
    // A hair early: the exact test follows.
    radii.par_iter().map(|&r| (table.density(r / late) * 0.999) as f32).collect()
}

/// The tables that turn a place's tone into a decision, for one stock, style and page.
#[derive(Clone)]
pub struct InkPlan {
    pub(crate) tone: Tone,
    pub(crate) coverage: Coverage,
    pub(crate) table: DensityTable,
    /// The table's inverse, for the inner loop.
    pub(crate) spacing: Spacing,
    pub(crate) arrival: Arrival,
    /// Density at which each stipple is drawn first, per object unit squared; rises along the stock. Empty where
    /// elements have counts; 0 where edges decide, which depends on the view.
    pub(crate) appears: Vec<f32>,
    /// Radius of a dot that faces the eye, pixels.
    pub(crate) dot_radius: f32,
    /// `c ↦ c^foreshorten` for c = 0…1.
    foreshortening: Vec<f32>,
    pub(crate) grow: f32,
    /// The test of projected edges, where the style asks for it and the stock has neighbours; table and spacing are then
    /// those of the shortest edges.
    pub(crate) edges: Option<Edges>,
    /// The papers' factors, where the style asks for them.
    pub(crate) papers: Option<Papers>,
    /// The colours of dots, where they have more than one.
    pub(crate) colors: Option<ColorTable>,
}

/// What the papers' factors need.
#[derive(Clone)]
pub(crate) struct Papers {
    pub tone: PapersTone,
    /// Where the stock has elements, their tone; each then has a count of its own.
    pub elements: Option<ElementTone>,
    /// Where it has none, the density that a tone of 1 asks for, in dots per pixel squared at the depth of the centre.
    pub full: f32,
    pub fraction: Fraction,
    pub min_area_px: f32,
    /// Dots are sized by the gradient.
    pub sized: bool,
    /// Smallest cosine that is drawn.
    pub front: Option<f32>,
}

/// Density to spacing, tabulated on the bits of the density: 64 linear pieces for each factor of two.
#[derive(Clone)]
pub(crate) struct Spacing {
    /// Bits of the first tabulated density, shifted.
    first: u32,
    spacing: Vec<f32>,
}

impl Spacing {
    /// Mantissa bits below a table step.
    const SHIFT: u32 = 23 - 6;

    fn new(table: &DensityTable, octaves: u32) -> Spacing {
        // So many octaves up to the end of the stock; sparser tones than that draw nothing.
        let last = ((table.max_density() * 1.02) as f32).max(f32::MIN_POSITIVE).to_bits() >> Self::SHIFT;
        let first = last.saturating_sub(octaves << 6);
        let spacing = (first..=last + 1)
            .into_par_iter()
            .map(|key| table.spacing(f64::from(f32::from_bits(key << Self::SHIFT))))
            .collect();
        Spacing { first, spacing }
    }

    /// The spacing that gives `density`; beyond the table, that of its ends.
    #[inline(always)]
    pub fn at(&self, density: f32) -> f32 {
        let bits = density.to_bits();
        let step = (bits >> Self::SHIFT).saturating_sub(self.first) as usize;
        let Some(&[a, b]) = self.spacing.get(step..step + 2).and_then(|s| s.first_chunk()) else {
            return self.spacing[self.spacing.len() - 1];
        };
        let t = (bits & ((1 << Self::SHIFT) - 1)) as f32 * (1.0 / (1 << Self::SHIFT) as f32);
        a + (b - a) * t
    }
}

const FORESHORTENING_STEPS: usize = 1024;

/// Octaves of density that a stock is asked for.
const OCTAVES: u32 = 20;

impl InkPlan {
    /// Works out the tables.
    pub fn new(stock: &Stock, style: &Style, page: &Page) -> InkPlan {
        InkPlan::planned(stock, style, page, None, OCTAVES)
    }

    /// The tables of an endless stock: `stock` holds every stipple of at least the radius `complete`, object units, and
    /// those down to `last` can be had.
    pub fn endless(stock: &Stock, style: &Style, page: &Page, complete: f32, last: f32) -> InkPlan {
        let table = DensityTable::extended(&stock.baked, Arrival::of(style), complete, last);
        let more = 2.0 * (complete / last).max(1.0).log2().ceil();
        InkPlan::planned(stock, style, page, Some(table), OCTAVES + more as u32)
    }

    /// The same plan for a stock with further stipples of these radii, falling, at its end.
    pub fn with(&self, radii: &[f32]) -> InkPlan {
        let mut plan = self.clone();
        plan.appears.extend(appearances(&self.table, self.arrival, radii));
        plan
    }

    /// The spacing that a density in the bake asks for, object units.
    pub(crate) fn spacing_of(&self, density: f32) -> f32 {
        self.spacing.at(density)
    }

    /// The tables; that of densities is counted where none is given.
    fn planned(
        stock: &Stock,
        style: &Style,
        page: &Page,
        table: Option<DensityTable>,
        octaves: u32,
    ) -> InkPlan {
        let arrival = Arrival::of(style);
        let coverage = Coverage::new(style);
        let papers = style.factors == Factors::Papers;
        let elements = stock.elements.as_ref().filter(|_| papers);
        // The largest dot is the full size.
        let sized = style.size_max.0.filter(|_| elements.is_some());
        let dot_radius = 0.5 * sized.unwrap_or(style.dot_size).to_px(page);
        let edges = (style.relevance == Relevance::Edges).then(|| Edges::new(stock, arrival)).flatten();
        let (edges, table) = match (edges, table) {
            (Some((edges, table)), _) => (Some(edges), table),
            (None, Some(table)) => (None, table),
            (None, None) => (None, DensityTable::new(&stock.baked, arrival)),
        };
        let appears = match elements {
            Some(_) => Vec::new(),
            None if edges.is_some() => vec![0.0; stock.len()],
            None => appearances(&table, arrival, &stock.baked.radius),
        };
        let papers = papers.then(|| Papers {
            tone: PapersTone::new(style),
            elements: elements.map(|elements| ElementTone::new(style, elements)),
            full: coverage.area(style.shadow, 1.0) / (std::f32::consts::PI * dot_radius * dot_radius),
            fraction: style.fraction,
            min_area_px: style.min_area_px,
            sized: sized.is_some(),
            front: front_limit(style),
        });
        InkPlan {
            tone: Tone::new(style),
            coverage,
            spacing: Spacing::new(&table, octaves),
            table,
            arrival,
            appears,
            dot_radius,
            foreshortening: (0..=FORESHORTENING_STEPS + 1)
                .map(|i| (i as f32 / FORESHORTENING_STEPS as f32).min(1.0).powf(style.foreshorten))
                .collect(),
            grow: style.grow,
            edges,
            papers,
            colors: ColorTable::of_surface(style, &stock.tint).or_else(|| ColorTable::new(style)),
        }
    }

    /// True if no place can ask for more than the stock has, however dark.
    pub(crate) fn suffices(&self, densest: f32) -> bool {
        f64::from(densest) <= self.table.max_density()
    }

    /// True if each element of the stock has a count of its own.
    pub(crate) fn by_elements(&self) -> bool {
        self.papers.as_ref().is_some_and(|papers| papers.elements.is_some())
    }

    /// The dot's radius in pixels at cosine `c`.
    #[inline(always)]
    pub(crate) fn radius(&self, c: f32) -> f32 {
        let x = c.clamp(0.0, 1.0) * FORESHORTENING_STEPS as f32;
        let i = x as usize;
        let (a, b) = (self.foreshortening[i], self.foreshortening[i + 1]);
        self.dot_radius * (a + (b - a) * (x - i as f32))
    }

    /// What a tone asks for at cosine `c` (of the facet) with dots of radius `r` pixels: the density on the surface
    /// in dots per pixel squared (of a surface that faces the eye), and the factor by which dots grow.
    #[inline(always)]
    pub(crate) fn demand(&self, ink: f32, c: f32, r: f32) -> (f32, f32) {
        let x = self.coverage.area(ink, c);
        let (x, growth) =
            if self.grow > 0.0 && x > self.grow { (self.grow, (x / self.grow).sqrt()) } else { (x, 1.0) };
        (x * c / (std::f32::consts::PI * r * r), growth)
    }
}
