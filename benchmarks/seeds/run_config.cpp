#include "benchmarks/seeds/run_config.h"

#include <stdexcept>

#include "sim/dataset/manifest.h"

namespace cousin {
namespace {

/// As `fields`, but scene keys under a table of their own: top-level "rig" is a name there and a
/// table here.
Fields file_fields(SeedsRunConfig& config) {
  return nested("scene", fields(config.scene)) + nested("rig", fields(config.rig)) +
         nested("render", fields(config.render)) + nested("pipeline", fields(config.pipeline));
}

}  // namespace

Fields fields(SeedsRunConfig& config) {
  return fields(config.scene) + nested("rig", fields(config.rig)) +
         nested("render", fields(config.render)) + nested("pipeline", fields(config.pipeline));
}

void validate(const SeedsRunConfig& config) {
  validate(config.scene);
  validate(config.rig);
  validate(config.render);
  validate(config.pipeline);
}

SeedsRunConfig seeds_run_config(const std::vector<std::string>& assignments,
                                const std::filesystem::path& file) {
  SeedsRunConfig config;
  const auto read_file = [&] {
    if (!file.empty()) read_toml(file, file_fields(config), MissingKeys::keep_default);
  };
  read_file();  // for the name of the rig
  constexpr std::string_view kRig = "rig=";
  bool rig_is_given = false;
  for (const std::string& assignment : assignments) {
    if (!assignment.starts_with(kRig)) continue;
    config.scene.rig = assignment.substr(kRig.size());
    rig_is_given = true;
  }
  config.rig = phone_preset(config.scene.rig);
  if (!rig_is_given) read_file();
  const Fields all = fields(config);
  for (const std::string& assignment : assignments) set_field(all, assignment);
  validate(config);
  const std::string mesh = specimen_file(config.scene);
  if (!mesh.empty() && !std::filesystem::is_regular_file(mesh)) {
    throw std::runtime_error("specimen = \"" + config.scene.specimen + "\": there is no file " +
                             mesh);
  }
  const std::string& environment = config.scene.environment;
  if (!environment.empty() && !std::filesystem::is_regular_file(environment)) {
    throw std::runtime_error("environment = \"" + environment + "\": there is no such file");
  }
  return config;
}

std::string specimen_file(const SeedsSceneConfig& config) {
  constexpr std::string_view kMesh = "mesh:";
  if (config.specimen.empty()) return {};
  if (!config.specimen.starts_with(kMesh) || config.specimen == kMesh) {
    throw std::invalid_argument("specimen = \"" + config.specimen + "\" is not \"mesh:FILE\"");
  }
  return config.specimen.substr(kMesh.size());
}

std::string user_files_hash(const SeedsSceneConfig& config) {
  std::string hash;
  for (const std::string& file : {specimen_file(config), config.environment}) {
    if (!file.empty()) hash += sha256_hex_of_file(file);
  }
  return hash;
}

std::string simulator_toml(const SeedsRunConfig& config) {
  SeedsRunConfig copy = config;  // fields point into what they describe
  return to_toml(nested("scene", fields(copy.scene)) + nested("rig", fields(copy.rig)) +
                 nested("render", fields(copy.render)));
}

std::string resolved_toml(const SeedsRunConfig& config) {
  SeedsRunConfig copy = config;
  return to_toml(file_fields(copy));
}

std::string config_hash(const SeedsRunConfig& config, std::uint64_t seed) {
  return sha256_hex(resolved_toml(config) + "\nseed = " + std::to_string(seed) + "\n" +
                    user_files_hash(config.scene));
}

}  // namespace cousin
