#include <stdexcept>
#include <string>

#include "benchmarks/app/parts.h"
#include "benchmarks/loop/plant_scenes.h"

namespace cousin {

std::vector<SceneEntry> plant_scenes() {
  std::vector<SceneEntry> scenes;
  for (const PlantSceneText& text : kPlantScenes) {
    const std::string how = how_to_build(kScenesPart.name);
    scenes.push_back(
        {.name = text.name,
         .status = how,
         .help = text.help,
         .configure = [name = std::string(text.name), how](const SceneRequest&) -> SceneJob {
           throw std::invalid_argument("scene \"" + name + "\" is " + how);
         }});
  }
  return scenes;
}

}  // namespace cousin
