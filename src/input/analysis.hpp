// What a case, or a stage of one, asks for.
#pragma once

#include <array>
#include <string>
#include <utility>

namespace voile::input {

enum class Analysis { statics, linear, modal, buckling, dynamic, drape, harmonic };

/// The words of a case for them, in the order of the reference.
inline constexpr std::array<std::pair<const char*, Analysis>, 7> analysis_words{{{"static", Analysis::statics},
                                                                                 {"linear", Analysis::linear},
                                                                                 {"modal", Analysis::modal},
                                                                                 {"buckling", Analysis::buckling},
                                                                                 {"dynamic", Analysis::dynamic},
                                                                                 {"drape", Analysis::drape},
                                                                                 {"harmonic", Analysis::harmonic}}};

[[nodiscard]] constexpr const char* word_of(Analysis analysis) {
  return analysis_words[static_cast<std::size_t>(analysis)].first;
}

/// That of a word; `otherwise` if it is none.
[[nodiscard]] inline Analysis analysis_of(const std::string& word, Analysis otherwise) {
  for (const auto& [name, analysis] : analysis_words)
    if (word == name) return analysis;
  return otherwise;
}

}  // namespace voile::input
