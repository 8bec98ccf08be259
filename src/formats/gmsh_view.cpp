#include "gmsh_view.hpp"

#include "base/bytes.hpp"
#include "base/child_process.hpp"
#include "base/plain_file.hpp"
#include "geo_safety.hpp"
#include "message.hpp"

namespace voile::formats {

std::vector<double> view_values(const std::string& file, const std::vector<Vec3>& points) {
  std::error_code ignored;
  require_plain_file(file);
  if (!std::filesystem::is_regular_file(file, ignored)) throw UserError(fmt::format("{}: there is no such file", file));
  refuse_dangerous_commands(file);
  ByteWriter out;
  out.put(file);
  out.put(points);
  const Message message(out.take());
  ByteReader in(run_beside(file, "voile-gmsh", {message.path(), "view"}));
  std::vector<double> values;
  in.get(values);
  return values;
}

}  // namespace voile::formats
