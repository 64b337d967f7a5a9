#include "perception/splats/splat_planes.h"

namespace cousin {
namespace {

/// Far below 1/255: never drawn.
constexpr float kUnseenLogit = -100;

}  // namespace

void hide_padding(SplatPlanes& planes) {
  if (planes.planes() != SplatPlane::count) return;
  for (int i = planes.size(); i < planes.padded(); ++i) {
    planes.plane(SplatPlane::opacity)[i] = kUnseenLogit;
  }
}

SplatPlanes::SplatPlanes(int planes, int size, float fill)
    : planes_(planes), size_(size), padded_((size + 7) / 8 * 8) {
  values_.assign(static_cast<std::size_t>(planes) * stride(), fill);
}

SplatPlanes SplatPlanes::gathered(const std::vector<int>& source, float fill) const {
  SplatPlanes result(planes_, static_cast<int>(source.size()), fill);
  for (int k = 0; k < planes_; ++k) {
    const float* from = plane(k);
    float* to = result.plane(k);
    for (std::size_t i = 0; i < source.size(); ++i) {
      if (source[i] >= 0) to[i] = from[source[i]];
    }
  }
  hide_padding(result);
  return result;
}

SplatPlanes to_planes(const std::vector<Splat>& splats) {
  SplatPlanes planes(SplatPlane::count, static_cast<int>(splats.size()));
  for (int i = 0; i < planes.size(); ++i) {
    const Splat& s = splats[static_cast<std::size_t>(i)];
    for (int k = 0; k < 3; ++k) {
      planes.plane(SplatPlane::centre + k)[i] = s.centre_m[k];
      planes.plane(SplatPlane::log_scale + k)[i] = s.log_scale[k];
      planes.plane(SplatPlane::dc + k)[i] = s.sh_dc[static_cast<std::size_t>(k)];
    }
    for (int k = 0; k < 4; ++k) planes.plane(SplatPlane::rotation + k)[i] = s.rotation_wxyz[k];
    planes.plane(SplatPlane::opacity)[i] = s.opacity_logit;
    for (int k = 0; k < 45; ++k) {
      planes.plane(SplatPlane::rest + k)[i] = s.sh_rest[static_cast<std::size_t>(k)];
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
      s.centre_m[k] = planes.plane(SplatPlane::centre + k)[i];
      s.log_scale[k] = planes.plane(SplatPlane::log_scale + k)[i];
      s.sh_dc[static_cast<std::size_t>(k)] = planes.plane(SplatPlane::dc + k)[i];
    }
    for (int k = 0; k < 4; ++k) s.rotation_wxyz[k] = planes.plane(SplatPlane::rotation + k)[i];
    s.opacity_logit = planes.plane(SplatPlane::opacity)[i];
    for (int k = 0; k < 45; ++k) {
      s.sh_rest[static_cast<std::size_t>(k)] = planes.plane(SplatPlane::rest + k)[i];
    }
  }
  return splats;
}

}  // namespace cousin
