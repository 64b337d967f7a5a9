#pragma once

#include <string>

#include "sim/truth/scene.h"
#include "sim/truth/truth_images.h"

namespace cousin {

/// The parts of validate(Scene), for those who hold a part alone. All throw std::invalid_argument
/// naming the object, the field, its value and the limit.

/// Colours in [0, 1]; leaf: albedo + transmittance <= 1; infrared shares <= 1 together; ior in
/// [1, 10], glass and water above 1; roughness in [0.05, 1]; mean free paths in [0, 1e6] m, of
/// coated surfaces alone; noise of positive scale and 1..12 octaves.
void validate(const Material& material);

/// Colours in [0, 1e20]; lamps of at least 1e-24 m2; suns with a direction, of (0, 1) rad, whose
/// disk shines with at most 1e30; a clear sky's sun above the horizon and turbidity in [1.7, 10];
/// projectors whose picture is as large as their lens's; pictures of 1..2^24 pixels.
/// @param where  begins the message: "scene \"leafy\", light 2".
void validate(const Light& light, const std::string& where);

/// A camera that validate(Camera) takes, finite poses of unit rotation, finite times, aperture and
/// exposure not negative, a focus in front of the lens.
void validate(const TrueView& view);

}  // namespace cousin
