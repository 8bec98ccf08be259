// Checks of [[attachment]] and [[landmark]]; private to src/input.
#pragma once

#include <cstddef>
#include <vector>

#include "case.hpp"
#include "case_read.hpp"

namespace voile::input {

/// What the stages before one that is read leave to it.
struct StagesBefore {
  double end = 0.0;                      ///< time at which they have ended [s]
  std::vector<std::size_t> attachments;  ///< numbers in the file of those that have taken hold

  void add(const Case& stage);
};

/// Throws UserError if what has been read cannot be; `c` has the obstacles and what stood before in the file.
void check_attachment(const SectionPlace& place, const Case& c, const system::Attachment& s,
                      const StagesBefore& before);
void check_landmark(const SectionPlace& place, const Case& c, const LandmarkSection& s);

}  // namespace voile::input
