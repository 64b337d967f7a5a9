#include "benchmarks/report/verdict.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>
#include <vector>

#include "benchmarks/report/shown_numbers.h"
#include "sim/types/trait_table.h"

namespace cousin {
namespace {

constexpr std::size_t kMostTraits = 3;

std::string method_shown(const std::vector<SpecimenRow>& specimens) {
  const bool has_ours = std::any_of(specimens.begin(), specimens.end(),
                                    [](const SpecimenRow& row) { return row.method == "ours"; });
  return has_ours ? "ours" : specimens.front().method;
}

/// "42 of 47 objects in images" of a method: a fruit in two views is two, as internodes are.
std::string measured_text(const std::vector<SpecimenRow>& specimens, const std::string& method) {
  std::set<std::tuple<std::string, std::string, std::int64_t, std::int64_t>> all, measured;
  bool are_in_images = false;
  for (const SpecimenRow& row : specimens) {
    if (row.method != method) continue;
    are_in_images = are_in_images || row.frame >= 0;
    const std::tuple which(row.dataset + "/" + row.scene, row.run, row.frame, row.instance);
    all.insert(which);
    if (row.status == ScoreStatus::ok) measured.insert(which);
  }
  return std::to_string(measured.size()) + " of " + std::to_string(all.size()) +
         (are_in_images ? " objects in images" : " specimens");
}

/// RMSE of a trait over all that a method measured; null where it was not pooled.
const ScoreRow* rmse_of(const std::vector<ScoreRow>& rows, const std::string& method,
                        std::string_view trait) {
  const ScoreRow* found = nullptr;
  for (const ScoreRow& row : rows) {
    if (row.scene != "pooled" || row.method != method || std::isnan(row.value) ||
        row.metric != std::string(trait) + ".rmse")
      continue;
    if (found == nullptr || row.case_name == "all" || row.n > found->n) found = &row;
  }
  return found;
}

std::string errors_text(const std::vector<ScoreRow>& rows, const std::string& method) {
  std::string text;
  std::size_t count = 0;
  for (const TraitRow& trait : trait_table()) {
    const ScoreRow* row = rmse_of(rows, method, trait.name);
    if (row == nullptr || count == kMostTraits) continue;
    const ShownUnit unit = shown_unit(row->unit, row->metric);
    text += (count == 0 ? ": RMSE of " : ", of ") + std::string(trait.name) + " " +
            shown_interval({row->value, row->ci_low, row->ci_high}, unit.factor) + " " + unit.name;
    ++count;
  }
  return text;
}

}  // namespace

std::string verdict(const ScoreFile& file) {
  std::string text;
  if (!file.specimens.empty()) {
    const std::string method = method_shown(file.specimens);
    text = measured_text(file.specimens, method) + " are measured by " + method +
           errors_text(file.scores, method) + ".";
  }
  const auto count = [&](ScoreStatus status) {
    return std::count_if(file.scores.begin(), file.scores.end(),
                         [&](const ScoreRow& row) { return row.status == status; });
  };
  const auto kept = count(ScoreStatus::pass), broken = count(ScoreStatus::fail);
  if (kept + broken > 0)
    text += (text.empty() ? "" : " ") + std::to_string(kept) + " of " +
            std::to_string(kept + broken) + " numbers keep their limit.";
  return text;
}

}  // namespace cousin
