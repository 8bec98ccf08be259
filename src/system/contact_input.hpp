// Contact as the user states it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "contact/contact_options.hpp"
#include "contact/obstacle.hpp"

namespace voile::system {

/// An exception to the rules between two bodies: obstacles, or surface or curve groups of the mesh (surface.hpp).
struct ContactRule {
  std::string first, second;
  std::optional<double> friction;
  bool ignore = false;
};

struct ContactInput {
  bool active = false;
  contact::ContactOptions options;
  double thickness = 0.0;  ///< of the sheet: its layers keep this apart [m]
  bool self = true;        ///< the sheet touches itself
  double friction = 0.0;   ///< of the sheet against itself
  std::vector<contact::Obstacle> obstacles;
  std::vector<ContactRule> rules;
  std::vector<std::string> notes;  ///< what a user should know of the obstacles
};

}  // namespace voile::system
