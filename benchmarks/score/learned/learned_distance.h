#pragma once

#include <filesystem>
#include <memory>

#include "benchmarks/score/image_fidelity.h"

namespace cousin {

/// How far apart two images are to a network, such as LPIPS [Zhang et al., CVPR 2018]. The network
/// is the user's own TorchScript file: `forward(image, photograph)` takes two float tensors of
/// 1 x 3 x height x width, red, green, blue, sRGB-encoded, from -1 to 1 (as the LPIPS authors'
/// package takes them by default), and returns one number, 0 for equal images.
class LearnedDistance {
 public:
  virtual ~LearnedDistance() = default;
  /// Whole images; values beyond 0..1 are clamped. On one thread, so the same number each time.
  /// @throws std::invalid_argument if sizes differ; std::runtime_error naming the file if the
  /// network fails or returns anything but one finite number.
  virtual double between(const FidelityPlanes& image, const FidelityPlanes& photograph) const = 0;
};

/// The largest file that is read as a network.
inline constexpr std::uintmax_t kMostNetworkBytes = std::uintmax_t{1} << 31;

/// Opens the module that links libtorch, which lies beside the program, and reads a network.
/// @throws std::runtime_error naming the file and what is wrong with it, or that this build has no
/// libtorch.
std::shared_ptr<const LearnedDistance> load_learned_distance(const std::filesystem::path& network);

/// The same with the module's own path.
std::shared_ptr<const LearnedDistance> load_learned_distance(const std::filesystem::path& network,
                                                             const std::filesystem::path& module);

/// What the module exports: a network that the caller deletes.
using LoadLearnedDistance = LearnedDistance*(const char* network);
inline constexpr const char* kLoadLearnedDistance = "cousin_load_learned_distance";

}  // namespace cousin
