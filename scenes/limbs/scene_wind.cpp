#include "scenes/limbs/scene_wind.h"

#include <cmath>
#include <stdexcept>

namespace cousin {
namespace {

/// Number at the end of a name: 7 of "seedling 07".
int number_of(const std::string& name) {
  const std::size_t space = name.rfind(' ');
  return space == std::string::npos ? -1 : std::atoi(name.c_str() + space + 1);
}

HandPush push_of(const Scene& scene, const HandConfig& hand, const Instance& plant,
                 const Limbs& limbs) {
  const std::string name = hand.leaf == 0 ? "stalk" : "leaf " + std::to_string(hand.leaf);
  if (hand.view >= static_cast<int>(scene.views.size())) {
    throw std::invalid_argument("push.view = " + std::to_string(hand.view) +
                                ": the scene has views 0.." +
                                std::to_string(scene.views.size() - 1));
  }
  HandPush push;
  push.stem = -1;
  for (std::size_t s = 0; s < limbs.stem_names.size(); ++s) {
    const std::string& own = limbs.stem_names[s];
    if (own == name || own == name + " blade") push.stem = static_cast<int>(s);
  }
  if (push.stem < 0) {
    throw std::invalid_argument("push.leaf = " + std::to_string(hand.leaf) + ": \"" + plant.name +
                                "\" has no such leaf that is long enough to push");
  }
  const double e = hand.elevation_rad, a = hand.azimuth_rad;
  push.share = hand.leaf == 0 ? 1 : 0.6;
  push.force_n = hand.force_n *
                 Eigen::Vector3d(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
  push.seconds = hand.seconds;
  push.begin_s = scene.views[static_cast<std::size_t>(hand.view)].time_s - 0.5 * hand.seconds;
  return push;
}

std::vector<int> add_models(Scene& scene, const LimbPieces& pieces) {
  std::vector<int> models;
  for (const ObjectModel& piece : pieces.models) {
    models.push_back(static_cast<int>(scene.models.size()));
    scene.models.push_back(piece);
  }
  return models;
}

/// Takes out the models that no instance shows any more.
void drop_unused_models(Scene& scene) {
  std::vector<int> number(scene.models.size(), -1);
  for (const Instance& instance : scene.instances)
    number[static_cast<std::size_t>(instance.model)] = 0;
  std::vector<ObjectModel> used;
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (number[i] < 0) continue;
    number[i] = static_cast<int>(used.size());
    used.push_back(std::move(scene.models[i]));
  }
  scene.models = std::move(used);
  for (Instance& instance : scene.instances)
    instance.model = number[static_cast<std::size_t>(instance.model)];
}

Fields hand_fields(HandConfig& c) {
  constexpr double kPi = 3.2;
  return {{"force_n", &c.force_n, "largest force of a hand that pushes a leaf; 0 = none", 0, 100},
          {"plant", &c.plant, "number in the specimen's name", 0, 1000000},
          {"leaf", &c.leaf, "which leaf, from 1; 0 = the stalk's upper end", 0, 1000},
          {"azimuth_rad", &c.azimuth_rad, "pushes towards, from +x to +y", -2 * kPi, 2 * kPi},
          {"elevation_rad", &c.elevation_rad, "pushes towards, upwards", -1.5708, 1.5708},
          {"view", &c.view, "whose time is the middle of the push", 0, 1000000},
          {"seconds", &c.seconds, "from touch to release", 0.02, 10}};
}

}  // namespace

Fields fields(SceneWind& c) {
  return scene_wind_fields(c.wind) +
         Fields{{"moves", &c.moves,
                 "organs: leaves and stems bend apart; plants: each sways as one body"}} +
         nested("push", hand_fields(c.push));
}

void validate(const SceneWind& config) {
  if (config.moves == "organs" || config.moves == "plants") {
    if (config.moves == "plants" && config.push.force_n > 0)
      throw std::invalid_argument(
          "push.force_n: a hand moves organs, not whole plants: moves = "
          "\"plants\"");
    return;
  }
  throw std::invalid_argument("moves \"" + config.moves + "\" is not one of organs, plants");
}

void move_plants(Scene& scene, const std::vector<PlantKind>& kinds, const SceneWind& config,
                 const LimbConfig& limb_config, const RigidSwayConfig& whole, double height_share,
                 const Rng& rng) {
  if (is_still(config)) return;
  if (config.moves == "plants") {
    sway_specimens(scene, config.wind, whole, height_share, rng);
    return;
  }
  std::vector<Limbs> limbs(kinds.size());
  std::vector<LimbPieces> pieces(kinds.size());
  std::vector<SplitSpecimen> split;
  bool is_pushed = config.push.force_n == 0;
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    limbs[k] = plant_limbs(*kinds[k].plant, *kinds[k].model, limb_config,
                           config.wind.mean_speed_m_s, rng.fork("limbs").fork(k));
    if (limbs[k].plant.stems.empty()) continue;
    pieces[k] = cut_model(kinds[k].model->model, limbs[k]);
    std::vector<int> models;
    for (const std::size_t place : kinds[k].specimens) {
      const Instance& plant = scene.instances[place];
      SplitSpecimen one{&limbs[k], &pieces[k], {}, {}};
      if (config.push.force_n > 0 && number_of(plant.name) == config.push.plant) {
        one.pushes.push_back(push_of(scene, config.push, plant, limbs[k]));
        is_pushed = true;
      }
      if (config.wind.mean_speed_m_s == 0 && one.pushes.empty()) continue;
      if (models.empty()) models = add_models(scene, pieces[k]);
      one.places = split_specimen(scene, place, pieces[k], models);
      split.push_back(std::move(one));
    }
  }
  if (!is_pushed) {
    throw std::invalid_argument("push.plant = " + std::to_string(config.push.plant) +
                                ": no plant of that number stands in the scene");
  }
  drop_unused_models(scene);
  SwayConfig sway;
  sway.step_s = 0.004;
  sway.sample_s = 0.008;
  sway.gravity_m_s2 = 0;
  sway.contacts = false;
  sway_limbs(scene, split, make_wind(config.wind, rng.fork("wind")), sway,
             windows_of(scene, limb_config.lead_s));
}

}  // namespace cousin
