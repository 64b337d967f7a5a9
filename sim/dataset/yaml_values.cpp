#include "sim/dataset/yaml_values.h"

#include <charconv>
#include <cmath>
#include <stdexcept>

#include "sim/types/utf8.h"

namespace cousin {
namespace {

std::string trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return {};
  return std::string(text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1));
}

/// Adds the items of "a, b" to `into`.
void split(std::string_view text, std::vector<std::string>& into) {
  while (!text.empty()) {
    const std::size_t comma = text.find(',');
    std::string item = trimmed(text.substr(0, comma));
    if (!item.empty()) into.push_back(std::move(item));
    text = comma == std::string_view::npos ? std::string_view() : text.substr(comma + 1);
  }
}

}  // namespace

YamlValues::YamlValues(std::string_view text, std::string name) : name_(std::move(name)) {
  parse(text);
}

YamlValues YamlValues::below(const std::string& key) const {
  YamlValues result;
  result.name_ = name_ + ": " + key;
  const std::string start = key + ".";
  for (auto at = values_.lower_bound(start); at != values_.end() && at->first.starts_with(start);
       ++at)
    result.values_.emplace(at->first.substr(start.size()), at->second);
  for (auto at = nested_.lower_bound(start); at != nested_.end() && at->starts_with(start); ++at)
    result.nested_.insert(at->substr(start.size()));
  return result;
}

std::set<std::string> YamlValues::first_keys() const {
  std::set<std::string> keys;
  for (const auto& [key, value] : values_) keys.insert(key.substr(0, key.find('.')));
  return keys;
}

const std::vector<std::string>& YamlValues::list(const std::string& key) const {
  const auto found = values_.find(key);
  if (found == values_.end()) fail("the key \"" + key + "\" is missing");
  return found->second;
}

std::string YamlValues::text(const std::string& key) const {
  if (list(key).size() != 1) fail(key + " is not one value");
  return list(key).front();
}

std::vector<double> YamlValues::numbers(const std::string& key) const {
  std::vector<double> result;
  for (const std::string& item : list(key)) {
    double value = 0;
    const char* begin = item.data() + (item.starts_with('+') ? 1 : 0);
    const auto [end, error] = std::from_chars(begin, item.data() + item.size(), value);
    if (error != std::errc{} || end != item.data() + item.size() || !std::isfinite(value)) {
      fail(key + " = " + cut_utf8(item, 60) + " is not a finite number");
    }
    result.push_back(value);
  }
  return result;
}

double YamlValues::number(const std::string& key) const {
  const std::vector<double> values = numbers(key);
  if (values.size() != 1) fail(key + " is not one number");
  return values.front();
}

int YamlValues::pixels(const std::string& key) const {
  const double value = number(key);
  if (!(value >= 1 && value <= 65535) || value != std::floor(value)) {
    fail(key + " = " + text(key) + " is not a whole number in [1, 65535]");
  }
  return static_cast<int>(value);
}

void YamlValues::fail(const std::string& what) const {
  throw std::runtime_error(name_ + ": " + what);
}

void YamlValues::parse(std::string_view text) {
  std::vector<std::pair<std::size_t, std::string>> parents;  // indentation and dotted key
  std::string open_list;                                     // key of a "[" that is not closed yet
  int number = 0;
  while (!text.empty()) {
    const std::size_t newline = text.find('\n');
    std::string_view line = text.substr(0, newline);
    text = newline == std::string_view::npos ? std::string_view() : text.substr(newline + 1);
    ++number;
    if (line.starts_with("%") || line.starts_with("---") || line.starts_with("...")) continue;
    if (const std::size_t comment = line.find('#'); comment != std::string_view::npos)
      line = line.substr(0, comment);
    const std::string content = trimmed(line);
    if (content.empty()) continue;
    if (!open_list.empty()) {
      const std::size_t close = content.find(']');
      split(std::string_view(content).substr(0, close), values_[open_list]);
      if (close != std::string::npos) open_list.clear();
      continue;
    }
    const std::size_t indent = line.find_first_not_of(" \t");
    if (content.starts_with("- ")) {
      if (parents.empty()) fail("line " + std::to_string(number) + ": a list entry without a key");
      std::vector<std::string>& into = values_[parents.back().second];
      const std::string item = trimmed(std::string_view(content).substr(2));
      if (item.starts_with('[') && item.ends_with(']')) {
        nested_.insert(parents.back().second);
        split(std::string_view(item).substr(1, item.size() - 2), into);
      } else {
        into.push_back(item);
      }
      continue;
    }
    const std::size_t colon = content.find(':');
    if (colon == std::string::npos)
      fail("line " + std::to_string(number) + ": neither \"key: value\" nor a list entry");
    while (!parents.empty() && parents.back().first >= indent) parents.pop_back();
    if (parents.size() > 32) fail("line " + std::to_string(number) + ": nested deeper than 32");
    const std::string key =
        (parents.empty() ? "" : parents.back().second + ".") + content.substr(0, colon);
    if (values_.contains(key))
      fail("line " + std::to_string(number) + ": " + key + " occurs twice");
    std::string value = trimmed(std::string_view(content).substr(colon + 1));
    if (value.starts_with("!!")) value.clear();
    parents.emplace_back(indent, key);
    if (value.starts_with('[')) {
      const std::size_t close = value.find(']');
      split(std::string_view(value).substr(1, close == std::string::npos ? close : close - 1),
            values_[key]);
      if (close == std::string::npos) open_list = key;
    } else if (!value.empty()) {
      std::erase(value, '"');
      std::erase(value, '\'');
      values_[key].push_back(value);
    }
  }
  if (!open_list.empty()) fail(open_list + ": the \"[\" is not closed");
}

}  // namespace cousin
