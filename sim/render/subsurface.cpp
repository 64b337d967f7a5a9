#include "sim/render/subsurface.h"

#include <embree3/rtcore.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "sim/render/ray_packet.h"
#include "sim/render/sample_points.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

using Eigen::Vector3f;

constexpr int kMostTurns = 1 << 14;
constexpr float kLeastOffsets = 32;  ///< mean free paths below so many ray offsets look diffuse

constexpr std::size_t kPoints = 16;
struct Quadrature {
  std::array<double, kPoints> at{}, weight{};
};

/// Gauss and Legendre's points of [0, 1], by Newton's method.
Quadrature gauss_legendre() {
  Quadrature q;
  for (std::size_t i = 0; i < kPoints; ++i) {
    double x = std::cos(std::numbers::pi * (static_cast<double>(i) + 0.75) / (kPoints + 0.5));
    double slope = 1;
    for (int round = 0; round < 8; ++round) {
      double p = 1, before = 0;
      for (std::size_t n = 1; n <= kPoints; ++n) {
        const auto k = static_cast<double>(n);
        const double next = ((2 * k - 1) * x * p - (k - 1) * before) / k;
        before = p;
        p = next;
      }
      slope = kPoints * (x * p - before) / (x * x - 1);
      x -= p / slope;
    }
    q.at[i] = 0.5 * (1 + x);
    q.weight[i] = 1 / ((1 - x * x) * slope * slope);
  }
  return q;
}

/// Albedo of a deep flat body at root = sqrt(1 - share kept at a turn), lit by the cosine.
double deep_albedo(const Quadrature& mu, double root) {
  std::array<double, kPoints> h{};
  h.fill(1);
  const double half_kept = 0.5 * (1 - root * root);
  for (int round = 0; round < 32; ++round) {  // halves the error
    std::array<double, kPoints> next{};
    for (std::size_t i = 0; i < kPoints; ++i) {
      double sum = 0;
      for (std::size_t k = 0; k < kPoints; ++k)
        sum += mu.weight[k] * mu.at[k] * h[k] / (mu.at[i] + mu.at[k]);
      next[i] = 0.5 * (h[i] + 1 / (root + half_kept * sum));
    }
    h = next;
  }
  double moment = 0;
  for (std::size_t i = 0; i < kPoints; ++i) moment += mu.weight[i] * mu.at[i] * h[i];
  return 1 - 2 * root * moment;
}

/// deep_albedo at root = i / kRoots: falls from 1 to 0.
constexpr std::size_t kRoots = 256;
std::array<float, kRoots + 1> deep_albedos() {
  const Quadrature mu = gauss_legendre();
  std::array<float, kRoots + 1> table{};
  for (std::size_t i = 0; i <= kRoots; ++i)
    table[i] = static_cast<float>(deep_albedo(mu, static_cast<double>(i) / kRoots));
  table.front() = 1;
  table.back() = 0;
  return table;
}

/// Embree's context of a walk: hits of other bodies are passed by.
struct WalkContext {
  RTCIntersectContext context;
  unsigned int instance = 0, geometry = 0;
};

void pass_others(const RTCFilterFunctionNArguments* args) {
  const auto& walk = *reinterpret_cast<const WalkContext*>(args->context);
  for (unsigned int i = 0; i < args->N; ++i) {
    if (args->valid[i] != -1) continue;
    if (RTCHitN_instID(args->hit, args->N, i, 0) != walk.instance ||
        RTCHitN_geomID(args->hit, args->N, i) != walk.geometry) {
      args->valid[i] = 0;
    }
  }
}

/// Numbers of one walk, two at a time.
struct WalkNumbers {
  std::uint64_t key;
  Eigen::Vector2f pair() { return unit_pair(hash64(key++)); }
};

/// Free path of a colour chosen by what each still carries, and what all carry after it.
struct FreePath {
  const Vector3f& turns_per_m;
  const Vector3f& carried;
  float length_m;

  FreePath(const Vector3f& turns, const Vector3f& carried_now, const Eigen::Vector2f& u)
      : turns_per_m(turns), carried(carried_now) {
    float left = u.x() * carried.sum();
    Eigen::Index colour = 0;
    while (colour < 2 && left >= carried[colour]) left -= carried[colour++];
    length_m = -std::log1p(-u.y()) / turns_per_m[colour];
  }

  /// One-sample weights over colours: the balance heuristic [Veach 1997].
  Vector3f after(float distance_m, bool turned) const {
    Vector3f density;
    for (Eigen::Index c = 0; c < 3; ++c)
      density[c] = std::exp(-turns_per_m[c] * distance_m) * (turned ? turns_per_m[c] : 1);
    const float mean = carried.dot(density) / carried.sum();
    if (!(mean > 0)) return Vector3f::Zero();
    return carried.cwiseProduct(density) / mean;
  }
};

Vector3f any_direction(const Eigen::Vector2f& u) {
  const float z = 1 - 2 * u.x(), r = std::sqrt(std::max(1 - z * z, 0.0F));
  return {r * std::cos(2 * kPiF * u.y()), r * std::sin(2 * kPiF * u.y()), z};
}

/// Whether what is carried goes on: of little, some walks go on for all.
bool goes_on(Vector3f& carried, float u) {
  constexpr float kLittle = 0.25F;
  const float most = carried.maxCoeff();
  if (!(most > 0)) return false;
  if (most >= kLittle) return true;
  carried *= kLittle / most;
  return u < most / kLittle;
}

/// The exit as seen from outside: against the way of the light, or along it where rounding had let
/// the walk out before.
PathHit outside_of(const PathTracer::Impl& scene, const RTCHit& hit, const Vector3f& direction,
                   float time) {
  const auto seen = [&](const Vector3f& along) {
    return scene.hit(hit.instID[0], hit.geomID, hit.primID, hit.u, hit.v, along, time);
  };
  PathHit outside = seen(-direction);
  return outside.is_dark ? seen(direction) : outside;
}

}  // namespace

float kept_at_turn(float albedo) {
  static const std::array<float, kRoots + 1> table = deep_albedos();
  const float a = std::clamp(albedo, 0.0F, 1.0F);
  // The table falls: the first entry that is not above.
  const auto place = std::lower_bound(table.begin(), table.end(), a, std::greater<float>());
  if (place == table.begin()) return 1;
  if (place == table.end()) return 0;
  const float high = *(place - 1), low = *place;
  const auto cell = static_cast<float>(place - table.begin() - 1);
  const float root = (cell + (high - a) / (high - low)) / static_cast<float>(kRoots);
  return 1 - root * root;
}

bool walks_below(const PathHit& hit) {
  return hit.bsdf.albedo.maxCoeff() > 0 &&
         hit.bsdf.material->mean_free_path_m.maxCoeff() > kLeastOffsets * hit.offset_m;
}

WalkExit walk_below(const PathTracer::Impl& scene, const PathHit& entry, const Sheet& own,
                    float time, std::uint64_t key) {
  WalkContext walk{make_context(RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT), own.instance, own.geometry};
  walk.context.filter = pass_others;
  WalkNumbers numbers{hash64(key)};
  const Vector3f turns_per_m = entry.bsdf.material->mean_free_path_m
                                   .cwiseMax(Vector3f::Constant(kLeastOffsets * entry.offset_m))
                                   .cwiseInverse();
  const Vector3f kept = entry.bsdf.albedo.unaryExpr(&kept_at_turn);
  const float reach_m = scene.instances[geometry_index(own.instance, own.geometry)].size_m;

  WalkExit out{entry, own, 0};
  Vector3f carried = Vector3f::Ones();
  Vector3f position_m = entry.position_m - entry.offset_m * entry.face_normal;
  const Eigen::Vector2f disk = concentric_disk(numbers.pair());
  const float cosine = std::sqrt(std::max(1 - disk.squaredNorm(), 1e-6F));
  Vector3f direction = -(frame_about(entry.face_normal) * Vector3f(disk.x(), disk.y(), cosine));
  float done_m = entry.offset_m / cosine;  // of the first path: it starts at the surface
  for (int turn = 0; turn < kMostTurns; ++turn) {
    const FreePath path(turns_per_m, carried, numbers.pair());
    const float far_m = path.length_m - done_m;
    if (far_m > 0) {
      RTCRayHit ray;
      ray.ray = single_ray(position_m, direction, far_m, time);
      ray.hit.geomID = ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
      rtcIntersect1(scene.rays->scene, &walk.context, &ray);
      ++out.rays;
      if (ray.hit.geomID != RTC_INVALID_GEOMETRY_ID) {
        carried = path.after(ray.ray.tfar + done_m, false);
        out.hit = outside_of(scene, ray.hit, direction, time);
        out.sheet = {ray.hit.instID[0], ray.hit.geomID, ray.hit.primID};
        break;
      }
      position_m += far_m * direction;
      if (!((position_m - entry.position_m).squaredNorm() <= reach_m * reach_m)) break;
    }
    done_m = 0;
    carried = path.after(path.length_m, true).cwiseProduct(kept);
    const Eigen::Vector2f u = numbers.pair();
    if (!goes_on(carried, u.x())) {
      carried.setZero();
      break;
    }
    direction = any_direction(numbers.pair());
  }
  out.hit.bsdf = entry.bsdf;
  out.hit.bsdf.part = PathBsdf::Part::base;
  out.hit.bsdf.came_out = carried;
  return out;
}

}  // namespace cousin
