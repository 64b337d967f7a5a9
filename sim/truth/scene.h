#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "sim/types/board.h"
#include "sim/types/image.h"
#include "sim/types/mesh.h"
#include "sim/types/pose.h"

namespace cousin {

/// How light leaves a surface: a diffuse base under a smooth-to-rough dielectric coat (GGX).
struct Material {
  std::string name;
  Rgbf albedo{
      0.5F, 0.5F,
      0.5F};  ///< diffuse reflectance in [0, 1]; times the vertex albedo if the model has one
  double ior = 1.5;                      ///< of the coat; 1 = no coat, purely diffuse
  double roughness = 0.5;                ///< GGX alpha = roughness^2, in [0.05, 1]
  std::optional<SeedBoard> print;        ///< face z = 0 of the object carries this print
  Rgbf ink_albedo{0.03F, 0.03F, 0.03F};  ///< where the print is black
};

/// A point with a meaning on an object, for keypoint truth.
struct Keypoint {
  std::string name;
  Eigen::Vector3d in_object_m;
};

/// An exact measurement of a specimen, from its mesh.
struct TrueTrait {
  std::string name;  ///< length, width, height, area, volume, ...
  std::string unit;  ///< m, m2, m3, kg
  double value = 0;
};

/// A shape that instances share, in its own frame.
struct ObjectModel {
  std::string name;
  Mesh mesh;
  std::vector<Rgbf> vertex_albedo;  ///< one for each vertex, or empty
  std::vector<Eigen::Vector3f>
      vertex_normals;  ///< unit, for shading; empty = flat. Geometry truth never uses them
  std::vector<std::uint16_t> triangle_part;  ///< index into part_names for each triangle, or empty
  std::vector<std::string> part_names;
  std::vector<Keypoint> keypoints;
};

struct TimedPose {
  double time_s = 0;
  Pose world_from_object;
};

struct Instance {
  int id = 0;  ///< unique; written to instance images; background is -1
  std::string name;
  std::string category;  ///< cultivar for specimens; "board", "screen", "sphere" for the setting
  bool is_specimen = false;  ///< scored; its traits are filled
  int model = 0;             ///< index into Scene::models
  int material = 0;          ///< index into Scene::materials
  Pose world_from_object;
  std::vector<TimedPose> motion;  ///< sorted by time; empty = static at world_from_object
  double mass_kg = 0;
  std::vector<TrueTrait> traits;
};

/// Directional light with an angular size, as seen from the scene.
struct Sun {
  Eigen::Vector3d to_sun = Eigen::Vector3d::UnitZ();  ///< unit
  double angular_radius_rad = 0.00465;
  Rgbf irradiance;  ///< on a surface facing it
};
/// Upper hemisphere: radiance goes from `horizon` to `zenith` with the sine of the elevation;
/// below, `ground`.
struct Sky {
  Rgbf zenith, horizon, ground;
};
/// One-sided rectangle that emits `radiance` on the side of axis_u x axis_v.
struct Lamp {
  Eigen::Vector3d centre_in_world_m;
  Eigen::Vector3d axis_u_m;  ///< from the centre to the middle of an edge
  Eigen::Vector3d axis_v_m;
  Rgbf radiance;
};
using Light = std::variant<Sun, Sky, Lamp>;

/// Where the rig is at one exposure. For a rolling shutter the rig moves from begin to end during
/// readout.
struct View {
  double time_s = 0;
  Pose rig_from_world;      ///< when the first row is read
  Pose rig_from_world_end;  ///< when the last row is read
};

/// All that is known of a scene; a plain value. World: right-handed, z up, metres.
struct Scene {
  std::string name;
  std::string rig;             ///< name of a sensor preset
  std::string board = "none";  ///< markers, plain, none
  std::vector<ObjectModel> models;
  std::vector<Material> materials;
  std::vector<Instance> instances;
  std::vector<Light> lights;
  std::vector<View> views;
};

/// World pose at a time: `world_from_object` if static, else interpolated; held before the first
/// and after the last.
Pose world_from_object(const Instance& instance, double time_s);

/// The model's mesh in the world at a time.
Mesh mesh_in_world(const Scene& scene, const Instance& instance, double time_s = 0);

/// Checks indices, unique ids, finite numbers, sizes of per-vertex arrays.
/// @throws std::invalid_argument naming the instance or model.
void validate(const Scene& scene);

}  // namespace cousin
