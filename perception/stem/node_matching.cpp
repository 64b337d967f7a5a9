#include "perception/stem/node_matching.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "sim/config/limits.h"

namespace cousin {
namespace {

using Eigen::Vector2d;

constexpr double kNever = std::numeric_limits<double>::infinity();

// ---- The paper's rule
// ----------------------------------------------------------------------------

/// Distance of a pair if both are within epsilon of each other's line.
double paper_distance(const EyePair& eyes, const EyeNode& left, const EyeNode& right,
                      double epsilon_px) {
  const auto away = epipolar_distance(eyes, left.pixel_px, right.pixel_px);
  if (!away) return kNever;
  const double most = std::max(std::abs(away->in_left_px), std::abs(away->in_right_px));
  if (most > epsilon_px || !middle_of_rays(eyes, left.pixel_px, right.pixel_px)) return kNever;
  return most;
}

std::vector<NodePair> mutual_nearest(const EyePair& eyes, const std::vector<EyeNode>& left,
                                     const std::vector<EyeNode>& right, double epsilon_px) {
  std::vector<NodePair> pairs;
  const auto nearest = [&](bool of_left, std::size_t i) {
    std::size_t best = std::numeric_limits<std::size_t>::max();
    double least = kNever;
    const std::size_t count = of_left ? right.size() : left.size();
    for (std::size_t j = 0; j < count; ++j) {
      const double d = of_left ? paper_distance(eyes, left[i], right[j], epsilon_px)
                               : paper_distance(eyes, left[j], right[i], epsilon_px);
      if (d >= least) continue;
      least = d;
      best = j;
    }
    return best;
  };
  for (std::size_t i = 0; i < left.size(); ++i) {
    const std::size_t j = nearest(true, i);
    if (j >= right.size() || nearest(false, j) != i) continue;
    const auto away = epipolar_distance(eyes, left[i].pixel_px, right[j].pixel_px);
    pairs.push_back({left[i], right[j], away->in_right_px});
  }
  return pairs;
}

void sort_upwards(std::vector<NodePair>& pairs) {
  std::stable_sort(pairs.begin(), pairs.end(), [](const NodePair& a, const NodePair& b) {
    return a.left.pixel_px.y() > b.left.pixel_px.y();
  });
}

// ---- Ours
// ----------------------------------------------------------------------------------------

/// All that the cost of a pair depends on.
struct Matcher {
  const EyePair& eyes;
  const EyeNodes& left;
  const EyeNodes& right;
  const NodeMatchConfig& config;
  const EpipolarOffset& offset;
  const Unlikeness& unlikeness;

  double alone() const { return 0.5 * config.most_sigmas * config.most_sigmas; }

  /// Squared epipolar distance over its variance; kNever beyond the limit.
  double epipolar_cost(const EyeNode& l, const EyeNode& r) const {
    const auto away = epipolar_distance(eyes, l.pixel_px, r.pixel_px);
    if (!away || !middle_of_rays(eyes, l.pixel_px, r.pixel_px)) return kNever;
    const double spread_px = offset.matches > 0 ? offset.sigma_px : config.calibration_px;
    const double variance =
        l.sigma_px * l.sigma_px + r.sigma_px * r.sigma_px + spread_px * spread_px;
    const double off = away->in_right_px - offset.offset_px;
    const double cost = off * off / variance;
    return cost > config.most_sigmas * config.most_sigmas ? kNever : cost;
  }

  /// How far the depth of a pair is from the root's, over what a leaning stem and the pixels allow.
  double lean_cost(const NodePair& root, const EyeNode& l, const EyeNode& r) const {
    const auto foot = middle_of_rays(eyes, root.left.pixel_px, root.right.pixel_px);
    const auto node = middle_of_rays(eyes, l.pixel_px, r.pixel_px);
    if (!foot || !node) return kNever;
    const double focal_px = eyes.left.camera().fx_px;
    const double per_px = foot->z() * foot->z() / (focal_px * eyes.baseline_m);  // metres
    const double up_m = (*node - *foot).head<2>().norm();
    const double sigma_px = std::sqrt(l.sigma_px * l.sigma_px + r.sigma_px * r.sigma_px +
                                      root.left.sigma_px * root.left.sigma_px +
                                      root.right.sigma_px * root.right.sigma_px);
    const double allowed_m = config.lean_sigma_rad * up_m + sigma_px * per_px;
    const double off = (node->z() - foot->z()) / allowed_m;
    return off * off > config.most_sigmas * config.most_sigmas ? kNever : 0.25 * off * off;
  }
};

bool is_above(const EyeNode& root, const EyeNode& node, double cone_rad) {
  const Vector2d up = root.pixel_px - node.pixel_px;
  const double slack_px = 2 + 4 * std::max(root.sigma_px, node.sigma_px);
  return up.y() > -slack_px &&
         std::abs(up.x()) < std::tan(cone_rad) * std::max(0.0, up.y()) + slack_px;
}

/// Places of the nodes not yet taken that may be a root's, from it upwards.
std::vector<std::size_t> nodes_above(const EyeNode* root, const std::vector<EyeNode>& nodes,
                                     const std::vector<bool>& taken, double cone_rad) {
  std::vector<std::size_t> above;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (!taken[i] && (!root || is_above(*root, nodes[i], cone_rad))) above.push_back(i);
  }
  std::stable_sort(above.begin(), above.end(), [&](std::size_t a, std::size_t b) {
    return nodes[a].pixel_px.y() > nodes[b].pixel_px.y();
  });
  return above;
}

/// Pairs of places that keep the order of both, and what they are better than none by.
struct Alignment {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  double gain = 0;
};
Alignment align(const Matcher& m, const NodePair* root, const std::vector<std::size_t>& left,
                const std::vector<std::size_t>& right) {
  const std::size_t rows = left.size() + 1, columns = right.size() + 1;
  const auto at = [columns](std::size_t i, std::size_t j) { return i * columns + j; };
  std::vector<double> gain(rows * columns, 0), own(rows * columns, -kNever);
  for (std::size_t i = 1; i < rows; ++i) {
    for (std::size_t j = 1; j < columns; ++j) {
      const EyeNode& l = m.left.nodes[left[i - 1]];
      const EyeNode& r = m.right.nodes[right[j - 1]];
      double cost = m.epipolar_cost(l, r);
      if (root && cost < kNever) cost += m.lean_cost(*root, l, r);
      own[at(i, j)] = gain[at(i - 1, j - 1)] + 2 * m.alone() - cost;
      gain[at(i, j)] = std::max({gain[at(i - 1, j)], gain[at(i, j - 1)], own[at(i, j)]});
    }
  }
  Alignment best;
  best.gain = gain.back();
  std::size_t i = rows - 1, j = columns - 1;
  while (i > 0 && j > 0) {
    if (gain[at(i, j)] == own[at(i, j)]) {
      best.pairs.emplace_back(left[--i], right[--j]);
    } else if (gain[at(i, j)] == gain[at(i - 1, j)]) {
      --i;
    } else {
      --j;
    }
  }
  std::reverse(best.pairs.begin(), best.pairs.end());
  return best;
}

struct Hypothesis {
  std::size_t left = 0, right = 0;  ///< of the roots
  Alignment alignment;
  double gain = -kNever;
};

NodePair pair_of(const Matcher& m, const EyeNode& l, const EyeNode& r) {
  const auto away = epipolar_distance(m.eyes, l.pixel_px, r.pixel_px);
  return {l, r, away ? away->in_right_px : 0};
}

/// The best pair of roots of those left, with their nodes.
Hypothesis best_plant(const Matcher& m, const std::vector<bool> (&taken)[4]) {
  Hypothesis best;
  for (std::size_t i = 0; i < m.left.roots.size(); ++i) {
    if (taken[0][i]) continue;
    const auto left = nodes_above(&m.left.roots[i], m.left.nodes, taken[2], m.config.cone_rad);
    for (std::size_t j = 0; j < m.right.roots.size(); ++j) {
      if (taken[1][j]) continue;
      const EyeNode &l = m.left.roots[i], &r = m.right.roots[j];
      const double cost = m.epipolar_cost(l, r);
      if (cost == kNever) continue;
      const NodePair root = pair_of(m, l, r);
      Hypothesis here{i, j, {}, 0};
      here.alignment =
          align(m, &root, left, nodes_above(&r, m.right.nodes, taken[3], m.config.cone_rad));
      here.gain = here.alignment.gain + 2 * m.alone() - cost;
      if (m.unlikeness) here.gain -= 2 * m.alone() * m.unlikeness(l.pixel_px, r.pixel_px);
      if (here.gain > best.gain) best = here;
    }
  }
  return best;
}

}  // namespace

Fields fields(NodeMatchConfig& c) {
  return {{"paper_epsilon_px", &c.paper_epsilon_px,
           "method paper: largest distance of a point from the other's epipolar line", 0.1, 1000},
          {"most_sigmas", &c.most_sigmas, "ours: the same over its deviation", 1, 100},
          {"calibration_px", &c.calibration_px,
           "deviation of the right image's offset from its calibration, each axis", 0, 100},
          {"cone_rad", &c.cone_rad, "a node is above its root within this of the image's vertical",
           0, 1.5},
          {"lean_sigma_rad", &c.lean_sigma_rad, "deviation of a stem's lean to or from the camera",
           0.005, 0.75}};
}

void validate(const NodeMatchConfig& config) {
  NodeMatchConfig copy = config;
  check_limits(fields(copy), "match");
}

std::vector<MatchedPlant> match_by_paper(const EyePair& eyes, const EyeNodes& left,
                                         const EyeNodes& right, const NodeMatchConfig& config) {
  MatchedPlant plant;
  const double epsilon_px = config.paper_epsilon_px;
  std::vector<NodePair> roots = mutual_nearest(eyes, left.roots, right.roots, epsilon_px);
  sort_upwards(roots);
  plant.has_root = !roots.empty();
  if (plant.has_root) plant.pairs.push_back(roots.front());
  std::vector<NodePair> nodes = mutual_nearest(eyes, left.nodes, right.nodes, epsilon_px);
  sort_upwards(nodes);
  plant.pairs.insert(plant.pairs.end(), nodes.begin(), nodes.end());
  if (plant.pairs.empty()) return {};
  return {plant};
}

std::vector<MatchedPlant> match_in_order(const EyePair& eyes, const EyeNodes& left,
                                         const EyeNodes& right, const NodeMatchConfig& config,
                                         const EpipolarOffset& offset,
                                         const Unlikeness& unlikeness) {
  const Matcher m{eyes, left, right, config, offset, unlikeness};
  std::vector<bool> taken[4] = {
      std::vector<bool>(left.roots.size()), std::vector<bool>(right.roots.size()),
      std::vector<bool>(left.nodes.size()), std::vector<bool>(right.nodes.size())};
  std::vector<MatchedPlant> plants;
  const auto add_nodes = [&](const Alignment& alignment, MatchedPlant& plant) {
    for (const auto& [l, r] : alignment.pairs) {
      taken[2][l] = taken[3][r] = true;
      plant.pairs.push_back(pair_of(m, left.nodes[l], right.nodes[r]));
    }
  };
  while (true) {
    const Hypothesis best = best_plant(m, taken);
    if (!(best.gain > 0)) break;
    taken[0][best.left] = taken[1][best.right] = true;
    MatchedPlant plant;
    plant.has_root = true;
    plant.pairs.push_back(pair_of(m, left.roots[best.left], right.roots[best.right]));
    add_nodes(best.alignment, plant);
    plants.push_back(std::move(plant));
  }
  if (!plants.empty()) return plants;
  MatchedPlant plant;
  add_nodes(align(m, nullptr, nodes_above(nullptr, left.nodes, taken[2], 0),
                  nodes_above(nullptr, right.nodes, taken[3], 0)),
            plant);
  if (!plant.pairs.empty()) plants.push_back(std::move(plant));
  return plants;
}

EpipolarOffset epipolar_offset(const std::vector<MatchedPlant>& plants,
                               const NodeMatchConfig& config) {
  std::vector<double> off;
  double variance = 0;
  for (const MatchedPlant& plant : plants) {
    for (const NodePair& pair : plant.pairs) {
      off.push_back(pair.epipolar_px);
      variance +=
          pair.left.sigma_px * pair.left.sigma_px + pair.right.sigma_px * pair.right.sigma_px;
    }
  }
  EpipolarOffset result;
  result.sigma_px = config.calibration_px;
  if (off.empty()) return result;
  const auto n = static_cast<double>(off.size());
  const double one = std::max(1e-6, variance / n);  // of one match
  const double prior = std::max(1e-9, config.calibration_px * config.calibration_px);
  // Half of them are false at most: the median, as sharp as the mean of 0.64 times as many.
  std::nth_element(off.begin(), off.begin() + static_cast<std::ptrdiff_t>(off.size() / 2),
                   off.end());
  const double middle = off[off.size() / 2];
  const double kept = 0.64 * n * prior / (0.64 * n * prior + one);
  result.offset_px = kept * middle;
  result.sigma_px = std::sqrt(kept * one / (0.64 * n));
  result.matches = static_cast<int>(off.size());
  return result;
}

}  // namespace cousin
