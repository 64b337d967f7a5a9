#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "sim/render/path_scene.h"
#include "sim/render/path_skips.h"

namespace cousin {

/// Light in the flesh of a body: a random walk of isotropic turns from where it goes in, along a
/// direction drawn as the cosine, to where it meets the body's surface from inside; it leaves there
/// as from a diffuse surface. No other body is met on the way. Private to sim/render.
///
/// No light is lost or made but by absorption at the turns, whatever the body's shape. The share
/// that a turn keeps is the one of which a flat, deep body gives back its albedo, so that mean free
/// paths much shorter than the body look diffuse of that albedo; a thin body lets light through.

/// Share of light that a turn keeps where a deep flat body, lit evenly or by the cosine, gives back
/// `albedo` in [0, 1]: inverts A = 1 - 2 sqrt(1 - a) * integral of H(mu) mu, with H of isotropic
/// scattering [Chandrasekhar, "Radiative Transfer", 1960, ch. III and V], to 1e-5.
float kept_at_turn(float albedo);

/// Whether light of this material walks at this hit: not where mean free paths are below 32 ray
/// offsets, which look diffuse.
bool walks_below(const PathHit& hit);

/// Where light came out.
struct WalkExit {
  PathHit hit;  ///< from outside; its bsdf is of the base alone
  Sheet sheet;
  std::uint64_t rays = 0;  ///< traced on the way
};
/// Walks from a hit on the outside of a closed body. A walk of more than 2^14 turns, or that left
/// through a gap of rounding, comes out where it went in. `hit.bsdf.came_out` is zero if all was
/// absorbed.
/// @param entry  `part` of its bsdf is set by the caller.  @param key  of the walk's numbers.
WalkExit walk_below(const PathTracer::Impl& scene, const PathHit& entry, const Sheet& own,
                    float time, std::uint64_t key);

}  // namespace cousin
