#pragma once

#include "perception/pipelines/views.h"

namespace cousin {

/// The depths of `config.cloud_views` views fused, in the poses' own unit; empty where no posed
/// view has depth.
Cloud views_cloud(const ViewsPipelineConfig& config, const Capture& capture,
                  const Estimate& so_far);

/// One closed mesh of all depths, within what the cloud covers, or where none was wanted the
/// depths; its status is `empty` where they cover nothing.
Surfaces views_mesh(const ViewsPipelineConfig& config, const Estimate& so_far);

}  // namespace cousin
