#pragma once

#include <map>
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

  /// Values by their dotted key; a scalar is a list of one.
  bool has(const std::string& key) const { return values_.contains(key); }
  const std::vector<std::string>& list(const std::string& key) const;
  std::string text(const std::string& key) const;
  std::vector<double> numbers(const std::string& key) const;  ///< finite
  double number(const std::string& key) const;
  int pixels(const std::string& key) const;  ///< in [1, 65535]
  [[noreturn]] void fail(const std::string& what) const;

 private:
  void parse(std::string_view text);
  std::string name_;
  std::map<std::string, std::vector<std::string>> values_;
};

}  // namespace cousin
