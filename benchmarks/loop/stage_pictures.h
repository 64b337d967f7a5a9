#pragma once

#include "benchmarks/loop/report_scene.h"
#include "benchmarks/loop/simulate.h"
#include "perception/pipelines/estimate.h"

namespace cousin {

/// Two of the images with the outlines that were found in them.
std::vector<ReportPicture> outline_pictures(const Capture& capture, const Estimate& estimate);
/// All measured surfaces as one mesh, in the world.
Mesh all_surfaces(const Estimate& estimate);

// What a page shows of a stage: pictures and shapes, added to the scene's. Nothing where the stage
// made nothing.

void show_splats(const SimulatedRun& run, const Estimate& estimate, ReportScene& scene);
/// With a cross where each measured point is seen.
void show_boxes(const SimulatedRun& run, const Estimate& estimate, ReportScene& scene);
void show_keypoints(const SimulatedRun& run, const Estimate& estimate, ReportScene& scene);
/// Measured and true depth in one scale; not where a cloud of specimens shows it.
void show_depths(const SimulatedRun& run, const Estimate& estimate, ReportScene& scene);
void show_cloud(const SimulatedRun& run, const Estimate& estimate, ReportScene& scene);
void show_outlines(const SimulatedRun& run, const Estimate& estimate, ReportScene& scene);
void show_surfaces(const SimulatedRun& run, const Estimate& estimate, ReportScene& scene);
/// The numbers of the specimens whose traits are measured.
void show_numbers(const SimulatedRun& run, const Estimate& estimate, ReportScene& scene);

}  // namespace cousin
