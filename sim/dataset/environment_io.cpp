#include "sim/dataset/environment_io.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "sim/imaging/image_io.h"
#include "sim/truth/scene_check.h"

namespace cousin {

Environment read_environment(const std::filesystem::path& file, double scale) {
  if (!(scale >= 0 && scale <= 1e20)) {
    throw std::runtime_error(file.string() + ": scale = " + std::to_string(scale) +
                             " is not in [0, 1e20]");
  }
  Environment environment{read_exr_color(file)};
  for (Rgbf& c : environment.radiance) {
    for (float* v : {&c.r, &c.g, &c.b}) *v = static_cast<float>(scale * static_cast<double>(*v));
  }
  try {
    validate(Light(environment), file.string());
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(error.what());  // a file's fault, not the caller's
  }
  return environment;
}

}  // namespace cousin
