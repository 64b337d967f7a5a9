#include "benchmarks/suites/fruits/fruit_suite.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "benchmarks/loop/perceive.h"
#include "benchmarks/loop/plan.h"
#include "benchmarks/loop/score_boxes.h"
#include "benchmarks/loop/score_geometry.h"
#include "benchmarks/loop/score_places.h"
#include "benchmarks/loop/simulate.h"
#include "benchmarks/loop/truth_stages.h"
#include "benchmarks/score/order_statistics.h"
#include "sim/config/fields.h"
#include "sim/types/trait_table.h"

namespace cousin {
namespace {

constexpr int kSurest[] = {25, 50, 75, 90};  ///< percent of the boxes

/// The pipeline with a method of its row.
PipelineConfig with_method(PipelineConfig config, const std::string& method) {
  set_field(fields(config), "method=" + method);
  return config;
}

/// "unoccluded", or "family, unoccluded": what follows the variety's name. A point's rows have no
/// case of their own.
std::string case_of(const FruitSuite& suite, const SpecimenRow& row) {
  const std::size_t comma = row.cultivar.find(", ");
  const std::string own = comma == std::string::npos ? "" : row.cultivar.substr(comma + 2);
  if (row.scene == suite.plain || own.empty()) return own;
  return row.scene + ", " + own;
}

/// Cases that a method is made for: whole in the image, in the sensor's range.
bool counts_in_all(const std::string& name) {
  return name.ends_with("unoccluded") || name.find("hidden") != std::string::npos;
}

/// Each box is a specimen of its own. The jobs of one run show the same plants, so their boxes are
/// drawn together: "hidden_25_run0" is of "run0".
std::vector<SpecimenRow> boxes_of_runs(std::vector<SpecimenRow> rows) {
  std::map<std::string, std::int64_t> numbers;
  for (SpecimenRow& row : rows) {
    const std::string box =
        row.run + "/" + std::to_string(row.frame) + "/" + std::to_string(row.instance);
    row.instance =
        numbers.try_emplace(box, static_cast<std::int64_t>(numbers.size())).first->second;
    row.run = row.run.substr(row.run.rfind("run"));
  }
  return rows;
}

/// The rows of one method and case, box after box.
struct Group {
  const FruitSuite& suite;
  const std::vector<SpecimenRow>& rows;
  ScoreRow base;
  std::vector<ScoreRow>& out;

  void add(ScoreRow row) const {
    const auto limit = suite.limit ? suite.limit(row) : std::nullopt;
    out.push_back(limit ? limited(std::move(row), *limit) : std::move(row));
  }
  void add(const std::string& metric, double value, const std::string& unit, std::int64_t n) const {
    add(measured_row(base, metric, value, unit, n));
  }
};

/// RMSE of relative errors in the third of the widest relative intervals over that in the third of
/// the narrowest; none below 30 pairs.
std::optional<double> rmse_by_width(std::vector<TraitPair> pairs) {
  std::erase_if(pairs, [](const TraitPair& p) { return !(p.sigma > 0); });
  if (pairs.size() < 30) return std::nullopt;
  const auto width = [](const TraitPair& p) { return p.sigma / p.measured; };
  std::sort(pairs.begin(), pairs.end(), [&](const TraitPair& a, const TraitPair& b) {
    return std::pair(width(a), a.truth) < std::pair(width(b), b.truth);
  });
  const std::size_t third = pairs.size() / 3;
  const auto squares = [&](std::size_t from) {
    double sum = 0;
    for (std::size_t i = from; i < from + third; ++i) {
      const double relative = pairs[i].measured / pairs[i].truth - 1;
      sum += relative * relative;
    }
    return sum;
  };
  return std::sqrt(squares(pairs.size() - third) / squares(0));
}

bool is_relative(std::string_view trait) {
  return trait_row(trait).scoring == TraitScoring::relative;
}

void add_intervals(const Group& group, const std::string& name,
                   const std::vector<TraitPair>& pairs) {
  const SigmaCoverage coverage = sigma_coverage(pairs);
  if (coverage.n == 0) return;
  group.add(with_interval(group.base, name + ".coverage_95", "1", coverage.within_95, coverage.n));
  group.add(name + ".width_over_rmse", coverage.width_over_rmse, "1", coverage.n);
  if (!is_relative(name)) return;
  if (const auto ratio = rmse_by_width(pairs))
    group.add(name + ".rmse_by_width", *ratio, "1", coverage.n);
}

void add_trait(const Group& group, std::string_view trait) {
  const auto pairs = trait_pairs(group.rows, trait, [](const SpecimenRow&) { return true; });
  const auto there = std::count_if(group.rows.begin(), group.rows.end(),
                                   [&](const SpecimenRow& row) { return row.trait == trait; });
  if (there == 0) return;
  const auto n = static_cast<std::int64_t>(pairs.size());
  const std::string name(trait), unit(trait_row(trait).unit);
  group.add(name + ".measured", static_cast<double>(n) / static_cast<double>(there), "1", there);
  if (n < 2) return;
  const ScoreRow& base = group.base;
  const TraitStatistics s = trait_statistics(
      pairs, Rng(base.seed).fork(group.suite.name).fork(base.case_name).fork(trait));
  if (is_relative(trait)) group.add(with_interval(base, name + ".mape", "1", s.mape, s.n));
  if (trait == group.suite.known_density)  // a known density adds no error of its own
    group.add(with_interval(base, "mass_by_known_density.mape", "1", s.mape, s.n));
  group.add(with_interval(base, name + ".rmse", unit, s.rmse, s.n));
  group.add(with_interval(base, name + ".bias", unit, s.bias, s.n));
  add_intervals(group, name, pairs);
}

/// Root mean squares of the errors of the surface's point along each axis, and in space.
void add_points(const Group& group) {
  std::map<std::int64_t, double> squares;
  std::vector<TraitPair> normalised;
  for (const char axis : {'x', 'y', 'z'}) {
    const std::string trait = std::string("point_") + axis;
    double sum = 0;
    std::int64_t n = 0;
    for (const SpecimenRow& row : group.rows) {
      if (row.trait != trait || row.status != ScoreStatus::ok) continue;
      const double error = row.measured - row.truth;
      sum += error * error;
      squares[row.instance] += error * error;
      normalised.push_back({row.truth, row.measured, row.sigma, row.run});
      ++n;
    }
    if (n > 0)
      group.add(std::string("point.rmse_") + axis, std::sqrt(sum / static_cast<double>(n)), "m", n);
  }
  if (squares.empty()) return;
  std::vector<double> off_m;
  double all = 0;
  for (const auto& [box, sum] : squares) {
    off_m.push_back(std::sqrt(sum));
    all += sum;
  }
  const auto n = static_cast<std::int64_t>(off_m.size());
  group.add("point.rmse_3d", std::sqrt(all / static_cast<double>(n)), "m", n);
  group.add("point.error_3d", quantile(off_m, 0.5), "m", n);
  const SigmaCoverage coverage = sigma_coverage(normalised);
  if (coverage.n > 0)
    group.add(with_interval(group.base, "point.coverage_95", "1", coverage.within_95, coverage.n));
}

using TraitList = std::vector<std::string_view>;

/// The group's boxes, each with all traits that any of them has: a capture of which nothing is
/// measured has rows of fewer. What is added is not solved.
std::pair<std::vector<SpecimenRow>, TraitList> completed(const std::vector<SpecimenRow>& rows) {
  TraitList traits;
  std::map<std::int64_t, std::map<std::string_view, const SpecimenRow*>> boxes;
  for (const SpecimenRow& row : rows) {
    boxes[row.instance][row.trait] = &row;
    if (std::find(traits.begin(), traits.end(), row.trait) == traits.end())
      traits.push_back(row.trait);
  }
  std::vector<SpecimenRow> all;
  for (const auto& [box, own] : boxes) {
    for (const std::string_view trait : traits) {
      const auto found = own.find(trait);
      SpecimenRow row = found != own.end() ? *found->second : *own.begin()->second;
      if (found == own.end()) {
        row.trait = trait;
        row.truth = row.measured = row.sigma = ScoreRow::kNone;
        row.status = ScoreStatus::not_solved;
      }
      all.push_back(std::move(row));
    }
  }
  return {std::move(all), std::move(traits)};
}

void add_group(const Group& group) {
  add_points(group);
  const auto [boxes, traits] = completed(group.rows);
  const Group whole{group.suite, boxes, group.base, group.out};
  for (const std::string_view trait : group.suite.traits) add_trait(whole, trait);
  if (std::none_of(traits.begin(), traits.end(), is_of_place)) return;
  std::vector<ScoreRow> places;
  add_place_rows(boxes, traits, group.base, places);
  for (ScoreRow& row : places) group.add(std::move(row));
}

/// The trait whose relative interval says how sure a box is: one for all boxes of a group.
std::string_view trait_of_width(const std::vector<SpecimenRow>& rows) {
  for (const std::string_view trait : {"volume", "mass", "point_z"}) {
    const bool is_there = std::any_of(rows.begin(), rows.end(), [&](const SpecimenRow& row) {
      return row.trait == trait && row.status == ScoreStatus::ok;
    });
    if (is_there) return trait;
  }
  return {};
}

/// Width of a box's interval of the trait over its value; infinite where it is not measured.
double width_of(const std::vector<const SpecimenRow*>& box, std::string_view trait) {
  for (const SpecimenRow* row : box) {
    if (row->trait == trait && row->status == ScoreStatus::ok && row->sigma > 0)
      return row->sigma / std::abs(row->measured);
  }
  return std::numeric_limits<double>::infinity();
}

/// The rows of the surest `percent` of all boxes there are; none where fewer are measured.
std::vector<SpecimenRow> surest(const std::vector<SpecimenRow>& rows, int percent) {
  std::map<std::int64_t, std::vector<const SpecimenRow*>> boxes;
  for (const SpecimenRow& row : rows) boxes[row.instance].push_back(&row);
  std::vector<std::pair<double, std::int64_t>> widths;
  const std::string_view trait = trait_of_width(rows);
  for (const auto& [box, own] : boxes) widths.emplace_back(width_of(own, trait), box);
  std::sort(widths.begin(), widths.end());
  widths.resize(widths.size() * static_cast<std::size_t>(percent) / 100);
  if (widths.empty() || !std::isfinite(widths.back().first)) return {};
  std::set<std::int64_t> kept;
  for (const auto& [width, box] : widths) kept.insert(box);
  std::vector<SpecimenRow> result;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(result),
               [&](const SpecimenRow& row) { return kept.contains(row.instance); });
  return result;
}

/// Seconds of depth and fits of one image that shows `fruits` that are measured.
void add_seconds(const FruitSuite& suite, const ScoreFile& jobs, ScoreRow base,
                 std::vector<ScoreRow>& rows) {
  double depth_s = 0, fits_s = 0, views = 0, measured = 0;
  for (const ScoreRow& row : jobs.scores) {
    const std::string scene = row.scene == suite.plain ? "all" : row.scene + ", all";
    if (row.method != base.method || scene != base.case_name) continue;
    if (row.metric == "seconds.depth") {
      depth_s += row.value;
      views += static_cast<double>(row.views);
    }
    if (row.metric == "seconds.fits" || row.metric == "seconds.traits") fits_s += row.value;
    if (row.metric == "boxes.measured") measured += row.value;
  }
  if (views == 0 || measured == 0) return;
  base.metric = "seconds." + std::to_string(suite.fruits_timed) + "_fruits";
  base.unit = "s";
  base.n = static_cast<std::int64_t>(measured);
  base.value = base.wall_s = depth_s / views + suite.fruits_timed * fits_s / measured;
  const bool is_held = base.method == "ours" && base.case_name == "all" && suite.limit_s > 0;
  rows.push_back(is_held ? limited(base, at_most(suite.limit_s)) : base);
}

}  // namespace

ScoreFile run_fruit_job(const FruitSuite& suite, const GridJob& job) {
  std::vector<std::string> sets = job.sets;
  sets.insert(sets.end(), suite.sets.begin(), suite.sets.end());
  const RunConfig config = run_config(suite.scene(), sets, {}, suite.pipeline());
  const SimulatedRun run =
      simulate(config, suite.seed, job.number("run"), planned_truth(*config.pipeline, false));
  ScoreFile file;
  const PipelineRow& pipeline = row_of(*config.pipeline);
  for (const MethodRow& method : pipeline.methods) {
    Stages outside;
    truth_row("boxes").put(outside, run, SeedBoard{});
    const Estimate estimate =
        perceive(run.capture, with_method(*config.pipeline, std::string(method.name)), suite.seed,
                 {}, 0, {}, {}, {}, outside);
    SeedsScoreLabels labels;
    labels.suite = suite.name;
    labels.scene = suite.scene_of(job);
    labels.case_name = job.name;
    labels.method = std::string(method.name);
    labels.run = job.name;
    labels.seed = suite.seed;
    labels.settings.views = config.scene.views();
    SeedsScores scores = score_boxes(run.truth, estimate, labels, pipeline.traits);
    // Only the pooled rows have these statistics; a single capture does not repeat them.
    std::erase_if(scores.rows, [](const ScoreRow& row) {
      return !row.metric.starts_with("seconds.") && !row.metric.starts_with("boxes.");
    });
    append({.scores = std::move(scores.rows), .specimens = std::move(scores.specimens)}, file);
  }
  return file;
}

namespace {

/// Rows of each method and case. Rows of a point, which have no case, go where their box's other
/// rows are, of this method or else of another.
using Groups = std::map<std::pair<std::string, std::string>, std::vector<SpecimenRow>>;

Groups groups_of_boxes(const FruitSuite& suite, const std::vector<SpecimenRow>& boxes) {
  std::map<std::pair<std::string, std::int64_t>, std::string> cases;
  for (const SpecimenRow& row : boxes) {
    if (const std::string own = case_of(suite, row); !own.empty())
      cases[{row.method, row.instance}] = own;
  }
  std::map<std::int64_t, std::string> of_any;
  for (const auto& [box, name] : cases) of_any.emplace(box.second, name);
  Groups groups;
  for (const SpecimenRow& row : boxes) {
    std::string name = case_of(suite, row);
    if (name.empty()) {
      const auto own = cases.find({row.method, row.instance});
      const auto other = of_any.find(row.instance);
      if (other == of_any.end()) continue;
      name = own != cases.end() ? own->second : other->second;
    }
    groups[{row.method, name}].push_back(row);
    const std::string all = row.scene == suite.plain ? "all" : row.scene + ", all";
    if (counts_in_all(name)) groups[{row.method, all}].push_back(row);
  }
  return groups;
}

/// Ratios of ours to each other method, in each case on the boxes that both measure.
void add_pairs(const FruitSuite& suite, const Groups& groups, std::vector<ScoreRow>& rows) {
  SeedsScoreLabels labels;
  labels.suite = suite.name;
  labels.scene = "pooled";
  labels.seed = suite.seed;
  for (const auto& [key, theirs] : groups) {
    const auto ours = groups.find({"ours", key.second});
    if (key.first == "ours" || ours == groups.end()) continue;
    std::vector<SpecimenRow> both = ours->second;
    both.insert(both.end(), theirs.begin(), theirs.end());
    for (SpecimenRow& row : both) row.cultivar = key.second;
    for (ScoreRow& row : paired_rows(both, "ours", key.first, labels))
      rows.push_back(std::move(row));
  }
}

}  // namespace

std::vector<ScoreRow> fruit_pooled_rows(const FruitSuite& suite, const ScoreFile& jobs) {
  std::vector<ScoreRow> rows;
  const std::vector<SpecimenRow> boxes = boxes_of_runs(jobs.specimens);
  ScoreRow base;
  base.suite = suite.name;
  base.scene = "pooled";
  base.seed = suite.seed;
  const Groups groups = groups_of_boxes(suite, boxes);
  for (const auto& [key, own] : groups) {
    base.method = key.first;
    base.case_name = key.second;
    add_group({suite, own, base, rows});
    if (!key.second.ends_with("all")) continue;
    add_seconds(suite, jobs, base, rows);
    for (const int percent : kSurest) {
      const std::vector<SpecimenRow> kept = surest(own, percent);
      if (kept.empty()) continue;
      base.case_name = key.second + ", surest " + std::to_string(percent) + " %";
      add_group({suite, kept, base, rows});
    }
  }
  add_pairs(suite, groups, rows);
  return rows;
}

LinePlot abstention_plot(const std::vector<ScoreRow>& rows, const std::string& method,
                         const std::string& trait, const std::string& metric,
                         const std::string& label, double factor) {
  LinePlot plot;
  plot.title = label + " against the share of boxes that are reported";
  plot.caption = {"The boxes with the narrowest intervals of " + trait +
                  " are reported first; the last point has all that are measured."};
  plot.x_label = "boxes reported, %";
  plot.y_label = label;
  plot.section = "What it dares to say";
  const auto find = [&](const std::string& name, const std::string& of) -> const ScoreRow* {
    const auto row = std::find_if(rows.begin(), rows.end(), [&](const ScoreRow& r) {
      return r.scene == "pooled" && r.method == method && r.case_name == name && r.metric == of;
    });
    return row == rows.end() ? nullptr : &*row;
  };
  LineSeries own{.name = method, .points = {}};
  const auto add = [&](double percent, const std::string& name) {
    const ScoreRow* row = find(name, metric);
    if (row == nullptr) return;
    own.points.push_back(
        {percent, {row->value * factor, row->ci_low * factor, row->ci_high * factor}});
  };
  for (const int percent : kSurest) add(percent, "all, surest " + std::to_string(percent) + " %");
  const ScoreRow *all = find("all", metric), *boxes = find("all", trait + ".measured");
  if (all && boxes) add(100 * static_cast<double>(all->n) / static_cast<double>(boxes->n), "all");
  if (!own.points.empty()) plot.series.push_back(std::move(own));
  return plot;
}

ReportTable camera_table(const std::vector<ScoreRow>& rows, const std::string& method,
                         const std::vector<std::string>& cameras,
                         const std::vector<CameraColumn>& columns) {
  ReportTable table;
  table.title = "Which camera";
  table.caption = "The same plants from the same places; a camera's model is no device.";
  table.columns = {"camera", "boxes"};
  for (const CameraColumn& column : columns) table.columns.push_back(column.title);
  for (const std::string& camera : cameras) {
    std::vector<std::string> line = {camera, ""};
    for (const CameraColumn& column : columns) {
      const auto row = std::find_if(rows.begin(), rows.end(), [&](const ScoreRow& r) {
        return r.scene == "pooled" && r.method == method && r.case_name == camera + ", all" &&
               r.metric == column.metric;
      });
      const bool is_there = row != rows.end();
      if (is_there && column.metric.ends_with(".measured")) line[1] = std::to_string(row->n);
      line.push_back(table_cell(is_there ? &*row : nullptr, column.factor, column.decimals));
    }
    table.lines.push_back(std::move(line));
  }
  return table;
}

}  // namespace cousin
