#include "benchmarks/score/scores.h"

#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "benchmarks/score/score_columns.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

constexpr std::array<std::pair<ScoreStatus, std::string_view>, 6> kStatusNames = {{
    {ScoreStatus::ok, "ok"},
    {ScoreStatus::pass, "pass"},
    {ScoreStatus::fail, "fail"},
    {ScoreStatus::not_solved, "not_solved"},
    {ScoreStatus::not_built, "not_built"},
    {ScoreStatus::error, "error"},
}};

}  // namespace

std::string_view to_string(ScoreStatus status) {
  for (const auto& [value, name] : kStatusNames) {
    if (value == status) return name;
  }
  throw std::invalid_argument("score status " + std::to_string(static_cast<int>(status)) +
                              " does not exist");
}

ScoreStatus score_status_from_string(std::string_view text) {
  for (const auto& [value, name] : kStatusNames) {
    if (name == text) return value;
  }
  throw std::invalid_argument("status \"" + cut_utf8(text, 64) +
                              "\" is not one of ok, pass, fail, not_solved, not_built, error");
}

void append(const ScoreFile& part, ScoreFile& all) {
  all.scores.insert(all.scores.end(), part.scores.begin(), part.scores.end());
  all.specimens.insert(all.specimens.end(), part.specimens.begin(), part.specimens.end());
}

const std::vector<Column<ScoreRow>>& score_columns() {
  static const std::vector<Column<ScoreRow>> columns = {
      {"suite", &ScoreRow::suite},
      {"scene", &ScoreRow::scene},
      {"case", &ScoreRow::case_name},
      {"method", &ScoreRow::method},
      {"metric", &ScoreRow::metric},
      {"value", &ScoreRow::value},
      {"unit", &ScoreRow::unit},
      {"n", &ScoreRow::n},
      {"ci_low", &ScoreRow::ci_low},
      {"ci_high", &ScoreRow::ci_high},
      {"wall_s", &ScoreRow::wall_s},
      {"cpu_s", &ScoreRow::cpu_s},
      {"peak_rss_mb", &ScoreRow::peak_rss_mb},
      {"peak_above_start_mb", &ScoreRow::peak_above_start_mb},
      {"seed", &ScoreRow::seed},
      {"status", &ScoreRow::status},
      {"limit_low", &ScoreRow::limit_low},
      {"limit_high", &ScoreRow::limit_high},
      {"limit_n", &ScoreRow::limit_n},
      {"run", &ScoreRow::run},
      {"views", &ScoreRow::views},
      {"width_px", &ScoreRow::width_px},
      {"height_px", &ScoreRow::height_px},
      {"steps", &ScoreRow::steps},
      {"held_out_every", &ScoreRow::held_out_every},
      {"view_set", &ScoreRow::view_set},
      {"poses", &ScoreRow::poses},
      {"light", &ScoreRow::light},
  };
  return columns;
}

const std::vector<Column<SpecimenRow>>& specimen_columns() {
  static const std::vector<Column<SpecimenRow>> columns = {
      {"dataset", &SpecimenRow::dataset},   {"scene", &SpecimenRow::scene},
      {"frame", &SpecimenRow::frame},       {"instance", &SpecimenRow::instance},
      {"cultivar", &SpecimenRow::cultivar}, {"run", &SpecimenRow::run},
      {"method", &SpecimenRow::method},     {"trait", &SpecimenRow::trait},
      {"unit", &SpecimenRow::unit},         {"true", &SpecimenRow::truth},
      {"measured", &SpecimenRow::measured}, {"sigma", &SpecimenRow::sigma},
      {"status", &SpecimenRow::status},
  };
  return columns;
}

std::string photographs_of(const ScoreRow& row) {
  std::string text = row.scene;
  for (const std::int64_t number :
       {row.run, row.views, row.width_px, row.height_px, row.held_out_every})
    text += "\n" + std::to_string(number);
  return text + "\n" + row.view_set + "\n" + row.poses + "\n" + row.light;
}

ScoreRow limited(ScoreRow row, const ScoreLimit& limit) {
  row.limit_low = limit.low;
  row.limit_high = limit.high;
  row.limit_n = limit.least_n;
  const bool holds = !std::isnan(row.value) && !(row.value < limit.low) &&
                     !(row.value > limit.high) && row.n >= limit.least_n;
  row.status = holds ? ScoreStatus::pass : ScoreStatus::fail;
  return row;
}

ScoreRow with_interval(ScoreRow row, std::string metric, std::string unit,
                       const WithInterval& value, std::int64_t n) {
  row.metric = std::move(metric);
  row.unit = std::move(unit);
  row.value = value.value;
  row.ci_low = value.low;
  row.ci_high = value.high;
  row.n = n;
  return row;
}

std::vector<ScoreRow> score_rows(const ScoreRow& row, const std::string& trait,
                                 const std::string& unit, const TraitStatistics& s) {
  return {
      with_interval(row, trait + ".rmse", unit, s.rmse, s.n),
      with_interval(row, trait + ".mape", "1", s.mape, s.n),
      with_interval(row, trait + ".bias", unit, s.bias, s.n),
      with_interval(row, trait + ".slope", "1", s.slope, s.n),
      with_interval(row, trait + ".intercept", unit, s.intercept, s.n),
      with_interval(row, trait + ".r2_about_true_mean", "1", s.r2_about_true_mean, s.n),
      with_interval(row, trait + ".r2_paper", "1", s.r2_paper, s.n),
      with_interval(row, trait + ".limit_low", unit, s.limit_low, s.n),
      with_interval(row, trait + ".limit_high", unit, s.limit_high, s.n),
  };
}

std::vector<ScoreRow> score_rows(const ScoreRow& row, const std::string& trait,
                                 const SigmaCoverage& c) {
  return {
      with_interval(row, trait + ".coverage_68", "1", c.within_68, c.n),
      with_interval(row, trait + ".coverage_95", "1", c.within_95, c.n),
      with_interval(row, trait + ".normalised_rms", "1", {.value = c.normalised_rms}, c.n),
  };
}

}  // namespace cousin
