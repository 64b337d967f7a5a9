#include "benchmarks/loop/keypoint_noise.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "benchmarks/loop/box_noise.h"
#include "benchmarks/loop/truth_stages.h"
#include "sim/config/limits.h"
#include "sim/truth/specimens.h"
#include "sim/types/rng.h"

namespace cousin {
namespace {

using Eigen::Vector2d;

/// The first of the words that a name is of; -1 = none.
int word_of(const std::string& name, std::span<const std::string_view> words) {
  for (std::size_t w = 0; w < words.size(); ++w) {
    const std::string_view word = words[w];
    if (name == word || name.starts_with(std::string(word) + " ")) return static_cast<int>(w);
  }
  return -1;
}

struct ChosenPoints {
  int first = -1;           ///< place in the model of the point that stands first; -1: none
  std::vector<int> others;  ///< places
};
ChosenPoints chosen_points(const ObjectModel& model, std::span<const std::string_view> words) {
  ChosenPoints chosen;
  for (std::size_t k = 0; k < model.keypoints.size(); ++k) {
    const int word = words.empty() ? 1 : word_of(model.keypoints[k].name, words);
    if (word == 0 && chosen.first < 0) {
      chosen.first = static_cast<int>(k);
    } else if (word > 0) {
      chosen.others.push_back(static_cast<int>(k));
    }
  }
  return chosen;
}

/// Views of one object's keypoints by their place in its model.
std::map<int, const KeypointView*> views_of(const TruthImages& images, int id) {
  std::map<int, const KeypointView*> views;
  for (const KeypointView& view : images.keypoints) {
    if (view.instance == id) views[view.keypoint] = &view;
  }
  return views;
}

/// Leaves out points that are nearer to one before them than a detector tells apart.
void thin_out(const std::map<int, const KeypointView*>& views, double least_apart_px,
              std::vector<int>& points) {
  std::vector<int> kept;
  for (const int k : points) {
    const auto own = views.find(k);
    if (own == views.end()) continue;
    const bool is_one = std::any_of(kept.begin(), kept.end(), [&](int other) {
      return (own->second->pixel_px - views.at(other)->pixel_px).norm() < least_apart_px;
    });
    if (!is_one) kept.push_back(k);
  }
  points = std::move(kept);
}

/// One image's look at one point.
DetectedKeypoint detected(const KeypointView* view, const Camera& camera,
                          const KeypointNoiseConfig& c, Rng common, Rng own) {
  DetectedKeypoint point;
  const double missed = uniform(own), gross = uniform(own);
  if (!view || missed < c.missed) return point;
  if (view->state != PointState::visible && view->state != PointState::occluded) return point;
  const double sigma_px = gross < c.gross_share ? c.gross_sigma_px : c.sigma_px;
  const Vector2d apart(normal(own), normal(own)), together(normal(common), normal(common));
  const Vector2d at = view->pixel_px + sigma_px * apart + c.common_sigma_px * together;
  if (at.x() < -0.5 || at.y() < -0.5 || at.x() > camera.width_px - 0.5 ||
      at.y() > camera.height_px - 0.5)
    return point;
  point.pixel_px = at;
  point.status = view->state == PointState::visible ? KeypointStatus::seen : KeypointStatus::hidden;
  point.sigma_px = std::max(0.05, std::hypot(c.sigma_px, c.common_sigma_px));
  return point;
}

/// Points of nothing about those that are there.
void add_false_points(const KeypointNoiseConfig& c, const Camera& camera, Rng rng,
                      std::vector<DetectedKeypoint>& points) {
  Vector2d low = Vector2d::Constant(1e9), high = Vector2d::Constant(-1e9);
  for (const DetectedKeypoint& point : points) {
    if (point.status == KeypointStatus::missing) continue;
    low = low.cwiseMin(point.pixel_px);
    high = high.cwiseMax(point.pixel_px);
  }
  if (low.x() > high.x()) return;
  const double about_px = 60;
  const int count = static_cast<int>(poisson(rng, c.false_points));
  for (int i = 0; i < count; ++i) {
    DetectedKeypoint point;
    point.status = KeypointStatus::seen;
    point.sigma_px = std::max(0.05, std::hypot(c.sigma_px, c.common_sigma_px));
    point.pixel_px = {
        std::clamp(uniform(rng, low.x() - about_px, high.x() + about_px), 0.0,
                   camera.width_px - 1.0),
        std::clamp(uniform(rng, low.y() - about_px, high.y()), 0.0, camera.height_px - 1.0)};
    points.push_back(point);
  }
}

/// The same order for the same stream.
void shuffle_behind_first(std::vector<DetectedKeypoint>& points, Rng rng) {
  for (std::size_t i = points.size(); i > 2; --i)
    std::swap(points[i - 1], points[1 + uniform_index(rng, i - 1)]);
}

}  // namespace

Fields fields(KeypointNoiseConfig& c) {
  return {
      {"sigma_px", &c.sigma_px, "error of true keypoints, of each image on its own", 0, 1000},
      {"common_sigma_px", &c.common_sigma_px, "and in common to all images of a frame", 0, 1000},
      {"gross_share", &c.gross_share, "share of the points of an image that are far beside", 0, 1},
      {"gross_sigma_px", &c.gross_sigma_px, "error of those", 0, 10000},
      {"missed", &c.missed, "share of the points of an image that are not found", 0, 1},
      {"false_points", &c.false_points, "mean count of points of nothing about each object", 0,
       100},
      {"least_apart_px", &c.least_apart_px, "points nearer to each other are found as one", 0,
       1000}};
}

void validate(const KeypointNoiseConfig& config) {
  KeypointNoiseConfig copy = config;
  check_limits(fields(copy), "keypoints");
}

bool takes_keypoints(const PipelineRow& row) {
  return std::find(row.from_outside.begin(), row.from_outside.end(), "keypoints") !=
         row.from_outside.end();
}

Keypoints detected_keypoints(const SimulatedRun& run, std::span<const std::string_view> words,
                             const KeypointNoiseConfig& config, std::uint64_t seed) {
  validate(config);
  const Rng rng = Rng(seed).fork("keypoints");
  const auto objects = specimens_of(run.truth.scene);
  Keypoints result;
  for (const std::size_t sensor : sensors_with_truth(run.truth)) {
    const SensorTruth own = truth_of_sensor(run.truth, sensor);
    for (std::size_t f = 0; f < own.views.size(); ++f) {
      for (const Instance* object : objects) {
        const auto model = static_cast<std::size_t>(object->model);
        ChosenPoints chosen = chosen_points(run.truth.scene.models[model], words);
        thin_out(views_of(run.truth.images[f], object->id), config.least_apart_px, chosen.others);
        const auto views = views_of(own.images[f], object->id);
        const Rng of_frame = rng.fork(static_cast<std::uint64_t>(own.views[f].frame))
                                 .fork(static_cast<std::uint64_t>(object->id));
        const Rng of_image = of_frame.fork("image").fork(static_cast<std::uint64_t>(sensor));
        KeypointDetection entry;
        entry.frame = own.views[f].frame;
        entry.sensor = static_cast<int>(sensor);
        entry.id = static_cast<int>(result.size());
        const auto add = [&](int k) {
          const auto view = views.find(k);
          const auto place = static_cast<std::uint64_t>(k + 1);
          entry.points.push_back(
              detected(view == views.end() ? nullptr : view->second, own.views[f].camera, config,
                       of_frame.fork("common").fork(place), of_image.fork(place)));
        };
        if (!words.empty()) add(chosen.first);
        for (const int k : chosen.others) add(k);
        add_false_points(config, own.views[f].camera, of_image.fork("false"), entry.points);
        if (!words.empty()) shuffle_behind_first(entry.points, of_image.fork("order"));
        const bool is_there = std::any_of(
            entry.points.begin(), entry.points.end(),
            [](const DetectedKeypoint& p) { return p.status != KeypointStatus::missing; });
        if (is_there) result.push_back(std::move(entry));
      }
    }
  }
  return result;
}

Stages outside_stages(const SimulatedRun& run, const PipelineRow& row,
                      const KeypointNoiseConfig& config, std::uint64_t seed,
                      const BoxNoiseConfig& boxes) {
  Stages stages;
  for (const std::string_view stage : row.from_outside) {
    if (const auto put = truth_row(stage).put) put(stages, run, SeedBoard{});
  }
  if (takes_keypoints(row)) {
    stages.keypoints = [&run, &row, config, seed](const Capture&, const Estimate&) {
      return detected_keypoints(run, row.keypoints, config, seed);
    };
  }
  if (stages.boxes) {
    stages.boxes = [of_truth = stages.boxes, boxes, seed](const Capture& capture,
                                                          const Estimate& so_far) {
      return detected_boxes(of_truth(capture, so_far), boxes, seed);
    };
  }
  return stages;
}

}  // namespace cousin
