#pragma once

#include "perception/pipelines/pipeline_table.h"
#include "sim/config/fields.h"

namespace cousin {

/// How a detector errs that hands over true boxes and masks; without noise by default.
struct BoxNoiseConfig {
  double missed = 0;   ///< share of the boxes that are not found, whatever their size
  double half_px = 0;  ///< pixels in sight of which half are found; 0: small ones are found too
  double edge_sigma_px = 0;  ///< a mask is larger all round, or smaller, by one draw of this
  double false_boxes = 0;    ///< mean count in an image of boxes of nothing
};
Fields fields(BoxNoiseConfig& config);
/// @throws std::invalid_argument naming key, value and limit
void validate(const BoxNoiseConfig& config);

/// Whether `run` makes boxes for a pipeline.
bool takes_boxes(const PipelineRow& row);

}  // namespace cousin
