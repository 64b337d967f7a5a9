// The one file that links libtorch; a module, opened when a network is asked for.
#include <ATen/Parallel.h>
#include <torch/script.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <stdexcept>
#include <string>

#include "benchmarks/score/learned/learned_distance.h"

namespace cousin {
namespace {

std::string first_line(const std::exception& error) {
  const std::string text = error.what();
  return text.substr(0, text.find('\n'));
}

torch::Tensor tensor_of(const FidelityPlanes& planes) {
  const int width = planes[0].width(), height = planes[0].height();
  torch::Tensor tensor = torch::empty({1, 3, height, width});
  float* value = tensor.data_ptr<float>();
  for (const Image<float>& plane : planes) {
    value = std::transform(plane.begin(), plane.end(), value,
                           [](float v) { return 2 * std::clamp(v, 0.0F, 1.0F) - 1; });
  }
  return tensor;
}

class TorchDistance final : public LearnedDistance {
 public:
  explicit TorchDistance(const std::string& network) : name_(network) {
    at::set_num_threads(1);
    try {
      network_ = torch::jit::load(network);
      network_.eval();
    } catch (const std::exception& error) {
      throw std::runtime_error(name_ + ": is no TorchScript network: " + first_line(error));
    }
  }

  double between(const FidelityPlanes& image, const FidelityPlanes& photograph) const override {
    for (std::size_t c = 0; c < 3; ++c) {
      if (image[c].width() != photograph[0].width() ||
          image[c].height() != photograph[0].height() ||
          photograph[c].size() != photograph[0].size() || image[c].empty()) {
        throw std::invalid_argument("learned distance: " + std::to_string(image[c].width()) +
                                    " x " + std::to_string(image[c].height()) + " pixels beside " +
                                    std::to_string(photograph[0].width()) + " x " +
                                    std::to_string(photograph[0].height()));
      }
    }
    const c10::InferenceMode no_gradients;
    double value = 0;
    try {
      const std::lock_guard lock(mutex_);
      const torch::Tensor result =
          network_.forward({tensor_of(image), tensor_of(photograph)}).toTensor();
      if (result.numel() != 1) {
        throw std::runtime_error("returns " + std::to_string(result.numel()) +
                                 " numbers instead of one");
      }
      value = result.to(torch::kDouble).item<double>();
    } catch (const std::exception& error) {
      throw std::runtime_error(name_ + ": " + first_line(error));
    }
    if (!std::isfinite(value)) throw std::runtime_error(name_ + ": returns no finite number");
    return value;
  }

 private:
  std::string name_;
  mutable torch::jit::Module network_;  // `forward` is not const
  mutable std::mutex mutex_;
};

}  // namespace
}  // namespace cousin

extern "C" cousin::LearnedDistance* cousin_load_learned_distance(const char* network) {
  return new cousin::TorchDistance(network);
}
