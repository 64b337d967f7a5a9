#include "perception/cloud/fuse.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>

#include "sim/config/limits.h"

namespace cousin {
namespace {

constexpr float kAssumedSigmaM = 0.0001F;  ///< of depths that come without
constexpr float kLeastSigmaM =
    0.00002F;  ///< what all views share (poses, lens) does not average out
constexpr float kLeastFacing =
    0.2F;  ///< cosine between normal and ray below which a depth says little

/// From the world's origin, in voxels: nearer than that floats of a position tell a quarter of a
/// voxel apart, and a voxel's number fits in 32 bits.
constexpr double kFarthestVoxels = 1 << 21;

/// A view's depths as points of the world, cropped to where there are any.
struct DepthView {
  int frame = 0;
  int x0 = 0, y0 = 0;
  std::optional<Lens> lens;
  Pose camera_from_world;
  Eigen::Vector3f centre_m;
  Image<Eigen::Vector3f> point_m;  ///< in the world; NaN = none
  Image<Eigen::Vector3f> normal;   ///< unit, towards the camera; zero = none
  Image<float> sigma_m;            ///< along the ray
  bool valid(int x, int y) const {
    return point_m.contains(x, y) && std::isfinite(point_m(x, y).x());
  }
};

struct Box {
  int x0, y0, x1, y1;  ///< half open
};
std::optional<Box> box_of_depths(const Image<float>& depth_m) {
  Box box{depth_m.width(), depth_m.height(), 0, 0};
  for (int y = 0; y < depth_m.height(); ++y) {
    const auto row = depth_m.row(y);
    for (int x = 0; x < depth_m.width(); ++x) {
      if (!std::isfinite(row[static_cast<std::size_t>(x)])) continue;
      box = {std::min(box.x0, x), std::min(box.y0, y), std::max(box.x1, x + 1), y + 1};
    }
  }
  return box.x1 > 0 ? std::optional(box) : std::nullopt;
}

/// Normal of the plane through the points of a 5 x 5 window that lie on the same surface.
Eigen::Vector3f window_normal(const DepthView& view, int x, int y, float reach_m) {
  const Eigen::Vector3f centre = view.point_m(x, y);
  Eigen::Matrix3f moments = Eigen::Matrix3f::Zero();
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  int count = 0;
  for (int dy = -2; dy <= 2; ++dy) {
    for (int dx = -2; dx <= 2; ++dx) {
      if (!view.valid(x + dx, y + dy)) continue;
      const Eigen::Vector3f d = view.point_m(x + dx, y + dy) - centre;
      if (d.norm() > reach_m) continue;
      moments += d * d.transpose();
      sum += d;
      ++count;
    }
  }
  if (count < 6) return Eigen::Vector3f::Zero();
  moments -= sum * sum.transpose() / static_cast<float>(count);
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
  solver.computeDirect(moments * (1.0F / std::max(moments.trace(), 1e-30F)));
  const Eigen::Vector3f n = solver.eigenvectors().col(0);
  if (solver.eigenvalues()[1] < 0.02F || !n.allFinite()) return Eigen::Vector3f::Zero();  // a line
  return n.dot(view.centre_m - centre) < 0 ? Eigen::Vector3f(-n) : n;
}

/// @param farthest_m  of a point along each axis of the world
std::optional<DepthView> prepare(const FramePose& pose, const FrameDepth& depth, int frame,
                                 double farthest_m) {
  const std::optional<Box> box = box_of_depths(depth.depth_m);
  if (!box) return std::nullopt;
  DepthView view;
  view.frame = frame;
  view.x0 = box->x0;
  view.y0 = box->y0;
  view.lens.emplace(pose.camera);
  view.camera_from_world = pose.camera_from_world;
  const Pose world_from_camera = inverse(pose.camera_from_world);
  view.centre_m = world_from_camera.translation_m.cast<float>();
  const Eigen::Matrix3f to_world = world_from_camera.rotation.toRotationMatrix().cast<float>();
  const int w = box->x1 - box->x0, h = box->y1 - box->y0;
  const Eigen::Vector3f none = Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
  view.point_m = Image<Eigen::Vector3f>(w, h, none);
  view.normal = Image<Eigen::Vector3f>(w, h, Eigen::Vector3f::Zero());
  view.sigma_m = Image<float>(w, h, kAssumedSigmaM);
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      const float z = depth.depth_m(view.x0 + x, view.y0 + y);
      if (!std::isfinite(z) || z <= 0) continue;
      const auto ray = view.lens->unproject(Eigen::Vector2d(view.x0 + x, view.y0 + y));
      if (!ray || ray->z() <= 0) continue;
      const Eigen::Vector3d in_world_m = world_from_camera * (*ray * (z / ray->z())).eval();
      if (!(in_world_m.cwiseAbs().maxCoeff() <= farthest_m)) continue;
      view.point_m(x, y) = in_world_m.cast<float>();
      const float sigma = depth.sigma_m.empty() ? 0 : depth.sigma_m(view.x0 + x, view.y0 + y);
      if (sigma > 0) view.sigma_m(x, y) = sigma / static_cast<float>(ray->z());  // is of z
    }
  }
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      if (!view.valid(x, y)) continue;
      if (!depth.normal.empty()) {
        const Eigen::Vector3f own = to_world * depth.normal(view.x0 + x, view.y0 + y);
        const bool faces_camera = own.dot(view.centre_m - view.point_m(x, y)) > 0;
        if (faces_camera && own.allFinite()) {
          view.normal(x, y) = own.normalized();
          continue;
        }
      }
      const float pixel_m =
          depth.depth_m(view.x0 + x, view.y0 + y) / static_cast<float>(pose.camera.fx_px);
      view.normal(x, y) = window_normal(view, x, y, 6 * pixel_m);
    }
  }
  return view;
}

/// Where along the normal another view sees the surface through a point, and how well.
struct Sight {
  float offset_m = 0;
  float weight = 0;  ///< 0: does not see it
};
Sight sight(const DepthView& view, const Eigen::Vector3f& point_m, const Eigen::Vector3f& normal,
            float agreement_m) {
  const Eigen::Vector3f ray = (view.centre_m - point_m).normalized();
  const float facing = normal.dot(ray);
  if (facing < kLeastFacing) return {};
  const auto pixel = view.lens->project(view.camera_from_world * point_m.cast<double>().eval());
  if (!pixel) return {};
  const int x = static_cast<int>(std::lround(pixel->x())) - view.x0;
  const int y = static_cast<int>(std::lround(pixel->y())) - view.y0;
  if (!view.valid(x, y)) return {};
  if (!(view.normal(x, y).dot(normal) >= 0.6F)) return {};  // unknown, or another side of an edge
  const Eigen::Vector3f offset = view.point_m(x, y) - point_m;
  const float along = normal.dot(offset);
  if (std::abs(along) > agreement_m || (offset - along * normal).norm() > 2 * agreement_m + 0.002F)
    return {};
  const float sigma = view.sigma_m(x, y) * facing;
  return {along, 1 / (sigma * sigma)};
}

/// A fused point and the voxel it falls into.
struct VoxelPoint {
  std::array<std::int32_t, 3> voxel;
  std::int32_t view;
  std::int32_t pixel;
  Eigen::Vector3f position_m;
  Eigen::Vector3f normal;
  float sigma_m;
  Rgb8 color;
  bool operator<(const VoxelPoint& other) const {
    return std::tie(voxel, view, pixel) < std::tie(other.voxel, other.view, other.pixel);
  }
};

std::vector<VoxelPoint> fused_points(const DepthView& view, int own,
                                     const std::vector<DepthView>& views, const Image<Rgb8>& color,
                                     const GreenConfig& green, const FuseConfig& config) {
  std::vector<VoxelPoint> points;
  const float agreement = static_cast<float>(config.agreement_m);
  for (int y = 0; y < view.point_m.height(); ++y) {
    for (int x = 0; x < view.point_m.width(); ++x) {
      const Eigen::Vector3f normal = view.normal(x, y);
      if (!view.valid(x, y) || normal.isZero()) continue;
      constexpr Rgb8 kUnknown{128, 128, 128};
      const Rgb8 here = color.empty() ? kUnknown : color(view.x0 + x, view.y0 + y);
      if (is_green(here, green)) continue;
      const Eigen::Vector3f point = view.point_m(x, y);
      float sum = 0, weights = 0;
      int seen = 0;
      for (const DepthView& other : views) {
        const Sight s = sight(other, point, normal, agreement);
        sum += s.weight * s.offset_m;
        weights += s.weight;
        seen += s.weight > 0 ? 1 : 0;
      }
      if (seen < config.min_views || !(weights > 0)) continue;
      VoxelPoint fused;
      fused.position_m = point + normal * (sum / weights);
      for (std::size_t k = 0; k < 3; ++k) {
        fused.voxel[k] = static_cast<std::int32_t>(std::floor(
            fused.position_m[static_cast<Eigen::Index>(k)] / static_cast<float>(config.voxel_m)));
      }
      fused.view = own;
      fused.pixel = y * view.point_m.width() + x;
      fused.normal = normal;
      fused.sigma_m = std::hypot(std::sqrt(1 / weights), kLeastSigmaM);
      fused.color = here;
      points.push_back(fused);
    }
  }
  return points;
}

CloudPoint averaged(const VoxelPoint* begin, const VoxelPoint* end) {
  Eigen::Vector3f position = Eigen::Vector3f::Zero(), normal = Eigen::Vector3f::Zero();
  Eigen::Vector3f color = Eigen::Vector3f::Zero();
  float weights = 0, least = begin->sigma_m;
  for (const VoxelPoint* p = begin; p != end; ++p) {
    const float weight = 1 / (p->sigma_m * p->sigma_m);
    position += weight * (p->position_m - begin->position_m);
    normal += weight * p->normal;
    color += weight * Eigen::Vector3f(p->color.r, p->color.g, p->color.b);
    weights += weight;
    least = std::min(least, p->sigma_m);
  }
  const Eigen::Vector3f code = color / weights;
  CloudPoint point;
  point.position_m = begin->position_m + position / weights;
  point.normal = normal.norm() > 0 ? Eigen::Vector3f(normal.normalized()) : Eigen::Vector3f::Zero();
  point.color = {static_cast<std::uint8_t>(code.x() + 0.5F),
                 static_cast<std::uint8_t>(code.y() + 0.5F),
                 static_cast<std::uint8_t>(code.z() + 0.5F)};
  point.sigma_m = least;  // points of one voxel share their views, so their errors do not average
  return point;
}

Cloud voxel_means(std::vector<VoxelPoint> points) {
  tbb::parallel_sort(points.begin(),
                     points.end());  // a total order: the same result on any number of threads
  Cloud cloud;
  for (std::size_t begin = 0; begin < points.size();) {
    std::size_t end = begin + 1;
    while (end < points.size() && points[end].voxel == points[begin].voxel) ++end;
    cloud.push_back(averaged(&points[begin], points.data() + end));
    begin = end;
  }
  return cloud;
}

void check_sizes(const Capture& capture, const Poses& poses, const Depths& depths) {
  if (poses.size() != capture.frames.size() || depths.size() != capture.frames.size()) {
    throw std::invalid_argument("fusion: " + std::to_string(poses.size()) + " poses and " +
                                std::to_string(depths.size()) + " depth images for " +
                                std::to_string(capture.frames.size()) + " frames");
  }
  for (std::size_t i = 0; i < depths.size(); ++i) {
    const Image<float>& depth = depths[i].depth_m;
    if (depth.empty() || poses[i].status != PoseStatus::ok) continue;
    const bool has_color = !capture.frames[i].sensors.empty() &&
                           (capture.frames[i].sensors[0].color.empty() ||
                            (capture.frames[i].sensors[0].color.width() == depth.width() &&
                             capture.frames[i].sensors[0].color.height() == depth.height()));
    const Image<float>& sigma = depths[i].sigma_m;
    const bool sigma_fits =
        sigma.empty() || (sigma.width() == depth.width() && sigma.height() == depth.height());
    const Image<Eigen::Vector3f>& normal = depths[i].normal;
    const bool normal_fits =
        normal.empty() || (normal.width() == depth.width() && normal.height() == depth.height());
    if (!has_color || !sigma_fits || !normal_fits) {
      throw std::invalid_argument("fusion: the depth image of frame " +
                                  std::to_string(depths[i].frame) +
                                  " differs in size from its colour, sigma or normal image");
    }
  }
}

void check_near(const Poses& poses, double farthest_m) {
  for (const FramePose& pose : poses) {
    if (pose.status != PoseStatus::ok) continue;
    const double far_m = centre_in_world_m(pose.camera_from_world).cwiseAbs().maxCoeff();
    if (far_m <= farthest_m) continue;
    throw std::invalid_argument(
        "fusion: the camera of frame " + std::to_string(pose.frame) + " is " +
        std::to_string(far_m) + " m from the world's origin along an axis; clouds hold positions " +
        "as float, which with this voxel_m say enough to " + std::to_string(farthest_m) +
        " m: move the origin, or take larger voxels");
  }
}

}  // namespace

Fields fields(FuseConfig& c) {
  return {
      {"voxel_m", &c.voxel_m, "side of the averaging voxels", 1e-6, 0.1},
      {"agreement_m", &c.agreement_m, "distance along the normal at which views agree", 1e-6, 0.1},
      {"min_views", &c.min_views, "views that see the surface, the own included", 1, 1000}};
}

void validate(const FuseConfig& config) {
  FuseConfig copy = config;
  check_limits(fields(copy), "fuse");
}

Cloud fuse_depths(const Capture& capture, const Poses& poses, const Depths& depths,
                  const GreenConfig& green, const FuseConfig& config) {
  validate(green);
  validate(config);
  check_sizes(capture, poses, depths);
  const double farthest_m = kFarthestVoxels * config.voxel_m;
  check_near(poses, farthest_m);
  std::vector<std::optional<DepthView>> prepared(depths.size());
  tbb::parallel_for(std::size_t{0}, depths.size(), [&](std::size_t i) {
    if (poses[i].status == PoseStatus::ok && !depths[i].depth_m.empty()) {
      prepared[i] = prepare(poses[i], depths[i], static_cast<int>(i), farthest_m);
    }
  });
  std::vector<DepthView> views;
  for (std::optional<DepthView>& view : prepared) {
    if (view) views.push_back(std::move(*view));
  }
  std::vector<std::vector<VoxelPoint>> parts(views.size());
  tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t i) {
    const Image<Rgb8>& color =
        capture.frames[static_cast<std::size_t>(views[i].frame)].sensors[0].color;
    parts[i] = fused_points(views[i], static_cast<int>(i), views, color, green, config);
  });
  std::vector<VoxelPoint> all;
  for (std::vector<VoxelPoint>& part : parts) {
    all.insert(all.end(), part.begin(), part.end());
    part = {};
  }
  return voxel_means(std::move(all));
}

}  // namespace cousin
