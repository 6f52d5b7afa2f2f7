// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/knowledge/stop_words.h"

#include <algorithm>
#include <iterator>

namespace livegs {
namespace {

// Each table is sorted.
constexpr std::string_view kStopWords[] = {
    "again",      "antique",    "asset",     "back",    "bare",    "beautiful", "big",      "black",
    "blue",       "bottom",     "bright",    "broken",  "brown",   "capture",   "clean",    "cleaned",
    "closed",     "compressed", "copy",      "crop",    "cropped", "crouching", "cute",     "damaged",
    "dark",       "detailed",   "empty",     "export",  "extra",   "final",     "flying",   "front",
    "full",       "gaussian",   "gaussians", "giant",   "gold",    "golden",    "gray",     "green",
    "grey",       "half",       "hanging",   "high",    "huge",    "isolated",  "kneeling", "large",
    "left",       "light",      "little",    "lod",     "low",     "lowres",    "lying",    "main",
    "matte",      "medium",     "mesh",      "mini",    "model",   "modern",    "new",      "nice",
    "object",     "old",        "one",       "only",    "open",    "orange",    "original", "pink",
    "point",      "points",     "poly",      "purple",  "raw",     "real",      "red",      "res",
    "resolution", "right",      "round",     "running", "rusty",   "scan",      "scanned",  "seated",
    "second",     "set",        "shiny",     "side",    "silver",  "simple",    "single",   "sitting",
    "size",       "sleeping",   "small",     "splat",   "splats",  "square",    "standing", "striped",
    "tall",       "test",       "the",       "tiny",    "top",     "toy",       "two",      "used",
    "version",    "vintage",    "violet",    "walking", "white",   "wide",      "yellow"};
constexpr std::string_view kHeadNouns[] = {
    "bag",     "bed",    "board",    "box",    "bracket", "cage",      "carrier", "cart",    "case",
    "catcher", "chain",  "cleaner",  "clip",   "coat",    "cover",     "cutter",  "dish",    "dispenser",
    "display", "door",   "dryer",    "feeder", "field",   "frame",     "grinder", "guard",   "handle",
    "hanger",  "holder", "hook",     "house",  "juice",   "keeper",    "leg",     "machine", "maker",
    "mount",   "net",    "opener",   "oven",   "pad",     "peel",      "press",   "pump",    "rack",
    "rail",    "reel",   "remover",  "rod",    "seat",    "sharpener", "shelf",   "shop",    "skin",
    "sleeve",  "slicer", "squeezer", "stand",  "station", "stem",      "strap",   "switch",  "tank",
    "tower",   "track",  "trailer",  "trap",   "trolley", "warmer"};
constexpr std::string_view kPrepositions[] = {"above", "at",      "behind", "beside",  "by",   "for",
                                              "from",  "holding", "in",     "near",    "next", "on",
                                              "over",  "to",      "under",  "wearing", "with", "without"};

template <class List>
bool holds(const List& list, std::string_view word) {
  return std::binary_search(std::begin(list), std::end(list), word);
}
template <class List>
constexpr bool sorted(const List& list) {
  return std::is_sorted(std::begin(list), std::end(list));
}
static_assert(sorted(kStopWords) && sorted(kHeadNouns) && sorted(kPrepositions));

}  // namespace

bool is_stop_word(std::string_view word) { return word.size() <= 2 || holds(kStopWords, word); }

bool is_head_noun(std::string_view word) {
  return holds(kHeadNouns, word) ||
         (word.ends_with('s') && holds(kHeadNouns, word.substr(0, word.size() - 1)));
}

bool is_preposition(std::string_view word) { return holds(kPrepositions, word); }

}  // namespace livegs
