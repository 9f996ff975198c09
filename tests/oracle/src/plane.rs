//! Polarised light of a plane layer of dipoles over Lambertian ground, by successive orders of scattering.
//!
//! Of the light around it, a dipole keeps the coherency tensor `T`; towards `-v` it sends `3 / (8 π) P T P` with
//! `P = 1 - v v`. With z up and x towards the sun's azimuth, the mirror symmetry leaves four numbers, each of one
//! azimuthal number `m`: `A = (Txx + Tyy) / 2` and `Z = Tzz` of 0, `X = Txz` of 1, `D = (Txx - Tyy) / 2` of 2
//! (Chandrasekhar 1960, *Radiative Transfer*, sections 15 to 17). They are functions of the optical depth alone.

use std::f64::consts::PI;

use crate::quadrature::GaussLegendre;

/// Optical depths of a layer at which the tensor is known; its source is a straight line between them.
const DEPTHS: usize = 400;

/// Directions above the level, and as many below it.
const DIRECTIONS: usize = 40;

/// Azimuthal numbers.
const NUMBERS: usize = 3;

/// What an order may add at last, relative to all of them.
const LAST: f64 = 1e-10;

/// `I` and `Q` along `cos mφ`, and `U` along `sin mφ`.
type Amplitudes = [f64; 3];

/// The tensor of an azimuthal number: `A` and `Z`, `X` or `D`.
type Tensor = [f64; 2];

/// A layer of dipoles that neither absorb nor depolarise, under a sun of the irradiance π across its rays.
pub struct PlaneLayer {
    depths: Vec<f64>,
    /// By azimuthal number, at each depth.
    tensors: [Vec<Tensor>; NUMBERS],
    /// Radiance of the ground.
    ground: f64,
}

impl PlaneLayer {
    /// A layer of an optical depth over ground of an albedo, under a sun whose zenith angle has the cosine `mu_0`.
    pub fn new(depth: f64, albedo: f64, mu_0: f64) -> Self {
        let at = |n: usize| 0.5 * depth * (1.0 - (PI * n as f64 / (DEPTHS - 1) as f64).cos());
        let depths: Vec<f64> = (0..DEPTHS).map(at).collect();
        // Closer towards the level.
        let GaussLegendre { nodes, weights, .. } = GaussLegendre::<DIRECTIONS>::new();
        let cosines: Vec<(f64, f64)> = nodes.iter().zip(weights).map(|(u, weight)| (u * u, 2.0 * u * weight)).collect();
        let s_0 = (1.0 - mu_0 * mu_0).sqrt();
        let beam = |t: f64| PI * (-t / mu_0).exp();
        let of_sun: [Tensor; NUMBERS] =
            [[(1.0 + mu_0 * mu_0) / 4.0, s_0 * s_0 / 2.0], [-mu_0 * s_0 / 2.0, 0.0], [-s_0 * s_0 / 4.0, 0.0]];
        let mut layer = Self { depths, tensors: Default::default(), ground: 0.0 };
        for (number, of_sun) in of_sun.into_iter().enumerate() {
            let first = layer.depths.iter().map(|&t| of_sun.map(|part| part * beam(t))).collect();
            let ground = if number == 0 { albedo / PI * mu_0 * beam(depth) } else { 0.0 };
            layer.add_orders(number, first, ground, albedo, &cosines);
        }
        layer
    }

    /// Sums the orders of an azimuthal number, of which the tensor of direct light and the ground's radiance by it are
    /// given.
    fn add_orders(
        &mut self,
        number: usize,
        mut order: Vec<Tensor>,
        mut ground: f64,
        albedo: f64,
        cosines: &[(f64, f64)],
    ) {
        let size = |tensor: &[Tensor]| tensor.iter().flatten().map(|part| part.abs()).sum::<f64>();
        let mut sum = order.clone();
        self.ground += ground;
        loop {
            let mut next = vec![[0.0; 2]; self.depths.len()];
            let mut fallen = 0.0;
            for &(mu, weight) in cosines {
                for mu in [mu, -mu] {
                    let light = self.light(number, mu, &order, ground);
                    next.iter_mut().zip(&light).for_each(|(sum, light)| gather(sum, number, mu, weight, *light));
                    if mu > 0.0 && number == 0 {
                        fallen += 2.0 * PI * weight * mu * light[self.depths.len() - 1][0];
                    }
                }
            }
            ground = albedo / PI * fallen;
            self.ground += ground;
            sum.iter_mut().flatten().zip(next.iter().flatten()).for_each(|(sum, part)| *sum += part);
            if size(&next) <= LAST * size(&sum) {
                break;
            }
            order = next;
        }
        self.tensors[number] = sum;
    }

    /// The light of a tensor and of ground in a direction of view at every depth. Between two depths, where the source
    /// is a straight line, the integral is exact.
    fn light(&self, number: usize, mu: f64, tensor: &[Tensor], ground: f64) -> Vec<Amplitudes> {
        let last = self.depths.len() - 1;
        // Along the light: down where the view is up.
        let at = |n: usize| if mu > 0.0 { n } else { last - n };
        let mut found = vec![[0.0; 3]; last + 1];
        let mut light = if mu < 0.0 && number == 0 { [ground, 0.0, 0.0] } else { [0.0; 3] };
        found[at(0)] = light;
        let mut before = source(number, mu, tensor[at(0)]);
        for n in 1..=last {
            let way = (self.depths[at(n)] - self.depths[at(n - 1)]).abs() / mu.abs();
            let left = (-way).exp();
            // The mean of what is left over the way.
            let mean = if way > 1e-3 { (1.0 - left) / way } else { 1.0 - way / 2.0 + way * way / 6.0 };
            let here = source(number, mu, tensor[at(n)]);
            for k in 0..3 {
                light[k] = light[k] * left + (mean - left) * before[k] + (1.0 - mean) * here[k];
            }
            (found[at(n)], before) = (light, here);
        }
        found
    }

    /// `I`, `Q` and `U` at the ground, looking up, where the cosine `mu` of the view's zenith angle is above 0, and
    /// looking down from the top where it is below; relative to the vertical plane, at an azimuth from the sun
    /// (radians, counterclockwise from above). `U > 0` lies counterclockwise as the observer sees it.
    pub fn stokes(&self, mu: f64, azimuth: f64) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (number, tensor) in self.tensors.iter().enumerate() {
            let light = self.light(number, mu, tensor, self.ground);
            let [i, q, u] = light[if mu > 0.0 { self.depths.len() - 1 } else { 0 }];
            let (sine, cosine) = (number as f64 * azimuth).sin_cos();
            sum = [sum[0] + i * cosine, sum[1] + q * cosine, sum[2] + u * sine];
        }
        sum
    }
}

/// What dipoles send into a direction of view of the tensor around them.
fn source(number: usize, mu: f64, [first, second]: Tensor) -> Amplitudes {
    let (square, level) = (1.0 - mu * mu, (1.0 - mu * mu).sqrt());
    let sent = match number {
        0 => [(1.0 + mu * mu) * first + square * second, square * (second - first), 0.0],
        1 => [-2.0 * mu * level * first, -2.0 * mu * level * first, -2.0 * level * first],
        _ => [-square * first, (1.0 + mu * mu) * first, 2.0 * mu * first],
    };
    sent.map(|sent| 3.0 / (8.0 * PI) * sent)
}

/// Adds light from a direction of view to the tensor.
fn gather(sum: &mut Tensor, number: usize, mu: f64, weight: f64, [i, q, u]: Amplitudes) {
    let (square, level) = (1.0 - mu * mu, (1.0 - mu * mu).sqrt());
    match number {
        0 => {
            sum[0] += 2.0 * PI * weight * ((1.0 + mu * mu) * i - square * q) / 4.0;
            sum[1] += 2.0 * PI * weight * square * (i + q) / 2.0;
        }
        1 => sum[0] -= PI * weight * (mu * level * (i + q) + level * u) / 2.0,
        _ => sum[0] += PI * weight * (-square * i + (1.0 + mu * mu) * q + 2.0 * mu * u) / 4.0,
    }
}
