#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdlib>

#include "abaqus_deck_reader.hpp"
#include "base/types.hpp"
#include "mesh_text.hpp"

namespace voile::formats {

void AbaqusDeckReader::take(const std::string& text) {
  const AbaqusWords words = abaqus_fields(text);
  if (words.empty()) return;
  switch (data_) {
    case Data::title:
      if (deck_.title.empty()) deck_.title = abaqus_trimmed(text);
      return;
    case Data::elastic:
    case Data::lamina:
      return take_elastic(words);
    case Data::rubber:
      return take_rubber(words);
    case Data::expansion:
      deck_.materials[material_].expansion = {number(words, 0), words.size() > 2 ? number(words, 1) : number(words, 0)};
      data_ = Data::none;
      return;
    case Data::density:
      deck_.materials[material_].density = number(words, 0);
      data_ = Data::none;
      return;
    case Data::section:
      deck_.sections.back().thickness = number(words, 0);
      data_ = Data::none;
      return;
    case Data::ply:
      return take_ply(words);
    case Data::axes:
      return take_axes(words);
    case Data::axis:
      return take_axis(words);
    case Data::support:
      return take_support(words);
    case Data::force:
      return take_force(words);
    case Data::pressure:
      return take_pressure(words);
    case Data::surface:
      return take_surface(words);
    case Data::surface_pressure:
      return take_surface_pressure(words);
    case Data::temperature:
    case Data::initial_temperature:
      return take_temperature(words);
    case Data::procedure:
      return take_procedure(words);
    case Data::amplitude:
      return take_amplitude(words);
    default:
      return;
  }
}

void AbaqusDeckReader::take_elastic(const AbaqusWords& words) {
  Deck::Material& m = deck_.materials[material_];
  if (m.young > 0.0) leave("*ELASTIC: properties at other temperatures; the first line is taken");
  if (m.young > 0.0) return;
  m.orthotropic = data_ == Data::lamina;
  m.young = number(words, 0);
  if (m.orthotropic) {
    m.young_2 = number(words, 1);
    m.poisson = number(words, 2);
    m.shear = number(words, 3);
  } else {
    m.poisson = words.size() > 1 ? number(words, 1) : 0.0;
  }
}

/// A symmetric stack is given up to its middle.
void AbaqusDeckReader::take_ply(const AbaqusWords& words) {
  double angle = 0.0;
  if (words.size() > 3 && !words[3].empty() && !parse_number(words[3], angle))
    leave(fmt::format("{}, COMPOSITE: the orientation {} of a ply; its angle is 0", keyword_, words[3]));
  std::vector<Deck::Ply>& plies = deck_.sections.back().plies;
  const auto half =
      symmetric_ ? static_cast<std::ptrdiff_t>(plies.size() / 2) : static_cast<std::ptrdiff_t>(plies.size());
  const Deck::Ply ply{number(words, 0), words.size() > 2 ? abaqus_upper(words[2]) : "", angle};
  plies.insert(plies.begin() + half, symmetric_ ? 2 : 1, ply);
}

/// Two points in the plane of the local axes 1 and 2, and perhaps the origin.
void AbaqusDeckReader::take_axes(const AbaqusWords& words) {
  for (std::size_t k = 0; k < 6; ++k)
    points_[k] =
        number(words, k) - (words.size() > 6 + k % 3 && !words[6 + k % 3].empty() ? number(words, 6 + k % 3) : 0.0);
  orient(1);  // unless a second line says so
  data_ = Data::axis;
}

void AbaqusDeckReader::take_axis(const AbaqusWords& words) {
  const long normal = words[0].empty() ? 1 : whole(words, 0);
  if (normal < 1 || normal > 3) fail_in_line(file_, line_, "*ORIENTATION: the axis is 1, 2 or 3");
  orient(normal);
  if (words.size() > 1 && !words[1].empty())
    deck_.orientations[abaqus_upper(parameters_["NAME"])].angle = number(words, 1);
  data_ = Data::none;
}

/// Axis 1 of a shell is the local axis that follows the one along its normal.
void AbaqusDeckReader::orient(long normal) {
  const Eigen::Map<const Vec3> x(points_.data()), in_plane(points_.data() + 3);
  const Vec3 z = x.cross(in_plane), y = z.cross(x);
  const Vec3 along = normal == 1 ? y.normalized() : normal == 2 ? z.normalized() : x.normalized();
  if (!(along.norm() > 0.5)) fail_in_line(file_, line_, "*ORIENTATION: the two points and the origin lie on one line");
  const Vec3 about = (normal == 1 ? Vec3(x) : normal == 2 ? y : z).normalized();
  Deck::Orientation& axes = deck_.orientations[abaqus_upper(parameters_["NAME"])];
  axes.direction = {along[0], along[1], along[2]};
  axes.about = {about[0], about[1], about[2]};
}

void AbaqusDeckReader::take_support(const AbaqusWords& words) {
  Deck::Support& s = deck_.supports[place_of(words[0])];
  const std::string name = words.size() > 1 ? abaqus_upper(words[1]) : "";
  if (name == "ENCASTRE") {
    s.held.fill(true);
  } else if (name == "PINNED") {
    s.held[0] = s.held[1] = s.held[2] = true;
  } else if (name == "XSYMM" || name == "YSYMM" || name == "ZSYMM") {
    s.mirror = name;
  } else if (long any = 0; !name.empty() && !parse_integer(name, any)) {
    leave(fmt::format("*BOUNDARY {}, {}", words[0], name));
  } else {
    const long first = whole(words, 1), last = words.size() > 2 && !words[2].empty() ? whole(words, 2) : first;
    const double value = words.size() > 3 ? number(words, 3) : 0.0;
    if (first < 1 || last > 6 || last < first)
      return leave("*BOUNDARY " + words[0] + ": degrees of freedom beyond 1 to 6");
    for (long k = first; k <= last; ++k) {
      s.held[static_cast<std::size_t>(k - 1)] = true;
      if (k <= 3) s.value[static_cast<std::size_t>(k - 1)] = value;
      if (k <= 3 && value != 0.0) take_amplitude_of(s, words[0]);
      if (k > 3 && value != 0.0) leave(fmt::format("*BOUNDARY {}: rotation {} by {}", words[0], k, value));
    }
  }
}

void AbaqusDeckReader::take_amplitude_of(Deck::Support& s, const std::string& where) {
  if (!s.amplitude.empty() && s.amplitude != amplitude_)
    leave(fmt::format("*BOUNDARY {}: a second amplitude; {} is taken for all of its values", where, amplitude_));
  s.amplitude = amplitude_;
}

void AbaqusDeckReader::take_amplitude(const AbaqusWords& words) {
  Deck::Table& table = deck_.amplitudes[amplitude_];
  for (std::size_t k = 0; k < words.size(); k += 2) {
    table.push_back({number(words, k), number(words, k + 1)});
    if (table.size() > 1 && !(table.back()[0] > table[table.size() - 2][0]))
      fail_in_line(file_, line_, "*AMPLITUDE: the times do not ascend");
  }
}

void AbaqusDeckReader::take_force(const AbaqusWords& words) {
  const long direction = whole(words, 1);
  if (direction < 1 || direction > 3) return leave(fmt::format("*CLOAD {}: a moment", words[0]));
  Deck::Load load{Deck::Load::Kind::force, place_of(words[0]), {}, 0.0, amplitude_};
  load.vector[static_cast<std::size_t>(direction - 1)] = number(words, 2);
  deck_.loads.push_back(load);
}

void AbaqusDeckReader::take_pressure(const AbaqusWords& words) {
  const std::string label = words.size() > 1 ? abaqus_upper(words[1]) : "";
  if (label == "P") {
    deck_.loads.push_back({Deck::Load::Kind::pressure, place_of(words[0]), {}, number(words, 2), amplitude_});
  } else if (label == "GRAV") {
    Deck::Load load{Deck::Load::Kind::gravity, place_of(words[0]), {}, 0.0, amplitude_};
    Vec3 direction = Vec3::Zero();
    for (std::size_t k = 0; k < 3 && 3 + k < words.size(); ++k)
      direction[static_cast<Eigen::Index>(k)] = words[3 + k].empty() ? 0.0 : number(words, 3 + k);
    if (direction.norm() > 0.0) direction.normalize();
    for (std::size_t k = 0; k < 3; ++k) load.vector[k] = number(words, 2) * direction[static_cast<Eigen::Index>(k)];
    deck_.loads.push_back(load);
  } else {
    leave(fmt::format("*DLOAD {}, {}", words[0], label));
  }
}

/// Constants of rubber, then compressibilities, of which there is none here.
void AbaqusDeckReader::take_rubber(const AbaqusWords& words) {
  Deck::Material& m = deck_.materials[material_];
  const long pairs = parameters_.contains("N") ? std::max(std::strtol(parameters_["N"].c_str(), nullptr, 10), 1L) : 1L;
  const std::size_t wanted = m.ogden ? 2 * static_cast<std::size_t>(pairs) : parameters_.contains("NEO HOOKE") ? 1 : 2;
  for (std::size_t k = 0; k < words.size(); ++k) {
    if (m.rubber.size() < wanted) {
      m.rubber.push_back(number(words, k));
    } else if (!words[k].empty() && number(words, k) != 0.0) {
      leave("*HYPERELASTIC: compressibility; it is incompressible");
      break;
    }
  }
}

/// Elements and a side of them.
void AbaqusDeckReader::take_surface(const AbaqusWords& words) {
  const std::string side = words.size() > 1 ? abaqus_upper(words[1]) : "";
  if (side == "SPOS" || side == "SNEG")
    surfaces_[abaqus_upper(parameters_["NAME"])].push_back({place_of(words[0]), side == "SPOS"});
}

/// Positive against the normal of the surface, where that of elements (*DLOAD) is along it.
void AbaqusDeckReader::take_surface_pressure(const AbaqusWords& words) {
  const std::string label = words.size() > 1 ? abaqus_upper(words[1]) : "";
  const auto surface = surfaces_.find(abaqus_upper(words[0]));
  if (label != "P" || surface == surfaces_.end())
    return leave(fmt::format("*DSLOAD {}, {}{}", words[0], label,
                             label == "P" ? ": the surface has no sides SPOS or SNEG of shells" : ""));
  for (const Side& s : surface->second)
    deck_.loads.push_back(
        {Deck::Load::Kind::pressure, s.elements, {}, (s.positive ? -1.0 : 1.0) * number(words, 2), amplitude_});
}

void AbaqusDeckReader::take_temperature(const AbaqusWords& words) {
  deck_.temperatures.push_back({place_of(words[0]), number(words, 1), data_ == Data::initial_temperature});
  if (words.size() > 2) leave(fmt::format("{} {}: temperatures over the thickness", keyword_, words[0]));
}

void AbaqusDeckReader::take_procedure(const AbaqusWords& words) {
  if (deck_.procedure == Procedure::frequency || deck_.procedure == Procedure::buckle) {
    constexpr long unsaid = 10;
    if (words[0].empty()) leave(fmt::format("{} without a number of modes: {} are found", keyword_, unsaid));
    deck_.modes = static_cast<int>(std::min(words[0].empty() ? unsaid : whole(words, 0), most_modes));
    for (std::size_t k = 1; k < std::min<std::size_t>(words.size(), 4); ++k)
      if (deck_.procedure == Procedure::frequency && !words[k].empty())
        leave(fmt::format("*FREQUENCY, a bound or shift of {}: the lowest modes are found", words[k]));
  } else if (deck_.procedure == Procedure::riks) {
    if (words.size() > 1 && !words[1].empty()) deck_.end = number(words, 1);
    if (!words[0].empty()) deck_.step = number(words, 0);
    for (std::size_t k = 2; k < words.size(); ++k) {
      if (words[k].empty()) continue;
      if (k == 4)
        deck_.factor = number(words, 4);
      else
        leave(fmt::format("*STATIC, RIKS: {} {}", k < 4 ? "arc length of at least or at most" : "end by a node,",
                          words[k]));
    }
    if (words.size() < 5 || words[4].empty()) leave("*STATIC, RIKS without a last load factor: the path ends at 1");
  } else if (words.size() > 1) {
    deck_.end = number(words, 1);
    deck_.step = words[0].empty() ? 0.01 * deck_.end : number(words, 0);  // of an explicit step, which finds its own
  }
  data_ = Data::none;
}

}  // namespace voile::formats
