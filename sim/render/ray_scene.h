#pragma once

#include <memory>

#include "sim/truth/scene.h"

namespace cousin {

/// A scene's geometry ready for rays (Embree). Immutable after construction; safe to share between
/// threads. Built at one instant: a moving scene is built anew for each time.
class RayScene {
 public:
  /// @throws std::invalid_argument if the scene is not valid; std::runtime_error if Embree fails.
  explicit RayScene(const Scene& scene, double time_s = 0);
  ~RayScene();
  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;

  struct Impl;
  const Impl& impl() const { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace cousin
