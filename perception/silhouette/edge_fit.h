#pragma once

#include <optional>

#include "perception/silhouette/contour_line.h"
#include "perception/silhouette/object_window.h"

namespace cousin {

/// Where the outline is, about a guess.
struct EdgeFit {
  double offset_px = 0;  ///< from the guess outwards along its normal
  double sigma_px = 0;   ///< from the pixels' noise and the model's misfit
  double contrast =
      0;  ///< linear colour, root mean square over the channels, between both sides of the edge
};

struct EdgeFitOptions {
  double blur_sigma_px = 0.5;
  double search_px = 0;  ///< offsets tried before the fit; 0 = none
};

/// Fits one piece of outline to the pixels near `guess` (box coordinates): within 1.5 px along it
/// and 3.5 px across.
///
///   color = a (s0 + s1 v) + (1 - a) (w0 + w1 v) board + (1 - a) e paper-share * object,   v =
///   distance outwards a = Phi(-(v - offset + k t^2 / 2 + k sigma^2 / 2) / sigma),   sigma^2 =
///   blur^2 + 1/12, k curvature, t along
///
/// s0, s1: the object's colour and its change; w0, w1: how much of its light the board gets, and
/// its change (shadow); e: light thrown from the object onto the board. They are linear, with weak
/// priors; offset and curvature (about the guess's) are found by Gauss-Newton together with them.
/// Beyond the plate the background is one unknown colour. The half-level line of a curved, blurred
/// edge lies k sigma^2 / 2 inside the edge; that is in `a`. Nothing where the background is partly
/// plate and partly not, or a sample lies outside the window. Pixels of another object are not left
/// out: whoever uses the fit looks how near they are (outlines.cpp does).
std::optional<EdgeFit> fit_edge(const ObjectWindow& window, const ContourVertex& guess,
                                const EdgeFitOptions& options);

}  // namespace cousin
