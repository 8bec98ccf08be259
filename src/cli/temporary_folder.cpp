#include "temporary_folder.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>

#include "voile/errors.hpp"

namespace voile::cli {

void check_temporary_folder() {
  std::string variable, folder = "/tmp";
  for (const char* name : {"TMPDIR", "TEMP", "TMP"})
    if (const char* given = std::getenv(name); given != nullptr && *given != '\0') {
      variable = fmt::format("{} = ", name);
      folder = given;
      break;
    }
  constexpr std::size_t wanted = 4096;
  std::string name = folder + "/voile_XXXXXX";
  const int descriptor = mkstemp(name.data());
  const std::string bytes(wanted, '\0');
  errno = descriptor < 0 ? errno : 0;
  const bool done = descriptor >= 0 && ::write(descriptor, bytes.data(), wanted) == static_cast<ssize_t>(wanted);
  const std::string why = errno != 0 ? std::strerror(errno) : "no room";
  if (descriptor >= 0) {
    close(descriptor);
    (void)unlink(name.c_str());
  }
  if (!done)
    throw UserError(fmt::format(
        "{}{}: temporary files cannot be written there ({}), and MPI needs some; make room, or set TMPDIR to "
        "an existing folder that is writable and has room",
        variable, folder, why));
}

}  // namespace voile::cli
