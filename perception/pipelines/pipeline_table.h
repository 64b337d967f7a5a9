#pragma once

#include <concepts>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "perception/pipelines/estimate.h"
#include "perception/pipelines/pipeline_needs.h"
#include "perception/pipelines/seeds_splats.h"
#include "sim/config/fields.h"
#include "sim/types/capture.h"

namespace cousin {

struct PipelineRow;

// ---- What a pipeline's configuration may have beside it; these are of one that says nothing -----

/// Whether the stage poses asks structure from motion.
template <class Config>
bool needs_sfm(const Capture& /*capture*/, const Config& /*config*/) {
  return false;
}
/// @throws std::invalid_argument naming what the capture lacks, before any work
template <class Config>
void check_capture(const Capture& /*capture*/, const Config& /*config*/) {}
/// A sentence for each setting that has no effect.
template <class Config>
std::vector<std::string> unused_settings(const Config& /*config*/) {
  return {};
}

/// The configuration of any pipeline. Its type has beside it fields(), validate(), to_string() of
/// its `method`, needs(), stages_for() and row_of(); and where the above do not do, those.
class PipelineConfig {
 public:
  template <class Config>
  requires(!std::same_as<Config, PipelineConfig>) PipelineConfig(Config config)
      : own_(std::make_unique<Of<Config>>(std::move(config))) {}
  PipelineConfig(const PipelineConfig& other) : own_(other.own_->copy()) {}
  PipelineConfig(PipelineConfig&&) noexcept = default;
  PipelineConfig& operator=(PipelineConfig other) noexcept {
    own_ = std::move(other.own_);
    return *this;
  }
  ~PipelineConfig() = default;

  /// Null if it is another pipeline's.
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

 private:
  struct Any {
    virtual ~Any() = default;
    virtual std::unique_ptr<Any> copy() const = 0;
    virtual Fields keys() = 0;
    virtual void check() const = 0;
    virtual std::string_view method() const = 0;
    virtual PipelineNeeds reads() const = 0;
    virtual bool asks_sfm(const Capture& capture) const = 0;
    virtual void check_images(const Capture& capture) const = 0;
    virtual std::vector<std::string> unused() const = 0;
    virtual Stages make(const Capture& capture, std::uint64_t seed,
                        const SplatWatch& watch) const = 0;
    virtual const PipelineRow& row() const = 0;
  };
  template <class Config>
  struct Of final : Any {
    explicit Of(Config own) : config(std::move(own)) {}
    std::unique_ptr<Any> copy() const override { return std::make_unique<Of>(*this); }
    Fields keys() override { return fields(config); }
    void check() const override { validate(config); }
    std::string_view method() const override { return to_string(config.method); }
    PipelineNeeds reads() const override { return needs(config); }
    bool asks_sfm(const Capture& capture) const override { return needs_sfm(capture, config); }
    void check_images(const Capture& capture) const override { check_capture(capture, config); }
    std::vector<std::string> unused() const override { return unused_settings(config); }
    Stages make(const Capture& capture, std::uint64_t seed,
                const SplatWatch& watch) const override {
      return stages_for(config, capture, seed, watch);
    }
    const PipelineRow& row() const override { return row_of(config); }
    Config config;
  };
  std::unique_ptr<Any> own_;

  friend Fields fields(PipelineConfig& config);
  friend void validate(const PipelineConfig& config);
  friend std::string_view method_of(const PipelineConfig& config);
  friend PipelineNeeds needs(const PipelineConfig& config);
  friend bool needs_sfm(const Capture& capture, const PipelineConfig& config);
  friend void check_capture(const Capture& capture, const PipelineConfig& config);
  friend std::vector<std::string> unused_settings(const PipelineConfig& config);
  friend Stages stages_for(const PipelineConfig& config, const Capture& capture, std::uint64_t seed,
                           const SplatWatch& watch);
  friend const PipelineRow& row_of(const PipelineConfig& config);
};

/// Its keys; they point into it.
Fields fields(PipelineConfig& config);
void validate(const PipelineConfig& config);
std::string_view method_of(const PipelineConfig& config);
PipelineNeeds needs(const PipelineConfig& config);
bool needs_sfm(const Capture& capture, const PipelineConfig& config);
void check_capture(const Capture& capture, const PipelineConfig& config);
std::vector<std::string> unused_settings(const PipelineConfig& config);
/// Its own stages; those that it has not are null. @param capture  outlives them
Stages stages_for(const PipelineConfig& config, const Capture& capture, std::uint64_t seed,
                  const SplatWatch& watch = {});
const PipelineRow& row_of(const PipelineConfig& config);

/// Runs the stages that there are in the pipeline's order, having checked that the capture has what
/// the configuration reads. @throws as run_stages
Estimate run_pipeline(const Capture& capture, const PipelineConfig& config, const Stages& stages,
                      const StageObserver& observer = {});

// ---- Rows
// ----------------------------------------------------------------------------------------

/// A method of a pipeline, as --method takes it.
struct MethodRow {
  std::string_view name;
  std::string_view help;
  /// Options of the build that it needs: "CERES", "PCL".
  std::vector<std::string_view> options = {};
};

/// What traits are of, and so how an estimate is scored.
enum class TraitsOf {
  specimens,  ///< of each object, over all views
  boxes,      ///< of what one box of one image shows
  plants,     ///< of one plant in one frame, and of its nodes
  trees,      ///< of each fruit over all views, and of the tree
  depths,     ///< there are none: depth images are what is measured
  nothing     ///< there are none: the scene is scored as a whole
};

/// A pipeline. To add one, write its files, and add its row to pipeline_table().
struct PipelineRow {
  std::string_view name;
  std::string_view old_name = {};  ///< that is taken too; empty: none
  std::string_view help;
  /// That it measures; empty: any photographs. Of the rows of a scene the first is its own.
  std::vector<std::string_view> scenes;
  StageOrder order;  ///< all stages that any of its methods has
  /// Stages without one of ours: `run` puts truth there, `perceive` asks for --stage.
  std::vector<std::string_view> from_outside = {};
  /// What the points of `keypoints` are, by the first words of their names in the scene: an entry's
  /// first point is of the first, the others are of the rest. Empty: all points of the scene.
  std::vector<std::string_view> keypoints = {};
  TraitsOf traits_of = TraitsOf::specimens;
  std::vector<std::string_view> traits = {};  ///< rows of trait_table()
  std::vector<MethodRow> methods;             ///< the default is the first
  PipelineConfig (*defaults)() = nullptr;
};

std::vector<const PipelineRow*> pipeline_table();
/// @throws std::invalid_argument listing the names that exist
const PipelineRow& pipeline_row(std::string_view name);
/// The scene's own pipeline, the first of its rows; null where it has none.
const PipelineRow* pipeline_of_scene(std::string_view scene);
/// "seeds, strawberries, scene".
std::string pipeline_names();

}  // namespace cousin
