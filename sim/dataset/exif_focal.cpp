#include "sim/dataset/exif_focal.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/dataset/for_each_frame.h"
#include "sim/dataset/text_fields.h"

namespace cousin {
namespace {

constexpr double kFilmDiagonal_mm = 43.266615305567875;  ///< of 36 x 24 mm
constexpr double kMostDifference = 0.15;                 ///< of two statements of one file
constexpr double kSameShare = 0.02;                      ///< of two photographs of one lens

/// Whether the picture has the shape that it was taken with, upright or turned.
bool is_whole(const ExifTags& tags, int width_px, int height_px) {
  if (!tags.width_px || !tags.height_px) return true;
  const auto shape = [](double a, double b) { return std::max(a, b) / std::min(a, b); };
  return std::abs(shape(*tags.width_px, *tags.height_px) / shape(width_px, height_px) - 1) < 0.01;
}

std::optional<ExifFocal> by_imager(const ExifTags& tags, int width_px, int height_px) {
  if (!tags.focal_length_mm || !tags.imager_pixels_per_mm) return std::nullopt;
  double scale = 1;
  if (tags.width_px) {
    const int then = tags.height_px ? std::max(*tags.width_px, *tags.height_px) : *tags.width_px;
    scale = static_cast<double>(std::max(width_px, height_px)) / then;
  }
  const double focal_px = *tags.focal_length_mm * *tags.imager_pixels_per_mm * scale;
  return ExifFocal{focal_px, 0.03 * focal_px,
                   short_text(*tags.focal_length_mm) + " mm before an imager of " +
                       short_text(*tags.imager_pixels_per_mm) + " pixels a millimetre"};
}

std::optional<ExifFocal> by_film(const ExifTags& tags, int width_px, int height_px) {
  if (!tags.focal_length_35mm_mm) return std::nullopt;
  const double focal_px =
      *tags.focal_length_35mm_mm / kFilmDiagonal_mm * std::hypot(width_px, height_px);
  return ExifFocal{focal_px, 0.05 * focal_px,
                   short_text(*tags.focal_length_35mm_mm) + " mm on 35 mm film"};
}

}  // namespace

std::optional<ExifFocal> exif_focal(const ExifTags& tags, int width_px, int height_px) {
  if (!is_whole(tags, width_px, height_px)) return std::nullopt;
  const std::optional<ExifFocal> imager = by_imager(tags, width_px, height_px);
  std::optional<ExifFocal> film = by_film(tags, width_px, height_px);
  std::optional<ExifFocal> result = imager ? imager : film;
  if (imager && film) {
    const double difference_px = std::abs(imager->focal_px - film->focal_px);
    if (difference_px > kMostDifference * film->focal_px) {
      film->sigma_px = difference_px;
      film->from += ", though " + imager->from + " is " + short_text(imager->focal_px) + " px";
      result = film;
    }
  }
  // A lens of less than a tenth or more than a hundred image sides is a wrong number.
  const double side_px = std::max(width_px, height_px);
  if (result && !(result->focal_px > 0.1 * side_px && result->focal_px < 100 * side_px))
    return std::nullopt;
  return result;
}

std::optional<ExifFocal> exif_focal(const std::vector<std::filesystem::path>& images, int width_px,
                                    int height_px) {
  std::vector<std::optional<ExifFocal>> focals(images.size());
  for_each_frame(images.size(), [&](std::size_t i) {
    focals[i] = exif_focal(read_exif(images[i]), width_px, height_px);
  });
  std::optional<std::size_t> first;
  std::size_t count = 0;
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (!focals[i]) continue;
    ++count;
    if (!first) first = i;
    const ExifFocal &a = *focals[*first], &b = *focals[i];
    if (std::abs(a.focal_px - b.focal_px) > kSameShare * a.focal_px) {
      throw std::runtime_error(
          images[i].string() + ": EXIF gives a focal length of " + short_text(b.focal_px) +
          " px (" + b.from + "), but that of " + images[*first].filename().string() + " is " +
          short_text(a.focal_px) + " px (" + a.from +
          "); import the photographs of one lens at a time, or give --intrinsics");
    }
  }
  if (!first) return std::nullopt;
  ExifFocal result = *focals[*first];
  result.from = "EXIF of " + images[*first].filename().string() + ": " + result.from + "; so in " +
                std::to_string(count) + " of " + std::to_string(images.size()) + " photographs";
  return result;
}

}  // namespace cousin
