#include "perception/splats/splat_kernels.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstring>
#include <set>

#include "perception/splats/reference_render.h"
#include "perception/splats/splat_frame.h"
#include "tests/perception/splats/random_splats.h"

namespace cousin {
namespace {

std::vector<const SplatKernels*> all_kernels() {
  std::vector<const SplatKernels*> all = {&portable_splat_kernels()};
  if (avx2_splat_kernels() != nullptr) all.push_back(avx2_splat_kernels());
  return all;
}

ColorPlanes random_gradient(int width, int height) {
  ColorPlanes planes;
  Rng rng(9);
  for (Image<float>& channel : planes.channel) {
    channel = Image<float>(width, height);
    for (float& x : channel) x = static_cast<float>(normal(rng));
  }
  return planes;
}

struct Drawn {
  SplatFrame frame;
  SplatPlanes gradients;
};

constexpr std::array<float, 3> kBackground = {0.2F, 0.5F, 0.1F};
constexpr float kNear = 0.05F;

Drawn draw(const SplatKernels& kernels, const std::vector<Splat>& splats, const Camera& camera,
           const Pose& pose, const ColorPlanes& gradient, int degree = 3) {
  Drawn d;
  const SplatPlanes planes = to_planes(splats);
  draw_splats(kernels, planes, degree, splat_camera(camera, pose, {0, 0, 0}, kNear), kBackground,
              SplatDepths::none, d.frame);
  blend_gradients(kernels, gradient, kBackground, d.frame);
  d.gradients = parameter_gradients(kernels, planes, d.frame);
  return d;
}

ReferenceView reference_view(const Camera& camera, const Pose& pose) {
  ReferenceView view;
  view.camera = camera;
  view.camera_from_origin = pose;
  view.near_m = kNear;
  for (std::size_t k = 0; k < 3; ++k) view.background[k] = kBackground[k];
  return view;
}

// Floats against doubles. Where a pixel's alpha is within rounding of 1/255, one may draw it and
// the other not: such a pixel differs by at most 1/255 of a colour.
TEST(SplatKernels, ImagesAreTheReferences) {
  const Camera camera = pinhole(75, 53, 70);
  const std::vector<Splat> splats = random_splats(300, 1);
  const ReferenceImage expected =
      render_reference(splat_parameters(splats), reference_view(camera, view_of_cube()));
  for (const SplatKernels* kernels : all_kernels()) {
    const Drawn d = draw(*kernels, splats, camera, view_of_cube(), random_gradient(75, 53));
    int off = 0;
    for (int y = 0; y < 53; ++y) {
      for (int x = 0; x < 75; ++x) {
        double difference =
            std::abs(d.frame.transmittance(x, y) - expected.transmittance[y * 75 + x]);
        for (int k = 0; k < 3; ++k) {
          const float value = d.frame.color.channel[static_cast<std::size_t>(k)](x, y);
          const double own = std::abs(value - expected.color(y * 75 + x, k));
          EXPECT_TRUE(std::isfinite(own)) << kernels->name << " at " << x << ", " << y;
          difference = std::max(difference, own);
        }
        EXPECT_LT(difference, 0.02) << kernels->name << " at " << x << ", " << y;
        off += difference <= 2e-5 ? 0 : 1;
      }
    }
    EXPECT_LE(off, 8) << kernels->name;
  }
}

// 1e-3 of each parameter's root mean square gradient, beside 1e-3 of the value itself.
TEST(SplatKernels, GradientsAreTheReferences) {
  const int width = 75, height = 53;
  const Camera camera = pinhole(width, height, 70);
  const std::vector<Splat> splats = random_splats(300, 2);
  const ColorPlanes gradient = random_gradient(width, height);
  Eigen::Matrix<double, Eigen::Dynamic, 3> rows(width * height, 3);
  for (int n = 0; n < width * height; ++n) {
    for (int k = 0; k < 3; ++k) {
      rows(n, k) = gradient.channel[static_cast<std::size_t>(k)].data()[n];
    }
  }
  const SplatParameters expected =
      reference_gradients(splat_parameters(splats), reference_view(camera, view_of_cube()), rows);
  for (const SplatKernels* kernels : all_kernels()) {
    const Drawn d = draw(*kernels, splats, camera, view_of_cube(), gradient);
    std::set<int> off;
    for (int k = 0; k < SplatPlane::count; ++k) {
      const double rms = std::sqrt(expected.col(k).squaredNorm() / 300);
      EXPECT_GT(rms, 0);
      for (int i = 0; i < 300; ++i) {
        const double difference =
            std::abs(static_cast<double>(d.gradients.at(k, i)) - expected(i, k));
        const double size = std::abs(expected(i, k)) + rms;
        if (difference > 1e-3 * size) off.insert(i);
        EXPECT_LE(difference, 0.05 * size) << kernels->name << " " << k << " " << i;
      }
    }
    // Gaussians with a pixel at a threshold, as above: that pixel's share is off, no more.
    EXPECT_LE(off.size(), 4u) << kernels->name;
  }
}

// A thin Gaussian whose centre is up to 25,000 pixels off the image and that points at it: of the
// squares of such offsets no digit is left over for the pixels that it crosses.
Splat needle(double angle, float depth_m, float thickness_m) {
  Splat s;
  s.centre_m = {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), depth_m};
  s.log_scale = {std::log(0.5F), std::log(thickness_m), std::log(thickness_m)};
  s.rotation_wxyz = {static_cast<float>(std::cos(angle / 2)), 0, 0,
                     static_cast<float>(std::sin(angle / 2))};
  s.opacity_logit = 2;
  s.sh_dc = {1, 1, 1};
  return s;
}

TEST(SplatKernels, NeedlesFarBesideTheImageAreTheReferences) {
  const int width = 160, height = 90;
  const Camera camera = pinhole(width, height, 500);
  for (const SplatKernels* kernels : all_kernels()) {
    int seen = 0;
    for (const float depth_m : {0.02F, 0.1F, 0.3F}) {
      for (const float thickness_m : {1e-3F, 1e-5F}) {
        for (int i = 0; i < 40; ++i) {
          const std::vector<Splat> splats = {needle(0.157 * i, depth_m, thickness_m)};
          ReferenceView view = reference_view(camera, Pose{});
          view.near_m = 0.01;
          view.low_pass_px2 = 0.03;
          const ReferenceImage expected = render_reference(splat_parameters(splats), view);
          SplatCamera eye = splat_camera(camera, Pose{}, {0, 0, 0}, 0.01);
          eye.low_pass_px2 = 0.03F;
          SplatFrame frame;
          draw_splats(*kernels, to_planes(splats), 3, eye, kBackground, SplatDepths::none, frame);
          double worst = 0;
          for (int n = 0; n < width * height; ++n) {
            const double left = frame.transmittance.data()[n];
            worst = std::max(worst, std::abs(left - expected.transmittance[n]));
            ASSERT_LE(left, 1) << kernels->name << ", needle " << i << ", pixel " << n;
          }
          seen += expected.transmittance.minCoeff() < 0.9 ? 1 : 0;
          // The centre and the turn are floats: up to 0.005 px of the needle's 0.17.
          EXPECT_LT(worst, 0.05) << kernels->name << ", needle " << i << " at " << depth_m << ", "
                                 << thickness_m;
        }
      }
    }
    EXPECT_GT(seen, 40) << kernels->name;
  }
}

TEST(SplatKernels, PairsAreNumberedAsGaussiansLieInMemory) {
  const std::vector<Splat> splats = random_splats(3000, 5, 0.05);
  const ColorPlanes gradient = random_gradient(200, 150);
  const Drawn d =
      draw(best_splat_kernels(), splats, pinhole(200, 150, 180), view_of_cube(), gradient);
  const TileLists& lists = d.frame.lists;
  std::uint32_t next = 0;
  for (std::size_t i = 0; i < splats.size(); ++i) {
    ASSERT_EQ(lists.pair_first[i], next);
    next += lists.pair_count[i];
  }
  ASSERT_EQ(next, lists.tile_pair.size());
  // Each pair is of one entry, and of that entry's Gaussian; a tile's entries come front to back.
  std::vector<int> entries(next, 0);
  for (std::size_t tile = 0; tile + 1 < lists.tile_begin.size(); ++tile) {
    float before = 0;
    for (std::uint32_t e = lists.tile_begin[tile]; e < lists.tile_begin[tile + 1]; ++e) {
      const std::uint32_t splat = lists.tile_splat[e], pair = lists.tile_pair[e];
      ++entries.at(pair);
      ASSERT_GE(pair, lists.pair_first[splat]);
      ASSERT_LT(pair, lists.pair_first[splat] + lists.pair_count[splat]);
      ASSERT_GE(d.frame.projected[splat].depth_m, before);
      before = d.frame.projected[splat].depth_m;
    }
  }
  EXPECT_EQ(entries, std::vector<int>(next, 1));
}

TEST(SplatKernels, BytesDoNotDependOnThreads) {
  const Camera camera = pinhole(200, 150, 180);
  const std::vector<Splat> splats = random_splats(5000, 4, 0.03);
  const ColorPlanes gradient = random_gradient(200, 150);
  const auto with_threads = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return draw(best_splat_kernels(), splats, camera, view_of_cube(), gradient);
  };
  const Drawn one = with_threads(1), eight = with_threads(8);
  EXPECT_TRUE(one.frame.color.channel == eight.frame.color.channel);
  EXPECT_EQ(std::memcmp(one.gradients.lanes(0, 0), eight.gradients.lanes(0, 0),
                        sizeof(float) * 59 * static_cast<std::size_t>(one.gradients.padded())),
            0);
}

TEST(SplatKernels, EqualDepthsAreDrawnInTheirOrder) {
  // Two discs of opacity 0.9 at one place: the second has what the first leaves.
  for (const SplatKernels* kernels : all_kernels()) {
    std::vector<Splat> two(2);
    for (Splat& s : two) {
      s.centre_m = {0, 0, 1};
      s.log_scale.setConstant(std::log(0.2F));
      s.opacity_logit = std::log(9.0F);
    }
    two[0].sh_dc = {0.5F / 0.28209479F, -0.5F / 0.28209479F, -0.5F / 0.28209479F};
    two[1].sh_dc = {-0.5F / 0.28209479F, 0.5F / 0.28209479F, -0.5F / 0.28209479F};
    Camera camera = pinhole(32, 32, 40);
    camera.cx_px = camera.cy_px = 16;
    const Drawn d = draw(*kernels, two, camera, Pose{}, random_gradient(32, 32));
    EXPECT_NEAR(d.frame.color.channel[0](16, 16), 0.9 + 0.01 * 0.2, 1e-5);
    EXPECT_NEAR(d.frame.color.channel[1](16, 16), 0.09 + 0.01 * 0.5, 1e-5);
    std::swap(two[0], two[1]);
    const Drawn swapped = draw(*kernels, two, camera, Pose{}, random_gradient(32, 32));
    EXPECT_NEAR(swapped.frame.color.channel[1](16, 16), 0.9 + 0.01 * 0.5, 1e-5);
  }
}

// A grid of what breaks rasterisers: no image and no gradient may be anything but finite.
TEST(SplatKernels, ExtremeGaussiansHaveFiniteImagesAndGradients) {
  const float scales[] = {1e-9F, 1e-4F, 1, 1e3F};
  const float logits[] = {-INFINITY, -5, 0, 40, INFINITY};
  const Eigen::Vector4f turns[] = {
      {0, 0, 0, 0}, {1e-30F, 0, 0, 0}, {1, 2, -3, 0.5F}, {1e20F, 1e20F, 0, 0}};
  const float depths[] = {-1, 0, 1e-30F, kNear, 1, 1e6F};
  std::vector<Splat> splats;
  for (const float a : scales) {
    for (const float b : scales) {
      for (const float logit : logits) {
        for (const auto& turn : turns) {
          for (const float depth : depths) {
            Splat s;
            s.centre_m = {0.01F * depth, -0.02F * depth, depth};
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
  const Camera camera = pinhole(40, 30, 35);
  const ColorPlanes gradient = random_gradient(40, 30);
  for (const SplatKernels* kernels : all_kernels()) {
    // All of them, and each alone: then it hides behind nothing.
    for (std::size_t alone = 0; alone <= splats.size(); ++alone) {
      const std::vector<Splat> chosen =
          alone == splats.size() ? splats : std::vector<Splat>{splats[alone]};
      const Drawn d = draw(*kernels, chosen, camera, Pose{}, gradient);
      for (const Image<float>& channel : d.frame.color.channel) {
        for (const float x : channel) ASSERT_TRUE(std::isfinite(x)) << kernels->name << alone;
      }
      for (int k = 0; k < SplatPlane::count; ++k) {
        for (int i = 0; i < d.gradients.size(); ++i) {
          ASSERT_TRUE(std::isfinite(d.gradients.at(k, i)))
              << kernels->name << ", Gaussian " << alone << ", parameter " << k;
        }
      }
    }
  }
}

TEST(SplatKernels, ParametersThatAreNotNumbersAreLeftOut) {
  const Camera camera = pinhole(40, 30, 35);
  const ColorPlanes gradient = random_gradient(40, 30);
  const std::vector<Splat> good = random_splats(20, 6);
  for (const SplatKernels* kernels : all_kernels()) {
    const Drawn expected = draw(*kernels, good, camera, view_of_cube(), gradient);
    std::vector<Splat> all = good;
    for (int k = 0; k < SplatPlane::count; ++k) {
      SplatPlanes one = to_planes({good[0]});
      one.at(k, 0) = NAN;
      all.push_back(to_splats(one)[0]);
    }
    const Drawn d = draw(*kernels, all, camera, view_of_cube(), gradient);
    EXPECT_TRUE(d.frame.color.channel == expected.frame.color.channel) << kernels->name;
  }
}

}  // namespace
}  // namespace cousin
