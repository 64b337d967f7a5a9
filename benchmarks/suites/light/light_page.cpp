#include "benchmarks/suites/light/light_page.h"

#include <algorithm>
#include <cmath>

#include "benchmarks/suites/light/image_error.h"
#include "sim/imaging/color.h"
#include "sim/imaging/image_io.h"

namespace cousin {
namespace {

Image<Rgb8> exposed(const Image<Rgbf>& image, double factor) {
  Image<Rgb8> shown(image.width(), image.height());
  const auto code = [&](float v) { return srgb8_from_linear(static_cast<float>(factor) * v); };
  std::transform(image.begin(), image.end(), shown.begin(), [&](const Rgbf& c) {
    return Rgb8{code(c.r), code(c.g), code(c.b)};
  });
  return shown;
}

std::uint8_t grey_code(double share) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
}

void add(ReportScene& scene, const char* name, const char* caption, const Image<Rgb8>& image) {
  scene.pictures.push_back({name, caption, encode_png(image)});
}

}  // namespace

std::vector<ErrorTimeCurve> light_curves(const std::vector<ScoreRow>& rows) {
  std::vector<ErrorTimeCurve> curves;
  const auto add_curve = [&](const char* metric, const char* title) {
    ErrorTimeCurve curve;
    curve.title = title;
    curve.metric = "relative error of luminance, RMS over pixels";
    curve.unit = "1";
    for (const ScoreRow& row : rows) {
      if (row.suite != "light" || row.metric != metric || !(row.wall_s > 0)) continue;
      const bool is_adaptive = row.case_name.starts_with("adaptive, ");
      const std::string who = row.method == "cycles" ? "Cycles" : row.method;
      curve.points.push_back({who + (is_adaptive ? ", adaptive" : ", plain"),
                              is_adaptive ? row.case_name.substr(10) : row.case_name,
                              row.wall_s,
                              {row.value, row.ci_low, row.ci_high}});
    }
    if (!curve.points.empty()) curves.push_back(std::move(curve));
  };
  add_curve("relative_error",
            "Error against time on the leafy scene, each against its own converged image");
  add_curve("relative_error.pair",
            "Error against time on the leafy scene, from pairs of images: noise alone");
  return curves;
}

void add_light_pictures(ReportScene& scene, const Image<Rgbf>& ours, const Image<Rgbf>& theirs) {
  const double mean = mean_luminance(theirs);
  const double factor = mean > 0 ? 0.3 / mean : 1;
  add(scene, "Ours", "linear radiance under one exposure", exposed(ours, factor));
  add(scene, "Cycles", "the same scene and exposure", exposed(theirs, factor));
  Image<Rgb8> difference(ours.width(), ours.height());
  for (std::size_t i = 0; i < difference.size(); ++i) {
    const double a = luminance(ours.data()[i]), b = luminance(theirs.data()[i]);
    const std::uint8_t v = grey_code(0.5 + 5 * (a - b) / (0.5 * (a + b) + 0.1 * mean));
    difference.data()[i] = {v, v, v};
  }
  add(scene, "Ours less Cycles, 10 times",
      "luminance over its mean (+ a tenth of the image's): grey 0, white +10 %, black -10 %",
      difference);
}

void add_depth_picture(ReportScene& scene, const Image<float>& our_depth_m,
                       const Image<float>& their_depth_m, const Image<std::int32_t>& our_instance,
                       const Image<std::int32_t>& their_instance) {
  Image<Rgb8> picture(our_depth_m.width(), our_depth_m.height());
  for (std::size_t i = 0; i < picture.size(); ++i) {
    Rgb8& c = picture.data()[i];
    if (our_instance.data()[i] != their_instance.data()[i]) {
      c = {255, 40, 40};
    } else if (our_instance.data()[i] < 0) {
      c = {30, 50, 110};
    } else {
      const double ratio =
          static_cast<double>(our_depth_m.data()[i]) / static_cast<double>(their_depth_m.data()[i]);
      const std::uint8_t v = grey_code((std::log10(std::abs(ratio - 1) + 1e-12) + 7) / 5);
      c = {v, v, v};
    }
  }
  add(scene, "Difference of depth",
      "relative, logarithmic: black 1e-7, white 1e-2; red: another instance; blue: none", picture);
}

}  // namespace cousin
