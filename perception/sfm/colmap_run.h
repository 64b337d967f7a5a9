#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "perception/sfm/colmap_database.h"
#include "perception/sfm/image_pairs.h"
#include "perception/sfm/sfm_model.h"
#include "sim/config/fields.h"
#include "sim/types/camera.h"
#include "sim/types/image.h"
#include "sim/types/seams.h"

namespace cousin {

/// What COLMAP does with the lens. `given`: stays as given; `focal`: its focal length is refined;
/// `self`: nothing is given, COLMAP's own start and its SIMPLE_RADIAL lens, all refined.
enum class ColmapLens { given, focal, self };
std::string_view to_string(ColmapLens lens);

struct ColmapConfig {
  std::string program = "colmap";  ///< a name in PATH, or a file
  /// Where its files are kept; a run that was stopped goes on there, one of other images starts
  /// anew. A folder with a database, images or models that no run of ours wrote is refused.
  /// "": a scratch folder.
  std::string folder;
  ColmapLens lens = ColmapLens::focal;
  bool lens_per_image = false;  ///< else all images share one
  int threads = 1;              ///< COLMAP's models vary with it
  int max_features = 8192;      ///< of an image
  /// Where images find no place they are matched with all others, and mapping starts again; the
  /// larger model counts.
  bool match_lost = true;
  double time_limit_s = 3600;  ///< of all steps together
};
Fields fields(ColmapConfig& config);
void validate(const ColmapConfig& config);

/// `not_built`: the program is not there. `no_model`: no two images show enough of the same.
/// `no_lens`: every model's lens, as COLMAP calibrated it, is none (it folds inside the image).
enum class ColmapStatus {
  ok,
  too_few_images,
  not_built,
  program_failed,
  timed_out,
  no_model,
  no_lens
};
std::string_view to_string(ColmapStatus status);

struct ColmapInput {
  std::vector<const Image<Rgb8>*> images;  ///< in the order they were taken; of one size
  std::optional<Camera> lens;              ///< must be there unless ColmapLens::self
  std::vector<ImagePair> pairs;
};

struct ColmapRun {
  ColmapStatus status = ColmapStatus::not_built;
  std::string
      reason;  ///< unless ok: what and why; if ok: why lost images stay lost, models left out
  std::string version;               ///< "3.8"
  SfmModel model;                    ///< the one of most images
  std::vector<int> model_sizes;      ///< images of each, descending
  std::vector<ImageMatches> images;  ///< features and matches of each; empty: there were none
  std::vector<StageTiming> timings;  ///< of each step; also of one found done
  StageTiming done_before;           ///< seconds of those found done, together
  bool resumed = false;              ///< some step was found done
};

/// Sparse reconstruction by COLMAP (3.8; CPU): features, the pairs given, incremental mapping.
/// Called with words, never through a shell; its logs stay in the folder. Models vary from run to
/// run, on one thread too; in a folder that is kept, finished steps are taken as they are.
/// @throws std::invalid_argument for an invalid config, images without pixels or of another size
/// than the first or the lens, a lens that COLMAP does not have, or a pair that does not exist;
/// std::runtime_error if the folder cannot be written or a model is malformed.
ColmapRun run_colmap(const ColmapInput& input, const ColmapConfig& config = {});

/// Version that the program states; "" if it is not there or states none.
std::string colmap_version(const std::string& program = "colmap");

}  // namespace cousin
