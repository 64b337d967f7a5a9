#pragma once

#include <string>
#include <vector>

#include "scenes/row/scene_row.h"
#include "sim/config/fields.h"
#include "sim/geometry/user_mesh.h"
#include "sim/truth/scene.h"
#include "sim/types/rng.h"

namespace cousin {

/// specimen.toml, which says what each number is. Every value is given there.
struct SpecimenSetting {
  struct Limits {
    double smallest_m = 0, largest_m = 0;
  } limits;
  struct Looks {
    std::vector<double> albedo, leaf_transmittance;
    double ior = 0, roughness = 0, infrared_albedo = 0, infrared_transmittance = 0;
    double density_kg_m3 = 0;
  } looks;
  struct Table {
    double radius_share = 0;
    std::vector<double> albedo, other_albedo;
    double noise_m = 0;
  } table;
  struct LightNumbers {
    double sun_elevation_rad = 0, sun_azimuth_rad = 0, turbidity = 0;
    std::vector<double> overcast;
  } light;
};
Fields fields(SpecimenSetting& config);
const SpecimenSetting& specimen_setting();  ///< of specimen.toml

struct SpecimenSceneConfig {
  std::string mesh;        ///< file of read_user_mesh
  std::string unit = "m";  ///< of the file's numbers: m, dm, cm, mm, um, in, ft; glTF is in metres
  std::string up = "z";    ///< the file's axis that is up: x, y, z, -x, -y or -z
  std::string name = "specimen";  ///< category of the instance
  /// solid: opaque; leaf: a sheet that lets light through; auto: leaf for parts that are named
  /// leaves, and for open meshes without parts.
  std::string surface = "auto";
  bool needs_volume = false;  ///< refuse a mesh that is not watertight
  int views = 24;
  double distance_min = 1.6, distance_max = 2.2;    ///< over the specimen's size
  double pitch_min_rad = 0.1, pitch_max_rad = 0.9;  ///< looking down
  std::string light = "overcast";                   ///< sun or overcast
  std::string rig = "phone_video_720p";
  SpecimenSetting setting = specimen_setting();
};
Fields fields(SpecimenSceneConfig& config);
/// @throws std::invalid_argument naming key, value and limit.
void validate(const SpecimenSceneConfig& config);

/// A user's mesh on a table: moved so that the middle of its box stands above the origin and its
/// lowest vertex on z = 0. Its parts are organs (plant_of_mesh). Traits: height, width_x, width_y
/// (m) of its box; area (m2) of all triangles; leaf_area (m2) if it has leaves; watertight (0 or
/// 1), open_edges, degenerate_triangles; volume (m3) and mass (kg) of a watertight mesh alone.
/// @throws std::runtime_error naming the file, its size and the limits where it is too small or
/// too large, as a plant in millimetres is; and where needs_volume is set, why it has none.
Scene build_specimen_scene(const SpecimenSceneConfig& config, const UserMesh& user, Rng rng);

// ---- Its row -----------------------------------------------------------------------------------

Scene build_scene(const SpecimenSceneConfig& config, const SceneBuild& which);
std::vector<std::string> specimen_categories(const SpecimenSceneConfig& config);
std::vector<UserFile> user_files(const SpecimenSceneConfig& config);
const SceneRow& specimen_row();
const SceneRow& row_of(const SpecimenSceneConfig& config);

}  // namespace cousin
