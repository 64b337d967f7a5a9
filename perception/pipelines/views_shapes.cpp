#include "perception/pipelines/views_shapes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "perception/splats/depth_mesh.h"

namespace cousin {
namespace {

/// Calls `use` with about a hundredth of the pixels of posed views that have depth, and their z.
template <class Use>
void for_some_depths(const Poses& poses, const Depths& depths, const Use& use) {
  constexpr int kEvery = 97;  // pixels
  for (std::size_t v = 0; v < depths.size(); ++v) {
    const Image<float>& depth_m = depths[v].depth_m;
    if (poses[v].status != PoseStatus::ok || depth_m.empty()) continue;
    for (std::size_t i = 0; i < depth_m.size(); i += kEvery) {
      const auto z = static_cast<double>(depth_m.data()[i]);
      const auto width = static_cast<std::size_t>(depth_m.width());
      if (std::isfinite(z) && z > 0)
        use(poses[v], static_cast<int>(i % width), static_cast<int>(i / width), z);
    }
  }
}

/// The median of the pixels' spans in the world over all depths; NaN where there is none.
double median_span_m(const Poses& poses, const Depths& depths) {
  std::vector<double> spans_m;
  for_some_depths(poses, depths, [&](const FramePose& pose, int, int, double z) {
    spans_m.push_back(z / pose.camera.fx_px);
  });
  if (spans_m.empty()) return kNaN;
  const auto middle = spans_m.begin() + static_cast<std::ptrdiff_t>(spans_m.size() / 2);
  std::nth_element(spans_m.begin(), middle, spans_m.end());
  return *middle;
}

/// A frame whose origin is amid the cameras, in which a pixel spans 0.1 mm at the median depth:
/// fusion and meshing know how large things are that lie on a bench.
class DepthBench {
 public:
  static constexpr double kSpan_m = 1e-4;
  /// @param span_m  of a pixel in the world
  DepthBench(const Poses& poses, double span_m) : scale_(kSpan_m / span_m) {
    int count = 0;
    for (const FramePose& pose : poses) {
      if (pose.status != PoseStatus::ok) continue;
      centre_m_ += centre_in_world_m(pose.camera_from_world);
      ++count;
    }
    centre_m_ /= std::max(1, count);
  }
  Poses of(Poses poses) const {
    for (FramePose& pose : poses) {
      Pose& camera = pose.camera_from_world;
      camera.translation_m = scale_ * (camera.translation_m + camera.rotation * centre_m_);
    }
    return poses;
  }
  Image<float> of(Image<float> depth_m) const {
    for (float& z : depth_m) z *= static_cast<float>(scale_);
    return depth_m;
  }
  Eigen::Vector3d of(const Eigen::Vector3d& world_m) const {
    return scale_ * (world_m - centre_m_);
  }
  Eigen::Vector3d in_world(const Eigen::Vector3d& point_m) const {
    return point_m / scale_ + centre_m_;
  }

 private:
  Eigen::Vector3d centre_m_ = Eigen::Vector3d::Zero();
  double scale_;
};

/// Where the middle 98 % of points along each axis lie, and a tenth more on either side.
Eigen::AlignedBox3d middle_of(const std::vector<Eigen::Vector3d>& points_m) {
  Eigen::AlignedBox3d box(Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero());
  for (int k = 0; k < 3; ++k) {
    std::vector<double> at;
    for (const Eigen::Vector3d& point : points_m) at.push_back(point[k]);
    std::sort(at.begin(), at.end());
    const std::size_t cut = at.size() / 100;
    const double low = at[cut], high = at[at.size() - 1 - cut];
    box.min()[k] = low - 0.1 * (high - low);
    box.max()[k] = high + 0.1 * (high - low);
  }
  return box;
}

/// The cloud's points; where no cloud was wanted, some of the depths'.
std::vector<Eigen::Vector3d> points_of(const ViewsPipelineConfig& config, const Estimate& so_far) {
  std::vector<Eigen::Vector3d> points_m;
  for (const CloudPoint& point : so_far.cloud) points_m.push_back(point.position_m.cast<double>());
  if (config.cloud_views > 0 || !points_m.empty()) return points_m;
  for_some_depths(so_far.poses, so_far.depths, [&](const FramePose& pose, int x, int y, double z) {
    const auto ray = Lens(pose.camera).unproject({x, y});
    if (!ray || !(ray->z() > 0)) return;
    const Eigen::Vector3d in_camera_m = *ray * (z / ray->z());
    points_m.push_back(inverse(pose.camera_from_world) * in_camera_m);
  });
  return points_m;
}

}  // namespace

Cloud views_cloud(const ViewsPipelineConfig& config, const Capture& capture,
                  const Estimate& so_far) {
  const double span_m = median_span_m(so_far.poses, so_far.depths);
  if (!std::isfinite(span_m)) return {};
  std::vector<std::size_t> with_depth;
  for (std::size_t v = 0; v < so_far.depths.size(); ++v) {
    if (so_far.poses[v].status == PoseStatus::ok && !so_far.depths[v].depth_m.empty())
      with_depth.push_back(v);
  }
  const std::size_t count =
      std::min(with_depth.size(), static_cast<std::size_t>(config.cloud_views));
  const DepthBench bench(so_far.poses, span_m);
  Depths some;
  for (const FrameDepth& depth : so_far.depths) some.push_back({depth.frame, {}, {}});
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t v = with_depth[i * with_depth.size() / count];
    some[v].depth_m = bench.of(so_far.depths[v].depth_m);
  }
  FuseConfig fuse;
  fuse.voxel_m = config.voxel_px * DepthBench::kSpan_m;
  fuse.agreement_m = config.agreement_px * DepthBench::kSpan_m;
  const GreenConfig nothing_is_green{.hue_low = 1, .hue_high = 0};
  Cloud cloud = fuse_depths(capture, bench.of(so_far.poses), some, nothing_is_green, fuse);
  for (CloudPoint& point : cloud) {
    point.position_m = bench.in_world(point.position_m.cast<double>()).cast<float>();
    point.sigma_m = 0;  // depths of Gaussians have none
  }
  return cloud;
}

Surfaces views_mesh(const ViewsPipelineConfig& config, const Estimate& so_far) {
  constexpr std::size_t kLeastPoints = 100;
  Surface surface;
  std::vector<Eigen::Vector3d> points_m = points_of(config, so_far);
  const double span_m = median_span_m(so_far.poses, so_far.depths);
  if (points_m.size() >= kLeastPoints && std::isfinite(span_m)) {
    const DepthBench bench(so_far.poses, span_m);
    for (Eigen::Vector3d& point : points_m) point = bench.of(point);
    const Eigen::AlignedBox3d box = middle_of(points_m);
    DepthMeshConfig mesh;
    mesh.low_m = box.min();
    mesh.high_m = box.max();
    mesh.step_m = box.sizes().maxCoeff() / config.mesh_cells;
    mesh.truncation_m = 4 * mesh.step_m;
    mesh.no_depth = DepthMeshConfig::NoDepth::unknown;
    Depths depths = so_far.depths;
    for (FrameDepth& depth : depths) depth.depth_m = bench.of(std::move(depth.depth_m));
    if ((box.sizes().array() > 0).all())
      surface.mesh = mesh_of_depths(bench.of(so_far.poses), depths, mesh);
    for (Eigen::Vector3d& vertex : surface.mesh.vertices_m) vertex = bench.in_world(vertex);
  }
  surface.status = surface.mesh.triangles.empty() ? SurfaceStatus::empty : SurfaceStatus::ok;
  return {surface};
}

}  // namespace cousin
