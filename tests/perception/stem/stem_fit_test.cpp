#include "perception/stem/stem_fit.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "perception/stem/stem_seam.h"
#include "tests/perception/stem/made_stem.h"

namespace cousin {
namespace {

using testing::HasSubstr;

/// No doubt in the calibration: what is left is the pixels' own.
StemFitConfig sure_rig() {
  StemFitConfig config;
  config.calibration_px = 1e-3;
  config.calibration_share = 0;
  config.scatter_m = 0;
  return config;
}

TEST(NodesOnStem, WithoutNoiseAreTheTrueOnes) {
  const EyePair eyes = made_eyes();
  const auto truth = made_stem(0.9);
  const MadeView view = made_view(eyes, truth, 0, 0, Rng(1));
  const StemNodes nodes = nodes_on_stem(eyes, view.sightings, sure_rig());
  ASSERT_EQ(nodes.status, FitStatus::ok) << nodes.reason;
  ASSERT_EQ(nodes.nodes_m.size(), truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    // The priors of bend and lean pull a node by half a millimetre at 0.9 m, most of it in depth.
    EXPECT_LT((nodes.nodes_m[i] - truth[i]).norm(), 1e-3);
    if (i == 0) continue;
    EXPECT_NEAR(chord(nodes, i - 1, i).value_m, (truth[i] - truth[i - 1]).norm(), 2e-4);
    EXPECT_NEAR(along(nodes, i - 1, i).value_m, chord(nodes, i - 1, i).value_m, 1e-4);
  }
}

/// Errors of all internodes over draws.
struct LengthErrors {
  std::vector<double> absolute, normalised;
  double squares = 0, sigmas = 0;
};
template <class Method>
LengthErrors errors_of(const Method& method, double own_px, double common_px) {
  const EyePair eyes = made_eyes();
  LengthErrors errors;
  for (int draw = 0; draw < 300; ++draw) {
    Rng rng = Rng(77).fork(static_cast<std::uint64_t>(draw));
    const auto truth = made_stem(uniform(rng, 0.6, 1.2));
    const MadeView view = made_view(eyes, truth, own_px, common_px, rng);
    const StemNodes nodes = method(eyes, view.sightings);
    if (nodes.status != FitStatus::ok || nodes.nodes_m.size() != truth.size()) continue;
    for (std::size_t i = 1; i < truth.size(); ++i) {
      const StemLength length = chord(nodes, i - 1, i);
      const double error = length.value_m - (truth[i] - truth[i - 1]).norm();
      errors.absolute.push_back(std::abs(error));
      errors.squares += error * error;
      errors.sigmas += length.sigma_m;
      errors.normalised.push_back(std::abs(error) / length.sigma_m);
    }
  }
  std::sort(errors.absolute.begin(), errors.absolute.end());
  return errors;
}
double median_of(const LengthErrors& errors) { return errors.absolute[errors.absolute.size() / 2]; }
double coverage_of(const LengthErrors& errors) {
  const auto inside = std::count_if(errors.normalised.begin(), errors.normalised.end(),
                                    [](double e) { return e < 1.96; });
  return static_cast<double>(inside) / static_cast<double>(errors.normalised.size());
}

TEST(NodesOnStem, HalveTheErrorOfNodesPlacedAlone) {
  const LengthErrors alone =
      errors_of([](const EyePair& e,
                   std::span<const StemSighting> s) { return nodes_by_pixels(e, s, sure_rig()); },
                1, 0);
  const LengthErrors stem =
      errors_of([](const EyePair& e,
                   std::span<const StemSighting> s) { return nodes_on_stem(e, s, sure_rig()); },
                1, 0);
  EXPECT_GT(alone.absolute.size(), 1400U);
  EXPECT_LT(median_of(stem), 0.0012);
  EXPECT_LT(median_of(stem), 0.6 * median_of(alone));
}

TEST(NodesOnStem, IntervalsHoldTheTruthAndAreNoWiderThanTheyNeedToBe) {
  for (const double common_px : {0.0, 1.0}) {
    SCOPED_TRACE(common_px);
    StemFitConfig config = sure_rig();
    if (common_px > 0) config.common_share = 0.5;
    const LengthErrors errors =
        errors_of([&](const EyePair& e,
                      std::span<const StemSighting> s) { return nodes_on_stem(e, s, config); },
                  1, common_px);
    // 1500 lengths of 300 plants: a share of 0.95 has a deviation of 0.6 to 1.3 %.
    EXPECT_GT(coverage_of(errors), 0.92);
    EXPECT_LT(coverage_of(errors), 0.975);
    const auto n = static_cast<double>(errors.absolute.size());
    EXPECT_LT(2 * 1.96 * errors.sigmas / n / std::sqrt(errors.squares / n), 4.7);
  }
}

TEST(NodesOnStem, ErrorsInCommonDoNotMoveDepthAndAreNotMended) {
  const auto fit = [](const EyePair& e, std::span<const StemSighting> s) {
    return nodes_on_stem(e, s, sure_rig());
  };
  const double own = median_of(errors_of(fit, 1, 0)), common = median_of(errors_of(fit, 0, 1));
  // Two eyes average errors of their own; those in common stay as they are.
  EXPECT_GT(common, 1.15 * own);
}

TEST(NodesOnStem, LeaveOutANodeThatIsNone) {
  const EyePair eyes = made_eyes();
  MadeView view = made_view(eyes, made_stem(0.9), 0.3, 0, Rng(5));
  view.sightings[3].right.pixel_px.x() += 25;  // 0.25 m nearer
  const StemNodes nodes = nodes_on_stem(eyes, view.sightings);
  ASSERT_EQ(nodes.status, FitStatus::ok) << nodes.reason;
  EXPECT_EQ(nodes.places, (std::vector<int>{0, 1, 2, 4, 5}));
}

TEST(NodesOnStem, OfOneNodeAreItAloneWithAWideInterval) {
  const EyePair eyes = made_eyes();
  MadeView view = made_view(eyes, made_stem(0.9), 1, 0, Rng(6));
  view.sightings.resize(1);
  const StemNodes one = nodes_on_stem(eyes, view.sightings);
  ASSERT_EQ(one.status, FitStatus::ok);
  ASSERT_EQ(one.nodes_m.size(), 1U);
  // 1.41 px of disparity of 93 px at 0.9 m, and the rig's offset of 1.5 px: 20 mm.
  EXPECT_NEAR(std::sqrt(one.covariance_m2(2, 2)), 0.020, 0.004);
  EXPECT_EQ(nodes_on_stem(eyes, {}).status, FitStatus::degenerate);
}

TEST(NodesOnStem, OfSwappedOrUnlikeImagesHaveAStatus) {
  const EyePair eyes = made_eyes();
  MadeView view = made_view(eyes, made_stem(0.9), 0.3, 0, Rng(7));
  std::vector<StemSighting> swapped = view.sightings;
  for (StemSighting& s : swapped) std::swap(s.left, s.right);
  EXPECT_EQ(nodes_on_stem(eyes, swapped).status, FitStatus::degenerate);
  EXPECT_EQ(nodes_by_middle(eyes, swapped).status, FitStatus::degenerate);
  // Rows that do not agree: another calibration, or another moment.
  int k = 0;
  for (StemSighting& s : view.sightings) s.right.pixel_px.y() += (k++ % 2 == 0 ? 9 : -9);
  const StemNodes nodes = nodes_on_stem(eyes, view.sightings);
  EXPECT_EQ(nodes.status, FitStatus::not_converged);
  EXPECT_THAT(nodes.reason, HasSubstr("disagree"));
}

TEST(NodesOnStem, ExposuresApartWidenTheInterval) {
  const EyePair eyes = made_eyes();
  const MadeView view = made_view(eyes, made_stem(0.9), 0.5, 0, Rng(8));
  const StemNodes at_once = nodes_on_stem(eyes, view.sightings);
  const StemNodes apart = nodes_on_stem(eyes, view.sightings, {}, 0.03);
  EXPECT_GT(chord(apart, 0, 5).sigma_m, 1.5 * chord(at_once, 0, 5).sigma_m);
}

TEST(StemAsFit, ComesBackFromAFit) {
  const EyePair eyes = made_eyes();
  const MadeView view = made_view(eyes, made_stem(0.9), 0.5, 0, Rng(9));
  const StemNodes nodes = nodes_on_stem(eyes, view.sightings);
  const FittedStem back = stem_of_fit(stem_as_fit(nodes, 7, true));
  EXPECT_TRUE(back.has_root);
  EXPECT_EQ(back.nodes.nodes_m, nodes.nodes_m);
  EXPECT_EQ(back.nodes.along_m, nodes.along_m);
  EXPECT_EQ(chord(back.nodes, 1, 2).sigma_m, chord(nodes, 1, 2).sigma_m);
  EXPECT_FALSE(stem_of_fit(stem_as_fit(nodes, 7, false)).has_root);
  ObjectFit sphere;
  sphere.model = "sphere";
  EXPECT_THROW(stem_of_fit(sphere), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
