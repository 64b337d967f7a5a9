#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scenes/row/scene_row.h"
#include "scenes/seeds/variation.h"
#include "sim/config/fields.h"
#include "sim/geometry/user_mesh.h"
#include "sim/truth/scene.h"
#include "sim/types/mesh.h"
#include "sim/types/rng.h"

namespace cousin {

enum class SizeSpread { literature, paper };

struct SeedsSceneConfig {
  std::string cultivar = "zhengdan958";  ///< one of cultivar_names(), or "mixed": all six in turn
  int seeds = 10;
  SizeSpread spread = SizeSpread::literature;  ///< "paper": the spread its R^2 and RMSE imply
  std::string specimen;  ///< "" = grown by us; "mesh:FILE" = a user's watertight mesh in metres
  double specimen_scale = 1;      ///< metres per unit of that mesh
  double specimen_variation = 0;  ///< how much each differs from that mesh (mesh_variation.h)
  /// "apart": none touches another; "heap": poured on one another.
  std::string placing = "apart";
  /// Of a heap: share of a seed's image that others leave free, mean over seeds and views.
  double visible_fraction = 0.7;
  bool markers = true;     ///< false: the paper's plain board
  double print_scale = 1;  ///< of the print over what it should be; 0.97: printed "to fit"
  /// How much deeper the middle of the sheet lies than two of its edges: a sheet that is bent.
  double sheet_sag_m = 0;
  std::string background = "green";  ///< what the board lies on: green, white, black or wood
  bool gloss = true;    ///< false: seeds without their coat, to see what its mirrors cost
  bool sphere = false;  ///< a 22 mm matt speckled sphere instead of the seeds
  int views = 60;       ///< spread over three rings
  std::vector<double> ring_elevations_rad = {0.26, 0.61, 1.05};
  std::vector<double> ring_distances_m = {0.75, 0.55, 0.33};  ///< mean camera distance of each ring
  double distance_min_m = 0.30;  ///< hand-held distances wander within these
  double distance_max_m = 0.80;
  double view_jitter = 0.05;     ///< relative wander of distance, radians of elevation and aim
  std::string light = "window";  ///< window (indoor daylight), lamps, sun
  std::string environment;       ///< "" = `light`; else an OpenEXR all around, in its place
  double environment_scale = 1;  ///< scene's radiance per unit of that picture
  std::string rig = "phone_video_720p";
  SeedVariation vary;  ///< of the lot and the light
};
Fields fields(SeedsSceneConfig& config);
void validate(const SeedsSceneConfig& config);

std::vector<std::string> cultivar_names();

/// A seed in its own frame: closed, watertight, centroid at the origin, with vertex colours made in
/// 3D, normals, traits and keypoints. Deterministic in (cultivar, spread, rng).
struct SeedModel {
  ObjectModel model;
  std::vector<TrueTrait> traits;  ///< length, width, height (m), area (m2), volume (m3), mass (kg)
  double mass_kg = 0;
};
SeedModel make_seed(const std::string& cultivar, SizeSpread spread, Rng rng,
                    const SeedVariation& vary = {});

/// The whole setting: board, screen, seeds dropped and settled, lights, camera path. In a heap each
/// specimen has two traits more: visible_fraction, of its own image, mean over the views; touching,
/// the number of others that it touches.
/// @param user_mesh  the specimen's mesh when config.specimen names a file (already read and
/// scaled)
/// @param environment  when config.environment names a file (already read and scaled)
/// @throws std::runtime_error if seeds cannot be settled, a heap cannot be as visible as asked for,
/// or the mesh is not watertight.
Scene build_seeds_scene(const SeedsSceneConfig& config, Rng rng,
                        const std::optional<UserMesh>& user_mesh = {},
                        const std::optional<Environment>& environment = {});

// ---- Its row -----------------------------------------------------------------------------------

Scene build_scene(const SeedsSceneConfig& config, const SceneBuild& which);
std::vector<std::string> specimen_categories(const SeedsSceneConfig& config);
std::vector<UserFile> user_files(const SeedsSceneConfig& config);
PhysicsUse physics_of(const SeedsSceneConfig& config);
void check_movable(const SeedsSceneConfig& config, const CousinDistance& distance);
/// The file of the user's own mesh; "" if the scene grows its specimens. @throws
/// std::invalid_argument if `specimen` is something else than "mesh:FILE".
std::string specimen_file(const SeedsSceneConfig& config);
const SceneRow& seeds_row();
const SceneRow& row_of(const SeedsSceneConfig& config);

}  // namespace cousin
