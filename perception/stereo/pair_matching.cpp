#include "perception/stereo/pair_matching.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "perception/stereo/disparity_lookup.h"
#include "perception/stereo/opencv_matching.h"
#include "sim/imaging/stereo_matching.h"
#include "sim/types/no_value.h"

namespace cousin {
namespace {

constexpr int kMostCandidates = 254;     ///< of one matching
constexpr int kAlignWidth_px = 240;      ///< at most, where rows are aligned first
constexpr int kRangeWidth_px = 480;      ///< at most, where the range is found
constexpr int kLeastSide_px = 32;        ///< of an image that is matched
constexpr double kLeastRows_px = 0.1;    ///< offsets below are not worth resampling an image
constexpr double kDoubtedRows_px = 0.5;  ///< offsets above are worth a word

/// Mean of scale x scale pixels each; what is left over at the right and below is left out.
Image<float> made_smaller(const Image<float>& image, int scale) {
  if (scale == 1) return image;
  Image<float> small(image.width() / scale, image.height() / scale);
  const auto area = static_cast<float>(scale * scale);
  tbb::parallel_for(0, small.height(), [&](int y) {
    for (int x = 0; x < small.width(); ++x) {
      float sum = 0;
      for (int j = 0; j < scale; ++j) {
        for (int i = 0; i < scale; ++i) sum += image(x * scale + i, y * scale + j);
      }
      small(x, y) = sum / area;
    }
  });
  return small;
}

/// The power of two that makes an image at most so wide, and no side too short to be matched.
int scale_for(const Image<float>& image, int most_px) {
  int scale = 1;
  const int shorter = std::min(image.width(), image.height());
  while (image.width() / scale > most_px && shorter / (2 * scale) >= kLeastSide_px) scale *= 2;
  return scale;
}

/// Leaves out patches of fewer pixels, whose neighbours differ by more than `step_px`.
Image<float> without_speckles(Image<float> disparity_px, int least_px, float step_px) {
  const int width = disparity_px.width(), height = disparity_px.height();
  Image<std::uint8_t> is_known(width, height);
  std::vector<Eigen::Vector2i> patch;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (is_known(x, y) != 0 || std::isnan(disparity_px(x, y))) continue;
      patch = {{x, y}};
      is_known(x, y) = 1;
      for (std::size_t i = 0; i < patch.size(); ++i) {
        const Eigen::Vector2i at = patch[i];
        const float own = disparity_px(at.x(), at.y());
        for (const Eigen::Vector2i& way : {Eigen::Vector2i(1, 0), Eigen::Vector2i(-1, 0),
                                           Eigen::Vector2i(0, 1), Eigen::Vector2i(0, -1)}) {
          const Eigen::Vector2i to = at + way;
          if (!disparity_px.contains(to.x(), to.y()) || is_known(to.x(), to.y()) != 0) continue;
          if (!(std::abs(disparity_px(to.x(), to.y()) - own) <= step_px)) continue;
          is_known(to.x(), to.y()) = 1;
          patch.push_back(to);
        }
      }
      if (patch.size() >= static_cast<std::size_t>(least_px)) continue;
      for (const Eigen::Vector2i& at : patch) disparity_px(at.x(), at.y()) = kNone;
    }
  }
  return disparity_px;
}

/// Leaves out what the right image cannot show: pixels that fall where a nearer one does, or
/// outside.
void leave_out_hidden(Image<float>& disparity_px, const Image<std::uint8_t>& right_valid) {
  constexpr float kNearer_px = 1;
  const int width = disparity_px.width();
  tbb::parallel_for(0, disparity_px.height(), [&](int y) {
    std::vector<float> nearest(static_cast<std::size_t>(width), -1);
    const auto there = [&](int x) {
      const float d = disparity_px(x, y);
      if (std::isnan(d)) return -1;
      const auto right = static_cast<int>(std::lround(static_cast<float>(x) - d));
      return right >= 0 && right < width && right_valid(right, y) != 0 ? right : -1;
    };
    for (int x = 0; x < width; ++x) {
      const int right = there(x);
      if (right < 0) continue;
      float& best = nearest[static_cast<std::size_t>(right)];
      best = std::max(best, disparity_px(x, y));
    }
    for (int x = 0; x < width; ++x) {
      const int right = there(x);
      const bool is_shown =
          right >= 0 && nearest[static_cast<std::size_t>(right)] <= disparity_px(x, y) + kNearer_px;
      if (!is_shown) disparity_px(x, y) = kNone;
    }
  });
}

/// Where a whole matching window lies in the image: 1, else 0.
Image<std::uint8_t> whole_windows(const Image<std::uint8_t>& valid, int scale) {
  constexpr int kReach_px = 5;
  const int width = valid.width() / scale, height = valid.height() / scale;
  // Along rows and then along columns, a count of pixels since the last that is not valid.
  Image<std::uint8_t> along(width, height, 1), whole(width, height, 1);
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      bool is_whole = true;
      for (int j = 0; j < scale; ++j) {
        for (int i = 0; i < scale; ++i)
          is_whole = is_whole && valid(x * scale + i, y * scale + j) != 0;
      }
      if (is_whole) continue;
      for (int i = std::max(0, x - kReach_px); i <= std::min(width - 1, x + kReach_px); ++i)
        along(i, y) = 0;
    }
  });
  tbb::parallel_for(0, width, [&](int x) {
    for (int y = 0; y < height; ++y) {
      if (along(x, y) != 0) continue;
      for (int j = std::max(0, y - kReach_px); j <= std::min(height - 1, y + kReach_px); ++j)
        whole(x, j) = 0;
    }
  });
  return whole;
}

/// A pair of images at one scale.
struct ScaledPair {
  Image<float> left, right;
  Image<std::uint8_t> left_whole, right_whole;
  int scale = 1;
};
ScaledPair scaled_pair(const RectifiedPair& pair, int scale) {
  return {made_smaller(pair.left.image, scale), made_smaller(pair.right.image, scale),
          whole_windows(pair.left.valid, scale), whole_windows(pair.right.valid, scale), scale};
}

/// A match whose window reaches over the edge of either image is left out.
StereoMatches match_inside(const ScaledPair& pair, const StereoMatchConfig& config) {
  StereoMatches matches = match_stereo(pair.left, pair.right, config);
  tbb::parallel_for(0, pair.left.height(), [&](int y) {
    for (int x = 0; x < pair.left.width(); ++x) {
      MatchReason& reason = matches.reason(x, y);
      float& disparity_px = matches.disparity_px(x, y);
      if (pair.left_whole(x, y) == 0) {
        reason = MatchReason::no_texture;  // of this image none is seen there
      } else if (reason == MatchReason::none) {
        const auto there = static_cast<int>(std::lround(static_cast<float>(x) - disparity_px));
        if (!pair.right_whole.contains(there, y) || pair.right_whole(there, y) == 0)
          reason = MatchReason::out_of_range;
      }
      if (reason != MatchReason::none) disparity_px = kNone;
    }
  });
  return matches;
}

/// Share of pixels for which `is` holds.
template <class Is>
double share_of(const Image<MatchReason>& reasons, Is is) {
  const auto count = std::count_if(reasons.begin(), reasons.end(), is);
  return reasons.empty() ? 0 : static_cast<double>(count) / static_cast<double>(reasons.size());
}
double textured_share(const Image<MatchReason>& reasons) {
  return share_of(reasons, [](MatchReason reason) { return reason != MatchReason::no_texture; });
}
double matched_share(const Image<MatchReason>& reasons) {
  return share_of(reasons, [](MatchReason reason) { return reason == MatchReason::none; });
}

/// All disparities that there may be at a small scale.
StereoMatches match_coarsely(const ScaledPair& pair, const PairMatchConfig& config) {
  StereoMatchConfig match = config.match;
  match.shift_px = 0;
  match.range_px =
      std::clamp(config.range_px > 0 ? config.range_px / pair.scale + 2 : pair.left.width() / 2, 1,
                 kMostCandidates);
  return match_inside(pair, match);
}

/// Moves the right image's rows to where they agree with the left one's.
/// @param pair  of the same images at some scale
void align_rows(RectifiedPair& whole, const Image<Eigen::Vector2f>& reported_px,
                const ScaledPair& pair, const Image<float>& disparity_px, PairFindings& findings) {
  const RowOffset rows = scaled(
      find_row_offset(pair.left, pair.right, disparity_px, scaled(findings.rows, 1.0 / pair.scale)),
      pair.scale);
  const int width = whole.left.image.width(), height = whole.left.image.height();
  if (rows.windows == 0) return;
  RowOffset change = rows;
  for (std::size_t i = 0; i < change.terms_px.size(); ++i)
    change.terms_px[i] -= findings.rows.terms_px[i];
  if (size_of(change, width, height).largest_px < kLeastRows_px) return;
  findings.rows = rows;
  findings.rows_off = size_of(rows, width, height);
  use_right_map(whole, with_rows_moved(reported_px, rows));
}

/// Disparities of both ends of what is seen, at full size.
bool find_range(const StereoMatches& coarse, const ScaledPair& pair, PairFindings& findings) {
  constexpr int kLeastPatch_px = 30;
  constexpr std::size_t kLeastPixels = 12;  // beyond either end, and a share of all
  constexpr std::size_t kShare = 300;
  // One wrong match would make all others dearer and worse: what counts is surely alike.
  const RefinedDisparities sure =
      refine_disparities(pair.left, pair.right, coarse.disparity_px, {.least_likeness = 0.8});
  const Image<float> disparity_px = without_speckles(sure.disparity_px, kLeastPatch_px, 1);
  std::vector<float> found;
  std::copy_if(disparity_px.begin(), disparity_px.end(), std::back_inserter(found),
               [](float d) { return !std::isnan(d); });
  if (found.size() <= 2 * kLeastPixels) return false;
  std::sort(found.begin(), found.end());
  const std::size_t beyond = std::max(kLeastPixels, found.size() / kShare);
  const double low_px = static_cast<double>(found[beyond]) * pair.scale;
  const double high_px = static_cast<double>(found[found.size() - 1 - beyond]) * pair.scale;
  // Thin things that are nearer than all others are lost at the small scale.
  const double margin_px = 2 * pair.scale + 2 + 0.15 * (high_px - low_px);
  findings.first_px = std::max(0.0, std::floor(low_px - margin_px));
  findings.last_px = std::ceil(high_px + margin_px);
  return true;
}

/// Disparities of the images at a scale, in pixels of that scale.
struct ScaledDisparities {
  Image<float> disparity_px, sigma_px;
  Image<MatchReason> reason;
  float noise = 0;  ///< of the left image's brightness
};

constexpr float kStep_px = 1.5F;  ///< between neighbours of one surface

/// Semi-global matching between the ends that findings say.
StereoMatches match_in_range(const ScaledPair& pair, const PairMatchConfig& config,
                             const PairFindings& findings) {
  StereoMatchConfig match = config.match;
  match.shift_px = static_cast<int>(findings.first_px) / pair.scale;
  match.range_px =
      std::clamp(static_cast<int>(std::ceil(findings.last_px / pair.scale)) - match.shift_px, 1,
                 kMostCandidates);
  StereoMatches matches = match_inside(pair, match);
  const int speckle_px = std::max(1, config.speckle_px / (pair.scale * pair.scale));
  matches.disparity_px = without_speckles(std::move(matches.disparity_px), speckle_px, kStep_px);
  return matches;
}

ScaledDisparities refined(const ScaledPair& pair, StereoMatches matches,
                          const PairMatchConfig& config) {
  RefinedDisparities fine =
      refine_disparities(pair.left, pair.right, matches.disparity_px, config.refine);
  return {without_speckles(std::move(fine.disparity_px), config.speckle_px, kStep_px),
          std::move(fine.sigma_px), std::move(matches.reason), fine.noise};
}

/// The same of images `times` as large.
ScaledDisparities made_larger(const ScaledDisparities& small, int times, int width, int height) {
  ScaledDisparities large{Image<float>(width, height, kNone), Image<float>(width, height, kNone),
                          Image<MatchReason>(width, height, MatchReason::out_of_range), 0};
  const auto factor = static_cast<float>(times);
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const double first = 0.5 * (times - 1);  // of the pixel whose middle is the small one's
      const KnownDisparity found = disparity_at(small.disparity_px, small.sigma_px,
                                                {(x - first) / times, (y - first) / times});
      large.disparity_px(x, y) = factor * found.disparity_px;
      large.sigma_px(x, y) = factor * found.sigma_px;
      if (small.reason.contains(x / times, y / times))
        large.reason(x, y) = small.reason(x / times, y / times);
    }
  });
  return large;
}

/// Standard deviation of the brightness in a window about each pixel.
Image<float> contrast_of(const Image<float>& image, int radius_px) {
  Image<float> contrast(image.width(), image.height());
  tbb::parallel_for(0, image.height(), [&](int y) {
    for (int x = 0; x < image.width(); ++x) {
      float sum = 0, squares = 0;
      int count = 0;
      for (int j = std::max(0, y - radius_px); j <= std::min(image.height() - 1, y + radius_px);
           ++j) {
        for (int i = std::max(0, x - radius_px); i <= std::min(image.width() - 1, x + radius_px);
             ++i, ++count) {
          const float off = image(i, j) - image(x, y);
          sum += off;
          squares += off * off;
        }
      }
      const float mean = sum / static_cast<float>(count);
      contrast(x, y) = std::sqrt(std::max(0.0F, squares / static_cast<float>(count) - mean * mean));
    }
  });
  return contrast;
}

/// Puts disparities of smaller images where the noise of the larger ones hides what texture there
/// is. What one image alone shows stays without.
void fill_from(const ScaledDisparities& smaller, const Image<float>& left,
               ScaledDisparities& larger) {
  constexpr int kRadius_px = 3;
  constexpr float kMostContrast = 2.5F;  // in standard deviations of the noise
  const Image<float> contrast = contrast_of(left, kRadius_px);
  for (std::size_t i = 0; i < larger.disparity_px.size(); ++i) {
    const MatchReason reason = larger.reason.data()[i];
    if (!std::isnan(larger.disparity_px.data()[i]) || reason == MatchReason::left_right ||
        reason == MatchReason::out_of_range || contrast.data()[i] > kMostContrast * larger.noise)
      continue;
    larger.disparity_px.data()[i] = smaller.disparity_px.data()[i];
    larger.sigma_px.data()[i] = smaller.sigma_px.data()[i];
  }
}

PairDisparities match_by_ours(RectifiedPair& pair, const Image<Eigen::Vector2f>& reported_px,
                              const PairMatchConfig& config, PairFindings findings) {
  const int width = pair.left.image.width(), height = pair.left.image.height();
  while ((findings.last_px - findings.first_px) / findings.scale > kMostCandidates)
    findings.scale *= 2;
  ScaledPair first = scaled_pair(pair, findings.scale);
  StereoMatches matches = match_in_range(first, config, findings);
  if (config.align_rows) {
    for (int round = 0; round < 2; ++round) {  // what agrees better is found in more places
      align_rows(pair, reported_px, first, matches.disparity_px, findings);
      first = scaled_pair(pair, findings.scale);
    }
  }
  ScaledDisparities result = refined(first, std::move(matches), config);
  // What noise drowns at one size, the mean of four pixels may show.
  std::vector<ScaledDisparities> smaller;
  std::vector<Image<float>> left = {first.left};
  for (int k = 1; k <= config.smaller_sizes; ++k) {
    const ScaledPair small = scaled_pair(pair, findings.scale << k);
    if (std::min(small.left.width(), small.left.height()) < kLeastSide_px) break;
    smaller.push_back(refined(small, match_in_range(small, config, findings), config));
    left.push_back(small.left);
  }
  for (std::size_t k = smaller.size(); k-- > 0;) {
    ScaledDisparities& larger = k == 0 ? result : smaller[k - 1];
    fill_from(made_larger(smaller[k], 2, larger.reason.width(), larger.reason.height()), left[k],
              larger);
  }
  if (findings.scale > 1) {
    result = made_larger(result, findings.scale, width, height);
    DisparityRefinementConfig refine = config.refine;
    refine.most_moved_px *= findings.scale;
    RefinedDisparities fine =
        refine_disparities(pair.left.image, pair.right.image, result.disparity_px, refine);
    for (std::size_t i = 0; i < fine.disparity_px.size(); ++i) {
      if (std::isnan(fine.disparity_px.data()[i])) continue;
      result.disparity_px.data()[i] = fine.disparity_px.data()[i];
      result.sigma_px.data()[i] = fine.sigma_px.data()[i];
    }
  }
  return {std::move(result.disparity_px), std::move(result.sigma_px), std::move(findings)};
}

PairDisparities match_with_opencv(const RectifiedPair& pair, PairFindings findings) {
  return {match_by_opencv(pair.left.image, pair.right.image,
                          std::max(1, static_cast<int>(findings.last_px))),
          {},
          std::move(findings)};
}

/// Where the left image shows texture, at a small scale.
struct Texture {
  Image<MatchReason> reason;
  int scale = 1;

  bool at(int x, int y) const {
    return reason.contains(x / scale, y / scale) &&
           reason(x / scale, y / scale) != MatchReason::no_texture;
  }
};

/// The coarse steps: rows, range, and whether the images are a pair at all.
Texture find_coarsely(RectifiedPair& pair, const Image<Eigen::Vector2f>& reported_px,
                      const PairMatchConfig& config, PairFindings& findings) {
  if (config.align_rows) {
    const ScaledPair small = scaled_pair(pair, scale_for(pair.left.image, kAlignWidth_px));
    const StereoMatches matches = match_coarsely(small, config);
    align_rows(pair, reported_px, small, matches.disparity_px, findings);
  }
  const ScaledPair coarse = scaled_pair(pair, scale_for(pair.left.image, kRangeWidth_px));
  const StereoMatches matches = match_coarsely(coarse, config);
  const double textured = textured_share(matches.reason), matched = matched_share(matches.reason);
  Texture texture{matches.reason, coarse.scale};
  if (textured < 0.001) {
    findings.why_none = "the images show no texture";
    return texture;
  }
  if (matched < 0.3 * textured) {
    const StereoMatches exchanged = match_coarsely(
        {coarse.right, coarse.left, coarse.right_whole, coarse.left_whole, coarse.scale}, config);
    const double other = matched_share(exchanged.reason);
    if (other > 2 * matched && other > 0.3 * textured) {
      findings.why_none = "the right image shows what the left one should: exchange the two";
      return texture;
    }
  }
  if (config.range_px > 0)
    findings.last_px = std::min(config.range_px, pair.left.image.width() - 1);
  else if (!find_range(matches, coarse, findings))
    findings.why_none = "no part of one image is found in the other";
  return texture;
}

void say_doubts(const PairMatchConfig& config, PairFindings& findings) {
  char text[200];
  if (findings.rows_off.largest_px > kDoubtedRows_px) {
    std::snprintf(text, sizeof text,
                  "the right image's rows lie up to %.1f px (%.1f px RMS) from where its "
                  "calibration says; they were moved",
                  findings.rows_off.largest_px, findings.rows_off.rms_px);
    findings.doubts.emplace_back(text);
  }
  if (findings.matched < 0.5) {
    std::snprintf(text, sizeof text, "of the pixels with texture %.0f %% are found in both images",
                  100 * findings.matched);
    findings.doubts.emplace_back(text);
  }
  if (findings.matched >= config.least_matched) return;
  std::snprintf(text, sizeof text,
                "of the pixels with texture %.0f %% are found in both images; least_matched = %.2f",
                100 * findings.matched, config.least_matched);
  findings.why_none = text;
  findings.doubts.clear();
}

}  // namespace

PairDisparities match_pair(RectifiedPair& pair, const PairMatchConfig& config) {
  const int width = pair.left.image.width(), height = pair.left.image.height();
  const Image<Eigen::Vector2f> reported_px = pair.geometry.right_px;
  PairFindings findings;
  PairDisparities result{Image<float>(width, height, kNone), {}, findings};
  if (std::min(width, height) < kLeastSide_px) {
    result.findings.why_none =
        "the images have fewer than " + std::to_string(kLeastSide_px) + " pixels along a side";
    return result;
  }
  const Texture texture = find_coarsely(pair, reported_px, config, findings);
  result.findings = findings;
  if (!findings.why_none.empty()) return result;
  result = config.matcher == PairMatcher::opencv
               ? match_with_opencv(pair, std::move(findings))
               : match_by_ours(pair, reported_px, config, std::move(findings));
  leave_out_hidden(result.disparity_px, pair.right.valid);
  double textured = 0, matched = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      float& d = result.disparity_px(x, y);
      if (pair.left.valid(x, y) == 0) d = kNone;
      if (std::isnan(d) && !result.sigma_px.empty()) result.sigma_px(x, y) = kNone;
      if (!texture.at(x, y)) continue;
      ++textured;
      matched += !std::isnan(d);
    }
  }
  result.findings.textured = textured / (static_cast<double>(width) * height);
  result.findings.matched = matched / std::max(1.0, textured);
  say_doubts(config, result.findings);
  if (!result.findings.why_none.empty()) result.disparity_px = Image<float>(width, height, kNone);
  return result;
}

}  // namespace cousin
