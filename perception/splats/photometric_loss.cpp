#include "perception/splats/photometric_loss.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "perception/splats/photometric_band.h"

namespace cousin {
namespace {

constexpr int kChannels = 3;
constexpr int kLeastRows = 16;  ///< of a band: each computes twenty more beside its own

/// Half of the window along one axis, from the middle outwards; the whole sums to one.
std::array<float, 6> window_taps() {
  std::array<double, 6> taps{};
  double sum = 0;
  for (int k = 0; k < 6; ++k) {
    taps[static_cast<std::size_t>(k)] = std::exp(-k * k / (2 * 1.5 * 1.5));
    sum += (k == 0 ? 1 : 2) * taps[static_cast<std::size_t>(k)];
  }
  std::array<float, 6> result{};
  for (std::size_t k = 0; k < 6; ++k) result[k] = static_cast<float>(taps[k] / sum);
  return result;
}

void require_size(const Image<float>& image, const Image<float>& like, const char* what) {
  if (image.width() == like.width() && image.height() == like.height()) return;
  throw std::invalid_argument(std::string("photometric_loss: ") + what + " is " +
                              std::to_string(image.width()) + " x " +
                              std::to_string(image.height()) + ", the rendered image's red is " +
                              std::to_string(like.width()) + " x " + std::to_string(like.height()));
}

/// Sum of the weights, row by row.
double total_weight(const Image<float>& weight) {
  double total = 0;
  for (int y = 0; y < weight.height(); ++y) {
    double row = 0;
    bool valid = true;
    for (const float w : weight.row(y)) {
      valid = valid && w >= 0 && w <= std::numeric_limits<float>::max();
      row += static_cast<double>(w);
    }
    if (!valid) {
      throw std::invalid_argument("photometric_loss: a weight of row " + std::to_string(y) +
                                  " is negative or not finite");
    }
    total += row;
  }
  return total;
}

}  // namespace

void validate(const PhotometricConfig& config) {
  if (config.ssim_share >= 0 && config.ssim_share <= 1) return;
  throw std::invalid_argument(
      "photometric_loss: ssim_share = " + std::to_string(config.ssim_share) + " is not in 0..1");
}

PhotometricLoss::PhotometricLoss(const PhotometricConfig& config) : config_(config) {
  validate(config);
}

const LossAndGradient& PhotometricLoss::operator()(const ColorPlanes& rendered,
                                                   const ColorPlanes& photograph,
                                                   const Image<float>& weight) {
  const Image<float>& red = rendered.channel[0];
  if (red.empty()) throw std::invalid_argument("photometric_loss: the rendered image is empty");
  for (const Image<float>& channel : rendered.channel)
    require_size(channel, red, "a channel of it");
  for (const Image<float>& channel : photograph.channel)
    require_size(channel, red, "the photograph");
  if (!weight.empty()) require_size(weight, red, "the weight");
  const int width = red.width();
  const int height = red.height();

  for (Image<float>& gradient : result_.gradient.channel) {
    if (gradient.width() != width || gradient.height() != height)
      gradient = Image<float>(width, height);
  }
  const double pixels = weight.empty() ? static_cast<double>(red.size()) : total_weight(weight);
  if (pixels == 0) {
    for (Image<float>& gradient : result_.gradient.channel)
      std::fill(gradient.begin(), gradient.end(), 0.0f);
    result_.value = result_.l1 = result_.ssim = 0;
    return result_;
  }

  // Tasks: enough for all threads to end together. A row's values depend on no band.
  const int threads = std::max(1, tbb::this_task_arena::max_concurrency());
  const int bands = std::clamp(threads == 1 ? 1 : (2 * threads + 2) / kChannels, 1,
                               std::max(1, height / kLeastRows));
  const auto rows = static_cast<std::size_t>(height);
  const std::size_t floats = photometric::scratch_floats(width);
  scratch_.resize(std::max(scratch_.size(), floats * static_cast<std::size_t>(kChannels * bands)));
  row_sums_.resize(2 * kChannels * rows);

  photometric::Band common;
  common.weight = weight.empty() ? nullptr : weight.data();
  common.width = width;
  common.height = height;
  std::ranges::copy(window_taps(), common.taps);
  common.l1_scale = static_cast<float>((1 - config_.ssim_share) / (kChannels * pixels));
  common.ssim_scale = static_cast<float>(-config_.ssim_share / (kChannels * pixels));
  photometric::BandKernel kernel = photometric::loss_band_avx2();
  if (!kernel || config_.kernel == PhotometricConfig::Kernel::portable)
    kernel = photometric::loss_band_portable;

  tbb::parallel_for(0, kChannels * bands, [&](int task) {
    const auto c = static_cast<std::size_t>(task / bands);
    const int part = task % bands;
    photometric::Band band = common;
    band.rendered = rendered.channel[c].data();
    band.photograph = photograph.channel[c].data();
    band.gradient = result_.gradient.channel[c].data();
    band.row_l1 = row_sums_.data() + 2 * c * rows;
    band.row_ssim = band.row_l1 + rows;
    band.scratch = scratch_.data() + floats * static_cast<std::size_t>(task);
    band.begin = static_cast<int>(static_cast<long long>(height) * part / bands);
    band.end = static_cast<int>(static_cast<long long>(height) * (part + 1) / bands);
    kernel(band);
  });

  double l1 = 0;
  double ssim = 0;
  for (std::size_t c = 0; c < kChannels; ++c) {
    for (std::size_t y = 0; y < rows; ++y) {
      l1 += row_sums_[2 * c * rows + y];
      ssim += row_sums_[(2 * c + 1) * rows + y];
    }
  }
  result_.l1 = l1 / (kChannels * pixels);
  result_.ssim = ssim / (kChannels * pixels);
  result_.value = (1 - config_.ssim_share) * result_.l1 + config_.ssim_share * (1 - result_.ssim);
  return result_;
}

}  // namespace cousin
