#pragma once

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scenes/row/rest_store.h"
#include "scenes/row/rig_eye.h"
#include "scenes/row/scene_text.h"
#include "sim/config/cousin.h"
#include "sim/config/fields.h"
#include "sim/render/path_tracer.h"
#include "sim/truth/scene.h"
#include "sim/types/rng.h"

namespace cousin {

struct SceneRow;

/// What a scene may know of the rig that takes it.
struct RigSight {
  RigEye eye;            ///< of its first images
  double readout_s = 0;  ///< of its cameras, the longest
};

/// Which scene of a run is built.
struct SceneBuild {
  std::uint64_t seed = 0;
  int index = 0;
  const RestStore* rests = nullptr;  ///< null: nothing is kept
  Environment (*read_environment)(const std::filesystem::path& file, double scale) = nullptr;

  /// The stream of this scene alone.
  Rng rng() const { return Rng(seed).fork("scene").fork(static_cast<std::uint64_t>(index)); }
};

/// A file of the user's that a scene is made from.
struct UserFile {
  std::string setting;  ///< as the user wrote it: `mesh = "pot.obj"`
  std::string path;
  bool is_mesh = false;
};

/// Whether physics runs, and what for or why not; and whether anything moves while pictures are
/// taken.
struct PhysicsUse {
  bool runs = false;
  std::string why;
  bool moves = false;
};

// ---- What a scene's configuration may have beside it; these are of one that says nothing --------

/// Tells it of the rig: views of a board are planned in the picture.
template <class Config>
void see(Config& /*config*/, const RigSight& /*sight*/) {}
/// Names of the plants in scene `index` that other scenes of the run may show too.
template <class Config>
std::vector<std::string> shared_plants(const Config& /*config*/, int /*index*/) {
  return {};
}
/// Whether scenes of a run are one thing on one day after another: they are one cousin.
template <class Config>
bool is_series(const Config& /*config*/) {
  return false;
}
template <class Config>
std::vector<UserFile> user_files(const Config& /*config*/) {
  return {};
}
/// All that Instance::category may be of its specimens, whether a scene shows one or not.
template <class Config>
std::vector<std::string> specimen_categories(const Config& /*config*/) {
  return {};
}
/// The key `cache`; null: the scene keeps nothing.
template <class Config>
std::string* cache_folder(Config& /*config*/) {
  return nullptr;
}
template <class Config>
PhysicsUse physics_of(const Config& config) {
  if constexpr (requires { is_still(config.motion); }) {
    if (!is_still(config.motion)) return {true, "plants move in the wind or under a hand", true};
  }
  return {false, "nothing settles or moves by force"};
}
/// @throws std::invalid_argument for an axis that this configuration cannot move, and why
template <class Config>
void check_movable(const Config& /*config*/, const CousinDistance& /*distance*/) {}

/// The configuration of any scene. Its type has members `views` and `rig`, and beside it fields(),
/// validate(), build_scene() and row_of(); and where the above do not do, those.
class SceneConfig {
 public:
  /// Explicit: else a scene without its own validate() would find the one of any scene.
  template <class Config>
  requires requires(Config c) {
    c.rig;
    c.views;
  }
  explicit SceneConfig(Config config) : own_(std::make_unique<Of<Config>>(std::move(config))) {}
  SceneConfig(const SceneConfig& other) : own_(other.own_->copy()) {}
  SceneConfig(SceneConfig&&) noexcept = default;
  SceneConfig& operator=(SceneConfig other) noexcept {
    own_ = std::move(other.own_);
    return *this;
  }
  ~SceneConfig() = default;

  /// Null if it is another scene's.
  template <class Config>
  Config* get_if() {
    auto* const own = dynamic_cast<Of<Config>*>(own_.get());
    return own ? &own->config : nullptr;
  }
  template <class Config>
  const Config* get_if() const {
    const auto* const own = dynamic_cast<const Of<Config>*>(own_.get());
    return own ? &own->config : nullptr;
  }

  std::string& rig() { return own_->rig(); }  ///< name of its preset
  const std::string& rig() const { return own_->rig(); }
  int views() const { return own_->views(); }

 private:
  struct Any {
    virtual ~Any() = default;
    virtual std::unique_ptr<Any> copy() const = 0;
    virtual std::string& rig() = 0;
    virtual int views() const = 0;
    virtual Fields keys() = 0;
    virtual void check() const = 0;
    virtual void look(const RigSight& sight) = 0;
    virtual Scene build(const SceneBuild& which) const = 0;
    virtual std::vector<std::string> shared(int index) const = 0;
    virtual bool series() const = 0;
    virtual std::vector<UserFile> files() const = 0;
    virtual std::vector<std::string> categories() const = 0;
    virtual std::string* cache() = 0;
    virtual PhysicsUse physics() const = 0;
    virtual void movable(const CousinDistance& distance) const = 0;
    virtual const SceneRow& row() const = 0;
  };
  template <class Config>
  struct Of final : Any {
    explicit Of(Config own) : config(std::move(own)) {}
    std::unique_ptr<Any> copy() const override { return std::make_unique<Of>(*this); }
    std::string& rig() override { return config.rig; }
    int views() const override { return config.views; }
    Fields keys() override { return fields(config); }
    void check() const override { validate(config); }
    void look(const RigSight& sight) override { see(config, sight); }
    Scene build(const SceneBuild& which) const override { return build_scene(config, which); }
    std::vector<std::string> shared(int index) const override {
      return shared_plants(config, index);
    }
    bool series() const override { return is_series(config); }
    std::vector<UserFile> files() const override { return user_files(config); }
    std::vector<std::string> categories() const override { return specimen_categories(config); }
    std::string* cache() override { return cache_folder(config); }
    PhysicsUse physics() const override { return physics_of(config); }
    void movable(const CousinDistance& distance) const override { check_movable(config, distance); }
    const SceneRow& row() const override { return row_of(config); }
    Config config;
  };
  std::unique_ptr<Any> own_;

  friend Fields fields(SceneConfig& config);
  friend void validate(const SceneConfig& config);
  friend void see(SceneConfig& config, const RigSight& sight);
  friend Scene build_scene(const SceneConfig& config, const SceneBuild& which);
  friend std::vector<std::string> shared_plants(const SceneConfig& config, int index);
  friend bool is_series(const SceneConfig& config);
  friend std::vector<UserFile> user_files(const SceneConfig& config);
  friend std::vector<std::string> specimen_categories(const SceneConfig& config);
  friend std::string* cache_folder(SceneConfig& config);
  friend PhysicsUse physics_of(const SceneConfig& config);
  friend void check_movable(const SceneConfig& config, const CousinDistance& distance);
  friend const SceneRow& row_of(const SceneConfig& config);
};

/// Its keys; they point into it. Not `cache`, which is of the machine.
Fields fields(SceneConfig& config);
/// @throws std::invalid_argument naming key, value and limit.
void validate(const SceneConfig& config);
void see(SceneConfig& config, const RigSight& sight);
/// @throws std::runtime_error naming a user's file and what is wrong with it.
Scene build_scene(const SceneConfig& config, const SceneBuild& which);
std::vector<std::string> shared_plants(const SceneConfig& config, int index);
bool is_series(const SceneConfig& config);
std::vector<UserFile> user_files(const SceneConfig& config);
/// Sorted, each once.
std::vector<std::string> specimen_categories(const SceneConfig& config);
std::string* cache_folder(SceneConfig& config);
PhysicsUse physics_of(const SceneConfig& config);
void check_movable(const SceneConfig& config, const CousinDistance& distance);
const SceneRow& row_of(const SceneConfig& config);

inline constexpr std::string_view kLeavesLetLightThrough =
    "leaves let light through, so it is not cached";

/// A scene. To add one, write scenes/NAME with its text and row, and add both to
/// benchmarks/loop/scene_list.h and its folder to the root's COUSIN_SCENES.
struct SceneRow {
  SceneText text;
  std::string_view shows =
      "what is photographed, with its exact measures, and what it stands in";  ///< for the plan
  /// Why light is traced path by path; empty: it is still and matt, so the light cache does too.
  std::string_view why_paths;
  PathConfig paths = {.pixel_samples = 16};  ///< by default
  double metered_m = 0;  ///< a rig exposes for what is this near its target; 0: for the picture
  const std::vector<CousinMove>& (*cousin_moves)() = nullptr;  ///< null: it has no cousins
  SceneConfig (*defaults)() = nullptr;
};

}  // namespace cousin
