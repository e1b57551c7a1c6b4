//! How much memory a scene will take, before it takes any.

use super::Checker;
use crate::build::scheme;
use crate::error::Detail;
use crate::pace::Pace;
use crate::scene::{Fluid, Model, Scene, TimeStep};
use crate::solid::Solid;
use crate::spec::{Flow, Integrator, Medium, Precision, Shape, SourceSpec};
use cf_fluid::Scheme;
use cf_output::Volume;

/// What a run may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Memory \[bytes\].
    pub memory: u64,
}

impl Limits {
    /// All the memory of this machine, or 1 TiB where it cannot be found out.
    pub fn of_this_machine() -> Self {
        let kilobytes = std::fs::read_to_string("/proc/meminfo").ok().and_then(|table| total_kilobytes(&table));
        Limits { memory: kilobytes.map_or(1 << 40, |kilobytes| kilobytes.saturating_mul(1024)) }
    }
}

fn total_kilobytes(table: &str) -> Option<u64> {
    let line = table.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    line.split_whitespace().next()?.parse().ok()
}

/// Predicted memory, field by field. The integrators and solvers decide the truth; this is meant to be a little high.
#[derive(Clone, Debug, PartialEq)]
pub struct MemoryTable {
    /// One row per field or group of fields.
    pub rows: Vec<MemoryRow>,
}

/// A field or group of fields.
#[derive(Clone, Debug, PartialEq)]
pub struct MemoryRow {
    /// What it is.
    pub name: &'static str,
    /// Its size \[bytes\].
    pub bytes: u64,
}

impl MemoryTable {
    /// The sum \[bytes\].
    pub fn total(&self) -> u64 {
        self.rows.iter().fold(0, |sum, row| sum.saturating_add(row.bytes))
    }
}

impl Scene {
    /// The memory this run is predicted to take.
    pub fn memory(&self) -> MemoryTable {
        let slots = self.grid.cells.iter().fold(1u64, |product, n| product.saturating_mul(*n as u64 + 2));
        let word = if self.numerics.precision == Precision::F32 { 4 } else { 8 };
        let mut rows = Vec::new();
        let mut add = |name, arrays: f64, bytes: u64| {
            if arrays > 0.0 {
                rows.push(MemoryRow { name, bytes: (arrays * slots as f64 * bytes as f64) as u64 });
            }
        };
        let d = self.grid.dimension() as f64;
        let Model::Diffusion(model) = &self.model else {
            add("phi and flux, with work space", 6.0, word);
            return MemoryTable { rows };
        };
        let integrator = Pace::of(self).integrator;
        let (flux, moves) = (if model.law.has_memory() { d } else { 0.0 }, self.moves());
        let prescribed = matches!(model.medium, Medium::Analytic(Flow::Rotation { .. } | Flow::Deformation { .. }));
        add("phi", 1.0, word);
        add("q_C", flux, word);
        add("sources", self.share_of_sources(&model.sources), word);
        add("velocity", if prescribed { d } else { 0.0 }, word);
        // x and b of the coarser levels, a quarter or an eighth of the cells each.
        let levels = if self.grid.dimension() == 2 { 0.7 } else { 0.35 };
        if let Some(fluid) = &model.fluid {
            let scheme = scheme(self.numerics.flow);
            let stages = if scheme == Scheme::CentralRk4 { 2.0 * d } else { 0.0 };
            add("flow: u, u before, stages", if scheme.keeps_before() { 2.0 * d } else { d } + stages, word);
            let pressure = if scheme.keeps_pressure() { 1.0 } else { 0.0 };
            add("flow: pressure and potentials", pressure + scheme.potentials() as f64, word);
            // Solves take four; a velocity is in the making while phi is carried, or two while it carries itself.
            let lifted = if fluid.buoyancy.is_some() { 4.0 + d } else { 4.0 };
            let shared = match scheme {
                Scheme::Cnp => lifted,
                Scheme::Auto => f64::max(lifted, 2.0 * d),
                Scheme::ReflectionExtrapolated => f64::max(4.0, 2.0 * d),
                Scheme::Draft | Scheme::CentralRk4 => 4.0 + d,
            };
            let taken = "velocities, solver vectors and buffers that flow, transport and diffusion take in turn";
            add(taken, shared + levels, word);
            let walls = !Solid::of(self).is_empty() || model.fluid.as_ref().is_some_and(Fluid::holds);
            add("flow: face weights on all levels, masks", if walls { d + 7.0 } else { 0.0 }, word);
        }
        // A solved flow shares its scratch.
        let own = model.fluid.is_none();
        let buffers = if own && moves && integrator != Some(Integrator::Characteristic) { 2.0 } else { 0.0 };
        add("advection buffers", buffers, word);
        let solver = if own { 4.0 + levels } else { 0.0 };
        match integrator {
            None | Some(Integrator::Kdk) => {}
            Some(Integrator::Characteristic) => add("step buffers", 2.0, word),
            Some(Integrator::PaperBe) => add("solver vectors and levels", solver, word),
            Some(Integrator::Sdirk2) => {
                add("first stage", if own { 1.0 + flux } else { 0.0 }, word);
                add("solver vectors and levels", solver, word);
            }
        }
        if matches!(self.numerics.step, TimeStep::Adaptive(_)) {
            add("state to go back to, difference of the stages", 2.0 * (1.0 + flux), word);
        } else if model.fluid.is_none() {
            add("samples of the error", 2.0 + flux, word);
        }
        add(
            "preconditioner in single precision",
            if self.numerics.precision == Precision::Mixed { 2.5 } else { 0.0 },
            4,
        );
        add("face weights and diagonal", if Solid::of(self).is_empty() { 0.0 } else { d + 1.0 }, word);
        // Files are written row by row; a cloud has at most `Volume::MOST` voxels along an axis.
        let (most, longest) = (Volume::MOST, self.grid.cells.iter().copied().max().unwrap_or(1));
        let voxels = (1.0 / longest.div_ceil(most) as f64).powi(3);
        add("voxels of pictures", if self.output.volume.is_some() { 2.0 * voxels } else { 0.0 }, 4);
        MemoryTable { rows }
    }
}

impl Scene {
    /// The share of a field that the planes of its sources take.
    fn share_of_sources(&self, sources: &[SourceSpec]) -> f64 {
        let last = self.grid.dimension() - 1;
        let (start, length) = (self.grid.origin[last], self.grid.extent[last]);
        let bounds = sources.iter().filter(|source| source.rate.is_some()).map(|source| match &source.shape {
            Shape::Gaussian { .. } => (start, start + length),
            shape => shape.bounds(last),
        });
        let (low, high) =
            bounds.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), (low, high)| (l.min(low), h.max(high)));
        // One plane more on either side.
        let planes = (high - low) / self.grid.spacing + 3.0;
        if low <= high { (planes / self.grid.cells[last] as f64).min(1.0) } else { 0.0 }
    }
}

/// Refuses a scene larger than the limit.
pub(super) fn fits(check: &mut Checker<'_>, scene: &Scene, limits: &Limits) {
    let total = scene.memory().total();
    check.require(total <= limits.memory, "grid.cells", || {
        Detail::new(format!("this run needs about {}, the machine has {}", gigabytes(total), gigabytes(limits.memory)))
            .advice("use fewer cells, a smaller preset or precision: f32")
    });
}

fn gigabytes(bytes: u64) -> String {
    let size = bytes as f64 / 1e9;
    if size < 0.1 { format!("{:.3} GB", size) } else { format!("{size:.1} GB") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_memory_of_a_machine_is_read_from_its_table() {
        assert_eq!(total_kilobytes("MemTotal:       24599108 kB\nMemFree: 1 kB\n"), Some(24_599_108));
        assert_eq!(total_kilobytes("MemFree: 1 kB\n"), None);
        assert_eq!(total_kilobytes("MemTotal: lots\n"), None);
        assert!(Limits::of_this_machine().memory > 1 << 20);
    }
}
