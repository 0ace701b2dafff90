#pragma once

#include <string>
#include <utility>
#include <vector>

#include "gelight/views/mesh_view.hpp"

namespace gelight::stress {

/// Small meshes on which something once failed, found by random tests and by fuzzing.
inline std::vector<std::pair<std::string, Mesh<double>>> kept_meshes() {
  return {
      {"a source in the middle of an edge of a face without area: part of its view was lost",
       {{{0, 0, 0}, {1, 0, 0}, {0.5, 0, 0}, {0.5, 1, 0}, {0, -1, 0}, {1, -1, 0}, {-0.5, -2, 0}},
        {{2, 1, 3}, {0, 2, 3}, {0, 1, 2}, {0, 5, 1}, {0, 4, 5}, {4, 6, 5}}}},
      {"faces of one place and one other, all round a vertex: windows circled for ever",
       {{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 1}, {0, 0, 0}, {0, 0, 0}},
        {{0, 1, 3}, {0, 3, 2}, {1, 4, 3}, {2, 3, 5}, {3, 4, 5}}}},
      {"an edge of no length: its ends were each other's way to the source",
       {{{-0.7, 0.6, -0.2}, {0.9, 0.2, 1.0}, {-0.3, 0.5, 1.1}, {0.8, 1.1, -0.1}, {0.9, 0.2, 1.0}},
        {{0, 3, 2}, {3, 1, 2}, {3, 4, 1}, {1, 4, 2}}}},
      {"a face that is one place, another with an edge of no length: no pivot was left to heat",
       {{{1, 1, 0},
         {-1, -1, 0},
         {0, 0, -1},
         {1, 0, 0},
         {-1, 0, -1},
         {-1, 0, 1},
         {-1, 0, -1},
         {0, 0, -1},
         {0, 0, -1}},
        {{5, 4, 1}, {6, 7, 8}, {2, 0, 3}}}},
  };
}

}  // namespace gelight::stress
