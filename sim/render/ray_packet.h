#pragma once

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <limits>
#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace cousin {

/// Rays travel in packets of this many lanes. Private to sim/render and its benchmarks.
inline constexpr int kLanes = 16;
using HitPacket = RTCRayHit16;
using ShadowPacket = RTCRay16;

/// Which lanes carry a ray: -1 = yes, 0 = no.
struct alignas(64) LaneMask {
  int lane[kLanes];
};

/// Denormal floats are flushed to zero while this lives, as Embree asks; the thread's mode is then
/// restored.
class FlushDenormals {
 public:
#if defined(__SSE__)
  FlushDenormals() : before_(_mm_getcsr()) { _mm_setcsr(before_ | 0x8040U); }  // FTZ and DAZ
  ~FlushDenormals() { _mm_setcsr(before_); }

 private:
  unsigned int before_;
#else
  FlushDenormals() {}
#endif
 public:
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;
};

/// Where a ray goes on beyond a hit. Never a denormal: flushed to zero, it would meet a hit at no
/// distance again and again.
inline float beyond(float t) {
  return std::max(std::nextafter(t, std::numeric_limits<float>::infinity()),
                  std::numeric_limits<float>::min());
}

inline RTCIntersectContext make_context(RTCIntersectContextFlags flags) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = flags;
  return context;
}

/// Lane `i` becomes a ray that has hit nothing yet.
template <class Packet>
inline void set_ray(Packet& ray, int i, float ox, float oy, float oz, float dx, float dy, float dz,
                    float far = std::numeric_limits<float>::infinity()) {
  ray.org_x[i] = ox;
  ray.org_y[i] = oy;
  ray.org_z[i] = oz;
  ray.tnear[i] = 0;
  ray.dir_x[i] = dx;
  ray.dir_y[i] = dy;
  ray.dir_z[i] = dz;
  ray.time[i] = 0;
  ray.tfar[i] = far;
  ray.mask[i] = 0xFFFFFFFFU;
  ray.id[i] = 0;
  ray.flags[i] = 0;
}

/// Shadow rays of lanes with mask -1: tfar becomes -infinity where something is in the way.
///
/// Not rtcOccluded16: in Embree 3.13.5 its coherent form never returns for some packets, in scenes
/// of any flags (a sphere of a million triangles, rays that leave it; leaves as instances). The
/// nearest hit is asked for instead, which costs a tenth more.
inline void find_occluded(const LaneMask& mask, RTCScene scene, RTCIntersectContext& context,
                          ShadowPacket& shadow) {
  HitPacket packet;
  packet.ray = shadow;
  for (int i = 0; i < kLanes; ++i) {
    packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
  rtcIntersect16(mask.lane, scene, &context, &packet);
  for (int i = 0; i < kLanes; ++i) {
    if (mask.lane[i] && packet.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID)
      shadow.tfar[i] = -std::numeric_limits<float>::infinity();
  }
}

}  // namespace cousin
