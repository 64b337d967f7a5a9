#include "sim/geometry/lattice.h"

namespace cousin {

void add_lattice_triangles(Mesh& mesh, std::uint32_t first, std::uint32_t columns,
                           std::uint32_t rows) {
  const std::uint32_t row = columns + 1;
  for (std::uint32_t j = 0; j < rows; ++j) {
    for (std::uint32_t i = 0; i < columns; ++i) {
      const std::uint32_t a = first + j * row + i;
      mesh.triangles.push_back({a, a + 1, a + row + 1});
      mesh.triangles.push_back({a, a + row + 1, a + row});
    }
  }
}

}  // namespace cousin
