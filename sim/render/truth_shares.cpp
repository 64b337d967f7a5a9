#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "sim/render/idle_lanes.h"
#include "sim/render/ray_scene_impl.h"
#include "sim/render/sample_points.h"
#include "sim/render/truth_samples.h"

namespace cousin {
namespace {

/// Samples of one specimen in one pixel.
struct PixelCount {
  int x = 0;
  int specimen = 0;
  int samples = 0;
};

/// Casts a row's samples and counts them by specimen.
class RowSampler {
 public:
  RowSampler(const RayScene::Impl& impl, const PreparedRays& rays,
             const std::vector<int>& specimen_of, const std::vector<Eigen::Vector2f>& points)
      : impl_(impl), rays_(rays), specimen_of_(specimen_of), points_(points) {
    context_ = make_context(RTC_INTERSECT_CONTEXT_FLAG_COHERENT);
  }

  std::vector<PixelCount> operator()(int y) {
    counts_.clear();
    lane_ = 0;
    const PreparedRays::Row& row = rays_.rows[static_cast<std::size_t>(y)];
    const Eigen::Vector3f o = row.origin_m.cast<float>();
    for (int x = 0; x < rays_.width; ++x) {
      const PixelDirections pixel = pixel_directions(rays_, x, y);
      if (pixel.centre.isZero(0)) continue;
      const Eigen::Vector2f shift =
          unit_pair(hash64(static_cast<std::uint64_t>(y) << 32 | static_cast<std::uint64_t>(x)));
      for (const Eigen::Vector2f& point : points_) {
        const Eigen::Vector2f p = rotated(point, shift);
        const Eigen::Vector3f d =
            pixel.centre + (p.x() - 0.5F) * pixel.slope_x + (p.y() - 0.5F) * pixel.slope_y;
        set_ray(packet_.ray, lane_, o.x(), o.y(), o.z(), d.x(), d.y(), d.z());
        packet_.ray.time[lane_] = row.time;
        pixel_[static_cast<std::size_t>(lane_)] = x;
        if (++lane_ == kLanes) cast();
      }
    }
    if (lane_ > 0) cast();
    return counts_;
  }

 private:
  void cast() {
    LaneMask mask;
    for (int i = 0; i < kLanes; ++i) {
      mask.lane[i] = i < lane_ ? -1 : 0;
      packet_.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    }
    idle_lanes(mask, packet_.ray);
    rtcIntersect16(mask.lane, impl_.scene, &context_, &packet_);
    for (int i = 0; i < lane_; ++i) {
      if (packet_.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
      const int specimen =
          specimen_of_[geometry_index(packet_.hit.instID[0][i], packet_.hit.geomID[i])];
      if (specimen >= 0) add(pixel_[static_cast<std::size_t>(i)], specimen);
    }
    lane_ = 0;
  }

  /// Pixels come in order, so the pixel's counts are the last ones.
  void add(int x, int specimen) {
    for (auto count = counts_.rbegin(); count != counts_.rend() && count->x == x; ++count) {
      if (count->specimen != specimen) continue;
      ++count->samples;
      return;
    }
    counts_.push_back({x, specimen, 1});
  }

  const RayScene::Impl& impl_;
  const PreparedRays& rays_;
  const std::vector<int>& specimen_of_;
  const std::vector<Eigen::Vector2f>& points_;
  RTCIntersectContext context_;
  HitPacket packet_;
  std::array<int, kLanes> pixel_{};
  int lane_ = 0;
  std::vector<PixelCount> counts_;
};

}  // namespace

std::vector<InstanceShares> specimen_shares(const RayScene& rays, const PreparedRays& prepared,
                                            int samples) {
  if (samples < 1 || samples > 4096) {
    throw std::invalid_argument("share_samples = " + std::to_string(samples) +
                                " is not in 1..4096");
  }
  const auto& geometries = rays.impl().geometries;
  const std::vector<SpecimenGeometries> order = specimens_by_id(rays.impl());
  std::vector<int> specimen_of(geometries.size(), -1);
  std::vector<InstanceShares> shares(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    for (const std::size_t place : order[k].geometries) specimen_of[place] = static_cast<int>(k);
    shares[k].instance = order[k].id;
    shares[k].width_px = prepared.width;
    shares[k].height_px = prepared.height;
  }
  std::vector<Eigen::Vector2f> points;
  for (int i = 0; i < samples; ++i) points.push_back(sobol_point(static_cast<std::uint32_t>(i)));
  std::vector<std::vector<PixelCount>> rows(static_cast<std::size_t>(prepared.height));
  tbb::parallel_for(0, prepared.height, [&](int y) {
    const FlushDenormals flush;
    rows[static_cast<std::size_t>(y)] = RowSampler(rays.impl(), prepared, specimen_of, points)(y);
  });
  for (int y = 0; y < prepared.height; ++y) {
    for (const PixelCount& count : rows[static_cast<std::size_t>(y)]) {
      const float share = static_cast<float>(count.samples) / static_cast<float>(samples);
      InstanceShares& instance = shares[static_cast<std::size_t>(count.specimen)];
      instance.pixels.push_back({count.x, y, share});
      instance.area_px += static_cast<double>(share);
    }
  }
  return shares;
}

}  // namespace cousin
