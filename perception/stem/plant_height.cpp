#include "perception/stem/plant_height.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "sim/config/limits.h"
#include "sim/imaging/rectification.h"
#include "sim/types/rng.h"

namespace cousin {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector2i;
using Eigen::Vector3d;

bool is_plant(const Rgb8& c, int least_green) { return 2 * c.g - c.r - c.b >= least_green; }

PlantHeight no_height(std::string why) {
  PlantHeight none;
  none.why_none = std::move(why);
  return none;
}

/// Pixels that hang together with `begin` among those that `is_part` accepts.
template <class Part>
std::vector<Vector2i> together(int width, int height, const std::vector<Vector2i>& begin,
                               const Part& is_part) {
  Image<std::uint8_t> seen(width, height);
  std::vector<Vector2i> found;
  for (const Vector2i& p : begin) {
    if (!seen.contains(p.x(), p.y()) || seen(p.x(), p.y()) != 0) continue;
    seen(p.x(), p.y()) = 1;
    found.push_back(p);
  }
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Vector2i here = found[i];
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const int x = here.x() + dx, y = here.y() + dy;
        if (!seen.contains(x, y) || seen(x, y) != 0 || !is_part(x, y)) continue;
        seen(x, y) = 1;
        found.emplace_back(x, y);
      }
    }
  }
  return found;
}

// ---- The paper's rule
// ----------------------------------------------------------------------------

/// The pixel of a mask that is farthest along a direction; of several the first.
std::optional<Vector2d> farthest(const Image<std::uint8_t>& mask, const Vector2d& from_px,
                                 const Vector2d& way) {
  std::optional<Vector2d> best;
  double most = 0;
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (mask(x, y) == 0) continue;
      const double along = way.dot(Vector2d(x, y) - from_px);
      if (along <= most) continue;
      most = along;
      best = Vector2d(x, y);
    }
  }
  return best;
}

/// The pixel of the right mask on the left one's epipolar line that is nearest to `like_px`.
std::optional<Vector2d> nearest_on_line(const EyePair& eyes, const Image<std::uint8_t>& mask,
                                        const Vector2d& left_px, const Vector2d& like_px) {
  std::optional<Vector2d> best;
  double least = 1e300;
  const int row = static_cast<int>(like_px.y());
  constexpr int kRows = 40;  // lines of a rig's two eyes are nearly level
  for (int y = std::max(0, row - kRows); y <= std::min(mask.height() - 1, row + kRows); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (mask(x, y) == 0) continue;
      const double away = (Vector2d(x, y) - like_px).squaredNorm();
      if (away >= least) continue;
      const auto off = epipolar_distance(eyes, left_px, Vector2d(x, y));
      if (!off || std::abs(off->in_right_px) > 1) continue;
      least = away;
      best = Vector2d(x, y);
    }
  }
  return best;
}

// ---- Ours
// ----------------------------------------------------------------------------------------

Vector3d point_of(const PairDepth& depth, int x, int y) {
  const double z = static_cast<double>(depth.depth_m(x, y));
  return {(x - depth.camera.cx_px) * z / depth.camera.fx_px,
          (y - depth.camera.cy_px) * z / depth.camera.fy_px, z};
}

/// n x = distance; n is unit and points to where it is up in the image.
struct GroundPlane {
  Vector3d normal = Vector3d::Zero();
  double distance_m = 0;
  int points = 0;
};

GroundPlane plane_through(const std::vector<Vector3d>& points_m) {
  Vector3d middle = Vector3d::Zero();
  for (const Vector3d& p : points_m) middle += p / static_cast<double>(points_m.size());
  Matrix3d spread = Matrix3d::Zero();
  for (const Vector3d& p : points_m) spread += (p - middle) * (p - middle).transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix3d> axes(spread);
  GroundPlane plane;
  plane.normal = axes.eigenvectors().col(0);
  if (plane.normal.y() > 0) plane.normal = -plane.normal;
  plane.distance_m = plane.normal.dot(middle);
  plane.points = static_cast<int>(points_m.size());
  return plane;
}

std::vector<Vector3d> near_plane(const std::vector<Vector3d>& points_m, const GroundPlane& plane,
                                 double within_m) {
  std::vector<Vector3d> near;
  for (const Vector3d& p : points_m) {
    if (std::abs(plane.normal.dot(p) - plane.distance_m) < within_m) near.push_back(p);
  }
  return near;
}

/// The plane that most of the points lie near.
GroundPlane find_ground(const std::vector<Vector3d>& points_m, const PlantHeightConfig& config) {
  GroundPlane best;
  if (static_cast<int>(points_m.size()) < config.least_ground) return best;
  Rng rng = Rng(1).fork("ground");  // the same for the same points
  constexpr int kDraws = 200;
  constexpr double kMostTilt = 0.7;  // cosine: the camera looks up or down by 45 degrees at most
  for (int draw = 0; draw < kDraws; ++draw) {
    std::vector<Vector3d> three;
    for (int k = 0; k < 3; ++k) three.push_back(points_m[uniform_index(rng, points_m.size())]);
    const Vector3d across = (three[1] - three[0]).cross(three[2] - three[0]);
    if (!(across.norm() > 1e-5)) continue;
    GroundPlane plane = plane_through(three);
    if (-plane.normal.y() < kMostTilt) continue;
    plane.points = static_cast<int>(near_plane(points_m, plane, config.soil_m).size());
    if (plane.points > best.points) best = plane;
  }
  for (int round = 0; round < 5 && best.points >= config.least_ground; ++round) {
    const auto near = near_plane(points_m, best, config.soil_m);
    if (static_cast<int>(near.size()) < config.least_ground) break;
    best = plane_through(near);
  }
  return best;
}

/// Points about the root that are not green.
std::vector<Vector3d> soil_about(const PairDepth& depth, const Vector3d& root_m,
                                 const PlantHeightConfig& config) {
  std::vector<Vector3d> soil;
  for (int y = 0; y < depth.depth_m.height(); y += 3) {
    for (int x = 0; x < depth.depth_m.width(); x += 3) {
      if (std::isnan(depth.depth_m(x, y)) || depth.green(x, y) != 0) continue;
      const Vector3d point = point_of(depth, x, y);
      if ((point - root_m).norm() < config.ground_m) soil.push_back(point);
    }
  }
  return soil;
}

/// A green pixel with a depth.
struct LeafPixel {
  Vector2i px;
  double up_m = 0;
  double depth_m = 0;
};

/// Green pixels within reach of the root, the highest first.
std::vector<LeafPixel> leaves_of(const PairDepth& depth, const Vector3d& root_m, const Vector3d& up,
                                 const PlantHeightConfig& config) {
  std::vector<LeafPixel> leaves;
  for (int y = 0; y < depth.depth_m.height(); ++y) {
    for (int x = 0; x < depth.depth_m.width(); ++x) {
      if (depth.green(x, y) == 0 || std::isnan(depth.depth_m(x, y))) continue;
      const Vector3d point = point_of(depth, x, y), apart = point - root_m;
      const double up_m = up.dot(apart);
      if (up_m < 0 || (apart - up_m * up).norm() > config.reach_m) continue;
      leaves.push_back({{x, y}, up_m, point.z()});
    }
  }
  std::sort(leaves.begin(), leaves.end(), [](const LeafPixel& a, const LeafPixel& b) {
    if (a.up_m != b.up_m) return a.up_m > b.up_m;
    return a.px.y() != b.px.y() ? a.px.y() < b.px.y() : a.px.x() < b.px.x();
  });
  return leaves;
}

/// The highest pixel that continues a top: green, without a depth, at the same depth.
Vector2i tip_above(const PairDepth& depth, const LeafPixel& top) {
  constexpr int kMost_px = 60;
  const auto part = [&](int x, int y) {
    return depth.green(x, y) != 0 && std::isnan(depth.depth_m(x, y)) && y < top.px.y() &&
           (Vector2i(x, y) - top.px).cwiseAbs().maxCoeff() <= kMost_px;
  };
  Vector2i best = top.px;
  for (const Vector2i& px : together(depth.green.width(), depth.green.height(), {top.px}, part)) {
    if (px.y() < best.y()) best = px;
  }
  return best;
}

}  // namespace

Fields fields(PlantHeightConfig& c) {
  return {
      {"least_green", &c.least_green, "2 g - r - b of a green pixel, codes", 1, 510},
      {"range_px", &c.range_px, "disparities that are matched", 16, 254},
      {"reach_m", &c.reach_m, "leaves are within this of the stem", 0.05, 10},
      {"ground_m", &c.ground_m, "soil about the root that its plane is laid through", 0.1, 20},
      {"soil_m", &c.soil_m, "soil farther from the plane is none", 0.001, 1},
      {"least_ground", &c.least_ground, "fewer points of soil are no ground", 3, 1000000},
      {"top_pixels", &c.top_pixels, "so many matched pixels may be higher than the top", 0, 10000},
      {"leaf_sigma_m", &c.leaf_sigma_m, "deviation of the top, beside calibration", 0, 1}};
}

void validate(const PlantHeightConfig& config) {
  PlantHeightConfig copy = config;
  check_limits(fields(copy), "height");
}

Image<std::uint8_t> green_about(const Image<Rgb8>& color, const Vector2d& place_px,
                                int least_green) {
  Image<std::uint8_t> mask(color.width(), color.height());
  constexpr int kAbout_px = 12;
  const Vector2i place = place_px.array().round().cast<int>();
  std::optional<Vector2i> begin;
  int least = kAbout_px * kAbout_px + 1;
  for (int dy = -kAbout_px; dy <= kAbout_px; ++dy) {
    for (int dx = -kAbout_px; dx <= kAbout_px; ++dx) {
      const Vector2i at = place + Vector2i(dx, dy);
      if (!color.contains(at.x(), at.y()) || dx * dx + dy * dy >= least) continue;
      if (!is_plant(color(at.x(), at.y()), least_green)) continue;
      least = dx * dx + dy * dy;
      begin = at;
    }
  }
  if (!begin) return mask;
  const auto part = [&](int x, int y) { return is_plant(color(x, y), least_green); };
  for (const Vector2i& px : together(color.width(), color.height(), {*begin}, part))
    mask(px.x(), px.y()) = 255;
  return mask;
}

PlantHeight height_by_green(const EyePair& eyes, const Image<Rgb8>& left, const Image<Rgb8>& right,
                            const EyeNode (&root)[2], const EyeNode (&node)[2],
                            const PlantHeightConfig& config) {
  const auto foot = middle_of_rays(eyes, root[0].pixel_px, root[1].pixel_px);
  if (!foot) return no_height("the root's rays do not meet");
  Vector2d tops[2];
  Image<std::uint8_t> masks[2];
  for (int eye = 0; eye < 2; ++eye) {
    masks[eye] = green_about(eye == 0 ? left : right, node[eye].pixel_px, config.least_green);
    const Vector2d way = (node[eye].pixel_px - root[eye].pixel_px).normalized();
    const auto top = farthest(masks[eye], root[eye].pixel_px, way);
    if (!top) return no_height("nothing green hangs together with the stem");
    tops[eye] = *top;
  }
  const auto match = nearest_on_line(eyes, masks[1], tops[0], tops[1]);
  if (!match) return no_height("the right image has nothing green on the top's line");
  const auto top = middle_of_rays(eyes, tops[0], *match);
  if (!top) return no_height("the top's rays do not meet");
  PlantHeight result;
  result.height_m = (*top - *foot).norm();
  result.top_m = *top;
  return result;
}

PairDepth pair_depth(const EyePair& eyes, const Image<Rgb8>& left, const Image<Rgb8>& right,
                     const PlantHeightConfig& config) {
  const Rectification rect = rectify(eyes.left.camera(), eyes.right.camera(), eyes.right_from_left);
  StereoMatchConfig match{.margin = 3, .range_px = config.range_px};
  PairDepth result;
  result.depth_m = passive_depth(left, right, rect, match).depth_m;
  result.camera = rect.camera;
  result.rectified_from_left = rect.rectified_from_left;
  result.green = Image<std::uint8_t>(rect.left_px.width(), rect.left_px.height());
  for (int y = 0; y < result.green.height(); ++y) {
    for (int x = 0; x < result.green.width(); ++x) {
      const Eigen::Vector2f at = rect.left_px(x, y);
      if (!at.allFinite()) continue;
      const int u = static_cast<int>(std::lround(at.x())),
                v = static_cast<int>(std::lround(at.y()));
      if (left.contains(u, v) && is_plant(left(u, v), config.least_green)) result.green(x, y) = 255;
    }
  }
  return result;
}

PlantHeight height_above_ground(const PairDepth& depth, const Vector3d& root_m, double root_sigma_m,
                                double scale_sigma, const PlantHeightConfig& config) {
  const Vector3d foot = depth.rectified_from_left * root_m;
  const GroundPlane ground = find_ground(soil_about(depth, foot, config), config);
  if (ground.points < config.least_ground) return no_height("no soil is matched about the root");
  const auto leaves = leaves_of(depth, foot, ground.normal, config);
  if (static_cast<int>(leaves.size()) <= config.top_pixels)
    return no_height("no leaf is matched above the root");
  const LeafPixel& top = leaves[static_cast<std::size_t>(config.top_pixels)];
  const Vector2i tip = tip_above(depth, top);
  const Vector3d way((tip.x() - depth.camera.cx_px) / depth.camera.fx_px,
                     (tip.y() - depth.camera.cy_px) / depth.camera.fy_px, 1);
  PlantHeight result;
  const Vector3d top_m = top.depth_m * way;
  result.height_m = ground.normal.dot(top_m - foot);
  result.top_m = depth.rectified_from_left.transpose() * top_m;
  result.up = depth.rectified_from_left.transpose() * ground.normal;
  result.sigma_m =
      std::sqrt(config.leaf_sigma_m * config.leaf_sigma_m + root_sigma_m * root_sigma_m +
                std::pow(scale_sigma * result.height_m, 2));
  return result;
}

}  // namespace cousin
