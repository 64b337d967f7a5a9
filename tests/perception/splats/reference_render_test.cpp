#include "perception/splats/reference_render.h"

#include <gtest/gtest.h>

#include "tests/perception/splats/random_splats.h"

namespace cousin {
namespace {

using ColorRows = Eigen::Matrix<double, Eigen::Dynamic, 3>;

ReferenceView small_view() {
  ReferenceView view;
  view.camera = pinhole(24, 20, 26);
  view.camera_from_origin = view_of_cube();
  view.background = {0.2, 0.5, 0.1};
  return view;
}

ColorRows random_rows(Eigen::Index count) {
  ColorRows rows(count, 3);
  Rng rng(5);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (int k = 0; k < 3; ++k) rows(i, k) = normal(rng);
  }
  return rows;
}

double loss(const SplatParameters& parameters, const ReferenceView& view, const ColorRows& rows) {
  return render_reference(parameters, view).color.cwiseProduct(rows).sum();
}

// The loss jumps where a pixel's alpha crosses 1/255 or its transmittance 1e-4; a difference whose
// step meets a jump is told by a second step of half the size, and another Gaussian stands in.
TEST(ReferenceRender, EveryGradientIsTheFiniteDifference) {
  SplatParameters p = splat_parameters(random_splats(10, 3, 0.12));
  const ReferenceView view = small_view();
  const ColorRows rows = random_rows(view.camera.width_px * view.camera.height_px);
  const SplatParameters gradient = reference_gradients(p, view, rows);
  for (int k = 0; k < 59; ++k) {
    const double size = gradient.col(k).cwiseAbs().maxCoeff();
    EXPECT_GT(size, 0) << "parameter " << k;
    int smooth = 0;
    for (Eigen::Index i = 0; i < p.rows(); ++i) {
      const auto difference = [&](double step) {
        const double old = p(i, k);
        p(i, k) = old + step;
        const double up = loss(p, view, rows);
        p(i, k) = old - step;
        const double down = loss(p, view, rows);
        p(i, k) = old;
        return (up - down) / (2 * step);
      };
      // Truncation is step^2 times a third derivative of at most about 1e4, rounding 1e-13 / step.
      const double wide = difference(2e-6), narrow = difference(1e-6);
      if (std::abs(wide - narrow) > 1e-6 * size) continue;
      ++smooth;
      EXPECT_NEAR(gradient(i, k), narrow, 1e-4 * std::max(std::abs(narrow), 1e-2 * size))
          << "parameter " << k << " of Gaussian " << i;
    }
    EXPECT_GE(smooth, 6) << "parameter " << k;
  }
}

TEST(ReferenceRender, OneGaussianHasItsClosedForm) {
  // A sphere of sigma 0.05 at depth 1 on the axis: sigma 5 px, widened by the low-pass.
  std::vector<Splat> one(1);
  one[0].centre_m = {0, 0, 1};
  one[0].log_scale.setConstant(std::log(0.05F));
  one[0].opacity_logit = std::log(0.8F / 0.2F);
  one[0].sh_dc = {0.5F / 0.28209479F, 0, -0.5F / 0.28209479F};  // colour 1, 0.5, 0
  ReferenceView view;
  view.camera = pinhole(41, 31, 100);
  view.camera.fy_px = 100;
  view.camera.cx_px = 20;
  view.camera.cy_px = 15;
  view.background = {0, 0, 1};
  const ReferenceImage image = render_reference(splat_parameters(one), view);
  for (int y = 0; y < 31; ++y) {
    for (int x = 0; x < 41; ++x) {
      const double r2 = (x - 20) * (x - 20) + (y - 15) * (y - 15);
      double alpha = 0.8 * std::exp(-0.5 * r2 / (25 + 0.3));
      if (alpha < 1.0 / 255) alpha = 0;
      const Eigen::Index n = y * 41 + x;
      // The parameters were floats.
      EXPECT_NEAR(image.color(n, 0), alpha, 1e-6);
      EXPECT_NEAR(image.color(n, 1), 0.5 * alpha, 1e-6);
      EXPECT_NEAR(image.color(n, 2), 1 - alpha, 1e-6);
    }
  }
}

}  // namespace
}  // namespace cousin
