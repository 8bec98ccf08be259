// Every section of the case file with its declared keys, at their defaults: what the reference page and the schema for
// editors are made from.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "case_keys.hpp"

namespace voile::input {

/// Owns one section of every kind, to which the keys are bound.
class Declarations {
 public:
  Declarations();
  Declarations(const Declarations&) = delete;
  Declarations& operator=(const Declarations&) = delete;
  [[nodiscard]] const std::vector<Key>& top() const { return top_; }
  /// Keys of a section that sections() names.
  [[nodiscard]] const std::vector<Key>& of(const std::string& section) const { return keys_.at(section); }

 private:
  Case case_;
  PanelSection panel_;
  SeamSection seam_;
  MarkSection mark_;
  MaterialInput material_;
  system::Support support_;
  MotionInput motion_;
  RigidSection rigid_;
  PeriodicSection periodic_;
  system::Load load_;
  system::Temperature temperature_;
  system::Hinge hinge_;
  ImperfectionSection imperfection_;
  system::PointMass mass_;
  system::Spring spring_;
  system::Attachment attachment_;
  ObstacleSection obstacle_;
  LandmarkSection landmark_;
  RuleSection rule_;
  Probe probe_;
  InitialVelocity initial_velocity_;
  std::vector<Key> top_;
  std::map<std::string, std::vector<Key>> keys_;
};

/// A JSON schema (draft 7) of the case file, by which editors complete and check it.
[[nodiscard]] std::string case_schema();

}  // namespace voile::input
