#include "perception/fruit/fruit_tracks.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <queue>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "sim/config/limits.h"

namespace cousin {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::size_t kMostBoxes = 20'000;
constexpr std::size_t kMostPairs = 10'000'000;

// ---- Places -------------------------------------------------------------------------------------

/// Middle of the mask, or of the box.
Eigen::Vector2d mask_middle_px(const DetectedBox& box) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double count = 0;
  for (int y = 0; y < box.mask.height(); ++y) {
    for (int x = 0; x < box.mask.width(); ++x) {
      if (box.mask(x, y) == 0) continue;
      sum += Eigen::Vector2d(box.mask_at_px.x() + x, box.mask_at_px.y() + y);
      ++count;
    }
  }
  return count > 0 ? Eigen::Vector2d(sum / count)
                   : Eigen::Vector2d(0.5 * (box.low_px + box.high_px));
}

/// Depths inside the mask, or in the middle half of the box.
std::vector<double> depths_in(const DetectedBox& box, const Image<float>& depth_m) {
  std::vector<double> depths;
  const auto add = [&](int x, int y) {
    if (depth_m.contains(x, y) && depth_m(x, y) > 0)
      depths.push_back(static_cast<double>(depth_m(x, y)));
  };
  if (box.mask.empty()) {
    const Eigen::Vector2d middle = 0.5 * (box.low_px + box.high_px),
                          half = 0.25 * (box.high_px - box.low_px);
    const Eigen::Vector2d
        first = (middle - half).cwiseMax(0.0),
        last = (middle + half).cwiseMin(Eigen::Vector2d(depth_m.width() - 1, depth_m.height() - 1));
    for (int y = static_cast<int>(std::ceil(first.y())); y <= last.y(); ++y) {
      for (int x = static_cast<int>(std::ceil(first.x())); x <= last.x(); ++x) add(x, y);
    }
    return depths;
  }
  for (int y = 0; y < box.mask.height(); ++y) {
    for (int x = 0; x < box.mask.width(); ++x) {
      if (box.mask(x, y) != 0) add(box.mask_at_px.x() + x, box.mask_at_px.y() + y);
    }
  }
  return depths;
}

double middle_value(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// A covariance of so much along a ray and across it.
Matrix3d about_ray(const Vector3d& ray, double along_m, double across_m) {
  const Matrix3d along = ray * ray.transpose();
  return along_m * along_m * along + across_m * across_m * (Matrix3d::Identity() - along);
}

/// A place on the ray through the mask's middle. @param depth_m  of the fruit's middle
LocatedPoint on_ray(const DetectedBox& box, const Camera& camera, double depth_m, double along_m,
                    const FruitPrior& prior) {
  const auto found = unproject(camera, mask_middle_px(box));
  const Vector3d ray = (found ? *found : Vector3d::UnitZ()).normalized();
  const double radius_m = 0.5 * prior.diameter_m;
  const double px_per_m = 0.5 * (camera.fx_px + camera.fy_px) / depth_m;
  const double section_px = std::numbers::pi * radius_m * radius_m * px_per_m * px_per_m;
  const double hidden = 1 - std::min(1.0, pixels_of(box) / section_px);
  // A cap's middle is up to a radius beside the section's.
  const double across_m = radius_m * std::hypot(0.1, 0.45 * hidden);
  return {ray * (depth_m / ray.z()), about_ray(ray, along_m, across_m)};
}

/// How far a fruit of the kind's size is, were the mask's longest side its diameter.
struct SizeDepth {
  double whole_m = 0, sigma_whole_m = 0;
  double hidden = 0;  ///< of the disc about the mask
};
SizeDepth depth_by_size(const DetectedBox& box, const Camera& camera, const FruitPrior& prior) {
  const Eigen::Vector2d extent_px = box.high_px - box.low_px;
  const double across_px = std::max(1.0, extent_px.maxCoeff());
  const double disc_px = 0.25 * std::numbers::pi * across_px * across_px;
  SizeDepth depth;
  depth.whole_m = 0.5 * (camera.fx_px + camera.fy_px) * prior.diameter_m / across_px;
  depth.sigma_whole_m = depth.whole_m * std::hypot(prior.sigma_diameter, 1 / across_px);
  depth.hidden = 1 - std::min(1.0, pixels_of(box) / disc_px);
  return depth;
}

// ---- Groups -------------------------------------------------------------------------------------

struct Group {
  std::vector<int> frames;  ///< sorted
  std::vector<int> boxes;   ///< sorted
  Vector3d mean_m;
  Matrix3d covariance_m2;
  int version = 0;  ///< -1: it is part of another
};

/// Log of how much likelier two groups are one fruit; negative where they are not.
double lead_of(const Group& a, const Group& b, const FruitTracksConfig& config) {
  constexpr double kNever = -1;
  const Vector3d off_m = a.mean_m - b.mean_m;
  const Matrix3d sum_m2 = a.covariance_m2 + b.covariance_m2;
  const double most = config.most_off * config.most_off;
  if (off_m.squaredNorm() > most * sum_m2.trace()) return kNever;
  const Eigen::LLT<Matrix3d> llt(sum_m2);
  const Vector3d scaled = llt.matrixL().solve(off_m);
  if (scaled.squaredNorm() > most) return kNever;
  const Matrix3d l = llt.matrixL();
  const double log_peak = -1.5 * std::log(2 * std::numbers::pi) - std::log(l.diagonal().prod());
  const double lead = -0.5 * scaled.squaredNorm() + log_peak - std::log(config.per_m3);
  if (lead <= 0) return kNever;
  std::vector<int> both;
  std::set_intersection(a.frames.begin(), a.frames.end(), b.frames.begin(), b.frames.end(),
                        std::back_inserter(both));
  return both.empty() ? lead : kNever;
}

std::vector<int> merged(const std::vector<int>& a, const std::vector<int>& b) {
  std::vector<int> all;
  std::merge(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(all));
  return all;
}

Group joined(const Group& a, const Group& b) {
  Group one;
  one.frames = merged(a.frames, b.frames);
  one.boxes = merged(a.boxes, b.boxes);
  const Matrix3d gain = a.covariance_m2 * (a.covariance_m2 + b.covariance_m2).inverse();
  one.mean_m = a.mean_m + gain * (b.mean_m - a.mean_m);
  const Matrix3d covariance = a.covariance_m2 - gain * a.covariance_m2;
  one.covariance_m2 = 0.5 * (covariance + covariance.transpose());
  return one;
}

/// A pair that may be one; the likeliest comes first, then by the boxes' numbers.
struct Pair {
  double lead = 0;
  std::size_t a = 0, b = 0;
  int version_a = 0, version_b = 0;
  bool operator<(const Pair& other) const {
    return std::tie(lead, other.a, other.b) < std::tie(other.lead, a, b);
  }
};

}  // namespace

Fields fields(FruitTracksConfig& c) {
  return {
      {"least_px", &c.least_px, "pixels of a box's mask; smaller ones are left out", 1, 1000000},
      {"per_m3", &c.per_m3, "fruits where they hang", 1e-3, 1e6},
      {"pose_sigma_m", &c.pose_sigma_m, "of a camera's place, each axis", 1e-5, 1},
      {"most_off", &c.most_off, "sigmas between two boxes of one fruit", 0.5, 10},
      {"crown_sigma_m", &c.crown_sigma_m, "of fruits before and behind the row's middle", 0.01,
       10}};
}

void validate(const FruitTracksConfig& config) {
  FruitTracksConfig copy = config;
  check_limits(fields(copy), "tracks");
}

int pixels_of(const DetectedBox& box) {
  if (box.mask.empty()) {
    const double ellipse_px = (box.high_px - box.low_px).cwiseMax(0).prod() * std::numbers::pi / 4;
    return static_cast<int>(std::min(ellipse_px, 1e9));
  }
  return static_cast<int>(std::count_if(box.mask.begin(), box.mask.end(),
                                        [](std::uint8_t inside) { return inside != 0; }));
}

std::optional<LocatedPoint> rough_place(const DetectedBox& box, const Camera& camera,
                                        const FrameDepth& depth, const FruitPrior& prior) {
  constexpr std::size_t kLeast = 5;
  std::vector<double> depths = depths_in(box, depth.depth_m);
  if (depths.size() < kLeast) return std::nullopt;
  const double radius_m = 0.5 * prior.diameter_m;
  // Of a ball's visible half the median depth is 0.7 radii before its middle; of a cap at its rim
  // less.
  const double depth_m = middle_value(depths) + 0.6 * radius_m;
  const SizeDepth by_size = depth_by_size(box, camera, prior);
  if (depth_m > by_size.whole_m + 3 * by_size.sigma_whole_m) return std::nullopt;
  return on_ray(box, camera, depth_m, 0.35 * radius_m, prior);
}

LocatedPoint place_by_size(const DetectedBox& box, const Camera& camera, const FruitPrior& prior) {
  const SizeDepth by_size = depth_by_size(box, camera, prior);
  return on_ray(box, camera, by_size.whole_m,
                std::hypot(by_size.sigma_whole_m, 0.4 * by_size.hidden * by_size.whole_m), prior);
}

PlacedBox placed(const DetectedBox& box, const LocatedPoint& in_camera,
                 const Pose& camera_from_world, double pose_sigma_m) {
  const Matrix3d turn = camera_from_world.rotation.toRotationMatrix().transpose();
  PlacedBox one{box.id, box.frame, {}};
  one.in_world.point_m = inverse(camera_from_world) * in_camera.point_m;
  one.in_world.covariance_m2 = turn * in_camera.covariance_m2 * turn.transpose() +
                               pose_sigma_m * pose_sigma_m * Matrix3d::Identity();
  return one;
}

PlacedBox in_row(PlacedBox box, double crown_sigma_m) {
  LocatedPoint& place = box.in_world;
  const double variance = place.covariance_m2(1, 1) + crown_sigma_m * crown_sigma_m;
  const double off_m = place.point_m.y();
  if (off_m * off_m > 9 * variance) return box;
  const Vector3d gain = place.covariance_m2.col(1) / variance;
  place.point_m -= gain * off_m;
  const Matrix3d less = gain * place.covariance_m2.row(1);
  place.covariance_m2 -= 0.5 * (less + less.transpose());
  return box;
}

Tracks join_boxes(std::span<const PlacedBox> boxes, const FruitTracksConfig& config) {
  if (boxes.size() > kMostBoxes)
    throw std::invalid_argument(std::to_string(boxes.size()) + " boxes; at most " +
                                std::to_string(kMostBoxes) + " are brought together");
  std::vector<Group> groups;
  for (const PlacedBox& box : boxes)
    groups.push_back({{box.frame}, {box.id}, box.in_world.point_m, box.in_world.covariance_m2, 0});
  std::sort(groups.begin(), groups.end(),
            [](const Group& a, const Group& b) { return a.boxes.front() < b.boxes.front(); });
  std::priority_queue<Pair> pairs;
  const auto add_pairs = [&](std::size_t i, std::size_t before) {
    if (pairs.size() > kMostPairs)
      throw std::invalid_argument("more than " + std::to_string(kMostPairs) +
                                  " pairs of boxes may be one fruit");
    for (std::size_t k = 0; k < before; ++k) {
      if (k == i || groups[k].version < 0) continue;
      const double lead = lead_of(groups[i], groups[k], config);
      const std::size_t a = std::min(i, k), b = std::max(i, k);
      if (lead > 0) pairs.push({lead, a, b, groups[a].version, groups[b].version});
    }
  };
  for (std::size_t i = 0; i < groups.size(); ++i) add_pairs(i, i);
  while (!pairs.empty()) {
    const Pair pair = pairs.top();
    pairs.pop();
    Group &a = groups[pair.a], &b = groups[pair.b];
    if (a.version != pair.version_a || b.version != pair.version_b) continue;
    const int version = a.version + 1;
    a = joined(a, b);
    a.version = version;
    b.version = -1;
    add_pairs(pair.a, groups.size());
  }
  Tracks tracks;
  for (const Group& group : groups) {
    if (group.version < 0) continue;
    tracks.push_back(
        {static_cast<int>(tracks.size()), group.boxes, group.mean_m, group.covariance_m2});
  }
  return tracks;
}

}  // namespace cousin
