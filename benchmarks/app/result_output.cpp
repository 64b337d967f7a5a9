#include "benchmarks/app/result_output.h"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include "benchmarks/app/terminal.h"
#include "benchmarks/loop/result_folder.h"
#include "benchmarks/loop/score_seeds.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

nlohmann::json readable(const nlohmann::json& value) {
  if (value.is_string()) return readable_utf8(value.get_ref<const std::string&>());
  nlohmann::json result = value;
  if (value.is_structured()) {
    for (auto& element : result) element = readable(element);
  }
  return result;
}

}  // namespace

ExitCode check_gates(const Options& options, const std::vector<ScoreRow>& rows) {
  bool all_hold = true;
  for (const std::string& text : options.gates) {
    for (const std::string& problem : broken(parse_gate(text), rows)) {
      print_message("gate " + text + ": " + problem);
      all_hold = false;
    }
  }
  return all_hold ? ExitCode::done : ExitCode::gate_failed;
}

void print_rows(const std::vector<ScoreRow>& rows) {
  for (const ScoreRow& row : rows) {
    const std::string status =
        row.status == ScoreStatus::ok ? "" : " " + std::string(to_string(row.status));
    std::printf("%s %-34s %14.6g %s%s\n", terminal_text(row.scene).c_str(),
                terminal_text(row.metric).c_str(), row.value,
                row.unit == "1" ? "" : terminal_text(row.unit).c_str(), status.c_str());
  }
}

void print_result(const Options& options, const ScoreFile& file) {
  if (options.json) {
    std::printf("%s", to_json(file).c_str());
  } else if (file.specimens.empty()) {
    print_rows(file.scores);
  } else {
    std::printf("%s", summary_table(file.scores).c_str());
  }
}

void print_json(const nlohmann::json& value) {
  std::printf("%s\n", readable(value).dump(2).c_str());
}

void print_plan(const Options& options, const std::vector<PlanEntry>& plan) {
  if (!options.json) {
    std::printf("%s", describe(plan).c_str());
    return;
  }
  nlohmann::json rows = nlohmann::json::array();
  for (const PlanEntry& entry : plan)
    rows.push_back({{"pass", entry.pass}, {"runs", entry.runs}, {"why", entry.why}});
  print_json(rows);
}

}  // namespace cousin
