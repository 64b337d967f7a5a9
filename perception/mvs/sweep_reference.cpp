#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "perception/mvs/bilinear.h"
#include "perception/mvs/reference_depth.h"
#include "sim/types/no_value.h"

namespace cousin {
namespace {

constexpr int kMostPlanes = 512;
constexpr int kMostCounted = 16;
/// What planes that face the camera must gain over level ones: where a window shows one edge only,
/// both fit, and what is photographed lies level more often.
constexpr float kFamilyMargin = 0.03F;

/// Planes normal . X = offset of the world, at even steps of inverse distance from the camera.
struct PlaneFamily {
  Eigen::Vector3d normal;
  double nearest = 0;  ///< signed distances from the camera centre, same sign
  double farthest = 0;
  int count = 0;
  double distance(int i) const {  ///< of plane i
    const double t = count > 1 ? static_cast<double>(i) / (count - 1) : 0.0;
    return 1.0 / ((1 - t) / nearest + t / farthest);
  }
};

/// Range of the volume along `normal`, and as many planes as the neighbours' disparities ask for.
PlaneFamily make_family(const Eigen::Vector3d& normal, const MvsView& view,
                        const std::vector<const MvsView*>& neighbours, const SweepVolume& volume,
                        double step_px) {
  PlaneFamily family{normal, std::numeric_limits<double>::infinity(),
                     -std::numeric_limits<double>::infinity(), 0};
  for (const Eigen::Vector3d& corner : corners_in_world_m(volume)) {
    const double distance = normal.dot(corner - view.centre_in_world_m);
    family.nearest = std::min(family.nearest, distance);
    family.farthest = std::max(family.farthest, distance);
  }
  if (-family.nearest > family.farthest) {  // the normal points at the camera
    family.normal = -normal;
    std::swap(family.nearest, family.farthest);
    family.nearest *= -1;
    family.farthest *= -1;
  }
  family.nearest = std::max(family.nearest, 0.02 * family.farthest);
  double disparity = 0;
  for (const Eigen::Vector3d& corner : corners_in_world_m(volume)) {
    const Eigen::Vector3d ray = corner - view.centre_in_world_m;
    const double along = family.normal.dot(ray);
    if (along <= 0) continue;
    for (const MvsView* neighbour : neighbours) {
      const auto pixel = [&](double distance) {
        const Eigen::Vector3d p = neighbour->camera_from_world *
                                  (view.centre_in_world_m + ray * (distance / along)).eval();
        const double depth = std::max(p.z(), 0.1 * neighbour->distance_m);
        return Eigen::Vector2d(neighbour->focal_px.x() * p.x() / depth,
                               neighbour->focal_px.y() * p.y() / depth);
      };
      disparity = std::max(disparity, (pixel(family.nearest) - pixel(family.farthest)).norm());
    }
  }
  family.count = static_cast<int>(
      std::clamp(std::ceil(disparity / step_px) + 1, 3.0, static_cast<double>(kMostPlanes)));
  return family;
}

/// Buffers of one sweep, all the size of the reference's rectangle.
struct SweepBuffers {
  explicit SweepBuffers(int width, int height, int counted_)
      : counted(counted_),
        ray_slope(width, height),
        mean(width, height),
        spread(width, height),
        warped(width, height),
        best_score(width, height, -1),
        best_plane(width, height, -1),
        before(width, height, -1),
        after(width, height, -1),
        previous(width, height, -1) {
    for (int i = 0; i < counted; ++i) top.emplace_back(width, height, -1.0F);
  }
  int counted;
  Image<float> ray_slope;  ///< of a family: depth = its distance over this; NaN: the ray misses
  Image<float> mean;       ///< of the reference's window
  Image<float> spread;     ///< 1 / sqrt(variance + noise) of the reference's window
  Image<float> warped;     ///< the neighbour seen through the plane
  std::vector<Image<float>> top;  ///< best scores at this plane, in descending order
  Image<float> best_score, best_plane, before, after, previous;
};

/// Sums of 2 radius + 1 neighbours along a row. `column_sums` begins `kMostRadius` zeros before the
/// row and ends as many after it: windows are clipped at the border.
constexpr int kMostRadius = 10;
template <int kRadius>
void sum_row_of(const float* column_sums, int width, float* sums) {
  for (int x = 0; x < width; ++x) {
    float sum = 0;
    for (int k = -kRadius; k <= kRadius; ++k) sum += column_sums[x + k + kMostRadius];
    sums[x] = sum;
  }
}
using SumRow = void (*)(const float*, int, float*);
template <int... kRadii>
SumRow choose_sum_row(int radius, std::integer_sequence<int, kRadii...>) {
  constexpr std::array<SumRow, sizeof...(kRadii)> kTable = {&sum_row_of<kRadii>...};
  return kTable.at(static_cast<std::size_t>(radius));
}
SumRow sum_row_for(int radius) {
  return choose_sum_row(radius, std::make_integer_sequence<int, kMostRadius + 1>());
}

/// Running sums down the columns; made anew now and then, so that rounding does not pile up.
class ColumnSums {
 public:
  ColumnSums(int width, int height, int radius)
      : height_(height),
        radius_(radius),
        sums_(static_cast<std::size_t>(width + 2 * kMostRadius)) {}
  /// Moves to row y, visited in order; add(row, sign, sums) adds a row's terms to the sums.
  template <class Add>
  void move_to(int y, const Add& add) {
    constexpr int kRenew = 16;
    if (y % kRenew == 0) {
      std::fill(sums_.begin(), sums_.end(), 0.0F);
      for (int k = std::max(0, y - radius_); k <= std::min(height_ - 1, y + radius_); ++k) {
        add(k, 1.0F, sums_.data() + kMostRadius);
      }
      return;
    }
    if (y + radius_ < height_) add(y + radius_, 1.0F, sums_.data() + kMostRadius);
    if (y - radius_ - 1 >= 0) add(y - radius_ - 1, -1.0F, sums_.data() + kMostRadius);
  }
  const float* padded() const { return sums_.data(); }

 private:
  int height_, radius_;
  std::vector<float> sums_;
};

void reference_moments(const Image<float>& luma, int radius, SweepBuffers& buffers) {
  const int w = luma.width(), h = luma.height();
  const float n = static_cast<float>((2 * radius + 1) * (2 * radius + 1));
  const SumRow sum_row = sum_row_for(radius);
  ColumnSums c1(w, h, radius), c2(w, h, radius);
  std::vector<float> s1(static_cast<std::size_t>(w)), s2(s1);
  for (int y = 0; y < h; ++y) {
    c1.move_to(y, [&](int k, float sign, float* sums) {
      const float* row = luma.row(k).data();
      for (int x = 0; x < w; ++x) sums[x] += sign * row[x];
    });
    c2.move_to(y, [&](int k, float sign, float* sums) {
      const float* row = luma.row(k).data();
      for (int x = 0; x < w; ++x) sums[x] += sign * (row[x] * row[x]);
    });
    sum_row(c1.padded(), w, s1.data());
    sum_row(c2.padded(), w, s2.data());
    for (int x = 0; x < w; ++x) {
      const auto i = static_cast<std::size_t>(x);
      const float mean = s1[i] / n;
      buffers.mean(x, y) = mean;
      buffers.spread(x, y) =
          1.0F / std::sqrt(std::max(0.0F, s2[i] / n - mean * mean) + kNoiseVariance);
    }
  }
}

/// The neighbour's luma where each reference pixel's ray meets the plane; outside mid grey: no
/// texture, no score.
void warp_row(const MvsView& view, const MvsView& neighbour, const Warp& warp,
              float inverse_distance, const float* slope, int y, float* out) {
  constexpr int kBlock = 64;
  const Eigen::Matrix3f& a = warp.from_ray;
  const Eigen::Vector3f& b = warp.from_inverse_depth;
  const float a00 = a(0, 0), a01 = a(0, 1), a02 = a(0, 2), b0 = b(0);
  const float a10 = a(1, 0), a11 = a(1, 1), a12 = a(1, 2), b1 = b(1);
  const float a20 = a(2, 0), a21 = a(2, 1), a22 = a(2, 2), b2 = b(2);
  BilinearLookUp<kBlock> look_up;
  for (int start = 0; start < view.ray_x.width(); start += kBlock) {
    const float* rx = view.ray_x.row(y).data() + start;
    const float* ry = view.ray_y.row(y).data() + start;
    const float* s = slope + start;
    const auto count = static_cast<std::size_t>(std::min(kBlock, view.ray_x.width() - start));
    for (std::size_t x = 0; x < count; ++x) {
      const float inverse_depth = s[x] * inverse_distance;
      const float z = a20 * rx[x] + a21 * ry[x] + a22 + b2 * inverse_depth;
      const float in_front = z > 0 ? 1.0F / z : kNone;
      look_up.x[x] = (a00 * rx[x] + a01 * ry[x] + a02 + b0 * inverse_depth) * in_front;
      look_up.y[x] = (a10 * rx[x] + a11 * ry[x] + a12 + b1 * inverse_depth) * in_front;
    }
    look_up.run<false>(neighbour.pinhole_luma, count);
    std::copy_n(look_up.value.begin(), count, out + start);
  }
}

/// Correlation of every window with the warped neighbour, inserted into the pixel's best scores.
void score_plane(const Image<float>& luma, int radius, SweepBuffers& buffers) {
  const int w = luma.width(), h = luma.height();
  const float weight = 1.0F / static_cast<float>((2 * radius + 1) * (2 * radius + 1));
  const SumRow sum_row = sum_row_for(radius);
  ColumnSums c1(w, h, radius), c2(w, h, radius), c3(w, h, radius);
  std::vector<float> s1(static_cast<std::size_t>(w)), s2(s1), s3(s1), scores(s1);
  for (int y = 0; y < h; ++y) {
    c1.move_to(y, [&](int k, float sign, float* sums) {
      const float* theirs = buffers.warped.row(k).data();
      for (int x = 0; x < w; ++x) sums[x] += sign * theirs[x];
    });
    c2.move_to(y, [&](int k, float sign, float* sums) {
      const float* theirs = buffers.warped.row(k).data();
      for (int x = 0; x < w; ++x) sums[x] += sign * (theirs[x] * theirs[x]);
    });
    c3.move_to(y, [&](int k, float sign, float* sums) {
      const float* mine = luma.row(k).data();
      const float* theirs = buffers.warped.row(k).data();
      for (int x = 0; x < w; ++x) sums[x] += sign * (mine[x] * theirs[x]);
    });
    sum_row(c1.padded(), w, s1.data());
    sum_row(c2.padded(), w, s2.data());
    sum_row(c3.padded(), w, s3.data());
    const float* mean = buffers.mean.row(y).data();
    const float* spread = buffers.spread.row(y).data();
    float* score = scores.data();
    for (int x = 0; x < w; ++x) {
      const float m = s1[static_cast<std::size_t>(x)] * weight;
      const float variance = s2[static_cast<std::size_t>(x)] * weight - m * m;
      const float covariance = s3[static_cast<std::size_t>(x)] * weight - m * mean[x];
      const float floor = variance > 0 ? variance : 0.0F;
      score[x] = covariance * spread[x] / std::sqrt(floor + kNoiseVariance);
    }
    for (Image<float>& best : buffers.top) {
      float* kept = best.row(y).data();
      for (int x = 0; x < w; ++x) {
        const float high = kept[x] > score[x] ? kept[x] : score[x];
        const float low = kept[x] > score[x] ? score[x] : kept[x];
        kept[x] = high;
        score[x] = low;
      }
    }
  }
}

/// Keeps the best plane of each pixel and the scores beside it.
void keep_best(int plane, SweepBuffers& buffers) {
  const std::size_t size = buffers.best_score.size();
  const float share = 1.0F / static_cast<float>(buffers.counted);
  const float here = static_cast<float>(plane);
  Image<float>& mean = buffers.warped;  // not needed any more for this plane
  std::fill(mean.begin(), mean.end(), 0.0F);
  for (Image<float>& top : buffers.top) {
    float* out = mean.data();
    float* in = top.data();
    for (std::size_t i = 0; i < size; ++i) {
      out[i] += in[i] * share;
      in[i] = -1;
    }
  }
  const float* score = mean.data();
  float* best = buffers.best_score.data();
  float* best_plane = buffers.best_plane.data();
  float* before = buffers.before.data();
  float* after = buffers.after.data();
  float* previous = buffers.previous.data();
  for (std::size_t i = 0; i < size; ++i) {
    const bool better = score[i] > best[i];
    const bool just_past = best_plane[i] == here - 1;
    before[i] = better ? previous[i] : before[i];
    after[i] = better ? -1.0F : (just_past ? score[i] : after[i]);
    best_plane[i] = better ? here : best_plane[i];
    best[i] = better ? score[i] : best[i];
    previous[i] = score[i];
  }
}

/// Offset of a parabola's top from the middle of three equidistant values, within half a step.
float parabola_offset(float before, float middle, float after) {
  const float bend = before - 2 * middle + after;
  if (!(bend < -1e-6F)) return 0;
  return std::clamp(0.5F * (before - after) / bend, -0.5F, 0.5F);
}

/// Merges a finished family into the result where it scores better.
void merge(const PlaneFamily& family, const Eigen::Vector3f& normal_in_camera,
           const SweepBuffers& buffers, ReferenceDepth& result) {
  const double near_inverse = 1.0 / family.nearest;
  const double step =
      family.count > 1 ? (1.0 / family.farthest - near_inverse) / (family.count - 1) : 0;
  for (std::size_t i = 0; i < buffers.best_score.size(); ++i) {
    const float score = buffers.best_score.data()[i];
    const float plane = buffers.best_plane.data()[i];
    const float slope = buffers.ray_slope.data()[i];
    if (plane < 0 || !(score > result.score.data()[i] + kFamilyMargin) || !(slope > 0)) continue;
    float at = plane;
    if (plane > 0 && plane < static_cast<float>(family.count - 1)) {
      at += parabola_offset(buffers.before.data()[i], score, buffers.after.data()[i]);
    }
    const float inverse_distance = static_cast<float>(near_inverse + step * at);
    result.score.data()[i] = score;
    result.inverse_depth.data()[i] = slope * inverse_distance;
    result.slope_x.data()[i] = normal_in_camera.x() * inverse_distance;
    result.slope_y.data()[i] = normal_in_camera.y() * inverse_distance;
  }
}

void sweep_family(const PlaneFamily& family, const MvsView& view,
                  const std::vector<const MvsView*>& neighbours, int radius, SweepBuffers& buffers,
                  ReferenceDepth& result) {
  const Eigen::Vector3f n = (view.camera_from_world.rotation * family.normal).cast<float>();
  for (std::size_t i = 0; i < buffers.ray_slope.size(); ++i) {
    // 1 / depth = (n . ray) / distance; rays along the plane or away from it have none.
    const float slope = n.x() * view.ray_x.data()[i] + n.y() * view.ray_y.data()[i] + n.z();
    buffers.ray_slope.data()[i] = slope > 1e-3F ? slope : kNone;
  }
  for (Image<float>* image : {&buffers.best_score, &buffers.best_plane, &buffers.before,
                              &buffers.after, &buffers.previous}) {
    std::fill(image->begin(), image->end(), -1.0F);
  }
  std::vector<Warp> warps;
  for (const MvsView* neighbour : neighbours) warps.push_back(warp_between(view, *neighbour));
  for (int plane = 0; plane < family.count; ++plane) {
    const float inverse_distance = static_cast<float>(1.0 / family.distance(plane));
    for (std::size_t i = 0; i < neighbours.size(); ++i) {
      for (int y = 0; y < view.rect.height; ++y) {
        warp_row(view, *neighbours[i], warps[i], inverse_distance, buffers.ray_slope.row(y).data(),
                 y, buffers.warped.row(y).data());
      }
      score_plane(view.luma, radius, buffers);
    }
    keep_best(plane, buffers);
  }
  merge(family, n, buffers, result);
}

}  // namespace

int counted_neighbours(int neighbours) { return std::min((neighbours + 1) / 2, kMostCounted); }

ReferenceDepth sweep_reference(const std::vector<MvsView>& views, int reference,
                               const std::vector<int>& neighbours, const SweepVolume& volume,
                               const MvsConfig& config) {
  const MvsView& view = views[static_cast<std::size_t>(reference)];
  std::vector<const MvsView*> others;
  for (const int i : neighbours) others.push_back(&views[static_cast<std::size_t>(i)]);
  const int w = view.rect.width, h = view.rect.height;
  ReferenceDepth result{Image<float>(w, h, kNone), Image<float>(w, h), Image<float>(w, h),
                        Image<float>(w, h, -2), Image<float>(w, h, kNone)};
  SweepBuffers buffers(w, h, counted_neighbours(static_cast<int>(neighbours.size())));
  const int radius = config.window_px / 2;
  reference_moments(view.luma, radius, buffers);

  // Level planes suit the board and what lies on it; seen obliquely, flanks need planes that face
  // the camera; seen from the side, level planes are edge-on and say nothing.
  const Eigen::Vector3d centre = 0.5 * (volume.low_m + volume.high_m);
  const Eigen::Vector3d view_direction = (centre - view.centre_in_world_m).normalized();
  const double downward = std::abs(view_direction.z());
  std::vector<Eigen::Vector3d> normals;
  if (downward > 0.3) normals.push_back(-Eigen::Vector3d::UnitZ());
  if (downward < 0.94) normals.push_back(view_direction);
  for (const Eigen::Vector3d& normal : normals) {
    const PlaneFamily family = make_family(normal, view, others, volume, config.step_px);
    sweep_family(family, view, others, radius, buffers, result);
  }
  return result;
}

}  // namespace cousin
