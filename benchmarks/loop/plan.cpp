#include "benchmarks/loop/plan.h"

#include <algorithm>

#include "benchmarks/loop/keypoint_noise_config.h"
#include "benchmarks/loop/rig_sight.h"
#include "benchmarks/loop/score_boxes.h"
#include "benchmarks/loop/truth_stages.h"

namespace cousin {

TruthNeeds planned_truth(const PipelineConfig& pipeline, bool attribution) {
  const PipelineRow& row = row_of(pipeline);
  const bool reads_truth = row.traits_of == TraitsOf::boxes || !row.from_outside.empty();
  TruthNeeds needs = attribution || reads_truth ? truth_stage_needs() : TruthNeeds{};
  if (row.traits_of == TraitsOf::plants || takes_keypoints(row)) needs.keypoints = true;
  if (row.traits_of == TraitsOf::depths) needs.depth = true;
  // Sizes and places of what boxes show are scored by how much of it is hidden.
  needs.visibility = row.traits_of == TraitsOf::boxes && !are_all_of_points(row.traits);
  return needs;
}

namespace {

/// Which renderer makes the light, and how much it spends.
std::string renderer_of(const RunConfig& config) {
  if (config.radiance == RadianceBy::cached) {
    return "cached, " + std::to_string(config.cached.pixel_samples) + " samples a pixel, " +
           std::to_string(config.cached.edge_samples) + " at edges";
  }
  const PathConfig& paths = config.paths;
  std::string text = "paths, " + std::to_string(paths.pixel_samples) + " samples a pixel";
  if (paths.adaptive) text += " on average, more where the error is larger";
  return text;
}

/// Why light is cached, or is not.
std::string why_cached(const RunConfig& config) {
  if (config.radiance == RadianceBy::cached)
    return "the scene is static: diffuse light is computed once for all views";
  const std::string_view why = row_of(config.scene).why_paths;
  return why.empty() ? "render.by = paths: each pixel follows its own" : std::string(why);
}

void add_rig_passes(const RunConfig& config, Reader reader, std::vector<PlanEntry>& plan) {
  const Streams there_are = streams_of(config.rig);
  const Streams streams = planned_streams(config, reader);
  const bool is_dataset = reader == Reader::anybody || !config.pipeline;
  const Streams needed = is_dataset ? Streams{} : needed_streams(*config.pipeline);
  const std::string nobody =
      is_dataset ? "streams=" + config.streams + " leaves out " : "no stage reads ";
  const bool light = streams.color || streams.raw;
  const auto add = [&](const char* pass, bool runs, const std::string& why) {
    plan.push_back({pass, runs, why});
  };
  const std::string rig = "rig " + config.scene.rig();
  const auto why = [&](bool runs, bool is_needed, const std::string& what) {
    if (!runs) return nobody + what;
    if (is_dataset && config.streams == "auto")
      return "a dataset holds all that the rig has: " + what;
    return (is_needed ? "the pipeline reads " : "asked for: ") + what;
  };
  const bool rolling = sight_of(config.rig).readout_s > 0;
  add("row poses", light && rolling,
      !light    ? nobody + "colour"
      : rolling ? "a rolling shutter: each row is read where the rig is then"
                : rig + " has a global shutter: one pose an image");
  const bool by_paths = config.radiance == RadianceBy::paths;
  add("light cache", light && !by_paths,
      light ? why_cached(config) : "no light is traced: " + nobody + "colour");
  add("radiance", light,
      why(light, needed.color || needed.raw, "colour") + (light ? "; " + renderer_of(config) : ""));
  add("sensor", light, light ? "lens, noise and processing of the camera" : nobody + "colour");
  add("raw", streams.raw,
      there_are.raw ? why(streams.raw, needed.raw, "raw images") : rig + " hands over none");
  const bool matched =
      streams.depth && there_are.infrared && config.capture.depth_by == DepthBy::matched;
  add("infrared", streams.infrared || matched,
      !there_are.infrared ? rig + " has no infrared pair"
      : streams.infrared  ? why(true, needed.infrared, "infrared images")
      : matched           ? "the sensor's depth is matched from it"
      : streams.depth     ? "depth is by the fast model"
                          : nobody + "infrared or the sensor's depth");
  add("sensor depth", streams.depth,
      !there_are.depth ? rig + " has no depth sensor"
                       : why(streams.depth, needed.depth, "the sensor's depth"));
}

}  // namespace

std::vector<PlanEntry> simulator_plan(const RunConfig& config, Reader reader) {
  const PhysicsUse physics = physics_of(config.scene);
  std::vector<PlanEntry> plan;
  plan.push_back({"scene", true, std::string(row_of(config.scene).shows)});
  plan.push_back({"physics", physics.runs, physics.why});
  plan.push_back({"motion", physics.moves,
                  physics.moves ? "each picture has rays over its own exposure"
                                : "nothing moves while pictures are taken"});
  add_rig_passes(config, reader, plan);
  return plan;
}

std::vector<PlanEntry> run_plan(const RunConfig& config, bool attribution,
                                const std::vector<StageSource>& sources) {
  std::vector<PlanEntry> plan = simulator_plan(config);
  if (config.pipeline) add_pipeline_plan(*config.pipeline, attribution, sources, plan);
  return plan;
}

namespace {

/// Truth images by their names in a plan.
std::vector<std::pair<const char*, bool>> truth_passes(const TruthNeeds& truth) {
  return {{"depth", truth.depth},
          {"instance", truth.instance},
          {"normal", truth.normal},
          {"position", truth.position},
          {"part", truth.part},
          {"coverage", truth.coverage},
          {"visibility", truth.visibility},
          {"shares", truth.shares},
          {"keypoints", truth.keypoints},
          {"flow", truth.flow},
          {"disparity", truth.disparity},
          {"noise-free depth", truth.noise_free_depth},
          {"invalid reason", truth.invalid_reason}};
}

bool has(const auto& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Why a stage runs, or is left out.
std::string why_stage(std::string_view stage, const PipelineRow& row, const PipelineNeeds& needed,
                      const std::vector<StageSource>& sources) {
  std::string why = row.traits.empty() ? "the scene as a whole" : "needed for the traits";
  if (has(row.from_outside, stage)) why = "true ones: the pipeline has no stage of its own for it";
  for (const auto& [name, reason] : needed.left_out) {
    if (name == stage) why = reason;
  }
  for (const StageSource& source : sources) {
    if (source.stage == stage) why = "yours: " + to_text(source);
  }
  return why;
}

const char* score_text(TraitsOf what) {
  switch (what) {
    case TraitsOf::specimens:
      return "traits, cloud and poses against the truth";
    case TraitsOf::boxes:
      return "what each box shows against the true surface under its middle";
    case TraitsOf::plants:
      return "nodes, internodes and heights of each plant against the truth";
    case TraitsOf::trees:
      return "fruits, count and yield of the tree against the truth";
    case TraitsOf::depths:
      return "depth of each pixel against the first surface there";
    case TraitsOf::nothing:
      break;
  }
  return "photographs against images of the model; poses and shapes against the scene";
}

}  // namespace

void add_pipeline_plan(const PipelineConfig& pipeline, bool attribution,
                       const std::vector<StageSource>& sources, std::vector<PlanEntry>& plan) {
  const PipelineRow& row = row_of(pipeline);
  const PipelineNeeds needed = needs(pipeline);
  const char* nobody = row.traits_of == TraitsOf::nothing
                           ? "no score reads it: the scene's own shapes and cameras do"
                           : "no score reads it: traits come from the exact meshes";
  const char* reads = attribution ? "true seams are put into the pipeline"
                      : row.traits_of == TraitsOf::boxes
                          ? "true boxes and the points under their middles"
                      : row.traits_of == TraitsOf::depths ? "depth is scored against it"
                                                          : "true seams are put into the pipeline";
  for (const auto& [pass, runs] : truth_passes(planned_truth(pipeline, attribution)))
    plan.push_back({std::string("truth: ") + pass, runs, runs ? reads : nobody});
  for (const std::string_view stage : row.order) {
    plan.push_back({"perceive: " + std::string(stage), has(needed.stages, stage),
                    why_stage(stage, row, needed, sources)});
  }
  plan.push_back({"score", true, score_text(row.traits_of)});
}

std::string describe(const std::vector<PlanEntry>& plan) {
  std::string text;
  std::size_t width = 0;
  for (const PlanEntry& entry : plan) width = std::max(width, entry.pass.size());
  for (const bool runs : {true, false}) {
    text += runs ? "runs:\n" : "left out:\n";
    for (const PlanEntry& entry : plan) {
      if (entry.runs != runs) continue;
      std::string pass = entry.pass;
      pass.resize(width, ' ');
      text += "  " + pass + " " + entry.why + "\n";
    }
  }
  return text;
}

}  // namespace cousin
