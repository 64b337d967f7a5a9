#include "benchmarks/stability/splat_cases.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "benchmarks/stability/splat_cube.h"
#include "perception/splats/reference_render.h"
#include "perception/splats/splat_frame.h"
#include "sim/types/rng.h"

namespace cousin {
namespace {

const int kWidth = cube_camera().width_px, kHeight = cube_camera().height_px;
constexpr std::array<float, 3> kBackground = {0.2F, 0.5F, 0.1F};
constexpr float kNear_m = 0.05F;

/// Every combination of what breaks a covariance, a projection or an opacity.
std::vector<Splat> extreme_splats() {
  const Eigen::Vector4f turns[] = {
      {0, 0, 0, 0}, {1e-30F, 0, 0, 0}, {1, 2, -3, 0.5F}, {1e20F, 1e20F, 0, 0}};
  std::vector<Splat> splats;
  for (const float a : {1e-9F, 1e-4F, 1.0F, 1e3F}) {
    for (const float b : {1e-9F, 1e-4F, 1.0F, 1e3F}) {
      for (const float logit : {-INFINITY, -5.0F, 0.0F, 40.0F, INFINITY}) {
        for (const auto& turn : turns) {
          for (const float depth_m : {-1.0F, 0.0F, 1e-30F, kNear_m, 1.0F, 1e6F}) {
            Splat s;
            s.centre_m = {0.01F * depth_m, -0.02F * depth_m, depth_m};
            s.log_scale = {std::log(a), std::log(b), std::log(a)};
            s.rotation_wxyz = turn;
            s.opacity_logit = logit;
            s.sh_rest.fill(0.1F);
            splats.push_back(s);
          }
        }
      }
    }
  }
  return splats;
}

/// The cube pressed flat, 1.5 m before the camera Pose{}: which of two Gaussians that cover each
/// other is in front is their order's alone.
SplatModel cube_at_one_depth() {
  SplatModel model = cube_of_splats();
  for (Splat& s : model.splats) s.centre_m.z() = 1.5F;
  return model;
}

ColorPlanes gradient_planes() {
  ColorPlanes planes;
  Rng rng = Rng(1).fork("gradient");
  for (Image<float>& channel : planes.channel) {
    channel = Image<float>(kWidth, kHeight);
    for (float& x : channel) x = static_cast<float>(normal(rng));
  }
  return planes;
}

struct Drawn {
  ColorPlanes color;
  SplatPlanes gradients;
};

Drawn draw(const std::vector<Splat>& splats, const Pose& pose) {
  const SplatKernels& kernels = best_splat_kernels();
  const SplatPlanes planes = to_planes(splats);
  SplatFrame frame;
  draw_splats(kernels, planes, 3, splat_camera(cube_camera(), pose, {0, 0, 0}, kNear_m),
              kBackground, SplatDepths::none, frame);
  blend_gradients(kernels, gradient_planes(), kBackground, frame);
  return {frame.color, parameter_gradients(kernels, planes, frame)};
}

double not_finite(const Drawn& drawn) {
  double count = 0;
  for (const Image<float>& channel : drawn.color.channel) {
    for (const float x : channel) count += std::isfinite(x) ? 0 : 1;
  }
  for (int k = 0; k < SplatPlane::count; ++k) {
    for (int i = 0; i < drawn.gradients.size(); ++i) {
      count += std::isfinite(drawn.gradients.at(k, i)) ? 0 : 1;
    }
  }
  return count;
}

/// Share of the pixels that differ by more than 1e-4: those where rounding turns a decision at an
/// alpha of 1/255.
double share_off(const ColorPlanes& a, const ColorPlanes& b) {
  double off = 0;
  for (std::size_t i = 0; i < a.channel[0].size(); ++i) {
    double largest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      largest = worse(largest, std::abs(a.channel[k].data()[i] - b.channel[k].data()[i]));
    }
    off += largest <= 1e-4 ? 0 : 1;
  }
  return off / static_cast<double>(a.channel[0].size());
}

void invariance_rows(std::vector<StabilityRow>& rows) {
  const ColorPlanes expected = render_splats(cube_of_splats(), cube_camera(), view_of_cube()).color;
  for (const double factor : {1e-3, 1e3}) {
    SplatModel model = cube_of_splats();
    for (Splat& s : model.splats) {
      s.centre_m *= static_cast<float>(factor);
      s.log_scale.array() += static_cast<float>(std::log(factor));
    }
    Pose pose = view_of_cube();
    pose.translation_m *= factor;
    rows.push_back(make_row("scene times " + std::string(factor < 1 ? "1e-3" : "1e3"),
                            "share of pixels off by 1e-4", "", 0.002,
                            share_off(render_splats(model, cube_camera(), pose).color, expected)));
  }
  SplatModel far = cube_of_splats();
  far.origin_in_world_m = {1e6, -2e6, 3e5};
  Pose pose = view_of_cube();
  pose.translation_m -= pose.rotation * far.origin_in_world_m;
  rows.push_back(make_row("scene 2e6 m from zero", "share of pixels off by 1e-4", "", 0.002,
                          share_off(render_splats(far, cube_camera(), pose).color, expected)));
  SplatModel reversed = cube_of_splats();
  std::reverse(reversed.splats.begin(), reversed.splats.end());
  const ColorPlanes other = render_splats(reversed, cube_camera(), view_of_cube()).color;
  double changed = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t i = 0; i < other.channel[k].size(); ++i) {
      changed += other.channel[k].data()[i] != expected.channel[k].data()[i] ? 1 : 0;
    }
  }
  rows.push_back(make_row("Gaussians in reverse order", "values changed", "", 0, changed));
}

/// Share of the kernels' gradients farther from the double reference than 1e-3 of the value and of
/// the parameter's root mean square.
double gradients_off(const SplatModel& model, const Pose& pose) {
  const Drawn drawn = draw(model.splats, pose);
  ReferenceView view;
  view.camera = cube_camera();
  view.camera_from_origin = pose;
  view.near_m = kNear_m;
  for (std::size_t k = 0; k < 3; ++k) view.background[k] = kBackground[k];
  const ColorPlanes gradient = gradient_planes();
  Eigen::Matrix<double, Eigen::Dynamic, 3> rows(kWidth * kHeight, 3);
  for (int n = 0; n < kWidth * kHeight; ++n) {
    for (int k = 0; k < 3; ++k) {
      rows(n, k) = gradient.channel[static_cast<std::size_t>(k)].data()[n];
    }
  }
  const SplatParameters expected = reference_gradients(splat_parameters(model.splats), view, rows);
  double off = 0;
  for (int k = 0; k < SplatPlane::count; ++k) {
    const double rms =
        std::sqrt(expected.col(k).squaredNorm() / static_cast<double>(expected.rows()));
    for (int i = 0; i < drawn.gradients.size(); ++i) {
      const double limit = 1e-3 * (std::abs(expected(i, k)) + rms);
      off += std::abs(drawn.gradients.at(k, i) - expected(i, k)) <= limit ? 0 : 1;
    }
  }
  return off / static_cast<double>(expected.size());
}

}  // namespace

std::vector<StabilityRow> splat_cases() {
  std::vector<StabilityRow> rows;
  const std::vector<Splat> extreme = extreme_splats();
  double count = not_finite(draw(extreme, Pose{}));
  for (const Splat& alone : extreme) count += not_finite(draw({alone}, Pose{}));
  rows.push_back(make_row("scales 1e-9..1e3, no turns, opacity 0..1, depths -1..1e6 m",
                          "values not finite", "", 0, count));
  invariance_rows(rows);
  rows.push_back(make_row("float kernels beside the double reference",
                          "share of gradients off by 1e-3", "", 0.01,
                          gradients_off(cube_of_splats(), view_of_cube())));
  const SplatModel flat = cube_at_one_depth();
  rows.push_back(make_row("400 Gaussians at one depth", "values not finite", "", 0,
                          not_finite(draw(flat.splats, Pose{}))));
  rows.push_back(make_row("400 Gaussians at one depth", "share of gradients off by 1e-3", "", 0.01,
                          gradients_off(flat, Pose{})));
  return rows;
}

}  // namespace cousin
