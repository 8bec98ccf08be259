#include "nastran_properties.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>

#include "mesh_text.hpp"
#include "voile/errors.hpp"

namespace voile::formats {

namespace {

void leave(Deck& deck, const NastranCard& card, const std::string& what) {
  deck.left.push_back({what, fmt::format("{}:{}", card.file, card.line)});
}

Deck::Material isotropic(const NastranCard& card) {
  Deck::Material m;
  const double shear = card.real(3, 0.0);
  m.young = card.real(2, 0.0);
  m.poisson = card.real(4, m.young > 0.0 && shear > 0.0 ? m.young / (2.0 * shear) - 1.0 : 0.0);
  if (m.young == 0.0) m.young = 2.0 * (1.0 + m.poisson) * shear;
  m.density = card.real(5, 0.0);
  return m;
}

/// G beside E and NU: Nastran takes all three.
void note_shear(Deck& deck, const NastranCard& card) {
  if (card.field(2).empty() || card.field(3).empty() || card.field(4).empty()) return;
  const double shear = card.real(2) / (2.0 * (1.0 + card.real(4)));
  if (std::abs(card.real(3) - shear) > 0.01 * shear)
    leave(deck, card,
          fmt::format("MAT1 {}, G = {}: E and NU are taken, which give {:.4g}; a MAT8 has a shear modulus of its own",
                      card.field(1), card.field(3), shear));
}

Deck::Material orthotropic(const NastranCard& card) {
  Deck::Material m{true, card.real(2, 0.0), card.real(4, 0.0), card.real(3, 0.0), card.real(5, 0.0), card.real(8, 0.0)};
  if (!(m.young > 0.0 && m.young_2 > 0.0 && m.shear > 0.0)) card.fail("E1, E2 and G12 above zero are needed");
  return m;
}

/// Xt, Xc, Yt, Yc, S of a MAT8.
constexpr std::size_t first_strength = 12, last_strength = 16;

bool is_property(const std::string& name) {
  return name == "PSHELL" || name == "PCOMP";
}

}  // namespace

NastranProperties::NastranProperties(const std::vector<NastranCard>& cards, NastranSystems& systems)
    : cards_(&cards), systems_(&systems), points_(systems.points()) {
  const auto once = [](std::map<long, const NastranCard*>& all, const NastranCard& card, const char* kind) {
    const auto [at, fresh] = all.emplace(card.whole(1), &card);
    if (!fresh)
      card.fail(fmt::format("{} {} is there twice, first in {}:{}; remove one of the two", kind, at->first,
                            at->second->file, at->second->line));
  };
  for (const NastranCard& card : cards) {
    if (card.name == "MAT1" || card.name == "MAT8") once(materials_, card, "material");
    if (is_property(card.name)) once(properties_, card, "property");
    if (layout_of(card.name).corners > 0) elements_[card.whole(2, card.whole(1))].push_back(&card);
  }
}

NastranProperties::Layout NastranProperties::layout_of(const std::string& name) {
  static const std::map<std::string, Layout> all{{"CTRIA3", {3, 6, 7, 11, 10}},  {"CTRIAR", {3, 6, 7, 11, 10}},
                                                 {"CQUAD4", {4, 7, 8, 11, 10}},  {"CQUADR", {4, 7, 8, 11, 10}},
                                                 {"CTRIA6", {3, 9, 10, 11, 14}}, {"CQUAD8", {4, 15, 16, 11, 17}},
                                                 {"CQUAD", {4, 12, 0, 0, 0}}};
  const auto at = all.find(name);
  return at == all.end() ? Layout{} : at->second;
}

void NastranProperties::check_element(const NastranCard& card, const Layout& layout) const {
  if (layout.offset > 0 && card.real(layout.offset, 0.0) != 0.0)
    card.fail(
        fmt::format("ZOFFS = {}: a shell beside its grid points is not read; move the grid points, or leave it blank",
                    card.field(layout.offset)));
  if (layout.thickness == 0) return;
  const long property = card.whole(2, card.whole(1));
  const auto at = properties_.find(property);
  const double whole = at != properties_.end() && at->second->name == "PSHELL" ? at->second->real(3, 0.0) : 0.0;
  const bool scaled = card.whole(layout.scaled, 0L) == 1;
  for (std::size_t k = layout.thickness; k < layout.thickness + layout.corners; ++k)
    if (!card.field(k).empty() && std::abs(card.real(k) * (scaled ? whole : 1.0) - whole) > 1e-9 * whole)
      card.fail(fmt::format(
          "T{} = {} is another thickness than {:g} of property {}; give these elements a PSHELL of their own",
          k - layout.thickness + 1, card.field(k), whole, property));
}

std::optional<NastranProperties::Axis> NastranProperties::axis_of(const NastranCard& card, const Layout& layout) {
  std::array<Vec3, 4> x;
  for (std::size_t k = 0; k < layout.corners; ++k) {
    const auto at = points_.find(card.whole(3 + k, 0L));
    if (at == points_.end()) return std::nullopt;
    x[k] = at->second;
  }
  const Vec3 normal =
      (layout.corners == 3 ? (x[1] - x[0]).cross(x[2] - x[0]) : (x[2] - x[0]).cross(x[3] - x[1])).normalized();
  Vec3 along = x[1] - x[0];
  double theta = 0.0;
  if (long system = 0; parse_integer(card.field(layout.theta), system))
    along = systems_->turned(system, Vec3::UnitX(), card);
  else
    theta = card.real(layout.theta, 0.0) * std::numbers::pi / 180.0;
  along -= along.dot(normal) * normal;
  if (!(along.norm() > 1e-6)) return std::nullopt;
  return Axis{Eigen::AngleAxisd(theta, normal) * along.normalized(), normal};
}

bool NastranProperties::orient(Deck& deck, const NastranCard& card, Deck::Section& section) {
  constexpr double alike = 0.9998;  // cosine of a degree
  std::optional<Axis> first;
  for (const NastranCard* element : elements_[card.whole(1)]) {
    const std::optional<Axis> axis = axis_of(*element, layout_of(element->name));
    if (!first) first = axis;
    if (!axis) continue;
    const Vec3 there = first->direction - first->direction.dot(axis->normal) * axis->normal;
    if (there.dot(axis->direction) > alike * there.norm() && there.norm() > 0.05) continue;
    leave(deck, *element,
          fmt::format(
              "{} {}: material axes (THETA, MCID) that differ between its elements; write its [[material]] with a "
              "`direction` for each group yourself",
              card.name, card.whole(1)));
    return false;
  }
  if (!first) return true;
  const Vec3& d = first->direction;
  deck.orientations[section.elements] = {{d[0], d[1], d[2]}, 0.0};
  section.orientation = section.elements;
  return true;
}

void NastranProperties::add_shell(Deck& deck, const NastranCard& card) {
  if (card.field(2).empty()) return leave(deck, card, "PSHELL without MID1: it has no membrane");
  Deck::Section section{fmt::format("property-{}", card.whole(1)), card.field(2), card.real(3, 0.0)};
  const auto material = deck.materials.find(card.field(2));
  if (material != deck.materials.end() && material->second.orthotropic && !orient(deck, card, section)) return;
  deck.sections.push_back(section);
  if (card.field(4).empty()) leave(deck, card, "PSHELL without MID2, a membrane: it bends as a shell of its thickness");
  if (!card.field(4).empty() && card.field(4) != card.field(2))
    leave(deck, card, "PSHELL, MID2: MID1 is taken for bending");
  if (card.real(5, 1.0) != 1.0) leave(deck, card, "PSHELL, 12I/T**3: 1 is taken");
  if (card.real(8, 0.0) != 0.0) leave(deck, card, "PSHELL, NSM: mass that is not structural");
}

void NastranProperties::add_laminate(Deck& deck, const NastranCard& card) {
  const std::string& symmetric = card.field(8);
  if (!symmetric.empty() && symmetric != "SYM")
    return leave(deck, card, fmt::format("PCOMP, LAM = {}; its plies one by one, or SYM, are read", symmetric));
  Deck::Section section{fmt::format("property-{}", card.whole(1)), ""};
  double whole = 0.0;
  for (std::size_t k = 9; k <= card.fields.size(); k += 4) {
    if (card.field(k).empty() && card.field(k + 1).empty() && card.field(k + 2).empty()) continue;
    const bool begins = section.plies.empty();
    const std::string material = card.field(k).empty() && !begins ? section.plies.back().material : card.field(k);
    const double thickness = card.field(k + 1).empty() && !begins ? section.plies.back().thickness : card.real(k + 1);
    section.plies.push_back({thickness, material, card.real(k + 2, 0.0)});
    whole += thickness;
  }
  if (section.plies.empty()) card.fail("there are no plies");
  if (symmetric == "SYM") {
    const std::vector<Deck::Ply> half = section.plies;
    section.plies.insert(section.plies.end(), half.rbegin(), half.rend());
    whole *= 2.0;
  }
  if (!card.field(2).empty() && std::abs(card.real(2) + 0.5 * whole) > 1e-6 * whole)
    card.fail(fmt::format("Z0 = {}: a laminate beside its grid points is not read; leave Z0 blank, which is {:g}",
                          card.field(2), -0.5 * whole));
  if (!orient(deck, card, section)) return;
  if (card.real(3, 0.0) != 0.0) leave(deck, card, "PCOMP, NSM: mass that is not structural");
  deck.sections.push_back(std::move(section));
}

void NastranProperties::add_to(Deck& deck, double mass) {
  for (const auto& [id, card] : materials_) {
    if (card->name == "MAT1") note_shear(deck, *card);
    for (std::size_t k = first_strength; card->name == "MAT8" && k <= last_strength; ++k)
      if (!card->field(k).empty()) {
        leave(deck, *card, fmt::format("MAT8 {}: strengths; give the [[material]] `failure` and its strengths", id));
        break;
      }
    Deck::Material& m = deck.materials[card->field(1)];
    m = card->name == "MAT8" ? orthotropic(*card) : isotropic(*card);
    m.density *= mass;
  }
  for (const auto& [property, elements] : elements_)
    for (const NastranCard* element : elements) check_element(*element, layout_of(element->name));
  for (const NastranCard& card : *cards_) {
    if (!is_property(card.name) || elements_.count(card.whole(1)) == 0) continue;
    card.name == "PSHELL" ? add_shell(deck, card) : add_laminate(deck, card);
  }
}

}  // namespace voile::formats
