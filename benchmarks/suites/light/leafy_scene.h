#pragma once

#include "sim/truth/scene.h"
#include "sim/truth/truth_images.h"

namespace cousin {

/// The scene on which renderers are compared: 60 plants of 50 leaves in rows over bare soil, clear
/// sky and sun. 3,000 instances share 6 leaf shapes. Leaves reflect and transmit diffusely without
/// a wax coat and soil is diffuse, so that every renderer can express them. It stays as it is, or
/// numbers lose their meaning.
Scene leafy_scene();

/// 640 x 480, 1.5 m above the soil, looking down the rows; a pinhole.
TrueView leafy_view();

}  // namespace cousin
