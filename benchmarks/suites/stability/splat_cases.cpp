#include "benchmarks/suites/stability/splat_cases.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <numbers>
#include <string>

#include "benchmarks/suites/stability/splat_cube.h"
#include "perception/splats/reference_render.h"
#include "perception/splats/splat_frame.h"
#include "perception/splats/splat_ply.h"
#include "sim/process/scratch_folder.h"
#include "sim/types/rng.h"

namespace cousin {
namespace {

const int kWidth = cube_camera().width_px, kHeight = cube_camera().height_px;
constexpr std::array<float, 3> kBackground = {0.2F, 0.5F, 0.1F};
constexpr float kNear_m = 0.05F;

/// Every combination of what breaks a covariance, a projection or an opacity, along the ray (u, v).
std::vector<Splat> extreme_splats(float u, float v) {
  const Eigen::Vector4f turns[] = {
      {0, 0, 0, 0}, {1e-30F, 0, 0, 0}, {1, 2, -3, 0.5F}, {1e20F, 1e20F, 0, 0}};
  std::vector<Splat> splats;
  for (const float a : {1e-9F, 1e-4F, 1.0F, 1e3F}) {
    for (const float b : {1e-9F, 1e-4F, 1.0F, 1e3F}) {
      for (const float logit : {-INFINITY, -5.0F, 0.0F, 40.0F, INFINITY}) {
        for (const auto& turn : turns) {
          for (const float depth_m : {-1.0F, 0.0F, 1e-30F, kNear_m, 1.0F, 1e6F}) {
            Splat s;
            s.centre_m = {u * depth_m, v * depth_m, depth_m};
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
  Image<float> depth_m, mean_depth_m;
  SplatPlanes gradients;
};

Drawn draw(const std::vector<Splat>& splats, const Pose& pose, double low_pass_px2 = 0.3) {
  const SplatKernels& kernels = best_splat_kernels();
  const SplatPlanes planes = to_planes(splats);
  SplatCamera camera = splat_camera(cube_camera(), pose, {0, 0, 0}, kNear_m);
  camera.low_pass_px2 = static_cast<float>(low_pass_px2);
  SplatFrame frame;
  draw_splats(kernels, planes, 3, camera, kBackground, SplatDepths::with, frame);
  blend_gradients(kernels, gradient_planes(), kBackground, frame);
  return {frame.color, frame.depth_m, frame.mean_depth_m,
          parameter_gradients(kernels, planes, frame)};
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

/// Depths that no surface before the camera has; NaN says that there is none.
double impossible_depths(const Drawn& drawn) {
  double count = 0;
  for (const Image<float>* depth_m : {&drawn.depth_m, &drawn.mean_depth_m}) {
    for (const float z : *depth_m) count += std::isinf(z) || z <= 0 ? 1 : 0;
  }
  return count;
}

/// Extremes on the axis, at the image's edge and beyond it, each alone and all together.
void extreme_rows(std::vector<StabilityRow>& rows) {
  struct Ray {
    const char* name;
    float u, v;
  };
  constexpr Ray kRays[] = {{"near the axis", 0.01F, -0.02F},
                           {"at the image's edge", 0.42F, -0.29F},
                           {"beyond 1.3 of the field of view", 2.5F, 1.5F}};
  for (const Ray& ray : kRays) {
    const std::vector<Splat> extreme = extreme_splats(ray.u, ray.v);
    Drawn drawn = draw(extreme, Pose{});
    double count = not_finite(drawn), impossible = impossible_depths(drawn);
    for (const Splat& alone : extreme) {
      drawn = draw({alone}, Pose{});
      count += not_finite(drawn);
      impossible += impossible_depths(drawn);
    }
    const std::string name =
        "scales 1e-9..1e3, no turns, opacity 0..1, depths -1..1e6 m, " + std::string(ray.name);
    rows.push_back(make_row(name, "values not finite", "", 0, count));
    rows.push_back(make_row(name, "depths of 0 or less, or infinite", "", 0, impossible));
  }
}

/// A thin Gaussian 1 m beside the axis that points at it: its centre is 1,700 to 25,000 pixels
/// off the image, which it crosses.
Splat needle(double angle, float depth_m, float thickness_m) {
  Splat s;
  s.centre_m = {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), depth_m};
  s.log_scale = {std::log(0.5F), std::log(thickness_m), std::log(thickness_m)};
  s.rotation_wxyz = {static_cast<float>(std::cos(angle / 2)), 0, 0,
                     static_cast<float>(std::sin(angle / 2))};
  s.opacity_logit = 2;
  return s;
}

void needle_rows(std::vector<StabilityRow>& rows) {
  constexpr int kNeedles = 40;
  constexpr double kLowPass_px2 = 0.03, kLeast_m = 0.01;
  Camera camera = cube_camera();
  camera.fx_px = camera.fy_px = 500;
  double worst = 0, beyond = 0;
  for (const float depth_m : {0.02F, 0.1F, 0.3F}) {
    for (const float thickness_m : {1e-3F, 1e-5F}) {
      for (int i = 0; i < kNeedles; ++i) {
        const std::vector<Splat> splats = {
            needle(2 * std::numbers::pi * i / kNeedles, depth_m, thickness_m)};
        ReferenceView view;
        view.camera = camera;
        view.near_m = kLeast_m;
        view.low_pass_px2 = kLowPass_px2;
        const ReferenceImage expected = render_reference(splat_parameters(splats), view);
        SplatCamera eye = splat_camera(camera, Pose{}, {0, 0, 0}, kLeast_m);
        eye.low_pass_px2 = static_cast<float>(kLowPass_px2);
        SplatFrame frame;
        draw_splats(best_splat_kernels(), to_planes(splats), 3, eye, kBackground, SplatDepths::none,
                    frame);
        for (Eigen::Index n = 0; n < expected.transmittance.size(); ++n) {
          const double left = frame.transmittance.data()[n];
          worst = worse(worst, std::abs(left - expected.transmittance[n]));
          beyond += left >= 0 && left <= 1 ? 0 : 1;
        }
      }
    }
  }
  const std::string name = "needles of 0.5 m whose centre is up to 25,000 px beside the image";
  // Their centre and turn are floats: 0.004 px of a needle's 0.17.
  rows.push_back(make_row(name, "largest error of alpha", "", 0.01, worst));
  rows.push_back(make_row(name, "transmittances outside 0..1", "", 0, beyond));
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
                            "share of pixels off by 1e-4", "", 0,
                            share_off(render_splats(model, cube_camera(), pose).color, expected)));
  }
  SplatModel far = cube_of_splats();
  far.origin_in_world_m = {1e6, -2e6, 3e5};
  Pose pose = view_of_cube();
  pose.translation_m -= pose.rotation * far.origin_in_world_m;
  const ScratchFolder scratch("cousin-stability");
  const std::filesystem::path file = scratch.path() / "far.ply";
  write_splat_ply(file, far);
  rows.push_back(make_row(
      "scene 2e6 m from zero, written and read again", "share of pixels off by 1e-4", "", 0,
      share_off(render_splats(read_splat_ply(file).model, cube_camera(), pose).color, expected)));
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
double gradients_off(const SplatModel& model, const Pose& pose, double low_pass_px2 = 0.3) {
  const Drawn drawn = draw(model.splats, pose, low_pass_px2);
  ReferenceView view;
  view.low_pass_px2 = low_pass_px2;
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

/// Of the double reference: largest distance of a parameter's gradient from the central difference,
/// over its size and at least a hundredth of the largest of that parameter. The loss jumps where a
/// pixel's alpha crosses 1/255 or its transmittance 1e-4; a difference that meets a jump is told by
/// a second step of half the size, and left out. Counts parameters of which fewer than a fifth of
/// the Gaussians are left.
void finite_difference_rows(std::vector<StabilityRow>& rows) {
  constexpr std::ptrdiff_t kGaussians = 10;
  SplatModel model = cube_of_splats();
  model.splats.resize(kGaussians);
  SplatParameters p = splat_parameters(model.splats);
  ReferenceView view;
  view.camera = cube_camera();
  view.camera.width_px = 36;
  view.camera.height_px = 25;
  view.camera.fx_px /= 3;
  view.camera.fy_px /= 3;
  view.camera.cx_px = 17.5;
  view.camera.cy_px = 12;
  view.camera_from_origin = view_of_cube();
  view.near_m = kNear_m;
  Eigen::Matrix<double, Eigen::Dynamic, 3> weights(36 * 25, 3);
  Rng rng = Rng(1).fork("finite differences");
  for (double& x : weights.reshaped()) x = normal(rng);
  const SplatParameters gradient = reference_gradients(p, view, weights);
  const auto loss = [&] { return render_reference(p, view).color.cwiseProduct(weights).sum(); };
  double worst = 0, few = 0;
  for (Eigen::Index k = 0; k < p.cols(); ++k) {
    const double size = gradient.col(k).cwiseAbs().maxCoeff();
    int smooth = 0;
    for (Eigen::Index i = 0; i < p.rows(); ++i) {
      const auto difference = [&](double step) {
        const double old = p(i, k);
        p(i, k) = old + step;
        const double up = loss();
        p(i, k) = old - step;
        const double down = loss();
        p(i, k) = old;
        return (up - down) / (2 * step);
      };
      const double wide = difference(2e-6), narrow = difference(1e-6);
      if (std::abs(wide - narrow) > 1e-6 * size) continue;
      ++smooth;
      const double scale = std::max(std::abs(narrow), 1e-2 * size);
      worst = worse(worst, std::abs(gradient(i, k) - narrow) / scale);
    }
    few += size > 0 && smooth >= kGaussians / 5 ? 0 : 1;
  }
  const std::string name = "double reference beside finite differences, 59 parameters";
  rows.push_back(make_row(name, "largest relative error", "", 1e-4, worst));
  rows.push_back(make_row(name, "parameters with too few smooth differences", "", 0, few));
}

}  // namespace

std::vector<StabilityRow> splat_cases() {
  std::vector<StabilityRow> rows;
  extreme_rows(rows);
  needle_rows(rows);
  finite_difference_rows(rows);
  invariance_rows(rows);
  for (const double low_pass_px2 : {0.3, 0.1, 0.03}) {
    char name[96];
    std::snprintf(name, sizeof name, "float kernels beside the double reference, low pass %g px2",
                  low_pass_px2);
    rows.push_back(make_row(name, "share of gradients off by 1e-3", "", 0,
                            gradients_off(cube_of_splats(), view_of_cube(), low_pass_px2)));
  }
  const SplatModel flat = cube_at_one_depth();
  rows.push_back(make_row("400 Gaussians at one depth", "values not finite", "", 0,
                          not_finite(draw(flat.splats, Pose{}))));
  rows.push_back(make_row("400 Gaussians at one depth", "share of gradients off by 1e-3", "", 0,
                          gradients_off(flat, Pose{})));
  return rows;
}

}  // namespace cousin
