#include "perception/stem/node_shift.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "sim/config/limits.h"

namespace cousin {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Bilinear, the border repeated.
double at(const Image<float>& image, const Vector2d& px) {
  const double x = std::clamp(px.x(), 0.0, image.width() - 1.001);
  const double y = std::clamp(px.y(), 0.0, image.height() - 1.001);
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const double u = x - x0, v = y - y0;
  const auto value = [&](int i, int j) { return static_cast<double>(image(x0 + i, y0 + j)); };
  return (1 - v) * ((1 - u) * value(0, 0) + u * value(1, 0)) +
         v * ((1 - u) * value(0, 1) + u * value(1, 1));
}

/// Both channels of a window, one after the other.
Eigen::VectorXd window(const EyePicture& picture, const Vector2d& middle,
                       const NodeShiftConfig& c) {
  const int w = 2 * c.half_width_px + 1, h = 2 * c.half_height_px + 1;
  Eigen::VectorXd values(2 * w * h);
  int i = 0;
  for (const Image<float>* channel : {&picture.luma, &picture.green}) {
    for (int y = -c.half_height_px; y <= c.half_height_px; ++y) {
      for (int x = -c.half_width_px; x <= c.half_width_px; ++x)
        values(i++) = at(*channel, middle + Vector2d(x, y));
    }
  }
  return values;
}

/// Each channel less its mean, both over one length.
Eigen::VectorXd normalised(Eigen::VectorXd values) {
  const Eigen::Index half = values.size() / 2;
  values.head(half).array() -= values.head(half).mean();
  values.tail(half).array() -= values.tail(half).mean();
  const double length = values.norm();
  if (length > 1e-9) values /= length;
  return values;
}

bool is_inside(const Image<float>& image, const Vector2d& px, const NodeShiftConfig& c) {
  return px.x() >= c.half_width_px && px.y() >= c.half_height_px &&
         px.x() < image.width() - c.half_width_px - 1 &&
         px.y() < image.height() - c.half_height_px - 1;
}

/// The right pixel at another column on the line.
std::optional<Vector2d> on_line(const EyePair& eyes, const Vector3d& left_ray, double column_px,
                                double near_row_px, double off_px) {
  const Vector3d line = eyes.essential * (left_ray / left_ray.z());
  const auto guess = eyes.right.unproject({column_px, near_row_px});
  if (!guess || !(guess->z() > 0) || std::abs(line.y()) < 1e-9) return std::nullopt;
  const double x = guess->x() / guess->z();
  const auto seen = eyes.right.project(Vector3d(x, -(line.z() + line.x() * x) / line.y(), 1));
  if (!seen) return std::nullopt;
  return *seen + Vector2d(0, off_px);
}

/// Moves the right window until both are alike; nothing where it runs away.
std::optional<Vector2d> refine(const EyePicture& right, const Eigen::VectorXd& left_values,
                               Vector2d px, const NodeShiftConfig& c) {
  const Vector2d begin = px;
  for (int step = 0; step < 12; ++step) {
    const Eigen::VectorXd here = normalised(window(right, px, c));
    Eigen::MatrixXd slope(here.size(), 2);
    slope.col(0) = 0.5 * (normalised(window(right, px + Vector2d(1, 0), c)) -
                          normalised(window(right, px - Vector2d(1, 0), c)));
    slope.col(1) = 0.5 * (normalised(window(right, px + Vector2d(0, 1), c)) -
                          normalised(window(right, px - Vector2d(0, 1), c)));
    Eigen::Matrix2d normal = slope.transpose() * slope;
    normal(1, 1) += 0.2 * normal(0, 0);  // a stem says little of its own direction
    const Vector2d move = normal.ldlt().solve(slope.transpose() * (left_values - here));
    if (!move.allFinite()) return std::nullopt;
    px += move.cwiseMax(-1).cwiseMin(1);
    if (std::abs(px.x() - begin.x()) > 2 || std::abs(px.y() - begin.y()) > 2) return std::nullopt;
    if (move.norm() < 1e-3) break;
  }
  return px;
}

NodeShift no_shift(const char* why) {
  NodeShift none;
  none.why_none = why;
  return none;
}

}  // namespace

Fields fields(NodeShiftConfig& c) {
  return {
      {"half_width_px", &c.half_width_px, "of the window, across the stem", 2, 100},
      {"half_height_px", &c.half_height_px, "of the window, along the stem", 2, 100},
      {"search_px", &c.search_px, "to both sides of the right point, at least", 0.5, 200},
      {"search_sigmas", &c.search_sigmas, "and so many deviations of the points", 0, 20},
      {"least_likeness", &c.least_likeness, "correlation of the windows; less is no match", 0, 1},
      {"sigma_px", &c.sigma_px, "deviation of a match", 0.01, 10}};
}

void validate(const NodeShiftConfig& config) {
  NodeShiftConfig copy = config;
  check_limits(fields(copy), "shift");
}

EyePicture eye_picture(const Image<Rgb8>& color) {
  EyePicture picture{Image<float>(color.width(), color.height()),
                     Image<float>(color.width(), color.height())};
  for (int y = 0; y < color.height(); ++y) {
    for (int x = 0; x < color.width(); ++x) {
      const Rgb8& c = color(x, y);
      picture.luma(x, y) = static_cast<float>(0.299 * c.r + 0.587 * c.g + 0.114 * c.b);
      picture.green(x, y) = static_cast<float>(2 * c.g - c.r - c.b);
    }
  }
  return picture;
}

NodeShift find_shift(const EyePair& eyes, const EyePicture& left, const EyePicture& right,
                     const EyeNode& left_node, const EyeNode& right_node, double off_px,
                     const NodeShiftConfig& config) {
  if (!is_inside(left.luma, left_node.pixel_px, config))
    return no_shift("the left window leaves the image");
  const auto ray = eyes.left.unproject(left_node.pixel_px);
  if (!ray || !(ray->z() > 0)) return no_shift("the left lens shows no ray there");
  const Eigen::VectorXd own = normalised(window(left, left_node.pixel_px, config));
  const double reach_px = std::max(
      config.search_px, config.search_sigmas * std::hypot(left_node.sigma_px, right_node.sigma_px));
  Vector2d best_px = Vector2d::Zero();
  double best = -1;
  const int steps = static_cast<int>(std::ceil(reach_px));
  for (int s = -steps; s <= steps; ++s) {
    const auto px =
        on_line(eyes, *ray, right_node.pixel_px.x() + s, right_node.pixel_px.y(), off_px);
    if (!px || !is_inside(right.luma, *px, config)) continue;
    const double likeness = own.dot(normalised(window(right, *px, config)));
    if (likeness <= best) continue;
    best = likeness;
    best_px = *px;
  }
  if (best < config.least_likeness) return no_shift("the windows are unlike");
  const auto px = refine(right, own, best_px, config);
  if (!px) return no_shift("the windows do not settle");
  NodeShift shift;
  shift.right_px = *px;
  shift.likeness = own.dot(normalised(window(right, *px, config)));
  return shift;
}

}  // namespace cousin
