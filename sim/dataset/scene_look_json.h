#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "sim/dataset/json_interop.h"
#include "sim/truth/scene.h"

namespace cousin {

/// Materials and lights as truth files hold them. Fields that keep their default are left out,
/// except those that every material has.
Json to_json(const Material& material);
Material read_material(const JsonNode& node);
/// An environment's picture in a file of its own.
struct EnvironmentFile {
  std::size_t light = 0;  ///< its place among the scene's
  std::string file;       ///< below truth/
  double scale = 1;       ///< times the file's radiance
};
std::string environment_file(std::size_t light);  ///< "environments/000000.exr"

/// `kind` names the type: sun, sky, lamp, clear_sky, projector, environment. A projector's picture
/// is an array of linear r, g, b, row by row; an environment's is environment_file(index).
Json to_json(const Light& light, std::size_t index);
/// An environment that names a file comes without its picture, and `files` gets the file.
Light read_light(const JsonNode& node, std::size_t index, std::vector<EnvironmentFile>& files);

}  // namespace cousin
