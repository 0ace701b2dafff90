#pragma once

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "parted_file.hpp"
#include "progress_line.hpp"
#include "ranks.hpp"

/// Makes the parts of a file that a run before this one has not: each by `make(part, thread)` on
/// some thread of some rank. Tells on rank 0 how far it is, in `things`, which are rows. Returns
/// the parts that were made; on rank 0, all are done then.
inline std::vector<int> make_missing_parts(const Ranks& ranks, PartedFile& file, int threads,
                                           const std::string& things, const Team::Work& make) {
  std::vector<int> missing;
  if (ranks.is_first()) {
    missing =
        file.begin([](const std::string& words) { std::fprintf(stderr, "%s\n", words.c_str()); });
  }
  ranks.broadcast(missing);
  double rows = 0;
  for (const int part : missing) rows += static_cast<double>(file.rows_of(part));
  const auto all = static_cast<double>(file.rows()), before = all - rows;
  if (ranks.is_first() && before > 0) {
    std::fprintf(stderr, "%zu of %d parts are there already\n",
                 static_cast<std::size_t>(file.part_count()) - missing.size(), file.part_count());
  }
  ProgressLine line(things, all);
  const auto a_part = static_cast<double>(file.rows_of(0));
  deal(ranks, missing, threads, make,
       [&](int done) { line.tell(std::min(done * a_part, rows), before); });
  return missing;
}
