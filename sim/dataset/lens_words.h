#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace cousin {

/// Private to sim/dataset: what calibration files of other programs call a lens's distortion.
/// `none`: a pinhole camera. `plumb_bob`: k1 k2 p1 p2 [k3]; `rational`: with k4 k5 k6;
/// `thin_prism`: with s1 s2 s3 s4; `fisheye`: four coefficients of Kannala and Brandt; `not_read`:
/// a polynomial of librealsense that no model of ours is, unless all of it is zero.
enum class LensKind { unsaid, none, plumb_bob, rational, thin_prism, fisheye, not_read };

/// What a word means. Case does not matter, nor do "_", "-" and blanks between its parts, nor
/// librealsense's "distortion." before it. An empty word is `unsaid`; an unknown one has no kind.
std::optional<LensKind> lens_kind_of(std::string_view word);

/// The words that are known, for messages.
std::string lens_words();

}  // namespace cousin
