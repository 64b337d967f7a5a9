#include "sim/dataset/categories.h"

#include <algorithm>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/json_interop.h"

namespace cousin {
namespace {

constexpr std::size_t kMaxCategories = 10'000;

}  // namespace

std::vector<std::string> categories_from_json(std::string_view text, const std::string& name) {
  const JsonDocument document(text, name);
  std::vector<std::string> names;
  for (const JsonNode& entry : document.root().elements(kMaxCategories)) {
    entry.expect_keys({"id", "name"}, {"supercategory"});
    const auto id = static_cast<std::int64_t>(names.size()) + 1;
    if (entry["id"].integer(0, kMaxCategories) != id)
      entry["id"].fail("is not " + std::to_string(id) + ": ids go from 1 without a gap");
    std::string own = entry["name"].text(256);
    if (own.empty()) entry["name"].fail("is empty");
    if (std::find(names.begin(), names.end(), own) != names.end())
      entry["name"].fail("\"" + own + "\" stands twice");
    names.push_back(std::move(own));
  }
  return names;
}

std::string categories_to_json(const std::vector<std::string>& names) {
  Json list = Json::array();
  for (std::size_t i = 0; i < names.size(); ++i)
    list.push_back(Json{{"id", i + 1}, {"name", names[i]}});
  return to_text(list);
}

std::vector<std::string> read_categories(const std::filesystem::path& folder) {
  if (!std::filesystem::exists(folder / kCategoriesFile)) return {};
  const std::filesystem::path file = resolve_inside(folder, kCategoriesFile);
  return categories_from_json(read_file(file), file.string());
}

void write_categories(const std::filesystem::path& folder, const std::vector<std::string>& names) {
  write_file(folder / kCategoriesFile, categories_to_json(names));
}

}  // namespace cousin
