#include "benchmarks/seeds/plan.h"

#include <algorithm>

#include "benchmarks/seeds/simulator_plan.h"
#include "benchmarks/seeds/truth_stages.h"

namespace cousin {

TruthNeeds planned_truth(bool attribution) {
  return attribution ? truth_stage_needs() : TruthNeeds{};
}

namespace {

/// Longest readout of a rig's colour cameras.
double readout_s(const DeviceConfig& rig) {
  if (const auto* phone = std::get_if<PhoneConfig>(&rig)) return phone->readout_s;
  if (const auto* device = std::get_if<ActiveStereoConfig>(&rig))
    return device->color.photosites.readout_s;
  const auto* range = std::get_if<RangeRigConfig>(&rig);
  double longest_s = 0;
  for (const RigSensor& sensor : range ? range->body.sensors : std::get<RigConfig>(rig).sensors)
    longest_s = std::max(longest_s, sensor.camera.photosites.readout_s);
  return longest_s;
}

/// Which renderer makes the light, and how much it spends.
std::string renderer_of(const SeedsRunConfig& config) {
  if (config.radiance == RadianceBy::cached) {
    return "cached, " + std::to_string(config.render.pixel_samples) + " samples a pixel, " +
           std::to_string(config.render.edge_samples) + " at edges";
  }
  const PathConfig& paths = config.paths;
  std::string text = "paths, " + std::to_string(paths.pixel_samples) + " samples a pixel";
  if (paths.adaptive) text += " on average, more where the error is larger";
  return text;
}

void add_rig_passes(const SeedsRunConfig& config, Reader reader, std::vector<PlanEntry>& plan) {
  const Streams there_are = streams_of(config.rig);
  const Streams streams = planned_streams(config, reader);
  const bool is_dataset = reader == Reader::anybody;
  const Streams needed = is_dataset ? Streams{} : needed_streams(config.pipeline);
  const std::string nobody =
      is_dataset ? "streams=" + config.streams + " leaves out " : "no stage reads ";
  const bool light = streams.color || streams.raw;
  const auto add = [&](const char* pass, bool runs, const std::string& why) {
    plan.push_back({pass, runs, why});
  };
  const std::string rig = "rig " + config.scene.rig;
  const auto why = [&](bool runs, bool is_needed, const std::string& what) {
    if (!runs) return nobody + what;
    if (is_dataset && config.streams == "auto")
      return "a dataset holds all that the rig has: " + what;
    return (is_needed ? "the pipeline reads " : "asked for: ") + what;
  };
  const bool rolling = readout_s(config.rig) > 0;
  add("row poses", light && rolling,
      !light    ? nobody + "colour"
      : rolling ? "a rolling shutter: each row is read where the rig is then"
                : rig + " has a global shutter: one pose an image");
  const bool by_paths = config.radiance == RadianceBy::paths;
  add("light cache", light && !by_paths,
      !light     ? "no light is traced: " + nobody + "colour"
      : by_paths ? "radiance = paths: each pixel follows its own"
                 : "the scene is static: diffuse light is computed once for all views");
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

Streams left_out_streams(const SeedsRunConfig& config) {
  const Streams there_are = streams_of(config.rig), streams = planned_streams(config);
  return {.color = there_are.color && !streams.color,
          .raw = there_are.raw && !streams.raw,
          .infrared = there_are.infrared && !streams.infrared,
          .depth = there_are.depth && !streams.depth};
}

std::vector<PlanEntry> simulator_plan(const SeedsRunConfig& config, Reader reader) {
  std::vector<PlanEntry> plan;
  const bool sphere = config.scene.sphere;
  plan.push_back({"scene", true, "board, screen, specimens"});
  plan.push_back(
      {"physics", !sphere,
       sphere ? "a sphere is placed on the board" : "seeds are dropped and settle on the board"});
  plan.push_back({"motion", false, "the scene is static: nothing in it has samples over time"});
  add_rig_passes(config, reader, plan);
  return plan;
}

std::vector<PlanEntry> seeds_plan(const SeedsRunConfig& config, bool attribution,
                                  const std::vector<StageSource>& sources) {
  std::vector<PlanEntry> plan = simulator_plan(config, Reader::pipeline);
  const auto add = [&](const char* pass, bool runs, const std::string& why) {
    plan.push_back({pass, runs, why});
  };
  const PipelineNeeds pipeline = needs(config.pipeline);

  const TruthNeeds truth = planned_truth(attribution);
  const auto truth_pass = [&](const char* pass, bool runs) {
    add(pass, runs,
        runs ? "true seams are put into the pipeline"
             : "no score reads it: traits come from the exact meshes");
  };
  truth_pass("truth: depth", truth.depth);
  truth_pass("truth: instance", truth.instance);
  truth_pass("truth: normal", truth.normal);
  truth_pass("truth: position", truth.position);
  truth_pass("truth: part", truth.part);
  truth_pass("truth: coverage", truth.coverage);
  truth_pass("truth: visibility", truth.visibility);
  truth_pass("truth: shares", truth.shares);
  truth_pass("truth: keypoints", truth.keypoints);
  truth_pass("truth: flow", truth.flow);
  truth_pass("truth: disparity", truth.disparity);
  truth_pass("truth: noise-free depth", truth.noise_free_depth);
  truth_pass("truth: invalid reason", truth.invalid_reason);

  for (const std::string_view stage : seeds_stage_order()) {
    const bool runs =
        std::find(pipeline.stages.begin(), pipeline.stages.end(), stage) != pipeline.stages.end();
    std::string why = "needed for the traits";
    for (const auto& [name, reason] : pipeline.left_out) {
      if (name == stage) why = reason;
    }
    for (const StageSource& source : sources) {
      if (source.stage == stage) why = "yours: " + to_text(source);
    }
    plan.push_back({"perceive: " + std::string(stage), runs, why});
  }
  add("score", true, "traits, cloud and poses against the truth");
  return plan;
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
