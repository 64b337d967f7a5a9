#include "benchmarks/suites/seeds/paper_tables.h"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include "benchmarks/loop/score_seeds.h"
#include "benchmarks/score/equal_time.h"
#include "perception/cloud/measure_traits.h"
#include "scenes/seeds/seeds_scene.h"

namespace cousin {
namespace {

constexpr const char* kPaperCultivar = "zhengdan958";  ///< tables 1 and 2 are of it
constexpr const char* kPublished = "published: 3DGS";
constexpr const char* kPublishedStereo = "published: SfM-MVS";

/// Methods that a line can be of, and what they are called.
struct Method {
  const char* name;
  const char* title;
};
constexpr Method kTraitMethods[] = {{kPublished, "published: 3DGS"},
                                    {"splats_paper", "3DGS, the paper's way"},
                                    {kPublishedStereo, "published: SfM-MVS"},
                                    {"paper", "MVS, the paper's way"},
                                    {"splats", "3DGS, ours"},
                                    {"ours", "MVS, ours"}};

bool is_held_out(const ScoreRow& row) { return row.held_out_every > 0; }
bool is_trained(const ScoreRow& row) { return row.suite == kSplatsSuite; }
bool is_published(std::string_view method) { return method.starts_with("published"); }

const ScoreRow* pooled_row(const std::vector<ScoreRow>& rows, const std::string& cultivar,
                           std::string_view method, const std::string& metric) {
  const auto found = std::find_if(rows.begin(), rows.end(), [&](const ScoreRow& row) {
    const bool is_place = is_published(method) ? row.scene == cultivar && row.steps == 0
                                               : row.scene == "pooled" && row.case_name == cultivar;
    return is_trained(row) && is_place && row.method == method && row.metric == metric;
  });
  return found == rows.end() ? nullptr : &*found;
}

/// A cultivar's model after so many steps, of all photographs if there is one, else with some held
/// out; by poses of the board.
const ScoreRow* model_row(const std::vector<ScoreRow>& rows, const std::string& cultivar,
                          std::string_view method, const std::string& metric, int steps) {
  const ScoreRow* best = nullptr;
  for (const ScoreRow& row : rows) {
    if (!is_trained(row) || row.scene != cultivar || row.method != method || row.metric != metric ||
        row.steps != steps || is_posed_by_tracks(row))
      continue;
    if (best == nullptr || (is_held_out(*best) && !is_held_out(row))) best = &row;
  }
  return best;
}

std::vector<int> steps_there(const std::vector<ScoreRow>& rows, const std::string& cultivar,
                             std::string_view method, std::string_view metric) {
  std::vector<int> steps;
  for (const ScoreRow& row : rows) {
    if (is_trained(row) && row.scene == cultivar && row.method == method && row.metric == metric &&
        row.steps > 0 && !is_posed_by_tracks(row))
      steps.push_back(row.steps);
  }
  std::sort(steps.begin(), steps.end());
  steps.erase(std::unique(steps.begin(), steps.end()), steps.end());
  return steps;
}

int last_steps(const std::vector<ScoreRow>& rows, const std::string& cultivar,
               std::string_view method, std::string_view metric) {
  const std::vector<int> steps = steps_there(rows, cultivar, method, metric);
  return steps.empty() ? 0 : steps.back();
}

/// Appends what a table says of one cultivar; published lines alone say nothing of this run.
void add_beside_own(std::vector<std::vector<std::string>> lines, bool has_own, ReportTable& table) {
  if (!has_own) return;
  std::move(lines.begin(), lines.end(), std::back_inserter(table.lines));
}

/// Seconds, points and Gaussians of a reconstruction.
ReportTable reconstructions(const std::vector<ScoreRow>& rows) {
  ReportTable table{
      "Seeds, table 1: times and points, Zhengdan 958",
      "Published: 270 photographs of 1920 x 1080 on an RTX 4060 Ti. Ours: 60 of 1280 x 720 on a "
      "CPU; "
      "seconds of poses are in them, and points are of all that was reconstructed.",
      {"method", "steps", "wall s", "CPU s", "points", "of them on seeds", "Gaussians", "peak MB"},
      {}};
  std::vector<std::vector<std::string>> lines;
  bool has_own = false;
  for (const ScoreRow& row : rows) {
    if (!is_published(row.method) || row.metric != "seconds.reconstruction") continue;
    const auto points = std::find_if(rows.begin(), rows.end(), [&](const ScoreRow& other) {
      return other.method == row.method && other.case_name == row.case_name &&
             other.metric == "reconstruction.points";
    });
    const int steps = row.steps;
    lines.push_back({row.method, steps > 0 ? std::to_string(steps) : "", table_cell(&row, 1, 0), "",
                     table_cell(points == rows.end() ? nullptr : &*points, 1, 0), "", "", ""});
  }
  for (const Method& method : kTraitMethods) {
    if (is_published(method.name)) continue;
    std::vector<int> steps = steps_there(rows, kPaperCultivar, method.name, "seconds.perceive");
    if (steps.empty()) steps = {0};
    for (const int step : steps) {
      const auto cell = [&](const char* metric) {
        return table_cell(model_row(rows, kPaperCultivar, method.name, metric, step), 1, 0);
      };
      const ScoreRow* seconds =
          model_row(rows, kPaperCultivar, method.name, "seconds.perceive", step);
      if (seconds == nullptr) continue;
      has_own = true;
      lines.push_back({method.title, step > 0 ? std::to_string(step) : "",
                       table_cell(seconds->wall_s, 1, 0), table_cell(seconds->cpu_s, 1, 0),
                       cell("reconstruction.points"), cell("cloud.points"), cell("gaussians"),
                       table_cell(seconds->peak_rss_mb, 1, 0)});
    }
  }
  add_beside_own(std::move(lines), has_own, table);
  return table;
}

ReportTable traits(const std::vector<ScoreRow>& rows, const std::string& title,
                   const std::vector<std::string>& cultivars) {
  ReportTable table{title,
                    "R2 about the mean of the measured values, as the paper's. n: seeds measured.",
                    {"cultivar", "method", "n"},
                    {}};
  for (const std::string_view trait : kSeedTraits) {
    const std::string name(trait);
    const bool by_size = name == "area" || name == "volume";
    if (!by_size) table.columns.push_back(name + " R2");
    table.columns.push_back(name + " MAPE %");
    if (!by_size) table.columns.push_back(name + " RMSE mm");
  }
  for (const std::string& cultivar : cultivars) {
    std::vector<std::vector<std::string>> lines;
    bool has_own = false;
    for (const Method& method : kTraitMethods) {
      const ScoreRow* first = pooled_row(rows, cultivar, method.name, "length.rmse");
      if (first == nullptr) continue;
      std::vector<std::string> line = {cultivar, method.title, std::to_string(first->n)};
      for (const std::string_view trait : kSeedTraits) {
        const std::string name(trait);
        const bool by_size = name == "area" || name == "volume";
        const auto cell = [&](const char* statistic, double factor, int decimals) {
          return table_cell(pooled_row(rows, cultivar, method.name, name + statistic), factor,
                            decimals);
        };
        if (!by_size) line.push_back(cell(".r2_paper", 1, 3));
        line.push_back(cell(".mape", 100, 2));
        if (!by_size) line.push_back(cell(".rmse", 1000, 3));
      }
      lines.push_back(std::move(line));
      has_own = has_own || !is_published(method.name);
    }
    add_beside_own(std::move(lines), has_own, table);
  }
  return table;
}

/// What poses and photographs change: trained models of one capture each, by poses of the board and
/// of COLMAP; nothing where all are of the board.
ReportTable sizes_by_poses(const std::vector<ScoreRow>& rows) {
  ReportTable table{
      "Seeds, sizes by photographs and poses, Zhengdan 958",
      "Ten seeds of one capture. Poses: of the board's corners; sfm: COLMAP's own, scaled by the "
      "board's squares, as published; adjusted: COLMAP's tracks with our lens and the board.",
      {"photographs", "poses", "views placed %", "centres off mm", "method", "steps", "wall s",
       "seeds", "length RMSE mm", "width RMSE mm", "height RMSE mm", "length MAPE %", "PSNR dB",
       "PSNR not green dB"},
      {}};
  if (std::none_of(rows.begin(), rows.end(), is_posed_by_tracks)) return table;
  std::vector<const ScoreRow*> lengths;
  for (const ScoreRow& row : rows) {
    if (is_trained(row) && row.scene == kPaperCultivar && !is_held_out(row) &&
        row.metric == "curve.length.rmse" && row.steps > 0)
      lengths.push_back(&row);
  }
  const auto place = [](const ScoreRow* row) {
    return std::tuple(row->views, row->run, row->width_px, row->poses, row->method, row->steps);
  };
  std::stable_sort(lengths.begin(), lengths.end(),
                   [&](const ScoreRow* a, const ScoreRow* b) { return place(a) < place(b); });
  for (const ScoreRow* const of : lengths) {
    const ScoreRow& length = *of;
    const auto row = [&](const char* metric) -> const ScoreRow* {
      const auto found = std::find_if(rows.begin(), rows.end(), [&](const ScoreRow& other) {
        return is_trained(other) && other.scene == length.scene && other.method == length.method &&
               other.case_name == length.case_name && other.metric == metric;
      });
      return found == rows.end() ? nullptr : &*found;
    };
    table.lines.push_back(
        {std::to_string(length.views) + " views " + std::to_string(length.width_px) + "x" +
             std::to_string(length.height_px),
         length.poses.empty() ? "board" : length.poses, table_cell(row("views.posed"), 100, 0),
         table_cell(row("camera.centre_rms"), 1000, 2),
         length.method == "splats" ? "3DGS, ours" : "3DGS, the paper's way",
         std::to_string(length.steps), table_cell(length.wall_s, 1, 0),
         table_cell(row("specimens.found"), 1, 0), table_cell(&length, 1000, 3),
         table_cell(row("curve.width.rmse"), 1000, 3),
         table_cell(row("curve.height.rmse"), 1000, 3),
         table_cell(row("curve.length.mape"), 100, 2), table_cell(row("train.psnr_whole"), 1, 2),
         table_cell(row("train.psnr_object"), 1, 2)});
  }
  return table;
}

ReportTable image_quality(const std::vector<ScoreRow>& rows) {
  ReportTable table{"Seeds, table 3: image quality of the models, views trained on",
                    "Whole photographs, green screen black; \"not green\" is board and grains "
                    "alone. Published: of "
                    "270 photographs of 1920 x 1080 after 30,000 steps.",
                    {"cultivar", "method", "steps", "SSIM", "PSNR dB", "LPIPS", "FLIP",
                     "PSNR not green dB", "photographs"},
                    {}};
  for (const std::string& cultivar : cultivar_names()) {
    std::vector<std::vector<std::string>> lines;
    if (const ScoreRow* psnr = pooled_row(rows, cultivar, kPublished, "psnr")) {
      lines.push_back(
          {cultivar, kPublished, "30000",
           table_cell(pooled_row(rows, cultivar, kPublished, "ssim"), 1, 4), table_cell(psnr, 1, 2),
           table_cell(pooled_row(rows, cultivar, kPublished, "lpips"), 1, 4), "", "", ""});
    }
    const std::size_t published = lines.size();
    for (const Method& method : {Method{"splats_paper", "3DGS, the paper's way"},
                                 Method{"splats_images", "3DGS, ours for images"},
                                 Method{"splats", "3DGS, ours for surfaces"}}) {
      const int steps = last_steps(rows, cultivar, method.name, "train.psnr_whole");
      const auto row = [&](const char* metric) {
        return model_row(rows, cultivar, method.name, metric, steps);
      };
      const ScoreRow* psnr = row("train.psnr_whole");
      if (psnr == nullptr) continue;
      lines.push_back({cultivar, method.title, std::to_string(steps),
                       table_cell(row("train.ssim_whole"), 1, 4), table_cell(psnr, 1, 2),
                       table_cell(row("train.lpips_whole"), 1, 4),
                       table_cell(row("train.flip_whole"), 1, 4),
                       table_cell(row("train.psnr_object"), 1, 2), std::to_string(psnr->n)});
    }
    const auto noise = std::find_if(rows.begin(), rows.end(), [&](const ScoreRow& row) {
      return row.scene == cultivar && row.metric == "noise_floor.psnr_whole";
    });
    if (noise != rows.end()) {
      const auto of_object = std::find_if(rows.begin(), rows.end(), [&](const ScoreRow& row) {
        return row.scene == cultivar && row.metric == "noise_floor.psnr_object";
      });
      lines.push_back({cultivar, "two captures from one place", "", "", table_cell(&*noise, 1, 2),
                       "", "", table_cell(of_object == rows.end() ? nullptr : &*of_object, 1, 2),
                       std::to_string(noise->n)});
    }
    add_beside_own(std::move(lines), lines.size() > published, table);
  }
  return table;
}

/// The object whose area and volume are known; nothing where only the published errors are.
ReportTable sphere(const std::vector<ScoreRow>& rows) {
  ReportTable table{"Seeds, the sphere of 22 mm",
                    "Error of area and volume. Published: of 270 photographs of 1920 x 1080.",
                    {"method", "area %", "volume %"},
                    {}};
  std::vector<std::vector<std::string>> lines;
  bool has_own = false;
  for (const Method& method : kTraitMethods) {
    const ScoreRow* area = pooled_row(rows, kSphere, method.name, "area.mape");
    const ScoreRow* volume = pooled_row(rows, kSphere, method.name, "volume.mape");
    if (area == nullptr && volume == nullptr) continue;
    has_own = has_own || !is_published(method.name);
    lines.push_back({method.title, table_cell(area, 100, 2), table_cell(volume, 100, 2)});
  }
  add_beside_own(std::move(lines), has_own, table);
  return table;
}

/// The three methods at equal photographs.
ReportTable three_methods(const std::vector<ScoreRow>& rows) {
  ReportTable table{
      "Seeds, table 5: PSNR of the three methods, views trained on, dB",
      "Of Instant-NGP ours is trained on and scored at 426 x 240 (published: full size); \"small\" "
      "columns compare all there. 30,000 steps are of one cultivar, with one view in eight held "
      "out.",
      {"cultivar", "published 3DGS 7000", "3DGS 7000", "published 3DGS 30000", "3DGS 30000",
       "ours for images 3000", "published NGP", "NGP 2000, small", "NGP 7000, small",
       "3DGS 7000, small", "ours 3000, small"},
      {}};
  for (const std::string& cultivar : cultivar_names()) {
    const auto published = [&](const char* method, int steps) -> const ScoreRow* {
      for (const ScoreRow& row : rows) {
        if (is_trained(row) && row.scene == cultivar && row.method == method &&
            row.metric == "psnr" && row.steps == steps)
          return &row;
      }
      return nullptr;
    };
    bool has_own = false;
    const auto own = [&](const char* method, const char* metric, int steps) {
      const ScoreRow* row = model_row(rows, cultivar, method, metric, steps);
      has_own = has_own || row != nullptr;
      return table_cell(row, 1, 2);
    };
    if (published(kPublished, 7000) == nullptr) continue;
    constexpr const char* kWhole = "train.psnr_whole";
    constexpr const char* kSmall = "train.psnr_whole_small";
    std::vector<std::string> line = {cultivar,
                                     table_cell(published(kPublished, 7000), 1, 2),
                                     own("splats_paper", kWhole, 7000),
                                     table_cell(published(kPublished, 30000), 1, 2),
                                     own("splats_paper", kWhole, 30000),
                                     own("splats_images", kWhole, 3000),
                                     table_cell(published("published: Instant-NGP", 0), 1, 2),
                                     own("instant-ngp", kSmall, 2000),
                                     own("instant-ngp", kSmall, 7000),
                                     own("splats_paper", kSmall, 7000),
                                     own("splats_images", kSmall, 3000)};
    if (has_own) table.lines.push_back(std::move(line));
  }
  return table;
}

ReportTable paired_tests(const std::vector<ScoreRow>& rows) {
  ReportTable table{
      "Seeds, paired tests of length",
      "Mean absolute error of the first less that of the second, on seeds that both measure; "
      "published is of Zhengdan 958 (n = 50).",
      {"first / second", "seeds of", "n", "difference mm", "t", "p", "relative difference %", "t",
       "p"},
      {}};
  const auto add = [&](const std::string& method, const std::string& scene,
                       const std::string& case_name, const char* absolute, const char* relative) {
    const auto find = [&](const std::string& metric) -> const ScoreRow* {
      for (const ScoreRow& row : rows) {
        if (is_trained(row) && row.method == method && row.scene == scene && row.metric == metric &&
            (case_name.empty() || row.case_name == case_name))
          return &row;
      }
      return nullptr;
    };
    const ScoreRow* t = find("length.paired_t");
    if (t == nullptr) return;
    table.lines.push_back({method, case_name.empty() ? scene : case_name, std::to_string(t->n),
                           table_cell(find(absolute), 1000, 3), table_cell(t, 1, 2),
                           table_cell(find("length.paired_t_p"), 1, 4),
                           table_cell(find(relative), 100, 2),
                           table_cell(find("length.relative_paired_t"), 1, 2),
                           table_cell(find("length.relative_paired_t_p"), 1, 4)});
  };
  add("published: 3DGS/SfM-MVS", kPaperCultivar, "", "length.absolute_difference",
      "length.relative_difference");
  const std::size_t published = table.lines.size();
  for (const char* method :
       {"splats_paper/paper", "splats/splats_paper", "ours/paper", "ours/splats"}) {
    for (const char* group : {kPaperCultivar, "all"})
      add(method, "pooled", group, "length.absolute_difference", "length.relative_difference");
  }
  // Published ones alone say nothing of this run.
  if (table.lines.size() == published) table.lines.clear();
  return table;
}

}  // namespace

std::vector<ReportTable> seeds_paper_tables(const std::vector<ScoreRow>& rows) {
  if (!std::any_of(rows.begin(), rows.end(), is_trained)) return {};
  std::vector<std::string> others = cultivar_names();
  std::erase(others, kPaperCultivar);
  std::vector<ReportTable> tables = {
      reconstructions(rows),
      traits(rows, "Seeds, table 2: sizes, Zhengdan 958", {kPaperCultivar}),
      sizes_by_poses(rows),
      image_quality(rows),
      traits(rows, "Seeds, table 4: sizes, other cultivars", others),
      three_methods(rows),
      paired_tests(rows),
      sphere(rows)};
  std::erase_if(tables, [](const ReportTable& table) { return table.lines.empty(); });
  return tables;
}

}  // namespace cousin
