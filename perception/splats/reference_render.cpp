#include "perception/splats/reference_render.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "perception/splats/sh_basis.h"

namespace cousin {
namespace {

using Matrix23 = Eigen::Matrix<double, 2, 3>;

/// One Gaussian between its parameters and the image.
struct Footprint {
  bool shown = false;
  Eigen::Vector3d in_camera, direction, scale, color, raw_color;
  Eigen::Vector4d unit_q;
  Eigen::Matrix3d turn;
  Eigen::Vector2d pixel, clamped;
  Matrix23 jacobian;
  Eigen::Matrix2d covariance, conic;
  double opacity = 0, distance = 0, q_norm = 1;
  bool u_free = true, v_free = true;
};

Eigen::Matrix3d turn_of(const Eigen::Vector4d& q) {
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
}

Footprint footprint(const SplatParameters& parameters, Eigen::Index i, const ReferenceView& view) {
  Footprint f;
  const auto p = parameters.row(i);
  if (!p.segment<10>(0).allFinite() || std::isnan(p[10]) || !p.segment<48>(11).allFinite())
    return f;
  const Camera& camera = view.camera;
  const Eigen::Vector3d centre = p.segment<3>(0).transpose();
  f.in_camera = view.camera_from_origin * centre;
  const double z = f.in_camera.z();
  if (!(z >= view.near_m)) return f;
  const double u = f.in_camera.x() / z, v = f.in_camera.y() / z;
  f.pixel = {camera.fx_px * u + camera.cx_px, camera.fy_px * v + camera.cy_px};
  const double half_u = 0.5 * camera.width_px / camera.fx_px;
  const double half_v = 0.5 * camera.height_px / camera.fy_px;
  const double u0 = (-0.5 - camera.cx_px) / camera.fx_px - 0.3 * half_u;
  const double v0 = (-0.5 - camera.cy_px) / camera.fy_px - 0.3 * half_v;
  f.clamped = {std::clamp(u, u0, u0 + 2.6 * half_u), std::clamp(v, v0, v0 + 2.6 * half_v)};
  f.u_free = f.clamped.x() == u;
  f.v_free = f.clamped.y() == v;
  f.jacobian << camera.fx_px / z, 0, -camera.fx_px * f.clamped.x() / z, 0, camera.fy_px / z,
      -camera.fy_px * f.clamped.y() / z;

  f.unit_q = p.segment<4>(6).transpose();
  f.q_norm = f.unit_q.norm();
  if (f.q_norm < 1e-12) {
    f.unit_q = {1, 0, 0, 0};
    f.q_norm = 1;
  } else {
    f.unit_q /= f.q_norm;
  }
  f.turn = turn_of(f.unit_q);
  f.scale = p.segment<3>(3).transpose().array().exp();
  const Eigen::Matrix3d rotation = view.camera_from_origin.rotation.toRotationMatrix();
  const Matrix23 m = f.jacobian * rotation * f.turn * f.scale.asDiagonal();
  f.covariance = m * m.transpose() + view.low_pass_px2 * Eigen::Matrix2d::Identity();
  f.conic = f.covariance.inverse();
  f.opacity = 1 / (1 + std::exp(-p[10]));

  const Eigen::Vector3d eye = centre_in_world_m(view.camera_from_origin);
  f.distance = (centre - eye).norm();
  f.direction = (centre - eye) / f.distance;
  double basis[16];
  sh_basis(view.sh_degree, f.direction.x(), f.direction.y(), f.direction.z(), basis);
  const int functions = (view.sh_degree + 1) * (view.sh_degree + 1);
  for (int c = 0; c < 3; ++c) {
    f.raw_color[c] = 0.5 + basis[0] * p[11 + c];
    for (int k = 1; k < functions; ++k) f.raw_color[c] += basis[k] * p[14 + 15 * c + k - 1];
  }
  f.color = f.raw_color.cwiseMax(0.0);
  f.shown = f.opacity > 1.0 / 255 && f.conic.allFinite();
  return f;
}

std::vector<Footprint> footprints(const SplatParameters& parameters, const ReferenceView& view) {
  std::vector<Footprint> all;
  for (Eigen::Index i = 0; i < parameters.rows(); ++i) {
    all.push_back(footprint(parameters, i, view));
  }
  return all;
}

std::vector<std::size_t> front_to_back(const std::vector<Footprint>& all) {
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::erase_if(order, [&](std::size_t i) { return !all[i].shown; });
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return all[a].in_camera.z() < all[b].in_camera.z();
  });
  return order;
}

/// One Gaussian at one pixel.
struct Blended {
  std::size_t splat;
  double alpha, before;
  bool limited;
  Eigen::Vector2d offset;
};

std::vector<Blended> blended_at(const std::vector<Footprint>& all,
                                const std::vector<std::size_t>& order, const Eigen::Vector2d& pixel,
                                double& left) {
  std::vector<Blended> list;
  left = 1;
  for (const std::size_t i : order) {
    const Footprint& f = all[i];
    const Eigen::Vector2d offset = pixel - f.pixel;
    const double raw = f.opacity * std::exp(-0.5 * offset.dot(f.conic * offset));
    if (raw < 1.0 / 255) continue;
    const double alpha = std::min(raw, 0.99);
    if (left * (1 - alpha) < 1e-4) break;
    list.push_back({i, alpha, left, raw > 0.99, offset});
    left *= 1 - alpha;
  }
  return list;
}

/// What one Gaussian's parameters do to the loss through its footprint.
struct FootprintGradient {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Matrix2d conic = Eigen::Matrix2d::Zero();
  Eigen::Vector3d color = Eigen::Vector3d::Zero();
  double opacity = 0;
};

Eigen::Vector4d quaternion_gradient(const Footprint& f, const Eigen::Matrix3d& turn) {
  // The matrix is quadratic in the quaternion: central differences of step 1 are exact.
  Eigen::Vector4d g;
  for (int k = 0; k < 4; ++k) {
    Eigen::Vector4d up = f.unit_q, down = f.unit_q;
    up[k] += 1;
    down[k] -= 1;
    g[k] = 0.5 * ((turn_of(up) - turn_of(down)).cwiseProduct(turn)).sum();
  }
  return (g - f.unit_q * f.unit_q.dot(g)) / f.q_norm;
}

void parameter_row(const SplatParameters& parameters, Eigen::Index i, const ReferenceView& view,
                   const Footprint& f, const FootprintGradient& g, SplatParameters& result) {
  auto row = result.row(i);
  const Eigen::Matrix3d rotation = view.camera_from_origin.rotation.toRotationMatrix();
  const double z = f.in_camera.z();
  const Eigen::Matrix2d covariance = -f.conic * g.conic * f.conic;
  const Matrix23 p = f.jacobian * rotation;
  const Matrix23 m = p * f.turn * f.scale.asDiagonal();
  const Matrix23 grad_m = (covariance + covariance.transpose()) * m;
  row.segment<3>(3) = grad_m.cwiseProduct(m).colwise().sum();
  row.segment<4>(6) =
      quaternion_gradient(f, p.transpose() * grad_m * f.scale.asDiagonal()).transpose();
  row[10] = g.opacity * f.opacity * (1 - f.opacity);

  // Centre, through the Jacobian and the pixel.
  const Matrix23 grad_p = grad_m * f.scale.asDiagonal() * f.turn.transpose();
  const Matrix23 grad_j = grad_p * rotation.transpose();
  const double fx = view.camera.fx_px, fy = view.camera.fy_px;
  Eigen::Vector2d grad_uv(fx * g.pixel.x(), fy * g.pixel.y());
  if (f.u_free) grad_uv.x() += -fx / z * grad_j(0, 2);
  if (f.v_free) grad_uv.y() += -fy / z * grad_j(1, 2);
  Eigen::Vector3d in_camera(grad_uv.x() / z, grad_uv.y() / z, 0);
  in_camera.z() =
      -grad_j.cwiseProduct(f.jacobian).sum() / z - grad_uv.dot(f.in_camera.head<2>()) / (z * z);
  Eigen::Vector3d centre = rotation.transpose() * in_camera;

  Eigen::Vector3d color = g.color;
  for (int c = 0; c < 3; ++c) {
    if (!(f.raw_color[c] > 0)) color[c] = 0;
  }
  double basis[16], weight[16] = {}, along[3] = {};
  const Eigen::Vector3d& d = f.direction;
  sh_basis(view.sh_degree, d.x(), d.y(), d.z(), basis);
  const int functions = (view.sh_degree + 1) * (view.sh_degree + 1);
  for (int c = 0; c < 3; ++c) {
    row[11 + c] = basis[0] * color[c];
    for (int k = 1; k < functions; ++k) {
      row[14 + 15 * c + k - 1] = basis[k] * color[c];
      weight[k] += color[c] * parameters(i, 14 + 15 * c + k - 1);
    }
  }
  add_sh_direction_gradient(view.sh_degree, d.x(), d.y(), d.z(), weight, along);
  const Eigen::Vector3d direction(along[0], along[1], along[2]);
  centre += (direction - d * d.dot(direction)) / f.distance;
  row.segment<3>(0) = centre.transpose();
}

}  // namespace

SplatParameters splat_parameters(const std::vector<Splat>& splats) {
  SplatParameters p(static_cast<Eigen::Index>(splats.size()), 59);
  for (Eigen::Index i = 0; i < p.rows(); ++i) {
    const Splat& s = splats[static_cast<std::size_t>(i)];
    p.row(i).segment<3>(0) = s.centre_m.cast<double>().transpose();
    p.row(i).segment<3>(3) = s.log_scale.cast<double>().transpose();
    p.row(i).segment<4>(6) = s.rotation_wxyz.cast<double>().transpose();
    p(i, 10) = s.opacity_logit;
    for (int k = 0; k < 3; ++k) p(i, 11 + k) = s.sh_dc[static_cast<std::size_t>(k)];
    for (int k = 0; k < 45; ++k) p(i, 14 + k) = s.sh_rest[static_cast<std::size_t>(k)];
  }
  return p;
}

ReferenceImage render_reference(const SplatParameters& parameters, const ReferenceView& view) {
  const std::vector<Footprint> all = footprints(parameters, view);
  const std::vector<std::size_t> order = front_to_back(all);
  const Eigen::Index pixels =
      static_cast<Eigen::Index>(view.camera.width_px) * view.camera.height_px;
  ReferenceImage image;
  image.color.resize(pixels, 3);
  image.transmittance.resize(pixels);
  const Eigen::Vector3d background(view.background[0], view.background[1], view.background[2]);
  for (Eigen::Index n = 0; n < pixels; ++n) {
    const auto x = static_cast<double>(n % view.camera.width_px);
    const auto y = static_cast<double>(n / view.camera.width_px);
    double left = 1;
    Eigen::Vector3d color = Eigen::Vector3d::Zero();
    for (const Blended& b : blended_at(all, order, {x, y}, left)) {
      color += b.alpha * b.before * all[b.splat].color;
    }
    image.color.row(n) = (color + left * background).transpose();
    image.transmittance[n] = left;
  }
  return image;
}

SplatParameters reference_gradients(
    const SplatParameters& parameters, const ReferenceView& view,
    const Eigen::Matrix<double, Eigen::Dynamic, 3>& color_gradient) {
  const std::vector<Footprint> all = footprints(parameters, view);
  const std::vector<std::size_t> order = front_to_back(all);
  std::vector<FootprintGradient> gradients(all.size());
  const Eigen::Vector3d background(view.background[0], view.background[1], view.background[2]);
  for (Eigen::Index n = 0; n < color_gradient.rows(); ++n) {
    const auto x = static_cast<double>(n % view.camera.width_px);
    const auto y = static_cast<double>(n / view.camera.width_px);
    const Eigen::Vector3d g = color_gradient.row(n).transpose();
    double left = 1;
    const std::vector<Blended> list = blended_at(all, order, {x, y}, left);
    // Back to front: `behind` is what would be seen with nothing in front.
    Eigen::Vector3d behind = background;
    for (auto b = list.rbegin(); b != list.rend(); ++b) {
      const Footprint& f = all[b->splat];
      FootprintGradient& to = gradients[b->splat];
      to.color += b->alpha * b->before * g;
      if (!b->limited) {
        const double grad_alpha = b->before * g.dot(f.color - behind);
        to.opacity += grad_alpha * b->alpha / f.opacity;
        to.pixel += grad_alpha * b->alpha * (f.conic * b->offset);
        to.conic -= 0.5 * grad_alpha * b->alpha * b->offset * b->offset.transpose();
      }
      behind = b->alpha * f.color + (1 - b->alpha) * behind;
    }
  }
  SplatParameters result = SplatParameters::Zero(parameters.rows(), 59);
  for (Eigen::Index i = 0; i < parameters.rows(); ++i) {
    const Footprint& f = all[static_cast<std::size_t>(i)];
    if (f.shown) {
      parameter_row(parameters, i, view, f, gradients[static_cast<std::size_t>(i)], result);
    }
  }
  return result;
}

}  // namespace cousin
