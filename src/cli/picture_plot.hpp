// Commands of voile-picture that draw tables, and put pictures beside each other.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "picture/plot.hpp"

namespace voile::cli {

class PlotCommand {
 public:
  explicit PlotCommand(CLI::App& cli);
  [[nodiscard]] bool chosen() const { return sub_->parsed(); }
  /// Throws UserError.
  void run();

 private:
  void declare_axes();
  void take_axes();
  void choose_columns(const picture::Table& table, std::vector<std::string>& x, std::vector<std::string>& y) const;
  void add_runs();
  void add_curves(const std::string& option, const std::vector<std::string>& wanted, picture::Stroke stroke);

  CLI::App* sub_;
  picture::Plot plot_;
  std::vector<std::string> results_, curves_, dashed_, points_;
  std::string x_, y_, labels_, logarithmic_, x_range_, y_range_, legend_ = "beside", output_, size_ = "960x640";
  bool quiet_ = false;
};

class SheetCommand {
 public:
  explicit SheetCommand(CLI::App& cli);
  [[nodiscard]] bool chosen() const { return sub_->parsed(); }
  /// Throws UserError.
  void run() const;

 private:
  CLI::App* sub_;
  std::vector<std::string> pictures_;
  std::string output_;
  int columns_ = 0;
  bool palette_ = false, quiet_ = false;
};

}  // namespace voile::cli
