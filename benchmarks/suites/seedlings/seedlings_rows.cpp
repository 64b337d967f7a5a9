#include "benchmarks/suites/seedlings/seedlings_rows.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "benchmarks/score/distributions.h"
#include "benchmarks/score/order_statistics.h"
#include "benchmarks/suites/seedlings/exact_surface.h"
#include "benchmarks/suites/seedlings/field_shape.h"
#include "benchmarks/suites/seedlings/surface_coverage.h"

namespace cousin {
namespace {

ScoreRow base_row(const SeedlingsJob& job, std::uint64_t seed) {
  ScoreRow row;
  row.suite = kSeedlingsSuite;
  row.scene = job.sample.light;
  row.case_name = job.case_name();
  row.method = job.plan.method;
  row.seed = seed;
  row.run = job.sample.number;
  row.views = job.set.views;
  row.view_set = job.set.one_side ? "one side" : "";
  row.width_px = job.sample.width_px;
  row.height_px = job.sample.height_px;
  row.light = job.sample.light;
  return row;
}

ScoreRow with_number(ScoreRow row, const std::string& metric, double value, const char* unit,
                     std::int64_t n) {
  row.metric = metric;
  row.value = value;
  row.unit = unit;
  row.n = n;
  return row;
}

ScoreRow unsolved_row(const ScoreRow& base, const std::string& status) {
  ScoreRow row = with_number(base, "training: " + status, ScoreRow::kNone, "1", 0);
  row.status = ScoreStatus::not_solved;
  return row;
}

void add_view_scores(const ScoreRow& row, const std::string& set, const ViewScores& scores,
                     std::vector<ScoreRow>& rows) {
  rows.push_back(with_number(row, set + ".psnr", scores.psnr_db, "dB", scores.views));
  rows.push_back(
      with_number(row, set + ".psnr_exposed", scores.psnr_exposed_db, "dB", scores.views));
  rows.push_back(with_number(row, set + ".ssim", scores.ssim, "1", scores.views));
  rows.push_back(with_number(row, set + ".flip", scores.flip, "1", scores.views));
  if (!std::isnan(scores.learned))
    rows.push_back(with_number(row, set + ".lpips", scores.learned, "1", scores.views));
  rows.push_back(with_number(row, set + ".psnr_seedlings", scores.psnr_seedlings_db, "dB",
                             scores.views_of_seedlings));
  rows.push_back(with_number(row, set + ".ssim_seedlings", scores.ssim_seedlings, "1",
                             scores.views_of_seedlings));
  rows.push_back(with_number(row, set + ".flip_seedlings", scores.flip_seedlings, "1",
                             scores.views_of_seedlings));
}

void add_field_scores(ScoreRow row, const FieldScores& scores, std::vector<ScoreRow>& rows) {
  row.case_name += ", " + std::to_string(scores.steps) + " steps";
  row.steps = scores.steps;
  row.wall_s = scores.wall_s;
  row.cpu_s = scores.cpu_s;
  add_view_scores(row, "train", scores.train, rows);
  add_view_scores(row, "held_out", scores.held_out, rows);
  const std::int64_t n = scores.held_out.views;
  rows.push_back(with_number(row, "held_out.psnr_pooled", scores.pooled_db, "dB", n));
  rows.push_back(with_number(row, "held_out.psnr_covered", scores.covered_db, "dB", n));
  rows.push_back(with_number(row, "held_out.psnr_uncovered", scores.uncovered_db, "dB", n));
  if (scores.gaussians > 0) {
    rows.push_back(with_number(row, "gaussians", static_cast<double>(scores.gaussians), "1", 1));
  }
}

void add_coverage(ScoreRow row, const FieldViews& views, std::vector<ScoreRow>& rows) {
  row.method = "photographs";
  CoverageShare all, plants;
  for (std::size_t v = 0; v < views.held_out.size(); ++v) {
    all.add(views.seen[v], views.held_out[v]->shown);
    plants.add(views.seen[v], views.held_out[v]->seedlings);
  }
  for (const int count : {1, kEnoughViews}) {
    const std::string by = "seen_by_" + std::to_string(count);
    rows.push_back(with_number(row, "coverage." + by, all.seen_by(count), "1", all.points()));
    rows.push_back(
        with_number(row, "coverage.seedlings_" + by, plants.seen_by(count), "1", plants.points()));
  }
}

/// A row as if it were of all samples; their cases begin with the sample's name and a comma.
ScoreRow of_all_samples(ScoreRow row) {
  row.run = -1;
  row.case_name =
      "mean" + row.case_name.substr(std::min(row.case_name.find(", "), row.case_name.size()));
  return row;
}

/// What means are of: photographs but the sample, steps, metric.
std::string case_of(const ScoreRow& row) {
  ScoreRow all = row;
  all.run = -1;
  return photographs_of(all) + "\n" + std::to_string(row.steps) + "\n" + row.metric;
}

/// Rows with numbers of samples, one of each case, method and metric (two jobs may score the same
/// steps), without those of samples for which another method has no number of that case and metric:
/// means stand beside one another.
std::vector<const ScoreRow*> of_samples_in_common(const std::vector<ScoreRow>& rows) {
  std::map<std::string, std::map<std::string, std::set<std::int64_t>>> samples;  // by method
  std::vector<const ScoreRow*> numbers;
  for (const ScoreRow& row : rows) {
    if (row.run < 0 || row.status != ScoreStatus::ok || !std::isfinite(row.value)) continue;
    if (samples[case_of(row)][row.method].insert(row.run).second) numbers.push_back(&row);
  }
  const auto is_missing = [&](const ScoreRow* row) {
    for (const auto& [method, own] : samples[case_of(*row)]) {
      if (!own.contains(row->run)) return true;
    }
    return false;
  };
  std::erase_if(numbers, is_missing);
  return numbers;
}

WithInterval student_mean(const std::vector<double>& values) {
  WithInterval result;
  result.value = mean(values);
  const auto n = static_cast<double>(values.size());
  if (n < 2) return result;
  double squares = 0;
  for (const double v : values) squares += (v - result.value) * (v - result.value);
  const double half = student_t_quantile(0.05, n - 1) * std::sqrt(squares / (n - 1) / n);
  result.low = result.value - half;
  result.high = result.value + half;
  return result;
}

double column_mean(const std::vector<const ScoreRow*>& rows, double ScoreRow::*column) {
  std::vector<double> values;
  for (const ScoreRow* row : rows) values.push_back(row->*column);
  return mean(values);
}

}  // namespace

std::vector<ScoreRow> shape_job_rows(const SeedlingsJob& job, std::uint64_t seed,
                                     const TrainedField& field, const FieldViews& views) {
  ScoreRow row = base_row(job, seed);
  if (field.status != "ok" || field.scores.empty()) return {unsolved_row(row, field.status)};
  const FieldScores& last = field.scores.back();
  row.case_name += ", " + std::to_string(last.steps) + " steps";
  row.steps = last.steps;
  row.wall_s = last.wall_s;
  row.cpu_s = last.cpu_s;
  return shape_rows(job.sample, seed, field.splats, views, row);
}

std::vector<ScoreRow> sample_rows(const SeedlingsJob& job, std::uint64_t seed,
                                  const TrainedField& field, const FieldViews& views,
                                  const SampleCapture& whole) {
  const ScoreRow base = base_row(job, seed);
  std::vector<ScoreRow> rows;
  for (const FieldScores& scores : field.scores) add_field_scores(base, scores, rows);
  if (field.status != "ok") rows.push_back(unsolved_row(base, field.status));
  if (job.plan.method != kReference || !job.part.empty()) return rows;
  add_coverage(base, views, rows);
  if (job.set.one_side || job.set.views != job.sample.views) return rows;
  ScoreRow of_capture = base;
  of_capture.method = "photographs";
  rows.push_back(
      with_number(of_capture, "noise_floor.psnr", whole.noise_psnr_db, "dB", whole.noise_views));
  if (whole.noise_views_of_seedlings > 0)
    rows.push_back(with_number(of_capture, "noise_floor.psnr_seedlings", whole.noise_seedlings_db,
                               "dB", whole.noise_views_of_seedlings));
  rows.push_back(with_number(of_capture, "sample.day", job.sample.day, "d", 1));
  const ExactSurface surface = exact_surface(views);
  of_capture.method = "exact surface, mean colour";
  rows.push_back(with_number(of_capture, "held_out.psnr_covered", surface.psnr_db, "dB",
                             static_cast<std::int64_t>(views.held_out.size())));
  rows.push_back(with_number(of_capture, "held_out.pixels", static_cast<double>(surface.pixels),
                             "1", surface.pixels));
  of_capture.method = "exact surface, mean colour, one exposure";
  const ExactSurface even = exact_surface_at_one_exposure(views);
  rows.push_back(with_number(of_capture, "held_out.psnr_covered", even.psnr_db, "dB", even.views));
  of_capture.method = "simulator";
  rows.push_back(with_number(of_capture, "seconds.photographs", whole.wall_s, "s",
                             static_cast<std::int64_t>(whole.views.size())));
  return rows;
}

std::vector<ScoreRow> mean_rows(const std::vector<ScoreRow>& rows) {
  const std::vector<const ScoreRow*> compared = of_samples_in_common(rows);
  std::vector<std::vector<const ScoreRow*>> groups;  // in the order of their first rows
  std::map<std::pair<std::string, std::string>, std::size_t> index;
  for (const ScoreRow* const one : compared) {
    const ScoreRow& row = *one;
    const auto [at, is_new] = index.try_emplace({row.method, case_of(row)}, groups.size());
    if (is_new) groups.emplace_back();
    groups[at->second].push_back(&row);
  }
  std::vector<ScoreRow> means;
  for (const auto& group : groups) {
    std::vector<double> values;
    for (const ScoreRow* row : group) values.push_back(row->value);
    ScoreRow row = of_all_samples(*group.front());
    row.wall_s = column_mean(group, &ScoreRow::wall_s);
    row.cpu_s = column_mean(group, &ScoreRow::cpu_s);
    means.push_back(with_interval(row, row.metric, row.unit, student_mean(values),
                                  static_cast<std::int64_t>(values.size())));
  }
  return means;
}

std::vector<ScoreRow> equal_time_rows(const std::vector<ScoreRow>& rows, int steps,
                                      const TrainingMachines& machines) {
  std::vector<ScoreRow> of_samples;
  for (const ScoreRow& row : rows) {
    if (row.run >= 0) of_samples.push_back(row);
  }
  return equal_time_rows(
      of_samples, {kReference,
                   kOurs,
                   steps,
                   {"train.psnr", "held_out.psnr", "train.psnr_exposed", "held_out.psnr_exposed"},
                   machines});
}

}  // namespace cousin
