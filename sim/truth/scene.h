#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "sim/types/board.h"
#include "sim/types/camera.h"
#include "sim/types/image.h"
#include "sim/types/mesh.h"
#include "sim/types/pose.h"

namespace cousin {

/// What happens to light at a surface.
enum class SurfaceKind {
  coated,     ///< opaque diffuse base under a dielectric coat: fruit skin, soil, paper, plastic
  leaf,       ///< thin sheet of no thickness: both sides reflect and transmit diffusely under a wax
  conductor,  ///< rough metal; `albedo` is its reflectance at normal incidence [Schlick 1994]
  glass,      ///< rough dielectric with another medium inside: closed surfaces only
  clear,      ///< the same, smooth: water (ior 1.333)
};

/// Fractal value noise in object coordinates: albedo goes from `albedo` to `other_albedo` with it.
struct NoiseTexture {
  Rgbf other_albedo;  ///< as it is, whatever the vertex albedo: dust and stains cover what is below
  double scale_m = 0.01;  ///< size of the largest features
  int octaves = 4;        ///< 1..12, each half the size and half the strength
};

/// The same for infrared imagers, where a surface has another texture there than noise gives.
struct InfraredTexture {
  float other_albedo = 0;
  double scale_m = 0.01;  ///< size of the largest features
  int octaves = 4;        ///< 1..12
};

/// How light leaves a surface. Colours are reflectances in [0, 1], linear sRGB; microfacets are GGX
/// with alpha = roughness^2.
struct Material {
  std::string name;
  SurfaceKind kind = SurfaceKind::coated;
  Rgbf albedo{
      0.5F, 0.5F,
      0.5F};  ///< diffuse reflectance of the base; times the vertex albedo if the model has one
  Rgbf transmittance{0, 0, 0};      ///< leaf: diffuse share let through; albedo + this <= 1
  std::optional<Rgbf> back_albedo;  ///< leaf: of the clockwise side; as the front if absent
  /// Coated, closed bodies: between turns of light in the flesh below the skin, 1 / reduced
  /// scattering coefficient; zero = it leaves where it came. Seen by the path tracer alone; others
  /// take the body as diffuse of the same albedo.
  Rgbf mean_free_path_m{0, 0, 0};
  double ior = 1.5;                ///< of coat, wax, glass or water; 1 = no coat, purely diffuse
  double roughness = 0.5;          ///< in [0.05, 1]; clear has none
  std::optional<SeedBoard> print;  ///< face z = 0 of the object carries this print
  double print_bend_m = 0;         ///< corners of that face lie within so much of z = 0
  Rgbf ink_albedo{0.03F, 0.03F, 0.03F};  ///< where the print is black
  std::optional<NoiseTexture> noise;
  // At 850 nm, for infrared imagers; leaves are bright there [Jacquemoud & Baret 1990].
  float infrared_albedo = 0.5F;
  float infrared_transmittance = 0;
  /// From infrared_albedo to its other. Without one, `noise` varies infrared_albedo by the ratio of
  /// its two albedos.
  std::optional<InfraredTexture> infrared_noise;
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

/// A word about a specimen that people sort by.
struct TrueLabel {
  std::string name;   ///< variety, maturity, ...
  std::string value;  ///< benihoppe; low, medium, high; ...
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
  /// Of specimens what detectors are to tell apart: the maturity of fruits, else the cultivar.
  /// "board", "screen", "sphere" for the setting.
  std::string category;
  bool is_specimen = false;  ///< scored; its traits are filled
  int model = 0;             ///< index into Scene::models
  int material = 0;          ///< index into Scene::materials
  /// Index into Scene::materials for each of the model's parts: a plant's stems are not its leaves.
  /// None is clear. Empty = `material` everywhere.
  std::vector<int> part_materials;
  Pose world_from_object;
  std::vector<TimedPose> motion;  ///< sorted by time; empty = static at world_from_object
  double mass_kg = 0;
  std::vector<TrueTrait> traits;
  std::vector<TrueLabel> labels;  ///< of a specimen, sorted by name, each once
  /// Organs that move on their own are instances of their own. This is the id of the specimen that
  /// this one is an organ of, -1 = none: all truth counts its surface as that specimen's. An organ
  /// is no specimen, has no organs, traits or labels, and its model has its specimen's part names.
  /// At rest its axes are its specimen's.
  int part_of = -1;
  /// Of a specimen with organs: for each keypoint of its model the id of what carries it, itself or
  /// one of its organs, in whose axes `in_object_m` then is. Empty = itself.
  std::vector<int> keypoint_carriers;
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
/// Cloudless sky and, if asked, the sun's disk in it, as a function of turbidity [Preetham, Shirley
/// & Smits 1999]. The lower hemisphere reflects `ground_albedo` of the horizontal irradiance.
struct ClearSky {
  Eigen::Vector3d to_sun = Eigen::Vector3d::UnitZ();  ///< unit, z >= 0
  double turbidity = 3;                               ///< 1.7 (clean) .. 10 (hazy)
  bool has_sun = true;
  double angular_radius_rad = 0.00465;
  double scale = 1;  ///< radiance per kcd/m2 of luminance
  Rgbf ground_albedo{0.2F, 0.2F, 0.2F};
};
/// Point source that throws a picture: a spot light, or a depth camera's dot projector. Axes as a
/// camera's; a direction outside the picture gets nothing.
struct Projector {
  Pose world_from_projector;
  Camera lens;            ///< its picture's; pixels as for a camera
  Image<Rgbf> intensity;  ///< radiant intensity of each pixel, per steradian; bilinear between
};
/// A picture all around: equirectangular, row 0 at the zenith, column 0 at azimuth -pi about +z,
/// azimuth growing towards +y.
struct Environment {
  Image<Rgbf> radiance;
};
using Light = std::variant<Sun, Sky, Lamp, ClearSky, Projector, Environment>;

/// Where the rig is at one exposure. For a rolling shutter the rig moves from begin to end during
/// readout.
struct View {
  double time_s = 0;
  Pose rig_from_world;                                         ///< when the first row is read
  Pose rig_from_world_end;                                     ///< when the last row is read
  Eigen::Vector3d focus_in_world_m = Eigen::Vector3d::Zero();  ///< what an autofocus finds
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

/// Checks everything but shapes: indices, unique ids, finite numbers, sizes of per-vertex arrays,
/// materials, lights, views (scene_check.h has the parts). Triangles may have no area.
/// @throws std::invalid_argument naming the model, material, instance, light or view, the value and
/// the limit.
void validate(const Scene& scene);

}  // namespace cousin
