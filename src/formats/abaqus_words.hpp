// Words of Abaqus input files; private to src/io.
#pragma once

#include <algorithm>
#include <cctype>
#include <istream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace voile::formats {

using AbaqusWords = std::vector<std::string>;

inline std::string abaqus_upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

inline std::string abaqus_trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t\r\""), end = text.find_last_not_of(" \t\r\"");
  return begin == std::string::npos ? "" : text.substr(begin, end - begin + 1);
}

/// The next line that is no comment, a keyword line with those that continue it after a comma; counts lines. False at the end.
inline bool abaqus_line(std::istream& in, std::string& text, std::size_t& line) {
  while (std::getline(in, text)) {
    ++line;
    if (text.starts_with("**")) continue;
    for (std::string more; text.starts_with("*") && in.peek() != '*';) {
      const std::string whole = abaqus_trimmed(text);
      if (!whole.ends_with(',') || !std::getline(in, more)) break;
      ++line;
      text = whole + more;
    }
    return true;
  }
  return false;
}

/// Words between commas, without empty ones at the end.
inline AbaqusWords abaqus_fields(const std::string& line) {
  AbaqusWords words;
  std::istringstream in(line);
  for (std::string word; std::getline(in, word, ',');) words.push_back(abaqus_trimmed(word));
  while (!words.empty() && words.back().empty()) words.pop_back();
  return words;
}

/// NAME = VALUE of a keyword line, names in capitals; "" for flags.
inline std::map<std::string, std::string> abaqus_parameters(const AbaqusWords& words) {
  std::map<std::string, std::string> parameters;
  for (std::size_t k = 1; k < words.size(); ++k) {
    const std::size_t equal = std::min(words[k].find('='), words[k].size());
    parameters[abaqus_upper(abaqus_trimmed(words[k].substr(0, equal)))] =
        equal < words[k].size() ? abaqus_trimmed(words[k].substr(equal + 1)) : "";
  }
  return parameters;
}

/// What a part's set is called where the assembly has one of the same name.
inline std::string abaqus_part_set(const std::string& name) {
  return name + "_part";
}

/// A name or number without the instance before it, as in "Plate-1.Edge".
inline std::string abaqus_without_instance(const std::string& name) {
  const std::size_t dot = name.rfind('.');
  return dot == std::string::npos ? name : name.substr(dot + 1);
}

}  // namespace voile::formats
