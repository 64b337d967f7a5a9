#include "sim/render/truth_samples.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>

#include "sim/render/idle_lanes.h"
#include "sim/render/ray_scene_impl.h"

namespace cousin {
namespace {

Eigen::Vector3f direction_at(const PreparedRays& rays, int x, int y) {
  const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(rays.stride) +
                        static_cast<std::size_t>(x);
  return {rays.x[i], rays.y[i], rays.z[i]};
}

/// Side of the square grid of strata. @throws std::invalid_argument if `samples` is not a square.
int strata_side(int samples) {
  const int side = static_cast<int>(std::lround(std::sqrt(std::max(samples, 0))));
  if (samples < 1 || side * side != samples) {
    throw std::invalid_argument("coverage_samples = " + std::to_string(samples) +
                                " is not a square number");
  }
  return side;
}

/// Share of the strata's centres whose first hit is a specimen.
float pixel_coverage(const RayScene::Impl& impl, const PreparedRays& rays, int x, int y, int side) {
  const PixelDirections pixel = pixel_directions(rays, x, y);
  if (pixel.centre.isZero(0)) return 0;
  const Eigen::Vector3f o = rays.rows[static_cast<std::size_t>(y)].origin_m.cast<float>();
  RTCIntersectContext context = make_context(RTC_INTERSECT_CONTEXT_FLAG_COHERENT);
  const int samples = side * side;
  int hits = 0;
  for (int first = 0; first < samples; first += kLanes) {
    HitPacket packet;
    LaneMask mask;
    for (int i = 0; i < kLanes; ++i) {
      const int s = std::min(first + i, samples - 1);
      const float dx = (static_cast<float>(s % side) + 0.5F) / static_cast<float>(side) - 0.5F;
      const float dy = (static_cast<float>(s / side) + 0.5F) / static_cast<float>(side) - 0.5F;
      const Eigen::Vector3f d = pixel.centre + dx * pixel.slope_x + dy * pixel.slope_y;
      set_ray(packet.ray, i, o.x(), o.y(), o.z(), d.x(), d.y(), d.z());
      packet.ray.time[i] = rays.rows[static_cast<std::size_t>(y)].time;
      packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
      mask.lane[i] = first + i < samples ? -1 : 0;
    }
    idle_lanes(mask, packet.ray);
    rtcIntersect16(mask.lane, impl.scene, &context, &packet);
    for (int i = 0; i < kLanes; ++i) {
      if (!mask.lane[i] || packet.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
      const std::uint32_t g = geometry_index(packet.hit.instID[0][i], packet.hit.geomID[i]);
      hits += impl.geometries[g].is_specimen ? 1 : 0;
    }
  }
  return static_cast<float>(hits) / static_cast<float>(samples);
}

struct PixelBox {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  ///< half open
};

/// Pixels that may see the geometry: its box's edges, sampled, through the first and the last row's
/// pose. The margin covers the bend of an edge between samples. The whole image if some of it does
/// not project.
PixelBox projected_box(const RayScene::Impl& impl, const RayGeometry& geometry,
                       const TrueView& view) {
  const int width = view.camera.width_px, height = view.camera.height_px;
  constexpr int kSteps = 4;
  // Every place of the object in the span with the camera at either end.
  std::vector<Pose> camera_from_object;
  for (Pose world_from_object : geometry.steps) {
    world_from_object.translation_m += impl.centre_m;
    camera_from_object.push_back(view.camera_from_world * world_from_object);
    camera_from_object.push_back(view.camera_from_world_end * world_from_object);
  }
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e30), high = -low;
  for (int a = 0; a < 8; ++a) {
    for (int axis = 1; axis <= 4; axis *= 2) {
      if (a & axis) continue;
      const Eigen::Vector3d& from = geometry.box_corners_in_object_m[static_cast<std::size_t>(a)];
      const Eigen::Vector3d& to =
          geometry.box_corners_in_object_m[static_cast<std::size_t>(a | axis)];
      for (int step = 0; step <= kSteps; ++step) {
        const Eigen::Vector3d p = from + (to - from) * (static_cast<double>(step) / kSteps);
        for (const Pose& pose : camera_from_object) {
          const auto pixel = project(view.camera, pose * p);
          if (!pixel) return {0, 0, width, height};
          low = low.cwiseMin(*pixel);
          high = high.cwiseMax(*pixel);
        }
      }
    }
  }
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(2) + 0.1 * (high - low);
  low = (low - margin).cwiseMax(0.0).cwiseMin(Eigen::Vector2d(width, height));
  high = (high + margin).cwiseMax(0.0).cwiseMin(Eigen::Vector2d(width, height));
  return {static_cast<int>(std::floor(low.x())), static_cast<int>(std::floor(low.y())),
          static_cast<int>(std::ceil(high.x())), static_cast<int>(std::ceil(high.y()))};
}

/// A row's rays in the axes of one mesh.
struct MeshRays {
  Eigen::Vector3f origin_m;
  Eigen::Matrix3f mesh_from_world;
};

MeshRays mesh_rays(const RayScene::Impl& impl, const RayGeometry& geometry,
                   const PreparedRays::Row& row) {
  if (!geometry.is_instanced) return {row.origin_m.cast<float>(), Eigen::Matrix3f::Identity()};
  const Pose mesh_from_world = inverse(mesh_pose(impl, geometry, row.time));
  return {(mesh_from_world * row.origin_m).cast<float>(),
          mesh_from_world.rotation.toRotationMatrix().cast<float>()};
}

/// Adds one geometry to its specimen's full mask: any-hit rays at it alone.
void cast_alone(const RayScene::Impl& impl, const RayGeometry& geometry, const PreparedRays& rays,
                const PixelBox& box, const Image<std::int32_t>& instance,
                Image<std::uint8_t>& mask_full) {
  const RTCScene alone = impl.mesh_of(geometry).alone;
  RTCIntersectContext context = make_context(RTC_INTERSECT_CONTEXT_FLAG_COHERENT);
  for (int y = box.y0; y < box.y1; ++y) {
    const MeshRays frame = mesh_rays(impl, geometry, rays.rows[static_cast<std::size_t>(y)]);
    const Eigen::Vector3f& o = frame.origin_m;
    for (int x = box.x0; x < box.x1; x += kLanes) {
      ShadowPacket packet;
      LaneMask valid;
      for (int i = 0; i < kLanes; ++i) {
        Eigen::Vector3f d = direction_at(rays, std::min(x + i, rays.width - 1), y);
        valid.lane[i] = x + i < box.x1 && !d.isZero(0) ? -1 : 0;
        if (geometry.is_instanced) d = frame.mesh_from_world * d;
        set_ray(packet, i, o.x(), o.y(), o.z(), d.x(), d.y(), d.z());
      }
      idle_lanes(valid, packet);
      find_occluded(valid, alone, context, packet);
      for (int i = 0; i < kLanes && x + i < box.x1; ++i) {
        // A visible pixel is in the full mask by definition, whatever the rounding in the other
        // tree.
        const bool hit = valid.lane[i] && packet.tfar[i] < 0;
        if (hit || instance(x + i, y) == geometry.id) mask_full(x + i, y) = 255;
      }
    }
  }
}

/// Grows to hold pixels.
struct PixelBounds {
  int x0 = std::numeric_limits<int>::max(), y0 = x0, x1 = -1, y1 = -1;
  void add(int x, int y) {
    x0 = std::min(x0, x);
    x1 = std::max(x1, x);
    y0 = std::min(y0, y);
    y1 = std::max(y1, y);
  }
};

/// A box that holds both.
PixelBox joined(const PixelBox& a, const PixelBox& b) {
  if (a.x1 <= a.x0 || a.y1 <= a.y0) return b;
  if (b.x1 <= b.x0 || b.y1 <= b.y0) return a;
  return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
}

InstanceVisibility count_visibility(int id, const PixelBox& box,
                                    const Image<std::int32_t>& instance,
                                    const Image<std::uint8_t>& mask_full) {
  InstanceVisibility result;
  result.instance = id;
  PixelBounds full, seen;
  for (int y = box.y0; y < box.y1; ++y) {
    for (int x = box.x0; x < box.x1; ++x) {
      if (!mask_full(x, y)) continue;
      ++result.pixels_full;
      full.add(x, y);
      if (instance(x, y) != id) continue;
      ++result.pixels_visible;
      seen.add(x, y);
    }
  }
  if (result.pixels_full == 0) return result;
  result.visible_fraction =
      static_cast<double>(result.pixels_visible) / static_cast<double>(result.pixels_full);
  result.box_x = full.x0;
  result.box_y = full.y0;
  result.box_width = full.x1 - full.x0 + 1;
  result.box_height = full.y1 - full.y0 + 1;
  if (result.pixels_visible == 0) return result;
  result.seen_x = seen.x0;
  result.seen_y = seen.y0;
  result.seen_width = seen.x1 - seen.x0 + 1;
  result.seen_height = seen.y1 - seen.y0 + 1;
  return result;
}

}  // namespace

PixelDirections pixel_directions(const PreparedRays& rays, int x, int y) {
  const int x0 = std::max(x - 1, 0), x1 = std::min(x + 1, rays.width - 1);
  const int y0 = std::max(y - 1, 0), y1 = std::min(y + 1, rays.height - 1);
  const auto& here = rays.rows[static_cast<std::size_t>(y)].camera_from_world;
  const auto in_row = [&](int yy) -> Eigen::Vector3f {
    const auto& there = rays.rows[static_cast<std::size_t>(yy)].camera_from_world;
    const Eigen::Vector3f d = direction_at(rays, x, yy);
    if (there == here) return d;
    return (here.transpose() * (there * d.cast<double>())).cast<float>();
  };
  const auto difference = [](const Eigen::Vector3f& a, const Eigen::Vector3f& b,
                             int steps) -> Eigen::Vector3f {
    if (steps == 0 || a.isZero(0) || b.isZero(0)) return Eigen::Vector3f::Zero();
    return (b - a) / static_cast<float>(steps);
  };
  return {direction_at(rays, x, y),
          difference(direction_at(rays, x0, y), direction_at(rays, x1, y), x1 - x0),
          difference(in_row(y0), in_row(y1), y1 - y0)};
}

std::vector<SpecimenGeometries> specimens_by_id(const RayScene::Impl& impl) {
  std::map<int, std::vector<std::size_t>> by_id;
  for (std::size_t i = 0; i < impl.geometries.size(); ++i) {
    if (impl.geometries[i].is_specimen) by_id[impl.geometries[i].id].push_back(i);
  }
  std::vector<SpecimenGeometries> specimens;
  for (auto& [id, geometries] : by_id) specimens.push_back({id, std::move(geometries)});
  return specimens;
}

Image<float> specimen_coverage(const RayScene& rays, const PreparedRays& prepared,
                               const Image<std::uint8_t>& is_specimen, int samples) {
  const int side = strata_side(samples);
  const int width = is_specimen.width(), height = is_specimen.height();
  Image<float> coverage(width, height);
  const auto neighbours_differ = [&](int x, int y) {
    for (int j = std::max(y - 1, 0); j <= std::min(y + 1, height - 1); ++j) {
      for (int i = std::max(x - 1, 0); i <= std::min(x + 1, width - 1); ++i) {
        if (is_specimen(i, j) != is_specimen(x, y)) return true;
      }
    }
    return false;
  };
  tbb::parallel_for(0, height, [&](int y) {
    const FlushDenormals flush;
    for (int x = 0; x < width; ++x) {
      coverage(x, y) = neighbours_differ(x, y) ? pixel_coverage(rays.impl(), prepared, x, y, side)
                                               : static_cast<float>(is_specimen(x, y));
    }
  });
  return coverage;
}

void add_visibility(const RayScene& rays, const TrueView& view, const PreparedRays& prepared,
                    const Image<std::int32_t>& instance, TruthImages& truth) {
  const std::vector<SpecimenGeometries> specimens = specimens_by_id(rays.impl());
  truth.visibility.resize(specimens.size());
  truth.masks_full.assign(specimens.size(),
                          Image<std::uint8_t>(instance.width(), instance.height()));
  tbb::parallel_for(std::size_t{0}, specimens.size(), [&](std::size_t i) {
    const FlushDenormals flush;
    PixelBox whole;
    for (const std::size_t place : specimens[i].geometries) {
      const RayGeometry& g = rays.impl().geometries[place];
      const PixelBox box = projected_box(rays.impl(), g, view);
      if (rays.impl().mesh_of(g).alone)
        cast_alone(rays.impl(), g, prepared, box, instance, truth.masks_full[i]);
      whole = joined(whole, box);
    }
    truth.visibility[i] = count_visibility(specimens[i].id, whole, instance, truth.masks_full[i]);
  });
}

}  // namespace cousin
