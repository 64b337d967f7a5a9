#include "benchmarks/seeds/plan.h"

#include <algorithm>

#include "benchmarks/seeds/truth_stages.h"

namespace cousin {

TruthNeeds planned_truth(bool attribution) {
  return attribution ? truth_stage_needs() : TruthNeeds{};
}

std::vector<PlanEntry> seeds_plan(const SeedsRunConfig& config, bool attribution,
                                  const std::vector<StageSource>& sources) {
  std::vector<PlanEntry> plan;
  const auto add = [&](const char* pass, bool runs, const std::string& why) {
    plan.push_back({pass, runs, why});
  };
  const bool sphere = config.scene.sphere;
  add("scene", true, "board, screen, specimens");
  add("physics", !sphere,
      sphere ? "a sphere is placed on the board" : "seeds are dropped and settle on the board");
  add("motion", false, "the scene is static; only the hand moves while rows are read");
  add("light cache", true, "the scene is static: diffuse light is computed once for all views");
  const PipelineNeeds pipeline = needs(config.pipeline);
  const bool color =
      std::find(pipeline.images.begin(), pipeline.images.end(), "color") != pipeline.images.end();
  add("radiance", color, color ? "the pipeline reads colour" : "no stage reads colour");
  add("sensor", color, "the phone's lens, noise and 8-bit sRGB");
  add("infrared", false, "a phone has no infrared pair");
  add("sensor depth", false, "a phone has no depth sensor");

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

  for (const std::string& stage : seeds_stage_names()) {
    const bool runs =
        std::find(pipeline.stages.begin(), pipeline.stages.end(), stage) != pipeline.stages.end();
    std::string why = "needed for the traits";
    for (const auto& [name, reason] : pipeline.left_out) {
      if (name == stage) why = reason;
    }
    for (const StageSource& source : sources) {
      if (source.stage == stage) why = "yours: " + to_text(source);
    }
    plan.push_back({"perceive: " + stage, runs, why});
  }
  add("score", true, "traits, cloud and poses against the truth");
  return plan;
}

std::string describe(const std::vector<PlanEntry>& plan) {
  std::string text;
  for (const bool runs : {true, false}) {
    text += runs ? "runs:\n" : "left out:\n";
    for (const PlanEntry& entry : plan) {
      if (entry.runs != runs) continue;
      std::string pass = entry.pass;
      pass.resize(std::max<std::size_t>(20, pass.size()), ' ');
      text += "  " + pass + " " + entry.why + "\n";
    }
  }
  return text;
}

}  // namespace cousin
