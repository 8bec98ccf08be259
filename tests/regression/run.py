#!/usr/bin/python3
"""Runs whole cases with the built program and asserts what comes out.

    tests/regression/run.py               everything
    tests/regression/run.py annulus ranks some of it; --list names all
    tests/regression/run.py --jobs 2      two tests at a time
    tests/regression/run.py --turn 5      everything, but of the slow ones a sixth, by this number of a day

Published figures: Sze, Liu & Lo (2004), see runs/reference. Set VOILE to test another binary than build/voile.
"""

import argparse
import json
import os
import subprocess
import sys
import time
import traceback
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "runs" / "lib"))

# Each adds its tests.
import answers  # noqa: E402, F401
import bodies  # noqa: E402, F401
import contacting  # noqa: E402, F401
import decks  # noqa: E402, F401
import draping  # noqa: E402, F401
import failing  # noqa: E402, F401
import falling  # noqa: E402, F401
import fit  # noqa: E402, F401
import forms  # noqa: E402, F401
import garments  # noqa: E402, F401
import gas  # noqa: E402, F401
import gathering  # noqa: E402, F401
import harmonic  # noqa: E402, F401
import harmonic_fields  # noqa: E402, F401
import hinges  # noqa: E402, F401
import howtos  # noqa: E402, F401
import hyperelastic  # noqa: E402, F401
import imperfect  # noqa: E402, F401
import initial_states  # noqa: E402, F401
import joints  # noqa: E402, F401
import landmarks  # noqa: E402, F401
import library  # noqa: E402, F401
import meshing  # noqa: E402, F401
import patterns  # noqa: E402, F401
import periodic  # noqa: E402, F401
import picture_mistakes  # noqa: E402, F401
import picturing  # noqa: E402, F401
import placing  # noqa: E402, F401
import published  # noqa: E402, F401
import rigid  # noqa: E402, F401
import remeshing  # noqa: E402, F401
import remeshing_motion  # noqa: E402, F401
import remeshing_paths  # noqa: E402, F401
import remeshing_sewn  # noqa: E402, F401
import robustness  # noqa: E402, F401
import running  # noqa: E402, F401
import sewing  # noqa: E402, F401
import silent  # noqa: E402, F401
import staging  # noqa: E402, F401
import tailoring  # noqa: E402, F401
import terminal  # noqa: E402, F401
import trusting  # noqa: E402, F401
import tutorials  # noqa: E402, F401
import viewing  # noqa: E402, F401
from harness import OUT, TESTS, Failure, Report  # noqa: E402


# These would take most of the time of all (4 to 140 s each). Neighbours in the list test what is related.
SLOW = """garment_gathers_again garment_gathers garment_tshirt garment_measures drape_fall remesh_sewing remesh_snap_through
remesh_ranks garment_marks garment_tube ranks linear_course turned_clamp corrected_restart damaged_restart solver_options
contact_exact frames_clock garment_restart remesh_outlook remesh_ahead remesh_mistakes placement remesh_critical_points
remesh_tip garment_seam_bending garment_holes remesh_background garment_tight attachment attachment_remesh examples templates
remesh_by_error remesh_on_slope contact_cylinder contact_untangle attachment_stages unsymmetric_laminate harmonic_methods
tutorial_drape harmonic_mistakes rigid_motion gas_breathing remeshed_on_one_mesh garment_hostile impossible_names
stiffness_jumps drape_test rubber_drum zipper fabric_test fit_sheets library_coupling pictures_by_ranks harmonic_forces
drape_equilibria gas_leak koiter_cylinder stages_interrupted gas_rigid three_layers patch_pocket imperfect_restart
imperfect_mistakes seam_statics cylinders roofs mixed_statics forms exports_in_pieces exports_of_mistakes pictures_of_mistakes
pictures_on_a_full_disk signal_twice stages_mistakes stages_stopped_search named_failures poor_meshes meshes_at_random
absurd_numbers initial_mistakes rigid_mistakes periodic_mistakes hinge_mistakes garment_refused garment_slides garment_obj
sewn_wrongly rigid_caps user_mistakes frames_notes unresolved_on_the_way hemisphere howto_cases deck_cases signals_to_mpirun
newton_cost garment_sewn_dress yarn_friction manikin shrunk_tube attachment_mistakes estimated_errors tutorial_skirt
garment_landmark_mistakes lacking_memory rigid_pendulum failure_pulled rubber_mistakes folders knife_pleat kes
remesh_contact_restart remesh_restart garment_dxf sewn_tube tutorial_study progress_line joint_frame seam_that_hangs
attachment_hard garment_in_the_way hinge_fold chains element_types clamps_turn_far remesh_taken_over placement_mistakes
imperfect_stages imperfect_mirror nastran_silent garment_sections heated_ranks_and_restart joint_moebius sheet_formats
contact_starts full_terminal deck_loads killed_motion unloaded_stages gas_mistakes harmonic_fields_mistakes rubber_motion
compared_modes rubber_states start_shapes garment_dress modes starts signals corrected_membrane periodic_motion exports ledger
periodic_strip restart_in_contact contact_frames pictures remesh_path folded_at_rest periodic_modes tutorial_roof periodic_cell
unresolved_modes rigid_roll periodic_film arch_between rigid_stages periodic_stages arc_stays_on_its_path stages_in_impact
garment_dart said_lowest_modes weak_options follower_pressure_is_judged hinge_motion contact_follower linear_values
contact_forces sewn_from_next rigid_stage_loads friction_at_rest seam_report stress_at_notches ledger_lifted held_velocities
said_differences arch_restarted units_declared abaqus_loads loose_options mode_options clocks periodic_buckling
remesh_consistent_mass edge_moments contact_last_iterations clamped_surface passing_in_stages expressions_of_growth view_page
joint_tied library_forces joint_crossed abaqus_details moving_supports pictures_without_memory membrane_jumps
three_layers_mistakes dimples tutorial_plate damped_ranks stress_at_vertices bimetal stages_turn own_histories local_axes echoes
results_with_flipped_bytes linear_output linear_under_stress fabric_damping stages_in_contact rubber_balloons stress_at_clamps
explicit_stiffening wind nothing_held harmonic_peaks ball_turns_on_plate gas_behind_a_rim seams_by_star gas_sphere
ring_between_plates tied_sheets effective_masses damped_restart remesh_flying garment_landmarks twisted_tapes""".split()


def in_turn(names, day):
    """Without the slow ones of the other days."""
    return [name for name in names if name not in SLOW or (SLOW.index(name) + day) % 6 == 0]


def passes(name):
    """Runs a test; whether it passes."""
    print(f"{name}: {TESTS[name].__doc__}", flush=True)
    report, begin = Report(), time.time()
    try:
        TESTS[name](report)
    except (Failure, subprocess.TimeoutExpired, OSError, KeyError, json.JSONDecodeError, SystemExit) as error:
        report.check(False, str(error) if isinstance(error, Failure) else traceback.format_exc(limit=2))
    print(f"  {time.time() - begin:.1f} s", flush=True)
    return report.failures == 0


def passes_alone(name):
    """The same in a process and a folder of its own; prints what it says in one piece."""
    done = subprocess.run([sys.executable, __file__, name], env=os.environ | {"VOILE_REGRESSION_FOLDER": str(OUT / "jobs" / name)},
                          text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    said = done.stdout.splitlines()
    print("\n".join(said[:-1] if done.returncode in (0, 1) else said), flush=True)  # the last line counts this one test
    return done.returncode == 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tests", nargs="*", help="names of tests; all by default")
    parser.add_argument("--list", action="store_true", help="name the tests and stop")
    parser.add_argument("--jobs", type=int, default=1, help="tests that run side by side; 1 by default")
    parser.add_argument("--turn", type=int, metavar="DAY", help="of the slow tests run every sixth, by this number; all run on six days")
    arguments = parser.parse_args()
    if arguments.list:
        for name, function in TESTS.items():
            print(f"{name:20} {function.__doc__}")
        return 0
    if gone := [name for name in SLOW if name not in TESTS]:
        parser.error(f"SLOW names tests that are not there: {', '.join(gone)}")
    unknown = [name for name in arguments.tests if name not in TESTS]
    if unknown:
        parser.error(f"there is no test {', '.join(unknown)}; there are {', '.join(TESTS)}")
    OUT.mkdir(parents=True, exist_ok=True)
    names = arguments.tests or list(TESTS)
    if arguments.turn is not None:
        names = in_turn(names, arguments.turn)
        print(f"{len(TESTS) - len(names)} slow tests have their turn on other days")
    if arguments.jobs > 1:
        with ThreadPoolExecutor(arguments.jobs) as pool:
            passed = list(pool.map(passes_alone, names))
    else:
        passed = [passes(name) for name in names]
    failed = [name for name, good in zip(names, passed) if not good]
    total = len(names)
    print(f"{total - len(failed)} regression tests passed, {len(failed)} failed" + (": " + ", ".join(failed) if failed else ""))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
