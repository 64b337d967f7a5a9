#include "benchmarks/tools/ledger/ledger.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <stdexcept>
#include <system_error>

#include "sim/dataset/atomic_file.h"
#include "sim/process/program_run.h"
#include "sim/process/scratch_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
constexpr std::size_t kLimit_bytes = std::size_t{1} << 26;
constexpr double kGitLimit_s = 60;

// ---- Lines
// ---------------------------------------------------------------------------------------

/// A line of the file, for messages.
class Line {
 public:
  Line(const std::string& file, std::size_t number, const std::string& text)
      : where_(file + ": line " + std::to_string(number)) {
    try {
      json_ = Json::parse(text);
    } catch (const nlohmann::json::exception& error) {
      fail(std::string("is not JSON: ") + error.what());
    }
    if (!json_.is_object()) fail("is no object");
  }
  bool has(const char* key) const { return json_.contains(key); }
  void expect_keys(const std::set<std::string>& keys) const {
    for (const auto& [key, value] : json_.items()) {
      if (!keys.contains(key)) fail("has the unknown key \"" + key + "\"");
    }
    for (const std::string& key : keys) {
      if (!json_.contains(key)) fail("has no \"" + key + "\"");
    }
  }
  std::string text(const char* key) const {
    if (!json_[key].is_string() || json_[key].get<std::string>().empty())
      fail(std::string("\"") + key + "\" is no text");
    return json_[key].get<std::string>();
  }
  double number(const char* key) const {
    if (!json_[key].is_number() || !std::isfinite(json_[key].get<double>()))
      fail(std::string("\"") + key + "\" is no finite number");
    return json_[key].get<double>();
  }
  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error(where_ + " " + what);
  }

 private:
  std::string where_;
  Json json_;
};

LedgerEntry entry_of(const Line& line) {
  if (line.has("prediction")) {
    line.expect_keys({"prediction", "set", "what", "unit", "low", "high", "why"});
    Prediction p{line.text("prediction"), line.text("set"),    line.text("what"), line.text("unit"),
                 line.number("low"),      line.number("high"), line.text("why")};
    const bool is_word = std::all_of(p.id.begin(), p.id.end(), [](char c) {
      return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_';
    });
    if (!is_word) line.fail("\"prediction\" is not of letters, digits, - and _");
    if (!(p.low < p.high)) line.fail("\"low\" is not below \"high\"");
    return p;
  }
  if (line.has("outcome")) {
    line.expect_keys({"outcome", "value", "command"});
    return LedgerOutcome{line.text("outcome"), line.number("value"), line.text("command")};
  }
  if (line.has("seen")) {
    line.expect_keys({"seen", "why"});
    return SeenSet{line.text("seen"), line.text("why")};
  }
  line.fail("is neither a prediction, an outcome nor a seen set");
}

std::string text_of(const LedgerEntry& entry) {
  Json json;
  if (const auto* p = std::get_if<Prediction>(&entry)) {
    json = {{"prediction", p->id}, {"set", p->set},   {"what", p->what}, {"unit", p->unit},
            {"low", p->low},       {"high", p->high}, {"why", p->why}};
  } else if (const auto* o = std::get_if<LedgerOutcome>(&entry)) {
    json = {{"outcome", o->id}, {"value", o->value}, {"command", o->command}};
  } else {
    const auto& seen = std::get<SeenSet>(entry);
    json = {{"seen", seen.set}, {"why", seen.why}};
  }
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::vector<LedgerEntry> entries_of(const std::string& text, const std::string& name) {
  std::vector<LedgerEntry> entries;
  std::set<std::string> ids, ended;
  std::istringstream lines(text);
  std::size_t number = 0;
  for (std::string words; std::getline(lines, words);) {
    const Line line(name, ++number, words);
    entries.push_back(entry_of(line));
    if (const auto* p = std::get_if<Prediction>(&entries.back())) {
      if (!ids.insert(p->id).second) line.fail("has the prediction \"" + p->id + "\" again");
    } else if (const auto* o = std::get_if<LedgerOutcome>(&entries.back())) {
      if (!ids.contains(o->id))
        line.fail("is the outcome of no prediction above, \"" + o->id + "\"");
      if (!ended.insert(o->id).second) line.fail("is a second outcome of \"" + o->id + "\"");
    }
  }
  return entries;
}

// ---- git
// -----------------------------------------------------------------------------------------

/// What git prints. @param allowed  an exit code that is an answer too
std::string git(const fs::path& folder, std::vector<std::string> words, int allowed = 0,
                int* code = nullptr) {
  const ScratchFolder scratch("cousin-git");
  const fs::path log = scratch.path() / "out";
  std::vector<std::string> all = {"git", "-C", folder.string()};
  all.insert(all.end(), words.begin(), words.end());
  const ProgramOutcome outcome =
      run_program({.words = std::move(all), .log = log, .time_limit_s = kGitLimit_s});
  if (code) *code = outcome.code;
  const bool is_answer = outcome.end == ProgramEnd::exited &&
                         (outcome.code == 0 || (allowed != 0 && outcome.code == allowed));
  if (!is_answer)
    throw std::runtime_error(folder.string() + ": git " + words.front() + ": " + outcome.reason +
                             last_lines(log));
  return read_file(log, kLimit_bytes);
}

fs::path folder_of(const fs::path& file) {
  const fs::path folder = fs::absolute(file).parent_path();
  return folder.empty() ? fs::path(".") : folder;
}

}  // namespace

std::string_view to_string(LedgerStatus status) {
  switch (status) {
    case LedgerStatus::open:
      return "open";
    case LedgerStatus::kept:
      return "kept";
    case LedgerStatus::missed:
      return "missed";
    case LedgerStatus::seen:
      return "seen";
    case LedgerStatus::not_older:
      return "not_older";
    case LedgerStatus::not_committed:
      break;
  }
  return "not_committed";
}

std::vector<LedgerEntry> read_ledger(const fs::path& file) {
  return entries_of(read_file(file, kLimit_bytes), file.string());
}

void append_to_ledger(const fs::path& file, const LedgerEntry& entry) {
  const std::string before = fs::exists(file) ? read_file(file, kLimit_bytes) : std::string();
  entries_of(before, file.string());  // whose faults are not the new line's
  const std::string line = (before.empty() || before.back() == '\n' ? "" : "\n") + text_of(entry);
  try {
    entries_of(before + line, file.string());
  } catch (const std::runtime_error& error) {
    throw std::invalid_argument(error.what());
  }
  if (file.has_parent_path()) fs::create_directories(file.parent_path());
  const int out = ::open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  const bool is_written =
      out >= 0 && ::write(out, line.data(), line.size()) == static_cast<ssize_t>(line.size());
  const int problem = errno;
  if (out >= 0) ::close(out);
  if (!is_written)
    throw std::runtime_error(file.string() +
                             ": cannot be written: " + std::system_category().message(problem));
}

std::vector<std::string> commits_of_lines(const fs::path& file) {
  const std::string name = file.filename().string();
  int code = -1;
  git(folder_of(file), {"rev-parse", "--verify", "-q", "HEAD"}, 1,
      &code);  // says if there is no git
  const bool is_known =
      code == 0 && !git(folder_of(file), {"ls-tree", "--name-only", "HEAD", "--", name}).empty();
  if (!is_known) {
    const std::string text = read_file(file, kLimit_bytes);
    const auto lines = std::count(text.begin(), text.end(), '\n');
    return std::vector<std::string>(static_cast<std::size_t>(lines));
  }
  const std::string blame =
      git(folder_of(file), {"blame", "--line-porcelain", "--", file.filename().string()});
  std::vector<std::string> commits;
  std::istringstream lines(blame);
  std::string commit;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("\t")) {
      const bool is_none = commit.find_first_not_of('0') == std::string::npos;
      commits.push_back(is_none ? "" : commit);
    } else if (const std::size_t blank = line.find(' ');
               (blank == 40 || blank == 64) &&
               line.find_first_not_of("0123456789abcdef") == blank) {
      commit = line.substr(0, blank);
    }
  }
  return commits;
}

IsOlder is_older_in(const fs::path& repository) {
  return [repository](const std::string& older, const std::string& newer) {
    if (older == newer) return false;
    int code = -1;
    git(repository, {"merge-base", "--is-ancestor", older, newer}, 1, &code);
    return code == 0;
  };
}

std::vector<LedgerRow> judge_ledger(const std::vector<LedgerEntry>& entries,
                                    const std::vector<std::string>& commits,
                                    const IsOlder& is_older) {
  if (commits.size() != entries.size())
    throw std::invalid_argument("a ledger of " + std::to_string(entries.size()) + " lines has " +
                                std::to_string(commits.size()) + " commits");
  // A line tells of its set's results from its commit on; of one commit, from its place on.
  const auto is_before = [&](std::size_t a, std::size_t b) {
    if (commits[a] == commits[b]) return a < b;
    return commits[b].empty() || (!commits[a].empty() && is_older(commits[a], commits[b]));
  };
  std::map<std::string, std::size_t> predicted;  // places by id
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (const auto* p = std::get_if<Prediction>(&entries[i])) predicted[p->id] = i;
  }
  const auto set_told_by = [&](std::size_t i) -> std::string {
    if (const auto* seen = std::get_if<SeenSet>(&entries[i])) return seen->set;
    if (const auto* o = std::get_if<LedgerOutcome>(&entries[i]))
      return std::get<Prediction>(entries[predicted.at(o->id)]).set;
    return {};
  };
  std::vector<LedgerRow> rows;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const auto* p = std::get_if<Prediction>(&entries[i]);
    if (!p) continue;
    LedgerRow& row = rows.emplace_back();
    row.prediction = *p;
    if (commits[i].empty()) row.status = LedgerStatus::not_committed;
    for (std::size_t k = 0; k < entries.size(); ++k) {
      const auto* o = std::get_if<LedgerOutcome>(&entries[k]);
      if (o && o->id == p->id) {
        row.outcome = o->value;
        row.command = o->command;
        if (row.status != LedgerStatus::open) continue;
        const bool counts = commits[k].empty() || is_older(commits[i], commits[k]);
        const bool is_inside = o->value >= p->low && o->value <= p->high;
        row.status = !counts     ? LedgerStatus::not_older
                     : is_inside ? LedgerStatus::kept
                                 : LedgerStatus::missed;
      } else if (set_told_by(k) == p->set && is_before(k, i)) {
        row.status = LedgerStatus::seen;
      }
    }
  }
  return rows;
}

}  // namespace cousin
