#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "benchmarks/loop/simulate.h"
#include "perception/pipelines/seeds.h"
#include "perception/splats/splat_model.h"
#include "sim/types/mesh.h"

namespace cousin {

/// A picture for the report.
struct ReportPicture {
  std::string name;
  std::string caption;
  std::vector<std::uint8_t> file;  ///< the bytes of a PNG or JPEG file
};

/// What a report shows of one scene.
struct ReportScene {
  std::string name;  ///< letters, digits, . _ -; the first one is no dot
  std::vector<ReportPicture> pictures;
  Cloud cloud;
  Mesh measured;      ///< all fitted surfaces, in the world
  Mesh truth;         ///< all true surfaces, in the world
  SplatModel splats;  ///< trained Gaussians, of spherical harmonics the first alone
};

/// Up to three of the scene's images, two of them again with the measured outlines drawn in, and
/// the shapes for the 3D view.
ReportScene report_scene(const std::string& name, const SimulatedRun& run,
                         const Estimate& estimate);

/// The same in every direction: of spherical harmonics the first alone.
SplatModel without_directions(SplatModel model);

/// FOLDER/NAME/: scene.json, the pictures, cloud.ply, measured.ply, truth.ply, splats.ply. It is
/// written beside its name and takes the place of an earlier one only when whole.
/// @throws std::invalid_argument naming a name that cannot be a folder's.
void write_report_scene(const std::filesystem::path& folder, const ReportScene& scene);

using WantedScene = std::function<bool(const std::string& name)>;

/// The scenes below a folder, by name, all or those that are wanted; a folder that does not exist
/// has none. A folder without scene.json is no scene.
/// @throws std::runtime_error naming the file and what is wrong.
std::vector<ReportScene> read_report_scenes(const std::filesystem::path& folder,
                                            const WantedScene& wanted = {});

}  // namespace cousin
