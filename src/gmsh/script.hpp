// Scripts of Gmsh (.geo) with their parameters, in the program voile-gmsh.
#pragma once

#include <map>
#include <memory>
#include <string>

namespace voile::formats {

/// Throws UserError if Gmsh has logged errors so far. `doing`: a word for the message.
void check_log(const std::string& file, const char* doing);

/// A file in memory, which other code of this process opens by its name.
class MemoryFile {
 public:
  /// Throws InternalError if there is no memory for it.
  explicit MemoryFile(const std::string& bytes);
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  [[nodiscard]] std::string name() const;

 private:
  int descriptor_;
};

/// The same bytes without a byte-order mark at their beginning, by which Gmsh would take a mesh for a script; nothing if the
/// file has none.
[[nodiscard]] std::unique_ptr<MemoryFile> without_byte_order_mark(const std::string& file);

/// A script with its parameters preset: they stand in a file in memory that includes it, since DefineConstant keeps a
/// variable that exists already. (The option -setnumber is no alternative: Gmsh never forgets its values.)
class Script {
 public:
  /// Before a Session, which gives up writing. Throws UserError that names a parameter that is not there.
  Script(const std::string& file, const std::map<std::string, double>& parameters);
  /// Lets Gmsh read it, in a Session. Throws UserError with what Gmsh complains of.
  void open() const;

 private:
  std::string file_;
  std::map<std::string, double> numbers_;  ///< by their ONELAB names
  std::unique_ptr<MemoryFile> wrapper_;    ///< null if none is needed
};

/// Name of a physical group, or its kind and number.
[[nodiscard]] std::string group_name(int dimension, int tag);

}  // namespace voile::formats
