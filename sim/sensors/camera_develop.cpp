#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "sim/imaging/color.h"
#include "sim/imaging/image_io.h"
#include "sim/sensors/camera_sensor.h"

namespace cousin {
namespace {

/// 8-bit codes of 65 536 linear values from 0 to 1: twenty to a code where the curves are steepest.
constexpr int kToneSteps = 65535;

std::vector<std::uint8_t> tone_table(const DevelopConfig& develop) {
  std::vector<std::uint8_t> table(kToneSteps + 1);
  for (int i = 0; i <= kToneSteps; ++i) {
    const double linear = static_cast<double>(i) / kToneSteps;
    std::uint8_t& code = table[static_cast<std::size_t>(i)];
    switch (develop.tone) {
      case ToneCurve::srgb:
        code = srgb8_from_linear(static_cast<float>(linear));
        break;
      case ToneCurve::gamma:
        code = static_cast<std::uint8_t>(std::lround(255 * std::pow(linear, 1 / develop.gamma)));
        break;
      case ToneCurve::linear:
        code = static_cast<std::uint8_t>(std::lround(255 * linear));
        break;
    }
  }
  return table;
}

/// Gain of red, green and blue: white balance, all scaled so that none is below 1. So each colour
/// saturates at 1 or above, and what is clipped in all of them is white.
std::array<double, 3> channel_gains(const PhotositesConfig& p, const DevelopConfig& d) {
  const double red = d.white_balance_red > 0 ? d.white_balance_red : 1 / p.sensitivity_red;
  const double blue = d.white_balance_blue > 0 ? d.white_balance_blue : 1 / p.sensitivity_blue;
  if (p.mosaic == Mosaic::grey) return {1, 1, 1};
  const double common = 1 / std::min({red, 1.0, blue});
  return {red * common, common, blue * common};
}

}  // namespace

Image<Rgbf> develop_linear(const Image<std::uint16_t>& raw, const CameraSensorConfig& config) {
  const PhotositesConfig& p = config.photosites;
  const double per_code = 1.0 / ((1 << p.bits) - 1 - p.black_level);
  const auto black = static_cast<float>(p.black_level);
  std::array<float, 3> gain{};
  std::ranges::transform(channel_gains(p, config.develop), gain.begin(),
                         [&](double g) { return static_cast<float>(per_code * g); });

  Image<float> balanced(raw.width(), raw.height());
  tbb::parallel_for(0, raw.height(), [&](int y) {
    const auto in = raw.row(y);
    const auto out = balanced.row(y);
    for (std::size_t x = 0; x < out.size(); ++x) {
      const int channel = bayer_channel(p.mosaic, static_cast<int>(x), y);
      out[x] = (static_cast<float>(in[x]) - black) * gain[static_cast<std::size_t>(channel)];
    }
  });
  Image<Rgbf> colour = demosaic(balanced, p.mosaic, config.develop.demosaic);
  if (p.srgb_from_camera.empty() || p.mosaic == Mosaic::grey) return colour;

  const Eigen::Matrix3f matrix = srgb_from_camera(p).cast<float>();
  tbb::parallel_for(0, colour.height(), [&](int y) {
    for (Rgbf& pixel : colour.row(y)) {
      // A clipped photosite says nothing of the colour: white stays white.
      const Eigen::Vector3f camera(std::min(pixel.r, 1.0F), std::min(pixel.g, 1.0F),
                                   std::min(pixel.b, 1.0F));
      const Eigen::Vector3f srgb = matrix * camera;
      pixel = {srgb.x(), srgb.y(), srgb.z()};
    }
  });
  return colour;
}

Image<Rgb8> develop(const Image<std::uint16_t>& raw, const CameraSensorConfig& config) {
  const Image<Rgbf> linear = develop_linear(raw, config);
  const std::vector<std::uint8_t> table = tone_table(config.develop);
  const auto code = [&](float value) {
    return table[static_cast<std::size_t>(std::clamp(value, 0.0F, 1.0F) * kToneSteps + 0.5F)];
  };
  Image<Rgb8> picture(linear.width(), linear.height());
  tbb::parallel_for(0, linear.height(), [&](int y) {
    const auto in = linear.row(y);
    const auto out = picture.row(y);
    for (std::size_t x = 0; x < out.size(); ++x) {
      out[x] = {code(in[x].r), code(in[x].g), code(in[x].b)};
    }
  });
  const int quality = config.develop.jpeg_quality;
  return quality > 0 ? decode_jpeg(encode_jpeg(picture, quality)) : picture;
}

}  // namespace cousin
