#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace cousin {

/// One anisotropic Gaussian with view-dependent colour, as 3DGS defines it [Kerbl et al., ACM TOG
/// 42(4), 2023]: covariance R diag(exp(2 log_scale)) R', opacity sigmoid(opacity_logit), colour
/// max(0, 0.5 + sum of sh * Y(direction from the camera to the centre)).
struct Splat {
  Eigen::Vector3f centre_m = Eigen::Vector3f::Zero();   ///< from SplatModel::origin_in_world_m
  Eigen::Vector3f log_scale = Eigen::Vector3f::Zero();  ///< ln of metres, along the own axes
  Eigen::Vector4f rotation_wxyz = {1, 0, 0, 0};         ///< of any norm; axes -> world
  float opacity_logit = 0;
  std::array<float, 3> sh_dc{};     ///< red, green, blue
  std::array<float, 45> sh_rest{};  ///< 15 of red, 15 of green, 15 of blue, as the reference's PLY
};
bool is_finite(const Splat& splat);  ///< every value of it

/// Gaussians of one scene. Colours are sRGB-encoded, 0..1, as the images they were trained on.
struct SplatModel {
  int sh_degree = 3;  ///< 0..3; coefficients beyond it are zero
  /// Added to the variances of each Gaussian in an image, > 0: what it was trained with. 0.3 is the
  /// reference's, of files from elsewhere too.
  double low_pass_px2 = 0.3;
  Eigen::Vector3d origin_in_world_m = Eigen::Vector3d::Zero();  ///< added to every centre
  std::vector<Splat> splats;
  /// Of a training that gave no model: why. No file has it.
  std::string why_none;
  std::vector<int> views_seen;  ///< training views in which each blends; empty = not known
};

}  // namespace cousin
