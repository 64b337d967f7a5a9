#include "benchmarks/tools/measure/measured_page.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <utility>

#include "benchmarks/loop/seeds_report.h"
#include "benchmarks/loop/stage_pictures.h"
#include "benchmarks/report/drawn_number.h"
#include "benchmarks/report/shown_numbers.h"
#include "benchmarks/score/length_units.h"
#include "benchmarks/tools/measure/group_comparison.h"
#include "sim/imaging/image_io.h"

namespace cousin {
namespace {

constexpr int kQuality = 92;  ///< of the JPEG file

/// Index of the posed view with a picture that looks down most; -1 without one.
int view_from_above(const Capture& capture, const Poses& poses) {
  int best = -1;
  double most_down = -2;
  for (std::size_t i = 0; i < poses.size() && i < capture.frames.size(); ++i) {
    if (poses[i].status != PoseStatus::ok || capture.frames[i].sensors.empty() ||
        capture.frames[i].sensors.front().color.empty())
      continue;
    const Eigen::Vector3d looks =
        poses[i].camera_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
    if (-looks.z() > most_down) {
      most_down = -looks.z();
      best = static_cast<int>(i);
    }
  }
  return best;
}

/// The part of the image that holds the points and a margin, enlarged to be at least 900 wide.
struct Enlarged {
  Image<Rgb8> image;
  int left = 0, top = 0, factor = 1;

  Eigen::Vector2d place_of(const Eigen::Vector2d& pixel_px) const {
    const Eigen::Vector2d corner_px(left, top);
    return ((pixel_px - corner_px).array() + 0.5) * factor - 0.5;
  }
};

Enlarged enlarged_about(const Image<Rgb8>& image, const std::vector<Eigen::Vector2d>& points_px) {
  constexpr double kMargin = 0.25;  // of the larger side
  constexpr int kLeastWidth = 900, kMostFactor = 6;
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& point_px : points_px) box.extend(point_px);
  const double margin = std::max(16.0, kMargin * box.sizes().maxCoeff());
  const auto clamped = [](double at, int size) {
    return static_cast<int>(std::clamp(at, 0.0, static_cast<double>(size)));
  };
  Enlarged part;
  part.left = clamped(box.min().x() - margin, image.width() - 1);
  part.top = clamped(box.min().y() - margin, image.height() - 1);
  const int right = std::max(part.left + 1, clamped(box.max().x() + margin, image.width()));
  const int bottom = std::max(part.top + 1, clamped(box.max().y() + margin, image.height()));
  part.factor = std::clamp(kLeastWidth / (right - part.left), 1, kMostFactor);
  part.image = Image<Rgb8>((right - part.left) * part.factor, (bottom - part.top) * part.factor);
  for (int y = 0; y < part.image.height(); ++y) {
    for (int x = 0; x < part.image.width(); ++x)
      part.image(x, y) = image(part.left + x / part.factor, part.top + y / part.factor);
  }
  return part;
}

void show_seed_numbers(const Capture& capture, const Estimate& estimate, ReportScene& scene) {
  const int view = view_from_above(capture, estimate.poses);
  if (view < 0) return;
  const FramePose& pose = estimate.poses[static_cast<std::size_t>(view)];
  const Image<Rgb8>& image = capture.frames[static_cast<std::size_t>(view)].sensors.front().color;
  std::vector<std::pair<int, Eigen::Vector2d>> numbers;
  std::vector<Eigen::Vector2d> places_px;
  for (const SpecimenTraits& seed : estimate.traits) {
    if (!seed.centroid_in_world_m.allFinite()) continue;
    const auto pixel = project(pose.camera, pose.camera_from_world * seed.centroid_in_world_m);
    if (!pixel || !image.contains(static_cast<int>(pixel->x()), static_cast<int>(pixel->y())))
      continue;
    numbers.emplace_back(seed.instance, *pixel);
    places_px.push_back(*pixel);
  }
  if (numbers.empty()) return;
  Enlarged part = enlarged_about(image, places_px);
  const int dot_px = std::max(1, part.image.width() / 640);
  for (const auto& [number, pixel_px] : numbers)
    write_number(part.image, number, part.place_of(pixel_px), dot_px);
  scene.pictures.push_back(
      {"Seeds by number, view " + std::to_string(capture.frames[static_cast<std::size_t>(view)].id),
       "the numbers of specimens.csv (seed), in the view that looks down most",
       encode_jpeg(part.image, kQuality)});
}

std::string with_interval(const MeasuredRow& row) {
  if (!std::isfinite(row.low)) return shown_precisely(row.value);
  return shown_precisely(row.value) + " ± " + shown_number(row.high - row.value);
}

/// Traits of the rows, in the order in which they come.
std::vector<std::string> traits_of(const std::vector<MeasuredRow>& rows) {
  std::vector<std::string> traits;
  for (const MeasuredRow& row : rows) {
    if (!row.trait.empty() && std::find(traits.begin(), traits.end(), row.trait) == traits.end())
      traits.push_back(row.trait);
  }
  return traits;
}

ReportTable table_of(const MeasuredSample& sample) {
  const std::vector<MeasuredRow> rows = measured_rows(sample);
  const std::vector<std::string> traits = traits_of(rows);
  ReportTable table;
  table.title = sample.name + ": " + std::to_string(count_measured(sample.traits)) + " of " +
                std::to_string(sample.traits.size()) + " seeds measured";
  table.caption = "Value ± half of the 95 % interval. " + sample.scale.from;
  table.columns = {"seed"};
  for (const std::string& trait : traits) {
    const auto row = std::find_if(rows.begin(), rows.end(),
                                  [&](const MeasuredRow& r) { return r.trait == trait; });
    const std::string unit(length_unit(row->unit).shown);
    table.columns.push_back(unit.empty() ? trait : trait + ", " + unit);
  }
  table.columns.emplace_back("why not measured");
  std::map<int, std::vector<const MeasuredRow*>> of_seed;
  for (const MeasuredRow& row : rows) of_seed[row.seed].push_back(&row);
  for (const auto& [seed, its_rows] : of_seed) {
    std::vector<std::string> line(table.columns.size());
    line.front() = std::to_string(seed);
    line.back() = its_rows.front()->reason;
    for (const MeasuredRow* row : its_rows) {
      const auto place = std::find(traits.begin(), traits.end(), row->trait);
      if (place != traits.end())
        line[static_cast<std::size_t>(place - traits.begin()) + 1] = with_interval(*row);
    }
    table.lines.push_back(std::move(line));
  }
  return table;
}

/// How each trait is spread, in metres as pages take it; samples of a group together.
std::vector<Distribution> distributions_of(const MeasuredPage& page) {
  std::vector<Distribution> result;
  for (const MeasuredSample& sample : page.samples) {
    for (const MeasuredRow& row : measured_rows(sample)) {
      if (row.trait.empty()) continue;
      auto of_trait = std::find_if(result.begin(), result.end(),
                                   [&](const Distribution& d) { return d.quantity == row.trait; });
      if (of_trait == result.end()) {
        result.push_back({row.trait, row.trait, row.unit, {}});
        of_trait = result.end() - 1;
      }
      const std::string name = page.group.empty() ? sample.name : sample.source;
      auto& groups = of_trait->groups;
      auto group = std::find_if(groups.begin(), groups.end(),
                                [&](const DistributionGroup& g) { return g.name == name; });
      if (group == groups.end()) {
        groups.push_back({name, name, {}});
        group = groups.end() - 1;
      }
      group->values.push_back(row.value / length_unit(row.unit).factor);
    }
  }
  return result;
}

std::string summary_of(const MeasuredPage& page) {
  std::size_t seen = 0;
  int measured = 0;
  for (const MeasuredSample& sample : page.samples) {
    seen += sample.traits.size();
    measured += count_measured(sample.traits);
  }
  std::string text = std::to_string(measured) + " of " + std::to_string(seen) +
                     " seeds that are seen are measured";
  if (page.samples.size() > 1) text += ", in " + std::to_string(page.samples.size()) + " samples";
  text += ". " + page.samples.front().scale.from;
  return text +
         " Sizes are in millimetres. Intervals were set on simulated seeds, photographed without "
         "compression: of heights of glossy seeds, and from videos of few bits, they hold fewer "
         "than 95 in 100. No real seed has confirmed them.";
}

std::string interval_text(const WithInterval& value, double factor, const char* unit) {
  std::string text = shown_interval(value, factor);
  return text + (unit[0] == '\0' ? "" : std::string(" ") + unit);
}

}  // namespace

ReportScene measured_scene(const std::string& name, const Capture& capture,
                           const Estimate& estimate) {
  ReportScene scene;
  scene.name = name;
  show_seed_numbers(capture, estimate, scene);
  for (ReportPicture& picture : outline_pictures(capture, estimate))
    scene.pictures.push_back(std::move(picture));
  scene.measured = all_surfaces(estimate);
  return scene;
}

std::vector<MeasuredRow> all_rows(const MeasuredPage& page) {
  std::vector<MeasuredRow> rows;
  for (const MeasuredSample& sample : page.samples) {
    for (MeasuredRow& row : measured_rows(sample)) rows.push_back(std::move(row));
  }
  return rows;
}

std::vector<ReportTable> group_tables(const MeasuredPage& page) {
  std::vector<std::pair<std::string, PrintScale>> scales;
  for (const MeasuredSample& sample : page.samples) {
    if (std::none_of(scales.begin(), scales.end(),
                     [&](const auto& known) { return known.first == sample.source; }))
      scales.emplace_back(sample.source, sample.scale);
  }
  if (page.group.empty() || scales.size() < 2) return {};
  const GroupComparison comparison = compare_groups(all_rows(page), scales);
  ReportTable groups;
  groups.title = "Each " + page.group;
  groups.caption =
      "Spread of the seeds as measured; the part that is the measurement's own error, by the "
      "deviations that it gives; what is left from seed to seed; and how many seeds a group it "
      "takes to see a difference of 2 % (power 80 %, level 5 %).";
  groups.columns = {"trait",  page.group,    "seeds",        "mean",
                    "spread", "measurement", "seed to seed", "seeds to see 2 %"};
  for (const GroupTrait& t : comparison.traits) {
    const LengthUnit of = length_unit(t.unit);
    const std::string unit = of.shown.empty() ? "" : " " + std::string(of.shown);
    groups.lines.push_back(
        {t.trait, t.group, std::to_string(t.seeds), shown_precisely(t.mean) + unit,
         shown_number(t.sd), shown_number(t.measurement_sd), shown_number(t.seed_sd),
         t.seeds_for_two_percent > 0 ? std::to_string(t.seeds_for_two_percent) : ""});
  }
  ReportTable differences;
  differences.title = "Differences between groups";
  differences.caption =
      "Mean of a group less that of " + scales.front().first +
      ", with 95 % interval (Welch). Seeds are taken as independent. A difference whose interval "
      "holds 0 is not shown to exist.";
  differences.columns = {"trait", page.group, "difference", "in per cent", "p"};
  for (const GroupDifference& d : comparison.differences) {
    const std::string unit(length_unit(d.unit).shown);
    differences.lines.push_back({d.trait, d.group + " − " + d.first,
                                 interval_text(d.difference, 1, unit.c_str()),
                                 interval_text(d.relative, 100, "%"),
                                 std::isnan(d.p_value) ? "" : shown_number(d.p_value)});
  }
  return {std::move(groups), std::move(differences)};
}

ReportInput measured_page(const MeasuredPage& page) {
  ReportInput input;
  input.title = page.title;
  input.summary = summary_of(page);
  input.commands = {page.command_line};
  input.config_toml = page.config_toml;
  input.tables = group_tables(page);
  for (const MeasuredSample& sample : page.samples) input.tables.push_back(table_of(sample));
  for (std::size_t i = 0; i < page.scenes.size(); ++i) {
    const std::string prefix = page.scenes.size() > 1 ? page.samples[i].name + ": " : "";
    add_scene(page.scenes[i], prefix, input);
  }
  input.distributions = distributions_of(page);
  input.notes = page.notes;
  return input;
}

}  // namespace cousin
