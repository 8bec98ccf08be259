// Scripts of Gmsh (.geo) with their parameters, in the program voile-gmsh.
#pragma once

#include <map>
#include <string>

namespace voile::io {

/// Throws UserError if Gmsh has logged errors so far. `doing`: a word for the message.
void check_log(const std::string& file, const char* doing);

/// A script with its parameters preset: they stand in a file in memory that includes it, since DefineConstant keeps a
/// variable that exists already. (The option -setnumber is no alternative: Gmsh never forgets its values.)
class Script {
 public:
  /// Before a Session, which gives up writing. Throws UserError that names a parameter that is not there.
  Script(const std::string& file, const std::map<std::string, double>& parameters);
  ~Script();
  Script(const Script&) = delete;
  Script& operator=(const Script&) = delete;
  /// Lets Gmsh read it, in a Session. Throws UserError with what Gmsh complains of.
  void open() const;

 private:
  std::string file_;
  std::map<std::string, double> numbers_;  ///< by their ONELAB names
  int wrapper_ = -1;                       ///< descriptor of the file in memory; -1 if none is needed
};

/// Name of a physical group, or its kind and number.
[[nodiscard]] std::string group_name(int dimension, int tag);

}  // namespace voile::io
