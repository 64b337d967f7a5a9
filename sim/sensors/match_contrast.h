#pragma once

#include <vector>

namespace cousin {

struct ActiveStereoConfig;
struct PatternLight;

/// How much better a census window fits its own counterpart than any other window: log2 of the bits
/// that differ from an unrelated window over those that differ from the same place in the other
/// image, both expected from the light.
///
/// Two pixels of a window that differ by D electrons, with noise of variance v in their difference,
/// set one of their bits with probability p = Phi((D - margin) / sqrt(v)) and the other with
/// Phi((-D - margin) / sqrt(v)). Over pairs of a pattern of dots (Gaussian profiles, the brightness
/// of a random place) the bits differ as mean(p (1 - p)) between the two images, which see the same
/// D, and as mean(p) (1 - mean(p)) between unrelated windows. The noise is that of photons, of
/// reading and rounding, and speckle, which the two imagers do not share.
/// Windows see dots wider than they are by `spread`, as the two images sample them at other places:
/// a factor on the area of a dot, fitted. Without a projector D is normal, of the texture's
/// contrast.
class MatchContrast {
 public:
  /// A table for one image's margin and read noise. @param dots  share of the dots' own photon
  /// noise that counts
  MatchContrast(const ActiveStereoConfig& config, const PatternLight& light, double dots,
                double spread);
  /// 0 = windows are alike everywhere, or there is no signal.
  float operator()(float signal_e, float ambient_e) const;

 private:
  float first_signal_ = 0, first_noise_ = 0;  ///< log2 of electrons and of their squares
  float still_e2_ = 0;
  std::vector<float> table_;
};

}  // namespace cousin
