#include "perception/splats/train_splats.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <stdexcept>

#include "perception/splats/splat_checkpoint_io.h"
#include "perception/splats/splat_trainer.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

/// Steps before training gives up on views that show nothing.
int patience(std::size_t views) { return 2 * static_cast<int>(views); }

bool any_weight(std::span<const SplatView> views) {
  return std::any_of(views.begin(), views.end(), [](const SplatView& view) {
    const Image<float>& weight = view.full.weight;
    return weight.empty() ||
           std::any_of(weight.begin(), weight.end(), [](float w) { return w > 0; });
  });
}

/// @throws std::invalid_argument naming the view, and what is wrong with it
void check_views(std::span<const SplatView> views) {
  for (std::size_t i = 0; i < views.size(); ++i) {
    const std::string name = "splat training: view " + std::to_string(i);
    const SplatViewLevel& level = views[i].full;
    if (level.color.channel[0].empty()) throw std::invalid_argument(name + ": has no image");
    try {
      splat_camera(level.camera, views[i].camera_from_world, Eigen::Vector3d::Zero(), 1);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(name + ": " + error.what());
    }
    check_sizes(level, name);
  }
}

SavedTraining read_training_of(const std::string& fingerprint, std::size_t views,
                               const std::filesystem::path& file, int most_splats) {
  SavedTraining saved = read_training(file, most_splats);
  if (saved.fingerprint == fingerprint && saved.state.near_m.size() == views) return saved;
  throw std::runtime_error(file.string() +
                           ": the checkpoint is of other views, start or configuration");
}

SavedTraining begin_or_go_on(std::span<const SplatView> views, const SplatModel& start,
                             const SplatTrainConfig& config, const SplatCheckpoint& checkpoint) {
  SavedTraining saved;
  if (checkpoint.file.empty()) {
    saved.state = start_training(start);
    return saved;
  }
  const std::string fingerprint = training_fingerprint(views, start, config);
  if (std::filesystem::exists(checkpoint.file)) {
    // One that cannot be read now may be read later: it is not begun anew.
    if (!std::ifstream(checkpoint.file, std::ios::binary))
      throw std::runtime_error(checkpoint.file.string() + ": the checkpoint cannot be read");
    try {
      SavedTraining kept =
          read_training_of(fingerprint, views.size(), checkpoint.file,
                           std::max(config.most_splats, static_cast<int>(start.splats.size())));
      if (checkpoint.most_steps == 0 || kept.state.step <= checkpoint.most_steps) return kept;
      throw std::runtime_error(checkpoint.file.string() + ": the checkpoint is of " +
                               std::to_string(kept.state.step) + " steps, beyond the " +
                               std::to_string(checkpoint.most_steps) + " that are asked for");
    } catch (const std::runtime_error&) {
      if (!checkpoint.replaces_other) throw;
    }
  }
  saved.fingerprint = fingerprint;
  saved.state = start_training(start);
  return saved;
}

SplatModel learned(const SplatTrainer& trainer, const SplatTrainConfig& config) {
  SplatModel model;
  model.sh_degree = config.sh_degree;
  model.low_pass_px2 = config.low_pass_px2;
  model.origin_in_world_m = trainer.state().origin_in_world_m;
  model.splats = to_splats(trainer.state().values);
  return model;
}

}  // namespace

std::string to_string(SplatTrainStatus status) {
  switch (status) {
    case SplatTrainStatus::ok:
      return "ok";
    case SplatTrainStatus::no_views:
      return "no_views";
    case SplatTrainStatus::no_start:
      return "no_start";
    case SplatTrainStatus::nothing_to_learn:
      return "nothing_to_learn";
    case SplatTrainStatus::nothing_seen:
      return "nothing_seen";
    case SplatTrainStatus::nothing_left:
      return "nothing_left";
    case SplatTrainStatus::not_finite:
      return "not_finite";
    case SplatTrainStatus::too_many_pairs:
      return "too_many_pairs";
    case SplatTrainStatus::stopped:
      return "stopped";
  }
  return "";
}

std::string explained(SplatTrainStatus status) {
  const auto meaning = [status]() -> const char* {
    switch (status) {
      case SplatTrainStatus::ok:
      case SplatTrainStatus::stopped:
        return "";
      case SplatTrainStatus::no_views:
        return ": no photograph has a pose";
      case SplatTrainStatus::no_start:
        return ": nothing to start from";
      case SplatTrainStatus::nothing_to_learn:
        return ": no pixel of any photograph counts";
      case SplatTrainStatus::nothing_seen:
        return ": no view shows any Gaussian, poses or start are wrong";
      case SplatTrainStatus::nothing_left:
        return ": no Gaussian that was shown is left, photographs show the background alone";
      case SplatTrainStatus::not_finite:
        return ": the loss was not a number";
      case SplatTrainStatus::too_many_pairs:
        return ": Gaussians cover more tiles of one view than can be listed; ask for fewer, or for "
               "smaller photographs";
    }
    return "";
  };
  return to_string(status) + meaning();
}

SplatTraining train_splats(std::span<const SplatView> views, const SplatModel& start,
                           const SplatTrainConfig& config, const SplatProgress& progress,
                           const SplatCheckpoint& checkpoint, const SplatSnapshots& snapshots) {
  validate(config);
  if (!checkpoint.file.empty() && checkpoint.every < 1) {
    throw std::invalid_argument("splat training: a checkpoint every " +
                                std::to_string(checkpoint.every) + " steps is not at least 1");
  }
  SplatTraining training;
  if (views.empty()) return training;
  check_views(views);
  SavedTraining saved = begin_or_go_on(views, start, config, checkpoint);
  training.curve = std::move(saved.curve);
  training.status = saved.state.values.size() == 0
                        ? saved.state.step == 0            ? SplatTrainStatus::no_start
                          : saved.blind < saved.state.step ? SplatTrainStatus::nothing_left
                                                           : SplatTrainStatus::nothing_seen
                    : any_weight(views) ? SplatTrainStatus::ok
                                        : SplatTrainStatus::nothing_to_learn;
  if (training.status != SplatTrainStatus::ok) return training;
  if (snapshots.begin && saved.state.step == 0) snapshots.begin();

  const SplatTrainPoint before = training.curve.empty() ? SplatTrainPoint{} : training.curve.back();
  SplatTrainer trainer(views, config, std::move(saved.state));
  double loss_sum = saved.loss_sum;
  int loss_count = saved.loss_count;
  int blind = saved.blind;
  StageTiming kept;  // what is not training: snapshots, checkpoints, who saw what
  const auto keeping = [&kept](const auto& keep) {
    const StageClock clock("kept");
    keep();
    const StageTiming took = clock.finish();
    kept.wall_s += took.wall_s;
    kept.cpu_s += took.cpu_s;
  };
  const auto point_now = [&](double loss) {
    return SplatTrainPoint{trainer.state().step, saved.wall_s + trainer.seconds().total,
                           saved.cpu_s + trainer.seconds().total_cpu, loss,
                           trainer.state().values.size()};
  };
  if (progress && before.step > 0 && before.step == trainer.state().step &&
      before.step < config.steps && !progress(before)) {
    training.status = SplatTrainStatus::stopped;
  }
  const auto judge = [&] {  // by what the views showed
    const int done = trainer.state().step;
    const auto all = static_cast<int>(views.size());
    // To the end, a round of all views that showed none says as much as the patience with them.
    const bool was_shown = blind < done;
    const bool gives_up =
        blind >= patience(views.size()) || (!was_shown && done == config.steps && done >= all);
    if (trainer.state().values.size() == 0 || gives_up)
      training.status = was_shown ? SplatTrainStatus::nothing_left : SplatTrainStatus::nothing_seen;
  };
  if (training.status == SplatTrainStatus::ok) judge();  // one that had ended says so again
  while (training.status == SplatTrainStatus::ok && trainer.state().step < config.steps) {
    SplatTrainer::Step step;
    try {
      step = trainer.step();
    } catch (const TooManyPairs&) {  // of what growth made, if it was due
      training.status = SplatTrainStatus::too_many_pairs;
      break;
    }
    const int done = trainer.state().step;
    blind = step.shown == 0 ? blind + 1 : 0;
    if (std::isfinite(step.loss))
      judge();
    else
      training.status = SplatTrainStatus::not_finite;
    if (snapshots.take && training.status == SplatTrainStatus::ok &&
        std::find(snapshots.at.begin(), snapshots.at.end(), done) != snapshots.at.end()) {
      keeping([&] { snapshots.take(point_now(step.loss), learned(trainer, config)); });
    }
    loss_sum += step.loss;
    ++loss_count;
    if (done % config.report_every == 0 || done == config.steps) {
      training.curve.push_back(point_now(loss_sum / loss_count));
      loss_sum = 0;
      loss_count = 0;
      if (progress && training.status == SplatTrainStatus::ok && !progress(training.curve.back()) &&
          done < config.steps) {
        training.status = SplatTrainStatus::stopped;
      }
    }
    const bool stops = training.status != SplatTrainStatus::ok;
    if (!checkpoint.file.empty() && training.status != SplatTrainStatus::not_finite &&
        (stops || done % checkpoint.every == 0 || done == config.steps)) {
      const SplatTrainPoint now = point_now(step.loss);
      keeping([&] {
        write_training(checkpoint.file, {saved.fingerprint, trainer.state(), training.curve,
                                         now.wall_s, now.cpu_s, loss_sum, loss_count, blind});
      });
    }
  }
  training.seconds = trainer.seconds();
  training.model = learned(trainer, config);
  keeping([&] {
    try {
      training.model.views_seen = trainer.views_seen();
    } catch (const TooManyPairs&) {  // of another view, or of what the last step made: not known
    }
  });
  training.seconds.kept = kept.wall_s;
  training.seconds.kept_cpu = kept.cpu_s;
  return training;
}

}  // namespace cousin
