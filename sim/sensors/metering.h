#pragma once

#include "sim/sensors/camera_config.h"
#include "sim/sensors/phone.h"
#include "sim/truth/scene.h"
#include "sim/truth/truth_images.h"
#include "sim/types/image.h"

namespace cousin {

/// A disc of an image that automatic exposure is for, as when a photographer taps on a fruit.
struct MeteredSpot {
  double x_px = 0, y_px = 0;
  double radius_px = 0;  ///< 0: none; exposed for the highlights of the whole image
};

/// What lies within `metered_m` of the view's focus; none where the lens does not see it.
MeteredSpot metered_spot(const View& seen, const TrueView& view, double metered_m);

/// Electrons at unit radiance that bring the mean of the spot's brightest channels to a quarter of
/// full well, a mid grey, from half to eight times what the whole image's highlights ask for.
/// @param highlights_e  electrons at unit radiance by these; given back for no spot
double spot_exposure_electrons(const Image<Rgbf>& radiance, const MeteredSpot& spot,
                               double highlights_e, double full_well_e);

/// The configuration with its exposure for the spot, where it is automatic.
CameraSensorConfig metered(CameraSensorConfig config, const Image<Rgbf>& radiance,
                           const MeteredSpot& spot);
PhoneConfig metered(PhoneConfig config, const Image<Rgbf>& radiance, const MeteredSpot& spot);

}  // namespace cousin
