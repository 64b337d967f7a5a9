#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>
#include <string>

#include "benchmarks/report/pictures.h"
#include "benchmarks/suites/light/leafy_scene.h"
#include "benchmarks/suites/sensors/sensors_page.h"
#include "sim/imaging/image_io.h"
#include "sim/render/ray_scene.h"
#include "sim/sensors/active_stereo.h"

namespace cousin {
namespace {

struct ReasonColor {
  InvalidReason reason;
  Rgb8 color;
  const char* color_name;
};
constexpr std::array<ReasonColor, 8> kReasonColors = {{
    {InvalidReason::none, {40, 40, 40}, "dark grey"},
    {InvalidReason::out_of_range, {86, 180, 233}, "light blue"},
    {InvalidReason::band, {0, 114, 178}, "blue"},
    {InvalidReason::saturated, {240, 228, 66}, "yellow"},
    {InvalidReason::mixed_pixel, {230, 159, 0}, "orange"},
    {InvalidReason::left_right, {213, 94, 0}, "red"},
    {InvalidReason::no_projector, {204, 121, 167}, "pink"},
    {InvalidReason::no_texture, {0, 158, 115}, "green"},
}};

Image<Rgb8> grey(const Image<std::uint16_t>& codes) {
  Image<Rgb8> shown(codes.width(), codes.height());
  std::transform(codes.begin(), codes.end(), shown.begin(), [](std::uint16_t code) {
    const auto v = static_cast<std::uint8_t>(std::min<int>(code, 255));
    return Rgb8{v, v, v};
  });
  return shown;
}

Image<float> metres(const Image<std::uint16_t>& depth, double unit_m) {
  Image<float> out(depth.width(), depth.height());
  std::transform(depth.begin(), depth.end(), out.begin(), [&](std::uint16_t code) {
    return code == 0 ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(unit_m * code);
  });
  return out;
}

/// The picture and what its colours say, with shares.
ReportPicture reason_picture(const Image<InvalidReason>& reasons) {
  Image<Rgb8> shown(reasons.width(), reasons.height());
  std::array<std::size_t, kReasonColors.size()> counts{};
  for (std::size_t i = 0; i < reasons.size(); ++i) {
    const auto k = static_cast<std::size_t>(reasons.data()[i]);
    shown.data()[i] = kReasonColors[k].color;
    ++counts[k];
  }
  std::string caption;
  for (std::size_t k = 0; k < kReasonColors.size(); ++k) {
    if (counts[k] == 0) continue;
    char share[32];
    std::snprintf(share, sizeof share, " %.1f %%",
                  100.0 * static_cast<double>(counts[k]) / static_cast<double>(reasons.size()));
    const InvalidReason reason = kReasonColors[k].reason;
    const std::string name =
        reason == InvalidReason::none ? "has depth" : std::string(to_string(reason));
    caption += std::string(caption.empty() ? "" : ", ") + kReasonColors[k].color_name + ": " +
               name + share;
  }
  return {"Why pixels have no depth", caption, encode_png(shown)};
}

}  // namespace

ReportScene sensors_pictures(std::uint64_t seed) {
  const Rng rng = Rng(seed).fork("sensors pictures");
  ActiveStereoConfig config = active_stereo_preset("d457");
  const ActiveStereoUnit unit = make_active_stereo(config, rng.fork("unit"));
  Scene scene = leafy_scene();
  // Dim and even, so that the dots can be seen.
  scene.lights = {Sky{{0.004F, 0.004F, 0.004F}, {0.004F, 0.004F, 0.004F}, {0, 0, 0}}};
  const RayScene rays(scene);
  const Pose rig_from_world = look_at({-0.5, -0.45, 1.0}, {-0.05, 0.05, 0.2});
  const InfraredPair pair =
      render_infrared_pair(rays, scene, rig_from_world, config, unit, rng.fork("light"));
  const StereoDepth depth = sense_depth(pair, config, unit, rng.fork("exposure"));
  ReportScene pictures;
  pictures.name = "d457";
  pictures.pictures = {
      {"Left infrared image", "8 bits, as the imager hands it over: dots on leaves and soil",
       encode_png(grey(depth.left_codes))},
      {"Depth", "near is red, far is blue, none is dark grey",
       encode_png(depth_in_color(metres(depth.depth, config.depth_unit_m)))},
      reason_picture(depth.reason)};
  return pictures;
}

}  // namespace cousin
