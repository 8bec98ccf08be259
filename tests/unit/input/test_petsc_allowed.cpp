#include <doctest/doctest.h>

#include "input/petsc_allowed.hpp"

namespace test_petsc_allowed {

using voile::input::refusal_of_petsc_option;

namespace {

bool allowed(const char* name, const char* value = "") {
  return refusal_of_petsc_option(name, value).empty();
}

}  // namespace

TEST_CASE("options of a case that choose and tune solvers or print are allowed") {
  for (const auto& [name, value] : {std::pair{"-snes_rtol", "1e-10"},
                                    {"-snes_max_it", "15"},
                                    {"-ksp_type", "cg"},
                                    {"-ksp_view", ""},
                                    {"-ksp_view", "ascii"},
                                    {"-ksp_view", "::ascii_info_detail"},
                                    {"-snes_monitor", ""},
                                    {"-snes_converged_reason", ""},
                                    {"-ksp_monitor_true_residual", ""},
                                    {"-snes_linesearch_type", "bt"},
                                    {"-snes_linesearch_monitor", ""},
                                    {"-pc_type", "voile_mixed"},
                                    {"-pc_block_icc_ordering_type", "rcm"},
                                    {"-pc_hypre_type", "boomeramg"},
                                    {"-pc_fieldsplit_0_fields", "0,1"},
                                    {"-mat_mumps_icntl_14", "80"},
                                    {"-mat_mumps_cntl_1", "1e-3"},
                                    {"-ts_voile_radius", "0.5"},
                                    {"-eps_target", "-0.5"},
                                    {"-st_ksp_type", "preonly"},
                                    {"-st_mat_mumps_icntl_14", "100"},
                                    {"-mg_levels_ksp_max_it", "2"},
                                    {"-mg_levels_1_sub_pc_type", "ilu"},
                                    {"-sub_pc_type", "icc"},
                                    {"-relax_ksp_type", "cg"},
                                    {"-inexact_ksp_monitor", ""},
                                    {"-inexact_factor_pc_type", "cholesky"},
                                    {"-mixed_ksp_rtol", "1e-10"},
                                    {"-path_control", "load"}}) {
    const std::string option = name;
    CHECK_MESSAGE(allowed(name, value), option);
  }
}

TEST_CASE("options of a case that write, load, start or open something are refused") {
  for (const auto& [name, value] : {std::pair{"-dll_prepend", "./evil.so"},
                                    {"-options_file", "more"},
                                    {"-options_alias", "a"},
                                    {"-prefix_push", "a_"},
                                    {"-info", "file"},
                                    {"-log_view", ":file"},
                                    {"-log_view", ""},
                                    {"-malloc_dump", ""},
                                    {"-on_error_attach_debugger", ""},
                                    {"-start_in_debugger", ""},
                                    {"-python", "x"},
                                    {"-mat_view", "binary:file"},
                                    {"-vec_view", ""},
                                    {"-ksp_view", ":file"},
                                    {"-KSP_VIEW", ":file"},
                                    {"-ksp_view", "ascii:file"},
                                    {"-ksp_view", "ascii:file:ascii_info"},
                                    {"-ksp_view_mat", "binary"},
                                    {"-ksp_view_mat", "BINARY"},
                                    {"-ksp_view_mat", "draw"},
                                    {"-ksp_view_mat", "hdf5:file"},
                                    {"-snes_monitor", "ascii:file"},
                                    {"-snes_monitor", "python:x"},
                                    {"-snes_monitor", "file"},
                                    {"-snes_monitor_python", "x"},
                                    {"-snes_monitor_lg", ""},
                                    {"-ksp_monitor_saws", ""},
                                    {"-ts_monitor_solution_vtk", "f.vts"},
                                    {"-ts_monitor_draw_solution", ""},
                                    {"-ts_save_trajectory", ""},
                                    {"-ts_trajectory_dirname", "x"},
                                    {"-snes_converged_reason", ":file"},
                                    {"-ksp_type", "python"},
                                    {"-ksp_python_type", "x"},
                                    {"-pc_type", "python"},
                                    {"-pc_type", "shell"},
                                    {"-snes_type", "shell"},
                                    {"-mg_levels_pc_type", "python"},
                                    {"-mg_levels_ksp_view", ":file"},
                                    {"-st_ksp_view_mat", "binary:file"},
                                    {"-ksp_type", "hpddm"},
                                    {"-mat_mumps_icntl_1", "42"},
                                    {"-mat_mumps_icntl_22", "1"},
                                    {"-st_mat_mumps_icntl_22", "1"},
                                    {"-mat_mumps_ooc_tmpdir", "x"},
                                    {"-pc_mixed_on_disk", ""},
                                    {"-snes_rtol", "@file"},
                                    {"-snes_rtol", "$HOME"},
                                    {"-snes_rtol", "\"1\""},
                                    {"-ksp_type", "/a/b"},
                                    {"-snes", "x"},
                                    {"-snes_", "x"},
                                    {"-anything", ""}}) {
    const std::string option = name, given = value;
    CHECK_MESSAGE(!allowed(name, value), option, " ", given);
  }
}

}  // namespace test_petsc_allowed
