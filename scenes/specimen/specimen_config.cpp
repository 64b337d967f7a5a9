#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

#include "scenes/specimen/specimen_scene.h"
#include "scenes/specimen/toml_text.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

void one_of(const char* key, const std::string& value, std::initializer_list<const char*> words) {
  std::string names;
  for (const char* word : words) {
    if (value == word) return;
    names += (names.empty() ? "" : ", ") + std::string(word);
  }
  throw std::invalid_argument(std::string(key) + " \"" + value + "\" is not one of " + names);
}

void ordered(const char* low_key, double low, const char* high_key, double high) {
  if (low <= high) return;
  throw std::invalid_argument(std::string(low_key) + " " + std::to_string(low) + " is above " +
                              high_key + " " + std::to_string(high));
}

}  // namespace

Fields fields(SpecimenSetting& c) {
  constexpr double kKilometre = 1000;
  return {
      {"limits.smallest_m", &c.limits.smallest_m, "size of a specimen", 1e-6, kKilometre},
      {"limits.largest_m", &c.limits.largest_m, "size of a specimen", 1e-6, kKilometre},
      {"looks.albedo", &c.looks.albedo, "of meshes without colours", 0, 1},
      {"looks.leaf_transmittance", &c.looks.leaf_transmittance, "of leaves", 0, 0.5},
      {"looks.ior", &c.looks.ior, "of the wax", 1, 3},
      {"looks.roughness", &c.looks.roughness, "of the surface", 0.05, 1},
      {"looks.infrared_albedo", &c.looks.infrared_albedo, "at 850 nm", 0, 0.5},
      {"looks.infrared_transmittance", &c.looks.infrared_transmittance, "at 850 nm", 0, 0.5},
      {"looks.density_kg_m3", &c.looks.density_kg_m3, "of watertight meshes", 10, 20000},
      {"table.radius_share", &c.table.radius_share, "over the specimen's size", 1, 100},
      {"table.albedo", &c.table.albedo, "of the table", 0, 1},
      {"table.other_albedo", &c.table.other_albedo, "of its stains", 0, 1},
      {"table.noise_m", &c.table.noise_m, "size of the stains", 1e-3, 10},
      {"lights.sun_elevation_rad", &c.light.sun_elevation_rad, "of the sun", 0.05, 1.57},
      {"lights.sun_azimuth_rad", &c.light.sun_azimuth_rad, "of the sun about +z", -7, 7},
      {"lights.turbidity", &c.light.turbidity, "of the air", 1.7, 10},
      {"lights.overcast", &c.light.overcast, "radiance at the zenith", 0, 1e6},
  };
}

const SpecimenSetting& specimen_setting() {
  static const SpecimenSetting kSetting = [] {
    SpecimenSetting setting;
    read_toml_text(specimen_toml(), "scenes/specimen/specimen.toml", fields(setting),
                   MissingKeys::error);
    return setting;
  }();
  return kSetting;
}

Fields fields(SpecimenSceneConfig& c) {
  return Fields{{"mesh", &c.mesh, "the specimen's file: PLY, OBJ, STL, glTF (.gltf, .glb)"},
                {"unit", &c.unit, "of its numbers: m, dm, cm, mm, um, in, ft; glTF is in metres"},
                {"up", &c.up, "axis of the file that is up: x, y, z, -x, -y, -z"},
                {"name", &c.name, "of what it is: the instance's category"},
                {"surface", &c.surface,
                 "solid, leaf (lets light through) or auto (leaf: open meshes, parts named leaf)"},
                {"needs_volume", &c.needs_volume, "refuse a mesh that is not watertight"},
                {"views", &c.views, "photographs all around", 1, 10000},
                {"distance_min", &c.distance_min, "nearest, over the specimen's size", 0.6, 100},
                {"distance_max", &c.distance_max, "farthest, over the specimen's size", 0.6, 100},
                {"pitch_min_rad", &c.pitch_min_rad, "looking down", -0.5, 1.57},
                {"pitch_max_rad", &c.pitch_max_rad, "looking down", -0.5, 1.57},
                {"light", &c.light, "sun or overcast"},
                {"rig", &c.rig, "sensor preset"}} +
         fields(c.setting);
}

void validate(const SpecimenSceneConfig& config) {
  SpecimenSceneConfig copy = config;
  check_limits(fields(copy), "specimen");
  constexpr std::size_t kMostName = 256;  // as categories.json has them
  if (config.name.empty() || config.name.size() > kMostName)
    throw std::invalid_argument("specimen: name has " + std::to_string(config.name.size()) +
                                " bytes, outside [1, " + std::to_string(kMostName) + "]");
  metres_per_unit(config.unit);  // throws, naming those that exist
  one_of("up", config.up, {"x", "y", "z", "-x", "-y", "-z"});
  one_of("surface", config.surface, {"auto", "solid", "leaf"});
  one_of("light", config.light, {"sun", "overcast"});
  ordered("distance_min", config.distance_min, "distance_max", config.distance_max);
  ordered("pitch_min_rad", config.pitch_min_rad, "pitch_max_rad", config.pitch_max_rad);
  const SpecimenSetting& s = config.setting;
  ordered("limits.smallest_m", s.limits.smallest_m, "limits.largest_m", s.limits.largest_m);
  for (const auto* color : {&s.looks.albedo, &s.looks.leaf_transmittance, &s.table.albedo,
                            &s.table.other_albedo, &s.light.overcast}) {
    if (color->size() != 3) {
      throw std::invalid_argument("specimen: a colour has " + std::to_string(color->size()) +
                                  " numbers; it needs 3");
    }
  }
}

}  // namespace cousin
