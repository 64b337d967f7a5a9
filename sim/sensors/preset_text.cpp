#include "sim/sensors/preset_text.h"

#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace cousin {

bool is_preset_file(std::string_view name) { return name.ends_with(".toml"); }

std::string preset_title(const std::string& name) {
  return is_preset_file(name) ? name : name + ".toml";
}

std::vector<std::string> preset_names(std::span<const PresetText> presets) {
  std::vector<std::string> names;
  for (const PresetText& preset : presets) names.emplace_back(preset.name);
  return names;
}

std::string preset_toml(const std::string& name, std::span<const PresetText> presets) {
  if (is_preset_file(name)) {
    constexpr std::size_t kMaxBytes = std::size_t{1} << 20;
    std::error_code error;
    if (!std::filesystem::is_regular_file(name, error))
      throw std::runtime_error(name + ": no such file, or not a regular one");
    std::ifstream in(name, std::ios::binary);
    std::string text(kMaxBytes + 1, '\0');
    in.read(text.data(), static_cast<std::streamsize>(text.size()));
    if (!in && !in.eof()) throw std::runtime_error(name + ": cannot read");
    text.resize(static_cast<std::size_t>(in.gcount()));
    if (text.size() > kMaxBytes)
      throw std::runtime_error(name + ": more than " + std::to_string(kMaxBytes) +
                               " bytes; a preset has less");
    return text;
  }
  std::string known;
  for (const PresetText& preset : presets) {
    if (preset.name == name) return std::string(preset.toml);
    known += (known.empty() ? "" : ", ") + std::string(preset.name);
  }
  throw std::invalid_argument("rig \"" + name + "\" does not exist; there are " + known +
                              ", or the path of a file that ends with .toml");
}

}  // namespace cousin
