#include "perception/splats/splat_camera.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace cousin {

SplatCamera splat_camera(const Camera& camera, const Pose& camera_from_world,
                         const Eigen::Vector3d& origin_in_world_m, double near_m) {
  validate(camera);
  if (camera.model != LensModel::pinhole) {
    throw std::invalid_argument("splats need a pinhole camera, not " +
                                std::string(to_string(camera.model)));
  }
  const Eigen::Matrix3d rotation = camera_from_world.rotation.toRotationMatrix();
  const Eigen::Vector3d from_origin = camera_from_world * origin_in_world_m;
  if (!rotation.allFinite() || !from_origin.allFinite()) {
    throw std::invalid_argument("pose of a splat camera is not finite");
  }
  if (!(near_m > 0) || !std::isfinite(near_m)) {
    throw std::invalid_argument("near depth " + std::to_string(near_m) + " m is not above 0");
  }
  SplatCamera c;
  const Eigen::Vector3d centre = -(rotation.transpose() * from_origin);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) c.rotation[3 * i + j] = static_cast<float>(rotation(i, j));
    c.translation[i] = static_cast<float>(from_origin[i]);
    c.centre[i] = static_cast<float>(centre[i]);
  }
  c.fx = static_cast<float>(camera.fx_px);
  c.fy = static_cast<float>(camera.fy_px);
  c.cx = static_cast<float>(camera.cx_px);
  c.cy = static_cast<float>(camera.cy_px);
  const double half_u = 0.5 * camera.width_px / camera.fx_px;
  const double half_v = 0.5 * camera.height_px / camera.fy_px;
  const double u0 = (-0.5 - camera.cx_px) / camera.fx_px;
  const double v0 = (-0.5 - camera.cy_px) / camera.fy_px;
  c.u_min = static_cast<float>(u0 - 0.3 * half_u);
  c.u_max = static_cast<float>(u0 + 2.3 * half_u);
  c.v_min = static_cast<float>(v0 - 0.3 * half_v);
  c.v_max = static_cast<float>(v0 + 2.3 * half_v);
  c.near_m = static_cast<float>(near_m);
  c.width_px = camera.width_px;
  c.height_px = camera.height_px;
  return c;
}

double near_depth_m(const SplatPlanes& planes, const Pose& camera_from_world,
                    const Eigen::Vector3d& origin_in_world_m, double share) {
  const Eigen::Matrix3d rotation = camera_from_world.rotation.toRotationMatrix();
  const Eigen::Vector3f axis = rotation.row(2).transpose().cast<float>();
  const auto offset = static_cast<float>((camera_from_world * origin_in_world_m).z());
  std::vector<float> depths;
  depths.reserve(static_cast<std::size_t>(planes.size()));
  for (int i = 0; i < planes.size(); ++i) {
    const float z = axis.x() * planes.at(0, i) + axis.y() * planes.at(1, i) +
                    axis.z() * planes.at(2, i) + offset;
    if (z > 0 && std::isfinite(z)) depths.push_back(z);
  }
  if (depths.empty()) return 1e-6 * share;
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return std::max(1e-30, share * static_cast<double>(*middle));
}

}  // namespace cousin
