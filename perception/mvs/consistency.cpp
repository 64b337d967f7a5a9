#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "perception/mvs/reference_depth.h"
#include "sim/types/no_value.h"

namespace cousin {
namespace {

/// Other references asked about each depth: the nearest in angle.
constexpr int kAsked = 10;

/// One reference's depths as seen from another.
struct Witness {
  const MvsView* view;
  float reference_focal_px;
  const ReferenceDepth* depth;
  Eigen::Matrix3f rotation;  ///< witness_from_reference
  Eigen::Vector3f translation_m;

  /// Whether the witness sees the surface there too: its depth at the nearest pixel of the point's
  /// projection, carried along its plane to the exact place, agrees within the tolerances.
  bool agrees(const Eigen::Vector3f& point_m, float most_px, float most_relative) const {
    const Eigen::Vector3f p = rotation * point_m + translation_m;
    if (!(p.z() > 0)) return false;
    const Eigen::Vector2f ray = p.head<2>() / p.z();
    const Eigen::Vector2f pinhole = view->focal_px.cwiseProduct(ray) + view->principal_px;
    const Eigen::Vector2f pixel = view->distorted_from_pinhole(pinhole.x(), pinhole.y());
    if (!std::isfinite(pixel.x())) return false;
    const int x = static_cast<int>(std::lround(pixel.x())) - view->rect.x0;
    const int y = static_cast<int>(std::lround(pixel.y())) - view->rect.y0;
    if (!depth->inverse_depth.contains(x, y)) return false;
    const float there = depth->inverse_depth(x, y) +
                        depth->slope_x(x, y) * (ray.x() - view->ray_x(x, y)) +
                        depth->slope_y(x, y) * (ray.y() - view->ray_y(x, y));
    const float difference = 1 / there - p.z();  // NaN where the witness has no depth
    // What the difference amounts to in the reference's image: the part of it across the
    // reference's ray.
    const Eigen::Vector3f moved =
        rotation.transpose() * Eigen::Vector3f(ray.x(), ray.y(), 1) * difference;
    const float across = (moved - point_m * (moved.dot(point_m) / point_m.squaredNorm())).norm();
    return std::abs(difference) <= most_relative * p.z() &&
           across * reference_focal_px <= most_px * point_m.z();
  }
};

}  // namespace

std::vector<Image<float>> consistent_depths_m(const std::vector<MvsView>& views,
                                              const std::vector<int>& references,
                                              const std::vector<ReferenceDepth>& depths,
                                              const MvsConfig& config) {
  std::vector<Image<float>> result(references.size());
  tbb::parallel_for(std::size_t{0}, references.size(), [&](std::size_t i) {
    const MvsView& view = views[static_cast<std::size_t>(references[i])];
    const ReferenceDepth& mine = depths[i];
    std::vector<std::size_t> order;
    for (std::size_t j = 0; j < references.size(); ++j) {
      if (j != i) order.push_back(j);
    }
    const auto far = [&](std::size_t j) {
      return (views[static_cast<std::size_t>(references[j])].centre_in_world_m -
              view.centre_in_world_m)
          .squaredNorm();
    };
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return far(a) < far(b); });
    order.resize(std::min<std::size_t>(order.size(), kAsked));
    std::vector<Witness> witnesses;
    for (const std::size_t j : order) {
      const MvsView& other = views[static_cast<std::size_t>(references[j])];
      const Pose relative = other.camera_from_world * inverse(view.camera_from_world);
      witnesses.push_back({&other, view.focal_px.x(), &depths[j],
                           relative.rotation.toRotationMatrix().cast<float>(),
                           relative.translation_m.cast<float>()});
    }
    result[i] = Image<float>(view.rect.width, view.rect.height, kNone);
    for (int y = 0; y < view.rect.height; ++y) {
      for (int x = 0; x < view.rect.width; ++x) {
        const float inverse_depth = mine.inverse_depth(x, y);
        if (!std::isfinite(inverse_depth)) continue;
        const Eigen::Vector3f point_m =
            Eigen::Vector3f(view.ray_x(x, y), view.ray_y(x, y), 1) / inverse_depth;
        int agreeing = 0;
        for (const Witness& witness : witnesses) {
          agreeing += witness.agrees(point_m, static_cast<float>(config.consistency_px),
                                     static_cast<float>(config.consistency_depth))
                          ? 1
                          : 0;
          if (agreeing >= config.consistent_views) break;
        }
        if (agreeing >= config.consistent_views) result[i](x, y) = 1 / inverse_depth;
      }
    }
  });
  return result;
}

}  // namespace cousin
