#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "sim/dataset/truth_json.h"

/// Any bytes as each JSON file of truth/: values or std::runtime_error, nothing else.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cousin;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto attempt = [](auto read) {
    try {
      read();
    } catch (const std::runtime_error&) {
    }
  };
  Scene scene;
  scene.models.resize(2);
  scene.instances.resize(2);
  scene.instances[0].id = 1;
  scene.instances[1].id = 2;
  attempt([&] {
    std::vector<SensorViews> others;
    views_from_json(text, "fuzz", others);
  });
  attempt([&] {
    SceneFiles files;
    scene_from_json(text, "fuzz", files);
  });
  attempt([&] { keypoints_from_json(text, "fuzz", scene); });
  attempt([&] { shared_plants_from_json(text, "fuzz"); });
  attempt([&] { true_traits_from_json(text, "fuzz", scene); });
  attempt([&] {
    const std::vector<TrueView> views(2);
    std::vector<TruthImages> images(2);
    scene_gt_info_from_json(text, "fuzz", views, images);
  });
  return 0;
}
