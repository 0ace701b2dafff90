#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "stress/stress.hpp"

// stress                runs all cases
// stress 19 "image 3"   runs these, and prints what each solver's error is
// stress --list         names them
// stress --table        prints the table of tests/README.md
// stress --check FILE   fails unless FILE holds that table

namespace {

using namespace gelight::stress;

std::vector<Case> catalogue() {
  std::vector<Case> all;
  for (const auto& cases : {shape_cases(), topology_cases(), vector_cases(), image_cases()}) {
    all.insert(all.end(), cases.begin(), cases.end());
  }
  return all;
}

int check_table(const std::string& path, const std::string& wanted) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  if (text.str().find(wanted) != std::string::npos) return 0;
  std::cerr << path << " does not hold the table that `stress --table` prints\n";
  return 1;
}

int run_cases(const std::vector<Case>& cases, bool verbose) {
  int failed = 0;
  for (const Case& one : cases) {
    const auto faults = run(one, verbose);
    for (const auto& fault : faults) std::cerr << "case " << fault << '\n';
    failed += !faults.empty();
  }
  std::cout << cases.size() << " cases, " << failed << " failed\n";
  return failed > 0 ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<Case> cases = catalogue();
  const std::vector<std::string> names(argv + 1, argv + argc);
  if (names.empty()) return run_cases(cases, false);
  if (names[0] == "--table") {
    std::cout << table(cases);
    return 0;
  }
  if (names[0] == "--check" && names.size() == 2) return check_table(names[1], table(cases));
  if (names[0] == "--list") {
    for (const Case& one : cases) std::cout << one.name << ": " << one.input << '\n';
    return 0;
  }
  std::vector<Case> chosen;
  for (const auto& name : names) {
    const auto found =
        std::find_if(cases.begin(), cases.end(), [&](const Case& one) { return one.name == name; });
    if (found == cases.end()) {
      std::cerr << "there is no case " << name << "; stress --list names them\n";
      return 2;
    }
    chosen.push_back(*found);
  }
  return run_cases(chosen, true);
}
