#include "benchmarks/loop/seeds_report.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "benchmarks/loop/limits.h"
#include "benchmarks/loop/result_folder.h"
#include "benchmarks/loop/score_seeds.h"
#include "benchmarks/report/report.h"
#include "benchmarks/report/shown_numbers.h"
#include "perception/cloud/measure_traits.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/links.h"
#include "sim/types/trait_table.h"

namespace cousin {
namespace {

const std::vector<std::string> kTraits(kSeedTraits.begin(), kSeedTraits.end());

ReportShape shape_of(const Mesh& mesh, const std::string& name, const std::string& caption,
                     Rgb8 color) {
  ReportShape shape;
  shape.name = name;
  shape.caption = caption;
  for (const Eigen::Vector3d& v : mesh.vertices_m) shape.positions_m.push_back(v.cast<float>());
  for (const auto& t : mesh.triangles) {
    shape.triangles.push_back({static_cast<std::uint32_t>(t[0]), static_cast<std::uint32_t>(t[1]),
                               static_cast<std::uint32_t>(t[2])});
  }
  shape.colors.assign(shape.positions_m.size(), color);
  return shape;
}

/// @param source  of the depth
ReportShape shape_of(const Cloud& cloud, const std::string& name, const std::string& source) {
  ReportShape shape;
  shape.name = name;
  shape.caption = "Points of the " + source + ": " + std::to_string(cloud.size()) + ".";
  for (const CloudPoint& p : cloud) {
    shape.positions_m.push_back(p.position_m);
    shape.colors.push_back(p.color);
  }
  return shape;
}

/// Where all but the outermost hundredth of the centres on either side lie, and half as much again:
/// a few Gaussians far off would make the others too small to see.
Eigen::AlignedBox3f shown_box(const std::vector<Splat>& splats) {
  Eigen::AlignedBox3f box;
  if (splats.empty()) return box;
  Eigen::Vector3f low, high;
  for (int k = 0; k < 3; ++k) {
    std::vector<float> at;
    for (const Splat& splat : splats) at.push_back(splat.centre_m[k]);
    std::sort(at.begin(), at.end());
    const std::size_t cut = at.size() / 100;
    const float low_m = at[cut], high_m = at[at.size() - 1 - cut];
    low[k] = low_m - 0.25F * (high_m - low_m);
    high[k] = high_m + 0.25F * (high_m - low_m);
  }
  return {low, high};
}

bool is_drawn(const Splat& splat) {
  const Eigen::Vector3f scale_m = splat.log_scale.array().exp();
  return scale_m.allFinite() && (scale_m.array() > 0).all() && splat.rotation_wxyz.allFinite() &&
         splat.rotation_wxyz.norm() > 1e-12F && std::isfinite(splat.opacity_logit);
}

/// Colours as they are from every direction; what cannot be drawn is left out.
ReportShape shape_of(const SplatModel& model, const std::string& name) {
  constexpr float kDc = 0.28209479F;  // of the first spherical harmonic
  ReportShape shape;
  shape.name = name;
  const Eigen::Vector3f origin_m = model.origin_in_world_m.cast<float>();
  const Eigen::AlignedBox3f box = shown_box(model.splats);
  for (const Splat& splat : model.splats) {
    if (!is_drawn(splat) || !box.contains(splat.centre_m)) continue;
    const Eigen::Vector4f& q = splat.rotation_wxyz;
    shape.positions_m.push_back(origin_m + splat.centre_m);
    const auto code = [&](std::size_t k) {
      const float value = std::clamp(0.5F + kDc * splat.sh_dc[k], 0.0F, 1.0F);
      return static_cast<std::uint8_t>(std::lround(255 * value));
    };
    shape.colors.push_back({code(0), code(1), code(2)});
    shape.splats.push_back({splat.log_scale.array().exp(),
                            Eigen::Quaternionf(q[0], q[1], q[2], q[3]).normalized(),
                            1 / (1 + std::exp(-splat.opacity_logit))});
  }
  const std::size_t drawn = shape.splats.size();
  shape.caption =
      "The trained model: " + std::to_string(drawn) + " of its " +
      std::to_string(model.splats.size()) +
      " Gaussians, without those far off from the middle 98 %, in the colours that they "
      "have from all sides alike.";
  return shape;
}

/// maize, wheat and rice first, then what is not a species: the order of a table's columns.
int rank_of(const std::string& group) {
  static const std::vector<std::string> kOrder = {"maize", "wheat", "rice", "all", kSphere};
  return static_cast<int>(std::find(kOrder.begin(), kOrder.end(), group) - kOrder.begin());
}

/// Whether a suite's numbers stand apart from those that plots and tiles are of: another spread of
/// sizes does, and Gaussians' smaller images do where there are others.
class Apart {
 public:
  explicit Apart(const std::vector<ScoreRow>& rows)
      : has_seeds_(std::any_of(rows.begin(), rows.end(),
                               [](const ScoreRow& row) { return row.suite == "seeds"; })) {}
  bool operator()(const std::string& suite) const {
    return suite == kPaperSpread || (has_seeds_ && suite == kSplatsSuite);
  }

 private:
  bool has_seeds_;
};

/// RMSE and MAPE of our method, a species a line; where no species was pooled, a cultivar a line.
std::vector<Headline> headlines_of(const std::vector<ScoreRow>& rows) {
  std::vector<std::pair<int, Headline>> found;
  const bool many = std::any_of(rows.begin(), rows.end(), [](const ScoreRow& row) {
    return row.scene == "pooled" && row.case_name == "all";
  });
  const Apart is_apart(rows);
  for (const ScoreRow& row : rows) {
    if (row.scene != "pooled" || is_apart(row.suite) || row.method.find('/') != row.method.npos)
      continue;
    const bool is_species = rank_of(row.case_name) < 3;
    if (many ? !is_species : is_species || row.method == "simulator") continue;
    for (std::size_t i = 0; i < kTraits.size(); ++i) {
      const std::string& trait = kTraits[i];
      const bool by_size = trait == "area" || trait == "volume";
      if (row.metric != trait + (by_size ? ".mape" : ".rmse")) continue;
      if (many && row.method != "ours") continue;
      Headline headline;
      headline.label = (by_size ? "MAPE of " : "RMSE of ") + trait + ", " + row.case_name;
      if (row.method == "paper") headline.label += ", the paper's steps";
      headline.value = {row.value, row.ci_low, row.ci_high};
      headline.unit = by_size ? "%" : "m";
      headline.status = row.status;
      if (row.status != ScoreStatus::ok)
        headline.limit = limit_text(row, shown_unit(headline.unit, row.metric));
      found.emplace_back(static_cast<int>(i) * 10 + rank_of(row.case_name), std::move(headline));
    }
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Headline> result;
  for (auto& [rank, headline] : found) result.push_back(std::move(headline));
  return result;
}

bool is_of_seeds(const ScoreRow& row) { return row.suite == "seeds" || row.suite == kSplatsSuite; }

/// Every number of seeds that has a limit, ordered by what it is, then by group.
std::vector<Headline> limits_of(const std::vector<ScoreRow>& rows) {
  std::vector<Headline> result;
  for (const ScoreRow& row : rows) {
    if (!has_limit(row) || row.status == ScoreStatus::ok || !is_of_seeds(row)) continue;
    Headline headline;
    headline.label = row.metric;
    headline.group = row.case_name;
    if (row.scene != "pooled") {  // a capture of its own
      headline.label = row.suite == kSplatsSuite
                           ? row.metric + ", " + row.method
                           : row.metric.substr(row.metric.find('.') + 1) + ", 270 views";
      headline.group = row.scene;
    }
    if (row.method.find('/') != row.method.npos)
      headline.label += " to " + row.method.substr(row.method.find('/') + 1);
    headline.value = {row.value, row.ci_low, row.ci_high};
    const bool share = row.metric.ends_with("mape") || row.metric.ends_with("coverage_95") ||
                       row.metric.ends_with(".solved") || row.metric == "views.posed";
    headline.unit = share ? "%" : row.unit;
    headline.limit = limit_text(row, shown_unit(headline.unit, row.metric));
    headline.status = row.status;
    result.push_back(std::move(headline));
  }
  // Lengths before area and volume, then what is no trait: the order of a table's lines.
  const auto rank = [](const Headline& h) {
    const auto trait = std::find_if(kTraits.begin(), kTraits.end(), [&](const std::string& name) {
      return h.label.starts_with(name + ".");
    });
    return std::pair(static_cast<int>(trait - kTraits.begin()), rank_of(h.group));
  };
  std::stable_sort(result.begin(), result.end(),
                   [&](const Headline& a, const Headline& b) { return rank(a) < rank(b); });
  return result;
}

/// What a point was measured under, but the scene and the run.
std::string setting_of(const ScoreRow& row) {
  if (row.views == 0) return row.case_name;
  std::string text = std::to_string(row.views) + " views " + std::to_string(row.width_px) + "x" +
                     std::to_string(row.height_px);
  if (row.held_out_every > 0)
    text += ", one in " + std::to_string(row.held_out_every) + " held out";
  if (!row.poses.empty()) text += ", poses " + row.poses;
  if (row.steps > 0) text += ", " + std::to_string(row.steps) + " steps";
  return text;
}

std::vector<ErrorTimeCurve> curves_of(const std::vector<ScoreRow>& rows) {
  std::map<std::string, ErrorTimeCurve> curves;
  const Apart is_apart(rows);
  for (const ScoreRow& row : rows) {
    for (const std::string& trait : kTraits) {
      if (row.metric != "curve." + trait + ".rmse" || !(row.wall_s > 0)) continue;
      // One point a setting: further runs, and other spreads of sizes, are other seeds.
      if (row.suite == kPaperSpread || row.run != 0) continue;
      // Gaussians' smaller images have plots of their own beside others.
      const std::string apart = is_apart(row.suite) ? ", trained models" : "";
      ErrorTimeCurve& curve = curves[apart + trait + "/" + row.scene];
      curve.title = "Error against time: " + trait + ", " + row.scene + apart;
      curve.metric = "RMSE of " + trait;
      curve.unit = trait_row(trait).unit;
      curve.points.push_back(
          {row.method, setting_of(row), row.wall_s, {row.value, row.ci_low, row.ci_high}});
    }
  }
  std::vector<ErrorTimeCurve> result;
  for (auto& [key, curve] : curves) {
    if (curve.points.size() > 2) result.push_back(std::move(curve));
  }
  return result;
}

std::vector<Attribution> attributions_of(const std::vector<ScoreRow>& rows) {
  std::map<std::string, Attribution> found;
  const std::string prefix = "truth up to ";
  for (const ScoreRow& row : rows) {
    if (!row.case_name.starts_with(prefix)) continue;
    for (const TraitRow& known : trait_table()) {
      const std::string trait(known.name);
      if (row.metric != trait + ".rmse") continue;
      Attribution& attribution = found[row.scene + "/" + trait];
      attribution.title = "Where the error of " + trait + " comes from, " + row.scene;
      attribution.metric = "RMSE of " + trait;
      attribution.unit = row.unit;
      attribution.steps.push_back(
          {row.case_name.substr(prefix.size()), {row.value, row.ci_low, row.ci_high}});
    }
  }
  std::vector<Attribution> result;
  for (auto& [key, attribution] : found) result.push_back(std::move(attribution));
  return result;
}

}  // namespace

void add_scene(const ReportScene& scene, const std::string& prefix, ReportInput& input) {
  for (const ReportPicture& picture : scene.pictures) {
    input.images.push_back({prefix + picture.name, picture.caption, picture.file});
  }
  if (!scene.splats.splats.empty())
    input.shapes.push_back(shape_of(scene.splats, prefix + "Gaussians"));
  if (!scene.cloud.empty()) {
    const bool is_stereo = scene.splats.splats.empty();
    input.shapes.push_back(shape_of(scene.cloud, prefix + "Cloud",
                                    is_stereo ? "multi-view stereo" : "Gaussians' depth"));
  }
  if (!scene.measured.triangles.empty()) {
    input.shapes.push_back(shape_of(scene.measured, prefix + "Measured surfaces",
                                    "Closed surfaces fitted by our method", {214, 140, 60}));
  }
  if (!scene.truth.triangles.empty()) {
    input.shapes.push_back(shape_of(scene.truth, prefix + "True surfaces",
                                    "The specimens as they are", {90, 140, 200}));
  }
}

void write_report(const std::filesystem::path& file, const SeedsReport& report) {
  ReportInput input;
  input.title = report.title;
  input.summary = report.summary;
  if (!report.command_line.empty()) input.commands = {report.command_line};
  input.config_toml = report.config_toml;
  input.scores = report.scores;
  const auto& specimens = report.scores.specimens;
  const bool only_spheres = std::all_of(specimens.begin(), specimens.end(),
                                        [](const auto& row) { return row.cultivar == kSphere; });
  const Apart is_apart(report.scores.scores);
  for (const SpecimenRow& row : specimens) {
    if ((only_spheres || row.cultivar != kSphere) && !is_apart(row.dataset))
      input.plotted.push_back(row);
  }
  input.headlines = headlines_of(report.scores.scores);
  for (const ScoreRow& row : report.scores.scores) {
    if (row.metric != "seconds.run" || row.method != "whole") continue;
    input.headlines.push_back({"Run time of all stages", {row.wall_s}, "s"});
    input.headlines.push_back({"Peak memory", {row.peak_rss_mb}, "MB"});
  }
  input.limits = limits_of(report.scores.scores);
  for (const ReportScene& scene : report.scenes) {
    const std::string prefix = report.scenes.size() > 1 ? scene.name + ": " : "";
    add_scene(scene, prefix, input);
  }
  input.curves = curves_of(report.scores.scores);
  input.curves.insert(input.curves.end(), report.curves.begin(), report.curves.end());
  input.lines = report.lines;
  input.tables = report.tables;
  input.attributions = attributions_of(report.scores.scores);
  for (const ScoreRow& row : report.scores.scores) {
    const bool of_one_run = row.metric.starts_with("seconds.") &&
                            row.metric != "seconds.perceive" && row.metric != "seconds.run" &&
                            row.suite == "run" && row.scene == "000000";
    if (of_one_run)
      input.timings.push_back({row.metric.substr(8), row.wall_s, row.cpu_s, row.peak_rss_mb});
  }
  const auto& more = report.scores.header.more;
  if (const auto note = more.find("note"); note != more.end()) input.notes.push_back(note->second);
  input.plan = report.plan;
  write_file(file, make_report(input));
}

namespace {
constexpr const char* kConfigFile = "config.toml";
constexpr const char* kPlanFile = "plan.txt";
constexpr const char* kScenesFolder = "report";
}  // namespace

std::filesystem::path report_scenes_folder(const std::filesystem::path& folder) {
  return folder / kScenesFolder;
}

void write_report_folder(const std::filesystem::path& folder, const SeedsReport& report) {
  write_result_tables(folder, report.scores);
  if (!report.config_toml.empty()) write_file(folder / kConfigFile, report.config_toml);
  if (!report.plan.empty()) write_file(folder / kPlanFile, report.plan);
  write_report(folder / "report.html", report);
}

std::vector<std::string> report_names(std::vector<std::string> more) {
  for (const char* name : {"report.html", kConfigFile, kPlanFile, kScenesFolder})
    more.emplace_back(name);
  return result_names(std::move(more));
}

SeedsReport read_report_folder(const std::filesystem::path& folder) {
  for (const char* part : {"scores.json", kConfigFile, kPlanFile, kScenesFolder})
    refuse_links_out(folder, part);
  SeedsReport report;
  report.scores = read_result_tables(folder);
  add_limits_of_schema_1(report.scores.scores);
  const auto& more = report.scores.header.more;
  if (const auto title = more.find("title"); title != more.end()) {
    report.title = title->second;
  } else {
    report.title = "Cousin: " + folder.filename().string();
  }
  if (const auto command = more.find("command"); command != more.end())
    report.command_line = command->second;
  if (const auto summary = more.find("summary"); summary != more.end())
    report.summary = summary->second;
  const auto text = [&](const char* name) {
    return std::filesystem::exists(folder / name) ? read_file(folder / name) : std::string();
  };
  report.config_toml = text(kConfigFile);
  report.plan = text(kPlanFile);
  WantedScene wanted;
  if (const auto scenes = more.find("scenes"); scenes != more.end()) {
    wanted = [names = " " + scenes->second + " "](const std::string& name) {
      return names.find(" " + name + " ") != std::string::npos;
    };
  }
  report.scenes = read_report_scenes(report_scenes_folder(folder), wanted);
  return report;
}

}  // namespace cousin
