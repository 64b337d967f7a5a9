#include "benchmarks/tools/fit_sensor/rig_choice.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <vector>

#include "benchmarks/tools/fit_sensor/preset_patch.h"
#include "sim/sensors/active_stereo_presets.h"
#include "sim/sensors/rig_presets.h"

namespace cousin {

RigChoice rig_choice(const std::string& name) {
  std::vector<PresetText> all(active_stereo_preset_texts().begin(),
                              active_stereo_preset_texts().end());
  all.insert(all.end(), rig_preset_texts().begin(), rig_preset_texts().end());
  RigChoice rig{name, preset_toml(name, all), {}, {}};
  const std::vector<std::string> tables = toml_tables(rig.toml, preset_title(name));
  if (std::find(tables.begin(), tables.end(), "rig") != tables.end())
    rig.cameras = rig_preset(name);
  else
    rig.depth = active_stereo_preset(name);
  return rig;
}

std::optional<PhotositesChoice> photosites_choice(const RigChoice& rig) {
  for (const std::string prefix : {"camera.photosites.", "color.photosites."}) {
    if (!has_key(rig.toml, prefix + "full_well_e")) continue;
    int bits = 8;
    if (rig.cameras) bits = rig.cameras->sensors.front().camera.photosites.bits;
    if (rig.depth) {
      ActiveStereoConfig config = *rig.depth;
      for (const Field& field : fields(config)) {
        if (field.key == prefix + "bits") bits = *std::get<int*>(field.value);
      }
    }
    return PhotositesChoice{prefix, bits};
  }
  return std::nullopt;
}

}  // namespace cousin
