// What an Abaqus or Nastran deck has besides its mesh: materials, sections, supports, loads and the first step.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

namespace voile::formats {

struct Deck {
  /// What the program calls things, for messages.
  struct Words {
    std::string deck = "an Abaqus deck", element = "*ELEMENT", support = "*BOUNDARY", load = "*CLOAD or *DLOAD",
                section = "*SHELL SECTION", gravity = "*DLOAD", step = "*STEP";
  };
  struct Material {
    bool orthotropic = false;
    double young = 0.0, poisson = 0.0, young_2 = 0.0, shear = 0.0, density = 0.0;  ///< 0: the deck has none
    std::array<double, 2> expansion{};                                             ///< along axes 1 and 2
    /// Of rubber, as the deck gives them: C10; C10 and C01; pairs of a modulus and an exponent. Empty: elastic.
    std::vector<double> rubber{};
    bool ogden = false;
  };
  struct Ply {
    double thickness;
    std::string material;
    double angle;  ///< of its axis 1 [degree]
  };
  struct Section {
    std::string elements, material;  ///< names
    double thickness = 0.0;
    std::string orientation{};  ///< name; empty: none
    std::vector<Ply> plies{};   ///< from the lowest; empty: of one material
    double mass = 0.0;          ///< per area, besides that of its materials
  };
  /// Of axis 1, before it is projected into the shell and turned about the normal.
  struct Orientation {
    std::array<double, 3> direction{};
    double angle = 0.0;             ///< about `about`, by the right hand [degree]
    std::array<double, 3> about{};  ///< the local axis along the normal, or against it
  };
  /// Of all lines on one set or node.
  struct Support {
    std::array<bool, 6> held{};     ///< displacements 1 to 3, rotations 4 to 6
    std::array<double, 3> value{};  ///< of the displacements
    std::string mirror;             ///< XSYMM, YSYMM or ZSYMM
    std::string amplitude;          ///< of the values; empty: none
  };
  struct Load {
    enum class Kind { force, pressure, gravity, area } kind = Kind::force;
    std::string where;  ///< set, or number of a node or element
    std::array<double, 3> vector{};
    double size = 0.0;  ///< of a pressure, along the normal
    std::string amplitude;
  };
  struct Temperature {
    std::string where;  ///< set of nodes
    double value = 0.0;
    bool initial = false;
  };
  enum class Procedure { none, linear, nonlinear, riks, frequency, buckle, dynamic };
  struct Left {
    std::string what;   ///< keyword, or keyword and data
    std::string place;  ///< FILE:LINE
  };

  using Table = std::vector<std::array<double, 2>>;  ///< times, ascending, and factors

  Words words{};
  std::string title;
  std::map<std::string, Material> materials;
  std::map<std::string, Orientation> orientations;
  std::vector<Section> sections;
  std::map<std::string, Support> supports;  ///< by set or number of a node
  std::vector<Load> loads;
  std::vector<Temperature> temperatures;
  Procedure procedure = Procedure::none;
  int modes = 0;
  double step = 0.0, end = 1.0;  ///< of the step, in time
  double factor = 1.0;           ///< load factor that ends a path of Riks
  std::map<std::string, Table> amplitudes;
  std::vector<std::string> included;  ///< names of included files, as the deck writes them
  std::vector<std::string> node_sets, element_sets;
  std::vector<std::string> turned;  ///< sets of nodes with axes of their own, by which supports and forces count
  bool tied = false;                ///< *TIE
  double tie_tolerance = 0.0;       ///< in the deck's unit; 0: not given
  std::vector<Left> left;           ///< what was not understood
};

/// Not collective. Throws UserError for a file that cannot be read and numbers that are none, with file and line.
[[nodiscard]] Deck read_abaqus_deck(const std::string& file);
/// Of Nastran bulk data, by the sets that its case control selects for the first subcase, or all if there is none. Supports,
/// forces and pressures are named by the numbers of nodes and elements, sections by "property-N". The same otherwise.
[[nodiscard]] Deck read_nastran_deck(const std::string& file);

}  // namespace voile::formats
