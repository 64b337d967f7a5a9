#include "benchmarks/tools/measure/measured_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "benchmarks/score/distributions.h"
#include "benchmarks/score/length_units.h"
#include "benchmarks/score/scores.h"

namespace cousin {
namespace {

constexpr double kUncheckedSigma = 0.005;
constexpr double kMostOff = 0.2;
constexpr double kNominal_mm = 100;

/// All of the text as a finite number.
bool read_number(std::string_view text, double& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() && std::isfinite(value);
}

std::string number_text(double value) {
  if (!std::isfinite(value)) return "";
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

}  // namespace

PrintScale print_scale_of_ruler(const std::string& text, double reading_sigma_mm) {
  const std::size_t slash = text.find('/');
  const std::string_view all = text;
  double read_mm = 0, nominal_mm = kNominal_mm;
  const bool is_number = read_number(all.substr(0, slash), read_mm) &&
                         (slash == text.npos || read_number(all.substr(slash + 1), nominal_mm));
  if (!is_number || !(nominal_mm > 0))
    throw std::invalid_argument("--ruler \"" + text +
                                "\": give the millimetres that you read for the printed 100 mm, as "
                                "99.7, or of another length 149.6/150");
  PrintScale scale;
  scale.factor = read_mm / nominal_mm;
  scale.sigma = reading_sigma_mm / nominal_mm;
  if (!(std::abs(scale.factor - 1) <= kMostOff))
    throw std::invalid_argument("--ruler \"" + text + "\": the print would be off by more than " +
                                std::to_string(static_cast<int>(100 * kMostOff)) +
                                " %; read millimetres, and print the board again at 100 %");
  char words[160];
  std::snprintf(words, sizeof words,
                "By its ruler the board is printed at %.2f %% (95 %%: %.2f to %.2f).",
                100 * scale.factor, 100 * (scale.factor - kSigmas95 * scale.sigma),
                100 * (scale.factor + kSigmas95 * scale.sigma));
  scale.from = words;
  return scale;
}

PrintScale unchecked_print() {
  return {1, kUncheckedSigma,
          "Nobody has checked the print's ruler: a scale of 100 % with a standard deviation of "
          "0.5 % is assumed, which is part of every interval (--ruler MM takes what you read)."};
}

PrintScale exact_print() { return {1, 0, "The simulated board has its nominal size."}; }

std::vector<MeasuredRow> measured_rows(const MeasuredSample& sample) {
  std::vector<MeasuredRow> rows;
  for (const SpecimenTraits& seed : sample.traits) {
    MeasuredRow row;
    row.sample = sample.name;
    row.source = sample.source;
    row.seed = seed.instance;
    row.status = to_string(seed.status);
    row.reason = seed.reason;
    if (seed.status != TraitStatus::ok) {
      rows.push_back(row);
      continue;
    }
    for (const Trait& trait : seed.traits) {
      const LengthUnit unit = length_unit(trait.unit);
      const double scale = std::pow(sample.scale.factor, unit.power);
      row.trait = trait.name;
      row.unit = trait.unit;
      row.value = trait.value * unit.factor * scale;
      row.own_sigma = trait.sigma * unit.factor * scale;
      const double of_print = row.value * unit.power * sample.scale.sigma / sample.scale.factor;
      const double half = kSigmas95 * std::hypot(row.own_sigma, of_print);
      row.low = row.value - half;
      row.high = row.value + half;
      rows.push_back(row);
    }
  }
  return rows;
}

int count_measured(const Traits& traits) {
  return static_cast<int>(
      std::count_if(traits.begin(), traits.end(),
                    [](const SpecimenTraits& seed) { return seed.status == TraitStatus::ok; }));
}

std::string to_tidy_csv(const std::vector<MeasuredRow>& rows, const std::string& group) {
  std::string text = "sample,";
  if (!group.empty()) text += csv_cell(group) + ",";
  text += "seed,trait,unit,value,low,high,status,reason\n";
  for (const MeasuredRow& row : rows) {
    text += csv_cell(row.sample) + ",";
    if (!group.empty()) text += csv_cell(row.source) + ",";
    text += std::to_string(row.seed) + "," + csv_cell(row.trait) + "," +
            csv_cell(std::string(length_unit(row.unit).millimetres)) + "," +
            number_text(row.value) + "," + number_text(row.low) + "," + number_text(row.high) +
            "," + csv_cell(row.status) + "," + csv_cell(row.reason) + "\n";
  }
  return text;
}

}  // namespace cousin
