#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/strawberries/strawberry_bed.h"
#include "scenes/strawberries/truss.h"

namespace cousin {

/// What of a stretch of bed bears fruit: all that physics must know.
struct StandConfig {
  std::string variety = "drawn";  ///< or drawn as the paper's 70, 60 and 50 plants
  int fruits_min = 1, fruits_max = 10;
  double fruits_share = 0.72;  ///< mean of the way from the fewest to the most
  /// Ripeness of a truss's first fruit, see TrussConfig: fitted to the shares of the paper's 8627
  /// fruits, low 55, medium 28, high 16 % [Strawberries 2.1].
  double ripeness_low = 0.18, ripeness_high = 1.32;
  double heavier = 1;                ///< times the fruits' masses: what stalks can hold
  std::string family = "botanical";  ///< of the fruits' shapes, or harmonics
  double elongation = 1;             ///< times their length over diameter
  int fruit_grid = 36;               ///< cells along an edge of a fruit's mesh
  TrussShape truss = truss_shape();  ///< and the bed's size
  std::vector<StrawberryVariety> varieties = all_varieties();  ///< of strawberry_varieties()
};
/// Those of trusses are truss.*, of varieties varieties.NAME.*.
Fields fields(StandConfig& config);
/// @throws std::invalid_argument naming key, value and limit.
void validate(const StandConfig& config);

/// Trusses that have been drawn, and the crown of the near row that each grows from.
struct Stand {
  std::string variety;
  std::vector<TrussConfig> trusses;
  std::vector<int> crowns;
  double ripeness_low = 0, ripeness_high = 1;  ///< of another day's first fruits, too
};
/// Numbers of a variety in a stand. @throws as strawberry_variety.
const StrawberryVariety& numbers_of(const StandConfig& config, const std::string& variety);

/// Deterministic in (config, bed, rng), whatever colours and lights are.
Stand draw_stand(const StandConfig& config, const StrawberryBedConfig& bed, Rng rng);
/// All trusses of a stand without weight. @param ripening  colours of another day
std::vector<Truss> grow_trusses(const Stand& stand, const Rng& rng,
                                const std::optional<Ripening>& ripening = {});

/// The ripening of one truss: its first fruit's is drawn.
std::optional<Ripening> ripening_of(const Stand& stand, const std::optional<Ripening>& all,
                                    std::size_t truss);

/// A stand at rest: the try that came to rest, and how.
struct StandRest {
  int attempt = 0;
  SagResult sag;
};
/// Tries of a stand until one comes to rest without overlaps: a truss in some thousand is caught.
/// @throws std::runtime_error naming the status, stem and limit if none does: so for fruits that
/// are too heavy for their stalks.
StandRest settle_stand(const StandConfig& config, const StrawberryBedConfig& bed, const Rng& rng);
/// Whether this build has the physics that settling needs.
bool can_settle();
/// The stream of one try, for draw_stand and grow_trusses; and of one truss of it.
Rng attempt_rng(const Rng& rng, int attempt);
Rng truss_rng(const Rng& rng, std::size_t truss);

/// A rest as text that reads back bit by bit, and everything that decides it: two rests of the same
/// description and stream are the same.
std::string to_text(const StandRest& rest);
std::string description(const StandConfig& config, const StrawberryBedConfig& bed);
/// @param name  of the file, for errors
/// @throws std::runtime_error naming the file, what in it is wrong and the limit: sizes that are
/// not those of the stand's stems, numbers that are not finite, poses that are none, places farther
/// than 10 m.
StandRest rest_from_text(std::string_view text, const std::string& name, const StandConfig& config,
                         const StrawberryBedConfig& bed, const Rng& rng);

}  // namespace cousin
