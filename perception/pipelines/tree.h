#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "perception/fruit/fruit_tracks.h"
#include "perception/fruit/tree_yield.h"
#include "perception/pipelines/apples.h"

namespace cousin {

/// How the fruits of a tree are counted; help texts are in its row.
enum class TreeMethod { ours, tracks, boxes };

/// A tree's fruits over all its views. Boxes with instance masks, and poses, come from outside.
struct TreePipelineConfig {
  TreeMethod method = TreeMethod::ours;
  ApplesPipelineConfig fruit;  ///< how each box's fruit is measured
  FruitTracksConfig tracks;
  TreeYieldConfig yield;
};
Fields fields(TreePipelineConfig& config);
void validate(const TreePipelineConfig& config);
std::string_view to_string(TreeMethod method);

PipelineNeeds needs(const TreePipelineConfig& config);
/// A sentence for each setting that the method does not use.
std::vector<std::string> unused_settings(const TreePipelineConfig& config);
/// @throws std::invalid_argument if the capture has no depth
void check_capture(const Capture& capture, const TreePipelineConfig& config);

/// Stages depth, fits (as of pipeline apples, a box each), tracks and traits. An entry of the
/// traits is a fruit over all views, with its middle in the world: diameter, length, volume, mass;
/// its instance is the track's number. The last one is the tree: fruit_count and yield of what
/// hangs in its place of the row; fruits elsewhere have no entry. Boxes of frames without a pose
/// are not used.
Stages stages_for(const TreePipelineConfig& config, const Capture& capture, std::uint64_t seed,
                  const SplatWatch& watch);
struct PipelineRow;
const PipelineRow& row_of(const TreePipelineConfig& config);

}  // namespace cousin
