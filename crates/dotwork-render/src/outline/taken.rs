//! Which parts of the page lines have been drawn on, so that others do not run beside them.

use dotwork_drawing::Page;
use glam::Vec2;

/// Side of a cell, pixels.
const CELL: f32 = 2.0;

/// Cells of the page near lines. Memory is kept from frame to frame.
#[derive(Default)]
pub(super) struct Taken {
    columns: i32,
    rows: i32,
    reach: f32,
    near: Vec<bool>,
}

impl Taken {
    /// Begins with an empty page, on which lines take what lies up to `reach` pixels away.
    pub fn clear(&mut self, page: &Page, reach: f32) {
        self.columns = (page.width as f32 / CELL).ceil() as i32;
        self.rows = (page.height as f32 / CELL).ceil() as i32;
        self.reach = reach.min(64.0);
        self.near.clear();
        self.near.resize(self.columns as usize * self.rows as usize, false);
    }

    /// Takes what lies near the straight line between two places.
    pub fn mark(&mut self, from: Vec2, to: Vec2) {
        let steps = ((to - from).length() / CELL).ceil().clamp(1.0, 4096.0) as u32;
        let reach = (self.reach / CELL).ceil() as i32;
        for s in 0..=steps {
            let at = from.lerp(to, s as f32 / steps as f32) / CELL;
            let (x, y) = (at.x as i32, at.y as i32);
            for row in (y - reach).max(0)..(y + reach + 1).min(self.rows) {
                for column in (x - reach).max(0)..(x + reach + 1).min(self.columns) {
                    let off = Vec2::new(column as f32 + 0.5, row as f32 + 0.5) - at;
                    if off.length() * CELL <= self.reach {
                        self.near[(row * self.columns + column) as usize] = true;
                    }
                }
            }
        }
    }

    /// Whether a place is near a line.
    pub fn near(&self, at: Vec2) -> bool {
        let (column, row) = ((at.x / CELL).floor() as i32, (at.y / CELL).floor() as i32);
        let on_page = column >= 0 && row >= 0 && column < self.columns && row < self.rows;
        on_page && self.near[(row * self.columns + column) as usize]
    }
}
