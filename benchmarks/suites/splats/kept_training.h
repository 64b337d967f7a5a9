#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "perception/ngp/ngp.h"
#include "perception/splats/train_splats.h"
#include "sim/types/seams.h"

namespace cousin {

/// What a training had learned after some of its steps.
template <class Model>
struct Kept {
  int step = 0;
  StageTiming seconds;  ///< of all steps to here, and the process's memory when it was taken
  Model model;
};
using KeptModel = Kept<SplatModel>;  ///< without `views_seen`
using KeptField = Kept<NgpModel>;

/// Keeps a training and the models that are taken on its way in a folder, so that one that was
/// stopped goes on in a later process and has the models of both; in memory where there is no
/// folder, for this process alone. Models are the same bytes either way.
class KeptTraining {
 public:
  /// @param folder  of this training alone, made where it is missing; empty: memory
  explicit KeptTraining(std::filesystem::path folder);

  /// None where there is no folder. What is of another training is replaced.
  SplatCheckpoint checkpoint() const;
  /// Keeps the model after each of `at` steps.
  SplatSnapshots snapshots(std::vector<int> at) const;
  /// Those of `at` that were taken, in that order, once the training has ended.
  /// @param at  rising
  /// @throws std::runtime_error if a file is damaged, or missing where a later one is there
  std::vector<KeptModel> models(const std::vector<int>& at) const;

 private:
  std::filesystem::path folder_;
  std::shared_ptr<std::vector<KeptModel>> in_memory_;
};

/// The same for a radiance field.
class KeptFieldTraining {
 public:
  explicit KeptFieldTraining(std::filesystem::path folder);

  NgpCheckpoint checkpoint() const;
  NgpSnapshots snapshots(std::vector<int> at) const;
  std::vector<KeptField> models(const std::vector<int>& at) const;

 private:
  std::filesystem::path folder_;
  std::shared_ptr<std::vector<KeptField>> in_memory_;
};

}  // namespace cousin
