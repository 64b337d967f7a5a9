#include "benchmarks/suites/seedlings/field_scores.h"

#include <algorithm>
#include <cmath>

#include "benchmarks/score/best_exposed.h"
#include "benchmarks/score/order_statistics.h"
#include "benchmarks/suites/seedlings/surface_coverage.h"

namespace cousin {
namespace {

/// PSNR over the pixels of several images together.
class PooledPsnr {
 public:
  void add(const FidelityPlanes& image, const FidelityPlanes& photograph, std::size_t pixel) {
    for (std::size_t c = 0; c < 3; ++c) {
      const double shown = std::clamp(image[c].data()[pixel], 0.0F, 1.0F);
      const double off = shown - photograph[c].data()[pixel];
      squares_ += off * off;
      ++count_;
    }
  }
  double value_db() const {
    return count_ > 0 ? -10 * std::log10(squares_ / static_cast<double>(count_)) : kNaN;
  }

 private:
  double squares_ = 0;
  std::int64_t count_ = 0;
};

struct ViewSums {
  std::vector<double> psnr_db, ssim, flip, exposed_db, learned;
  std::vector<double> seedlings_db, seedlings_ssim, seedlings_flip;

  void add(const FidelityPlanes& image, const SampleView& view, const LearnedDistance* network) {
    const FidelityPlanes& photograph = view.photograph.full.color.channel;
    const FidelityPlanes inside = where_counted(image, photograph, view.shown);
    const ImageFidelity whole = score_fidelity(inside, photograph, view.shown);
    psnr_db.push_back(whole.psnr_db);
    ssim.push_back(whole.ssim);
    flip.push_back(whole.flip);
    exposed_db.push_back(
        cousin::psnr_db(best_exposed(image, photograph, view.shown), photograph, view.shown));
    if (network) learned.push_back(network->between(inside, photograph));
    const ImageFidelity plants = score_fidelity(where_counted(image, photograph, view.seedlings),
                                                photograph, view.seedlings);
    if (plants.pixels == 0) return;  // some views show none
    seedlings_db.push_back(plants.psnr_db);
    seedlings_ssim.push_back(plants.ssim);
    seedlings_flip.push_back(plants.flip);
  }
  ViewScores scores() const {
    return {static_cast<std::int64_t>(psnr_db.size()),
            mean(psnr_db),
            mean(ssim),
            mean(flip),
            mean(seedlings_db),
            mean(seedlings_ssim),
            mean(seedlings_flip),
            mean(exposed_db),
            mean(learned),
            static_cast<std::int64_t>(seedlings_db.size())};
  }
};

FidelityPlanes image_of(const FieldRenderer& render, const SampleView& view) {
  return render(view.photograph);
}

}  // namespace

std::vector<std::size_t> scored_views(std::size_t trained) {
  const std::size_t count = std::min(trained, kScoredViews);
  std::vector<std::size_t> scored;
  for (std::size_t i = 0; i < count; ++i) scored.push_back(i * trained / count);
  return scored;
}

FieldViews field_views(std::vector<const SampleView*> train,
                       std::vector<const SampleView*> held_out) {
  FieldViews views{std::move(train), std::move(held_out), {}, {}};
  std::vector<DepthSight> eyes;
  for (const SampleView* view : views.train) {
    eyes.push_back({view->photograph.full.camera, view->photograph.camera_from_world,
                    &view->depth_m, &view->shown});
  }
  for (const SampleView* view : views.held_out)
    views.seen.push_back(views_that_see(view->position_m, eyes));
  return views;
}

FieldScores score_field(const FieldRenderer& render, const FieldViews& views) {
  FieldScores scores;
  ViewSums train, held_out;
  for (const std::size_t i : scored_views(views.train.size()))
    train.add(image_of(render, *views.train[i]), *views.train[i], views.learned.get());
  PooledPsnr all, covered, uncovered;
  for (std::size_t v = 0; v < views.held_out.size(); ++v) {
    const SampleView& view = *views.held_out[v];
    const FidelityPlanes image = image_of(render, view);
    held_out.add(image, view, views.learned.get());
    for (std::size_t i = 0; i < view.shown.size(); ++i) {
      if (view.shown.data()[i] == 0) continue;
      all.add(image, view.photograph.full.color.channel, i);
      const bool is_covered = views.seen[v].data()[i] >= kEnoughViews;
      (is_covered ? covered : uncovered).add(image, view.photograph.full.color.channel, i);
    }
  }
  scores.train = train.scores();
  scores.held_out = held_out.scores();
  scores.pooled_db = all.value_db();
  scores.covered_db = covered.value_db();
  scores.uncovered_db = uncovered.value_db();
  return scores;
}

}  // namespace cousin
