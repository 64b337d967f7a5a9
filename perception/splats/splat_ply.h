#pragma once

#include <cstddef>
#include <filesystem>

#include "perception/splats/splat_model.h"

namespace cousin {

struct SplatPlyConfig {
  enum class Invalid {
    drop,   ///< rows that are no Gaussian are left out and counted
    refuse  ///< the first of them is an error
  };
  std::size_t most_splats = 10'000'000;  ///< a file with more is refused
  Invalid invalid = Invalid::drop;
};

/// What a file held. Rows that are no Gaussian: a value is NaN or infinite as a float, or the
/// rotation's norm is below 1e-12, so that it turns nothing.
struct SplatFile {
  SplatModel model;
  std::size_t not_finite = 0;      ///< rows left out for a value
  std::size_t zero_rotations = 0;  ///< rows left out for their rotation
};

/// Reads the reference's PLY layout [Kerbl et al. 2023]: x y z, f_dc_0..2, f_rest_*, opacity,
/// scale_0..2, rot_0..3 (wxyz) of the element "vertex", with values as SplatModel has them.
/// Properties may come in any order, of any scalar type (rounded to float), as text or binary;
/// others are passed over, but for those of variants that mean something else, which are refused
/// by name: 2D and 4D Gaussians, SuperSplat's compression, Mip-Splatting's filter, Beta kernels.
/// 0, 9, 24 or 45 of f_rest are degree 0..3. A line
/// `comment origin_m X Y Z` gives the model's origin in the world; none is zero. A line `comment
/// low_pass_px2 X` (1e-6..100) gives what its images are drawn with; none is the reference's 0.3.
/// The file's length unit is taken to be the metre. `views_seen` is empty.
/// @throws std::runtime_error naming file, line, byte or property, value and limit.
SplatFile read_splat_ply(const std::filesystem::path& file, const SplatPlyConfig& config = {});

/// Writes the reference's layout and order (normals are zero), binary little-endian, with the
/// origin and the low pass as comments of 17 digits; written beside, then renamed. Reading gives
/// the same model, bit by bit, but for `views_seen`, which the layout has no place for.
/// @throws std::invalid_argument if `sh_degree` is not 0..3, the low pass is not in its limits or
/// reading would leave a splat out;
/// std::runtime_error if the file cannot be written.
void write_splat_ply(const std::filesystem::path& file, const SplatModel& model);

}  // namespace cousin
