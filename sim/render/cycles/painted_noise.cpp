#include "sim/render/cycles/painted_noise.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/render/value_noise.h"

namespace cousin {
namespace {

Eigen::Vector3f vec(const Rgbf& c) { return {c.r, c.g, c.b}; }
Rgbf rgb(const Eigen::Vector3f& c) { return {c.x(), c.y(), c.z()}; }

double longest_edge_m(const Mesh& mesh, const std::array<std::uint32_t, 3>& t) {
  double longest = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    longest = std::max(longest, (mesh.vertices_m[t[k]] - mesh.vertices_m[t[(k + 1) % 3]]).norm());
  }
  return longest;
}

int cuts(double edge_m, double cell_m) {
  return std::max(1, static_cast<int>(std::ceil(edge_m / cell_m - 1e-9)));
}

/// The cell that leaves at most so many triangles; those of the model are never fewer.
double cell_for(const std::vector<double>& edges_m, double finest_m, std::size_t most_triangles) {
  const double most = static_cast<double>(std::max(most_triangles, 2 * edges_m.size()));
  for (double cell_m = finest_m;; cell_m *= 1.25) {
    double sum = 0;
    for (const double edge_m : edges_m) {
      const double n = std::max(1.0, std::ceil(edge_m / cell_m - 1e-9));
      sum += n * n;
    }
    if (sum <= most) return cell_m;
  }
}

/// Cuts triangles into n x n and colours vertices.
class Painter {
 public:
  Painter(const ObjectModel& model, const Material& material)
      : from_(model), noise_(*material.noise) {
    albedo_ = vec(material.albedo);
    other_ = vec(noise_.other_albedo);
    base_ = albedo_.cwiseMax(other_);
    if (material.kind == SurfaceKind::leaf)
      base_ = base_.cwiseMin(Eigen::Vector3f::Ones() - vec(material.transmittance));
    out_ = model;
    out_.mesh.triangles.clear();
    out_.triangle_part.clear();
    for (std::size_t v = 0; v < model.mesh.vertices_m.size(); ++v) {
      const Eigen::Vector3f shade = model.vertex_albedo.empty() ? Eigen::Vector3f::Ones().eval()
                                                                : vec(model.vertex_albedo[v]);
      shades_.push_back(shade);
    }
    out_.vertex_albedo.clear();
    for (std::size_t v = 0; v < shades_.size(); ++v)
      out_.vertex_albedo.push_back(colour(out_.mesh.vertices_m[v], shades_[v]));
  }

  void add(std::size_t triangle, int n) {
    const auto& t = from_.mesh.triangles[triangle];
    const auto keep = [&](const std::array<std::uint32_t, 3>& corners) {
      out_.mesh.triangles.push_back(corners);
      if (!from_.triangle_part.empty()) out_.triangle_part.push_back(from_.triangle_part[triangle]);
    };
    if (n == 1) {
      keep(t);
      return;
    }
    // Rows of points from the first corner's edge to the third corner.
    const auto first = static_cast<std::uint32_t>(out_.mesh.vertices_m.size());
    for (int j = 0; j <= n; ++j) {
      for (int i = 0; i + j <= n; ++i)
        add_point(t, static_cast<double>(i) / n, static_cast<double>(j) / n);
    }
    const auto at = [&](int i, int j) {
      return first + static_cast<std::uint32_t>(j * (2 * n + 3 - j) / 2 + i);
    };
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i + j < n; ++i) {
        keep({at(i, j), at(i + 1, j), at(i, j + 1)});
        if (i + j + 1 < n) keep({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
      }
    }
  }

  ObjectModel take() { return std::move(out_); }
  Rgbf base() const { return rgb(base_); }

 private:
  Rgbf colour(const Eigen::Vector3d& at_m, const Eigen::Vector3f& shade) const {
    const Eigen::Vector3f own = albedo_.cwiseProduct(shade);
    const Eigen::Vector3f p = at_m.cast<float>() / static_cast<float>(noise_.scale_m);
    const Eigen::Vector3f seen = own + value_noise(p, noise_.octaves) * (other_ - own);
    const auto share = [&](int k) {
      return base_[k] > 0 ? std::clamp(seen[k] / base_[k], 0.0F, 1.0F) : 0.0F;
    };
    return {share(0), share(1), share(2)};
  }

  void add_point(const std::array<std::uint32_t, 3>& t, double u, double v) {
    const auto between = [&](const auto& values) {
      using Value = std::decay_t<decltype(values[0])>;
      using Scalar = typename Value::Scalar;
      return Value(static_cast<Scalar>(1 - u - v) * values[t[0]] +
                   static_cast<Scalar>(u) * values[t[1]] + static_cast<Scalar>(v) * values[t[2]]);
    };
    out_.mesh.vertices_m.push_back(between(from_.mesh.vertices_m));
    out_.vertex_albedo.push_back(colour(out_.mesh.vertices_m.back(), between(shades_)));
    if (!from_.vertex_normals.empty())
      out_.vertex_normals.push_back(between(from_.vertex_normals).normalized());
  }

  const ObjectModel& from_;
  const NoiseTexture& noise_;
  Eigen::Vector3f albedo_, other_, base_;
  std::vector<Eigen::Vector3f> shades_;  ///< vertex albedo of the model
  ObjectModel out_;
};

}  // namespace

PaintedNoise paint_noise(const ObjectModel& model, const Material& material,
                         std::size_t most_triangles) {
  if (!material.noise)
    throw std::invalid_argument("material \"" + material.name + "\" has no noise to paint");
  std::vector<double> edges_m;
  for (const auto& t : model.mesh.triangles) edges_m.push_back(longest_edge_m(model.mesh, t));
  const double finest_m = 0.5 * material.noise->scale_m / std::exp2(material.noise->octaves - 1);
  PaintedNoise painted;
  painted.cell_m = cell_for(edges_m, finest_m, most_triangles);
  Painter painter(model, material);
  for (std::size_t t = 0; t < edges_m.size(); ++t) painter.add(t, cuts(edges_m[t], painted.cell_m));
  painted.material = material;
  painted.material.noise.reset();
  painted.material.albedo = painter.base();
  painted.model = painter.take();
  return painted;
}

}  // namespace cousin
