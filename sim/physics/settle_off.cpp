#include "sim/physics/settle.h"

namespace cousin {

SettleResult settle(const std::vector<SettleBody>& bodies, const SettleConfig& config) {
  validate(config);
  SettleResult result;
  result.status = bodies.empty() ? SettleStatus::ok : SettleStatus::not_built;
  for (const SettleBody& body : bodies) result.world_from_body.push_back(body.world_from_body);
  return result;
}

}  // namespace cousin
