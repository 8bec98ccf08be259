// Key frames that move an obstacle.
//
// Symbols   t_0, t_n   times of the first and the last frame in the file [s]      s   frames_start [s]
//
// At the time t of the run the body is where the file has it at t_0 + t - s. A loop begins anew after the period
// T = t_n - t_0 if its last frame is the first again. Otherwise a frame is missing from the last to the first: the body
// goes that way in d = (t_n - t_0) / n, and T = t_n - t_0 + d. With smoothing over the time c it is at the mean of these
// places from t - c to t: its velocity is continuous, it begins where the first frame has it, and it follows c/2 later.
#pragma once

#include <string>
#include <vector>

#include "base/mpi.hpp"
#include "input/case.hpp"

namespace voile::setup {

/// Gives an obstacle with its mesh the frames of its section, and says in `notes` (on every rank) what a user should
/// know of them: that they are not of this mesh, end before the run does, or jump where they repeat. `end`: of the run
/// [s]. Collective; so is each call of the obstacle's frames, at the same time on every rank.
/// Throws UserError for files that cannot be read and frames that do not fit the mesh.
void read_frames(MPI_Comm comm, const input::ObstacleSection& section, double end, contact::Obstacle& o,
                 std::vector<std::string>& notes);

}  // namespace voile::setup
