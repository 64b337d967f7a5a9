#include "perception/splats/splat_planes.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace cousin {
namespace {

/// Far below 1/255: never drawn.
constexpr float kUnseenLogit = -100;

using Blocks = tbb::blocked_range<int>;
constexpr int kBlocks = 256;  ///< that one task fills

}  // namespace

void hide_padding(SplatPlanes& planes) {
  if (planes.planes() != SplatPlane::count) return;
  for (int i = planes.size(); i < planes.padded(); ++i) {
    planes.at(SplatPlane::opacity, i) = kUnseenLogit;
  }
}

SplatPlanes::SplatPlanes(int planes, int size, float fill)
    : planes_(planes), size_(size), padded_((size + block - 1) / block * block) {
  Row row;
  std::fill_n(row.lane, block, fill);
  values_.assign(static_cast<std::size_t>(planes) * static_cast<std::size_t>(padded_ / block), row);
}

SplatPlanes SplatPlanes::gathered(const std::vector<int>& source, float fill) const {
  const int count = static_cast<int>(source.size());
  SplatPlanes result(planes_, count, fill);
  tbb::parallel_for(Blocks(0, result.padded_ / block, kBlocks), [&](const Blocks& range) {
    for (int i = block * range.begin(); i < std::min(count, block * range.end()); ++i) {
      const int from = source[static_cast<std::size_t>(i)];
      if (from < 0) continue;
      for (int k = 0; k < planes_; ++k) result.at(k, i) = at(k, from);
    }
  });
  hide_padding(result);
  return result;
}

SplatPlanes to_planes(const std::vector<Splat>& splats) {
  SplatPlanes planes(SplatPlane::count, static_cast<int>(splats.size()));
  for (int i = 0; i < planes.size(); ++i) {
    const Splat& s = splats[static_cast<std::size_t>(i)];
    for (int k = 0; k < 3; ++k) {
      planes.at(SplatPlane::centre + k, i) = s.centre_m[k];
      planes.at(SplatPlane::log_scale + k, i) = s.log_scale[k];
      planes.at(SplatPlane::dc + k, i) = s.sh_dc[static_cast<std::size_t>(k)];
    }
    for (int k = 0; k < 4; ++k) planes.at(SplatPlane::rotation + k, i) = s.rotation_wxyz[k];
    planes.at(SplatPlane::opacity, i) = s.opacity_logit;
    for (int k = 0; k < 45; ++k) {
      planes.at(SplatPlane::rest + k, i) = s.sh_rest[static_cast<std::size_t>(k)];
    }
  }
  hide_padding(planes);
  return planes;
}

std::vector<Splat> to_splats(const SplatPlanes& planes) {
  std::vector<Splat> splats(static_cast<std::size_t>(planes.size()));
  for (int i = 0; i < planes.size(); ++i) {
    Splat& s = splats[static_cast<std::size_t>(i)];
    for (int k = 0; k < 3; ++k) {
      s.centre_m[k] = planes.at(SplatPlane::centre + k, i);
      s.log_scale[k] = planes.at(SplatPlane::log_scale + k, i);
      s.sh_dc[static_cast<std::size_t>(k)] = planes.at(SplatPlane::dc + k, i);
    }
    for (int k = 0; k < 4; ++k) s.rotation_wxyz[k] = planes.at(SplatPlane::rotation + k, i);
    s.opacity_logit = planes.at(SplatPlane::opacity, i);
    for (int k = 0; k < 45; ++k) {
      s.sh_rest[static_cast<std::size_t>(k)] = planes.at(SplatPlane::rest + k, i);
    }
  }
  return splats;
}

}  // namespace cousin
