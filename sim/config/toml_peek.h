#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace cousin {

/// The text under `key` in `table` of a TOML file, before the file's fields are known; "" if there
/// is none. @throws std::runtime_error as read_toml for what is not TOML or not text.
std::string toml_text_of(const std::filesystem::path& file, std::string_view table,
                         std::string_view key);

}  // namespace cousin
