// The commands of voile-picture that show results: their options and what they do.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "picture/export.hpp"
#include "picture/show.hpp"
#include "picture/viewer.hpp"

namespace voile::cli {

/// What all commands ask for: which results, which of their parts.
struct ResultsOptions {
  std::string results;
  picture::Choice choice;
  void declare(CLI::App& sub, bool modes);
};

/// How cloth shall look.
struct ClothOptions {
  std::string cloth, print;
  void declare(CLI::App& sub);
};

class RenderCommand {
 public:
  explicit RenderCommand(CLI::App& cli);
  [[nodiscard]] bool chosen() const { return sub_->parsed(); }
  /// Throws UserError.
  void run();

 private:
  void declare_look();
  void declare_camera();
  void take_numbers();
  void write_animation(const picture::Recording& recording) const;
  void write_pictures(const picture::Recording& recording) const;

  CLI::App* sub_;
  ResultsOptions results_;
  ClothOptions cloth_;
  picture::ShowOptions show_;
  std::string steps_, size_ = "1280x960", quality_ = "final", range_, views_ = "three-quarter", eye_, target_, up_;
  std::string output_, animation_;
  double rate_ = 25.0, scale_ = 1.0, creases_ = 0.0;
  int frames_ = 32;
  bool quiet_ = false, palette_ = false, no_ground_ = false, no_stamp_ = false, no_obstacles_ = false;
  std::filesystem::file_time_type begun_ = std::filesystem::file_time_type::clock::now();
};

class ExportCommand {
 public:
  explicit ExportCommand(CLI::App& cli);
  [[nodiscard]] bool chosen() const { return sub_->parsed(); }
  /// Throws UserError.
  void run();

 private:
  CLI::App* sub_;
  ResultsOptions results_;
  ClothOptions cloth_;
  picture::ExportOptions export_;
  std::string steps_, output_, fields_;
  bool quiet_ = false, no_obstacles_ = false;
};

class ViewCommand {
 public:
  explicit ViewCommand(CLI::App& cli);
  [[nodiscard]] bool chosen() const { return sub_->parsed(); }
  /// Throws UserError.
  void run();

 private:
  CLI::App* sub_;
  ResultsOptions results_;
  picture::ViewerOptions viewer_;
  std::string steps_ = "all", output_, fields_;
  bool quiet_ = false, no_obstacles_ = false;
};

}  // namespace voile::cli
