#include "calibration/boards/board_template.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <optional>

namespace cousin {
namespace {

constexpr int kBlockSquares = 3;

/// Board points (in squares) at pixel centres, one pixel wider than the box on each side.
Image<Eigen::Vector2f> board_points(const BoardPattern& pattern, LensMap& lens, const PixelBox& box,
                                    const Eigen::Matrix3d& normalized_from_board) {
  const Eigen::Matrix3d squares_from_normalized =
      pattern.squares_from_board() * normalized_from_board.inverse();
  // The plane is in front where the third coordinate has the sign it has at the board's origin.
  const Eigen::Vector3d origin = normalized_from_board.col(2);
  const double sign = (squares_from_normalized * (origin / origin.z())).z() > 0 ? 1 : -1;
  Image<Eigen::Vector2f> points(box.width + 2, box.height + 2, Eigen::Vector2f::Zero());
  for (int y = 0; y < points.height(); ++y) {
    for (int x = 0; x < points.width(); ++x) {
      const Eigen::Vector3d p =
          squares_from_normalized * lens(box.x + x - 1, box.y + y - 1).homogeneous();
      points(x, y) = sign * p.z() > 0
                         ? Eigen::Vector2f((p.head<2>() / p.z()).cast<float>())
                         : Eigen::Vector2f::Constant(std::numeric_limits<float>::quiet_NaN());
    }
  }
  return points;
}

/// Fibonacci lattice of the unit square [Sloan & Joe, Lattice Methods for Multiple Integration,
/// 1994]: as many different x and y as points. `count` and `step` are successive Fibonacci numbers,
/// the larger first.
std::vector<Eigen::Vector2f> fibonacci_lattice(int count, int step) {
  std::vector<Eigen::Vector2f> points;
  for (int i = 0; i < count; ++i) {
    points.push_back(Eigen::Vector2f(i + 0.5F, (step * i) % count + 0.5F) /
                     static_cast<float>(count));
  }
  return points;
}

/// A shift within the unit square that differs between neighbouring pixels: the additive recurrence
/// R2.
Eigen::Vector2f pixel_shift(int x, int y) {
  constexpr double kA = 0.7548776662466927, kB = 0.5698402909980532;
  const double n = x + 97.0 * y;
  return {static_cast<float>(kA * n - std::floor(kA * n)),
          static_cast<float>(kB * n - std::floor(kB * n))};
}

void blur(Image<float>& image, double sigma_px) {
  cv::Mat mat(image.height(), image.width(), CV_32F, image.data());
  const int size = 2 * static_cast<int>(std::ceil(3.5 * sigma_px)) + 1;
  cv::GaussianBlur(mat, mat, cv::Size(size, size), sigma_px, sigma_px, cv::BORDER_REPLICATE);
}

}  // namespace

LensMap::LensMap(const Camera& camera)
    : lens_(camera),
      columns_(camera.width_px / kStep + 4),
      nodes_(static_cast<std::size_t>(columns_) *
             static_cast<std::size_t>(camera.height_px / kStep + 4)),
      known_(nodes_.size(), 0) {}

const Eigen::Vector2d& LensMap::node(int column, int row) {
  const auto i = static_cast<std::size_t>(row * columns_ + column);
  if (known_[i] == 0) {
    const std::optional<Eigen::Vector3d> ray =
        lens_.unproject(Eigen::Vector2d((column - 1) * kStep, (row - 1) * kStep));
    nodes_[i] = ray && ray->z() > 1e-3
                    ? Eigen::Vector2d(ray->head<2>() / ray->z())
                    : Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
    known_[i] = 1;
  }
  return nodes_[i];
}

Eigen::Vector2d LensMap::operator()(int x, int y) {
  const int column = x / kStep + (x >= 0 ? 1 : 0), row = y / kStep + (y >= 0 ? 1 : 0);
  const double u = static_cast<double>(x - (column - 1) * kStep) / kStep;
  const double v = static_cast<double>(y - (row - 1) * kStep) / kStep;
  return (1 - v) * ((1 - u) * node(column, row) + u * node(column + 1, row)) +
         v * ((1 - u) * node(column, row + 1) + u * node(column + 1, row + 1));
}

BoardPattern::BoardPattern(const SeedBoard& board)
    : squares_(board.squares),
      square_m_(board.square_m),
      margin_(static_cast<float>(0.5 * (board.plate_m / board.square_m - board.squares))),
      marker_inset_(static_cast<float>(0.5 * (kBlockSquares - board.marker_m / board.square_m))),
      module_(static_cast<float>(board.marker_m / board.square_m / kMarkerModules)),
      cells_(static_cast<std::size_t>(board.squares) * static_cast<std::size_t>(board.squares)) {
  for (int row = 0; row < squares_; ++row) {
    for (int column = 0; column < squares_; ++column) {
      const bool left = column < kBlockSquares, right = column >= squares_ - kBlockSquares;
      const bool low = row < kBlockSquares, high = row >= squares_ - kBlockSquares;
      std::uint8_t cell = (column + row) % 2 == 0 ? 0 : 1;
      if (board.has_markers && (left || right) && (low || high)) {
        cell = static_cast<std::uint8_t>(2 + (low ? (left ? 0 : 1) : (right ? 2 : 3)));
      }
      cells_[static_cast<std::size_t>(row * squares_ + column)] = cell;
    }
  }
  if (!board.has_markers) return;
  for (const int id : board.marker_ids) {
    for (int row = kMarkerModules - 1; row >= 0; --row) {
      for (int column = 0; column < kMarkerModules; ++column) {
        modules_.push_back(marker_module_black(id, column, row) ? 0 : 1);
      }
    }
  }
}

bool BoardPattern::is_white(float x, float y) const {
  if (!(x >= 0 && y >= 0)) return true;
  const int column = static_cast<int>(x), row = static_cast<int>(y);
  if (column >= squares_ || row >= squares_) return true;
  const std::uint8_t cell = cells_[static_cast<std::size_t>(row * squares_ + column)];
  if (cell < 2) return cell == 1;
  const float block = static_cast<float>(squares_ - kBlockSquares);
  const float u = (x - (column < kBlockSquares ? 0 : block) - marker_inset_) / module_;
  const float v = (y - (row < kBlockSquares ? 0 : block) - marker_inset_) / module_;
  if (u < 0 || v < 0 || u >= kMarkerModules || v >= kMarkerModules) return true;
  const int module = static_cast<int>(v) * kMarkerModules + static_cast<int>(u);
  return modules_[static_cast<std::size_t>((cell - 2) * kMarkerModules * kMarkerModules +
                                           module)] == 1;
}

bool BoardPattern::is_uniform(const Eigen::Vector2f& centre, const Eigen::Vector2f& reach) const {
  const auto inside_one = [&](float c, float r) { return std::floor(c - r) == std::floor(c + r); };
  const auto outside = [&](float c, float r) {
    return c + r < 0 || c - r >= static_cast<float>(squares_);
  };
  if (outside(centre.x(), reach.x()) || outside(centre.y(), reach.y())) return true;
  if (!inside_one(centre.x(), reach.x()) || !inside_one(centre.y(), reach.y())) return false;
  const int column = static_cast<int>(std::floor(centre.x())),
            row = static_cast<int>(std::floor(centre.y()));
  if (column < 0 || row < 0 || column >= squares_ || row >= squares_) return true;
  return cells_[static_cast<std::size_t>(row * squares_ + column)] < 2;
}

bool BoardPattern::on_plate(float x, float y, float inset) const {
  const float low = -margin_ + inset, high = static_cast<float>(squares_) + margin_ - inset;
  return x > low && y > low && x < high && y < high;
}

Eigen::Matrix3d BoardPattern::squares_from_board() const {
  Eigen::Matrix3d m;
  m << 1 / square_m_, 0, 0.5 * squares_, 0, 1 / square_m_, 0.5 * squares_, 0, 0, 1;
  return m;
}

PixelBox plate_box(const SeedBoard& board, const Camera& camera,
                   const Eigen::Matrix3d& normalized_from_board) {
  constexpr int kSamples = 144;
  const double half = 0.5 * board.plate_m;
  double x0 = camera.width_px, y0 = camera.height_px, x1 = -1, y1 = -1;
  const auto visit = [&](int i, int j) {
    const Eigen::Vector3d p =
        normalized_from_board *
        Eigen::Vector3d(half * (2.0 * i / kSamples - 1), half * (2.0 * j / kSamples - 1), 1);
    const std::optional<Eigen::Vector2d> pixel = project(camera, p);
    if (!pixel) return false;
    x0 = std::min(x0, pixel->x()), x1 = std::max(x1, pixel->x());
    y0 = std::min(y0, pixel->y()), y1 = std::max(y1, pixel->y());
    return true;
  };
  // The inside of the plate is seen within its edge, if the whole edge is where the lens maps.
  bool whole = true;
  for (int k = 0; k <= kSamples; ++k) {
    for (const auto& [i, j] : {std::array{k, 0}, {k, kSamples}, {0, k}, {kSamples, k}}) {
      whole = visit(i, j) && whole;
    }
  }
  for (int i = 1; i < kSamples && !whole; ++i) {
    for (int j = 1; j < kSamples; ++j) visit(i, j);
  }
  const auto clamp = [](double v, int size) {
    return static_cast<int>(std::clamp(v, 0.0, size - 1.0));
  };
  PixelBox box;
  if (x1 < 0 || y1 < 0 || x0 > camera.width_px - 1 || y0 > camera.height_px - 1) return box;
  box.x = clamp(std::floor(x0) - 1, camera.width_px);
  box.y = clamp(std::floor(y0) - 1, camera.height_px);
  box.width = clamp(std::ceil(x1) + 1, camera.width_px) - box.x + 1;
  box.height = clamp(std::ceil(y1) + 1, camera.height_px) - box.y + 1;
  return box;
}

BoardTemplate render_board(const BoardPattern& pattern, LensMap& lens, const PixelBox& box,
                           const Eigen::Matrix3d& normalized_from_board, double psf_sigma_px,
                           TemplateQuality quality) {
  const Image<Eigen::Vector2f> points = board_points(pattern, lens, box, normalized_from_board);
  BoardTemplate t{box, Image<float>(box.width, box.height),
                  Image<Eigen::Vector2f>(box.width, box.height, Eigen::Vector2f::Zero())};
  // The error of an edge's place falls faster than 1/count: 0.01 px and 0.002 px over a corner's
  // window.
  const std::vector<Eigen::Vector2f> lattice =
      quality == TemplateQuality::fine ? fibonacci_lattice(144, 89) : fibonacci_lattice(21, 13);
  for (int y = 0; y < box.height; ++y) {
    for (int x = 0; x < box.width; ++x) {
      const Eigen::Vector2f centre = points(x + 1, y + 1);
      t.in_squares(x, y) = centre;
      if (!pattern.on_plate(centre.x(), centre.y(), -1.0F)) continue;
      const Eigen::Vector2f ex = 0.5F * (points(x + 2, y + 1) - points(x, y + 1));
      const Eigen::Vector2f ey = 0.5F * (points(x + 1, y + 2) - points(x + 1, y));
      const Eigen::Vector2f reach = 0.5F * (ex.cwiseAbs() + ey.cwiseAbs());
      if (pattern.is_uniform(centre, reach)) {
        t.white(x, y) = pattern.is_white(centre.x(), centre.y()) ? 1.0F : 0.0F;
        continue;
      }
      // Each pixel turns the lattice by its own shift, so that an edge along a row meets no common
      // grid.
      const Eigen::Vector2f shift = pixel_shift(x, y);
      int white = 0;
      for (const Eigen::Vector2f& sample : lattice) {
        const Eigen::Vector2f u = sample + shift;
        const Eigen::Vector2f p = centre + (u.x() - std::floor(u.x()) - 0.5F) * ex +
                                  (u.y() - std::floor(u.y()) - 0.5F) * ey;
        white += pattern.is_white(p.x(), p.y()) ? 1 : 0;
      }
      t.white(x, y) = static_cast<float>(white) / static_cast<float>(lattice.size());
    }
  }
  blur(t.white, psf_sigma_px);
  return t;
}

Eigen::Vector2f gradient(const BoardTemplate& t, int x, int y) {
  // Fourth order, so that it is right for structures of three pixels too.
  const auto at = [&](int u, int v) {
    return t.white(std::clamp(u, 0, t.box.width - 1), std::clamp(v, 0, t.box.height - 1));
  };
  constexpr float kNear = 2.0F / 3, kFar = 1.0F / 12;
  return {kNear * (at(x + 1, y) - at(x - 1, y)) - kFar * (at(x + 2, y) - at(x - 2, y)),
          kNear * (at(x, y + 1) - at(x, y - 1)) - kFar * (at(x, y + 2) - at(x, y - 2))};
}

}  // namespace cousin
