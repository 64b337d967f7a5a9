#pragma once

#include <array>
#include <string_view>

#include "sim/config/fields.h"
#include "sim/types/seams.h"

namespace cousin {

/// What of a seed is measured, in this order; see trait_table.h.
inline constexpr auto kSeedTraits =
    std::to_array<std::string_view>({"length", "width", "height", "area", "volume"});

/// The paper's measures of a cluster: PCA box, alpha shape. It does not say how large alpha is. A
/// cloud of a surface is empty inside, and the tetrahedra that span it have spheres as large as
/// what is measured: with a smaller alpha only a thin shell has a volume, and what no view sees
/// (undersides) stays open. So alpha goes with the cluster's size: as long as it.
struct PaperTraitConfig {
  double alpha_of_length = 1;  ///< alpha over the box's length
};
Fields fields(PaperTraitConfig& config);
void validate(const PaperTraitConfig& config);
/// Length, width, height of the PCA box, area and volume of the alpha shape of each surface's
/// points; no sigma. The centroid is that of the points. Fewer than four points, points in one
/// plane, or an alpha shape without a tetrahedron: not_solved, with the reason.
Traits traits_as_paper(const Surfaces& surfaces, const PaperTraitConfig& config = {});

/// What a closed, smooth surface cannot say about itself: creases, ridges, brushes, the shape of
/// what no view sees, and outlines that are off by the same share of a pixel in every view.
/// Standard deviations, added in quadrature to those of the fit. The defaults are the scatter that
/// rendered seeds of three species showed beyond it at 1920 x 1080, where a pixel spans 0.33 mm
/// (seeds 1 and 7; scored on others).
struct MeshTraitConfig {
  double length_sigma_px = 0.105;
  double width_sigma_px = 0.15;  ///< the box turns about the length with ease
  double height_sigma_px = 0.18;
  double area_sigma = 0.045;    ///< relative
  double volume_sigma = 0.045;  ///< relative
};
Fields fields(MeshTraitConfig& config);
void validate(const MeshTraitConfig& config);
/// Ours: minimum-volume box, area and volume of the closed mesh; sigma is the standard deviation
/// over the surface's samples (NaN with fewer than two) together with the configured ones. Where
/// other boxes are nearly as small, as for a nearly square outline, sizes are the mean over which
/// of them is the object's own least, and their sigma tells so. Surfaces without a mesh, or whose
/// status is not ok: not_solved, with the reason; the centroid is then that of the points.
/// @param pixel_m  what a pixel of the views spans at the specimens; NaN: unknown, and then so are
///                 the sigmas of the three lengths
Traits traits_of_meshes(const Surfaces& surfaces, double pixel_m,
                        const MeshTraitConfig& config = {});

}  // namespace cousin
