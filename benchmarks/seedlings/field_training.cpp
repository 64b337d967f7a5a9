#include "benchmarks/seedlings/field_training.h"

#include <memory>
#include <stdexcept>

#include "benchmarks/splats/kept_training.h"
#include "benchmarks/splats/ngp_view.h"
#include "perception/splats/splat_render.h"
#include "perception/splats/train_splats.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

FieldRenderer renderer_of(SplatModel model) {
  return [model = std::make_shared<const SplatModel>(std::move(model))](const Camera& camera,
                                                                        const Pose& pose) {
    return render_splats(*model, camera, pose).color.channel;
  };
}

FieldRenderer renderer_of(const NgpModel& model) {
  return [kept = std::make_shared<const NgpModel>(model)](const Camera& camera, const Pose& pose) {
    return fidelity_planes(render_ngp(*kept, camera, pose).color);
  };
}

/// Scores a model and keeps it as the last.
void add_scores(const FieldViews& views, int steps, const StageTiming& timing,
                std::int64_t gaussians, FieldRenderer render, TrainedField& field) {
  FieldScores scores = score_field(render, views);
  scores.steps = steps;
  scores.wall_s = timing.wall_s;
  scores.cpu_s = timing.cpu_s;
  scores.gaussians = gaussians;
  field.scores.push_back(scores);
  field.render = std::move(render);
}

std::vector<SplatView> photographs(const FieldViews& views) {
  std::vector<SplatView> result;
  for (const SampleView* view : views.train) result.push_back(view->photograph);
  return result;
}

TrainedField train_gaussians(const SplatTrainConfig& config, const std::vector<int>& at,
                             const FieldViews& views, const SplatModel& start,
                             const fs::path& unfinished) {
  const KeptTraining kept(unfinished);
  const auto go_on = [&](const SplatTrainPoint& point) { return point.step < at.back(); };
  const SplatTraining training =
      train_splats(photographs(views), start, config, go_on, kept.checkpoint(), kept.snapshots(at));
  TrainedField field;
  const bool is_left = training.status == SplatTrainStatus::stopped;
  field.status = is_left ? "ok" : to_string(training.status);
  if (field.status != "ok") return field;
  std::vector<KeptModel> models = kept.models(at);
  if (models.size() != at.size()) {
    throw std::runtime_error(unfinished.string() + ": " + std::to_string(models.size()) + " of " +
                             std::to_string(at.size()) +
                             " models are there; remove it to train again");
  }
  for (KeptModel& way : models) {
    add_scores(views, way.step, way.seconds, static_cast<std::int64_t>(way.model.splats.size()),
               renderer_of(way.model), field);
    field.splats = std::move(way.model);
  }
  return field;
}

TrainedField train_reference(const FieldPlan& plan, const FieldViews& views,
                             const SplatModel& start, std::uint64_t seed,
                             const fs::path& unfinished) {
  SplatTrainConfig config = reference_training();
  config.seed = seed;
  config.report_every = 10;  // where it can be left
  return train_gaussians(config, plan.at, views, start, unfinished);
}

TrainedField train_ours(const FieldPlan& plan, const FieldViews& views, const SplatModel& start,
                        std::uint64_t seed, const fs::path& unfinished) {
  TrainedField field;
  if (!plan.most_splats.empty() && plan.most_splats.size() != plan.at.size())
    throw std::invalid_argument(plan.method + ": " + std::to_string(plan.most_splats.size()) +
                                " numbers of Gaussians for " + std::to_string(plan.at.size()) +
                                " trainings");
  for (std::size_t i = 0; i < plan.at.size(); ++i) {
    const int steps = plan.at[i];
    SplatTrainConfig config;
    config.steps = steps;
    config.rates = rates_for(steps);
    if (!plan.most_splats.empty()) config.most_splats = plan.most_splats[i];
    config.seed = seed;
    TrainedField one =
        train_gaussians(config, {steps}, views, start,
                        unfinished.empty() ? unfinished : unfinished / std::to_string(steps));
    field.status = one.status;
    if (one.status != "ok") break;
    field.scores.push_back(one.scores.back());
    field.render = std::move(one.render);
    field.splats = std::move(one.splats);
  }
  return field;
}

TrainedField train_radiance_field(const FieldPlan& plan, const FieldViews& views,
                                  std::uint64_t seed, const fs::path& unfinished) {
  std::vector<NgpView> photographs;
  for (const SampleView* view : views.train) photographs.push_back(ngp_view(view->photograph));
  NgpConfig config;
  config.iterations = plan.at.back();
  config.samples_per_step = plan.ngp_samples;
  config.seed = seed;
  TrainedField field;
  const KeptFieldTraining kept(unfinished);
  const NgpTraining training =
      train_ngp(photographs, config, kept.snapshots(plan.at), {}, kept.checkpoint());
  field.status = to_string(training.status);
  if (training.status != NgpStatus::ok) field.status += ", " + training.reason;
  for (const KeptField& way : kept.models(plan.at))
    add_scores(views, way.step, way.seconds, 0, renderer_of(way.model), field);
  return field;
}

}  // namespace

TrainedField train_field(const FieldPlan& plan, const FieldViews& views,
                         const std::vector<StartPoint>& start, std::uint64_t seed,
                         const fs::path& unfinished) {
  if (plan.at.empty()) throw std::invalid_argument(plan.method + ": no steps to score after");
  if (plan.method == kNgp) return train_radiance_field(plan, views, seed, unfinished);
  const SplatModel from = splats_from_points(start);
  if (plan.method == kReference) return train_reference(plan, views, from, seed, unfinished);
  if (plan.method == kOurs) return train_ours(plan, views, from, seed, unfinished);
  throw std::invalid_argument("method \"" + plan.method + "\" is not one of " + kReference + ", " +
                              kOurs + ", " + kNgp);
}

}  // namespace cousin
