#include "sim/types/seams.h"

#include <array>

namespace cousin {

std::string_view to_string(BoardStatus status) {
  constexpr std::array<std::string_view, 5> kNames = {"ok", "not_seen", "too_few_corners",
                                                      "ambiguous", "no_image"};
  return kNames.at(static_cast<std::size_t>(status));
}

std::string_view to_string(PoseStatus status) {
  constexpr std::array<std::string_view, 4> kNames = {"ok", "no_board", "degenerate",
                                                      "not_converged"};
  return kNames.at(static_cast<std::size_t>(status));
}

std::string_view to_string(SurfaceStatus status) {
  constexpr std::array<std::string_view, 6> kNames = {
      "ok", "too_few_views", "empty", "not_converged", "touching", "not_watertight"};
  return kNames.at(static_cast<std::size_t>(status));
}

std::string_view to_string(FitStatus status) {
  constexpr std::array<std::string_view, 4> kNames = {"ok", "too_few_points", "degenerate",
                                                      "not_converged"};
  return kNames.at(static_cast<std::size_t>(status));
}

std::string_view to_string(TraitStatus status) {
  return status == TraitStatus::ok ? "ok" : "not_solved";
}

}  // namespace cousin
