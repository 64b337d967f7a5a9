#include "benchmarks/loop/true_outline.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace cousin {
namespace {

constexpr double kReach_px = 3;

/// Where the line through an outline point along its normal leaves the object: its outermost
/// crossing within reach.
std::optional<double> outermost_crossing(const std::vector<TrueOutlineSegment>& contour,
                                         const OutlinePoint& point) {
  const Eigen::Vector2d origin = point.pixel_px.cast<double>(),
                        normal = point.normal.cast<double>();
  const Eigen::Vector2d along(-normal.y(), normal.x());
  std::optional<double> outermost;
  for (const TrueOutlineSegment& segment : contour) {
    const Eigen::Vector2d a = segment[0] - origin, b = segment[1] - origin;
    const double ta = along.dot(a), tb = along.dot(b);
    if (ta * tb > 0 || ta == tb) continue;
    const double share = ta / (ta - tb);
    const double across = (1 - share) * normal.dot(a) + share * normal.dot(b);
    if (std::abs(across) <= kReach_px && (!outermost || across > *outermost)) outermost = across;
  }
  return outermost;
}

}  // namespace

Pose middle_pose(const TrueView& view) {
  return interpolate(view.camera_from_world, view.camera_from_world_end, 0.5);
}

/// Pixel of a world point through a rolling shutter: the row it lands on fixes the pose it is seen
/// from. The motion during readout is a pixel or so, so the fixed point iteration contracts fast.
std::optional<Eigen::Vector2d> project_rolling(const TrueView& view,
                                               const Eigen::Vector3d& point_in_world_m) {
  std::optional<Eigen::Vector2d> pixel = project(view.camera, middle_pose(view) * point_in_world_m);
  for (int i = 0; i < 6 && pixel; ++i) {
    pixel = project(view.camera, pose_at_row(view, pixel->y()) * point_in_world_m);
  }
  return pixel;
}

std::vector<TrueOutlineSegment> true_contour(const Mesh& mesh, const TrueView& view) {
  const Eigen::Vector3d eye = centre_in_world_m(middle_pose(view));
  std::map<std::pair<std::uint32_t, std::uint32_t>, int>
      facing;  // edge -> sum of +1 front, -1 back
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices_m[t[0]];
    const Eigen::Vector3d normal = (mesh.vertices_m[t[1]] - a).cross(mesh.vertices_m[t[2]] - a);
    const int sign = normal.dot(eye - a) > 0 ? 1 : -1;
    for (int i = 0; i < 3; ++i) {
      facing[std::minmax(t[static_cast<std::size_t>(i)],
                         t[static_cast<std::size_t>((i + 1) % 3)])] += sign;
    }
  }
  std::vector<TrueOutlineSegment> segments;
  for (const auto& [edge, sum] : facing) {
    if (sum != 0) continue;
    const auto a = project_rolling(view, mesh.vertices_m[edge.first]);
    const auto b = project_rolling(view, mesh.vertices_m[edge.second]);
    if (a && b) segments.push_back({*a, *b});
  }
  return segments;
}

OutlineScore score_outlines(const Silhouettes& measured, const std::vector<TrueView>& views,
                            const std::vector<Mesh>& meshes_in_world,
                            const std::vector<int>& object_of) {
  std::map<int, const TrueView*> view_of;
  for (const TrueView& view : views) view_of[view.frame] = &view;
  OutlineScore score;
  double sum = 0, squares = 0, normalized = 0;
  for (const Silhouette& silhouette : measured) {
    const auto view = view_of.find(silhouette.frame);
    if (view == view_of.end() || silhouette.instance < 0) continue;
    const auto instance = static_cast<std::size_t>(silhouette.instance);
    if (instance >= object_of.size() || object_of[instance] < 0) continue;
    const auto contour =
        true_contour(meshes_in_world[static_cast<std::size_t>(object_of[instance])], *view->second);
    for (const OutlinePoint& point : silhouette.outline) {
      if (!point.on_object || !(point.sigma_px > 0)) continue;
      const auto crossing = outermost_crossing(contour, point);
      if (!crossing) continue;
      const double outside = -*crossing;
      ++score.points;
      sum += outside;
      squares += outside * outside;
      normalized += outside * outside / (static_cast<double>(point.sigma_px) * point.sigma_px);
    }
  }
  if (score.points == 0) return score;
  const auto n = static_cast<double>(score.points);
  score.bias_px = sum / n;
  score.rms_px = std::sqrt(squares / n);
  score.normalized_rms = std::sqrt(normalized / n);
  return score;
}

}  // namespace cousin
