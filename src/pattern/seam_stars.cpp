// Seams of many pieces at once: `*` in the names of their pieces.
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "base/text.hpp"
#include "base/wildcard.hpp"
#include "seams.hpp"
#include "voile/errors.hpp"

namespace voile::pattern {

namespace {

using Words = std::vector<std::string>;

bool any_star(const Words& words) {
  return std::any_of(words.begin(), words.end(), has_star);
}

/// What the `*` of "PIECE/EDGE" or "PIECE@POINT" stands for, ascending.
Words texts_of(const std::vector<Panel>& panels, const SeamRequest& r, const std::string& word) {
  const std::size_t end = word.find_last_of("/@");
  const std::string piece = word.substr(0, end);
  if (!has_star(piece) || (end != std::string::npos && has_star(word.substr(end))))
    throw UserError(fmt::format(
        "{}: '{}': a * stands for a text in the name of a piece; name edges and points one by one", r.where, word));
  Words texts, names;
  for (const Panel& p : panels) {
    names.push_back(p.piece.name);
    if (const std::optional<std::string> text = star_of(piece, p.piece.name)) texts.push_back(*text);
  }
  if (texts.empty())
    throw UserError(fmt::format("{}: '{}': no piece matches; there are {}", r.where, word, join(names, ", ")));
  std::sort(texts.begin(), texts.end());
  return texts;
}

Words replaced(Words words, const std::string& text) {
  for (std::string& word : words) word = with_star(word, text);
  return words;
}

}  // namespace

std::vector<SeamRequest> with_stars_replaced(const std::vector<Panel>& panels, const SeamRequest& r) {
  if (!any_star(r.edges) && !any_star(r.to) && !any_star(r.meet)) return {r};
  for (const auto& [key, side, other] : {std::tuple{"edges", &r.edges, "to"}, {"to", &r.to, "edges"}})
    if (!any_star(*side))
      throw UserError(
          fmt::format("{}: {}: there is no * in it, and one in {} or meet; each seam needs its own edges on "
                      "both sides",
                      r.where, key, other));
  std::string first;
  Words texts;
  for (const Words* words : {&r.edges, &r.to, &r.meet})
    for (const std::string& word : *words) {
      if (!has_star(word)) continue;
      const Words own = texts_of(panels, r, word);
      if (first.empty()) first = word, texts = own;
      if (own != texts)
        throw UserError(
            fmt::format("{}: the * of '{}' stands for {}, that of '{}' for {}; it must be the same; name the "
                        "pieces alike, or write a [[seam]] for each",
                        r.where, first, join(texts, ", "), word, join(own, ", ")));
    }
  if (!r.name.empty() && !has_star(r.name) && texts.size() > 1)
    throw UserError(
        fmt::format("{}: name: {} seams would have it; write a * in it, or remove the key", r.where, texts.size()));
  std::vector<SeamRequest> all;
  for (const std::string& text : texts) {
    SeamRequest one = r;
    one.name = with_star(r.name, text);
    one.where = fmt::format("{} (* = '{}')", r.where, text);
    one.edges = replaced(r.edges, text);
    one.to = replaced(r.to, text);
    one.meet = replaced(r.meet, text);
    all.push_back(std::move(one));
  }
  return all;
}

}  // namespace voile::pattern
