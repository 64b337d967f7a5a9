#include "tests/perception/sfm/plant_views.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/types/rng.h"

namespace cousin {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Pose pose_on(CameraPath path, int i, int images) {
  const double a = 2 * std::numbers::pi * i / images, e = 0.5 + 0.4 * (i % 3);
  const Vector3d around(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
  const Vector3d middle(0, 0, 0.05);
  Pose pose;
  switch (path) {
    case CameraPath::around: {
      pose = look_at(0.4 * around, middle);
      const Eigen::AngleAxisd roll(0.6 * std::sin(5.0 * i), Vector3d::UnitZ());
      return Pose{Eigen::Quaterniond(roll), Vector3d::Zero()} * pose;
    }
    case CameraPath::upright:
      return look_at(0.4 * around, middle);
    case CameraPath::nadir_flat:
      pose.rotation = Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX());
      pose.translation_m = -(pose.rotation * Vector3d(0.04 * (i % 5), 0.04 * (i / 5), 0.4));
      return pose;
    case CameraPath::forward: {
      const Vector3d way = Vector3d(0.3, 0, 1).normalized();
      pose = look_at(middle + (0.5 - 0.2 * i / images) * way, middle);
      return pose;
    }
    case CameraPath::still:
      return look_at(Vector3d(0.25, 0, 0.3) + 0.003 * around, middle);
  }
  return pose;
}

bool is_inside(const Camera& lens, const Vector2d& pixel) {
  return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= lens.width_px - 1 &&
         pixel.y() <= lens.height_px - 1;
}

}  // namespace

Camera plant_lens() {
  Camera camera;
  camera.model = LensModel::opencv5;
  camera.width_px = 1280;
  camera.height_px = 720;
  camera.fx_px = camera.fy_px = 1080;
  camera.cx_px = 643;
  camera.cy_px = 356;
  camera.distortion = {0.05, -0.08, 4e-4, -3e-4, 0.02};
  return camera;
}

PlantViews plant_views(const PlantViewsConfig& config, std::uint64_t seed) {
  PlantViews views;
  views.lens = plant_lens();
  Rng rng = Rng(seed).fork("plant");
  Rng noise = Rng(seed).fork("noise");
  for (int p = 0; p < config.points; ++p) {
    Vector3d at(uniform(rng, -0.1, 0.1), uniform(rng, -0.1, 0.1), uniform(rng, 0, 0.15));
    if (config.path == CameraPath::nadir_flat) at.z() = 0;
    views.points_in_world_m.push_back(at);
  }
  views.model_from_world.scale = 7.5;
  views.model_from_world.rotation = Eigen::Quaterniond(0.3, -0.4, 0.8, 0.2).normalized();
  views.model_from_world.shift_m = {3, -1, 2};
  Rng focal = Rng(seed).fork("focal");
  std::vector<std::vector<SfmSighting>> sightings(views.points_in_world_m.size());
  for (int i = 0; i < config.images; ++i) {
    const Pose pose = pose_on(config.path, i, config.images);
    views.camera_from_world.push_back(pose);
    Camera own = views.lens;
    own.fx_px = own.fy_px *= 1 + config.focal_spread * normal(focal);
    views.lenses.push_back(own);
    const Lens lens(own);
    views.frames.push_back(10 + i);
    FrameCorners& corners = views.corners.emplace_back();
    corners.frame = 10 + i;
    corners.status = BoardStatus::ok;
    for (int row = 0; row < views.board.squares - 1; ++row) {
      for (int column = 0; column < views.board.squares - 1; ++column) {
        if (!corner_exists(views.board, column, row)) continue;
        const auto pixel = lens.project(pose * corner_in_world_m(views.board, column, row));
        const Vector2d off(normal(noise), normal(noise));
        if (!pixel || !is_inside(views.lens, *pixel)) continue;
        corners.corners.push_back({column, row, *pixel + config.corner_noise_px * off,
                                   isotropic_px2(std::max(config.corner_noise_px, 1e-4))});
      }
    }
    const bool is_lost = std::find(config.lost.begin(), config.lost.end(), i) != config.lost.end();
    if (!is_lost) {
      views.model.images.push_back(i);
      views.model.lenses.push_back(views.lens);
      views.model.camera_from_world.push_back(moved(pose, views.model_from_world));
    }
    for (std::size_t p = 0; p < sightings.size(); ++p) {
      const auto pixel = lens.project(pose * views.points_in_world_m[p]);
      const Vector2d off(normal(noise), normal(noise));
      if (is_lost || !pixel || !is_inside(views.lens, *pixel)) continue;
      sightings[p].push_back({i, *pixel + config.noise_px * off});
    }
  }
  for (std::size_t p = 0; p < sightings.size(); ++p) {
    if (sightings[p].size() < 2) continue;
    views.model.points.push_back(
        {views.model_from_world * views.points_in_world_m[p], {}, sightings[p]});
  }
  return views;
}

}  // namespace cousin
