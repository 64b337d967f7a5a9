#include "sim/config/cousin.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>
#include <stdexcept>
#include <toml.hpp>

#include "sim/config/field_value.h"

namespace cousin {
namespace {

double of_axis(const CousinDistance& distance, const std::string& axis) {
  CousinDistance copy = distance;
  for (const Field& field : fields(copy)) {
    if (field.key == axis) return *std::get<double*>(field.value);
  }
  throw std::logic_error("cousin: no axis " + axis);
}

CousinMove read_move(const std::string& where, const std::string& axis, const std::string& key,
                     const toml::value& value) {
  if (!value.is_table() || value.as_table().size() != 1)
    throw std::runtime_error(where + ": must be { factor = X }, { step = X } or { to = X }");
  const auto& [word, number] = *value.as_table().begin();
  CousinMove move{axis, key, CousinMove::By::factor, 0};
  if (word == "step") {
    move.by = CousinMove::By::step;
  } else if (word == "to") {
    move.by = CousinMove::By::to;
  } else if (word != "factor") {
    throw std::runtime_error(where + ": \"" + word + "\" is not one of factor, step, to");
  }
  if (!number.is_floating()) throw std::runtime_error(where + ": must be a number with a point");
  move.range = number.as_floating();
  const bool is_good =
      std::isfinite(move.range) && (move.by == CousinMove::By::to || move.range > 0);
  if (!is_good) throw std::runtime_error(where + ": a factor or step must be positive");
  return move;
}

/// Fields that a move's key names.
std::vector<const Field*> fields_of(const Fields& config, const std::string& key) {
  std::vector<const Field*> found;
  const std::size_t stars = key.find("**");
  for (const Field& field : config) {
    const bool is_it = stars == key.npos ? field.key == key
                                         : field.key.starts_with(key.substr(0, stars)) &&
                                               field.key.ends_with(key.substr(stars + 2)) &&
                                               field.key.size() + 3 >= key.size();
    if (is_it) found.push_back(&field);
  }
  return found;
}

double moved(const CousinMove& move, double distance, double share, double value) {
  switch (move.by) {
    case CousinMove::By::factor:
      return value * std::pow(move.range, distance * share);
    case CousinMove::By::step:
      return value + distance * share * move.range;
    case CousinMove::By::to:
      break;
  }
  return value + distance * (move.range - value);
}

std::string heading(const CousinMove& move, double distance) {
  return "cousin." + move.axis + " = " + shortest(distance) + ": ";
}

void require_within(const Field& field, double value, const CousinMove& move, double distance) {
  if (value >= field.min && value <= field.max) return;
  throw std::invalid_argument(heading(move, distance) + "moves " + field.key + " to " +
                              shortest(value) + "; it must be in [" + shortest(field.min) + ", " +
                              shortest(field.max) + "]");
}

/// Writes what `move` makes of the field's value or values.
void move_field(const Field& field, const CousinMove& move, double distance, double share) {
  const auto next = [&](double value) {
    const double result = moved(move, distance, share, value);
    require_within(field, result, move, distance);
    return result;
  };
  if (auto* const* real = std::get_if<double*>(&field.value)) {
    **real = next(**real);
  } else if (auto* const* whole = std::get_if<int*>(&field.value)) {
    **whole = static_cast<int>(std::lround(next(**whole)));
  } else if (auto* const* list = std::get_if<std::vector<double>*>(&field.value)) {
    for (double& value : **list) value = next(value);
  } else {
    throw std::invalid_argument(heading(move, distance) + field.key + " is not a number");
  }
}

/// Calls `visit(move, distance, fields)` for every move of an axis that is not at 0.
void for_moves(
    const Fields& config, const std::vector<CousinMove>& moves, const CousinDistance& distance,
    const std::function<void(const CousinMove&, double, const std::vector<const Field*>&)>& visit) {
  for (const std::string& axis : cousin_axes()) {
    const double d = of_axis(distance, axis);
    if (d == 0) continue;
    bool any = false;
    for (const CousinMove& move : moves) {
      if (move.axis != axis) continue;
      const std::vector<const Field*> found = fields_of(config, move.key);
      const bool is_pattern = move.key.find("**") != move.key.npos;
      if (found.empty() && is_pattern) continue;  // another device does not have it
      any = true;
      if (found.empty())
        throw std::invalid_argument(heading(move, d) + "this configuration has no key " + move.key);
      visit(move, d, found);
    }
    if (!any) {
      throw std::invalid_argument("cousin." + axis + " = " + shortest(d) +
                                  ": this scene's table moves nothing here along that axis");
    }
  }
}

}  // namespace

Fields fields(CousinDistance& d) {
  return {{"shape", &d.shape, "distance from the reference in shape: 0 = twin, 1 = far", 0, 1},
          {"growth", &d.growth, "in size, maturity, moisture or stage", 0, 1},
          {"texture", &d.texture, "in colour, pattern and gloss", 0, 1},
          {"light", &d.light, "in its direction, hardness and level", 0, 1},
          {"sensor", &d.sensor, "in noise, blur, lens and shutter", 0, 1}};
}

bool is_twin(const CousinDistance& d) {
  return d.shape == 0 && d.growth == 0 && d.texture == 0 && d.light == 0 && d.sensor == 0;
}

const std::vector<std::string>& cousin_axes() {
  static const std::vector<std::string> kAxes = {"shape", "growth", "texture", "light", "sensor"};
  return kAxes;
}

std::vector<CousinMove> read_cousin_moves(std::string_view text, std::string_view name) {
  std::istringstream in{std::string(text)};
  const std::string file(name);
  const toml::value root = toml::parse(in, file);
  std::vector<std::pair<std::uint_least32_t, CousinMove>> found;
  for (const auto& [axis, table] : root.as_table()) {
    const auto& axes = cousin_axes();
    if (std::find(axes.begin(), axes.end(), axis) == axes.end() || !table.is_table())
      throw std::runtime_error(file + ": [" + axis +
                               "] is not a table of shape, growth, texture, "
                               "light or sensor");
    for (const auto& [key, value] : table.as_table()) {
      std::string where = file;
      where.append(": [").append(axis).append("] \"").append(key).append("\"");
      found.emplace_back(value.location().line(), read_move(where, axis, key, value));
    }
  }
  std::sort(found.begin(), found.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<CousinMove> moves;
  for (auto& [line, move] : found) moves.push_back(std::move(move));
  return moves;
}

std::string describe(const std::vector<CousinMove>& moves) {
  std::string text;
  for (const CousinMove& move : moves) {
    std::string line = move.axis;
    line.resize(std::max<std::size_t>(line.size() + 1, 9), ' ');
    line += move.key;
    line.resize(std::max<std::size_t>(line.size() + 1, 44), ' ');
    const std::string range = shortest(move.range);
    line += move.by == CousinMove::By::factor ? "times or over up to " + range
            : move.by == CousinMove::By::step ? "more or less by up to " + range
                                              : "towards " + range;
    text += line + "\n";
  }
  return text;
}

std::vector<CousinChange> move_to_cousin(const Fields& config, const std::vector<CousinMove>& moves,
                                         const CousinDistance& distance, const Rng& rng) {
  std::vector<CousinChange> changes;
  for_moves(config, moves, distance,
            [&](const CousinMove& move, double d, const std::vector<const Field*>& found) {
              Rng own = rng.fork(move.axis).fork(move.key);
              const double sign = uniform(own) < 0.5 ? -1 : 1;
              const double share = sign * uniform(own, 0.5, 1);
              for (const Field* field : found) {
                const std::string before = value_as_toml(*field);
                move_field(*field, move, d, share);
                changes.push_back({move.axis, field->key, before, value_as_toml(*field)});
              }
            });
  return changes;
}

std::string comments_of(const std::vector<CousinChange>& changes) {
  std::string text;
  for (const CousinChange& c : changes)
    text += "# cousin." + c.axis + ": " + c.key + " = " + c.before + " -> " + c.after + "\n";
  return text;
}

void check_cousin(const Fields& config, const std::vector<CousinMove>& moves,
                  const CousinDistance& distance) {
  for_moves(config, moves, distance,
            [](const CousinMove& move, double d, const std::vector<const Field*>& found) {
              for (const Field* field : found) {
                std::vector<double> values;
                if (auto* const* real = std::get_if<double*>(&field->value)) {
                  values = {**real};
                } else if (auto* const* whole = std::get_if<int*>(&field->value)) {
                  values = {static_cast<double>(**whole)};
                } else if (auto* const* list = std::get_if<std::vector<double>*>(&field->value)) {
                  values = **list;
                } else {
                  throw std::invalid_argument(heading(move, d) + field->key + " is not a number");
                }
                for (const double value : values) {
                  for (const double share : {-1.0, 1.0})
                    require_within(*field, moved(move, d, share, value), move, d);
                }
              }
            });
}

}  // namespace cousin
