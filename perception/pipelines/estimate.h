#pragma once

#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "perception/splats/splat_model.h"
#include "sim/types/capture.h"
#include "sim/types/seams.h"
#include "sim/types/tracks.h"

namespace cousin {

/// One member a stage of any pipeline, in the form that `Of` gives to its seam.
template <template <class Seam> class Of>
struct SeamsOf {
  Of<Corners> corners;
  Of<Poses> poses;
  Of<SplatModel> splats;
  Of<Boxes> boxes;
  Of<Keypoints> keypoints;
  Of<Depths> depths;
  Of<Cloud> cloud;
  Of<Clusters> clusters;
  Of<Silhouettes> silhouettes;
  Of<Fits> fits;
  Of<Tracks> tracks;
  Of<Surfaces> surfaces;
  Of<Traits> traits;
};

/// Sentences of stages for whoever took the capture: what is doubted, or used in part.
using StageNotes = std::vector<std::string>;

template <class Seam>
using Made = Seam;
/// Everything between a capture and its traits: what the stages of a pipeline made, the seams of
/// stages that there are not being empty.
struct Estimate : SeamsOf<Made> {
  std::vector<StageTiming> timings;
  /// Stages, which read an estimate, add to them.
  std::shared_ptr<StageNotes> notes = std::make_shared<StageNotes>();
};

/// Makes one seam of the capture and all earlier results.
template <class Seam>
using Stage = std::function<Seam(const Capture&, const Estimate&)>;
/// The stages of a pipeline; those that it has not are null. Any may be replaced by files, a
/// program or truth (stage_table.h).
struct Stages : SeamsOf<Stage> {};

/// Names of stages in the order in which a pipeline runs them.
using StageOrder = std::span<const std::string_view>;

/// A stage failed: ours, a user's program, or a file that does not fit. Nested: the cause.
class StageError : public std::runtime_error {
 public:
  StageError(const std::string& stage_name, const std::string& what);
  std::string stage;
};

/// Called before and after each stage, for progress and for writing seams as soon as they exist.
using StageObserver = std::function<void(std::string_view stage, bool finished, const Estimate&)>;

/// Runs those of the stages that there are, in this order.
/// @throws StageError; std::invalid_argument without frames, or for a name that is of no stage
Estimate run_stages(const Capture& capture, const Stages& stages, StageOrder order,
                    const StageObserver& observer = {});

}  // namespace cousin
