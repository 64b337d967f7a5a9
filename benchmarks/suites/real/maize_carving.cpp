#include "benchmarks/suites/real/maize_carving.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "benchmarks/report/pictures.h"
#include "perception/carve/visual_hull.h"
#include "sim/dataset/import.h"
#include "sim/geometry/mesh_io.h"
#include "sim/imaging/image_io.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScene = "maize";
constexpr const char* kShown = "plant_2";  ///< on the page: the largest of the three
constexpr int kShown_mm = 8;
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

Cloud cloud_of(const std::vector<Eigen::Vector3d>& centres_m, Rgb8 color) {
  Cloud cloud;
  for (const Eigen::Vector3d& centre : centres_m)
    cloud.push_back({centre.cast<float>(), Eigen::Vector3f::Zero(), color, 0});
  return cloud;
}

/// A silhouette with the carved voxels drawn on it.
Image<Rgb8> overlay(const CarveView& view, const Carving& carving) {
  constexpr Rgb8 kNothing = {255, 255, 255}, kBoth = {86, 156, 70}, kMissed = {213, 94, 0},
                 kBeyond = {140, 190, 235};
  const Image<std::uint8_t>& mask = view.mask;
  Image<std::uint8_t> hull(mask.width(), mask.height());
  for (const Eigen::Vector3d& centre : carving.centres_m) {
    const Eigen::Vector3d point = view.camera_from_world * centre;
    const auto pixel = project(view.camera, point);
    if (!pixel) continue;
    const double half = 0.5 * view.camera.fx_px * carving.voxel_m / point.z();
    const auto at = [](double v) { return static_cast<int>(std::lround(v)); };
    for (int y = at(pixel->y() - half); y <= at(pixel->y() + half); ++y) {
      for (int x = at(pixel->x() - half); x <= at(pixel->x() + half); ++x) {
        if (hull.contains(x, y)) hull(x, y) = 1;
      }
    }
  }
  Image<Rgb8> picture(mask.width(), mask.height(), kNothing);
  int left = mask.width(), top = mask.height(), right = 0, bottom = 0;
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      const bool plant = mask(x, y) != 0, carved = hull(x, y) != 0;
      if (!plant && !carved) continue;
      picture(x, y) = plant ? (carved ? kBoth : kMissed) : kBeyond;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = std::max(bottom, y);
    }
  }
  constexpr int kMargin_px = 30, kMost_px = 700;
  return shrunk(cropped(picture, left - kMargin_px, top - kMargin_px, right - left + 2 * kMargin_px,
                        bottom - top + 2 * kMargin_px),
                kMost_px);
}

/// Adds the pictures and shapes of one carving to the page.
void show(const std::string& plant, const Method& method, const std::vector<CarveView>& views,
          const Carving& carving, const VoxelCarving& published, const fs::path& out,
          RealPart& part) {
  const std::string mm = std::to_string(std::lround(1000 * carving.voxel_m)) + " mm";
  std::vector<Image<Rgb8>> pictures;
  for (const std::size_t i : {std::size_t{0}, views.size() / 4})
    pictures.push_back(overlay(views.at(i), carving));
  const Image<Rgb8> picture = side_by_side(pictures, 24);
  write_png(out / (plant + "_" + method.file + ".png"), picture);
  part.images.push_back({"Maize " + plant + ", " + method.name,
                         "Two of its silhouettes with the voxels of " + mm +
                             " carved from all of them. Green: plant and voxels; orange: plant "
                             "without voxels; blue: voxels beside the plant.",
                         encode_png(picture)});
  part.shapes.push_back(
      cloud_shape("Maize " + plant + ", " + method.name,
                  "Our voxels, " + mm + ", " + std::to_string(carving.centres_m.size()) + ".",
                  cloud_of(carving.centres_m, {90, 160, 70})));
  if (method.tolerated_misses > 0) {
    part.shapes.push_back(cloud_shape("Maize " + plant + ", published",
                                      "The voxels of OpenAlea phenomenal, " + mm + ", " +
                                          std::to_string(published.centres_m.size()) + ".",
                                      cloud_of(published.centres_m, {200, 150, 60})));
  }
}

struct Comparison {
  Carving carving;
  std::vector<ScoreRow> rows;
};
Comparison compare(const std::string& case_name, const Method& method,
                   const std::vector<CarveView>& views, const VoxelCarving& published) {
  CarveConfig config = on_grid_of(published);
  config.tolerated_misses = method.tolerated_misses;
  const StageClock clock("carve");
  Carving carving = carve_visual_hull(views, config);
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
  const auto share = [](std::int64_t a, std::int64_t b) {
    return b == 0 ? ScoreRow::kNone : static_cast<double>(a) / static_cast<double>(b);
  };
  std::vector<ScoreRow> rows = {
      row("iou_with_published", share(common, n_ours + n_theirs - common), "1", n_theirs),
      row("volume_over_published", share(n_ours, n_theirs), "1", n_theirs),
      row("share_of_published_found", share(common, n_theirs), "1", n_theirs),
      row("share_of_ours_published", share(common, n_ours), "1", n_ours),
      row("voxels.ours", static_cast<double>(n_ours), "1", n_ours),
      row("voxels.published", static_cast<double>(n_theirs), "1", n_theirs),
      row("seconds.carve", seconds, "s", static_cast<std::int64_t>(views.size()))};
  return {std::move(carving), std::move(rows)};
}

}  // namespace

RealPart maize_carving(const fs::path& real_data, const fs::path& out, bool quick) {
  RealPart part;
  std::vector<ScoreRow>& rows = part.rows;
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
        Comparison compared = compare(case_name, method, views, published);
        for (ScoreRow& row : compared.rows) rows.push_back(std::move(row));
        write_ply(cloud_file, cloud_of(compared.carving.centres_m, {90, 160, 70}));
        if (plant == kShown && voxel_mm == kShown_mm)
          show(plant, method, views, compared.carving, published, out, part);
      }
    }
  }
  return part;
}

}  // namespace cousin
