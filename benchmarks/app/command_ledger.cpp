// ledger: what is said of real captures before they are measured, and what came of it.
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "benchmarks/app/commands.h"
#include "benchmarks/app/option_keys.h"
#include "benchmarks/app/result_output.h"
#include "benchmarks/app/terminal.h"
#include "benchmarks/report/report.h"
#include "benchmarks/tools/ledger/ledger.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

void expect_words(const Options& o, std::size_t count, const char* form) {
  if (o.arguments.size() != count)
    throw std::invalid_argument("ledger " + o.arguments.at(0) + " takes " + form);
}

double number_of(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value))
    throw std::invalid_argument("\"" + text + "\" is no number");
  return value;
}

std::string text_of(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return std::isnan(value) ? "" : text;
}

void print_table(const std::vector<LedgerRow>& rows) {
  ReportTable table;
  table.title = "Predictions about real captures";
  table.columns = {"prediction", "set", "what", "from", "to", "unit", "outcome", "status"};
  for (const LedgerRow& row : rows) {
    const Prediction& p = row.prediction;
    table.lines.push_back({p.id, p.set, p.what, text_of(p.low), text_of(p.high), p.unit,
                           text_of(row.outcome), std::string(to_string(row.status))});
  }
  print_result_lines(table_text(table));
}

ExitCode show(const Options& o, const fs::path& file) {
  const std::vector<LedgerEntry> entries = read_ledger(file);
  const std::vector<LedgerRow> rows =
      judge_ledger(entries, commits_of_lines(file), is_older_in(fs::absolute(file).parent_path()));
  if (!o.json) {
    print_table(rows);
    return ExitCode::done;
  }
  nlohmann::json list = nlohmann::json::array();
  for (const LedgerRow& row : rows) {
    const Prediction& p = row.prediction;
    list.push_back(
        {{"prediction", p.id},
         {"set", p.set},
         {"what", p.what},
         {"unit", p.unit},
         {"low", p.low},
         {"high", p.high},
         {"why", p.why},
         {"outcome", std::isnan(row.outcome) ? nlohmann::json() : nlohmann::json(row.outcome)},
         {"command", row.command},
         {"status", to_string(row.status)}});
  }
  print_json(list);
  return ExitCode::done;
}

}  // namespace

ExitCode command_ledger(const JobContext& context) {
  const Options& o = context.options;
  const fs::path file = o.ledger_file;
  const std::string what = o.arguments.empty() ? "show" : o.arguments[0];
  if (what == "show") return show(o, file);
  if (what == "predict") {
    expect_words(o, 6, "ID SET WHAT LOW HIGH, with --unit and --why");
    append_to_ledger(
        file, Prediction{o.arguments[1], o.arguments[2], o.arguments[3], o.ledger_unit,
                         number_of(o.arguments[4]), number_of(o.arguments[5]), o.ledger_why});
  } else if (what == "outcome") {
    expect_words(o, 4, "ID VALUE COMMAND");
    append_to_ledger(file,
                     LedgerOutcome{o.arguments[1], number_of(o.arguments[2]), o.arguments[3]});
  } else if (what == "seen") {
    expect_words(o, 2, "SET, with --why");
    append_to_ledger(file, SeenSet{o.arguments[1], o.ledger_why});
  } else {
    throw std::invalid_argument("ledger \"" + what +
                                "\" is not one of: show, predict, outcome, seen");
  }
  context.progress.line("added to " + file.string() + "; it counts from the commit that has it");
  return ExitCode::done;
}

}  // namespace cousin
