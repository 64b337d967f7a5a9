#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace cousin {

/// categories.json, at the root of a dataset or of estimates: what the `category_id` of boxes,
/// masks and keypoints means. A list as COCO's `categories`: [{"id": 1, "name": "high"}, ...], ids
/// from 1 without a gap.
inline constexpr const char* kCategoriesFile = "categories.json";

/// Names, id 1 first. @throws as read_categories
std::vector<std::string> categories_from_json(std::string_view text, const std::string& name);
std::string categories_to_json(const std::vector<std::string>& names);
/// Names, id 1 first. Empty where the folder has no such file.
/// @throws std::runtime_error naming file, key, value and limit
std::vector<std::string> read_categories(const std::filesystem::path& folder);
void write_categories(const std::filesystem::path& folder, const std::vector<std::string>& names);

}  // namespace cousin
