#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "sim/truth/scene.h"
#include "sim/truth/truth_images.h"

namespace cousin {

/// An instance in another place than the scene's.
struct MovedInstance {
  std::size_t place = 0;  ///< into Scene::instances
  Pose world_from_object;
};

/// How much of one instance is seen, for searches that ask often: visible over what would be seen
/// of it alone, by the truth pass, as TruthImages::visibility has it.
class VisibleShare {
 public:
  /// @param target  place in scene.instances
  /// @param reach_m  what is farther from the target's middle is left out
  /// @param movable  places of instances that questions may move; they are small and few
  /// @throws as RayScene.
  VisibleShare(const Scene& scene, std::size_t target, double reach_m,
               std::vector<std::size_t> movable = {});
  ~VisibleShare();
  VisibleShare(VisibleShare&&) noexcept;

  Eigen::Vector3d centre_in_world_m() const;  ///< of the target's bounding ball
  double radius_m() const;

  /// With the movable instances where the scene has them. NaN if the view shows nothing of the
  /// target.
  double seen(const TrueView& view) const;
  /// With some of them moved. @throws std::invalid_argument for one that is not movable.
  double seen(const TrueView& view, const std::vector<MovedInstance>& moved) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The part of a camera's image about a ball, without lens distortion, `side_px` on its longer
/// side: where the ball fills the image, the image's own part of it.
/// @throws std::invalid_argument if the camera is within the ball or no pixel may show it.
TrueView view_about(const Camera& camera, const Pose& camera_from_world,
                    const Eigen::Vector3d& centre_in_world_m, double radius_m, int side_px);

}  // namespace cousin
