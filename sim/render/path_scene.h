#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "sim/render/path_material.h"
#include "sim/render/path_tracer.h"
#include "sim/render/ray_scene_impl.h"
#include "sim/render/scene_lights.h"

namespace cousin {

/// What light needs of a model, in the model's frame. Private to sim/render.
struct PathModel {
  std::vector<Eigen::Vector3f> vertex_albedo;   ///< or empty
  std::vector<Eigen::Vector3f> vertex_normals;  ///< or empty = flat
};

struct PathInstance {
  const PathMaterial* material = nullptr;
  std::vector<const PathMaterial*> part_materials;  ///< or empty: `material` everywhere
  const PathModel* model = nullptr;
  bool is_open = false;
  bool moves = false;  ///< its pose depends on the ray's time
  Eigen::Matrix3f world_from_object;
  Eigen::Vector3f origin_m;  ///< of the object, world less RayScene's centre
  float size_m = 0;          ///< of its bounds' diagonal
};

/// A point where a path met a surface.
struct PathHit {
  Eigen::Vector3f position_m;
  Eigen::Vector3f face_normal;  ///< unit, towards where the ray came from
  float offset_m = 0;           ///< how far off the face a ray must start
  Eigen::Matrix3f frame;        ///< tangent, bitangent, shading normal: world from local
  PathBsdf bsdf;
  bool is_dark = false;  ///< the back of a closed opaque surface
};

struct PathTracer::Impl {
  const RayScene::Impl* rays = nullptr;
  SceneLights lights;
  std::vector<PathMaterial> materials;
  std::vector<PathModel> models;
  std::vector<PathInstance> instances;
  bool has_water = false;  ///< a material is clear

  /// What Embree reports of a hit, and the ray's unit direction and time.
  PathHit hit(unsigned int inst_id, unsigned int geom_id, unsigned int prim_id, float u, float v,
              const Eigen::Vector3f& direction, float time) const;
};

}  // namespace cousin
