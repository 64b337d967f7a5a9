#include "perception/mvs/mvs_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cousin {
namespace {

/// Nearest depth that is looked at, as a share of the farthest: a camera may stand inside the
/// volume.
constexpr double kNearShare = 0.02;
/// Rays farther off axis than a tangent of 4 (76 degrees) do not fit a pinhole image.
constexpr double kWidestTangent = 4;
/// Luma below which the ratio of colours is noise.
constexpr float kDarkCode = 12;

struct Bounds {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high = Eigen::Vector2d::Constant(-std::numeric_limits<double>::infinity());
  void add(const Eigen::Vector2d& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
};

PixelRect rect_around(const Bounds& bounds, double margin) {
  if (!(bounds.low.x() <= bounds.high.x())) return {};
  const Eigen::Vector2d low = (bounds.low.array() - margin).floor().max(-1e6).min(1e6);
  const Eigen::Vector2d high = (bounds.high.array() + margin).ceil().max(-1e6).min(1e6);
  return {static_cast<int>(low.x()), static_cast<int>(low.y()),
          static_cast<int>(high.x() - low.x()) + 1, static_cast<int>(high.y() - low.y()) + 1};
}

PixelRect intersection(const PixelRect& a, const PixelRect& b) {
  const int x0 = std::max(a.x0, b.x0), y0 = std::max(a.y0, b.y0);
  const int x1 = std::min(a.x0 + a.width, b.x0 + b.width);
  const int y1 = std::min(a.y0 + a.height, b.y0 + b.height);
  return {x0, y0, std::max(0, x1 - x0), std::max(0, y1 - y0)};
}

std::optional<Eigen::Vector2d> normalized(const Lens& lens, const Eigen::Vector2d& pixel_px) {
  const auto ray = lens.unproject(pixel_px);
  if (!ray || ray->z() <= 0) return std::nullopt;
  const Eigen::Vector2d xy = ray->head<2>() / ray->z();
  if (xy.norm() > kWidestTangent) return std::nullopt;
  return xy;
}

/// Where the volume's edges fall on the image, and on the tangent plane, in view of the lens.
struct Footprint {
  Bounds image_px;
  Bounds tangents;
};
Footprint footprint(const Camera& camera, const Pose& camera_from_world,
                    const SweepVolume& volume) {
  Footprint result;
  // A grid over the box: its edges bend under distortion, and parts may be behind the camera.
  constexpr int kSteps = 8;
  const Eigen::Vector3d size = volume.high_m - volume.low_m;
  double farthest = 0;
  for (const Eigen::Vector3d& corner : corners_in_world_m(volume)) {
    farthest = std::max(farthest, (camera_from_world * corner).z());
  }
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      for (int k = 0; k <= kSteps; ++k) {
        const Eigen::Vector3d share = Eigen::Vector3d(i, j, k) / kSteps;
        const Eigen::Vector3d p =
            camera_from_world * (volume.low_m + size.cwiseProduct(share)).eval();
        if (p.z() < kNearShare * farthest || p.z() <= 0) continue;
        const Eigen::Vector2d tangent = p.head<2>() / p.z();
        if (tangent.norm() > kWidestTangent) continue;
        if (const auto pixel = project(camera, p)) {
          result.image_px.add(*pixel);
          result.tangents.add(tangent);
        }
      }
    }
  }
  return result;
}

/// A light binomial blur (variance a quarter of a square pixel each way): bilinear look-ups of the
/// smoothed image blur it less unevenly between pixel centres and pixel corners.
Image<float> smoothed(const Image<float>& image) {
  const int w = image.width(), h = image.height();
  Image<float> rows(w, h), result(w, h);
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      rows(x, y) = 0.125F * (image(std::max(x - 1, 0), y) + image(std::min(x + 1, w - 1), y)) +
                   0.75F * image(x, y);
    }
  }
  for (int y = 0; y < h; ++y) {
    const auto above = rows.row(std::max(y - 1, 0)), below = rows.row(std::min(y + 1, h - 1));
    const auto here = rows.row(y);
    const auto out = result.row(y);
    for (std::size_t x = 0; x < out.size(); ++x) {
      out[x] = 0.125F * (above[x] + below[x]) + 0.75F * here[x];
    }
  }
  return result;
}

Image<float> laplacian(const Image<float>& image) {
  const int w = image.width(), h = image.height();
  Image<float> result(w, h);
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      result(x, y) = image(std::max(x - 1, 0), y) + image(std::min(x + 1, w - 1), y) +
                     image(x, std::max(y - 1, 0)) + image(x, std::min(y + 1, h - 1)) -
                     4 * image(x, y);
    }
  }
  return result;
}

/// Catmull-Rom weights of the four samples around a fraction.
std::array<float, 4> cubic_taps(float t) {
  return {((-0.5F * t + 1.0F) * t - 0.5F) * t, (1.5F * t - 2.5F) * t * t + 1.0F,
          ((-1.5F * t + 2.0F) * t + 0.5F) * t, (0.5F * t - 0.5F) * t * t};
}

/// Catmull-Rom value at (x, y); zero (mid grey) outside the image.
float sample_cubic(const Image<float>& image, float x, float y) {
  const float fx = std::floor(x), fy = std::floor(y);
  const int ix = static_cast<int>(fx), iy = static_cast<int>(fy);
  if (ix < 0 || iy < 0 || ix >= image.width() || iy >= image.height()) return 0;
  const std::array<float, 4> wx = cubic_taps(x - fx), wy = cubic_taps(y - fy);
  float sum = 0;
  for (int j = 0; j < 4; ++j) {
    const auto row = image.row(std::clamp(iy + j - 1, 0, image.height() - 1));
    float line = 0;
    for (int i = 0; i < 4; ++i) {
      const auto column = static_cast<std::size_t>(std::clamp(ix + i - 1, 0, image.width() - 1));
      line += wx[static_cast<std::size_t>(i)] * row[column];
    }
    sum += wy[static_cast<std::size_t>(j)] * line;
  }
  return sum;
}

void fill_source(const Image<Rgb8>& image, const Camera& camera, MvsView& view) {
  const PixelRect& rect = view.rect;
  const Lens lens(camera);
  const LensGrid rays(rect, [&](const Eigen::Vector2d& pixel) { return normalized(lens, pixel); });
  view.ray_x = view.ray_y = view.chroma_b = view.chroma_r = Image<float>(rect.width, rect.height);
  Image<float> luma(rect.width, rect.height);
  for (int y = 0; y < rect.height; ++y) {
    for (int x = 0; x < rect.width; ++x) {
      const Rgb8 c = image(rect.x0 + x, rect.y0 + y);
      const float code = 0.299F * c.r + 0.587F * c.g + 0.114F * c.b;  // Rec. 601
      luma(x, y) = code - 128.0F;
      view.chroma_b(x, y) = (c.b - code) / (code + kDarkCode);
      view.chroma_r(x, y) = (c.r - code) / (code + kDarkCode);
      const Eigen::Vector2f ray =
          rays(static_cast<float>(rect.x0 + x), static_cast<float>(rect.y0 + y));
      view.ray_x(x, y) = ray.x();
      view.ray_y(x, y) = ray.y();
    }
  }
  view.luma = smoothed(luma);
  view.detail = laplacian(view.luma);
}

void fill_pinhole(const Camera& camera, const Bounds& tangents, MvsView& view) {
  view.focal_px = {static_cast<float>(camera.fx_px), static_cast<float>(camera.fy_px)};
  view.principal_px = {static_cast<float>(camera.cx_px), static_cast<float>(camera.cy_px)};
  const Eigen::Vector2d f(camera.fx_px, camera.fy_px), c(camera.cx_px, camera.cy_px);
  Bounds px;
  px.add(f.cwiseProduct(tangents.low) + c);
  px.add(f.cwiseProduct(tangents.high) + c);
  // The undistorted image of what the source rectangle shows; no look-up leaves it.
  Bounds seen;
  for (std::size_t i = 0; i < view.ray_x.size(); ++i) {
    const Eigen::Vector2d ray(view.ray_x.data()[i], view.ray_y.data()[i]);
    if (std::isfinite(ray.x())) seen.add(f.cwiseProduct(ray) + c);
  }
  view.pinhole_rect = intersection(rect_around(px, 6), rect_around(seen, 1));
  if (view.pinhole_rect.empty()) return;
  const Lens lens(camera);
  view.distorted_from_pinhole = LensGrid(view.pinhole_rect, [&](const Eigen::Vector2d& pixel) {
    return lens.project(((pixel - c).cwiseQuotient(f)).homogeneous());
  });
  view.pinhole_luma = Image<float>(view.pinhole_rect.width, view.pinhole_rect.height);
  for (int y = 0; y < view.pinhole_rect.height; ++y) {
    for (int x = 0; x < view.pinhole_rect.width; ++x) {
      const Eigen::Vector2f source =
          view.distorted_from_pinhole(static_cast<float>(view.pinhole_rect.x0 + x),
                                      static_cast<float>(view.pinhole_rect.y0 + y));
      if (!std::isfinite(source.x())) continue;  // stays mid grey
      view.pinhole_luma(x, y) =
          sample_cubic(view.luma, source.x() - static_cast<float>(view.rect.x0),
                       source.y() - static_cast<float>(view.rect.y0));
    }
  }
}

}  // namespace

std::array<Eigen::Vector3d, 8> corners_in_world_m(const SweepVolume& volume) {
  std::array<Eigen::Vector3d, 8> corners;
  for (std::size_t i = 0; i < 8; ++i) {
    corners[i] = {(i & 1U) != 0 ? volume.high_m.x() : volume.low_m.x(),
                  (i & 2U) != 0 ? volume.high_m.y() : volume.low_m.y(),
                  (i & 4U) != 0 ? volume.high_m.z() : volume.low_m.z()};
  }
  return corners;
}

std::optional<MvsView> prepare_view(const Capture& capture, const Poses& poses, int index,
                                    const SweepVolume& volume) {
  const FramePose& pose = poses[static_cast<std::size_t>(index)];
  const Image<Rgb8>& image = capture.frames[static_cast<std::size_t>(index)].sensors.at(0).color;
  MvsView view;
  view.index = index;
  view.camera_from_world = pose.camera_from_world;
  view.centre_in_world_m = cousin::centre_in_world_m(pose.camera_from_world);
  view.distance_m = (view.centre_in_world_m - 0.5 * (volume.low_m + volume.high_m)).norm();
  const Footprint seen = footprint(pose.camera, pose.camera_from_world, volume);
  view.rect = intersection(rect_around(seen.image_px, 6), {0, 0, image.width(), image.height()});
  if (view.rect.width < 16 || view.rect.height < 16) return std::nullopt;
  fill_source(image, pose.camera, view);
  fill_pinhole(pose.camera, seen.tangents, view);
  if (view.pinhole_rect.width < 16 || view.pinhole_rect.height < 16) return std::nullopt;
  return view;
}

std::vector<int> choose_neighbours(const std::vector<MvsView>& views, int reference,
                                   const SweepVolume& volume, const MvsConfig& config) {
  constexpr double kBestAngle = 0.25;  // enough parallax for depth, little change of appearance
  constexpr double kSameSideCost = 0.7;
  const MvsView& here = views[static_cast<std::size_t>(reference)];
  const Eigen::Vector3d centre = 0.5 * (volume.low_m + volume.high_m);
  const Eigen::Vector3d direction = (here.centre_in_world_m - centre).normalized();
  struct Candidate {
    int view;
    double cost;
    Eigen::Vector3d side;  ///< unit, across the reference's direction
  };
  std::vector<Candidate> candidates;
  for (int i = 0; i < static_cast<int>(views.size()); ++i) {
    const MvsView& other = views[static_cast<std::size_t>(i)];
    const Eigen::Vector3d towards = (other.centre_in_world_m - centre).normalized();
    const double angle = std::atan2(direction.cross(towards).norm(), direction.dot(towards));
    const double scale = std::abs(std::log(other.distance_m / here.distance_m));
    if (i == reference || angle < config.min_angle_rad || angle > config.max_angle_rad ||
        scale > 0.7) {
      continue;
    }
    const Eigen::Vector3d side = (towards - direction * direction.dot(towards)).normalized();
    candidates.push_back({i, std::abs(angle - kBestAngle) / kBestAngle + 2 * scale, side});
  }
  std::vector<int> chosen;
  while (static_cast<int>(chosen.size()) < config.neighbours && !candidates.empty()) {
    const auto best =
        std::min_element(candidates.begin(), candidates.end(),
                         [](const auto& a, const auto& b) { return a.cost < b.cost; });
    const Candidate taken = *best;
    chosen.push_back(taken.view);
    candidates.erase(best);
    for (Candidate& c : candidates) c.cost += kSameSideCost * std::max(0.0, c.side.dot(taken.side));
  }
  return chosen;
}

Warp warp_between(const MvsView& reference, const MvsView& neighbour) {
  const Pose relative = neighbour.camera_from_world * inverse(reference.camera_from_world);
  Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
  k(0, 0) = neighbour.focal_px.x();
  k(1, 1) = neighbour.focal_px.y();
  // Pixels count from the corner of the neighbour's undistorted copy.
  k(0, 2) = neighbour.principal_px.x() - neighbour.pinhole_rect.x0;
  k(1, 2) = neighbour.principal_px.y() - neighbour.pinhole_rect.y0;
  return {(k * relative.rotation.toRotationMatrix()).cast<float>(),
          (k * relative.translation_m).cast<float>()};
}

}  // namespace cousin
