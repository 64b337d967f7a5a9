#include <stdexcept>

#include "sim/dataset/seam_io.h"
#include "sim/geometry/mesh_io.h"
#include "tests/fuzz/fuzz_folder.h"

/// Any bytes as surfaces.json beside a mesh: surfaces or std::runtime_error, nothing else.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cousin;
  static const bool prepared = [] {
    Mesh mesh;
    mesh.vertices_m = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    std::filesystem::create_directories(fuzz_folder() / "meshes");
    write_ply(fuzz_folder() / "meshes" / "000000.ply", mesh);
    return true;
  }();
  static_cast<void>(prepared);
  fuzz_file("surfaces.json", data, size);
  try {
    read_surfaces(fuzz_folder());
  } catch (const std::runtime_error&) {
  }
  return 0;
}
