#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/config/fields.h"
#include "sim/types/rng.h"

namespace cousin {

/// How far a scene is from its reference along each axis: 0 = a twin, 1 = as far as the scene's
/// table goes.
struct CousinDistance {
  double shape = 0, growth = 0, texture = 0, light = 0, sensor = 0;
};
Fields fields(CousinDistance& distance);
bool is_twin(const CousinDistance& distance);
const std::vector<std::string>& cousin_axes();  ///< shape, growth, texture, light, sensor

/// One key that an axis moves. At distance d the value goes, with s = either sign times a uniform
/// number in [0.5, 1],
///   factor  to value * range^(d s)
///   step    to value + d s range
///   to      to value + d (range - value), without a draw.
struct CousinMove {
  enum class By { factor, step, to };
  std::string axis;
  std::string key;  ///< of the configuration; "rig.**.name" = every key below rig that ends so
  By by = By::factor;
  double range = 1;
};

/// A scene's table: [AXIS] "KEY" = { factor = 1.3 }, or step or to.
/// @throws std::runtime_error naming table and key of what is wrong.
std::vector<CousinMove> read_cousin_moves(std::string_view toml, std::string_view name);

/// One line a move: "shape    vary.elongation    times 1.35 or its inverse".
std::string describe(const std::vector<CousinMove>& moves);

/// What a draw made of a configuration.
struct CousinChange {
  std::string axis, key, before, after;  ///< values as TOML
};

/// Moves the values that `config` points to. Each key's draw has its own stream, which does not
/// depend on the distance: growing d moves along one line. Axes at 0 change nothing.
/// @throws std::invalid_argument naming axis, distance and key where a key does not exist in this
/// configuration, could not be moved within its limits, or an axis above 0 has nothing to move.
std::vector<CousinChange> move_to_cousin(const Fields& config, const std::vector<CousinMove>& moves,
                                         const CousinDistance& distance, const Rng& rng);

/// The changes as comments of a TOML file: "# cousin.shape: vary.size = 1.0 -> 1.2".
std::string comments_of(const std::vector<CousinChange>& changes);

/// Both ends of every draw at this distance. @throws as move_to_cousin.
void check_cousin(const Fields& config, const std::vector<CousinMove>& moves,
                  const CousinDistance& distance);

}  // namespace cousin
