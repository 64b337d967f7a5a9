#include <algorithm>
#include <stdexcept>
#include <string>

#include "scenes/strawberries/strawberries_scene.h"
#include "sim/config/limits.h"

namespace cousin {

Fields fields(StrawberriesSceneConfig& c) {
  constexpr double kFar_m = 3, kNear_m = 0.005;
  return fields(c.stand) +
         Fields{{"plants", &c.plants, "different stretches; scene i shows stretch i % plants", 1,
                 1000000},
                {"ripens", &c.ripens, "each scene has its own colours; false: as it grew"},
                {"light", &c.light, "drawn, morning, overcast, noon or lamp"},
                {"category", &c.category, "of fruits: maturity (low, medium, high) or variety"},
                {"views", &c.views, "of the fruits", 1, 10000},
                {"distance_min_m", &c.distance_min_m, "nearest to the fruits' middle", kNear_m,
                 kFar_m},
                {"distance_max_m", &c.distance_max_m, "farthest", kNear_m, kFar_m},
                {"height_m", &c.height_m, "eye above or below the fruits' middle, at most", 0, 1},
                {"tilted_share", &c.tilted_share,
                 "of the views, that look down; the others are level", 0, 1},
                {"pitch_min_rad", &c.pitch_min_rad, "of those that look down", -1.2, 1.2},
                {"pitch_max_rad", &c.pitch_max_rad, "of those that look down", -1.2, 1.2},
                {"azimuth_spread_rad", &c.azimuth_spread_rad, "views within this of straight on", 0,
                 1.2},
                {"occlusion", &c.occlusion,
                 "hidden share of the fruit that each view is of; negative: as it comes", -1, 1},
                {"swings_leaves", &c.swings_leaves,
                 "where no camera meets it, leaves are swung before the fruit or aside"},
                {"unmet", &c.unmet, "what becomes of a view that misses it: state or refuse"},
                {"rig", &c.rig, "sensor preset"}} +
         fields(c.motion) + nested("strawberry", fields(c.plant)) + nested("bed", fields(c.bed));
}

void validate(const StrawberriesSceneConfig& config) {
  StrawberriesSceneConfig copy = config;
  check_limits(fields(copy), "strawberries");
  validate(config.stand);
  validate(config.plant);
  validate(config.bed);
  const auto ordered = [](const char* low_key, double low, const char* high_key, double high) {
    if (low <= high) return;
    throw std::invalid_argument(std::string(low_key) + " " + std::to_string(low) + " is above " +
                                high_key + " " + std::to_string(high));
  };
  ordered("distance_min_m", config.distance_min_m, "distance_max_m", config.distance_max_m);
  ordered("pitch_min_rad", config.pitch_min_rad, "pitch_max_rad", config.pitch_max_rad);
  if (config.category != "variety" && config.category != "maturity")
    throw std::invalid_argument("category \"" + config.category +
                                "\" is not one of maturity, variety");
  if (config.unmet != "state" && config.unmet != "refuse")
    throw std::invalid_argument("unmet \"" + config.unmet + "\" is not one of state, refuse");
  if (config.occlusion >= 0 && !is_still(config.motion))
    throw std::invalid_argument(
        "occlusion = " + std::to_string(config.occlusion) +
        " is of fruits and leaves that stand still; wind and push.force_n must be 0");
  if (config.light == "drawn") return;
  Scene scene;  // throws, naming those that exist
  add_strawberry_light(scene, config.bed, config.light, {0.4, 0, 0}, {0, 0, 0}, Rng(0));
}

int maturity_of(double red_share) {
  return maturity_of(red_share, truss_shape().maturity_medium, truss_shape().maturity_high);
}

}  // namespace cousin
