#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "sim/render/idle_lanes.h"
#include "sim/render/ray_limits.h"
#include "sim/render/sample_points.h"
#include "sim/render/surface_light.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

/// Where irradiance is gathered.
struct CachePoint {
  Eigen::Vector3f origin_m;  ///< off the surface by its rounding
  Eigen::Vector3f normal;
  std::uint32_t surface = 0;
};

Eigen::Vector3f vec(const Rgbf& c) { return {c.r, c.g, c.b}; }

LitSurface make_surface(const Scene& scene, const RayScene::Impl& rays, const RayGeometry& geometry,
                        double time_s) {
  const Instance& instance = scene.instances[static_cast<std::size_t>(geometry.instance_index)];
  const ObjectModel& model = scene.models[static_cast<std::size_t>(instance.model)];
  const Material& material = scene.materials[static_cast<std::size_t>(instance.material)];
  if (material.kind != SurfaceKind::coated || material.noise) {
    throw std::invalid_argument("irradiance cache: material \"" + material.name +
                                "\" is not a plain coated one and needs the path tracer");
  }
  LitSurface s;
  if (geometry.is_instanced ||
      rays.mesh_of(geometry).planes.size() != rays.mesh_of(geometry).triangles.size()) {
    throw std::invalid_argument("irradiance cache: instance \"" + instance.name +
                                "\" shares its model, moves, or is one of more triangles than the "
                                "cache takes, and needs the path tracer");
  }
  s.mesh = &rays.mesh_of(geometry);
  s.is_specimen = geometry.is_specimen;
  s.coat = Coat(material.ior, material.roughness);
  s.albedo = vec(material.albedo);
  s.ink_albedo = vec(material.ink_albedo);
  for (const Rgbf& a : model.vertex_albedo)
    s.vertex_albedo.push_back(vec(a).cwiseProduct(s.albedo));
  const Pose pose = world_from_object(instance, time_s);
  for (const auto& n : model.vertex_normals) {
    s.vertex_normals.push_back((pose.rotation * n.cast<double>()).cast<float>());
  }
  s.print = material.print;
  const Pose object_from_world = inverse(pose);
  s.object_from_world = object_from_world.rotation.toRotationMatrix().cast<float>();
  s.object_origin_m = (object_from_world * rays.centre_m).cast<float>();
  return s;
}

/// Given normals, or the faces' mean weighted by area.
std::vector<Eigen::Vector3f> smooth_normals(const LitSurface& s) {
  if (!s.vertex_normals.empty()) return s.vertex_normals;
  const RayMesh& g = *s.mesh;
  std::vector<Eigen::Vector3d> sums(g.vertices_m.size() - 1, Eigen::Vector3d::Zero());
  for (const auto& t : g.triangles) {
    const Eigen::Vector3d a = g.vertices_m[t[0]].cast<double>();
    const Eigen::Vector3d cross =
        (g.vertices_m[t[1]].cast<double>() - a).cross(g.vertices_m[t[2]].cast<double>() - a);
    for (const std::uint32_t v : t) sums[v] += cross;
  }
  std::vector<Eigen::Vector3f> normals;
  for (const auto& sum : sums) normals.push_back(sum.stableNormalized().cast<float>());
  return normals;
}

/// Lays the cache points of all surfaces and gives each triangle its lattice.
class PointLayout {
 public:
  PointLayout(std::vector<LitSurface>& surfaces, double texel_m)
      : texel_m_(static_cast<float>(texel_m)) {
    for (std::size_t i = 0; i < surfaces.size(); ++i)
      lay(surfaces[i], static_cast<std::uint32_t>(i));
  }
  std::vector<CachePoint> points;

 private:
  /// Cells along the longest edge: dense on specimens and the print, coarse elsewhere.
  std::uint32_t lattice_order(const LitSurface& s, std::size_t triangle, float size_m) const {
    const RayMesh& g = *s.mesh;
    const auto& t = g.triangles[triangle];
    float longest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      longest = std::max(longest, (g.vertices_m[t[k]] - g.vertices_m[t[(k + 1) % 3]]).norm());
    }
    constexpr float kCoarseCells = 48;
    const bool is_near = s.is_specimen || g.planes[triangle].has_print;
    const float spacing = is_near ? texel_m_ : std::max(texel_m_, size_m / kCoarseCells);
    constexpr float kMostCells = 512;
    return static_cast<std::uint32_t>(std::clamp(std::round(longest / spacing), 1.0F, kMostCells));
  }

  void lay(LitSurface& s, std::uint32_t index) {
    const RayMesh& g = *s.mesh;
    const std::size_t vertex_count = g.vertices_m.size() - 1;
    const std::vector<Eigen::Vector3f> normals = smooth_normals(s);
    Eigen::Vector3f low = Eigen::Vector3f::Constant(1e30F), high = -low;
    for (std::size_t i = 0; i < vertex_count; ++i) {
      low = low.cwiseMin(g.vertices_m[i]);
      high = high.cwiseMax(g.vertices_m[i]);
    }
    const float size_m = vertex_count ? (high - low).norm() : 0;

    const auto first = static_cast<std::uint32_t>(points.size());
    s.first_point = first;
    s.lattices.resize(g.triangles.size());
    std::vector<float> vertex_offset(vertex_count, 0.0F);
    std::vector<std::size_t> own;  // triangles with a lattice of their own
    for (std::size_t i = 0; i < g.triangles.size(); ++i) {
      s.lattices[i].order = lattice_order(s, i, size_m);
      if (s.lattices[i].order > 1 || !is_smooth(g, i, normals)) {
        own.push_back(i);
        continue;
      }
      s.lattices[i].order = 0;
      for (const std::uint32_t v : g.triangles[i]) {
        // Along the mean normal, four times clears the tilt of the faces about it.
        vertex_offset[v] = std::max(vertex_offset[v], 4 * g.planes[i].offset_m);
      }
    }
    // Vertices that no triangle shares get a point too, so that indices stay plain; it is not
    // gathered.
    for (std::size_t v = 0; v < vertex_count; ++v) {
      const bool used = vertex_offset[v] > 0;
      points.push_back({g.vertices_m[v] + vertex_offset[v] * normals[v],
                        used ? normals[v] : Eigen::Vector3f(Eigen::Vector3f::Zero()), index});
    }
    for (const std::size_t i : own) lay_lattice(s, i, index, normals);
    if (g.is_open) {
      const std::size_t end = points.size();
      s.back_points = static_cast<std::uint32_t>(end - first);
      for (std::size_t i = first; i < end; ++i) points.push_back(back_of(points[i], s));
    }
  }

  static Eigen::Vector3f face_normal(const TrianglePlane& p) {
    return Eigen::Vector3d(p.normal[0], p.normal[1], p.normal[2]).cast<float>();
  }
  /// Whether a corner takes the smooth normal: within 35 degrees of the face; beyond lies a crease.
  static bool follows(const Eigen::Vector3f& normal, const Eigen::Vector3f& face) {
    return normal.dot(face) > 0.82F;
  }
  static bool is_smooth(const RayMesh& g, std::size_t triangle,
                        const std::vector<Eigen::Vector3f>& normals) {
    const Eigen::Vector3f face = face_normal(g.planes[triangle]);
    const auto& t = g.triangles[triangle];
    return std::all_of(t.begin(), t.end(),
                       [&](std::uint32_t v) { return follows(normals[v], face); });
  }
  /// The same place on the other side: the offsets of both sides lie along the normal.
  static CachePoint back_of(const CachePoint& front, const LitSurface& s) {
    float offset = 0;
    for (const TrianglePlane& p : s.mesh->planes) offset = std::max(offset, p.offset_m);
    return {front.origin_m - 8 * offset * front.normal, -front.normal, front.surface};
  }

  void lay_lattice(LitSurface& s, std::size_t triangle, std::uint32_t index,
                   const std::vector<Eigen::Vector3f>& normals) {
    const RayMesh& g = *s.mesh;
    const auto& t = g.triangles[triangle];
    const Eigen::Vector3f face = face_normal(g.planes[triangle]);
    Eigen::Vector3f corner[3];
    for (std::size_t k = 0; k < 3; ++k)
      corner[k] = follows(normals[t[k]], face) ? normals[t[k]] : face;
    CacheLattice& lattice = s.lattices[triangle];
    lattice.first = static_cast<std::uint32_t>(points.size());
    const auto n = static_cast<float>(lattice.order);
    for (std::uint32_t j = 0; j <= lattice.order; ++j) {
      for (std::uint32_t i = 0; i + j <= lattice.order; ++i) {
        // A fiftieth of a cell inwards, so that points on an edge do not touch an adjoining wall.
        const float inward = 0.02F / n;
        const float u = (static_cast<float>(i) / n) * (1 - inward) + inward / 3;
        const float v = (static_cast<float>(j) / n) * (1 - inward) + inward / 3;
        const Eigen::Vector3f p =
            g.vertices_m[t[0]] * (1 - u - v) + g.vertices_m[t[1]] * u + g.vertices_m[t[2]] * v;
        const Eigen::Vector3f normal =
            (corner[0] * (1 - u - v) + corner[1] * u + corner[2] * v).normalized();
        // Four times, as p is made in float.
        points.push_back({p + 4 * g.planes[triangle].offset_m * face, normal, index});
      }
    }
  }

  float texel_m_;
};

/// Gathers light at cache points.
class Gatherer {
 public:
  Gatherer(const IrradianceCache::Impl& cache, const std::vector<CachePoint>& points, Rng rng)
      : cache_(cache), points_(points), key_(rng.fork("irradiance")()) {}

  /// Light of the lamps, next-event estimation.
  Eigen::Vector3f lamps(std::size_t index, const std::vector<Eigen::Vector2f>& samples) const {
    const CachePoint& point = points_[index];
    const Coat& coat = cache_.surfaces[point.surface].coat;
    RTCIntersectContext context = make_context(RTC_INTERSECT_CONTEXT_FLAG_COHERENT);
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (std::size_t k = 0; k < cache_.lights.lamps.size(); ++k) {
      const auto& lamp = cache_.lights.lamps[k];
      const Eigen::Vector2f shift = unit_pair(hash64(hash64(key_ + index) + 17 * (k + 1)));
      float arriving = 0;
      for (std::size_t first = 0; first < samples.size(); first += kLanes) {
        ShadowPacket packet;
        LaneMask mask;
        float weight[kLanes];
        bool any = false;
        for (int i = 0; i < kLanes; ++i) {
          const Eigen::Vector2f u = rotated(samples[first + static_cast<std::size_t>(i)], shift);
          const LampDraw draw = draw_lamp(lamp, point.origin_m, u);
          const float cosine = point.normal.dot(draw.direction);
          const bool lit = cosine > 0 && draw.density > 0;
          mask.lane[i] = lit ? -1 : 0;
          if (!lit) continue;
          any = true;
          weight[i] = cosine * coat.entering(cosine) / draw.density;
          set_ray(packet, i, point.origin_m.x(), point.origin_m.y(), point.origin_m.z(),
                  draw.direction.x(), draw.direction.y(), draw.direction.z(), draw.distance_m);
        }
        if (!any) continue;
        idle_lanes(mask, packet);
        find_occluded(mask, cache_.rays->scene, context, packet);
        for (int i = 0; i < kLanes; ++i) {
          if (mask.lane[i] && packet.tfar[i] >= 0) arriving += weight[i];
        }
      }
      sum += arriving / static_cast<float>(samples.size()) * lamp.radiance;
    }
    return sum;
  }

  /// Light of pictures that directions can be drawn from, weighed against `surroundings`, which
  /// meets the same light by the surface's own directions.
  Eigen::Vector3f pictures(std::size_t index, const std::vector<Eigen::Vector2f>& samples) const {
    const CachePoint& point = points_[index];
    const Coat& coat = cache_.surfaces[point.surface].coat;
    RTCIntersectContext context = make_context(RTC_INTERSECT_CONTEXT_FLAG_COHERENT);
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (std::size_t k = 0; k < cache_.lights.pictures.size(); ++k) {
      const auto& picture = cache_.lights.pictures[k];
      if (picture.row_sums.empty()) continue;
      const Eigen::Vector2f shift = unit_pair(hash64(hash64(key_ + index) + 29 * (k + 1)));
      for (std::size_t first = 0; first < samples.size(); first += kLanes) {
        ShadowPacket packet;
        LaneMask mask;
        Eigen::Vector3f light[kLanes];
        for (int i = 0; i < kLanes; ++i) {
          const Eigen::Vector2f u = rotated(samples[first + static_cast<std::size_t>(i)], shift);
          const Eigen::Vector3f d = draw_picture(picture, u);
          const float density = picture_density(picture, d);
          const float cosine = point.normal.dot(d);
          const bool lit = cosine > 0 && density > 0;
          mask.lane[i] = lit ? -1 : 0;
          if (!lit) continue;
          light[i] = share_of(density, cosine / kPiF) * cosine * coat.entering(cosine) / density *
                     picture_radiance(picture, d);
          set_ray(packet, i, point.origin_m.x(), point.origin_m.y(), point.origin_m.z(), d.x(),
                  d.y(), d.z());
        }
        idle_lanes(mask, packet);
        find_occluded(mask, cache_.rays->scene, context, packet);
        for (int i = 0; i < kLanes; ++i) {
          if (mask.lane[i] && packet.tfar[i] >= 0) sum += light[i];
        }
      }
    }
    return sum / static_cast<float>(samples.size());
  }

  /// Light of the sky, and of surfaces if `bounce`, by cosine-weighted directions.
  Eigen::Vector3f surroundings(std::size_t index, const std::vector<Eigen::Vector2f>& samples,
                               bool bounce, std::uint64_t pass) const {
    const CachePoint& point = points_[index];
    const Coat& coat = cache_.surfaces[point.surface].coat;
    const Eigen::Matrix3f frame = frame_about(point.normal);
    const std::uint64_t hash = hash64(hash64(key_ + index) + 1000003 * (pass + 1));
    const Eigen::Vector2f shift = unit_pair(hash);
    RTCIntersectContext context = make_context(RTC_INTERSECT_CONTEXT_FLAG_COHERENT);
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    HitPacket packet;
    SecondaryPacket secondary;
    LaneMask all;
    Eigen::Vector3f direction[kLanes];
    float weight[kLanes];
    for (std::size_t first = 0; first < samples.size(); first += kLanes) {
      for (int i = 0; i < kLanes; ++i) {
        const Eigen::Vector2f disk =
            concentric_disk(rotated(samples[first + static_cast<std::size_t>(i)], shift));
        const float cosine = std::sqrt(std::max(0.0F, 1 - disk.squaredNorm()));
        direction[i] = frame * Eigen::Vector3f(disk.x(), disk.y(), cosine);
        weight[i] = coat.entering(cosine);
        all.lane[i] = -1;
        set_ray(packet.ray, i, point.origin_m.x(), point.origin_m.y(), point.origin_m.z(),
                direction[i].x(), direction[i].y(), direction[i].z());
        packet.hit.geomID[i] = kNoGeometry;
      }
      rtcIntersect16(all.lane, cache_.rays->scene, &context, &packet);
      for (int i = 0; i < kLanes; ++i) {
        secondary.mask.lane[i] = 0;
        if (packet.hit.geomID[i] == kNoGeometry) {
          sum += weight[i] * drawn_sky(direction[i], direction[i].dot(point.normal));
        } else if (bounce) {
          secondary.mask.lane[i] = -1;
          secondary.hit[i] = surface_hit(cache_, packet.hit.geomID[i], packet.hit.primID[i],
                                         packet.hit.u[i], packet.hit.v[i], direction[i]);
          secondary.light[i] = secondary_light(cache_, secondary.hit[i], direction[i]);
          secondary.hash[i] = hash64(hash + first + static_cast<std::size_t>(i));
        }
      }
      if (!bounce) continue;
      if (!cache_.lights.suns.empty()) add_suns(cache_, secondary);
      for (int i = 0; i < kLanes; ++i) {
        if (secondary.mask.lane[i]) sum += weight[i] * secondary.light[i].radiance;
      }
    }
    return sum * (kPiF / static_cast<float>(samples.size()));
  }

 private:
  /// Radiance of skies and pictures where a direction was drawn by its cosine; of pictures that
  /// `pictures` draws from, the share that it leaves.
  Eigen::Vector3f drawn_sky(const Eigen::Vector3f& d, float cosine) const {
    Eigen::Vector3f sum = dome_radiance(cache_.lights, d);
    const float own = std::max(cosine, 1e-6F) / kPiF;
    for (const auto& picture : cache_.lights.pictures) {
      const bool is_drawn = !picture.row_sums.empty();
      const float share = is_drawn ? share_of(own, picture_density(picture, d)) : 1;
      sum += share * picture_radiance(picture, d);
    }
    return sum;
  }

  const IrradianceCache::Impl& cache_;
  const std::vector<CachePoint>& points_;
  std::uint64_t key_;
};

int whole_packets(int samples) { return std::max(1, (samples + kLanes - 1) / kLanes) * kLanes; }

template <class Function>
void for_each_point(const std::vector<CachePoint>& points, const Function& function) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points.size(), 256),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      const FlushDenormals flush;
                      for (std::size_t i = range.begin(); i < range.end(); ++i) {
                        if (!points[i].normal.isZero(0)) function(i);
                      }
                    });
}

}  // namespace

IrradianceCache::IrradianceCache(const RayScene& rays, const Scene& scene,
                                 const RadianceConfig& config, Rng rng)
    : impl_(std::make_unique<Impl>()) {
  validate(config);
  if (scene.instances.size() != rays.impl().geometries.size()) {
    throw std::invalid_argument("irradiance cache: the scene \"" + scene.name +
                                "\" is not the one of the rays");
  }
  Impl& impl = *impl_;
  impl.rays = &rays.impl();
  impl.lights = make_lights(scene, impl.rays->centre_m);
  if (!impl.lights.beams.empty()) {
    throw std::invalid_argument("irradiance cache: scene \"" + scene.name +
                                "\" has a projector, which needs the path tracer");
  }
  for (const RayGeometry& geometry : impl.rays->geometries) {
    impl.surfaces.push_back(make_surface(scene, *impl.rays, geometry, rays.impl().span_s.begin_s));
  }
  const std::vector<CachePoint> points = PointLayout(impl.surfaces, config.board_texel_m).points;
  const Gatherer gather(impl, points, rng);

  const auto full = coherent_points(whole_packets(config.irradiance_samples));
  // An eighth on the way: their noise averages out when the last pass gathers from many points.
  const auto rough = coherent_points(whole_packets(config.irradiance_samples / 8));
  std::vector<Eigen::Vector3f> direct(points.size(), Eigen::Vector3f::Zero());
  // A lamp fills a small part of the hemisphere, so it needs fewer samples than the rest of it.
  const auto lamp_samples = coherent_points(whole_packets(config.irradiance_samples / 4));
  for_each_point(points, [&](std::size_t i) {
    direct[i] = gather.lamps(i, lamp_samples) + gather.pictures(i, full);
  });
  for (int pass = 0; pass <= config.max_bounces; ++pass) {
    const bool is_last = pass == config.max_bounces;
    std::vector<Eigen::Vector3f> next = direct;
    for_each_point(points, [&](std::size_t i) {
      next[i] += gather.surroundings(i, is_last ? full : rough, pass > 0,
                                     static_cast<std::uint64_t>(pass));
    });
    impl.irradiance = std::move(next);
  }
}

IrradianceCache::~IrradianceCache() = default;
IrradianceCache::IrradianceCache(IrradianceCache&&) noexcept = default;

}  // namespace cousin
