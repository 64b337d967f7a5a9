#pragma once

#include "sim/config/fields.h"
#include "sim/types/seams.h"

namespace cousin {

/// The paper's measures of a cluster: PCA box, alpha shape.
struct PaperTraitConfig {
  double alpha_m = 0.0015;
};
Fields fields(PaperTraitConfig& config);
void validate(const PaperTraitConfig& config);
/// Length, width, height of the PCA box, area and volume of the alpha shape of each surface's
/// points; no sigma. The centroid is that of the points. Fewer than four points, points in one
/// plane, or an alpha shape without a tetrahedron: not_solved, with the reason.
Traits traits_as_paper(const Surfaces& surfaces, const PaperTraitConfig& config = {});

/// Ours: minimum-volume box, area and volume of the closed mesh; sigma is the standard deviation
/// over the surface's samples (NaN with fewer than two). Surfaces without a mesh, or whose status
/// is not ok: not_solved, with the reason.
Traits traits_of_meshes(const Surfaces& surfaces);

}  // namespace cousin
