#include "benchmarks/loop/box_truth.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <tuple>

#include "sim/truth/specimens.h"

namespace cousin {
namespace {

constexpr double kLeastOverlap = 0.5;

double overlap(const TrueBox& a, const DetectedBox& b) {
  const Eigen::Vector2d size =
      (a.high_px.cwiseMin(b.high_px) - a.low_px.cwiseMax(b.low_px)).cwiseMax(0.0);
  const double both = size.prod();
  return both / ((a.high_px - a.low_px).prod() + (b.high_px - b.low_px).prod() - both);
}

/// Its surface at the pixel nearest to the middle of its box.
Eigen::Vector3d middle_point_m(const TrueBox& box, int id, const TrueView& view,
                               const TruthImages& images) {
  const Eigen::Vector2d middle = 0.5 * (box.low_px + box.high_px);
  // As a program indexes an image: of an even number of pixels the one before the middle.
  const Eigen::Vector2d wanted = middle.array().floor();
  double nearest = std::numeric_limits<double>::infinity();
  Eigen::Vector2d pixel = wanted;
  for (int y = static_cast<int>(box.low_px.y() + 1); y < box.high_px.y(); ++y) {
    for (int x = static_cast<int>(box.low_px.x() + 1); x < box.high_px.x(); ++x) {
      const Eigen::Vector2d at(x, y);
      const double away = (at - wanted).squaredNorm();
      if (images.instance(x, y) != id || away >= nearest) continue;
      nearest = away;
      pixel = at;
    }
  }
  const auto depth_m =
      static_cast<double>(images.depth_m(static_cast<int>(pixel.x()), static_cast<int>(pixel.y())));
  const auto ray = unproject(view.camera, pixel);
  if (!ray) throw std::runtime_error("a true lens has no ray at a pixel that shows a specimen");
  return *ray * (depth_m / ray->z());
}

void set_places(const Scene& scene, const Instance& object, const TrueView& view, TrueBox& box) {
  const double row = 0.5 * (box.low_px.y() + box.high_px.y());
  const double time_s = time_at_row(view, row);
  const Pose camera_from_world = pose_at_row(view, row);
  const Pose camera_from_object = camera_from_world * world_from_object(object, time_s);
  box.centre_m = camera_from_object.translation_m;
  box.axis = camera_from_object.rotation * Eigen::Vector3d::UnitZ();
  const std::vector<Keypoint>& keypoints =
      scene.models[static_cast<std::size_t>(object.model)].keypoints;
  for (std::size_t k = 0; k < keypoints.size(); ++k) {
    const bool is_calyx = keypoints[k].name == "calyx_centre";
    if (!is_calyx && keypoints[k].name != "cut_point") continue;
    const Instance& carrier = scene.instances[carrier_of(scene, object, k)];
    (is_calyx ? box.calyx_m : box.cut_m) =
        camera_from_world * (world_from_object(carrier, time_s) * keypoints[k].in_object_m);
  }
}

}  // namespace

std::vector<TrueBox> true_boxes_of(const SceneTruth& truth, std::size_t sensor) {
  const SensorTruth own = truth_of_sensor(truth, sensor);
  const auto objects = specimens_of(truth.scene);
  std::map<int, int> place_of;
  for (std::size_t k = 0; k < objects.size(); ++k) place_of[objects[k]->id] = static_cast<int>(k);
  std::vector<TrueBox> result;
  for (std::size_t f = 0; f < own.views.size(); ++f) {
    if (f >= own.images.size() || own.images[f].instance.empty() || own.images[f].depth_m.empty())
      throw std::invalid_argument(
          "boxes need true depth and instances of every view: render with --truth "
          "depth,instance");
    const TruthImages& images = own.images[f];
    std::map<int, TrueBox> boxes;
    for (int y = 0; y < images.instance.height(); ++y) {
      for (int x = 0; x < images.instance.width(); ++x) {
        const auto place = place_of.find(images.instance(x, y));
        if (place == place_of.end()) continue;
        const Eigen::Vector2d low(x - 0.5, y - 0.5), high(x + 0.5, y + 0.5);
        const auto [found, is_new] = boxes.try_emplace(place->second);
        TrueBox& box = found->second;
        if (is_new) {
          box.sensor = sensor;
          box.view = f;
          box.frame = own.views[f].frame;
          box.specimen = place->second;
          box.low_px = low;
          box.high_px = high;
        }
        box.low_px = box.low_px.cwiseMin(low);
        box.high_px = box.high_px.cwiseMax(high);
        ++box.pixels;
      }
    }
    for (auto& [specimen, box] : boxes) {
      const Instance& object = *objects[static_cast<std::size_t>(specimen)];
      box.point_m = middle_point_m(box, object.id, own.views[f], images);
      set_places(truth.scene, object, own.views[f], box);
      result.push_back(box);
    }
  }
  return result;
}

std::vector<int> match_boxes(const std::vector<TrueBox>& truth, const Boxes& measured) {
  std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;
  for (std::size_t t = 0; t < truth.size(); ++t) {
    for (std::size_t m = 0; m < measured.size(); ++m) {
      if (measured[m].frame != truth[t].frame ||
          measured[m].sensor != static_cast<int>(truth[t].sensor))
        continue;
      const double share = overlap(truth[t], measured[m]);
      if (share >= kLeastOverlap) pairs.emplace_back(-share, t, m);
    }
  }
  std::sort(pairs.begin(), pairs.end());
  std::vector<int> result(truth.size(), -1);
  std::vector<bool> taken(measured.size(), false);
  for (const auto& [share, t, m] : pairs) {
    if (result[t] >= 0 || taken[m]) continue;
    result[t] = static_cast<int>(m);
    taken[m] = true;
  }
  return result;
}

}  // namespace cousin
