#include "benchmarks/loop/views_report.h"

#include <algorithm>
#include <string>
#include <vector>

#include "perception/splats/splat_ply.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/seam_io.h"
#include "sim/geometry/measure.h"
#include "sim/truth/specimens.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

std::vector<ReportPicture> pictures_of(const fs::path& folder) {
  std::vector<fs::path> files;
  if (fs::is_directory(folder)) {
    for (const auto& entry : fs::directory_iterator(folder)) {
      if (entry.path().extension() == ".png") files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  std::vector<ReportPicture> pictures;
  for (const fs::path& file : files) {
    const std::string bytes = read_file(file);
    pictures.push_back({"view " + file.stem().string(),
                        "Left the photograph, right the Gaussians from the same place.",
                        std::vector<std::uint8_t>(bytes.begin(), bytes.end())});
  }
  return pictures;
}

}  // namespace

ReportScene views_report_scene(const fs::path& estimate_dir, const SceneTruth& truth) {
  ReportScene scene;
  scene.name = estimate_dir.filename().string();
  scene.pictures = pictures_of(estimate_dir / "pictures");
  if (fs::exists(estimate_dir / "splats.ply"))
    scene.splats = without_directions(read_splat_ply(estimate_dir / "splats.ply").model);
  if (fs::exists(estimate_dir / "cloud.ply")) scene.cloud = read_cloud(estimate_dir);
  std::vector<Mesh> measured, specimens, all;
  if (fs::exists(estimate_dir / "surfaces.json")) {
    for (Surface& surface : read_surfaces(estimate_dir)) {
      if (surface.status == SurfaceStatus::ok) measured.push_back(std::move(surface.mesh));
    }
  }
  scene.measured = merged(measured);
  for (const Instance& instance : truth.scene.instances) {
    all.push_back(mesh_in_world(truth.scene, instance));
    if (is_of_specimen(instance)) specimens.push_back(all.back());
  }
  scene.truth = merged(specimens.empty() ? all : specimens);
  return scene;
}

}  // namespace cousin
