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

/// Before the first step.
SplatTrainStatus status_at_start(const SavedTraining& saved, std::span<const SplatView> views) {
  if (saved.state.values.size() != 0)
    return any_weight(views) ? SplatTrainStatus::ok : SplatTrainStatus::nothing_to_learn;
  if (saved.state.step == 0) return SplatTrainStatus::no_start;
  return saved.blind < saved.state.step ? SplatTrainStatus::nothing_left
                                        : SplatTrainStatus::nothing_seen;
}

/// A training under way, which tells of itself and keeps itself.
class SplatTrainingRun {
 public:
  /// @param saved  what it begins with, without its curve, which is the training's
  SplatTrainingRun(std::span<const SplatView> views, const SplatTrainConfig& config,
                   const SplatProgress& progress, const SplatCheckpoint& checkpoint,
                   const SplatSnapshots& snapshots, SavedTraining saved, SplatTraining& training)
      : views_(views),
        config_(config),
        progress_(progress),
        checkpoint_(checkpoint),
        snapshots_(snapshots),
        trainer_(views, config, std::move(saved.state)),
        saved_(std::move(saved)),
        training_(training) {}

  /// Tells of the point that a training goes on from, if it is at one.
  void go_on() {
    const SplatTrainPoint before =
        training_.curve.empty() ? SplatTrainPoint{} : training_.curve.back();
    if (progress_ && before.step > 0 && before.step == trainer_.state().step &&
        before.step < config_.steps && !progress_(before)) {
      training_.status = SplatTrainStatus::stopped;
    }
    if (is_ok()) judge();  // one that had ended says so again
  }
  bool goes_on() const { return is_ok() && trainer_.state().step < config_.steps; }

  void step() {
    SplatTrainer::Step step;
    try {
      step = trainer_.step();
    } catch (const TooManyPairs&) {  // of what growth made, if it was due
      training_.status = SplatTrainStatus::too_many_pairs;
      return;
    }
    saved_.blind = step.shown == 0 ? saved_.blind + 1 : 0;
    if (std::isfinite(step.loss))
      judge();
    else
      training_.status = SplatTrainStatus::not_finite;
    take_snapshot(step.loss);
    add_to_curve(step.loss);
    write_checkpoint(step.loss);
  }

  void finish() {
    training_.seconds = trainer_.seconds();
    training_.model = learned(trainer_, config_);
    keeping([&] {
      try {
        training_.model.views_seen = trainer_.views_seen();
      } catch (const TooManyPairs&) {  // of another view, or of what the last step made: not known
      }
    });
    training_.seconds.kept = kept_.wall_s;
    training_.seconds.kept_cpu = kept_.cpu_s;
  }

 private:
  bool is_ok() const { return training_.status == SplatTrainStatus::ok; }

  template <class Keep>
  void keeping(const Keep& keep) {
    const StageClock clock("kept");
    keep();
    const StageTiming took = clock.finish();
    kept_.wall_s += took.wall_s;
    kept_.cpu_s += took.cpu_s;
  }

  SplatTrainPoint point_now(double loss) const {
    return SplatTrainPoint{trainer_.state().step, saved_.wall_s + trainer_.seconds().total,
                           saved_.cpu_s + trainer_.seconds().total_cpu, loss,
                           trainer_.state().values.size()};
  }

  /// By what the views showed.
  void judge() {
    const int done = trainer_.state().step;
    const auto all = static_cast<int>(views_.size());
    // To the end, a round of all views that showed none says as much as the patience with them.
    const bool was_shown = saved_.blind < done;
    const bool gives_up = saved_.blind >= patience(views_.size()) ||
                          (!was_shown && done == config_.steps && done >= all);
    if (trainer_.state().values.size() == 0 || gives_up)
      training_.status =
          was_shown ? SplatTrainStatus::nothing_left : SplatTrainStatus::nothing_seen;
  }

  void take_snapshot(double loss) {
    const std::vector<int>& at = snapshots_.at;
    if (snapshots_.take && is_ok() &&
        std::find(at.begin(), at.end(), trainer_.state().step) != at.end()) {
      keeping([&] { snapshots_.take(point_now(loss), learned(trainer_, config_)); });
    }
  }

  void add_to_curve(double loss) {
    const int done = trainer_.state().step;
    saved_.loss_sum += loss;
    ++saved_.loss_count;
    if (done % config_.report_every != 0 && done != config_.steps) return;
    training_.curve.push_back(point_now(saved_.loss_sum / saved_.loss_count));
    saved_.loss_sum = 0;
    saved_.loss_count = 0;
    if (progress_ && is_ok() && !progress_(training_.curve.back()) && done < config_.steps)
      training_.status = SplatTrainStatus::stopped;
  }

  void write_checkpoint(double loss) {
    const int done = trainer_.state().step;
    if (checkpoint_.file.empty() || training_.status == SplatTrainStatus::not_finite) return;
    if (is_ok() && done % checkpoint_.every != 0 && done != config_.steps) return;
    const SplatTrainPoint now = point_now(loss);
    keeping([&] {
      write_training(checkpoint_.file,
                     {saved_.fingerprint, trainer_.state(), training_.curve, now.wall_s, now.cpu_s,
                      saved_.loss_sum, saved_.loss_count, saved_.blind});
    });
  }

  std::span<const SplatView> views_;
  const SplatTrainConfig& config_;
  const SplatProgress& progress_;
  const SplatCheckpoint& checkpoint_;
  const SplatSnapshots& snapshots_;
  SplatTrainer trainer_;
  SavedTraining saved_;  ///< its state is the trainer's, its curve the training's
  SplatTraining& training_;
  StageTiming kept_;  ///< what is not training: snapshots, checkpoints, who saw what
};

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
  training.status = status_at_start(saved, views);
  if (training.status != SplatTrainStatus::ok) return training;
  if (snapshots.begin && saved.state.step == 0) snapshots.begin();
  SplatTrainingRun run(views, config, progress, checkpoint, snapshots, std::move(saved), training);
  run.go_on();
  while (run.goes_on()) run.step();
  run.finish();
  return training;
}

}  // namespace cousin
