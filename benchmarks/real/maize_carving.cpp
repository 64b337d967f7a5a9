#include "benchmarks/real/maize_carving.h"

#include <array>
#include <cmath>
#include <set>

#include "benchmarks/real/real_rows.h"
#include "perception/carve/visual_hull.h"
#include "sim/dataset/import.h"
#include "sim/geometry/mesh_io.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScene = "maize";
constexpr int kMarginVoxels = 4;  ///< around the published plant: ours may be larger

struct Method {
  const char* name;
  const char* file;
  int tolerated_misses;
};
constexpr std::array<Method, 2> kMethods = {
    {{"hull, no miss", "no_miss", 0}, {"hull, one miss", "one_miss", 1}}};

/// The published grid: voxels about the published centres.
CarveConfig on_grid_of(const VoxelCarving& published) {
  Eigen::Vector3d low = published.centres_m.front(), high = low;
  for (const Eigen::Vector3d& centre : published.centres_m) {
    low = low.cwiseMin(centre);
    high = high.cwiseMax(centre);
  }
  const double margin_m = (kMarginVoxels + 0.5) * published.voxel_m;
  CarveConfig config;
  config.voxel_m = published.voxel_m;
  config.low_m = low.array() - margin_m;
  config.high_m = high.array() + margin_m;
  return config;
}

using Cell = std::array<long, 3>;
std::set<Cell> cells_of(const std::vector<Eigen::Vector3d>& centres_m, const CarveConfig& config) {
  std::set<Cell> cells;
  for (const Eigen::Vector3d& centre : centres_m) {
    const Eigen::Vector3d index = (centre - config.low_m) / config.voxel_m;
    cells.insert(
        {std::lround(index.x() - 0.5), std::lround(index.y() - 0.5), std::lround(index.z() - 0.5)});
  }
  return cells;
}

void write_voxels(const fs::path& file, const Carving& carving) {
  Cloud cloud;
  for (const Eigen::Vector3d& centre : carving.centres_m) {
    cloud.push_back({centre.cast<float>(), Eigen::Vector3f::Zero(), Rgb8{90, 160, 70}, 0});
  }
  write_ply(file, cloud);
}

std::vector<ScoreRow> compare(const std::string& case_name, const Method& method,
                              const std::vector<CarveView>& views, const VoxelCarving& published,
                              const fs::path& cloud_file) {
  CarveConfig config = on_grid_of(published);
  config.tolerated_misses = method.tolerated_misses;
  const StageClock clock("carve");
  const Carving carving = carve_visual_hull(views, config);
  const double seconds = clock.finish().wall_s;
  const std::set<Cell> ours = cells_of(carving.centres_m, config);
  const std::set<Cell> theirs = cells_of(published.centres_m, config);
  std::int64_t common = 0;
  for (const Cell& cell : ours) common += theirs.contains(cell) ? 1 : 0;
  const auto n_ours = static_cast<std::int64_t>(ours.size());
  const auto n_theirs = static_cast<std::int64_t>(theirs.size());
  const auto row = [&](const std::string& metric, double value, const std::string& unit,
                       std::int64_t n) {
    return real_row(kScene, case_name, method.name, metric, value, unit, n);
  };
  write_voxels(cloud_file, carving);
  const auto share = [](std::int64_t a, std::int64_t b) {
    return b == 0 ? ScoreRow::kNone : static_cast<double>(a) / static_cast<double>(b);
  };
  return {row("iou_with_published", share(common, n_ours + n_theirs - common), "1", n_theirs),
          row("volume_over_published", share(n_ours, n_theirs), "1", n_theirs),
          row("share_of_published_found", share(common, n_theirs), "1", n_theirs),
          row("share_of_ours_published", share(common, n_ours), "1", n_ours),
          row("voxels.ours", static_cast<double>(n_ours), "1", n_ours),
          row("voxels.published", static_cast<double>(n_theirs), "1", n_theirs),
          row("seconds.carve", seconds, "s", static_cast<std::int64_t>(views.size()))};
}

}  // namespace

std::vector<ScoreRow> maize_carving_rows(const fs::path& real_data, const fs::path& out,
                                         bool quick) {
  std::vector<ScoreRow> rows;
  for (const std::string plant : {"plant_2", "plant_3", "plant_4"}) {
    const fs::path folder = real_data / "multiview/phenomenal_maize_silhouettes" / plant;
    if (!fs::is_directory(folder)) {
      rows.push_back(not_solved_row(kScene, plant, "silhouettes are absent"));
      continue;
    }
    const std::vector<CarveView> views = silhouette_views(import_phenomenal(folder));
    for (const int voxel_mm : quick ? std::vector<int>{16, 8} : std::vector<int>{16, 8, 4}) {
      const std::string case_name = plant + ", " + std::to_string(voxel_mm) + " mm";
      const fs::path file = folder / "voxels" / (std::to_string(voxel_mm) + ".npz");
      if (!fs::exists(file)) {
        rows.push_back(not_solved_row(kScene, case_name, "published voxels are absent"));
        continue;
      }
      const VoxelCarving published = read_phenomenal_voxels(file);
      if (published.centres_m.empty()) {
        rows.push_back(not_solved_row(kScene, case_name, "published carving is empty"));
        continue;
      }
      for (const Method& method : kMethods) {
        const fs::path cloud_file =
            out / (plant + "_" + std::to_string(voxel_mm) + "mm_" + method.file + ".ply");
        for (ScoreRow& row : compare(case_name, method, views, published, cloud_file)) {
          rows.push_back(std::move(row));
        }
      }
    }
  }
  return rows;
}

}  // namespace cousin
