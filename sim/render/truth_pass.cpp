#include "sim/render/truth_pass.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "sim/render/exact_hit.h"
#include "sim/render/idle_lanes.h"
#include "sim/render/keypoint_truth.h"
#include "sim/render/leaf_area_truth.h"
#include "sim/render/ray_limits.h"
#include "sim/render/ray_scene_impl.h"
#include "sim/render/ray_table.h"
#include "sim/render/truth_samples.h"
#include "sim/truth/scene_check.h"

namespace cousin {
namespace {

constexpr float kNoDepth = std::numeric_limits<float>::quiet_NaN();

/// Pointers to one row of each image; null for what is not needed.
struct TruthRow {
  float* depth_m = nullptr;
  Eigen::Vector3f* normal = nullptr;
  Eigen::Vector3f* position_m = nullptr;
  std::int32_t* instance = nullptr;
  std::uint16_t* part = nullptr;
};

template <class T>
T* row_of(Image<T>& image, int y) {
  return image.empty() ? nullptr : image.row(y).data();
}

class RowTracer {
 public:
  RowTracer(const RayScene::Impl& impl, const PreparedRays& rays) : impl_(impl), rays_(rays) {
    context_ = make_context(RTC_INTERSECT_CONTEXT_FLAG_COHERENT);
  }

  void operator()(int y, const TruthRow& out) {
    const PreparedRays::Row& row = rays_.rows[static_cast<std::size_t>(y)];
    const Eigen::Vector3f o = row.origin_m.cast<float>();
    frame_ = {};
    plane_ = {};
    axis_ = row.camera_from_world.row(2);
    const std::size_t first = static_cast<std::size_t>(y) * static_cast<std::size_t>(rays_.stride);
    for (int x = 0; x < rays_.width; x += kLanes) {
      const std::size_t at = first + static_cast<std::size_t>(x);
      load_packet(rays_, at, o, row.time, packet_, mask_);
      idle_lanes(mask_, packet_.ray);
      rtcIntersect16(mask_.lane, impl_.scene, &context_, &packet_);
      const int lanes = std::min(kLanes, rays_.width - x);
      if (lanes == kLanes && resolve_together(row, at, x, out)) continue;
      for (int i = 0; i < lanes; ++i) {
        if (packet_.hit.geomID[i] != kNoGeometry)
          resolve(row, at + static_cast<std::size_t>(i), i, x + i, out);
      }
    }
  }

 private:
  /// The plane of a hit, kept while hits stay on one triangle.
  void look_at(const PreparedRays::Row& row, std::uint32_t geometry, std::uint32_t triangle) {
    if (plane_.geometry == geometry && plane_.triangle == triangle) return;
    if (frame_.geometry != geometry) frame_ = row_frame(impl_, geometry, row);
    plane_ = row_plane(frame_, triangle, row);
  }

  ExactHit meet(const Eigen::Vector3d& d) const {
    if (frame_.is_world) return exact_hit(plane_, frame_.origin_m, frame_.reach_m, d);
    return exact_hit(plane_, frame_.origin_m, frame_.reach_m, frame_.mesh_from_world * d);
  }

  /// Casts on beyond a hit that was rejected. Lane hits are rare here, so one ray at a time.
  bool cast_on(const PreparedRays::Row& row, const Eigen::Vector3d& d, float tnear, ExactHit& hit) {
    const Eigen::Vector3f o = row.origin_m.cast<float>(), direction = d.cast<float>();
    RTCIntersectContext context = make_context(RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT);
    for (;;) {
      RTCRayHit ray{};
      ray.ray.org_x = o.x();
      ray.ray.org_y = o.y();
      ray.ray.org_z = o.z();
      ray.ray.dir_x = direction.x();
      ray.ray.dir_y = direction.y();
      ray.ray.dir_z = direction.z();
      ray.ray.time = row.time;
      ray.ray.tnear = beyond(tnear);
      ray.ray.tfar = std::numeric_limits<float>::infinity();
      ray.ray.mask = 0xFFFFFFFFU;
      ray.hit.geomID = kNoGeometry;
      rtcIntersect1(impl_.scene, &context, &ray);
      if (ray.hit.geomID == kNoGeometry) return false;
      look_at(row, geometry_index(ray.hit.instID[0], ray.hit.geomID), ray.hit.primID);
      hit = meet(d);
      if (hit.accepted) return true;
      tnear = ray.ray.tfar;
    }
  }

  /// The common case, in vectors: all lanes meet one triangle well inside. False if they do not.
  bool resolve_together(const PreparedRays::Row& row, std::size_t ray, int x, const TruthRow& out) {
    const std::uint32_t geometry = geometry_index(packet_.hit.instID[0][0], packet_.hit.geomID[0]);
    const unsigned int triangle = packet_.hit.primID[0];
    unsigned int differs = 0;
    for (int i = 0; i < kLanes; ++i) {
      differs |= (packet_.hit.geomID[i] ^ packet_.hit.geomID[0]) |
                 (packet_.hit.instID[0][i] ^ packet_.hit.instID[0][0]) |
                 (packet_.hit.primID[i] ^ triangle);
    }
    if (differs != 0 || packet_.hit.geomID[0] == kNoGeometry) return false;
    look_at(row, geometry, triangle);

    const float *hx = &rays_.x[ray], *hy = &rays_.y[ray], *hz = &rays_.z[ray];
    const float *lx = &rays_.x_rest[ray], *ly = &rays_.y_rest[ray], *lz = &rays_.z_rest[ray];
    const Eigen::Vector3d axis = axis_;
    alignas(64) double t[kLanes], depth_m[kLanes], facing[kLanes];
    int accepted = 0;
    const auto lane = [&](int i, auto to_plane) {
      const double dx = static_cast<double>(hx[i]) + static_cast<double>(lx[i]);
      const double dy = static_cast<double>(hy[i]) + static_cast<double>(ly[i]);
      const double dz = static_cast<double>(hz[i]) + static_cast<double>(lz[i]);
      const ExactHit hit = to_plane(Eigen::Vector3d(dx, dy, dz));
      t[i] = hit.t_m;
      facing[i] = hit.facing;
      depth_m[i] = hit.t_m * (axis[0] * dx + axis[1] * dy + axis[2] * dz);
      accepted += hit.accepted ? 1 : 0;
    };
    const RowPlane& plane = plane_;
    const Eigen::Vector3d o = frame_.origin_m;
    const double reach_m = frame_.reach_m;
    if (frame_.is_world) {
      for (int i = 0; i < kLanes; ++i)
        lane(i, [&](const Eigen::Vector3d& d) { return exact_hit(plane, o, reach_m, d); });
    } else {
      const Eigen::Matrix3d turn = frame_.mesh_from_world;
      for (int i = 0; i < kLanes; ++i)
        lane(i, [&](const Eigen::Vector3d& d) { return exact_hit(plane, o, reach_m, turn * d); });
    }
    if (accepted != kLanes) return false;
    store_together(row, ray, x, t, depth_m, facing[0], out);
    return true;
  }

  void store_together(const PreparedRays::Row& row, std::size_t ray, int x, const double* t,
                      const double* depth_m, double facing, const TruthRow& out) const {
    if (out.depth_m) {
      for (int i = 0; i < kLanes; ++i) out.depth_m[x + i] = static_cast<float>(depth_m[i]);
    }
    if (out.normal) {
      const Eigen::Vector3f n =
          facing > 0 ? Eigen::Vector3f(-plane_.normal_in_camera) : plane_.normal_in_camera;
      std::fill_n(out.normal + x, kLanes, n);  // one side of one plane: all rays share an origin
    }
    if (out.instance) std::fill_n(out.instance + x, kLanes, impl_.geometries[plane_.geometry].id);
    if (out.part) std::fill_n(out.part + x, kLanes, plane_.plane.part);
    if (!out.position_m) return;
    for (int i = 0; i < kLanes; ++i) {
      const Eigen::Vector3d d = direction(ray + static_cast<std::size_t>(i));
      out.position_m[x + i] = (row.origin_m + t[i] * d + impl_.centre_m).cast<float>();
    }
  }

  Eigen::Vector3d direction(std::size_t ray) const {
    return {static_cast<double>(rays_.x[ray]) + static_cast<double>(rays_.x_rest[ray]),
            static_cast<double>(rays_.y[ray]) + static_cast<double>(rays_.y_rest[ray]),
            static_cast<double>(rays_.z[ray]) + static_cast<double>(rays_.z_rest[ray])};
  }

  void resolve(const PreparedRays::Row& row, std::size_t ray, int lane, int x,
               const TruthRow& out) {
    const Eigen::Vector3d d = direction(ray);
    look_at(row, geometry_index(packet_.hit.instID[0][lane], packet_.hit.geomID[lane]),
            packet_.hit.primID[lane]);
    ExactHit hit = meet(d);
    if (!hit.accepted && !cast_on(row, d, packet_.ray.tfar[lane], hit)) return;

    if (out.depth_m) out.depth_m[x] = static_cast<float>(hit.t_m * axis_.dot(d));
    if (out.normal) {
      out.normal[x] =
          hit.facing > 0 ? Eigen::Vector3f(-plane_.normal_in_camera) : plane_.normal_in_camera;
    }
    if (out.position_m)
      out.position_m[x] = (row.origin_m + hit.t_m * d + impl_.centre_m).cast<float>();
    if (out.instance) out.instance[x] = impl_.geometries[plane_.geometry].id;
    if (out.part) out.part[x] = plane_.plane.part;
  }

  const RayScene::Impl& impl_;
  const PreparedRays& rays_;
  RTCIntersectContext context_;
  HitPacket packet_;
  LaneMask mask_;
  RowFrame frame_;                                   ///< of the last hit's geometry in this row
  RowPlane plane_;                                   ///< of the last hit in this row
  Eigen::Vector3d axis_ = Eigen::Vector3d::UnitZ();  ///< optical axis in the world
};

}  // namespace

PreparedRays prepare_rays(const RayScene& rays, const TrueView& view) {
  validate(view);
  PreparedRays prepared;
  prepared.width = view.camera.width_px;
  prepared.height = view.camera.height_px;
  prepared.stride = (prepared.width + kLanes - 1) / kLanes * kLanes;
  const std::size_t count =
      static_cast<std::size_t>(prepared.stride) * static_cast<std::size_t>(prepared.height);
  for (auto* values : {&prepared.x, &prepared.y, &prepared.z, &prepared.x_rest, &prepared.y_rest,
                       &prepared.z_rest}) {
    values->assign(count, 0.0F);
  }
  prepared.rows.resize(static_cast<std::size_t>(prepared.height));

  // At 89.99 degrees of incidence depth changes 6000 times as fast as the direction: 1e-7 px keeps
  // 1e-6.
  const auto directions = lens_directions(view.camera, 0, 0, prepared.width, prepared.height, 1e-7);
  tbb::parallel_for(0, prepared.height, [&](int y) {
    const Pose camera_from_world = pose_at_row(view, y);
    PreparedRays::Row& row = prepared.rows[static_cast<std::size_t>(y)];
    row.camera_from_world = camera_from_world.rotation.toRotationMatrix();
    row.origin_m = centre_in_world_m(camera_from_world) - rays.impl().centre_m;
    row.time = ray_time(rays.impl(), time_at_row(view, y));
    const Eigen::Matrix3d world_from_camera = row.camera_from_world.transpose();
    for (int x = 0; x < prepared.width; ++x) {
      const std::size_t from =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(prepared.width) +
          static_cast<std::size_t>(x);
      const std::size_t to =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(prepared.stride) +
          static_cast<std::size_t>(x);
      const Eigen::Vector3d d = world_from_camera * directions[from];
      prepared.x[to] = static_cast<float>(d.x());
      prepared.y[to] = static_cast<float>(d.y());
      prepared.z[to] = static_cast<float>(d.z());
      prepared.x_rest[to] = static_cast<float>(d.x() - static_cast<double>(prepared.x[to]));
      prepared.y_rest[to] = static_cast<float>(d.y() - static_cast<double>(prepared.y[to]));
      prepared.z_rest[to] = static_cast<float>(d.z() - static_cast<double>(prepared.z[to]));
    }
  });
  return prepared;
}

TruthImages render_truth(const RayScene& rays, const Scene& scene, const TrueView& view,
                         const TruthNeeds& needs, const TruthConfig& config) {
  return render_truth(rays, scene, view, prepare_rays(rays, view), needs, config);
}

TruthImages render_truth(const RayScene& rays, const Scene& scene, const TrueView& view,
                         const PreparedRays& prepared, const TruthNeeds& needs,
                         const TruthConfig& config) {
  const int width = prepared.width, height = prepared.height;
  if (width != view.camera.width_px || height != view.camera.height_px) {
    throw std::invalid_argument(
        "truth pass: the prepared rays are of another image size than the view");
  }
  if (scene.instances.size() != rays.impl().geometries.size()) {
    throw std::invalid_argument("truth pass: the scene \"" + scene.name +
                                "\" is not the one of the rays");
  }
  TruthImages truth;
  Image<std::int32_t> instance;
  const bool needs_ids = needs.instance || needs.coverage || needs.visibility;
  // Fresh memory costs more to touch than to fill, so the images are made side by side.
  tbb::parallel_invoke(
      [&] {
        if (needs.normal)
          truth.normal = Image<Eigen::Vector3f>(width, height, Eigen::Vector3f::Zero());
      },
      [&] {
        if (needs.depth) truth.depth_m = Image<float>(width, height, kNoDepth);
        if (needs_ids) instance = Image<std::int32_t>(width, height, -1);
      },
      [&] {
        if (!needs.position) return;
        truth.position_m =
            Image<Eigen::Vector3f>(width, height, Eigen::Vector3f::Constant(kNoDepth));
      },
      [&] {
        if (needs.part) truth.part = Image<std::uint16_t>(width, height, std::uint16_t{65535});
      });

  tbb::parallel_for(
      tbb::blocked_range<int>(0, height, 8), [&](const tbb::blocked_range<int>& range) {
        const FlushDenormals flush;
        RowTracer trace(rays.impl(), prepared);
        for (int y = range.begin(); y < range.end(); ++y) {
          trace(y, {row_of(truth.depth_m, y), row_of(truth.normal, y), row_of(truth.position_m, y),
                    row_of(instance, y), row_of(truth.part, y)});
        }
      });

  if (needs.coverage) {
    Image<std::uint8_t> is_specimen(width, height);
    std::vector<std::int32_t> specimens;
    for (const RayGeometry& g : rays.impl().geometries) {
      if (g.is_specimen) specimens.push_back(g.id);
    }
    std::sort(specimens.begin(), specimens.end());
    std::transform(instance.begin(), instance.end(), is_specimen.begin(), [&](std::int32_t id) {
      return std::uint8_t{std::binary_search(specimens.begin(), specimens.end(), id)};
    });
    truth.specimen_coverage =
        specimen_coverage(rays, prepared, is_specimen, config.coverage_samples);
  }
  if (needs.shares) truth.shares = specimen_shares(rays, prepared, config.share_samples);
  if (needs.keypoints) truth.keypoints = view_keypoints(rays, scene, view);
  if (needs.leaf_area) truth.leaf_areas = view_leaf_areas(rays, scene, view);
  if (needs.visibility) add_visibility(rays, view, prepared, instance, truth);
  if (needs.instance) truth.instance = std::move(instance);
  return truth;
}

}  // namespace cousin
