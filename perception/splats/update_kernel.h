#pragma once

#include "perception/splats/project_kernel.h"

namespace cousin {

/// d loss / d image of eight Gaussians: their partials, summed tile by tile in the order of the
/// tiles.
template <class L>
struct ImageGradients {
  L g, t, dy, t2, t_dy, dy2;  ///< as in SplatPartial
  L color[3];                 ///< 0 where the colour is cut at 0
  L moved_x, moved_y;         ///< sums over tiles of |d loss / d centre|, pixels
  typename L::Mask seen;      ///< has at least one pair
};

template <class L>
inline ImageGradients<L> sum_partials(const UpdateTask& task, int first) {
  alignas(32) float sums[12][8] = {};
  alignas(32) float count[8];
  alignas(32) float moved[2][8] = {};
  constexpr float to_inverse = -1.3862943611198906F;  // across is -1/2 log2(e) / variance
  for (int i = 0; i < 8; ++i) {
    const int n = first + i;
    const bool real = n < task.planes->size();
    const std::uint32_t pairs = real ? task.pair_count[n] : 0;
    count[i] = static_cast<float>(pairs);
    if (pairs == 0) continue;
    const auto* from = reinterpret_cast<const float*>(task.partials + task.pair_first[n]);
    float total[12] = {};
    const ProjectedSplat& s = task.projected[n];
    const float across = to_inverse * s.across, down = to_inverse * s.down;
    for (std::uint32_t p = 0; p < pairs; ++p, from += 12) {
      for (int k = 0; k < 12; ++k) total[k] += from[k];
      const float x = across * from[1];
      moved[0][i] += __builtin_fabsf(x);
      moved[1][i] += __builtin_fabsf(down * from[2] - s.tilt * x);
    }
    for (int k = 0; k < 3; ++k) {
      if (!(s.color[k] > 0)) total[8 + k] = 0;
    }
    for (int k = 0; k < 12; ++k) sums[k][i] = total[k];
  }
  ImageGradients<L> r;
  r.g = L::load(sums[0]);
  r.t = L::load(sums[1]);
  r.dy = L::load(sums[2]);
  r.t2 = L::load(sums[3]);
  r.t_dy = L::load(sums[4]);
  r.dy2 = L::load(sums[5]);
  for (int k = 0; k < 3; ++k) r.color[k] = L::load(sums[8 + k]);
  r.moved_x = L::load(moved[0]);
  r.moved_y = L::load(moved[1]);
  r.seen = less(L(0), L::load(count));
  return r;
}

/// Where gradients go that are only asked for.
template <class L>
struct GradientSink {
  const UpdateTask& task;
  int first;
  void operator()(int plane, const AdamRate&, const L& gradient) const {
    gradient.store(task.gradients->lanes(plane, first));
  }
};

/// One step of Adam [Kingma & Ba, ICLR 2015] for the Gaussians of the mask: those that the image
/// shows.
template <class L>
struct AdamSink {
  const UpdateTask& task;
  int first;
  typename L::Mask seen;
  void operator()(int plane, const AdamRate& rate, const L& gradient) const {
    // A gradient that overflowed is no gradient.
    const L g = zero_unless(less(magnitude(gradient), L(1e18)), gradient);
    float* value = task.planes->lanes(plane, first);
    float* first_moment = task.first_moment->lanes(plane, first);
    float* second_moment = task.second_moment->lanes(plane, first);
    const L old_m = L::load(first_moment), old_v = L::load(second_moment), old = L::load(value);
    const L beta1(task.beta1), beta2(task.beta2);
    const L m = multiply_add(beta1, old_m - g, g);
    const L v = multiply_add(beta2, old_v - g * g, g * g);
    const L root = multiply_add(square_root(v), L(rate.scale), L(task.epsilon));
    const L next = old - L(rate.rate) * m / root;
    where(seen, m, old_m).store(first_moment);
    where(seen, v, old_v).store(second_moment);
    where(seen, next, old).store(value);
  }
};

/// From the image back to all parameters of eight Gaussians, each given to `sink`.
template <class L, class Sink>
inline void splat_gradients(const UpdateTask& task, int first, const ImageGradients<L>& image,
                            const Sink& sink) {
  const SplatCamera& camera = task.camera;
  const SplatPlanes& planes = *task.planes;
  const ProjectedLanes<L> r = project_lanes<L>(planes, camera, first);
  const L two(2);

  // Centre in the image. With Q the inverse covariance, e = Q (dx, dy) is
  // (across t, down dy - tilt across t), and d log alpha / d centre = e.
  const L grad_x = r.across * image.t;
  const L grad_y = multiply_subtract(r.tilt, grad_x, r.down * image.dy);

  // Covariance: d loss / d Sigma is half of H, the sum of g e e^T, so d loss / d M = H M.
  const L h00 = r.across * r.across * image.t2;
  const L mixed = r.across * r.down * image.t_dy;
  const L h01 = multiply_subtract(r.tilt, h00, mixed);
  const L h11 = multiply_subtract(r.tilt, h01 + mixed, r.down * r.down * image.dy2);
  L grad_m[2][3];
  for (int k = 0; k < 3; ++k) {
    grad_m[0][k] = multiply_add(h00, r.m[0][k], h01 * r.m[1][k]);
    grad_m[1][k] = multiply_add(h01, r.m[0][k], h11 * r.m[1][k]);
  }
  for (int k = 0; k < 3; ++k) {
    L g = multiply_add(grad_m[0][k], r.m[0][k], grad_m[1][k] * r.m[1][k]);
    g = multiply_add(L(task.scale_pull), r.scale[k], g);
    sink(SplatPlane::log_scale + k, task.log_scale, g);
  }

  // M = P R diag(s).
  L grad_turn[3][3], grad_p[2][3];
  for (int j = 0; j < 3; ++j) {
    for (int b = 0; b < 2; ++b) grad_p[b][j] = L(0);
    for (int k = 0; k < 3; ++k) {
      const L sum = multiply_add(r.p[0][j], grad_m[0][k], r.p[1][j] * grad_m[1][k]);
      grad_turn[j][k] = r.scale[k] * sum;
      const L column = r.scale[k] * r.turn[j][k];
      for (int b = 0; b < 2; ++b) grad_p[b][j] = multiply_add(grad_m[b][k], column, grad_p[b][j]);
    }
  }

  // Quaternion; only what turns it counts, along its length nothing changes.
  const L w = r.q[0], x = r.q[1], y = r.q[2], z = r.q[3];
  const auto& t = grad_turn;
  L grad_q[4];
  grad_q[0] = two * (x * (t[2][1] - t[1][2]) + y * (t[0][2] - t[2][0]) + z * (t[1][0] - t[0][1]));
  grad_q[1] = two * (y * (t[0][1] + t[1][0]) + z * (t[0][2] + t[2][0]) + w * (t[2][1] - t[1][2]) -
                     two * x * (t[1][1] + t[2][2]));
  grad_q[2] = two * (x * (t[0][1] + t[1][0]) + z * (t[1][2] + t[2][1]) + w * (t[0][2] - t[2][0]) -
                     two * y * (t[0][0] + t[2][2]));
  grad_q[3] = two * (x * (t[0][2] + t[2][0]) + y * (t[1][2] + t[2][1]) + w * (t[1][0] - t[0][1]) -
                     two * z * (t[0][0] + t[1][1]));
  L along = L(0);
  for (int k = 0; k < 4; ++k) along = multiply_add(grad_q[k], r.q[k], along);
  const L inverse_norm = L(1) / r.q_norm;
  for (int k = 0; k < 4; ++k) {
    sink(SplatPlane::rotation + k, task.rotation,
         multiply_subtract(along, r.q[k], grad_q[k]) * inverse_norm);
  }

  // P and the image's centre depend on the centre in camera coordinates.
  const float* c = camera.rotation;
  L stretch = L(0), grad_uc = L(0), grad_vc = L(0);
  for (int j = 0; j < 3; ++j) {
    stretch = multiply_add(r.p[0][j], grad_p[0][j], stretch);
    stretch = multiply_add(r.p[1][j], grad_p[1][j], stretch);
    grad_uc = multiply_add(L(c[6 + j]), grad_p[0][j], grad_uc);
    grad_vc = multiply_add(L(c[6 + j]), grad_p[1][j], grad_vc);
  }
  const L fx(camera.fx), fy(camera.fy);
  const auto u_free = less(L(camera.u_min), r.u) & less(r.u, L(camera.u_max));
  const auto v_free = less(L(camera.v_min), r.v) & less(r.v, L(camera.v_max));
  const L grad_u = fx * (grad_x - zero_unless(u_free, grad_uc * r.inverse_z));
  const L grad_v = fy * (grad_y - zero_unless(v_free, grad_vc * r.inverse_z));
  L in_camera[3];
  in_camera[0] = grad_u * r.inverse_z;
  in_camera[1] = grad_v * r.inverse_z;
  in_camera[2] = -r.inverse_z * (stretch + multiply_add(r.u, grad_u, r.v * grad_v));

  // Colour, and the direction it is seen from.
  const int functions = (task.sh_degree + 1) * (task.sh_degree + 1);
  L basis[16], weight[16], grad_direction[3] = {L(0), L(0), L(0)};
  sh_basis(task.sh_degree, r.direction[0], r.direction[1], r.direction[2], basis);
  for (int k = 1; k < functions; ++k) {
    weight[k] = L(0);
    for (int channel = 0; channel < 3; ++channel) {
      const int plane = SplatPlane::rest + 15 * channel + k - 1;
      weight[k] =
          multiply_add(image.color[channel], L::load(planes.lanes(plane, first)), weight[k]);
      if (task.with_rest) sink(plane, task.rest, basis[k] * image.color[channel]);
    }
  }
  for (int channel = 0; channel < 3; ++channel) {
    sink(SplatPlane::dc + channel, task.dc, basis[0] * image.color[channel]);
  }
  add_sh_direction_gradient(task.sh_degree, r.direction[0], r.direction[1], r.direction[2], weight,
                            grad_direction);
  L radial = L(0);
  for (int k = 0; k < 3; ++k) radial = multiply_add(grad_direction[k], r.direction[k], radial);
  const L inverse_distance = L(1) / larger(r.distance, L(1e-30));
  for (int k = 0; k < 3; ++k) {
    const L turned = multiply_add(
        L(c[k]), in_camera[0], multiply_add(L(c[3 + k]), in_camera[1], L(c[6 + k]) * in_camera[2]));
    const L by_color = multiply_subtract(radial, r.direction[k], grad_direction[k]);
    sink(SplatPlane::centre + k, task.centre, multiply_add(by_color, inverse_distance, turned));
  }

  // Opacity: g is d loss / d ln(opacity).
  const L opacity = sigmoid_of(L::load(planes.lanes(SplatPlane::opacity, first)));
  const L pulled = multiply_add(L(task.opacity_pull), opacity, image.g);
  sink(SplatPlane::opacity, task.opacity, pulled * (L(1) - opacity));

  if (task.gradient_sum != nullptr) {
    // In an image that is 2 wide and 2 high, so that its resolution does not matter.
    const L x_px = task.by_tile ? image.moved_x : grad_x;
    const L y_px = task.by_tile ? image.moved_y : grad_y;
    const L gx = x_px * L(0.5 * camera.width_px), gy = y_px * L(0.5 * camera.height_px);
    const L norm = square_root(multiply_add(gx, gx, gy * gy));
    const L finite = zero_unless(image.seen & less(norm, L(1e18)), norm);
    (L::load(task.gradient_sum + first) + finite).store(task.gradient_sum + first);
    (L::load(task.gradient_count + first) + zero_unless(image.seen, L(1)))
        .store(task.gradient_count + first);
  }
}

/// What pulls at opacities and scales does to Gaussians that the image does not show: a pull that
/// held at the others alone would leave these as they are, for growth to copy.
template <class L>
inline void pull_unseen(const UpdateTask& task, int first, typename L::Mask seen) {
  alignas(32) float unseen[8];
  where(seen, L(0), L(1)).store(unseen);
  for (int i = 0; i < 8; ++i) unseen[i] = first + i < task.planes->size() ? unseen[i] : 0;
  const AdamSink<L> sink{task, first, less(L(0), L::load(unseen))};
  for (int k = 0; k < 3; ++k) {
    const L scale = exponential(L::load(task.planes->lanes(SplatPlane::log_scale + k, first)));
    sink(SplatPlane::log_scale + k, task.log_scale, L(task.scale_pull) * scale);
  }
  const L opacity = sigmoid_of(L::load(task.planes->lanes(SplatPlane::opacity, first)));
  sink(SplatPlane::opacity, task.opacity, L(task.opacity_pull) * opacity * (L(1) - opacity));
}

template <class L>
inline void update_range(const UpdateTask& task, int first, int last) {
  for (int n = first; n < last; n += 8) {
    const ImageGradients<L> image = sum_partials<L>(task, n);
    const unsigned some = bits(image.seen);
    if (task.gradients != nullptr) {
      for (int k = 0; k < SplatPlane::count; ++k) L(0).store(task.gradients->lanes(k, n));
      if (some == 0) continue;
      splat_gradients<L>(task, n, image, GradientSink<L>{task, n});
      for (int k = 0; k < SplatPlane::count; ++k) {
        float* to = task.gradients->lanes(k, n);
        const L g = L::load(to);
        zero_unless(image.seen & less(magnitude(g), L(1e18)), g).store(to);
      }
      continue;
    }
    if (some != 0) splat_gradients<L>(task, n, image, AdamSink<L>{task, n, image.seen});
    if (some != 0xff && (task.opacity_pull > 0 || task.scale_pull > 0))
      pull_unseen<L>(task, n, image.seen);
  }
}

}  // namespace cousin
