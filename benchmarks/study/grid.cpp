#include "benchmarks/study/grid.h"

#include <algorithm>
#include <charconv>
#include <set>
#include <stdexcept>

namespace cousin {
namespace {

bool is_of_file_name(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
         c == '_' || c == '-';
}

/// The pattern with the words of the job's levels.
std::string filled(const std::string& pattern, const GridJob& job) {
  std::string text;
  for (std::size_t at = 0; at < pattern.size();) {
    const std::size_t open = pattern.find('{', at);
    text += pattern.substr(at, open - at);
    if (open == std::string::npos) break;
    const std::size_t close = pattern.find('}', open);
    const std::string factor = pattern.substr(open + 1, close - open - 1);
    if (close == std::string::npos || !job.has(factor)) {
      throw std::invalid_argument("grid: \"" + pattern + "\" names \"" + factor +
                                  "\", which is no factor of its block");
    }
    text += job.at(factor).word;
    at = close + 1;
  }
  return text;
}

/// The place whose number is `index`, where the last factor counts fastest.
GridJob place_of(const GridBlock& block, std::size_t index) {
  GridJob job;
  std::vector<const Level*> levels(block.factors.size());
  job.places.resize(block.factors.size());
  for (std::size_t f = block.factors.size(); f-- > 0;) {
    const Factor& factor = block.factors[f];
    const std::size_t level = index % factor.levels.size();
    index /= factor.levels.size();
    levels[f] = &factor.levels[level];
    job.places[f] = {factor.name, levels[f]->word, level};
  }
  for (const Level* level : levels) {
    for (const std::string& set : level->sets) job.sets.push_back(filled(set, job));
  }
  job.name = filled(block.name, job);
  std::replace_if(
      job.name.begin(), job.name.end(), [](char c) { return !is_of_file_name(c); }, '_');
  return job;
}

}  // namespace

Factor key_factor(const std::string& key, const std::vector<std::string>& values) {
  Factor factor = named_factor(key, values);
  for (Level& level : factor.levels) level.sets = {key + "=" + level.word};
  return factor;
}

Factor named_factor(const std::string& name, const std::vector<std::string>& words) {
  Factor factor{name, {}};
  for (const std::string& word : words) factor.levels.push_back({word});
  return factor;
}

Factor number_factor(const std::string& name, int first, int end) {
  Factor factor{name, {}};
  for (int i = first; i < end; ++i) factor.levels.push_back({std::to_string(i)});
  return factor;
}

bool GridJob::has(const std::string& factor) const {
  return std::any_of(places.begin(), places.end(),
                     [&](const Place& place) { return place.factor == factor; });
}

const GridJob::Place& GridJob::at(const std::string& factor) const {
  const auto place = std::find_if(places.begin(), places.end(),
                                  [&](const Place& p) { return p.factor == factor; });
  if (place == places.end())
    throw std::invalid_argument("grid: job \"" + name + "\" has no factor \"" + factor + "\"");
  return *place;
}

int GridJob::number(const std::string& factor) const {
  const std::string& word = at(factor).word;
  int value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) {
    throw std::invalid_argument("grid: job \"" + name + "\" has \"" + word + "\" at \"" + factor +
                                "\", which is no whole number");
  }
  return value;
}

std::vector<GridJob> jobs_of(const Grid& grid) {
  std::vector<GridJob> jobs;
  std::set<std::string> names;
  for (std::size_t b = 0; b < grid.size(); ++b) {
    std::size_t count = 1;
    for (const Factor& factor : grid[b].factors) count *= factor.levels.size();
    for (std::size_t i = 0; i < count; ++i) {
      GridJob job = place_of(grid[b], i);
      job.block = b;
      if (grid[b].where && !grid[b].where(job)) continue;
      if (!names.insert(job.name).second)
        throw std::invalid_argument("grid: two jobs have the name \"" + job.name + "\"");
      jobs.push_back(std::move(job));
    }
  }
  return jobs;
}

}  // namespace cousin
