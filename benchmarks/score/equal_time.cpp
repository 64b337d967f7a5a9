#include "benchmarks/score/equal_time.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace cousin {
namespace {

/// Seconds that methods are held beside each other at. Wall time is what a user waits; what runs
/// beside disturbs CPU time far less.
struct SecondsKind {
  const char* name;
  double ScoreRow::*column;
};
constexpr SecondsKind kSecondsKinds[] = {{"seconds", &ScoreRow::wall_s},
                                         {"cpu_seconds", &ScoreRow::cpu_s}};

/// The last of rows that rise in their seconds that was there by then; null if none was. Each is a
/// training of its own, so there is nothing between two of them.
const ScoreRow* finished_by(const std::vector<const ScoreRow*>& sweep, double ScoreRow::*column,
                            double seconds) {
  if (sweep.empty()) return nullptr;
  const auto after = std::find_if(sweep.begin(), sweep.end(),
                                  [&](const ScoreRow* row) { return row->*column > seconds; });
  return after == sweep.begin() ? nullptr : *(after - 1);
}

/// Whether the two are known to be of different machines.
bool is_elsewhere(const ScoreRow& a, const ScoreRow& b, const TrainingMachines& machines) {
  const auto first = machines.find(training_of(a)), second = machines.find(training_of(b));
  return first != machines.end() && second != machines.end() && !first->second.empty() &&
         !second->second.empty() && first->second != second->second;
}

/// Snapshots of the same photographs and metric, by their seconds.
struct Sweeps {
  std::vector<const ScoreRow*> reference, ours;
};

}  // namespace

std::string training_of(const ScoreRow& row) {
  return row.scene + "\n" + row.method + "\n" + row.case_name;
}

std::vector<ScoreRow> equal_time_rows(const std::vector<ScoreRow>& rows,
                                      const EqualTimeQuestion& question) {
  std::set<std::string> failed;  // photographs
  for (const ScoreRow& row : rows) {
    if (row.method == question.reference && row.status == ScoreStatus::not_solved &&
        row.metric.starts_with("training: "))
      failed.insert(photographs_of(row));
  }
  std::map<std::pair<std::string, std::string>, Sweeps> all;
  for (const ScoreRow& row : rows) {
    const std::int64_t own = row.steps;
    if (own == 0 || std::find(question.metrics.begin(), question.metrics.end(), row.metric) ==
                        question.metrics.end())
      continue;
    const std::string photographs = photographs_of(row);
    if (failed.contains(photographs)) continue;
    Sweeps& sweeps = all[{photographs, row.metric}];
    if (row.method == question.reference && own <= question.reference_steps)
      sweeps.reference.push_back(&row);
    if (row.method == question.ours) sweeps.ours.push_back(&row);
  }
  std::vector<ScoreRow> gains;
  for (auto& [key, sweeps] : all) {
    if (sweeps.reference.empty() || sweeps.ours.empty()) continue;
    for (const SecondsKind& kind : kSecondsKinds) {
      const auto by_seconds = [&](const ScoreRow* a, const ScoreRow* b) {
        return a->*kind.column < b->*kind.column;
      };
      const auto has_none = [&](const ScoreRow* row) { return !(row->*kind.column > 0); };
      if (std::any_of(sweeps.reference.begin(), sweeps.reference.end(), has_none) ||
          std::any_of(sweeps.ours.begin(), sweeps.ours.end(), has_none))
        continue;
      const ScoreRow& last =
          **std::max_element(sweeps.reference.begin(), sweeps.reference.end(), by_seconds);
      std::vector<const ScoreRow*> comparable;
      for (const ScoreRow* row : sweeps.ours) {
        if (!is_elsewhere(*row, last, question.machines)) comparable.push_back(row);
      }
      std::sort(comparable.begin(), comparable.end(), by_seconds);
      const ScoreRow* ours = finished_by(comparable, kind.column, last.*kind.column);
      if (ours == nullptr || ours->n != last.n) continue;
      ScoreRow row = last;
      row.metric += std::string("_gain_at_equal_") + kind.name;
      row.value = ours->value - last.value;
      row.method = question.ours;
      gains.push_back(row);
    }
  }
  return gains;
}

}  // namespace cousin
