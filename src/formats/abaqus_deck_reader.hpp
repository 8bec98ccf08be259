// Reads what an Abaqus deck has besides its mesh; private to src/formats.
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "abaqus_words.hpp"
#include "deck.hpp"

namespace voile::formats {

class AbaqusDeckReader {
 public:
  explicit AbaqusDeckReader(std::string file) : file_(std::move(file)) {}

  Deck run() {
    read(0);
    return std::move(deck_);
  }

 private:
  using Procedure = Deck::Procedure;
  enum class Data {
    none,
    unread,
    title,
    elastic,
    lamina,
    rubber,
    expansion,
    density,
    section,
    ply,
    axes,
    axis,
    support,
    force,
    pressure,
    surface,
    surface_pressure,
    temperature,
    initial_temperature,
    procedure,
    amplitude,
    skipped
  };

  // Keywords
  void read(int depth);
  void begin(const std::string& text, int depth);
  void list_parameters();
  void note_set(const std::string& keyword);
  /// A set as the deck calls it, or the number of a node or element, without the instance before it.
  [[nodiscard]] std::string place_of(const std::string& word) const;
  bool begin_model(const std::string& keyword);
  bool begin_amplitude();
  std::string amplitude_of(const std::string& keyword);
  bool begin_step(const std::string& keyword);
  void include(int depth);

  // Lines of data, by the keyword before them
  void take(const std::string& text);
  void take_elastic(const AbaqusWords& words);
  void take_ply(const AbaqusWords& words);
  void take_axes(const AbaqusWords& words);
  void take_axis(const AbaqusWords& words);
  void orient(long normal);
  void take_support(const AbaqusWords& words);
  void take_amplitude_of(Deck::Support& s, const std::string& where);
  void take_amplitude(const AbaqusWords& words);
  void take_force(const AbaqusWords& words);
  void take_pressure(const AbaqusWords& words);
  void take_rubber(const AbaqusWords& words);
  void take_surface(const AbaqusWords& words);
  void take_surface_pressure(const AbaqusWords& words);
  void take_temperature(const AbaqusWords& words);
  void take_procedure(const AbaqusWords& words);

  void leave(const std::string& what);
  [[nodiscard]] double number(const AbaqusWords& words, std::size_t k) const;
  [[nodiscard]] long whole(const AbaqusWords& words, std::size_t k) const;

  static constexpr int most_included = 8;
  static constexpr long most_modes = 1000;

  std::string file_, keyword_, material_, amplitude_;
  std::map<std::string, std::string> parameters_;
  std::size_t line_ = 0;
  Data data_ = Data::none;
  int steps_ = 0;
  bool nonlinear_ = false, symmetric_ = false, in_assembly_ = false, ramp_ = false;
  std::array<double, 6> points_{};
  /// Elements of a surface, and whether it is their positive side.
  struct Side {
    std::string elements;
    bool positive;
  };
  std::map<std::string, std::vector<Side>> surfaces_;
  std::set<std::string> assembly_sets_;  ///< in capitals
  Deck deck_;
};

}  // namespace voile::formats
