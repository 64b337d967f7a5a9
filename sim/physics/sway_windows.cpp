#include <algorithm>
#include <cmath>

#include "sim/physics/sway_forces.h"

namespace cousin {
namespace {

/// Numbers of the samples that cover a window.
struct Samples {
  long first = 0, last = 0;
};

}  // namespace

SwayResult sway_windows(const BendingPlant& plant, const BentPlant& from,
                        const std::vector<HandPush>& pushes, const SwayConfig& config,
                        const WindField& wind, const SwayWindows& windows) {
  check_sway(plant, pushes, config);
  validate(windows);
  SwayResult result;
  const EngineWatch watch;
  const HingedPlant engine = make_plant_model(
      plant, {.step_s = config.step_s, .gravity_m_s2 = config.gravity_m_s2, .contacts = false});
  const EngineData data = make_data(*engine.model);
  SwayForces forces(plant, engine, config, pushes, wind);
  const long hold = forces.hold_steps(), sample = std::lround(config.sample_s / config.step_s);
  const auto lead = static_cast<long>(std::ceil(windows.lead_s / config.step_s));
  result.status = PlantStatus::ok;
  bool has_begun = false;
  long step = 0, taken = 0;  // steps are numbered from time 0; frames are taken below `taken`
  for (const SwayWindows::Span& span : windows.spans) {
    const Samples window{static_cast<long>(std::floor(span.begin_s / config.sample_s)),
                         static_cast<long>(std::ceil(span.end_s / config.sample_s))};
    if (!has_begun || window.first * sample - lead > step) {
      has_begun = true;
      mj_resetData(engine.model.get(), data.get());
      set_bent(engine, from, *data);
      mj_forward(engine.model.get(), data.get());
      forces.fix_air(*data);
      step = window.first * sample - lead;
      taken = window.first;
    }
    for (; step <= window.last * sample; ++step) {
      data->time = static_cast<double>(step) * config.step_s;
      if (step % sample == 0 && step / sample >= std::max(window.first, taken)) {
        mj_kinematics(engine.model.get(), data.get());
        result.frames.push_back(bent_plant(plant, engine, *data));
        taken = step / sample + 1;
      }
      if (step % hold == 0) forces.apply(*data);
      mj_step(engine.model.get(), data.get());
      const PlantStress stress = largest_stress(plant, engine, *data);
      if (stress.ratio > result.strain.ratio) result.strain = strain_of(stress);
      if (watch.warnings(*data) > 0) result.status = PlantStatus::engine_warning;
      if (stress.ratio > 1) result.status = PlantStatus::broke;
      if (result.status != PlantStatus::ok) {
        result.warnings = watch.warnings(*data);
        result.first_warning = watch.first_warning();
        return result;
      }
    }
  }
  return result;
}

}  // namespace cousin
