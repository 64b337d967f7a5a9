#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "perception/ngp/ngp.h"

namespace cousin {
namespace {

/// Cosine to the optical axis: what lies farther off is beside a camera, not before it. Where all
/// look in parallel, the point nearest to their axes is among the cameras themselves.
constexpr double kLeastBefore = 0.1;

}  // namespace

ngp::NgpVolume ngp_volume(const NgpConfig& config, std::span<const NgpView> views) {
  ngp::NgpVolume volume;
  volume.cascades = config.cascades;
  if (!config.centre_m.empty()) {
    volume.centre_in_world_m = {config.centre_m[0], config.centre_m[1], config.centre_m[2]};
  } else {
    // Least squares of the distances to the optical axes; cameras in one row leave a line open,
    // where a weak pull to their mean decides.
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero(), mean = Eigen::Vector3d::Zero();
    for (const NgpView& view : views) {
      const Eigen::Vector3d axis =
          view.camera_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
      const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - axis * axis.transpose();
      const Eigen::Vector3d eye = centre_in_world_m(view.camera_from_world);
      normal += across;
      right += across * eye;
      mean += eye / static_cast<double>(views.size());
    }
    const double pull = 1e-6 * static_cast<double>(views.size());
    normal += pull * Eigen::Matrix3d::Identity();
    volume.centre_in_world_m = normal.ldlt().solve(right + pull * mean);
  }
  volume.side_m = config.side_m;
  if (config.side_m <= 0) {
    std::vector<double> distance_m;
    for (const NgpView& view : views) {
      const Eigen::Vector3d seen = view.camera_from_world * volume.centre_in_world_m;
      if (seen.z() > kLeastBefore * seen.norm()) distance_m.push_back(seen.norm());
    }
    if (distance_m.empty() || 2 * distance_m.size() < views.size()) return volume;
    const auto middle = distance_m.begin() + static_cast<std::ptrdiff_t>(distance_m.size() / 2);
    std::nth_element(distance_m.begin(), middle, distance_m.end());
    volume.side_m = std::isfinite(*middle) ? *middle : 0;
  }
  return volume;
}

}  // namespace cousin
