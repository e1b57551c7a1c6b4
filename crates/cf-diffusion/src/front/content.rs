//! From fields to waves and back.

use cf_grid::Real;

/// K fields that are K waves.
pub(super) trait Content<T, const K: usize>: Copy + Sync {
    /// How much of what the waves lose is phi.
    const PHI: f64;
    /// The waves of equally long rows of the fields.
    fn waves(self, fields: [&[T]; K], waves: [&mut [T]; K]);
    /// The fields after the waves have lost what they lose.
    fn update(self, loss: [&[T]; K], fields: [&mut [T]; K]);
}

/// phi and the component of q along the axis. The flux relaxes by e^{-dt/2tau} before and after the sweep: no other
/// sweep mixes it with phi, so the two halves of a step's relaxation belong here and cost no pass of their own.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sound<T> {
    /// e^{-dt/2tau}/c \[s/m\].
    gain: T,
    /// e^{-dt/tau}.
    keep: T,
    /// c e^{-dt/2tau}/2 \[m/s\].
    half: T,
}

impl<T: Real> Sound<T> {
    pub fn new(c: f64, tau: f64, dt: f64) -> Self {
        let e = (-0.5 * dt / tau).exp();
        Self { gain: T::of(e / c), keep: T::of(e * e), half: T::of(0.5 * c * e) }
    }
}

impl<T: Real> Content<T, 2> for Sound<T> {
    const PHI: f64 = 0.5;

    #[inline(always)]
    fn waves(self, [phi, q]: [&[T]; 2], [plus, minus]: [&mut [T]; 2]) {
        for (((plus, minus), &phi), &q) in plus.iter_mut().zip(minus).zip(phi).zip(q) {
            let v = self.gain * q;
            (*plus, *minus) = (phi + v, phi - v);
        }
    }

    #[inline(always)]
    fn update(self, [plus, minus]: [&[T]; 2], [phi, q]: [&mut [T]; 2]) {
        let half = T::of(0.5);
        for (((phi, q), &plus), &minus) in phi.iter_mut().zip(q).zip(plus).zip(minus) {
            *phi = flushed(*phi - half * (plus + minus));
            *q = flushed(self.keep * *q - self.half * (plus - minus));
        }
    }
}

/// Zero for what is about to lose digits to underflow. Ahead of a front values fall by a factor per cell, and
/// arithmetic on subnormal numbers is many times slower.
#[inline(always)]
fn flushed<T: Real>(value: T) -> T {
    let least = if size_of::<T>() == 4 { 1e-36 } else { 1e-300 };
    if value.abs() < T::of(least) { T::ZERO } else { value }
}

/// A component of q across the axis, carried by the medium.
#[derive(Debug, Clone, Copy)]
pub(super) struct Carried;

impl<T: Real> Content<T, 1> for Carried {
    const PHI: f64 = 0.0;

    #[inline(always)]
    fn waves(self, [q]: [&[T]; 1], [wave]: [&mut [T]; 1]) {
        wave.copy_from_slice(q);
    }

    #[inline(always)]
    fn update(self, [loss]: [&[T]; 1], [q]: [&mut [T]; 1]) {
        for (q, &loss) in q.iter_mut().zip(loss) {
            *q = flushed(*q - loss);
        }
    }
}
