// Scripts of Gmsh (.geo) are programs: some commands run others or write files, merely by being read.
#pragma once

#include <string>

namespace voile::formats {

/// Throws UserError if the whole name of a script cannot stand in quotes in another script. Not collective.
void check_script_name(const std::string& file);

/// A courtesy that names the line: what protects the user is that voile-gmsh has no rights (base/confinement.hpp).
/// Looks through a script, and those that it includes or merges by name, and their neighbours with options (.opt), for commands that run programs (SystemCall,
/// NonBlockingSystemCall, System, OnelabRun, the field ExternalProcess), that write files (Save, Print, CreateDir,
/// Printf and its kin into a file), for plugins other than Crack, and for files to include whose names are made up as
/// the script runs. The text is searched as it stands, comments and strings included: what hides a command from a
/// reader of the language may not hide it from Gmsh. Throws UserError that names file, line and command. Not
/// collective.
void refuse_dangerous_commands(const std::string& file);

}  // namespace voile::formats
