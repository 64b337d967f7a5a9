#pragma once

#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <variant>
#include <vector>

namespace cousin {

/// What somebody says a real set will give, before it is measured.
struct Prediction {
  std::string id;    ///< one of its own: letters, digits, - and _
  std::string set;   ///< "multiview/fox"
  std::string what;  ///< "share of pixels with a depth"
  std::string unit;  ///< SI; "1" for ratios
  double low = 0, high = 0;
  std::string why;
};

/// What it gave.
struct LedgerOutcome {
  std::string id;  ///< of the prediction
  double value = 0;
  std::string command;  ///< that printed it
};

/// A set whose results were known at that time: no later prediction of it is blind.
struct SeenSet {
  std::string set;
  std::string why;
};

using LedgerEntry = std::variant<Prediction, LedgerOutcome, SeenSet>;

/// The ledger: a file of lines that only grows, a JSON object a line. The commit that added a line
/// says when it was written, so that no line can claim to be older than it is.
///   {"prediction": "fox-depth", "set", "what", "unit", "low", "high", "why"}
///   {"outcome": "fox-depth", "value", "command"}
///   {"seen": "multiview/fox", "why"}
/// @throws std::runtime_error naming file, line, key and what is wrong: a prediction whose id was
/// used, an outcome of none, limits that are not in order
std::vector<LedgerEntry> read_ledger(const std::filesystem::path& file);

/// Adds a line at the end, in one write, made with its folder if need be.
/// @throws std::invalid_argument if the ledger would not be read with it
void append_to_ledger(const std::filesystem::path& file, const LedgerEntry& entry);

/// The commit that added each line; empty for a line that is not committed.
/// @throws std::runtime_error where git or the repository is absent
std::vector<std::string> commits_of_lines(const std::filesystem::path& file);

/// Whether `older` is a commit before `newer`, not the same.
using IsOlder = std::function<bool(const std::string& older, const std::string& newer)>;
IsOlder is_older_in(const std::filesystem::path& repository);

enum class LedgerStatus {
  open,           ///< no outcome yet
  kept,           ///< the outcome is in the interval
  missed,         ///< it is not
  seen,           ///< the set's results were known before: no blind prediction
  not_older,      ///< the outcome's commit is not after the prediction's: it does not count
  not_committed,  ///< the prediction is in no commit yet
};
std::string_view to_string(LedgerStatus status);

struct LedgerRow {
  Prediction prediction;
  double outcome = std::numeric_limits<double>::quiet_NaN();
  std::string command;
  LedgerStatus status = LedgerStatus::open;
};

/// @param commits  of the lines, as commits_of_lines gives them
std::vector<LedgerRow> judge_ledger(const std::vector<LedgerEntry>& entries,
                                    const std::vector<std::string>& commits,
                                    const IsOlder& is_older);

}  // namespace cousin
