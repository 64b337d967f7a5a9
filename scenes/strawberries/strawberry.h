#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "scenes/fruit/fruit_model.h"
#include "scenes/strawberries/variety.h"
#include "sim/types/rng.h"

namespace cousin {

/// What of a strawberry is asked for, beside its variety.
struct StrawberryConfig {
  std::string variety = "benihoppe";
  std::optional<StrawberryVariety> numbers;  ///< in place of the variety's own
  double red_share = 1;  ///< of the flesh's surface; reached to 0.002 or to what the front allows
  double growth = 1;     ///< size over what is drawn for a ripe fruit, 0.1..1.5
  Eigen::Vector3d to_sun = {1, 0, 0.5};  ///< in the fruit's frame: the side that ripens first
  FruitFamily family = FruitFamily::botanical;
  double elongation = 1;  ///< times the shape index drawn, 0.4..2.5
  int grid = 0;           ///< cells along an edge of its mesh; 0: as the variety says
};
/// @throws std::invalid_argument naming key, value and limit.
void validate(const StrawberryConfig& config);

/// A strawberry with achenes, calyx and a short stalk; see FruitModel. Keypoints: tip,
/// calyx_centre, cut_point (of the stalk). Mass is drawn first (cut normal, as the variety says)
/// and the volume follows from it and the density drawn.
/// Deterministic in (config, rng).
FruitModel make_strawberry(const StrawberryConfig& config, Rng rng);

// The steps of make_strawberry.

/// The flesh before colour: closed, centred, dimpled.
struct StrawberryFlesh {
  Mesh mesh;
  std::vector<double> along;  ///< of each vertex: 0 at the tip, 1 at the calyx, by height
  std::vector<double> azimuth_rad;
  std::vector<Eigen::Vector3d> normals;
  std::vector<std::uint32_t> achenes;  ///< vertices on which they sit, in the order of the spiral
};
StrawberryFlesh make_strawberry_flesh(const StrawberryVariety& variety, FruitFamily family,
                                      double shape_index, double volume_m3, int grid, Rng rng);

/// Colours of the flesh's vertices whose red share is `red_share`: red grows from the tip and the
/// sunny side; what is not yet red goes from green to white as the share nears a third.
std::vector<Rgbf> color_strawberry(const StrawberryVariety& variety, const StrawberryFlesh& flesh,
                                   double red_share, const Eigen::Vector3d& to_sun, Rng rng);

/// Sepals and bracts as sheets that keep off the flesh, about the point where the stalk enters.
ObjectModel make_calyx(const StrawberryVariety& variety, const StrawberryFlesh& flesh,
                       const Eigen::Vector3d& base_m, double size, double red_share, Rng rng);

}  // namespace cousin
