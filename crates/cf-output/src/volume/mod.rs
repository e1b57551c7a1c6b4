//! Volume rendering: a scalar field in a box as a cloud of ink or smoke, lit and shaded.
//!
//! Along the ray of a pixel, from the eye into the box, each colour channel is the emission-absorption integral
//! (Max 1995)
//!
//! ```text
//! C = ∫ T(s) sigma(s) (albedo · (ambient + (1 - ambient) L(s)) + glow) ds + T(end) · background
//! T(s) = exp(-∫ sigma ds up to s),   sigma = extinction · v,   v = the field, scaled to 0..1
//! L = exp(-shadow · ∫ sigma ds towards the light)
//! ```
//!
//! [`Volume`] holds v on at most [`Volume::MOST`] voxels along an axis, blocks of cells averaged, with the optical depth
//! towards the light on a grid as coarse as looks good. Rays march by three quarters of a voxel with trilinear
//! interpolation and jump over empty blocks; fields of few voxels are refined by cubics first. Solids are an opaque surface
//! of a material of their own, given by the distance to it and shaded by its slope.

mod camera;
mod field;
mod march;
mod solid;

use crate::OutputError;
use crate::canvas::{Canvas, MAX_SIDE};
use crate::color::Rgb;
use crate::font;
use crate::surface::{Anchor, Pen, Surface};
pub use field::Volume;
pub use solid::smooth_mask;

use camera::Camera;

/// What a cloud is made of. Channels are red, green, blue of linear light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Optical depth along the longest edge of the box where the field is at the top of its range.
    pub extinction: [f64; 3],
    /// Share of the extinguished light that is scattered to the eye, 0 to 1.
    pub albedo: [f64; 3],
    /// Light of its own.
    pub glow: [f64; 3],
    /// Share of the light that comes from everywhere, 0 to 1.
    pub ambient: f64,
    /// Weight of the shadow that the cloud throws on itself; 0 for none.
    pub shadow: f64,
}

impl Material {
    /// Blue-black ink in clear water: red and green are absorbed first.
    pub const INK: Self =
        Self { extinction: [34.0, 22.0, 9.0], albedo: [0.03, 0.06, 0.22], glow: [0.0; 3], ambient: 0.65, shadow: 0.35 };
    /// White smoke.
    pub const SMOKE: Self =
        Self { extinction: [24.0; 3], albedo: [0.95, 0.93, 0.9], glow: [0.0; 3], ambient: 0.22, shadow: 0.6 };
    /// Something hot.
    pub const FIRE: Self =
        Self { extinction: [6.0, 9.0, 14.0], albedo: [0.0; 3], glow: [3.0, 1.1, 0.3], ambient: 1.0, shadow: 0.0 };
}

/// How a volume is looked at; start from `Look::default()` and change what matters.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// The axis that points up in the picture.
    pub up: usize,
    /// Where the eye is around the box, degrees, and above its middle plane, degrees.
    pub eye: [f64; 2],
    /// Where the light is, the same way.
    pub light: [f64; 2],
    /// Values of the field that are 0 and 1 of the material; values beyond them count as these.
    pub range: [f64; 2],
    /// The cloud.
    pub material: Material,
    /// The colour of solids.
    pub solid: [f64; 3],
    /// The low and the high corner of what is to fill the picture; the whole box unless given.
    pub frame: Option<[[f64; 3]; 2]>,
    /// Colours behind it, top and bottom.
    pub background: [Rgb; 2],
    /// Draw the edges of the box.
    pub edges: bool,
    /// Top left.
    pub title: String,
    /// Top right.
    pub time: String,
    /// Bottom left, such as what the densest cloud stands for.
    pub note: String,
}

impl Default for Look {
    fn default() -> Self {
        Self {
            size: [640, 800],
            up: 1,
            eye: [28.0, 14.0],
            light: [-50.0, 55.0],
            range: [0.0, 1.0],
            material: Material::SMOKE,
            solid: [0.26, 0.14, 0.085],
            frame: None,
            background: [[20, 26, 38], [52, 60, 74]],
            edges: true,
            title: String::new(),
            time: String::new(),
            note: String::new(),
        }
    }
}

impl Look {
    /// Ink in water in front of a light wall.
    pub fn ink() -> Self {
        Self {
            material: Material::INK,
            solid: [0.5, 0.42, 0.34],
            background: [[247, 249, 251], [214, 226, 235]],
            ..Self::default()
        }
    }

    /// The same, `height` pixels high and as wide as what is shown needs, but no more than twice as wide or narrow as high.
    pub fn fitted(self, volume: &Volume, height: usize) -> Self {
        let all = [0.0, 0.0, 1.0, 1.0];
        let aspect = Camera::new(volume.corners(), &Self { up: self.up.min(2), ..self.clone() }, all).aspect;
        let width = height as f64 * aspect.clamp(0.5, 2.0);
        Self { size: [width.round() as usize, height], ..self }
    }
}

/// Light of 1 in a pixel's number, and back: the sRGB curve.
fn encode(light: f64) -> u8 {
    let v = light.clamp(0.0, 1.0);
    let v = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
    (255.0 * v).round() as u8
}

fn decode(number: u8) -> f64 {
    let v = f64::from(number) / 255.0;
    if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

const TITLE: f64 = 12.0;
const NOTE: f64 = 10.0;
const PAD: f64 = 14.0;

/// Draws a volume. The same volume and look give the same picture for any number of threads.
///
/// # Errors
/// [`OutputError::Request`] for a picture without size, angles or colours that are no numbers, or an axis beyond z.
pub fn render(volume: &Volume, look: &Look) -> Result<Canvas, OutputError> {
    check(look)?;
    let [width, height] = look.size;
    let ink = if look.background[0].iter().map(|c| u32::from(*c)).sum::<u32>() > 384 { [30, 36, 44] } else { [225; 3] };
    let heads = if look.title.is_empty() && look.time.is_empty() { 0.0 } else { TITLE + PAD };
    let foot = if look.note.is_empty() { 0.0 } else { NOTE + PAD };
    let camera = Camera::new(volume.corners(), look, [0.0, heads, width as f64, height as f64 - foot]);
    let mut canvas = Canvas::new(width, height, look.background[0]);
    backdrop(&mut canvas, look.background);
    // Edges of a box that goes on beyond the picture stay clear of what is written on it.
    let clip = [0.0, heads, width as f64, height as f64];
    let pen = |alpha: f64| Pen { alpha, ..Pen::new(1.2, ink) };
    let (behind, before) = camera.edges();
    if look.edges {
        behind.iter().for_each(|edge| canvas.line(edge, pen(0.45), clip));
    }
    march::through(&mut canvas, &volume.prepared(look.range), &camera, look);
    if look.edges {
        before.iter().for_each(|edge| canvas.line(edge, pen(0.6), clip));
    }
    let base = PAD + TITLE;
    canvas.text([PAD, base], &look.title, TITLE, ink, Anchor::Start, false);
    let room = width as f64 - 2.0 * PAD - font::width(&look.title, TITLE);
    if font::width(&look.time, TITLE) < room {
        canvas.text([width as f64 - PAD, base], &look.time, TITLE, ink, Anchor::End, false);
    }
    canvas.text([PAD, height as f64 - PAD], &look.note, NOTE, ink, Anchor::Start, false);
    Ok(canvas)
}

fn check(look: &Look) -> Result<(), OutputError> {
    let refuse = |reason: String| Err(OutputError::request("volume picture", reason));
    if look.size.iter().any(|n| !(16..=MAX_SIDE).contains(n)) {
        return refuse(format!("{:?} pixels; give 16 to {MAX_SIDE} each", look.size));
    }
    if look.up > 2 {
        return refuse(format!("axis {} cannot point up; give 0, 1 or 2", look.up));
    }
    if ![look.eye, look.light].as_flattened().iter().all(|angle| angle.is_finite()) {
        return refuse(format!("the eye at {:?} and the light at {:?} degrees", look.eye, look.light));
    }
    let [low, high] = look.range;
    if !(low.is_finite() && high.is_finite() && high > low) {
        return refuse(format!("the range {low} to {high} is empty"));
    }
    if let Some([low, high]) = look.frame
        && !(0..3).all(|a| low[a].is_finite() && high[a].is_finite() && high[a] > low[a])
    {
        return refuse(format!("there is nothing between the corners {low:?} and {high:?}"));
    }
    let m = &look.material;
    let numbers = [m.extinction, m.albedo, m.glow, look.solid, [m.ambient, m.shadow, 0.0]];
    if !numbers.as_flattened().iter().all(|v| v.is_finite() && *v >= 0.0) {
        return refuse(format!("{m:?} has a number that is negative or not finite"));
    }
    Ok(())
}

fn backdrop(canvas: &mut Canvas, [top, bottom]: [Rgb; 2]) {
    let (width, height) = (canvas.width(), canvas.height());
    for y in 0..height {
        let share = (y as f64 + 0.5) / height as f64;
        let color = std::array::from_fn(|c| {
            (f64::from(top[c]) + share * (f64::from(bottom[c]) - f64::from(top[c]))).round() as u8
        });
        (0..width).for_each(|x| canvas.set(x, y, color));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::array::Array;

    fn slab(value: f32) -> Volume {
        let array = Array::per_cell("phi", [24, 20, 16], move |_| [value]);
        Volume::new(&array, [0.0; 3], [0.5; 3]).unwrap()
    }

    fn plain(material: Material) -> Look {
        Look {
            size: [64, 64],
            eye: [0.0, 0.0],
            up: 1,
            edges: false,
            material,
            background: [[188; 3]; 2],
            ..Look::default()
        }
    }

    fn middle(volume: &Volume, look: &Look) -> f64 {
        decode(render(volume, look).unwrap().get(32, 32).unwrap()[0])
    }

    #[test]
    fn absorption_is_beer_and_lambert() {
        // The eye looks along z through 16 of 24 cells of the longest edge, half full: optical depth e · 2/3 · 1/2.
        for depth in [0.3, 1.5] {
            let material =
                Material { extinction: [depth; 3], albedo: [0.0; 3], glow: [0.0; 3], ambient: 1.0, shadow: 0.0 };
            let expected = decode(188) * (-depth * 16.0 / 24.0 * 0.5_f64).exp();
            let found = middle(&slab(0.5), &plain(material));
            assert!((found - expected).abs() < 0.006, "{found} {expected}");
        }
    }

    #[test]
    fn a_thick_cloud_has_its_own_colour_and_nothing_shows_the_background() {
        let material = Material { extinction: [1e4; 3], albedo: [0.5; 3], glow: [0.0; 3], ambient: 1.0, shadow: 0.0 };
        assert!((middle(&slab(1.0), &plain(material)) - 0.5).abs() < 0.006);
        assert!((middle(&slab(0.0), &plain(material)) - decode(188)).abs() < 0.004);
        let glowing = Material { albedo: [0.0; 3], glow: [0.25; 3], ..material };
        assert!((middle(&slab(1.0), &plain(glowing)) - 0.25).abs() < 0.006);
    }

    #[test]
    fn a_cloud_shadows_itself() {
        let lit = Material { extinction: [8.0; 3], albedo: [0.8; 3], glow: [0.0; 3], ambient: 0.0, shadow: 0.0 };
        let open = middle(&slab(1.0), &plain(lit));
        let dark = middle(&slab(1.0), &plain(Material { shadow: 1.0, ..lit }));
        assert!(dark < 0.7 * open, "{dark} {open}");
    }

    #[test]
    fn solids_hide_what_is_behind_them() {
        let mut volume = slab(0.0);
        volume.set_solid(|p| (4.0 - p[2]).max((p[0] - 6.0).abs() - 3.0).max((p[1] - 5.0).abs() - 2.5));
        let canvas = render(&volume, &plain(Material::SMOKE)).unwrap();
        let (inside, outside) = (canvas.get(32, 32).unwrap(), canvas.get(2, 32).unwrap());
        assert_ne!(inside, outside);
        assert_eq!(outside, [188; 3]);
    }

    /// A ball in clear air, its light from the eye.
    fn ball(mask: bool) -> Canvas {
        let array = Array::per_cell("phi", [24; 3], |_| [0.0f32]);
        let mut volume = Volume::new(&array, [0.0; 3], [0.5; 3]).unwrap();
        let from = |p: [f64; 3]| p.map(|x| x - 6.0).iter().map(|x| x * x).sum::<f64>().sqrt() - 4.0;
        if mask {
            let within = move |c: [usize; 3]| from(c.map(|i| 0.5 * (i as f64 + 0.5))) <= 0.0;
            volume.set_solid(smooth_mask([24; 3], [0.0; 3], [0.5; 3], &within));
        } else {
            volume.set_solid(from);
        }
        let look = Look { size: [200, 200], light: [0.0, 0.0], solid: [0.4, 0.2, 0.1], ..plain(Material::SMOKE) };
        render(&volume, &look).unwrap()
    }

    #[test]
    fn a_ball_has_the_colour_of_solids_and_darkens_smoothly_towards_its_rim() {
        let middle = |canvas: &Canvas| canvas.get(100, 106).unwrap().map(decode);
        for mask in [false, true] {
            let canvas = ball(mask);
            let [red, green, blue] = middle(&canvas);
            // A highlight lies over it: red to green to blue as 4 to 2 to 1 without.
            assert!(red > 1.4 * green && green > 1.2 * blue, "{red} {green} {blue}");
            // Rings around the middle have one colour: no stairs, no blotches.
            let centre = [100.0, 100.0];
            let ring = |radius: f64| -> Vec<f64> {
                let at = |n: i32| {
                    let (sin, cos) = (f64::from(n) * 0.1).sin_cos();
                    // As bright above as below, but for the sky; left and right alike.
                    canvas.get((centre[0] + radius * cos) as usize, (centre[1] + radius * sin) as usize).unwrap()
                };
                (0..62).map(|n| decode(at(n)[0])).collect()
            };
            let mean = |radius: f64| ring(radius).iter().sum::<f64>() / 62.0;
            assert!(mean(20.0) > 1.05 * mean(45.0), "{} {}", mean(20.0), mean(45.0));
            for radius in [20.0, 45.0] {
                let ring = ring(radius);
                let step = ring.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
                let most = if mask { 0.16 } else { 0.06 };
                assert!(step < most * mean(radius), "{mask} {radius}: {step} of {}", mean(radius));
            }
        }
    }

    #[test]
    fn the_edge_of_a_ball_is_no_stair() {
        let canvas = ball(false);
        let background = decode(188);
        // Along a row through the rim some pixels are neither ball nor background.
        let between = (0..200).filter(|y| {
            (0..200).any(|x| {
                let red = decode(canvas.get(x, *y).unwrap()[2]);
                red > 0.25 * background && red < 0.75 * background
            })
        });
        assert!(between.count() > 60);
    }

    #[test]
    fn a_small_cloud_fills_the_picture_that_frames_it() {
        let array =
            Array::per_cell("phi", [40; 3], |c| [if c.iter().all(|i| (4..10).contains(i)) { 1.0f32 } else { 0.0 }]);
        let volume = Volume::new(&array, [0.0; 3], [0.1; 3]).unwrap();
        let share = |frame| {
            let look = Look { frame, ..plain(Material::SMOKE) }.fitted(&volume, 100);
            let canvas = render(&volume, &look).unwrap();
            let met = canvas.pixels().chunks_exact(3).filter(|p| **p != [188; 3]).count();
            met as f64 / (canvas.width() * canvas.height()) as f64
        };
        let [far, near] = [share(None), share(volume.extent_above(0.5))];
        assert!(far < 0.1 && near > 0.6, "{far} {near}");
    }

    #[test]
    fn the_same_picture_on_any_number_of_threads_and_odd_requests_are_refused() {
        let array = Array::per_cell("phi", [9, 30, 7], |c| [((c[0] * 7 + c[1] * 3 + c[2]) % 5) as f32]);
        let mut volume = Volume::new(&array, [0.0; 3], [0.1; 3]).unwrap();
        volume.set_solid(|p| (p[0] - 0.4).hypot(p[1] - 1.5).hypot(p[2] - 0.3) - 0.25);
        let look = Look { size: [70, 90], range: [0.0, 4.0], title: "cloud".into(), ..Look::default() };
        let draw = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| render(&volume, &look).unwrap())
        };
        assert_eq!(draw(1), draw(3));
        for odd in [
            Look { size: [0, 90], ..look.clone() },
            Look { up: 3, ..look.clone() },
            Look { eye: [f64::NAN, 0.0], ..look.clone() },
            Look { range: [1.0, 1.0], ..look.clone() },
            Look { frame: Some([[0.0; 3]; 2]), ..look.clone() },
            Look { material: Material { ambient: -1.0, ..Material::INK }, ..look.clone() },
        ] {
            assert!(render(&volume, &odd).is_err());
        }
    }
}
