#pragma once

#include "perception/splats/splat_render.h"

namespace cousin {

/// Parameters of Gaussians in double, row i of Gaussian i, columns in the order of `SplatPlane`:
/// centre 3, log_scale 3, rotation 4, opacity 1, dc 3, rest 45.
using SplatParameters = Eigen::Matrix<double, Eigen::Dynamic, 59, Eigen::RowMajor>;
SplatParameters splat_parameters(const std::vector<Splat>& splats);

/// A view to render, with the near depth as a distance.
struct ReferenceView {
  Camera camera;  ///< pinhole
  Pose camera_from_origin;
  double near_m = 1e-9;
  std::array<double, 3> background{};
  int sh_degree = 3;
  double low_pass_px2 = 0.3;  ///< as in SplatModel
};

/// Red, green, blue of each pixel (row y * width + x), and the transmittance left there.
struct ReferenceImage {
  Eigen::Matrix<double, Eigen::Dynamic, 3> color;
  Eigen::VectorXd transmittance;
};

/// The rendering equations written plainly in double, every Gaussian against every pixel: what the
/// kernels are tested against. Where 1/255, .99 or 1e-4 decide, it decides as they do, so near
/// those the two may differ by one decision.
ReferenceImage render_reference(const SplatParameters& parameters, const ReferenceView& view);

/// d loss / d parameters from d loss / d colour (row y * width + x).
SplatParameters reference_gradients(const SplatParameters& parameters, const ReferenceView& view,
                                    const Eigen::Matrix<double, Eigen::Dynamic, 3>& color_gradient);

}  // namespace cousin
