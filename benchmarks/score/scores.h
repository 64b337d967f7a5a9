#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "benchmarks/score/trait_statistics.h"

namespace cousin {

/// What became of a number: `pass` and `fail` have a limit, `ok` has none; `not_solved` is an
/// estimator's own word.
enum class ScoreStatus { ok, pass, fail, not_solved, not_built, error };
std::string_view to_string(ScoreStatus status);
/// @throws std::invalid_argument naming the text and the names that exist.
ScoreStatus score_status_from_string(std::string_view text);

/// What a number was measured under, so that nobody has to read it out of names. What it has not,
/// and what rows of several settings pool, is -1, 0 or empty.
struct ScoreSettings {
  std::int64_t run = -1;      ///< repetition with other random numbers, from 0
  std::int64_t views = 0;     ///< of the capture
  std::int64_t width_px = 0;  ///< of its images
  std::int64_t height_px = 0;
  std::int64_t steps = 0;           ///< of a training
  std::int64_t held_out_every = 0;  ///< one view in so many has no part in the training
  std::string view_set;  ///< which views of the capture, if not spread evenly: "one side"
  std::string poses;     ///< by structure from motion: "sfm", "adjusted"
  std::string light;     ///< as the scene's configuration names it
};

/// One number of scores.csv. NaN = not measured, an empty cell.
struct ScoreRow : ScoreSettings {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::string suite, scene, case_name, method, metric;  ///< `case_name` is the column "case"
  double value = kNone;
  std::string unit;                        ///< SI; "1" for ratios and counts
  std::int64_t n = 0;                      ///< what the number is over: specimens, views, points
  double ci_low = kNone, ci_high = kNone;  ///< 95 %
  double wall_s = kNone, cpu_s = kNone;
  double peak_rss_mb = kNone;
  double peak_above_start_mb = kNone;  ///< above the memory at the program's start
  std::uint64_t seed = 0;
  ScoreStatus status = ScoreStatus::ok;
  double limit_low = kNone, limit_high = kNone;  ///< what `value` is held to; NaN: no such limit
  std::int64_t limit_n = 0;                      ///< least `n`: what is missing raises no score
};

/// One measured trait of specimens.csv, for anyone's statistics.
struct SpecimenRow {
  std::string dataset, scene;
  std::int64_t frame = -1;  ///< -1: over all frames
  std::int64_t instance = 0;
  std::string cultivar, run, method, trait, unit;
  double truth = ScoreRow::kNone;     ///< the column "true"
  double measured = ScoreRow::kNone;  ///< NaN where not solved
  double sigma = ScoreRow::kNone;
  ScoreStatus status = ScoreStatus::ok;
};

/// Where numbers come from.
struct ScoreHeader {
  std::string program_version;
  std::string dataset_hash;
  std::string config_hash;
  std::string machine;
  std::map<std::string, std::string> more;  ///< compiler, threads, command line, ...
};
struct ScoreFile {
  ScoreHeader header;
  std::vector<ScoreRow> scores;
  std::vector<SpecimenRow> specimens;
};

/// Puts the rows and specimens of `part` behind those of `all`, whose header stays.
void append(const ScoreFile& part, ScoreFile& all);

/// Which photographs a row is of: scene and settings but the steps of a training.
std::string photographs_of(const ScoreRow& row);

/// What a value is held to: low <= value <= high; NaN is no limit on that side.
struct ScoreLimit {
  double low = ScoreRow::kNone;
  double high = ScoreRow::kNone;
  std::int64_t least_n = 0;
};
inline ScoreLimit at_most(double high) { return {.high = high}; }
inline ScoreLimit at_least(double low) { return {.low = low}; }
inline ScoreLimit between(double low, double high) { return {low, high}; }
/// `middle` and no farther than `half` from it.
inline ScoreLimit about(double middle, double half) { return {middle - half, middle + half}; }

inline bool has_limit(const ScoreRow& row) {
  return row.limit_low == row.limit_low || row.limit_high == row.limit_high;  // NaN: none
}

/// The row with the limit, which its value keeps or breaks; NaN breaks it, and so do too few.
ScoreRow limited(ScoreRow row, const ScoreLimit& limit);

/// A row of a statistic with its interval.
ScoreRow with_interval(ScoreRow row, std::string metric, std::string unit,
                       const WithInterval& value, std::int64_t n);
/// The rows of a trait's statistics: rmse, mape, bias, slope, intercept, r2_about_true_mean,
/// r2_paper, limit_low, limit_high, named "length.rmse" and so on. `row` gives suite, scene, case,
/// method, seed.
std::vector<ScoreRow> score_rows(const ScoreRow& row, const std::string& trait,
                                 const std::string& unit, const TraitStatistics& statistics);
/// "length.coverage_68", "length.coverage_95" and "length.normalised_rms".
std::vector<ScoreRow> score_rows(const ScoreRow& row, const std::string& trait,
                                 const SigmaCoverage& coverage);
/// The pairs of one trait that were solved, of the rows that `keep` accepts.
template <class Keep>
std::vector<TraitPair> trait_pairs(std::span<const SpecimenRow> rows, std::string_view trait,
                                   Keep keep) {
  std::vector<TraitPair> pairs;
  for (const SpecimenRow& row : rows) {
    const bool solved =
        row.status == ScoreStatus::ok && row.measured == row.measured && row.truth == row.truth;
    if (row.trait == trait && solved && keep(row))
      pairs.push_back({row.truth, row.measured, row.sigma, row.run});
  }
  return pairs;
}

/// A cell of a CSV table [RFC 4180]: in quotes where the text needs them.
std::string csv_cell(const std::string& text);
/// scores.csv and specimens.csv: a header line with the names above, settings last, RFC 4180
/// quoting, "\n" line ends, doubles in their shortest form that reads back equal.
std::string to_csv(std::span<const ScoreRow> rows);
std::string to_csv(std::span<const SpecimenRow> rows);

/// Strict readers: exactly these columns in this order, every number whole, every status known, no
/// NUL bytes, texts up to 64 KiB; "\r\n" is accepted. Of scores the columns up to `status` alone
/// are schema 1, see settings_of_schema_1. @param name of the file, for messages.
/// @throws std::runtime_error naming file, line, column and what was expected.
std::vector<ScoreRow> scores_from_csv(std::string_view text, std::string_view name);
std::vector<SpecimenRow> specimens_from_csv(std::string_view text, std::string_view name);

/// scores.json: {"schema": 2, "header": {...}, "scores": [{...}], "specimens": [{...}]}, keys as
/// the columns, null for a number that was not measured.
std::string to_json(const ScoreFile& file);
/// Strict: unknown or missing keys, wrong types, another schema are errors; schema 1 is read as
/// settings_of_schema_1 says. @throws std::runtime_error naming file and key.
ScoreFile scores_from_json(std::string_view text, std::string_view name);

}  // namespace cousin
