#pragma once

#include "perception/splats/lane_functions.h"
#include "perception/splats/sh_basis.h"
#include "perception/splats/splat_kernels.h"

namespace cousin {

/// Eight Gaussians between parameters and image: what projection and its gradient share.
template <class L>
struct ProjectedLanes {
  L x, y, z, inverse_z, u, v;  ///< in camera coordinates; u = x/z, v = y/z
  L u_clamped, v_clamped;
  L p[2][3];       ///< Jacobian times camera rotation
  L q[4], q_norm;  ///< unit quaternion, and the norm it had
  L turn[3][3];    ///< its matrix
  L scale[3];
  L m[2][3];                 ///< p turn diag(scale)
  L determinant;             ///< of the image covariance
  L variance[2];             ///< of it, xx and yy
  L tilt;                    ///< xy / yy: of a row of the image, the middle's dx over dy
  L across, down;            ///< 1 / variance of dx about that middle, and of dy
  L direction[3], distance;  ///< unit, from the camera's centre
};

template <class L>
inline ProjectedLanes<L> project_lanes(const SplatPlanes& planes, const SplatCamera& camera,
                                       int first) {
  ProjectedLanes<L> r;
  const auto load = [&](int k) { return L::load(planes.lanes(k, first)); };
  const float* c = camera.rotation;
  const L centre[3] = {load(0), load(1), load(2)};
  const auto row = [&](int i) {
    return multiply_add(
        L(c[3 * i]), centre[0],
        multiply_add(L(c[3 * i + 1]), centre[1],
                     multiply_add(L(c[3 * i + 2]), centre[2], L(camera.translation[i]))));
  };
  r.x = row(0);
  r.y = row(1);
  r.z = row(2);
  r.inverse_z = L(1) / r.z;
  r.u = r.x * r.inverse_z;
  r.v = r.y * r.inverse_z;
  r.u_clamped = smaller(larger(r.u, L(camera.u_min)), L(camera.u_max));
  r.v_clamped = smaller(larger(r.v, L(camera.v_min)), L(camera.v_max));
  const L fx = L(camera.fx) * r.inverse_z, fy = L(camera.fy) * r.inverse_z;
  for (int j = 0; j < 3; ++j) {
    r.p[0][j] = fx * multiply_subtract(r.u_clamped, L(c[6 + j]), L(c[j]));
    r.p[1][j] = fy * multiply_subtract(r.v_clamped, L(c[6 + j]), L(c[3 + j]));
  }

  // A quaternion of no length is the identity. Very long and very short ones keep their direction.
  L raw[4], longest = L(0);
  for (int k = 0; k < 4; ++k) {
    raw[k] = load(SplatPlane::rotation + k);
    longest = larger(longest, magnitude(raw[k]));
  }
  const auto has_length = at_least(longest, L(1e-12));
  const L shrink = L(1) / where(has_length, longest, L(1));
  L squares = L(0);
  for (int k = 0; k < 4; ++k) {
    raw[k] = where(has_length, raw[k] * shrink, L(k == 0 ? 1 : 0));
    squares = multiply_add(raw[k], raw[k], squares);
  }
  const L length = square_root(squares);
  r.q_norm = where(has_length, length * longest, L(1));
  const L inverse_length = L(1) / length;
  for (int k = 0; k < 4; ++k) r.q[k] = raw[k] * inverse_length;
  const L w = r.q[0], i = r.q[1], j = r.q[2], k = r.q[3];
  const L one(1), two(2);
  r.turn[0][0] = one - two * (j * j + k * k);
  r.turn[0][1] = two * (i * j - w * k);
  r.turn[0][2] = two * (i * k + w * j);
  r.turn[1][0] = two * (i * j + w * k);
  r.turn[1][1] = one - two * (i * i + k * k);
  r.turn[1][2] = two * (j * k - w * i);
  r.turn[2][0] = two * (i * k - w * j);
  r.turn[2][1] = two * (j * k + w * i);
  r.turn[2][2] = one - two * (i * i + j * j);

  for (int a = 0; a < 3; ++a) {
    r.scale[a] = exponential(load(SplatPlane::log_scale + a));
    for (int b = 0; b < 2; ++b) {
      const L sum = multiply_add(r.p[b][0], r.turn[0][a],
                                 multiply_add(r.p[b][1], r.turn[1][a], r.p[b][2] * r.turn[2][a]));
      r.m[b][a] = r.scale[a] * sum;
    }
  }
  // The determinant as a sum of squares (Cauchy-Binet): a needle's keeps its digits, where
  // xx yy - xy^2 would lose them all.
  L xx = L(0), xy = L(0), yy = L(0);
  for (int a = 0; a < 3; ++a) {
    xx = multiply_add(r.m[0][a], r.m[0][a], xx);
    xy = multiply_add(r.m[0][a], r.m[1][a], xy);
    yy = multiply_add(r.m[1][a], r.m[1][a], yy);
  }
  const L low(camera.low_pass_px2);
  r.determinant = multiply_add(low, xx + yy, low * low);
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3;
    const L minor = r.m[0][a] * r.m[1][b] - r.m[0][b] * r.m[1][a];
    r.determinant = multiply_add(minor, minor, r.determinant);
  }
  r.variance[0] = xx + low;
  r.variance[1] = yy + low;
  r.down = L(1) / r.variance[1];
  r.tilt = xy * r.down;
  r.across = r.variance[1] / r.determinant;

  L distance2 = L(0);
  for (int a = 0; a < 3; ++a) {
    r.direction[a] = centre[a] - L(camera.centre[a]);
    distance2 = multiply_add(r.direction[a], r.direction[a], distance2);
  }
  r.distance = square_root(distance2);
  const L inverse_distance = L(1) / larger(r.distance, L(1e-30));
  for (int a = 0; a < 3; ++a) r.direction[a] = r.direction[a] * inverse_distance;
  return r;
}

/// Fills `projected` and `depth_order` for Gaussians first .. last - 1. Left out is what is nearer
/// than the camera's near depth, has NaN, is below 1/255 everywhere, or lies outside the image.
template <class L>
inline void project_range(const ProjectTask& task, int first, int last) {
  const SplatCamera& camera = task.camera;
  const SplatPlanes& planes = *task.planes;
  const int functions = (task.sh_degree + 1) * (task.sh_degree + 1);
  for (int n = first; n < last; n += 8) {
    const ProjectedLanes<L> r = project_lanes<L>(planes, camera, n);
    const auto load = [&](int k) { return L::load(planes.lanes(k, n)); };
    const L logit = load(SplatPlane::opacity);
    const L log2_opacity = logarithm2(sigmoid_of(logit));
    const L room = log2_opacity - L(SplatLimits::smallest_log2_alpha);
    // Where alpha is 1/255, half of the squared distance in sigmas is room ln 2.
    const L reach = L(1.3862943611198906) * room;
    const L half_width = square_root(reach * r.variance[0]);
    const L half_height = square_root(reach * r.variance[1]);
    const L x = multiply_add(L(camera.fx), r.u, L(camera.cx));
    const L y = multiply_add(L(camera.fy), r.v, L(camera.cy));

    auto shown = at_least(r.z, L(camera.near_m)) & less(r.z, L(1e30)) & less(L(0), room) &
                 at_least(logit, logit) & less(r.determinant, L(1e30));
    shown = shown & at_least(x + half_width, L(0)) & at_least(y + half_height, L(0)) &
            at_least(L(camera.width_px - 1), x - half_width) &
            at_least(L(camera.height_px - 1), y - half_height);
    for (int k = 0; k < 3; ++k) {
      const L s = load(SplatPlane::log_scale + k);
      shown = shown & at_least(s, s);
    }
    for (int k = 0; k < 4; ++k) {
      const L q = load(SplatPlane::rotation + k);
      shown = shown & less(magnitude(q), L(1e30));
    }
    const unsigned some = bits(shown);
    if (some == 0) {
      for (int i = 0; i < 8; ++i) task.depth_order[n + i] = 0xffffffffU;
      continue;
    }

    L basis[16];
    sh_basis(task.sh_degree, r.direction[0], r.direction[1], r.direction[2], basis);
    L color[3];
    for (int c = 0; c < 3; ++c) {
      color[c] = multiply_add(basis[0], load(SplatPlane::dc + c), L(0.5));
      for (int k = 1; k < functions; ++k) {
        color[c] = multiply_add(basis[k], load(SplatPlane::rest + 15 * c + k - 1), color[c]);
      }
      shown = shown & less(magnitude(color[c]), L(1e30));
      color[c] = larger(color[c], L(0));
    }
    constexpr double log2_e = 1.4426950408889634;
    const L values[12] = {x,
                          y,
                          L(-0.5 * log2_e) * r.across,
                          r.tilt,
                          L(-0.5 * log2_e) * r.down,
                          log2_opacity,
                          color[0],
                          color[1],
                          color[2],
                          r.z,
                          half_width,
                          half_height};
    alignas(32) float rows[12][8];
    for (int k = 0; k < 12; ++k) values[k].store(rows[k]);
    const unsigned all = bits(shown);
    for (int i = 0; i < 8; ++i) {
      auto* to = reinterpret_cast<float*>(task.projected + n + i);
      for (int k = 0; k < 12; ++k) to[k] = rows[k][i];
      std::uint32_t order;
      __builtin_memcpy(&order, &rows[9][i], sizeof order);
      task.depth_order[n + i] = (all >> i & 1U) != 0 ? order : 0xffffffffU;
    }
  }
}

}  // namespace cousin
