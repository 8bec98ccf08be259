// Materials, sections and material axes of the shells of Nastran bulk data; private to src/io.
//
// Symbols   theta  from side G1 G2 of an element to material axis 1 about the normal;  MCID  a system whose x axis, projected into
//                  the element, is that axis instead
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "deck.hpp"
#include "nastran_cards.hpp"

namespace voile::formats {

class NastranProperties {
 public:
  /// `cards` and `systems` must outlive it. Throws UserError with both lines for a material or property that is there twice.
  NastranProperties(const std::vector<NastranCard>& cards, NastranSystems& systems);
  /// Materials, orientations and sections of what elements use; `mass`: factor of densities. Throws UserError with file and line where
  /// an element has a thickness or an offset of its own, which would be a wrong answer.
  void add_to(Deck& deck, double mass);

 private:
  /// Fields of an element; 0: it has none.
  struct Layout {
    std::size_t corners = 0, theta = 0, offset = 0, thickness = 0, scaled = 0;
  };
  struct Axis {
    Vec3 direction, normal;
  };
  [[nodiscard]] static Layout layout_of(const std::string& name);
  void check_element(const NastranCard& card, const Layout& layout) const;
  [[nodiscard]] std::optional<Axis> axis_of(const NastranCard& card, const Layout& layout);
  void add_shell(Deck& deck, const NastranCard& card);
  void add_laminate(Deck& deck, const NastranCard& card);
  /// Names the common direction of material axes of a section; false: there is none, which is left.
  [[nodiscard]] bool orient(Deck& deck, const NastranCard& card, Deck::Section& section);

  const std::vector<NastranCard>* cards_;
  NastranSystems* systems_;
  std::map<long, Vec3> points_;
  std::map<long, const NastranCard*> properties_, materials_;
  std::map<long, std::vector<const NastranCard*>> elements_;  ///< by property
};

}  // namespace voile::formats
