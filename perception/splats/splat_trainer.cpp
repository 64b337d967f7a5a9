#include "perception/splats/splat_trainer.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <numeric>

#include "perception/splats/splat_growth.h"

namespace cousin {
namespace {

using Range = tbb::blocked_range<int>;
using Clock = std::chrono::steady_clock;

/// Adds the time from its making to its end to a sum.
class Lap {
 public:
  explicit Lap(double& sum) : sum_(sum), start_(Clock::now()) {}
  ~Lap() { sum_ += std::chrono::duration<double>(Clock::now() - start_).count(); }

 private:
  double& sum_;
  Clock::time_point start_;
};

/// CPU seconds of all threads.
class CpuLap {
 public:
  explicit CpuLap(double& sum) : sum_(sum), start_(std::clock()) {}
  ~CpuLap() { sum_ += static_cast<double>(std::clock() - start_) / CLOCKS_PER_SEC; }

 private:
  double& sum_;
  std::clock_t start_;
};

/// 1.1 times the largest distance of a camera from their mean, as the reference.
double extent_of(std::span<const SplatView> views) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const SplatView& view : views) mean += centre_in_world_m(view.camera_from_world);
  mean /= static_cast<double>(std::max<std::size_t>(1, views.size()));
  double largest = 0;
  for (const SplatView& view : views) {
    largest = std::max(largest, (centre_in_world_m(view.camera_from_world) - mean).norm());
  }
  return 1.1 * largest;
}

double exponential_between(double first, double last, double progress) {
  if (!(first > 0) || !(last > 0)) return first + (last - first) * progress;
  return first * std::pow(last / first, progress);
}

AdamRate adam_rate(double rate, int update, double beta1, double beta2) {
  return {static_cast<float>(rate / (1 - std::pow(beta1, update))),
          static_cast<float>(1 / std::sqrt(1 - std::pow(beta2, update)))};
}

}  // namespace

SplatTrainer::SplatTrainer(std::span<const SplatView> views, const SplatTrainConfig& config,
                           SplatTrainState state)
    : config_(config),
      state_(std::move(state)),
      views_(views),
      kernels_(best_splat_kernels()),
      loss_({.ssim_share = config.ssim_share}) {
  state_.near_m.resize(views_.size(), 0);
  if (state_.extent_m > 0) return;
  state_.extent_m = extent_of(views_);
  // One view, or all from one place: their distance to the start stands in.
  const Pose& first = views_.front().camera_from_world;
  const double depth = near_depth_m(state_.values, first, state_.origin_in_world_m, 1);
  if (state_.extent_m < 1e-6 * depth) state_.extent_m = depth;
}

int SplatTrainer::halvings_now() const {
  const double share = static_cast<double>(state_.step) / config_.steps;
  return share < config_.quarter_until ? 2 : share < config_.half_until ? 1 : 0;
}

void SplatTrainer::make_small(int halvings) {
  if (halvings == halvings_) return;
  small_ = std::vector<SplatViewLevel>(halvings == 0 ? 0 : views_.size());
  tbb::parallel_for(std::size_t{0}, small_.size(),
                    [&](std::size_t v) { small_[v] = halved(views_[v].full, halvings); });
  halvings_ = halvings;
}

SplatCamera SplatTrainer::camera_of(std::size_t view, int halvings) {
  const SplatViewLevel& full = views_[view].full;
  const Pose& camera_from_world = views_[view].camera_from_world;
  double& near_m = state_.near_m[view];
  if (near_m == 0) {
    near_m = near_depth_m(state_.values, camera_from_world, state_.origin_in_world_m, config_.near);
  }
  SplatCamera camera = splat_camera(halvings > 0 ? small_[view].camera : full.camera,
                                    camera_from_world, state_.origin_in_world_m, near_m);
  // A small image is the mean over boxes of the large one: its low-pass, in its own pixels, and
  // the box's variance beyond a pixel of the large image.
  const double box = static_cast<double>(1 << (2 * halvings_of(full.camera, halvings)));
  camera.low_pass_px2 = static_cast<float>(config_.low_pass_px2 / box + (1 - 1 / box) / 12);
  return camera;
}

std::array<float, 3> SplatTrainer::background_now() const {
  if (!config_.any_background) return config_.background;
  Rng rng = Rng(config_.seed).fork("background").fork(static_cast<std::uint64_t>(state_.step));
  std::array<float, 3> color{};
  for (float& value : color) value = static_cast<float>(uniform(rng));
  return color;
}

const ColorPlanes& SplatTrainer::photograph_before(const SplatViewLevel& level,
                                                   const std::array<float, 3>& background) {
  const bool is_black =
      std::all_of(background.begin(), background.end(), [](float v) { return v == 0; });
  if (level.behind.empty() || is_black) return level.color;
  for (std::size_t c = 0; c < 3; ++c) {
    Image<float>& channel = photograph_.channel[c];
    const Image<float>& own = level.color.channel[c];
    if (channel.width() != own.width() || channel.height() != own.height())
      channel = Image<float>(own.width(), own.height());
    for (std::size_t i = 0; i < own.size(); ++i)
      channel.data()[i] = own.data()[i] + level.behind.data()[i] * background[c];
  }
  return photograph_;
}

SplatTrainer::Step SplatTrainer::step() {
  const Lap total(seconds_.total);
  const CpuLap total_cpu(seconds_.total_cpu);
  if (state_.step > 0) {
    const Lap lap(seconds_.grow);
    grow_if_due();
  }
  // Views in an order of their own each time round.
  const std::size_t round = static_cast<std::size_t>(state_.step) / views_.size();
  const std::size_t place = static_cast<std::size_t>(state_.step) % views_.size();
  if (place == 0 || order_.empty()) {
    order_.resize(views_.size());
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    Rng rng = Rng(config_.seed).fork("order").fork(round);
    for (std::size_t i = order_.size(); i > 1; --i) {
      std::swap(order_[i - 1], order_[uniform_index(rng, i)]);
    }
  }
  const std::size_t view = order_[place];
  const int halvings = halvings_now();
  make_small(halvings);
  const int every =
      config_.sh_degree_every > 0 ? config_.sh_degree_every : std::max(1, config_.steps / 30);
  const int degree = std::min(config_.sh_degree, state_.step / every);

  const std::array<float, 3> background = background_now();
  {
    const Lap lap(seconds_.draw);
    draw_splats(kernels_, state_.values, degree, camera_of(view, halvings), background,
                SplatDepths::none, frame_);
  }
  const LossAndGradient* loss = nullptr;
  {
    const Lap lap(seconds_.loss);
    const SplatViewLevel& photograph = halvings > 0 ? small_[view] : views_[view].full;
    loss = &loss_(frame_.color, photograph_before(photograph, background), photograph.weight);
  }
  {
    const Lap lap(seconds_.gradients);
    blend_gradients(kernels_, loss->gradient, background, frame_);
  }
  const double progress = static_cast<double>(state_.step) / config_.steps;
  {
    const Lap lap(seconds_.update);
    update(progress);
  }
  const Step done = {loss->value, frame_.lists.front_to_back.size()};
  ++state_.step;
  return done;
}

void SplatTrainer::update(double progress) {
  const SplatRates& rates = config_.rates;
  const bool with_rest = frame_.sh_degree > 0 && state_.step % config_.rest_every == 0;
  state_.rest_updates += with_rest ? 1 : 0;
  UpdateTask task;
  task.planes = &state_.values;
  task.camera = frame_.camera;
  task.sh_degree = frame_.sh_degree;
  task.projected = frame_.projected.data();
  task.partials = frame_.partials.data();
  task.pair_first = frame_.lists.pair_first.data();
  task.pair_count = frame_.lists.pair_count.data();
  task.first_moment = &state_.first_moment;
  task.second_moment = &state_.second_moment;
  const double centre =
      state_.extent_m * exponential_between(rates.centre_first, rates.centre_last, progress);
  const double decay = exponential_between(1, rates.decay, progress);
  const auto rate = [&](double value, int updates) {
    return adam_rate(value, updates, task.beta1, task.beta2);
  };
  task.centre = rate(centre, state_.step + 1);
  task.log_scale = rate(decay * rates.log_scale, state_.step + 1);
  task.rotation = rate(decay * rates.rotation, state_.step + 1);
  task.opacity = rate(decay * rates.opacity, state_.step + 1);
  task.dc = rate(decay * rates.dc, state_.step + 1);
  task.rest = rate(decay * rates.rest, std::max(1, state_.rest_updates));
  task.with_rest = with_rest;
  // Where a view shows nothing, nothing is pulled or moved: else Gaussians that no view shows, as
  // before wrong poses, would fade or stray before cameras, and be taken for a start.
  const bool moves = config_.growth == SplatGrowth::mcmc && !frame_.lists.front_to_back.empty();
  if (moves) {
    const double count = std::max(1, state_.values.size());
    task.opacity_pull = static_cast<float>(config_.opacity_pull / count);
    task.scale_pull = static_cast<float>(config_.scale_pull / (3 * count * state_.extent_m));
  }
  task.by_tile = config_.growth == SplatGrowth::budgeted;
  task.gradient_sum = state_.gradient_sum.data();
  task.gradient_count = state_.gradient_count.data();
  tbb::parallel_for(Range(0, state_.values.padded() / 8, 64), [&](const Range& range) {
    kernels_.update(task, 8 * range.begin(), 8 * range.end());
  });
  if (moves && config_.noise > 0) {
    // Covariances in extents, so that a unit of length changes nothing.
    const double centre_share = centre / state_.extent_m;
    add_centre_noise(state_.values, config_.noise * centre_share / state_.extent_m,
                     Rng(config_.seed).fork("noise").fork(static_cast<std::uint64_t>(state_.step)));
  }
}

void SplatTrainer::grow_if_due() {
  const double from = config_.grow_from * config_.steps, until = config_.grow_until * config_.steps;
  // The reference grows and resets strictly between the two; a budget is reached at the last.
  const bool within = config_.growth == SplatGrowth::adaptive
                          ? state_.step > from && state_.step < until
                          : state_.step >= from && state_.step <= until;
  if (within && config_.growth != SplatGrowth::fixed && state_.step % config_.grow_every == 0) {
    const double left = until - state_.step;
    const double progress =
        left < config_.grow_every ? 1 : (state_.step - from) / std::max(1.0, until - from);
    grow_splats(state_, config_, state_.extent_m, progress,
                Rng(config_.seed).fork("growth").fork(static_cast<std::uint64_t>(state_.step)));
    std::fill(state_.near_m.begin(), state_.near_m.end(), 0.0);
  }
  const int reset = static_cast<int>(config_.reset_every * config_.steps);
  if (reset > 0 && state_.step % reset == 0 && state_.step < until) reset_opacity(state_);
}

std::vector<int> SplatTrainer::views_seen() {
  std::vector<int> seen(static_cast<std::size_t>(state_.values.size()), 0);
  ColorPlanes ones;
  for (std::size_t view = 0; view < views_.size(); ++view) {
    draw_splats(kernels_, state_.values, config_.sh_degree, camera_of(view, 0), config_.background,
                SplatDepths::none, frame_);
    for (Image<float>& channel : ones.channel) {
      channel = Image<float>(frame_.camera.width_px, frame_.camera.height_px, 1.0F);
    }
    blend_gradients(kernels_, ones, config_.background, frame_);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const SplatPartial* partial = frame_.partials.data() + frame_.lists.pair_first[i];
      float weight = 0;
      for (std::uint32_t p = 0; p < frame_.lists.pair_count[i]; ++p) weight += partial[p].weight;
      seen[i] += weight > 0 ? 1 : 0;
    }
  }
  return seen;
}

}  // namespace cousin
