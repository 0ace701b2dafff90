#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "stress/stress.hpp"

// stress                runs all cases
// stress 19 "image 3"   runs these, and prints what each solver's error is
// stress --list         names them
// stress --table        prints the table of tests/README.md
// stress --bounds      prints the bounds of claims.cpp as they would be measured now
// stress --check FILE   fails unless FILE holds that table, with about the same measured errors

namespace {

using namespace gelight::stress;

std::vector<Case> catalogue() {
  std::vector<Case> all;
  for (const auto& cases : {shape_cases(), topology_cases(), vector_cases(), image_cases()}) {
    all.insert(all.end(), cases.begin(), cases.end());
  }
  return all;
}

std::vector<std::string> lines_of(std::istream& in) {
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> cells_of(const std::string& row) {
  std::vector<std::string> cells;
  std::istringstream in(row);
  for (std::string cell; std::getline(in, cell, '|');) cells.push_back(cell);
  return cells;
}

// Compilers differ in what they measure: by a share, where it depends on which of two nearly equal
// ways is taken, and by rounding.
bool is_about(double a, double b) {
  return std::fabs(a - b) <= std::max(0.2 * std::max(a, b), 1e-12);
}

// " 7.8 %, 28 % (12 %, 42 %)": what is measured is about the same, the bounds in brackets are the
// same, and so is every other cell.
bool agree(const std::string& a, const std::string& b) {
  if (a == b) return true;
  const auto bracket = [](const std::string& cell) {
    return std::min(cell.find('('), cell.size());
  };
  if (bracket(a) == a.size() || a.substr(bracket(a)) != b.substr(bracket(b))) return false;
  if (a.substr(bracket(a)).starts_with("(finite)")) return true;  // errors that nobody answers for
  const char *p = a.c_str(), *q = b.c_str();
  while (*p != '(' && *q != '(') {
    char *after_p = nullptr, *after_q = nullptr;
    const double x = std::strtod(p, &after_p), y = std::strtod(q, &after_q);
    if ((after_p == p) != (after_q == q)) return false;
    if (after_p == p) {
      if (*p++ != *q++) return false;
      continue;
    }
    const bool is_percent = std::string_view(after_p).starts_with(" %");
    if (!is_about(is_percent ? x / 100 : x, is_percent ? y / 100 : y)) return false;
    p = after_p, q = after_q;
  }
  return *p == *q;
}

bool is_same_row(const std::string& a, const std::string& b) {
  const auto of_a = cells_of(a), of_b = cells_of(b);
  return of_a.size() == of_b.size() && std::equal(of_a.begin(), of_a.end(), of_b.begin(), agree);
}

int check_table(const std::string& path, const std::string& wanted) {
  std::ifstream file(path);
  std::istringstream in(wanted);
  const auto held = lines_of(file), rows = lines_of(in);
  const auto head = std::find(held.begin(), held.end(), rows.front());
  int differences = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const bool is_there = std::cmp_less(i, held.end() - head);
    const std::string has = is_there ? head[static_cast<std::ptrdiff_t>(i)] : "";
    if (is_same_row(rows[i], has)) continue;
    std::cerr << path << " has\n  " << has << "\nfor\n  " << rows[i] << '\n';
    ++differences;
  }
  return differences > 0 ? 1 : 0;
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
  if (names[0] == "--bounds") {
    for (const Case& one : cases) std::cout << (one.problems ? measured_claims(one) : "");
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
