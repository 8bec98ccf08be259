// Cards of Nastran bulk data: small, large and free fields, continuation lines, INCLUDE; private to src/io.
//
// Fields count from 1, behind the name, eight to a line: field 9 is the first of the first continuation.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "base/types.hpp"

namespace voile::formats {

struct NastranCard {
  std::string name;                 ///< in capitals, without '*'
  std::vector<std::string> fields;  ///< trimmed, in capitals
  std::string file;
  std::size_t line = 0;

  /// Field `k`, "" if it is blank or not there.
  [[nodiscard]] const std::string& field(std::size_t k) const;
  /// Throws UserError with file and line if the field is blank or no number. [of the file]
  [[nodiscard]] double real(std::size_t k) const;
  [[nodiscard]] long whole(std::size_t k) const;
  /// The same, `otherwise` where the field is blank.
  [[nodiscard]] double real(std::size_t k, double otherwise) const;
  [[nodiscard]] long whole(std::size_t k, long otherwise) const;
  /// Numbers from field `first` on; of ranges "A THRU B BY C" A and what is among `known`. Throws UserError for what is neither.
  [[nodiscard]] std::vector<long> list(std::size_t first, const std::set<long>& known) const;
  /// Throws UserError "file:line: NAME: what".
  [[noreturn]] void fail(const std::string& what) const;
};

struct NastranFile {
  std::vector<NastranCard> control;   ///< lines before BEGIN BULK: `name` is the line
  std::vector<NastranCard> cards;     ///< in the order of the file
  std::vector<std::string> included;  ///< as the file names them
};

/// Not collective. Throws UserError with file and line for what cannot be read: superelements, replicated cards,
/// continuations that do not follow their cards, missing files.
[[nodiscard]] NastranFile read_nastran_file(const std::string& file);

/// Coordinate systems by number, resolved into the basic one.
class NastranSystems {
 public:
  /// `cards` must outlive it. Throws UserError for a system that is defined twice.
  explicit NastranSystems(const std::vector<NastranCard>& cards);
  /// Places of all grid points in the basic system, by number. [of the file]  Throws UserError with file and line for a
  /// missing system, axes that span no plane, systems that refer to each other, points defined twice.
  [[nodiscard]] std::map<long, Vec3> points();
  /// A vector of a rectangular system `id` in the basic one; `card` names it. Throws UserError for a missing or curved system.
  [[nodiscard]] Vec3 turned(long id, const Vec3& vector, const NastranCard& card);

 private:
  struct System {
    char kind = 'R';  ///< R, C or S
    Vec3 origin = Vec3::Zero();
    Mat3 axes = Mat3::Identity();  ///< columns
  };
  [[nodiscard]] const System& system(long id, const NastranCard& user);
  [[nodiscard]] Vec3 placed(long id, const Vec3& x, const NastranCard& user);
  [[nodiscard]] Vec3 point(long id, const NastranCard& user);

  std::map<long, std::pair<const NastranCard*, std::size_t>> definitions_;  ///< card and its first field
  std::map<long, System> systems_;
  std::map<long, const NastranCard*> grids_;
  const NastranCard* defaults_ = nullptr;  ///< GRDSET
  int depth_ = 0;
};

}  // namespace voile::formats
