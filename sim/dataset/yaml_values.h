#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace cousin {

/// Private to sim/dataset: what camera calibrations use of YAML, which is nested mappings by
/// indentation, scalars, [a, b] over several lines, and "- a" lists, whose items may be [a, b] that
/// are joined; tags, comments and document marks are skipped. Errors are std::runtime_error naming
/// the file and the key or line.
class YamlValues {
 public:
  YamlValues(std::string_view text, std::string name);
  /// The same of JSON: an object's members have its key and a dot before theirs, an element of a
  /// list that holds objects its place; lists of lists are joined.
  static YamlValues of_json(std::string_view text, const std::string& name);

  /// What stands below "key.", without that; for messages the file's name has ": key" behind it.
  YamlValues below(const std::string& key) const;
  bool empty() const { return values_.empty(); }
  const std::string& name() const { return name_; }
  /// The parts of the keys before their first dot.
  std::set<std::string> first_keys() const;

  /// Values by their dotted key; a scalar is a list of one.
  bool has(const std::string& key) const { return values_.contains(key); }
  /// Whether the file has a list of lists there.
  bool is_nested(const std::string& key) const { return nested_.contains(key); }
  const std::vector<std::string>& list(const std::string& key) const;
  std::string text(const std::string& key) const;
  std::vector<double> numbers(const std::string& key) const;  ///< finite
  double number(const std::string& key) const;
  int pixels(const std::string& key) const;  ///< in [1, 65535]
  [[noreturn]] void fail(const std::string& what) const;

 private:
  YamlValues() = default;
  void parse(std::string_view text);
  std::string name_;
  std::map<std::string, std::vector<std::string>> values_;
  std::set<std::string> nested_;
};

}  // namespace cousin
