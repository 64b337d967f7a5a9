#include "perception/ngp/ngp.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "perception/ngp/ngp_rays.h"
#include "sim/types/rng.h"
#include "tests/perception/ngp/small_field.h"

namespace cousin {
namespace {

double psnr(const Image<Rgb8>& a, const Image<Rgb8>& b) {
  double sum = 0;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) {
      const double r = a(x, y).r - b(x, y).r, g = a(x, y).g - b(x, y).g, v = a(x, y).b - b(x, y).b;
      sum += r * r + g * g + v * v;
    }
  }
  return 10 * std::log10(255.0 * 255.0 * 3 * static_cast<double>(a.size()) / sum);
}

TEST(Ngp, LearnsAViewThatItHasNotSeen) {
  std::vector<NgpView> views = ball_views(16);
  const NgpView held = ball_view(small_camera(), 0.2);
  NgpConfig config = small_field_config();
  config.iterations = 400;
  const NgpTraining training = train_ngp(views, config);
  ASSERT_EQ(training.status, NgpStatus::ok) << training.reason;
  const NgpImage image = render_ngp(training.model, held.camera, held.camera_from_world);
  // An all-black picture has 12 dB; edges a pixel wide keep these views from being perfect.
  EXPECT_GT(psnr(image.color, held.color), 21);
  // The ball's middle is 1.208 - 0.3 m away.
  EXPECT_NEAR(image.depth_m(24, 18), 0.908, 0.03);
  EXPECT_TRUE(std::isnan(image.depth_m(0, 0)));
  EXPECT_LT(training.curve.back().loss, 0.3 * training.curve.front().loss);
}

// Rays end where they are opaque; the whole ray, all samples at once, gives the same picture.
TEST(Ngp, ARayThatEndsEarlyHasTheColourOfTheWhole) {
  const NgpView view = ball_view(small_camera(), 0.3);
  NgpConfig config = small_field_config();
  config.background = {0.1, 0.6, 0.2};
  const NgpTraining training = train_ngp(ball_views(8), config);
  ASSERT_EQ(training.status, NgpStatus::ok);
  const NgpModel& model = training.model;
  const NgpImage image = render_ngp(model, view.camera, view.camera_from_world);
  const Pose world_from_camera = inverse(view.camera_from_world);
  const Eigen::Vector3f origin =
      ((world_from_camera.translation_m - model.volume.centre_in_world_m) / model.volume.side_m)
          .cast<float>();
  const Eigen::Matrix3f turn = world_from_camera.rotation.toRotationMatrix().cast<float>();
  const Image<Eigen::Vector3f> directions = ngp::pixel_directions(view.camera);
  const auto levels = ngp::grid_levels(model.config.grid);
  ngp::RayBundle bundle;
  ngp::FieldBatch<float> batch;
  int opaque = 0, longest = 0;
  for (int y = 0; y < image.color.height(); ++y) {
    for (int x = 0; x < image.color.width(); ++x) {
      bundle.clear();
      const Eigen::Vector3f direction = turn * directions(x, y);
      bundle.add(model, ngp::march_config(config), origin, direction, 0.5F);
      const auto basis = {ngp::harmonics(direction)};
      bundle.run(model, levels, ngp::dense_kernels(), basis, batch);
      const ngp::RaySamples<float> samples = bundle.ray(batch, 0);
      const ngp::RayColor<float> whole = ngp::composite(samples, {0.1F, 0.6F, 0.2F});
      const Rgb8 pixel = image.color(x, y);
      const std::array<int, 3> drawn = {pixel.r, pixel.g, pixel.b};
      for (std::size_t c = 0; c < 3; ++c)
        ASSERT_EQ(drawn[c], std::lround(255 * std::clamp(whole.color[c], 0.0F, 1.0F)));
      ASSERT_EQ(image.alpha(x, y), 1 - whole.transmittance);
      opaque += whole.used < samples.count ? 1 : 0;
      longest = std::max(longest, samples.count);
    }
  }
  EXPECT_GT(opaque, 20);   // rays that did end early
  EXPECT_GT(longest, 16);  // and more than two rounds
}

TEST(Ngp, SameBytesOnAnyNumberOfThreads) {
  const std::vector<NgpView> views = ball_views(6);
  NgpConfig config = small_field_config();
  config.iterations = 40;
  const NgpTraining many = train_ngp(views, config);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const NgpTraining single = train_ngp(views, config);
  EXPECT_EQ(many.model.table, single.model.table);
  EXPECT_EQ(many.model.weights, single.model.weights);
  EXPECT_EQ(many.model.occupancy.filled, single.model.occupancy.filled);
}

TEST(Ngp, SnapshotsAreTakenWhereAsked) {
  std::vector<int> taken;
  NgpConfig config = small_field_config();
  config.iterations = 12;
  double before_s = 0;
  const auto take = [&](const NgpPoint& point, const NgpModel& model) {
    taken.push_back(point.iteration);
    EXPECT_FALSE(model.weights.empty());
    EXPECT_GT(point.wall_s, before_s);
    before_s = point.wall_s;
  };
  const NgpTraining training = train_ngp(ball_views(4), config, {{5, 12, 99}, take});
  EXPECT_EQ(taken, (std::vector<int>{5, 12}));
}

TEST(Ngp, WhatCannotBeLearnedIsAStatus) {
  NgpConfig config = small_field_config();
  config.iterations = 3;
  EXPECT_EQ(train_ngp({}, config).status, NgpStatus::too_few_views);
  EXPECT_EQ(train_ngp(ball_views(1), config).status, NgpStatus::too_few_views);

  std::vector<NgpView> masked = ball_views(3);
  for (NgpView& view : masked) view.mask = Image<std::uint8_t>(48, 36, 0);
  EXPECT_EQ(train_ngp(masked, config).status, NgpStatus::no_pixels);

  // Cameras back to back: nothing lies in front of both.
  std::vector<NgpView> away = ball_views(2);
  for (std::size_t v = 0; v < 2; ++v)
    away[v].camera_from_world = look_at({v ? 1.0 : -1.0, 0, 0}, {v ? 2.0 : -2.0, 0, 0});
  config.side_m = 0;
  EXPECT_EQ(train_ngp(away, config).status, NgpStatus::no_volume);
  EXPECT_EQ(ngp_volume({}, {}).side_m, 0);

  // All look straight down: no point is nearer to their axes than the cameras are themselves.
  std::vector<NgpView> down = ball_views(10);
  for (std::size_t v = 0; v < down.size(); ++v) {
    const double x = 0.1 * static_cast<double>(v), z = v % 2 == 0 ? 2.00 : 2.02;
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()));
    down[v].camera_from_world = {turn, turn * Eigen::Vector3d(-x, 0, -z)};
  }
  const NgpTraining parallel = train_ngp(down, config);
  EXPECT_EQ(parallel.status, NgpStatus::no_volume);
  EXPECT_NE(parallel.reason.find("in parallel"), std::string::npos);

  // Cubes that no camera sees: nothing was learned, whatever the loss.
  config.centre_m = {0, 0, 1000};
  config.side_m = 1.2;
  config.cascades = 1;
  const NgpTraining nowhere = train_ngp(ball_views(3), config);
  EXPECT_EQ(nowhere.status, NgpStatus::no_volume);
  EXPECT_EQ(nowhere.samples, 0);
}

TEST(Ngp, IdenticalAndBlackViewsStayFinite) {
  NgpConfig config = small_field_config();
  config.iterations = 30;
  std::vector<NgpView> same(3, ball_view(small_camera(), 0.1));
  EXPECT_EQ(train_ngp(same, config).status, NgpStatus::ok);
  std::vector<NgpView> black = ball_views(3);
  for (NgpView& view : black) view.color = Image<Rgb8>(48, 36);
  const NgpTraining dark = train_ngp(black, config);
  EXPECT_EQ(dark.status, NgpStatus::ok);
  for (const float w : dark.model.weights) ASSERT_TRUE(std::isfinite(w));
}

TEST(Ngp, BadInputIsNamed) {
  std::vector<NgpView> views = ball_views(2);
  views[1].color = Image<Rgb8>(10, 10);
  try {
    train_ngp(views, small_field_config());
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "view 1: image of 10 x 10 but the camera has 48 x 36");
  }
  Pose nowhere;
  nowhere.translation_m.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(render_ngp({}, views[0].camera, nowhere), std::invalid_argument);
  NgpConfig config = small_field_config();
  config.grid.log2_table = 40;
  EXPECT_THROW(validate(config), std::invalid_argument);
  config = small_field_config();
  config.centre_m = {0, 0};
  EXPECT_THROW(validate(config), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
