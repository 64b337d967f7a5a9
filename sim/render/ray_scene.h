#pragma once

#include <memory>

#include "sim/truth/scene.h"

namespace cousin {

struct TimeSpan {
  double begin_s = 0;
  double end_s = 0;
};

/// A scene's geometry ready for rays (Embree). Immutable after construction; safe to share between
/// threads.
///
/// A model that several instances share is kept once and placed by transforms of one level; one
/// with a single instance is laid out in the world. Over a span of time, as of an exposure with its
/// readout, instances that move in it are placed by a transform in each of up to 129 even steps of
/// at most one degree, between which rotation and translation are interpolated linearly; a row's or
/// a sample's ray then carries its own time. What stands still costs the same as at an instant.
///
/// Up to 2^20 unique triangles each keeps 64 bytes for exact hits; beyond, exact hits are made at
/// need from vertices in double, and Embree builds compact trees.
/// Triangles without area are never hit. Of coincident surfaces the same one wins on every run and
/// number of threads; which one is not said.
class RayScene {
 public:
  /// @throws std::invalid_argument if the scene is not valid, a coordinate is beyond 1e12 m of the
  /// scene's centre or a span ends before it begins; std::runtime_error if Embree fails.
  explicit RayScene(const Scene& scene, double time_s = 0);
  RayScene(const Scene& scene, const TimeSpan& span_s);
  ~RayScene();
  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;

  struct Impl;
  const Impl& impl() const { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace cousin
