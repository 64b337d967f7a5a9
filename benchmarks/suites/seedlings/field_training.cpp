#include "benchmarks/suites/seedlings/field_training.h"

#include <algorithm>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>

#include "benchmarks/suites/splats/kept_training.h"
#include "benchmarks/suites/splats/ngp_view.h"
#include "perception/splats/splat_checkpoint_io.h"
#include "perception/splats/splat_render.h"
#include "perception/splats/swept_start.h"
#include "perception/splats/train_splats.h"
#include "sim/dataset/atomic_file.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kLeastSwept = 1000;  ///< points, of a start on surfaces; or all wanted
/// Of the rate of centres: Gaussians that begin on surfaces need not be thrown about.
constexpr double kSweptRate = 0.25;

FieldRenderer renderer_of(SplatModel model) {
  return [model = std::make_shared<const SplatModel>(std::move(model))](const SplatView& view) {
    return render_splats(*model, view.full.camera, view.camera_from_world).color.channel;
  };
}

/// As each view's camera shows a model of their mean exposure. @param trained  of the exposures
FieldRenderer as_exposed_by(FieldRenderer render, const ViewExposures& exposures,
                            const std::vector<SplatView>& trained) {
  struct Known {
    Eigen::Vector3d centre_m;
    double log_gain;
  };
  std::map<int, Known> known;  // by frame, whose number another capture may have too
  for (std::size_t v = 0; v < trained.size(); ++v)
    known[trained[v].frame] = {centre_in_world_m(trained[v].camera_from_world),
                               exposures.gain_of(v)};
  return [render = std::move(render), known,
          vignetting = exposures.vignetting](const SplatView& view) {
    const auto own = known.find(view.frame);
    const bool is_known =
        own != known.end() && own->second.centre_m == centre_in_world_m(view.camera_from_world);
    const double log_gain = is_known ? own->second.log_gain : 0;
    return as_exposed({render(view)}, view.full.camera, log_gain, vignetting).channel;
  };
}

FieldRenderer renderer_of(const NgpModel& model) {
  return [kept = std::make_shared<const NgpModel>(model)](const SplatView& view) {
    return fidelity_planes(render_ngp(*kept, view.full.camera, view.camera_from_world).color);
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

/// What Gaussians are trained on and begin from.
struct GaussianStart {
  std::vector<SplatView> photographs;
  SplatModel model;
  ViewExposures exposures;   ///< that were taken out of the photographs
  double centre_rate = 1;    ///< share of the configuration's
  StageTiming seconds = {};  ///< of finding all that
};

[[noreturn]] void throw_incomplete(const fs::path& unfinished, std::size_t models,
                                   std::size_t wanted) {
  throw std::runtime_error(unfinished.string() + ": " + std::to_string(models) + " of " +
                           std::to_string(wanted) + " models are there; remove it to train again");
}

TrainedField train_gaussians(const SplatTrainConfig& config, const std::vector<int>& at,
                             const FieldViews& views, const GaussianStart& start,
                             const fs::path& unfinished) {
  const KeptTraining kept(unfinished);
  const auto go_on = [&](const SplatTrainPoint& point) { return point.step < at.back(); };
  const SplatTraining training = train_splats(start.photographs, start.model, config, go_on,
                                              kept.checkpoint(), kept.snapshots(at));
  TrainedField field;
  const bool is_left = training.status == SplatTrainStatus::stopped;
  field.status = is_left ? "ok" : to_string(training.status);
  std::vector<KeptModel> models = kept.models(at);  // of one that failed those before
  if (field.status == "ok" && models.size() != at.size())
    throw_incomplete(unfinished, models.size(), at.size());
  field.exposures = start.exposures;
  for (KeptModel& way : models) {
    way.seconds.wall_s += start.seconds.wall_s;
    way.seconds.cpu_s += start.seconds.cpu_s;
    FieldRenderer render = renderer_of(way.model);
    if (start.exposures.status == ExposureStatus::ok)
      render = as_exposed_by(std::move(render), start.exposures, start.photographs);
    add_scores(views, way.step, way.seconds, static_cast<std::int64_t>(way.model.splats.size()),
               std::move(render), field);
    field.splats = std::move(way.model);
  }
  return field;
}

/// Seconds of a start as the first process that made it took them, since each makes it again.
StageTiming kept_seconds(const fs::path& unfinished, const GaussianStart& start, StageTiming now) {
  if (unfinished.empty()) return now;
  const fs::path file = unfinished / "start_seconds.txt";
  const std::string own = training_fingerprint(start.photographs, start.model, {});
  if (fs::exists(file)) {
    std::istringstream in(read_file(file));
    std::string of;
    StageTiming first = now;
    if (in >> of >> first.wall_s >> first.cpu_s && of == own) return first;
  }
  std::ostringstream out;
  out.precision(17);
  out << own << ' ' << now.wall_s << ' ' << now.cpu_s << '\n';
  write_file(file, out.str());
  return now;
}

/// On surfaces that are swept, of photographs with their exposures taken out; on the points where
/// hardly any surface is found.
GaussianStart swept(const FieldPlan& plan, const FieldViews& views, const FieldStart& from,
                    const fs::path& unfinished) {
  const StageClock clock("start");
  GaussianStart start{photographs(views), {}, {}};
  SweptStartConfig config;
  config.most_points = plan.start_points;
  SweptStart surfaces = swept_start(start.photographs, from.volume, config);
  start.exposures = std::move(surfaces.exposures);
  for (std::size_t v = 0; v < start.photographs.size(); ++v) {
    SplatViewLevel& level = start.photographs[v].full;
    level =
        at_mean_exposure(std::move(level), start.exposures.gain_of(v), start.exposures.vignetting);
  }
  const auto wanted = static_cast<std::size_t>(std::max(1, plan.start_points));
  if (surfaces.points.size() < std::min(kLeastSwept, wanted)) {
    start.model = splats_from_points(from.points);
  } else {
    surfaces.points.insert(surfaces.points.end(), from.beside.begin(), from.beside.end());
    start.model = splats_from_points(surfaces.points);
    start.centre_rate = kSweptRate;
  }
  start.seconds = kept_seconds(unfinished, start, clock.finish());
  return start;
}

TrainedField train_reference(const FieldPlan& plan, const FieldViews& views, const FieldStart& from,
                             std::uint64_t seed, const fs::path& unfinished) {
  const GaussianStart start{photographs(views), splats_from_points(from.points), {}};
  SplatTrainConfig config = reference_training();
  config.seed = seed;
  config.report_every = 10;  // where it can be left
  return train_gaussians(config, plan.at, views, start, unfinished);
}

TrainedField train_ours(const FieldPlan& plan, const FieldViews& views, const FieldStart& from,
                        std::uint64_t seed, const fs::path& unfinished) {
  if (!plan.most_splats.empty() && plan.most_splats.size() != plan.at.size())
    throw std::invalid_argument(plan.method + ": " + std::to_string(plan.most_splats.size()) +
                                " numbers of Gaussians for " + std::to_string(plan.at.size()) +
                                " trainings");
  const GaussianStart start = swept(plan, views, from, unfinished);
  TrainedField field;
  for (std::size_t i = 0; i < plan.at.size(); ++i) {
    const int steps = plan.at[i];
    SplatTrainConfig config;
    config.steps = steps;
    config.rates = rates_for(steps);
    config.rates.centre_first *= start.centre_rate;
    if (!plan.most_splats.empty()) config.most_splats = plan.most_splats[i];
    config.seed = seed;
    TrainedField one =
        train_gaussians(config, {steps}, views, start,
                        unfinished.empty() ? unfinished : unfinished / std::to_string(steps));
    field.status = one.status;
    if (one.scores.empty()) break;
    field.scores.push_back(one.scores.back());
    field.render = std::move(one.render);
    field.splats = std::move(one.splats);
    field.exposures = std::move(one.exposures);
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
  const std::vector<KeptField> models = kept.models(plan.at);
  if (training.status == NgpStatus::ok && models.size() != plan.at.size())
    throw_incomplete(unfinished, models.size(), plan.at.size());
  for (const KeptField& way : models)
    add_scores(views, way.step, way.seconds, 0, renderer_of(way.model), field);
  return field;
}

}  // namespace

TrainedField train_field(const FieldPlan& plan, const FieldViews& views, const FieldStart& start,
                         std::uint64_t seed, const fs::path& unfinished) {
  if (plan.at.empty()) throw std::invalid_argument(plan.method + ": no steps to score after");
  if (plan.method == kNgp) return train_radiance_field(plan, views, seed, unfinished);
  if (plan.method == kReference) return train_reference(plan, views, start, seed, unfinished);
  if (plan.method == kOurs) return train_ours(plan, views, start, seed, unfinished);
  throw std::invalid_argument("method \"" + plan.method + "\" is not one of " + kReference + ", " +
                              kOurs + ", " + kNgp);
}

}  // namespace cousin
