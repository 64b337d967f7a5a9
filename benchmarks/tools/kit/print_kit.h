#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/truth/scene.h"

namespace cousin {

/// An object for a 3D printer, and what is true of it.
struct KitObject {
  std::string name;               ///< of its file: letters, digits, _
  std::string kind;               ///< "maize seed", "strawberry", ...
  Mesh mesh;                      ///< closed, metres, standing on z = 0
  std::vector<TrueTrait> traits;  ///< of this very mesh
};

/// Two seeds of each cultivar, two strawberries, two apples and a sphere of 22 mm, as the scenes
/// make them. Deterministic in `seed`.
std::vector<KitObject> print_kit(std::uint64_t seed);

/// NAME.stl of each object (binary, millimetres), traits.csv (object, kind, trait, unit, value; a
/// tidy table in millimetres) and README.txt, which says how to print and what to compare.
void write_print_kit(const std::filesystem::path& folder, const std::vector<KitObject>& objects);
/// The names of those files.
std::vector<std::string> print_kit_files(const std::vector<KitObject>& objects);

}  // namespace cousin
