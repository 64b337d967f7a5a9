#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "sim/render/path_sampler.h"
#include "sim/render/path_scene.h"
#include "sim/render/path_skips.h"

namespace cousin {

/// One path on its way.
struct PathState {
  Eigen::Vector3f origin_m;
  Eigen::Vector3f direction;
  Eigen::Vector3f throughput;
  float density = 0;           ///< of the direction, per steradian, where it was drawn; 0 = of a
                               ///< camera, or infinite: no light was drawn there
  float time = 0;              ///< of the ray, as Embree takes it
  std::uint32_t index = 0;     ///< of the sample in the batch
  Sheet from;                  ///< the surface it left; a camera's ray none
  float touch_m = 0;           ///< what it meets nearer than this touches that surface
  int touches = 0;             ///< surfaces in a row that touched the one before
  bool was_scattered = false;  ///< at a surface that is not clear, since the camera
  PathSkips skips;
};

/// Follows a batch of camera rays to their end, bounce by bounce, so that rays of a kind travel
/// together. One for each task. Private to sim/render.
class PathBatch {
 public:
  PathBatch(const PathTracer::Impl& scene, const PathConfig& config)
      : scene_(scene),
        max_bounces_(config.max_bounces),
        straight_sun_(scene.has_water && !config.refracts_sun) {}

  void clear();
  /// @param direction  unit, or zero: a sample without a ray.
  void add(const Eigen::Vector3f& origin_m, const Eigen::Vector3f& direction,
           const PathSampler& sampler, float time);
  void run();

  std::size_t size() const { return samplers_.size(); }
  /// Radiance of sample `i`, in the order they were added.
  const Eigen::Vector3f& radiance(std::size_t i) const { return radiance_[i]; }
  std::uint64_t rays() const { return rays_; }

  /// Dimensions that the camera uses; bounce k starts after them.
  static constexpr std::uint32_t kCameraPairs = 3;

 private:
  struct Shadow {
    Eigen::Vector3f origin_m, direction;
    float far_m = 0;
    float time = 0;
    Eigen::Vector3f light;
    std::uint32_t index = 0;
    PathSkips skips;
    bool passes_water = false;
  };
  struct RayHit {
    unsigned int instance = 0, geometry = 0, triangle = 0;  ///< as Embree names them
    float u = 0, v = 0, far_m = 0;
  };

  void trace(bool is_coherent);
  void trace_packets();
  void trace_singles();
  void add_light_behind(const PathState& path, bool missed, float far_m);
  void shade(int bounce);
  /// Between two sheets that touch, light goes to and fro; in a pile of many it would for ever.
  static constexpr int kMostTouches = 8;
  /// A surface that a path has met.
  struct Meeting {
    PathHit hit;
    Sheet own;
    Sheet before;     ///< the surface the path left, if it touches this one
    int touches = 0;  ///< in a row; of more than kMostTouches the rest of the pile is left behind
    PathStart leave(const Eigen::Vector3f& direction) const {
      if (touches > kMostTouches) return plain_start(hit, direction);
      return start_from(hit, own, before, direction);
    }
  };
  /// Both at a surface; where light walks below it, of the coat here and of the base elsewhere.
  void scatter(const PathState& path, const Meeting& met, int bounce, std::uint32_t pair);
  void add_lights(const PathState& path, const Meeting& met, std::uint32_t pair, bool is_first);
  void bounce(const PathState& path, const Meeting& met, int bounce, std::uint32_t pair);
  void go_on(const PathState& path, const Meeting& met, const PathBsdf::Draw& draw, float roulette);
  void trace_shadows(bool is_coherent);
  void trace_shadow_packets();
  void trace_shadow_singles();
  void add_unblocked(const Shadow& shadow, bool met_water);
  Eigen::Vector3f through_water(const Shadow& shadow);

  const PathTracer::Impl& scene_;
  int max_bounces_;
  bool straight_sun_;  ///< suns and beams shine straight through water
  std::vector<PathState> paths_, next_;
  std::vector<RayHit> hits_;
  std::vector<Shadow> shadows_, candidates_;
  std::vector<PathSampler> samplers_;
  std::vector<Eigen::Vector3f> radiance_;
  std::uint64_t rays_ = 0;
};

}  // namespace cousin
