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

/// One number of scores.csv. NaN = not measured, an empty cell.
struct ScoreRow {
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

/// The row with a limit that it kept or broke.
ScoreRow limited(ScoreRow row, bool passes);

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

/// scores.csv and specimens.csv: a header line with the names above, RFC 4180 quoting, "\n" line
/// ends, doubles in their shortest form that reads back equal.
std::string to_csv(std::span<const ScoreRow> rows);
std::string to_csv(std::span<const SpecimenRow> rows);

/// Strict readers: exactly these columns in this order, every number whole, every status known, no
/// NUL bytes, texts up to 64 KiB; "\r\n" is accepted. @param name of the file, for messages.
/// @throws std::runtime_error naming file, line, column and what was expected.
std::vector<ScoreRow> scores_from_csv(std::string_view text, std::string_view name);
std::vector<SpecimenRow> specimens_from_csv(std::string_view text, std::string_view name);

/// scores.json: {"schema": 1, "header": {...}, "scores": [{...}], "specimens": [{...}]}, keys as
/// the columns, null for a number that was not measured.
std::string to_json(const ScoreFile& file);
/// Strict: unknown or missing keys, wrong types, another schema are errors. @throws
/// std::runtime_error naming file and key.
ScoreFile scores_from_json(std::string_view text, std::string_view name);

}  // namespace cousin
