#include "benchmarks/study/shard.h"

#include <algorithm>
#include <charconv>
#include <exception>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/manifest.h"
#include "sim/types/whole_file.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

int parse_whole(std::string_view text, const std::string& all) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw std::invalid_argument("--shard \"" + all + "\" is not i/n with 0 <= i < n");
  }
  return value;
}

/// The first line of a result file: what the result is of, and what it is. A file that was cut off,
/// wherever that was, has another text than its line says.
std::string first_line(const std::string& key_hash, std::string_view text) {
  return key_hash + " " + sha256_hex(text);
}

/// The text of a whole result of that key.
std::optional<std::string> stored_result(const fs::path& file, const std::string& key_hash) {
  if (!fs::exists(file)) return std::nullopt;
  const std::string bytes = read_file(file);
  const std::size_t line_end = bytes.find('\n');
  if (line_end == std::string::npos || !bytes.starts_with(key_hash)) return std::nullopt;
  std::string text = bytes.substr(line_end + 1);
  if (bytes.substr(0, line_end) != first_line(key_hash, text)) return std::nullopt;
  return text;
}

}  // namespace

Shard parse_shard(const std::string& text) {
  if (text.empty()) return {};
  const std::size_t slash = text.find('/');
  if (slash == std::string::npos) {
    throw std::invalid_argument("--shard \"" + text + "\" is not i/n with 0 <= i < n");
  }
  const std::string_view view(text);
  const Shard shard{parse_whole(view.substr(0, slash), text),
                    parse_whole(view.substr(slash + 1), text)};
  if (shard.count < 1 || shard.count > 100000 || shard.index < 0 || shard.index >= shard.count) {
    throw std::invalid_argument("--shard \"" + text + "\" is not i/n with 0 <= i < n <= 100000");
  }
  return shard;
}

std::pair<int, int> shard_range(const Shard& shard, int size) {
  const auto cut = [&](int i) {
    return static_cast<int>(static_cast<long long>(size) * i / shard.count);
  };
  return {cut(shard.index), cut(shard.index + 1)};
}

ShardJob shard_of(GridJob job, std::string key, std::function<std::string()> run,
                  fs::path unfinished) {
  std::string file = job.name + ".json";
  return {std::move(file), std::move(key), std::move(run), std::move(unfinished), std::move(job)};
}

std::vector<ShardJob> shards_of(const Grid& grid, const std::string& prefix,
                                const std::vector<std::string>& sets,
                                const std::function<std::string(const GridJob&)>& run) {
  std::vector<ShardJob> jobs;
  for (GridJob& job : jobs_of(grid)) {
    std::string key = prefix + "/" + job.name;
    for (const std::string& set : job.sets) key += "\n" + set;
    for (const std::string& set : sets) key += "\n" + set;
    jobs.push_back(shard_of(job, std::move(key), [run, job] { return run(job); }));
  }
  return jobs;
}

std::vector<ShardJob> jobs_named(std::vector<ShardJob> jobs, const std::string& parts) {
  constexpr std::size_t kNamed = 5;
  std::string some;
  for (std::size_t i = 0; i < std::min(kNamed, jobs.size()); ++i)
    some += (i == 0 ? "" : ", ") + jobs[i].name;
  const std::size_t count = jobs.size();
  std::vector<std::string> any;
  std::istringstream text(parts);
  for (std::string part; std::getline(text, part, ',');) any.push_back(part);
  std::erase_if(jobs, [&](const ShardJob& job) {
    return !any.empty() && std::none_of(any.begin(), any.end(), [&](const std::string& part) {
      return job.name.find(part) != std::string::npos;
    });
  });
  if (jobs.empty() && count > 0) {
    throw std::invalid_argument("no job's name holds \"" + parts + "\"; there are " +
                                std::to_string(count) + ": " + some +
                                (count > kNamed ? ", ... (--list prints them all)" : ""));
  }
  return jobs;
}

bool is_finished(const fs::path& folder, const ShardJob& job) {
  return stored_result(folder / job.name, sha256_hex(job.key)).has_value();
}

bool is_missing(const ShardResult& result) { return result.text.empty() && result.error.empty(); }

std::vector<ShardResult> run_shards(
    const fs::path& folder, const std::vector<ShardJob>& jobs, const Shard& shard,
    const std::function<void(const std::string&, int, int)>& progress) {
  const int count = static_cast<int>(jobs.size());
  const auto [first, end] = shard_range(shard, count);
  std::vector<ShardResult> results;
  for (int i = 0; i < count; ++i) {
    const ShardJob& job = jobs[static_cast<std::size_t>(i)];
    ShardResult result;
    result.name = job.name;
    const fs::path file = folder / job.name;
    const std::string key_hash = sha256_hex(job.key);
    if (const auto stored = stored_result(file, key_hash)) {
      result.text = *stored;
      result.reused = true;
    } else if (i >= first && i < end) {
      if (progress) progress(job.name, i - first, end - first);
      try {
        result.text = job.run();
        write_file(file, first_line(key_hash, result.text) + "\n" + result.text);
        if (!job.unfinished.empty()) remove_own_folder(job.unfinished);
      } catch (const std::exception& error) {
        result.error = error.what();
        result.failure = std::current_exception();
      }
    }
    results.push_back(std::move(result));
  }
  // Other shards went on while this one worked.
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    if (!is_missing(results[i])) continue;
    if (auto stored = stored_result(folder / jobs[i].name, sha256_hex(jobs[i].key))) {
      results[i].text = std::move(*stored);
      results[i].reused = true;
    }
  }
  return results;
}

}  // namespace cousin
