#include "benchmarks/loop/result_folder.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <set>
#include <thread>
#include <tuple>

#include "sim/dataset/atomic_file.h"
#include "sim/types/memory_limit.h"
#include "sim/types/trait_table.h"
#include "sim/types/utf8.h"
#include "sim/types/whole_file.h"

namespace cousin {
namespace fs = std::filesystem;

void require_writable(const fs::path& folder) {
  const fs::path file = folder / temporary_name("write_test");
  write_file(file, std::string(std::size_t{1} << 16, ' '));
  std::error_code ignored;
  fs::remove(file, ignored);
}

std::vector<std::string> result_names(std::vector<std::string> more) {
  for (const char* name : {"scores.csv", "specimens.csv", "scores.json"}) more.emplace_back(name);
  return more;
}

void write_result_tables(const fs::path& folder, const ScoreFile& file) {
  write_file(folder / "scores.csv", to_csv(file.scores));
  write_file(folder / "specimens.csv", to_csv(file.specimens));
  write_file(folder / "scores.json", to_json(file));
}

ScoreFile read_result_tables(const fs::path& folder) {
  const fs::path file = folder / "scores.json";
  // What JSON of the least words takes a byte.
  constexpr std::uint64_t kMemoryPerByte = 32;
  const std::string text = read_file(file);
  check_memory(file, bytes_times(text.size(), kMemoryPerByte), "its JSON");
  return scores_from_json(text, file.string());
}

std::string machine_text() {
  std::string processor = "unknown processor";
  std::ifstream cpuinfo("/proc/cpuinfo");
  for (std::string line; std::getline(cpuinfo, line);) {
    if (line.starts_with("model name")) {
      processor = line.substr(line.find(':') + 2);
      break;
    }
  }
  double memory_gib = 0;
  std::ifstream meminfo("/proc/meminfo");
  std::string key;
  double kib = 0;
  if (meminfo >> key >> kib) memory_gib = kib / (1 << 20);
  char text[160];
  std::snprintf(text, sizeof text, "%s, %u cores, %.0f GiB", processor.c_str(),
                std::thread::hardware_concurrency(), memory_gib);
  return text;
}

std::string summary_table(const std::vector<ScoreRow>& rows) {
  // (suite, case, method, trait) -> metric -> value
  std::map<std::tuple<std::string, std::string, std::string, std::string>,
           std::map<std::string, const ScoreRow*>>
      table;
  for (const ScoreRow& row : rows) {
    const std::size_t dot = row.metric.find('.');
    if (dot == std::string::npos) continue;
    const std::string trait = row.metric.substr(0, dot);
    if (find_trait(trait))
      table[{row.suite, row.case_name, row.method, trait}][row.metric.substr(dot + 1)] = &row;
  }
  std::string text;
  char line[200];
  std::snprintf(line, sizeof line, "%-18s %-18s %-12s %-8s %4s %18s %9s %8s %7s %8s\n", "suite",
                "case", "method", "trait", "n", "RMSE", "bias", "MAPE %", "slope", "cover 95");
  const std::string head = line;
  // One cultivar is its species too: each number once.
  std::set<std::tuple<std::string, std::string, std::string, std::int64_t, double>> shown_before;
  for (const auto& [key, metrics] : table) {
    const auto& [suite, case_name, method, trait] = key;
    const auto found = metrics.find("rmse");
    if (found == metrics.end() || !metrics.contains("slope")) continue;
    const double rmse = found->second->value;
    if (!std::isnan(rmse) &&
        !shown_before.emplace(suite, method, trait, found->second->n, rmse).second)
      continue;
    const auto value = [&](const char* metric) {
      const auto it = metrics.find(metric);
      return it == metrics.end() ? ScoreRow::kNone : it->second->value;
    };
    char mape[16] = "-";  // of a trait that may be 0
    if (metrics.contains("mape")) std::snprintf(mape, sizeof mape, "%.2f", value("mape") * 100);
    const TraitRow& shown = trait_row(trait);
    std::string unit(shown.shown);
    const auto characters = std::count_if(unit.begin(), unit.end(), [](char c) {
      return (static_cast<unsigned char>(c) & 0xC0) != 0x80;
    });
    unit.append(static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, 4 - characters)), ' ');
    std::snprintf(
        line, sizeof line, "%-18s %-18s %-12s %-8s %4lld %13.4f %s %+9.4f %8s %7.3f %8.2f\n",
        terminal_text(suite).c_str(), terminal_text(case_name).c_str(),
        terminal_text(method).c_str(), terminal_text(trait).c_str(),
        static_cast<long long>(found->second->n), value("rmse") * shown.factor, unit.c_str(),
        value("bias") * shown.factor, mape, value("slope"), value("coverage_95"));
    text += line;
  }
  return text.empty() ? text : head + text;
}

}  // namespace cousin
