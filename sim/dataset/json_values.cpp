// Calibrations in JSON, as the keys that those in YAML have.
#include <algorithm>

#include "sim/dataset/camera_values.h"
#include "sim/dataset/json_interop.h"
#include "sim/dataset/text_fields.h"
#include "sim/dataset/yaml_values.h"

namespace cousin {
namespace {

constexpr std::size_t kMostJsonValues = 1'000'000;
constexpr int kDeepestJson = 32;

struct FlatJson {
  std::map<std::string, std::vector<std::string>> values;
  std::set<std::string> nested;
};

std::string json_scalar(const JsonNode& node) {
  if (node.is_text()) return node.text(std::size_t{1} << 16);
  if (node.is_null()) return "null";
  if (node.is_number()) return exact_text(node.number());
  return node.boolean() ? "true" : "false";
}

void flatten(const JsonNode& node, const std::string& key, int depth, FlatJson& into);

void flatten_list(const JsonNode& node, const std::string& key, int depth, FlatJson& into) {
  if (depth > kDeepestJson) node.fail("is nested deeper than 32");
  const std::vector<JsonNode> elements = node.elements(kMostJsonValues);
  const bool has_objects = std::any_of(elements.begin(), elements.end(),
                                       [](const JsonNode& each) { return each.is_object(); });
  if (has_objects) {
    for (std::size_t i = 0; i < elements.size(); ++i)
      flatten(elements[i], key + "." + std::to_string(i), depth + 1, into);
    return;
  }
  into.values[key];  // an empty list is there too
  for (const JsonNode& each : elements) {
    if (each.is_array()) {
      into.nested.insert(key);
      flatten_list(each, key, depth + 1, into);
    } else {
      into.values[key].push_back(json_scalar(each));
    }
  }
}

void flatten(const JsonNode& node, const std::string& key, int depth, FlatJson& into) {
  if (depth > kDeepestJson) node.fail("is nested deeper than 32");
  if (node.is_array()) return flatten_list(node, key, depth, into);
  if (!node.is_object()) {
    into.values[key].push_back(json_scalar(node));
    return;
  }
  for (const auto& [name, value] : node.members(kMostJsonValues)) {
    const std::string whole = key.empty() ? name : key + "." + name;
    if (into.values.contains(whole)) value.fail("has the key of another value");
    flatten(value, whole, depth + 1, into);
  }
}

}  // namespace

YamlValues YamlValues::of_json(std::string_view text, const std::string& name) {
  const JsonDocument document(text, name);
  if (!document.root().is_object()) document.root().fail("is not an object");
  FlatJson flat;
  flatten(document.root(), "", 0, flat);
  YamlValues result;
  result.name_ = name;
  result.values_ = std::move(flat.values);
  result.nested_ = std::move(flat.nested);
  return result;
}

YamlValues values_of_file(std::string_view text, const std::string& name) {
  return name.ends_with(".json") ? YamlValues::of_json(text, name) : YamlValues(text, name);
}

bool is_rig_json(const YamlValues& values) {
  return values.has("schema") || values.first_keys().contains("sensors");
}

}  // namespace cousin
