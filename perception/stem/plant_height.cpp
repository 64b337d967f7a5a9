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

/// Excess green over brightness: shade makes leaves dark, not grey.
bool is_plant(const Rgb8& c, double least_green) {
  return 2 * c.g - c.r - c.b > least_green * (c.r + c.g + c.b);
}

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
  constexpr int kRows = 40;       // lines of a rig's two eyes are nearly level
  constexpr double kLine_px = 4;  // as the paper's test of nodes
  for (int y = std::max(0, row - kRows); y <= std::min(mask.height() - 1, row + kRows); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (mask(x, y) == 0) continue;
      const double away = (Vector2d(x, y) - like_px).squaredNorm();
      if (away >= least) continue;
      const auto off = epipolar_distance(eyes, left_px, Vector2d(x, y));
      if (!off || std::abs(off->in_right_px) > kLine_px) continue;
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

bool is_near(const Vector3d& point_m, const GroundPlane& plane, double within_m) {
  return std::abs(plane.normal.dot(point_m) - plane.distance_m) < within_m;
}

std::vector<Vector3d> near_plane(const std::vector<Vector3d>& points_m, const GroundPlane& plane,
                                 double within_m) {
  std::vector<Vector3d> near;
  for (const Vector3d& p : points_m) {
    if (is_near(p, plane, within_m)) near.push_back(p);
  }
  return near;
}

/// The plane that most of the points lie near.
GroundPlane find_ground(const std::vector<Vector3d>& points_m, const PlantHeightConfig& config) {
  GroundPlane best;
  if (static_cast<int>(points_m.size()) < config.least_ground) return best;
  Rng rng = Rng(1).fork("ground");  // the same for the same points
  constexpr int kDraws = 200;
  constexpr double kLeastUpright =
      0.7;  // cosine: the camera looks up or down by 45 degrees at most
  for (int draw = 0; draw < kDraws; ++draw) {
    std::vector<Vector3d> three;
    for (int k = 0; k < 3; ++k) three.push_back(points_m[uniform_index(rng, points_m.size())]);
    const Vector3d across = (three[1] - three[0]).cross(three[2] - three[0]);
    if (!(across.norm() > 1e-5)) continue;
    GroundPlane plane = plane_through(three);
    if (-plane.normal.y() < kLeastUpright) continue;
    plane.points =
        static_cast<int>(std::count_if(points_m.begin(), points_m.end(), [&](const Vector3d& p) {
          return is_near(p, plane, config.soil_m);
        }));
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

/// Whether a pixel has a leaf's or a stem's depth.
bool has_leaf(const PairDepth& depth, int x, int y) {
  return depth.green(x, y) != 0 && !std::isnan(depth.depth_m(x, y));
}

Vector3d point_at(const PairDepth& depth, const Vector2i& px, double depth_m) {
  return {(px.x() - depth.camera.cx_px) * depth_m / depth.camera.fx_px,
          (px.y() - depth.camera.cy_px) * depth_m / depth.camera.fy_px, depth_m};
}

/// Green pixels with a depth within reach of the root; the highest first.
std::vector<LeafPixel> leaves_of(const PairDepth& depth, const Vector3d& root_m, const Vector3d& up,
                                 const PlantHeightConfig& config) {
  std::vector<LeafPixel> leaves;
  for (int y = 0; y < depth.depth_m.height(); ++y) {
    for (int x = 0; x < depth.depth_m.width(); ++x) {
      if (!has_leaf(depth, x, y)) continue;
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

/// The middle depth of the green pixels about one that are as deep; NaN where too few are: a match
/// that stands alone is wrong.
double supported_depth_m(const PairDepth& depth, const LeafPixel& leaf,
                         const PlantHeightConfig& config) {
  constexpr int kAbout_px = 10;
  std::vector<double> depths;
  for (int dy = -kAbout_px; dy <= kAbout_px; ++dy) {
    for (int dx = -kAbout_px; dx <= kAbout_px; ++dx) {
      const int x = leaf.px.x() + dx, y = leaf.px.y() + dy;
      if (!depth.green.contains(x, y) || !has_leaf(depth, x, y)) continue;
      const auto z = static_cast<double>(depth.depth_m(x, y));
      if (std::abs(z - leaf.depth_m) < config.step_m) depths.push_back(z);
    }
  }
  if (static_cast<int>(depths.size()) < config.top_pixels) return kNaN;
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return *middle;
}

/// The highest of the leaves by the depth of what is about it.
std::optional<LeafPixel> top_of(const PairDepth& depth, const std::vector<LeafPixel>& leaves,
                                const Vector3d& root_m, const Vector3d& up,
                                const PlantHeightConfig& config) {
  constexpr int kMost = 400;  // of those that have support: lower ones are not the top
  std::optional<LeafPixel> top;
  int supported = 0;
  for (const LeafPixel& leaf : leaves) {
    if (supported == kMost || (top && leaf.up_m + config.step_m < top->up_m)) break;
    const double depth_m = supported_depth_m(depth, leaf, config);
    if (std::isnan(depth_m)) continue;
    ++supported;
    const double up_m = up.dot(point_at(depth, leaf.px, depth_m) - root_m);
    if (!top || up_m > top->up_m) top = LeafPixel{leaf.px, up_m, depth_m};
  }
  return top;
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
  return {{"least_green", &c.least_green, "2 g - r - b of a green pixel over r + g + b", 0, 2},
          {"range_px", &c.range_px, "disparities that are matched", 16, 254},
          {"reach_m", &c.reach_m, "leaves are within this of the stem", 0.05, 10},
          {"step_m", &c.step_m, "depth changes by less between pixels of one plant", 0.001, 1},
          {"ground_m", &c.ground_m, "soil about the root that its plane is laid through", 0.1, 20},
          {"soil_m", &c.soil_m, "soil farther from the plane is none", 0.001, 1},
          {"least_ground", &c.least_ground, "fewer points of soil are no ground", 3, 1000000},
          {"top_pixels", &c.top_pixels, "green pixels about the top that are as deep, at least", 0,
           10000},
          {"leaf_sigma_m", &c.leaf_sigma_m, "deviation of the top, beside calibration", 0, 1}};
}

void validate(const PlantHeightConfig& config) {
  PlantHeightConfig copy = config;
  check_limits(fields(copy), "height");
}

Image<std::uint8_t> green_along(const Image<Rgb8>& color, const Vector2d& root_px,
                                const Vector2d& node_px, double least_green) {
  Image<std::uint8_t> mask(color.width(), color.height());
  constexpr int kAside_px = 6;
  constexpr double kLeast_px = 80;
  const Vector2d way = (node_px - root_px).normalized(), aside(-way.y(), way.x());
  const double length_px = std::max(3 * (node_px - root_px).norm(), kLeast_px);
  const auto part = [&](int x, int y) { return is_plant(color(x, y), least_green); };
  std::vector<Vector2i> begin;
  for (double along = 0; along <= length_px; along += 1) {
    for (int off = -kAside_px; off <= kAside_px; ++off) {
      const Vector2d at = root_px + along * way + off * aside;
      const Vector2i px = at.array().round().cast<int>();
      if (color.contains(px.x(), px.y()) && part(px.x(), px.y())) begin.push_back(px);
    }
  }
  for (const Vector2i& px : together(color.width(), color.height(), begin, part))
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
    masks[eye] = green_along(eye == 0 ? left : right, root[eye].pixel_px, node[eye].pixel_px,
                             config.least_green);
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
  return result;
}

PairDepth pair_depth(const EyePair& eyes, const Image<Rgb8>& left, const Image<Rgb8>& right,
                     const PlantHeightConfig& config) {
  const Rectification rect = rectify(eyes.left.camera(), eyes.right.camera(), eyes.right_from_left);
  // Leaves have little texture: what is smooth about edges counts, and single errors are found by
  // what is about them.
  const StereoMatchConfig match{.margin = 2,
                                .block_px = 7,
                                .range_px = config.range_px,
                                .uniqueness = 0.03,
                                .texture = 0.005};
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

std::optional<Vector3d> ground_up(const PairDepth& depth, const Vector3d& root_m,
                                  const PlantHeightConfig& config) {
  const Vector3d foot = depth.rectified_from_left * root_m;
  const GroundPlane ground = find_ground(soil_about(depth, foot, config), config);
  if (ground.points < config.least_ground) return std::nullopt;
  return depth.rectified_from_left.transpose() * ground.normal;
}

PlantHeight height_above_ground(const PairDepth& depth, const Vector3d& root_m, double root_sigma_m,
                                double scale_sigma, const PlantHeightConfig& config) {
  const Vector3d foot = depth.rectified_from_left * root_m;
  const GroundPlane ground = find_ground(soil_about(depth, foot, config), config);
  if (ground.points < config.least_ground) return no_height("no soil is matched about the root");
  const auto leaves = leaves_of(depth, foot, ground.normal, config);
  const auto top = top_of(depth, leaves, foot, ground.normal, config);
  if (!top) return no_height("no leaf is matched above the root");
  const auto tip_px = tip_above(depth, *top);
  PlantHeight result;
  // If the image cuts the plant, its top is outside, and no height follows.
  constexpr int kBorder_px = 4;
  if (top->px.y() < kBorder_px || tip_px.y() < kBorder_px)
    return no_height("the plant leaves the image");
  const Vector3d top_m = point_at(depth, tip_px, top->depth_m);
  result.height_m = ground.normal.dot(top_m - foot);
  result.sigma_m =
      std::sqrt(config.leaf_sigma_m * config.leaf_sigma_m + root_sigma_m * root_sigma_m +
                std::pow(scale_sigma * result.height_m, 2));
  return result;
}

}  // namespace cousin
