#include "perception/sfm/colmap_run.h"

#include <algorithm>
#include <array>
#include <functional>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "perception/sfm/colmap_files.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/colmap_model.h"
#include "sim/dataset/manifest.h"
#include "sim/imaging/image_io.h"
#include "sim/process/program_run.h"
#include "sim/process/scratch_folder.h"
#include "sim/types/whole_file.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

using Words = std::vector<std::string>;
void check_input(const ColmapInput& input, const ColmapConfig& config) {
  const auto count = static_cast<int>(input.images.size());
  for (int i = 0; i < count; ++i) {
    const Image<Rgb8>* image = input.images[static_cast<std::size_t>(i)];
    if (image == nullptr || image->empty())
      throw std::invalid_argument("run_colmap: image " + std::to_string(i) + " has no pixels");
    const Image<Rgb8>& first = *input.images.front();
    if (image->width() == first.width() && image->height() == first.height()) continue;
    throw std::invalid_argument("run_colmap: image " + std::to_string(i) + " has " +
                                std::to_string(image->width()) + " x " +
                                std::to_string(image->height()) + " pixels, the first " +
                                std::to_string(first.width()) + " x " +
                                std::to_string(first.height()) + "; all must have one size");
  }
  if (input.lens && count > 0 &&
      (input.lens->width_px != input.images.front()->width() ||
       input.lens->height_px != input.images.front()->height())) {
    throw std::invalid_argument("run_colmap: the lens is of " +
                                std::to_string(input.lens->width_px) + " x " +
                                std::to_string(input.lens->height_px) + " pixels, the images of " +
                                std::to_string(input.images.front()->width()) + " x " +
                                std::to_string(input.images.front()->height()));
  }
  for (const ImagePair& pair : input.pairs) {
    if (pair[0] >= 0 && pair[0] < pair[1] && pair[1] < count) continue;
    throw std::invalid_argument("run_colmap: the pair " + std::to_string(pair[0]) + ", " +
                                std::to_string(pair[1]) + " is not two of " +
                                std::to_string(count) + " images in order");
  }
  if (config.lens != ColmapLens::self && !input.lens)
    throw std::invalid_argument("run_colmap: no lens is given, and the config asks for one");
}

/// COLMAP's words for the lens given: its model and its parameters, pixels from the corner.
Words lens_words(const ColmapInput& input, const ColmapConfig& config) {
  Words words = {config.lens_per_image ? "--ImageReader.single_camera_per_image"
                                       : "--ImageReader.single_camera",
                 "1", "--ImageReader.camera_model"};
  if (config.lens == ColmapLens::self) {
    words.emplace_back("SIMPLE_RADIAL");
    return words;
  }
  ColmapModel model;
  model.cameras[1] = *input.lens;
  // The line "1 OPENCV 640 480 500 500 ..." after the file's head.
  const std::string text = colmap_text(model).cameras;
  std::istringstream line(text.substr(text.find('\n') + 1));
  std::string skipped, parameters;
  line >> skipped >> words.emplace_back() >> skipped >> skipped;
  for (std::string number; line >> number;) parameters += (parameters.empty() ? "" : ",") + number;
  words.insert(words.end(), {"--ImageReader.camera_params", parameters});
  return words;
}

std::string images_hash(const ColmapInput& input) {
  std::string hashes;
  for (const Image<Rgb8>* image : input.images) {
    const std::string_view pixels(reinterpret_cast<const char*>(image->data()),
                                  image->size() * sizeof(Rgb8));
    hashes += std::to_string(image->width()) + "x" + std::to_string(image->height()) + " " +
              sha256_hex(pixels) + "\n";
  }
  return sha256_hex(hashes);
}

bool holds(const fs::path& file, const std::string& text) {
  return fs::exists(file) && read_file(file) == text;
}

/// One run in its folder: the steps that are done, what is left of the time.
class Steps {
 public:
  /// @param key  of everything that the first step starts from
  Steps(std::string key, double time_limit_s, fs::path folder, ColmapRun& run)
      : key_(std::move(key)), left_s_(time_limit_s), folder_(std::move(folder)), run_(run) {}

  /// Runs `words` unless `name` was done by the same; what it leaves behind stays in the folder.
  /// @returns false if it failed; then the run says why.
  bool run(const std::string& name, const Words& words, const std::function<void()>& prepare) {
    key_ = sha256_hex(key_ + "\n" + name + "\n" + joined(words));
    const fs::path done = folder_ / (name + ".done"), log = folder_ / (name + ".log");
    if (const std::optional<StageTiming> earlier = done_before(done)) {
      run_.resumed = true;
      run_.timings.push_back({.stage = name, .wall_s = earlier->wall_s, .cpu_s = earlier->cpu_s});
      run_.done_before.wall_s += earlier->wall_s;
      run_.done_before.cpu_s += earlier->cpu_s;
      return true;
    }
    fs::remove(done);
    prepare();
    const ProgramOutcome outcome = run_program({.words = words,
                                                .environment = {{"QT_QPA_PLATFORM", "offscreen"}},
                                                .log = log,
                                                .time_limit_s = std::max(left_s_, 1e-3)});
    left_s_ -= outcome.wall_s;
    run_.timings.push_back({.stage = name, .wall_s = outcome.wall_s, .cpu_s = outcome.cpu_s});
    if (succeeded(outcome)) {
      std::ostringstream text;
      text << key_ << "\n" << outcome.wall_s << " " << outcome.cpu_s << "\n";
      write_file(done, text.str());
      return true;
    }
    run_.reason = name + ": " + outcome.reason;
    switch (outcome.end) {
      case ProgramEnd::not_started:
        run_.status = ColmapStatus::not_built;
        break;
      case ProgramEnd::timed_out:
        run_.status = ColmapStatus::timed_out;
        break;
      case ProgramEnd::exited:
      case ProgramEnd::signalled:
        run_.status = ColmapStatus::program_failed;
        run_.reason += "; " + log.string() + " ends with" + last_lines(log);
    }
    return false;
  }

 private:
  /// The seconds that the step took, if this very step was done before.
  std::optional<StageTiming> done_before(const fs::path& done) const {
    if (!fs::exists(done)) return {};
    std::istringstream text(read_file(done, 1000));
    std::string key;
    StageTiming timing;
    if (!(text >> key >> timing.wall_s >> timing.cpu_s) || key != key_) return {};
    return timing;
  }
  static std::string joined(const Words& words) {
    std::string text;
    for (const std::string& word : words) text += word + '\0';
    return text;
  }

  std::string key_;
  double left_s_;
  fs::path folder_;
  ColmapRun& run_;
};

void write_images(const ColmapInput& input, const fs::path& folder) {
  for (std::size_t i = 0; i < input.images.size(); ++i)
    write_png(folder / colmap_image_name(static_cast<int>(i)), *input.images[i]);
}

constexpr std::array kDatabaseFiles = {"database.db", "database.db-shm", "database.db-wal"};
constexpr std::array kRunFolders = {"images", "sparse", "sparse_lost"};
constexpr std::array kRunSteps = {"features", "matches", "mapping", "matches_lost", "mapping_lost"};

void remove_database(const fs::path& folder) {
  for (const char* name : kDatabaseFiles) fs::remove(folder / name);
}

/// A folder without our key is somebody's own: what is there is not ours to remove.
/// @throws std::invalid_argument if it holds what a run would write over.
void refuse_foreign_folder(const fs::path& folder) {
  const auto refuse = [&](const std::string& name) {
    if (!fs::exists(fs::symlink_status(folder / name))) return;
    throw std::invalid_argument("colmap.folder: " + (folder / name).string() +
                                " is there, and no database.key of a run of ours beside it; "
                                "name an empty or a new folder");
  };
  for (const char* name : kDatabaseFiles) refuse(name);
  for (const char* name : kRunFolders) refuse(name);
  for (const char* name : {"pairs.txt", "pairs_lost.txt"}) refuse(name);
  for (const std::string step : kRunSteps) {
    refuse(step + ".log");
    refuse(step + ".done");
  }
}

/// Features and matches are in one database: what it was made of is written beside it, before
/// anything else, and a database of something else goes with all that came of it.
void keep_database_of(const std::string& key, const fs::path& folder) {
  if (!fs::exists(folder / "database.key")) refuse_foreign_folder(folder);
  own_all_in(folder);  // COLMAP's files too
  if (holds(folder / "database.key", key)) return;
  remove_database(folder);
  for (const std::string step : kRunSteps) fs::remove(folder / (step + ".done"));
  for (const char* name : kRunFolders) fs::remove_all(folder / name);
  write_file(folder / "database.key", key);
}

Words extraction_words(const ColmapInput& input, const ColmapConfig& config,
                       const fs::path& folder) {
  Words words = {config.program,
                 "feature_extractor",
                 "--random_seed",
                 "0",
                 "--database_path",
                 (folder / "database.db").string(),
                 "--image_path",
                 (folder / "images").string(),
                 "--SiftExtraction.use_gpu",
                 "0",
                 "--SiftExtraction.num_threads",
                 std::to_string(config.threads),
                 "--SiftExtraction.max_num_features",
                 std::to_string(config.max_features)};
  const Words lens = lens_words(input, config);
  words.insert(words.end(), lens.begin(), lens.end());
  return words;
}

/// @param list  name of the file of pairs
Words matching_words(const ColmapConfig& config, const fs::path& folder, const char* list) {
  return {config.program,
          "matches_importer",
          "--random_seed",
          "0",
          "--database_path",
          (folder / "database.db").string(),
          "--match_list_path",
          (folder / list).string(),
          "--match_type",
          "pairs",
          "--SiftMatching.use_gpu",
          "0",
          "--SiftMatching.num_threads",
          std::to_string(config.threads)};
}

/// @param models  name of the folder that they go to
Words mapping_words(const ColmapConfig& config, const fs::path& folder, const char* models) {
  return {config.program,
          "mapper",
          "--random_seed",
          "0",
          "--database_path",
          (folder / "database.db").string(),
          "--image_path",
          (folder / "images").string(),
          "--output_path",
          (folder / models).string(),
          "--Mapper.num_threads",
          std::to_string(config.threads),
          "--Mapper.min_model_size",
          "3",
          "--Mapper.extract_colors",
          "1",
          "--Mapper.ba_refine_focal_length",
          config.lens == ColmapLens::given ? "0" : "1",
          "--Mapper.ba_refine_extra_params",
          config.lens == ColmapLens::self ? "1" : "0"};
}

void empty_folder(const fs::path& folder) {
  fs::remove_all(folder);
  fs::create_directories(folder);
}

/// What of the images and words a run in `folder` depends on; a folder of another run is emptied.
/// What is done with the lens is part of it: mapping anew would find the matches of lost images
/// too.
std::string prepared_key(const ColmapInput& input, const ColmapConfig& config,
                         const Words& extraction, const fs::path& folder,
                         const std::string& version) {
  std::string key = version + "\n" + images_hash(input) + "\n" + match_list(input.pairs) + "\n" +
                    std::string(to_string(config.lens));
  for (const std::string& word : extraction) key += "\n" + word;
  key = sha256_hex(key);
  keep_database_of(key, folder);
  return key;
}

/// @returns whether all steps are done; if not, the run says why.
bool map_pairs(const ColmapInput& input, const ColmapConfig& config, const Words& extraction,
               const fs::path& folder, Steps& steps, ColmapRun& run) {
  const bool matched = steps.run("features", extraction, [&] {
    // One that was stopped left a camera, and perhaps features, in its database.
    remove_database(folder);
    write_images(input, folder / "images");
    write_file(folder / "pairs.txt", match_list(input.pairs));
  }) && steps.run("matches", matching_words(config, folder, "pairs.txt"), [] {});
  if (!matched) return false;
  const bool mapped = steps.run("mapping", mapping_words(config, folder, "sparse"), [&] {
    empty_folder(folder / "sparse");
    // Which images are lost is this step's outcome.
    for (const char* name : {"matches_lost.done", "mapping_lost.done"}) fs::remove(folder / name);
  });
  // COLMAP ends with an error where it finds nothing to start from.
  if (!mapped && run.status == ColmapStatus::program_failed &&
      last_lines(folder / "mapping.log").find("failed to create sparse model") !=
          std::string::npos) {
    run.status = ColmapStatus::no_model;
    run.reason =
        "COLMAP found no two images that show enough of the same; images taken closer together do";
  }
  return mapped;
}

/// Matches images without a place with all others and maps again. @returns as map_pairs
bool map_lost(const std::vector<ImagePair>& pairs, const ColmapConfig& config,
              const fs::path& folder, Steps& steps) {
  return steps.run("matches_lost", matching_words(config, folder, "pairs_lost.txt"), [&] {
    write_file(folder / "pairs_lost.txt", match_list(pairs));
  }) && steps.run("mapping_lost", mapping_words(config, folder, "sparse_lost"), [&] {
    empty_folder(folder / "sparse_lost");
  });
}

/// Tries again where the largest model lacks images; if that places more, its models are `found`.
/// @returns false if a step of it failed; then the run says why.
bool map_with_lost(const ColmapInput& input, const ColmapConfig& config, const fs::path& folder,
                   Steps& steps, SfmModels& found) {
  std::vector<SfmModel>& models = found.models;
  if (models.empty()) return true;
  const auto images = static_cast<int>(input.images.size());
  const std::vector<ImagePair> pairs = pairs_of_lost(images, models.front().images, input.pairs);
  if (pairs.empty()) return true;
  // A second try that fails, which the reason tells, costs nothing of what the first found.
  if (!map_lost(pairs, config, folder, steps)) return false;
  SfmModels again = read_models(folder / "sparse_lost", images);
  found.bent.insert(found.bent.end(), again.bent.begin(), again.bent.end());
  if (!again.models.empty() && again.models.front().images.size() > models.front().images.size())
    models = std::move(again.models);
  return true;
}

/// Why models that mapping left are left out.
std::string bent_text(const std::vector<std::string>& bent) {
  constexpr std::size_t kMostNamed = 3;
  std::string text = "the images do not fix the lens that COLMAP calibrated, of " +
                     std::to_string(bent.size()) + (bent.size() == 1 ? " model" : " models");
  for (std::size_t i = 0; i < std::min(bent.size(), kMostNamed); ++i) text += "; " + bent[i];
  return text;
}

/// Features and matches of the images; why there are none, if the database cannot be read.
void take_database(const fs::path& folder, int images, ColmapRun& run) {
  const fs::path file = folder / "database.db";
  if (!fs::exists(file) || fs::file_size(file) == 0) return;
  ColmapDatabase database = read_colmap_database(file, images);
  run.images = std::move(database.images);
  if (database.complaint.empty()) return;
  run.reason += (run.reason.empty() ? "" : "; ") + database.complaint;
}

}  // namespace

ColmapRun run_colmap(const ColmapInput& input, const ColmapConfig& config) {
  validate(config);
  check_input(input, config);
  ColmapRun run;
  if (input.images.size() < 2 || input.pairs.empty()) {
    run.status = ColmapStatus::too_few_images;
    run.reason = std::to_string(input.images.size()) + " images and " +
                 std::to_string(input.pairs.size()) + " pairs of them; at least 2 and 1";
    return run;
  }
  if (find_program(config.program).empty()) {
    run.reason = "COLMAP was not found: there is no program \"" + config.program +
                 "\" (Debian's package: colmap)";
    return run;
  }
  run.version = colmap_version(config.program);
  if (run.version.empty()) {
    run.status = ColmapStatus::program_failed;
    run.reason = "\"" + config.program + "\" does not say its version as COLMAP does";
    return run;
  }
  std::optional<ScratchFolder> scratch;
  if (config.folder.empty()) scratch.emplace("cousin-colmap");
  const fs::path folder = fs::absolute(scratch ? scratch->path() : fs::path(config.folder));
  fs::create_directories(folder);
  const Words extraction = extraction_words(input, config, folder);
  const std::string key = prepared_key(input, config, extraction, folder, run.version);
  Steps steps(key, config.time_limit_s, folder, run);
  const auto images = static_cast<int>(input.images.size());
  if (!map_pairs(input, config, extraction, folder, steps, run)) {
    if (run.status == ColmapStatus::no_model) take_database(folder, images, run);
    return run;
  }
  SfmModels found = read_models(folder / "sparse", images);
  std::vector<SfmModel>& models = found.models;
  // A database that a step was stopped in may be anything.
  const bool is_whole = !config.match_lost || map_with_lost(input, config, folder, steps, found);
  if (models.empty()) {
    run.status = found.bent.empty() ? ColmapStatus::no_model : ColmapStatus::no_lens;
    run.reason = found.bent.empty() ? "COLMAP left no model" : bent_text(found.bent);
    fs::remove(folder / "mapping.done");  // another try may end well
    take_database(folder, images, run);
    return run;
  }
  for (const SfmModel& model : models)
    run.model_sizes.push_back(static_cast<int>(model.images.size()));
  run.model = std::move(models.front());
  run.status = ColmapStatus::ok;
  if (!found.bent.empty()) run.reason += (run.reason.empty() ? "" : "; ") + bent_text(found.bent);
  if (is_whole) take_database(folder, images, run);
  return run;
}

}  // namespace cousin
